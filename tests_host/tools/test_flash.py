"""`passo flash`: the commands it would run, and a whole flash of a board behind a pty."""

import io
import json
import os
import pty
import re
import shlex
import subprocess
import sys
import time
import tty
from functools import partial
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from host_tools import interpreter
from host_tools.build.tree import write_package
from host_tools.cli import flash
from host_tools.failure import Failure
from host_tools.resources import version

FAKE_BOARD = Path(__file__).resolve().parents[1] / "sims" / "fake_board.py"
MICROPYTHON = Path(sys.executable).parent / "micropython"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder, so that build/ does not land in the project."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_flash(*arguments):
    app = typer.Typer()
    app.command()(flash.flash)
    return CliRunner().invoke(app, ["--board", "plotter_2014", *arguments])


def test_dry_run_transcript(folder):
    result = run_flash("--port", "/dev/ttyACM0", "--dry-run")
    assert result.exit_code == 0, result.output
    mpremote = shlex.join(interpreter.mpremote_command("/dev/ttyACM0"))
    assert result.output.splitlines()[-2:] == [
        f"{mpremote} run {shlex.quote(str(flash.flash_uf2.ASK))}",
        f"{mpremote} run {shlex.quote(str(flash.REMOVE_STAMP))} + cp build/plotter_2014/main.py :"
        " + cp -r build/plotter_2014/passo : + cp build/plotter_2014/board.py :"
        f" + run {shlex.quote(str(flash.REMOVE_STALE))} + cp build/plotter_2014/stamp.txt : + reset",
    ]
    assert (folder / "build/plotter_2014/passo/app.mpy").is_file()


@pytest.mark.parametrize("port", ["/dev/no-such-port", "/dev/no/such/port"])
def test_a_wrong_port_is_one_line(folder, port):
    """Nothing is built for it, and no table goes before the reason."""
    result = run_flash("--port", port)
    assert isinstance(result.exception, Failure) and f"there is no port {port}" in str(result.exception)
    assert result.output == "" and not (folder / "build").exists()


def test_a_port_that_does_not_answer_is_one_line(folder, monkeypatch):
    monkeypatch.setattr(flash, "ask_board", lambda command, port: (_ for _ in ()).throw(flash.no_answer_failure(port)))
    result = run_flash("--port", "socket://localhost:1")
    assert isinstance(result.exception, Failure) and "no MicroPython board answers" in str(result.exception)
    assert result.output == "" and not (folder / "build").exists()


def test_a_port_must_be_named(folder):
    result = run_flash()
    assert isinstance(result.exception, Failure)
    assert "--port" in str(result.exception)


def test_a_port_that_is_not_there():
    asking, _ = flash.flash_commands("/dev/no-such-port", Path("build/x"))
    with pytest.raises(Failure, match="there is no port /dev/no-such-port"):
        flash.ask_board(asking, "/dev/no-such-port")


def test_a_port_without_a_board(monkeypatch):
    master, slave = pty.openpty()
    tty.setraw(slave)
    port = os.ttyname(slave)
    monkeypatch.setattr(flash, "PROBE_TIMEOUT_S", 3)
    asking, _ = flash.flash_commands(port, Path("build/x"))
    try:
        with pytest.raises(Failure, match=f"no MicroPython board answers on {port}"):
            flash.ask_board(asking, port)
    finally:
        os.close(master)
        os.close(slave)


@pytest.fixture
def board(tmp_path):
    """(port, folder of its files) of a board that answers as MicroPython does."""
    if not MICROPYTHON.exists():
        pytest.skip(f"there is no {MICROPYTHON}")
    files = tmp_path / "board"
    files.mkdir()
    master, slave = pty.openpty()
    tty.setraw(slave)
    process = subprocess.Popen([MICROPYTHON, FAKE_BOARD, files], stdin=master, stdout=master)
    yield os.ttyname(slave), files
    process.kill()
    process.wait()
    os.close(master)
    os.close(slave)


def put(files, name, text="old"):
    (files / name).parent.mkdir(parents=True, exist_ok=True)
    (files / name).write_text(text)


def put_drives(firmware):
    """The coil drives that the plotters' board files ask for, by their manifests."""
    for name in ("drive_unipolar", "drive_pbl3770a", "coil_drives"):
        put(firmware, f"passo/options/{name}/manifest.py", "x = 1\n")


@pytest.fixture
def small_firmware(tmp_path, monkeypatch):
    """A few modules instead of all: a copy takes its time."""
    firmware = tmp_path / "firmware"
    for name in ("main.py", "passo/__init__.py", "passo/app.py", "passo/motion/line.py", "passo/protocols/plotter/__init__.py"):
        put(firmware, name, "x = 1\n")
    put_drives(firmware)
    monkeypatch.setattr(flash, "build_tree", partial(flash.build_tree, firmware=firmware))


def wait_for(path):
    for _ in range(600):
        if path.exists():
            return True
        time.sleep(0.1)
    return False


def test_a_whole_flash(folder, board, small_firmware):
    port, files = board
    kept = ("settings.0", "settings.1", "lib/mine.py")  # the settings above all
    for name in kept + ("passo/app.py", "passo/old_room/gone.mpy", "main.py"):
        put(files, name)
    result = run_flash("--port", port)
    assert result.exit_code == 0, (result.output, result.exception)
    built = folder / "build" / "plotter_2014"
    for path in built.rglob("*"):
        if path.is_file():
            assert (files / path.relative_to(built)).read_bytes() == path.read_bytes(), path
    assert not (files / "passo/app.py").exists(), "a module of an older version would hide the new one"
    assert not (files / "passo/old_room").exists()
    for name in kept:
        assert (files / name).read_text() == "old"
    assert wait_for(files / ".reset")


def test_a_copy_that_ends_early(folder, board, small_firmware):
    port, files = board
    put(files, "passo", "a file where the package's folder belongs")
    put(files, "stamp.txt")
    result = run_flash("--port", port)
    assert isinstance(result.exception, Failure)
    assert str(result.exception).startswith(f"copying to {port} ended early: ")
    assert "\n" not in str(result.exception)
    assert (files / "stamp.txt").read_text() == "being copied\n", "else it would say that the firmware is whole"


OLD_STATES = {
    "empty": {},
    "an older build": {"main.py": None, "passo/stamp.txt": "0123456789ab\n", "stamp.txt": "0123456789ab\n", "passo/app.mpy": "old"},
    "the same build": {"main.py": None, "passo/stamp.txt": "", "stamp.txt": "", "passo/app.mpy": "old"},
    "one without stamps": {"main.py": "main()\n", "passo/app.mpy": "old"},
    "sources by hand": {"main.py": None, "passo/app.mpy": "old"},
}


def starts(files):
    """Whether main.py runs what is there."""
    main = files.get("main.py")
    if main is None:
        return False
    try:
        compile(main, "main.py", "exec")
    except SyntaxError:
        return False
    if "stamp_of(" not in main:
        return re.search(r"^ *main\(.*\)$", main, re.MULTILINE) is not None
    names = {"sys": sys, "open": lambda path: io.StringIO(files[path]) if path in files else open("/no/such/file")}
    exec(main[: main.index("\nif WHOLE:")].replace("import passo_image as image", "raise ImportError"), names)
    return "\n    main(Start, STAMP)\n" in main and names["WHOLE"]


def copied(commands, out):
    """(path, text) of each file that the commands write, in order."""
    words = commands[commands.index("run") :]
    for step in [each.split(" ") for each in " ".join(words).split(" + ")]:
        if step[:2] == ["cp", "-r"]:
            yield from ((path.relative_to(out).as_posix(), path.read_bytes().decode("latin-1")) for path in Path(step[2]).rglob("*") if path.is_file())
        elif step[0] == "cp":
            yield from ((Path(path).name, Path(path).read_bytes().decode("latin-1")) for path in step[1:-1])
        elif step[:2] == ["run", str(flash.REMOVE_STAMP)]:
            yield "stamp.txt", "being copied\n"


@pytest.mark.parametrize("how", ["flash", "mip"])
def test_a_copy_cut_anywhere_does_not_start(folder, how):
    """Behind any number of files, and amid each: whatever was on the board, it says that it is not whole, or has no main.py that is. mip runs
    nothing on the board."""
    out = folder / "build" / "router_3axis"
    flash.build_tree("router_3axis", out)
    write_package(out)
    if how == "flash":
        writes = list(copied(flash.flash_commands("PORT", out)[1], out))
    else:
        urls = json.loads((out / "package.json").read_text())["urls"]
        writes = [(name, (out / source).read_bytes().decode("latin-1")) for name, source in urls]
    assert len(writes) > 100 and writes[-1][0] == "stamp.txt"
    main, stamp = (out / "main.py").read_text(), (out / "stamp.txt").read_text()
    for before in OLD_STATES:
        files = {name: main if text is None else text or stamp for name, text in OLD_STATES[before].items()}
        for number, (name, text) in enumerate(writes):
            for part in ("", text[: len(text) // 2], text[:-1], text):
                whole = number == len(writes) - 1 and part.strip() == text.strip()
                files[name] = part
                if number:  # else nothing but a stamp has changed
                    assert bool(starts(files)) == whole, (before, number, name, len(part))
        assert starts(files)


def test_a_stamp_is_of_all_files(folder, small_firmware):
    """Another number in one module is another build; the same files are the same."""
    out = folder / "build" / "plotter_2014"
    stamps = []
    put(folder / "firmware", "main.py", "import passo.app\n")
    for text in ("x = 1\nprint(x)\n", "x = 2\nprint(x)\n", "x = 1\nprint(x)\n"):
        put(folder / "firmware", "passo/app.py", text)
        assert run_flash("--dry-run").exit_code == 0
        stamps.append((out / "stamp.txt").read_text())
        assert stamps[-1] == (out / "passo" / "stamp.txt").read_text()
    assert stamps[0] == stamps[2] != stamps[1] and len(stamps[0]) == len(version()) + 10
