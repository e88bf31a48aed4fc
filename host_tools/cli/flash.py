"""`passo flash`: build the firmware of a board and copy it there with mpremote.

Unchanged files are not copied again. The package, main.py and board.py are replaced, modules of an older version in
/passo are removed; saved settings and other files on the board stay. The board compiles nothing of it (see build/tree.py).
"""

import os
import shlex
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools import boards
from host_tools.build.budget import memory
from host_tools.build.tree import STAMP, build_tree, default_out
from host_tools.failure import Failure
from host_tools.language import _
from host_tools.resources import HOST_TOOLS
from passo.config.boardfile import check

REMOVE_STALE = HOST_TOOLS / "build" / "remove_stale.py"
REMOVE_STAMP = HOST_TOOLS / "build" / "remove_stamp.py"
# mpremote gives up on a board that does not answer after some ten seconds, and a whole copy takes about a minute.
PROBE_TIMEOUT_S = 30
COPY_TIMEOUT_S = 600


def commands(port, out, drivers=()):
    """The mpremote commands, as argument lists: ask if a board answers; then copy, remove stale modules, copy the stamp and reset. The
    old stamp goes first: a board whose copy was cut short has none, and says so at its start. `drivers`: packages of micropython-lib,
    which mpremote fetches from the internet."""
    mpremote = [sys.executable, "-m", "mpremote", "connect", port]
    copy = ["cp", "-r", str(out / "passo"), ":", "+", "cp", str(out / "main.py"), str(out / "board.py"), ":"]
    if drivers:
        copy += ["+", "mip", "install", *drivers]
    finish = ["+", "run", str(REMOVE_STALE), "+", "cp", str(out / STAMP), ":", "+", "reset"]
    return [mpremote + ["exec", "pass"], mpremote + ["run", str(REMOVE_STAMP), "+"] + copy + finish]


def drivers_of(board):
    """The packages of micropython-lib that a board file, a dict, asks for."""
    return ("sdcard",) if board.get("card") else ()


def no_answer(port):
    return Failure(
        "no MicroPython board answers on {}: is it the right port (passo ports), and does no other program use it? A running Passo "
        "lets go for two seconds after a reset",
        port,
    )


def reason_of(output):
    """The last line of what mpremote printed, without its name."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    return lines[-1].removeprefix("mpremote: ") if lines else ""


def check_port(port):
    """Raises Failure if there is no such port, before anything is built for it."""
    if "://" not in port and os.sep in port and not Path(port).exists():
        raise Failure("there is no port {}: is the board plugged in? (passo ports)", port)


def probe(command, port):
    """Raises Failure unless a MicroPython board answers."""
    if find_spec("mpremote") is None:
        raise Failure("mpremote, which talks to the board, is not installed: pip install mpremote")
    check_port(port)
    try:
        result = subprocess.run(command, capture_output=True, text=True, timeout=PROBE_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        raise no_answer(port) from None
    if result.returncode:
        said = reason_of(result.stderr or result.stdout)
        if "failed to access" in said or "no device" in said:
            raise Failure("{} (passo ports)", said)
        raise no_answer(port)


def copy(command, port):
    """Runs the copy with mpremote's own progress; raises Failure if it ended early."""
    try:
        result = subprocess.run(command, stderr=subprocess.PIPE, text=True, timeout=COPY_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        raise Failure("the board on {} stopped answering while its files were copied: flash it again", port) from None
    if result.returncode:
        raise Failure("copying to {} ended early: {}; flash it again", port, reason_of(result.stderr))


def flash(
    board: Annotated[str, typer.Option("--board", help="Name of a file of boards/, or the path of a board file.")],
    port: Annotated[Optional[str], typer.Option("--port", help="Serial port of the board (passo ports).")] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Build, then only print the commands.")] = False,
):
    """Build the firmware of one board, copy it there and reset.

    Example: passo flash --board plotter_2014 --port /dev/ttyACM0

    Example: passo flash --board plotter_2014 --dry-run
    """
    if port is None and not dry_run:
        raise Failure("which port? Give --port; passo ports lists those that look like a board")
    if port is not None and not dry_run:
        check_port(port)
    out = default_out(board)
    rows = build_tree(board, out)
    print(_("{}: {} files, {:,} bytes in {} (passo build lists them)", board, len(rows), sum(row[2] for row in rows), out))
    config = check(boards.load(board))
    if config["chip"].startswith("esp32"):
        print(memory(config))
    asking, copying = commands(port or "PORT", out, drivers_of(boards.load(board)))
    if dry_run:
        print(shlex.join(asking))
        print(shlex.join(copying))
        return
    probe(asking, port)
    copy(copying, port)
    print(_("{} runs on {}", board, port))
