"""Every check module also holds under real MicroPython (the unix port): the same functions, another generator."""

import re
import subprocess
import sys
from pathlib import Path

import folders
import pytest
import tiers
import whole_boards

from host_tools import interpreter
from host_tools.build.tree import unix_tree

CHECKS = Path(__file__).resolve().parent
TESTS = CHECKS.parent
ROOT = TESTS.parent
MODULE_PATH = (unix_tree(), *folders.OF_CHECKS, TESTS / "sims", whole_boards.folder(), ROOT)
MICROPYTHON = Path(sys.executable).parent / "micropython"
MODULES = folders.checks()
TIMEOUT_S = 300

needs_micropython = pytest.mark.skipif(not MICROPYTHON.exists(), reason=f"there is no {MICROPYTHON}")


def micro_run(folders, *arguments):
    """Run micro_runner.py under MicroPython with `folders` on its module path."""
    few = {"check": ["--few", "--most=%d" % tiers.FEW], "test": ["--short", "--most=%d" % tiers.SOME, "--part=%d" % tiers.PART]}.get(tiers.current, [])
    slow = ["--slow"] if tiers.current == "all" else []
    return subprocess.run(
        [MICROPYTHON, "-X", "heapsize=64m", CHECKS / "micro_runner.py", *few, *slow, *arguments],
        env=interpreter.environment(*folders),
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
    )


@needs_micropython
@pytest.mark.quick
@pytest.mark.parametrize("module", MODULES)
def test_checks_under_micropython(module):
    result = micro_run(MODULE_PATH, module)
    assert result.returncode == 0, f"{module} under MicroPython:\n{result.stdout}{result.stderr}"


@needs_micropython
def test_a_failing_check_is_reported(tmp_path):
    (tmp_path / "check_wrong.py").write_text(
        'CASES = {"check_small": (("steps", 0, 1000),)}\n\n\n'
        "def check_small(steps):\n    assert steps < 900\n\n\ndef check_fine():\n    pass\n"
    )
    result = micro_run((tmp_path, CHECKS), "check_wrong")
    assert result.returncode == 1
    assert re.search(r"FAILED check_small\(steps=(9\d\d|1000)\), run \d+\n", result.stdout), result.stdout
    assert "AssertionError" in result.stdout
    assert re.search(r"2 checks, \d+ runs, 1 failed\n$", result.stdout)


@needs_micropython
def test_a_module_without_checks_fails(tmp_path):
    (tmp_path / "check_none.py").write_text("")
    assert micro_run((tmp_path, CHECKS), "check_none").returncode == 1
