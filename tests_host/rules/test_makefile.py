"""What `make` would do: what it installs for which target, and tests that are chosen by hand."""

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
