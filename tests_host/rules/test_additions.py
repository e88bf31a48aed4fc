"""CONTRIBUTING's five additions, done as they are written: each in folders of its own, in a copy of the house, with its test there."""

import re
import shutil
import subprocess
import textwrap
from pathlib import Path

import pytest

from host_tools import interpreter
from host_tools.resources import ROOT

TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
FILE = re.compile(r"`((?:firmware|tests_host)/[\w/.]+)`[^`\n]*:\n\n((?:    .*\n|\n)+)")
OWN = re.compile(r"(firmware/passo/(options|protocols)|tests_host/options)/(?P<name>\w+)/\w+\.(py|txt)")
# Runs a test of the copy with the modules of the copy.
_RUN = "import sys, pytest; sys.exit(pytest.main(sys.argv[1:]))\n"


def additions():
    """{heading: {path: text}} of the five."""
    part = TEXT.partition("## Five additions\n")[2].partition("\n## ")[0]
    return {heading: {path: textwrap.dedent(text).strip("\n") + "\n" for path, text in FILE.findall(body)} for heading, body in re.findall(r"### (.+)\n((?:(?!### ).*\n)*)", part)}


ADDITIONS = additions()


def _needless(folder, names):
    """Return the names that no clone of the house has."""
    return {"__pycache__", *([".git", ".venv", ".hypothesis", ".pytest_cache", "build", "out"] if Path(folder) == ROOT else [])} & set(names)


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    folder = tmp_path_factory.mktemp("house")
    shutil.copytree(ROOT, folder, ignore=_needless, dirs_exist_ok=True)
    for files in ADDITIONS.values():
        for path, text in files.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text, encoding="utf-8")
    return folder


def run(copy, *arguments):
    script = copy / "run.py"
    script.write_text(_RUN, encoding="utf-8")
    command = [*interpreter.python(copy, copy / "firmware"), str(script), "-q", "-p", "no:cacheprovider", *arguments]
    done = subprocess.run(command, env=interpreter.environment(), cwd=copy, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


@pytest.mark.quick
def test_the_map_names_every_folder():
    text = TEXT.partition("## Map of the house\n")[2].partition("\n## ")[0]
    folders = [*ROOT.glob("*/__init__.py"), *(ROOT / "host_tools").glob("*/__init__.py"), *(ROOT / "firmware" / "passo").glob("*/__init__.py")]
    missing = {path.parent.name for path in folders} - set(re.findall(r"(\w+)/", text))
    assert not missing and len(folders) > 20


@pytest.mark.quick
def test_each_touches_its_own_folders_only():
    assert list(ADDITIONS) == ["An option", "A language", "A coil drive", "A sensor that pauses", "A setting with a status field"]
    for heading, files in ADDITIONS.items():
        names = {OWN.fullmatch(path)["name"] for path in files}
        assert len(names) == 1 and len(files) >= 2, heading
        assert not any((ROOT / path).exists() for path in files)


@pytest.mark.quick
@pytest.mark.xdist_group("additions")
def test_their_tests_pass(copy):
    tests = [path for files in ADDITIONS.values() for path in files if Path(path).name.startswith("test_")]
    code, said = run(copy, *tests)
    assert code == 0 and len(tests) == 5, said


@pytest.mark.slow
@pytest.mark.xdist_group("additions")
def test_the_rules_of_the_house_pass_beside_them(copy):
    """Tables of docs/reference are made anew first; nothing else is."""
    made = subprocess.run([*interpreter.python(copy, copy / "firmware"), str(copy / "host_tools/build/reference.py")], env=interpreter.environment(), cwd=copy, capture_output=True, text=True)
    assert made.returncode == 0, made.stderr
    rules = [f"tests_host/rules/test_{name}.py" for name in ("layers", "numbers", "surface", "tables", "docs", "house", "error_table", "writers", "interrupt_attributes", "package")]
    code, said = run(copy, *rules, "tests_host/tools/test_words.py", "tests_host/tools/test_language.py", "tests_host/tools/test_setting_names.py")
    assert code == 0, said[-6000:]
