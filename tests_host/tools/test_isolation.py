"""Files of others are not executed: each verb, in a folder of downloads in which modules lie by the names of Python's, of Passo's and of MicroPython's."""

import os
import shutil
import signal
import subprocess
from pathlib import Path

import pytest

from host_tools import interpreter
from host_tools.cli.main import VERBS
from host_tools.workers import in_processes

LIMIT_S = 60
LATER = ("panel", "board", "agent", "shop", "emulate")  # they run until they get a signal
NAMES = (
    "struct", "job_runner", "typing", "sitecustomize", "usercustomize", "typer", "array", "json", "io", "pickle", "numpy", "micropython", "machine", "board",
    "multiprocessing", "matplotlib", "ezdxf", "svgelements", "mpremote", "ziglang", "serial", "rich", "host_tools", "passo",
)  # fmt: skip
PACKAGES = ("passo", "host_tools", "multiprocessing", "numpy", "mpremote", "ziglang")
MODULE = "f = open({!r}, 'a')\nf.write(__name__ + chr(10))\nf.close()\nraise SystemExit('a file of others')\n"
PART = "G21 G90\nG1 X5 Y5 F600\nM2\n"
SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm" viewBox="0 0 20 20"><path d="M2 2H18" stroke="black"/></svg>'
NO_PORT = ("--port", "nosuch")
WORDS = {
    "examples": [()],
    "panel": [("--demo", "--http", "0")], "site": [("--help",)], "agent": [("--virtual", "m=plotter_2014", "--broker", "127.0.0.1:1")], "shop": [("--broker", "127.0.0.1:1", "--http", "0")],
    "wiring": [("router_3axis",)], "board": [("--time", "fast")], "emulate": [("--help",)], "draw": [("part.svg", "--dry-run")],
    "nest": [("part.svg", "part.svg")], "engrave": [("--help",)], "experiments": [("arcs", "--out", "experiments")], "send": [(*NO_PORT, "END")], "stream": [("part.nc", *NO_PORT)], "resume": [("part.nc", *NO_PORT)],
    "keys": [NO_PORT], "check": [("part.nc",), ("programs", "--workers", "2")], "calibrate": [("--help",)], "settings": [("show", *NO_PORT)],
    "link": [("2", "--protocol", "grbl", *NO_PORT)], "status": [NO_PORT], "log": [NO_PORT], "blackbox": [NO_PORT], "interlock": [("mill_2004",)], "watch": [NO_PORT],
    "plot": [("--help",)], "film": [("--help",)], "ports": [()], "build": [("--board", "two_motor_kit", "--out", "made")],
    "flash": [("--board", "two_motor_kit", *NO_PORT)],
    "prove": [NO_PORT], "compile": [("part.nc", "--dialect", "ngc", "-o", "plain.nc")], "jobs": [("list", *NO_PORT)], "machine": [("list", *NO_PORT)],
    "pulses": [("check", "part.nc")], "torch": [("info", *NO_PORT)], "wifi": [("show", *NO_PORT)],
}  # fmt: skip
RUNS = [pytest.param(verb, words, id=" ".join([verb, *words]), marks=[pytest.mark.slow] * (verb == "build")) for verb in WORDS for words in WORDS[verb]]


@pytest.fixture
def downloads(tmp_path):
    """A folder of others' files; `ran` beside it names those that were executed."""
    folder = tmp_path / "downloads"
    (folder / "programs").mkdir(parents=True)
    code = MODULE.format(str(tmp_path / "ran"))
    for name in NAMES:
        path = folder / name / "__init__.py" if name in PACKAGES else folder / f"{name}.py"
        path.parent.mkdir(exist_ok=True)
        path.write_text(code)
    for name in ("part.nc", "programs/a.nc", "programs/b.nc"):
        (folder / name).write_text(PART)
    (folder / "part.svg").write_text(SVG)
    return folder


def executed(folder):
    path = folder.parent / "ran"
    return path.read_text().split() if path.exists() else []


def run(folder, command, later=False, **environment):
    """Return (exit status, output) of a command in `folder`; a program of `later` is ended after its first line."""
    process = subprocess.Popen(command, cwd=folder, env={**os.environ, **environment}, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        said = process.stdout.readline() if later else ""
        if later:
            process.send_signal(signal.SIGTERM)
        said += process.communicate(timeout=LIMIT_S)[0]
    finally:
        process.kill()
    return process.returncode, said


def test_each_verb_is_tried():
    assert sorted(WORDS) == sorted(VERBS)


@pytest.mark.unmeasured
@pytest.mark.parametrize("verb, words", RUNS)
def test_a_verb_executes_no_file_of_others(downloads, verb, words):
    passo = Path(interpreter.python()[0]).with_name("passo")
    if not passo.exists():
        pytest.skip("passo is not installed")
    status, said = run(downloads, [passo, verb, *words], verb in LATER and words != ("--help",))
    assert executed(downloads) == []
    assert "Traceback" not in said and "a file of others" not in said, said
    if verb in ("check", "wiring", "interlock", "compile", "nest", "panel", "board"):
        assert status in (0, -signal.SIGTERM), said


def test_a_program_that_passo_starts_takes_no_path_of_the_user(downloads):
    """The user's variables name the folder, too."""
    paths = {"PYTHONPATH": str(downloads), "MICROPYPATH": str(downloads), "PYTHONHOME": ""}
    for command in (interpreter.passo("wiring", "router_3axis"), [*interpreter.python(), "-c", "import struct, typing, passo, host_tools"], interpreter.mpremote_command("nosuch")):
        _status, said = run(downloads, command, **paths)
        assert executed(downloads) == [] and "a file of others" not in said, said
    assert "router" in run(downloads, interpreter.passo("wiring", "router_3axis"), **paths)[1]


def test_passo_itself_finds_nothing_in_the_current_folder(downloads):
    """`export PYTHONPATH=$PYTHONPATH:/opt/lib` leaves an empty path in it, which is the current folder. sitecustomize.py is then Python's own affair."""
    (downloads / "sitecustomize.py").unlink()
    (downloads / "usercustomize.py").unlink()
    passo = Path(interpreter.python()[0]).with_name("passo")
    if not passo.exists():
        pytest.skip("passo is not installed")
    shutil.rmtree(downloads / "host_tools")  # which `passo` asks for before it can say anything
    for words in (("check", "part.nc"), ("check", "programs", "--workers", "2")):
        status, said = run(downloads, [passo, *words], PYTHONPATH=":/opt/nosuch", MICROPYPATH=":")
        assert (status, executed(downloads)) == (0, []), said


def test_processes_find_nothing_in_the_current_folder(downloads, monkeypatch):
    monkeypatch.chdir(downloads)
    monkeypatch.setenv("PYTHONPATH", str(downloads))
    assert list(in_processes(str.upper, ["a"], 1)) == [("a", "A")] and executed(downloads) == []


def test_a_folder_named_passo_is_in_nobodys_way(downloads):
    """As after cloning: `passo` is the folder of the sources."""
    for each in downloads.iterdir():
        shutil.rmtree(each) if each.is_dir() else each.unlink()
    (downloads / "part.nc").write_text(PART)
    (downloads / "passo").mkdir()
    for sources in (False, True):
        if sources:
            (downloads / "passo" / "passo").mkdir()
        status, said = run(downloads, interpreter.passo("check", "part.nc"))
        assert status == 0, said


def test_a_matplotlibrc_of_the_folder_is_not_obeyed(downloads):
    """It can have LaTeX run, and stands before the user's own."""
    for each in NAMES:
        shutil.rmtree(downloads / each, ignore_errors=True)
        (downloads / f"{each}.py").unlink(missing_ok=True)
    latex = downloads / "latex"
    latex.write_text(f"#!/bin/sh\necho latex >> {downloads.parent / 'ran'}\nexit 1\n")
    latex.chmod(0o755)
    (downloads / "matplotlibrc").write_text("text.usetex: True\n")
    for words in (("check", "part.nc", "-o", "path.png"), ("compile", "part.nc", "--dialect", "ngc", "-o", "plain.nc", "--picture", "path.svg")):
        status, said = run(downloads, interpreter.passo(*words), PATH=f"{downloads}:{os.environ['PATH']}")
        assert (status, executed(downloads)) == (0, []), said
