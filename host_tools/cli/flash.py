"""`passo flash`: build the firmware of a board and copy it there with mpremote. A board with Passo's UF2 has it: only the board file goes
over (flash_uf2.py).

Unchanged files are not copied again. The package, main.py and board.py are replaced, modules of an older version in
/passo are removed; saved settings and other files on the board stay. The board compiles nothing of it (see build/tree.py).
"""

import os
import shlex
import subprocess
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools import boards
from host_tools.build.budget import check_module, memory_text
from host_tools.build.frozen import stamp
from host_tools.build.tree import STAMP, build_tree, default_out
from host_tools.cli import flash_uf2
from host_tools.failure import Failure
from host_tools.language import _
from host_tools.resources import HOST_TOOLS
from host_tools.switches import print_cautions
from passo.config.boardfile import check

REMOVE_STALE = HOST_TOOLS / "build" / "remove_stale.py"
REMOVE_STAMP = HOST_TOOLS / "build" / "remove_stamp.py"
# mpremote gives up on a board that does not answer after some ten seconds, and a whole copy takes about a minute.
PROBE_TIMEOUT_S = 30
COPY_TIMEOUT_S = 600


def flash_commands(port, out, drivers=(), source=False):
    """Return two mpremote commands, as argument lists: the first asks if a board answers; the second copies, removes stale modules, copies the stamp
    and resets. The second spoils the old stamp first and then copies main.py, which compares stamps: a board whose copy was cut short says so at its
    start, whatever was there before. `drivers`: packages of micropython-lib, which mpremote fetches from the internet. `source`: the copied package
    runs instead of the one in the UF2."""
    mpremote = flash_uf2.mpremote_command(port)
    copy = ["cp", str(out / "main.py"), ":", "+", "cp", "-r", str(out / "passo"), ":", "+", "cp", str(out / "board.py"), ":"]
    if drivers:
        copy += ["+", "mip", "install", *drivers]
    finish = ["+", "run", str(REMOVE_STALE), "+", "cp", str(out / STAMP), ":"]
    finish += ["+", "cp", str(out / STAMP), ":source.txt"] if source else []
    finish += ["+", "reset"]
    return [flash_uf2.ask_command(port), mpremote + ["run", str(REMOVE_STAMP), "+"] + copy + finish]


def drivers_of(board):
    """Return the packages of micropython-lib that a board file, a dict, asks for."""
    return ("sdcard",) if board.get("card") else ()


def no_answer_failure(port):
    """Return the Failure of a port at which no MicroPython answers."""
    return Failure(
        "no MicroPython board answers on {}: is it the right port (passo ports), and does no other program use it? A running Passo "
        "lets go for two seconds after a reset",
        port,
    )


def reason_of(output):
    """Return the last line of mpremote's output, without the name of mpremote."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    return lines[-1].removeprefix("mpremote: ") if lines else ""


def check_port(port):
    """Raise Failure if there is no such port, before anything is built for it."""
    if "://" not in port and os.sep in port and not Path(port).exists():
        raise Failure("there is no port {}: is the board plugged in? (passo ports)", port)


def ask_board(command, port):
    """Run `command` of mpremote and return its output. Raises Failure unless a board with MicroPython answers within 30 s."""
    if find_spec("mpremote") is None:
        raise Failure("mpremote, which talks to the board, is not installed: pip install mpremote")
    check_port(port)
    try:
        result = subprocess.run(command, capture_output=True, text=True, timeout=PROBE_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        raise no_answer_failure(port) from None
    if result.returncode:
        said = reason_of(result.stderr or result.stdout)
        if "failed to access" in said or "no device" in said:
            raise Failure("{} (passo ports)", said)
        raise no_answer_failure(port)
    return result.stdout


def copy_files(command, port):
    """Run the copy with mpremote's own progress, up to ten minutes. Raises Failure if it ends early."""
    try:
        result = subprocess.run(command, stderr=subprocess.PIPE, text=True, timeout=COPY_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        raise Failure("the board on {} stopped answering while its files were copied: flash it again", port) from None
    if result.returncode:
        raise Failure("copying to {} ended early: {}; flash it again", port, reason_of(result.stderr))


def copy_and_report(command, chosen, port):
    """Copy by `command`, and print that `chosen` runs on the port. Raises Failure."""
    copy_files(command, port)
    print(_("{} runs on {}", chosen, port))


def install_uf2(port, path, board):
    """Put a UF2 on a board, which may be in its boot loader; without a board file to come, reset it. Raises Failure."""
    told = flash_uf2.check_file(path)
    print(_("{} holds Passo's build {} for the {}", path, told[1], told[0]) if told else _("{} holds no Passo: MicroPython as it comes", path))
    try:
        has = flash_uf2.parse_answer(ask_board(flash_uf2.ask_command(port), port), port) if flash_uf2.find_drive() is None else None
    except Failure:
        raise flash_uf2.start_failure(path) from None
    flash_uf2.replace_uf2(port, path, has)
    if board is None:
        subprocess.run([*flash_uf2.mpremote_command(port), "reset"], capture_output=True, timeout=PROBE_TIMEOUT_S)


def flash(
    board: Annotated[Optional[str], typer.Option("--board", help="Name of a file of boards/, or the path of a board file.")] = None,
    port: Annotated[Optional[str], typer.Option("--port", help="Serial port of the board (passo ports).")] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Build, then only print the commands.")] = False,
    uf2: Annotated[Optional[Path], typer.Option("--uf2", help="A UF2 to put on the board first; its files are kept.")] = None,
    source: Annotated[bool, typer.Option("--source", help="Copy the modules to a board with Passo's UF2, too, and run those.")] = False,
):
    """Build the firmware of one board, copy it there and reset. A board with Passo's UF2 only wants the board file.

    Example: passo flash --board plotter_2014 --port /dev/ttyACM0

    Example: passo flash --board plotter_2014 --dry-run

    Example: passo flash --uf2 passo-rp2040-0123456789ab.uf2 --board router_3axis --port /dev/ttyACM0
    """
    if board is None and uf2 is None:
        raise Failure("which board? Give --board; boards/ has those of the project")
    if port is None and not dry_run:
        raise Failure("which port? Give --port; passo ports lists those that look like a board")
    if port is not None and not dry_run and uf2 is None:
        check_port(port)
    if uf2 is not None and not dry_run:
        install_uf2(port, uf2, board)
    if board is None:
        return
    config = check(boards.load(board))
    print_cautions(config)
    if not dry_run and (found := flash_uf2.parse_answer(ask_board(flash_uf2.ask_command(port), port), port)).chip and not source:
        put_board_file(board, config, found, port)
        return
    check_module(config, board)
    out = default_out(board)
    rows = build_tree(board, out)
    print(_("{}: {} files, {:,} bytes in {} (passo build lists them)", board, len(rows), sum(row[2] for row in rows), out))
    if config["chip"].startswith("esp32"):
        print(memory_text(config))
    asking, copying = flash_commands(port or "PORT", out, drivers_of(boards.load(board)), source)
    if dry_run:
        print(shlex.join(asking))
        print(shlex.join(copying))
        return
    copy_and_report(copying, board, port)


def put_board_file(board, config, found, port):
    """Copy the board file to a board with Passo's UF2 (`found`: its Has). Raises Failure if the UF2 does not serve it."""
    flash_uf2.check_fits(found, config, board)
    if found.stamp != stamp(found.chip):
        print(_("the UF2 on the board is build {} of Passo {}, and not of this source: make uf2 CHIP={} builds one", found.stamp, found.version, found.chip))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "board.py"
        file.write_bytes(boards.board_py(board))
        copy_and_report(flash_uf2.copy_command(port, file), board, port)
