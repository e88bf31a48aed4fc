"""The actions of `make`: its installs for each target, and tests chosen by hand."""

import os
import re
import subprocess

import pytest
from test_board_command import ROOT

pytestmark = pytest.mark.quick


def recipe(*arguments):
    """The commands of a target, not carried out, as if nothing were installed."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))}
    words = ["make", "-n", "-W", "pyproject.toml", *arguments]
    return subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True, env=kept).stdout


@pytest.mark.parametrize("target, wanted", [
    ("run", {".[draw]"}), ("venv", {".[draw]"}), ("build BOARD=x", {"."}), ("flash BOARD=x", {"."}),
    ("emulate", {".[emulate]"}), ("test", {".[test]"}),
])  # fmt: skip
def test_only_what_is_needed_is_installed_and_said(target, wanted):
    commands = recipe(*target.split())
    assert set(re.findall(r"pip install .*-e '(\.[^']*)'", commands)) == wanted
    assert re.search(r'echo "Installing what .* needs into .venv: some \d+ MB', commands)


@pytest.mark.parametrize("target", ["check", "test", "test-all"])
def test_chosen_tests_are_not_failed_for_their_coverage(target):
    commands = recipe(target, "ARGS=tests_host/rules/test_error_table.py")
    runs = [line for line in commands.splitlines() if " pytest " in line]
    assert runs and all("--cov" not in line for line in runs)
    assert [line for line in runs if "tests_host/rules/test_error_table.py" in line] == runs


def made(folder, minor, here=None):
    """Return (exit code, output) of `make .venv/.installed-tools` in a folder, by a `python3` of 3.`minor`; `here`: that of its .venv."""
    for path, number in ((folder / "bin" / "python3", minor), (folder / ".venv" / "bin" / "python", here)):
        if number is not None:
            path.parent.mkdir(parents=True)
            path.write_text(OLD % (number, number, 0 if number >= 11 else 1, path, path))
            path.chmod(0o755)
    for name in ("Makefile", "pyproject.toml"):
        (folder / name).write_text((ROOT / name).read_text())
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))}
    kept["PATH"] = f"{folder / 'bin'}:{kept['PATH']}"
    done = subprocess.run(["make", ".venv/.installed-tools"], cwd=folder, capture_output=True, text=True, env=kept)
    return done.returncode, done.stdout + done.stderr


# A Python of that minor version, as far as the Makefile asks; `-m venv` and pip make a copy of it, and succeed.
OLD = """#!/bin/sh
case "$*" in
    -V) echo Python 3.%d.9 ;;
    *print*) echo 3 %d ;;
    *version_info*) exit %d ;;
    *venv*) mkdir -p .venv/bin && cp %s .venv/bin/python ;;
    *) test -x %s ;;
esac
"""


def test_an_old_python_is_named_before_anything_is_fetched(tmp_path):
    code, said = made(tmp_path, 10)
    assert code and "wants Python 3.11 or later, and python3 is Python 3.10.9: make PYTHON=python3.11" in said
    assert "Installing" not in said and not (tmp_path / ".venv").exists()


@pytest.mark.parametrize("here, anew", [(None, False), (12, False), (10, True), (13, True)])
def test_a_venv_of_another_python_is_made_anew(tmp_path, here, anew):
    code, said = made(tmp_path, 12, here)
    assert code == 0, said
    assert ("is made anew" in said) == anew and "Installing" in said
