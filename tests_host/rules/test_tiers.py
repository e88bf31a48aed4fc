"""The tests that a tier runs, tried on a test file of its own."""

import os
import re
import subprocess
from pathlib import Path

import pytest
import tiers
from test_board_command import ROOT

from host_tools import interpreter

pytestmark = pytest.mark.quick
PYTEST = [*interpreter.python(ROOT / "tests_host"), Path(pytest.__file__).with_name("__main__.py")]

CHECKS = """
tried = []
CASES = {"check_all": (("value", 0, 100000),), "check_slow": (("value", 0, 100000),)}
RUNS = {"check_all": 60}
SLOW = ("check_slow",)
NOT_QUICK = ("check_long",)


def check_all(value):
    tried.append(value)


def check_long():
    pass


def check_slow(value):
    pass
"""
FILE = """
import sys

import pytest


@pytest.mark.slow
def test_slow():
    pass


@pytest.mark.quick
def test_quick():
    pass


@pytest.mark.quick
@pytest.mark.slow
def test_one_of_a_quick_file_that_is_slow():
    pass


def test_plain():
    assert "plain" not in sys.argv


@pytest.mark.quick
def test_the_examples():
    import check_sample

    print("examples:", len(check_sample.tried))


@pytest.mark.unmeasured
def test_unmeasured():
    assert sys.gettrace() is None
"""
PLAIN = """
import tiers

assert tiers.current != "check", "a file without quick tests is not imported"


def test_of_a_plain_file():
    pass
"""
WANTED = {
    "check": {"test_quick", "check_all", "test_the_examples"},
    "test": {"test_quick", "check_all", "check_long", "test_the_examples", "test_plain", "test_unmeasured",
             "test_of_a_plain_file"},
    "all": {"test_quick", "check_all", "check_slow", "test_the_examples", "test_plain", "test_unmeasured", "test_slow", "check_long",
            "test_of_a_plain_file", "test_one_of_a_quick_file_that_is_slow"},
}  # fmt: skip


@pytest.mark.parametrize("tier", tiers.TIERS)
def test_what_runs(tmp_path, tier):
    (tmp_path / "check_sample.py").write_text(CHECKS)
    (tmp_path / "test_file.py").write_text(FILE)
    (tmp_path / "test_plain.py").write_text(PLAIN)
    environ = {**os.environ, "CI": "1"}
    options = ["-p", "conftest", "-p", "no:cacheprovider", "-n", "0", "-s", "-v", "-c", ROOT / "pyproject.toml", "--rootdir", "."]
    command = [*PYTEST, *options, "--tier", tier]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=environ)
    assert done.returncode == 0, done.stdout + done.stderr
    ran = set(re.findall(r"::(\w+) (?:PASSED|examples)", done.stdout))
    assert ran == WANTED[tier]
    assert int(re.search(r"examples: (\d+)", done.stdout)[1]) == {"check": tiers.FEW, "test": 30, "all": 60}[tier]


MEASURED = """
import subprocess
import threading
import time

import pytest
import sample
import tiers

from host_tools import interpreter


def pass_time():
    end = time.process_time() + 2 * tiers.MEASURED_S
    while time.process_time() < end:
        pass


@pytest.fixture
def made():
    sample.of_fixture()
    pass_time()
    sample.late_of_fixture()


def test_long(made):
    assert sample.first()
    pass_time()
    sample.late()


@pytest.mark.unmeasured
def test_unmeasured():
    sample.unseen()


def in_thread():
    sample.of_thread()
    pass_time()
    sample.late_of_thread()


def test_a_thread():
    thread = threading.Thread(target=in_thread)
    thread.start()
    while thread.is_alive():  # as tests wait: a signal's handler runs here
        thread.join(0.01)
    thread = threading.Thread(target=sample.late_thread)
    thread.start()
    thread.join()


def run(name):
    subprocess.run([*interpreter.python(), "-c", f"import sys; sys.path.insert(0, '.'); import sample; sample.{name}()"], check=True)


def test_a_program():
    run("of_program")


@pytest.mark.programs_measured
def test_programs_that_are_measured():
    run("of_measured_program")


def test_the_next():
    assert sample.after()
    thread = threading.Thread(target=sample.after_in_thread)
    thread.start()
    thread.join()
"""
SEEN = ("first", "of_fixture", "of_thread", "of_measured_program", "after", "after_in_thread")
UNSEEN = ("late", "late_of_fixture", "unseen", "late_of_thread", "late_thread", "of_program")
MEASURING = "[run]\npatch = subprocess\nparallel = true\n"


def test_coverage_sees_the_beginning_of_each_test(tmp_path):
    names = (*SEEN, *UNSEEN)
    (tmp_path / "sample.py").write_text("".join(f"def {name}():\n    return 1\n\n\n" for name in names))
    (tmp_path / "test_file.py").write_text(MEASURED)
    (tmp_path / "measuring").write_text(MEASURING)
    environ = {**os.environ, "CI": "1"}
    options = ["-p", "conftest", "-p", "no:cacheprovider", "-n", "0", "-c", os.devnull, "--rootdir", "."]
    measure = ["--cov=sample", "--cov-config=measuring", "--cov-report=term-missing"]
    command = [*PYTEST, *options, *measure, "test_file.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=environ)
    assert done.returncode == 0, done.stdout + done.stderr
    missing = ", ".join(str(4 * number + 2) for number in range(len(SEEN), len(names)))
    assert re.search(rf"^sample.py +24 +6 +75% +{missing}$", done.stdout, re.MULTILINE), done.stdout


GROUPED = """
import pytest


@pytest.fixture(scope="module")
def shared():
    pass


@pytest.mark.parametrize("number", range(6))
def test_that_shares(shared, number):
    pass


@pytest.mark.xdist_group("named")
@pytest.mark.parametrize("number", range(6))
def test_of_a_group(number):
    pass
"""


def test_those_of_a_group_run_in_one_worker(tmp_path):
    (tmp_path / "test_file.py").write_text(GROUPED)
    options = ["-p", "conftest", "-p", "no:cacheprovider", "-n", "2", "--dist", "loadgroup", "-v", "-c", os.devnull, "--rootdir", "."]
    done = subprocess.run([*PYTEST, *options], cwd=tmp_path, capture_output=True, text=True)
    ran = set(re.findall(r"\[(gw\d)\].* PASSED .*::(test_\w+)", done.stdout))
    assert len(ran) == 2 and len({name for _, name in ran}) == 2, done.stdout + done.stderr
