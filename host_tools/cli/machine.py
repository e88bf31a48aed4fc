"""`passo machine`: several machines on one board: board files that are stored there, of which one is chosen."""

import contextlib
import hashlib
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from host_tools import interpreter
from host_tools.build.budget import check_module
from host_tools.build.machines import OLD
from host_tools.build.tree import FILE_LIST, STAMP, build_tree, default_out
from host_tools.cli import flash_uf2
from host_tools.cli.flash import COPY_TIMEOUT_S, PROBE_TIMEOUT_S, check_port, flash_commands, copy_files, ask_board, reason_of
from host_tools.failure import Failure
from host_tools.language import _
from host_tools.resources import HOST_TOOLS

app = typer.Typer(
    help="""Write board files, store several on a board, choose the one that it is, and go back.

    Each machine has its own saved settings and firmware; files that are alike are stored once. They want the same chip.

    Examples:

        passo machine new mine --like lpt_router axes.x.travel_steps=24000
        passo machine set mine.py step_program.interval_us=250
        passo machine add mine.py --port /dev/ttyACM0
        passo machine choose mine --port /dev/ttyACM0
        passo machine back --port /dev/ttyACM0
    """,
    no_args_is_help=True,
)
Port = Annotated[str, typer.Option(help="Serial port of the board (passo ports).")]
Pairs = Annotated[list[str], typer.Argument(metavar="KEY=VALUE...", help="Values as in a board file; a KEY is a path: axes.x.steps_per_m. None removes.")]
_BAUD = 115_200  # of a chip's own USB any will do
_ON_BOARD = HOST_TOOLS / "build" / "machines.py"


def _mpremote_command(port):
    """Return the command that runs mpremote with the board on `port`."""
    return interpreter.mpremote_command(port)


def _call_board(port, call, *more):
    """Run `call`, functions of machines.py, on the board; return the lines that it prints. `more`: further commands of mpremote. Raises Failure with
    its error."""
    check_port(port)
    ask_board(flash_commands(port, Path())[0], port)
    text = _ON_BOARD.read_text(encoding="utf-8") + "\n" + call
    try:
        result = subprocess.run(
            [*_mpremote_command(port), "exec", text, *more], capture_output=True, text=True, timeout=COPY_TIMEOUT_S
        )
    except subprocess.TimeoutExpired:
        raise Failure("the board on {} stopped answering", port) from None
    if result.returncode:
        raise Failure("{}", reason_of(result.stderr or result.stdout).removeprefix("ValueError: "))
    return result.stdout.splitlines()


@app.command("list")
def list_(port: Port):
    """Show the machines that are stored, and which one is chosen. The board goes on after a reset.

    Example: passo machine list --port /dev/ttyACM0
    """
    lines = _call_board(port, "print_machines()", "+", "reset")
    now = next((line[7:] for line in lines if line.startswith("chosen ")), "")
    found = [line[8:].split(": ", 1) for line in lines if line.startswith("machine ")]
    for name, state in found:
        print(f"{'*' if name == now else ' '} {name:<20} {state}")
    if not found:
        print(_("no machine is stored: passo machine add BOARD"))


@app.command()
def add(
    board: Annotated[str, typer.Argument(help="Name of a file of boards/, or the path of a board file.")],
    port: Port,
):
    """Build a machine's firmware, and store its board file and what the board lacks of that firmware. The chosen machine stays as it is.

    Example: passo machine add boards/mine.py --port /dev/ttyACM0
    """
    told = store_machine(board, port, "print_machines()")
    name = Path(board).stem
    print(_("{0} is stored: passo machine choose {0}", name))
    for line in told:
        if line.startswith("machine ") and not line.endswith(": ready"):
            print(line)


def store_machine(board, port, call, out=None):
    """Store a machine with the files of its firmware that the board lacks; then run `call` of machines.py, and restart. `out`: folder of the build.
    Return the lines that the call prints. Raises Failure."""
    from host_tools import board_files, boards

    name = Path(board).stem
    board_files.check_name(name)
    chip = boards.load(board).get("chip")
    told = _call_board(port, "print_machines()")
    there = next((line[5:] for line in told if line.startswith("chip ")), None)
    if there is None:
        raise Failure("there is no machine on this board yet: passo flash first")
    if there != chip:
        raise Failure("this board is an {}, and {} is for an {}", there, name, chip)
    files = _build_firmware(board, port, out or default_out(board))
    text = "".join(f"{path} {digest}\n" for path, digest in files)
    data = boards.board_py(board)
    wanted = {line.split()[1] for line in _call_board(port, f"keep_old({name!r}, {_file_digest('board.py', data)!r})\nprint_missing({text!r})") if line.startswith("wants ")}
    with tempfile.TemporaryDirectory() as folder:
        machines = Path(folder) / "machines"
        (machines / "files").mkdir(parents=True)
        for (_path, digest), source in files.items():
            if digest in wanted:
                shutil.copyfile(source, machines / "files" / digest)
        if wanted:
            copy_files([*_mpremote_command(port), "cp", "-r", str(machines), ":"], port)
        stored = machines / name
        stored.mkdir()
        (stored / "board.py").write_bytes(data)
        (stored / "modules.txt").write_text(text, encoding="ascii")
        copy_files([*_mpremote_command(port), "cp", "-r", str(machines), ":"], port)
    return _call_board(port, "remove_unused()\n" + call, "+", "reset")


def _build_firmware(board, port, out):
    """Return {(path on the board, digest): file} of a machine's firmware, built in `out`; empty if the board has Passo's UF2. Raises Failure."""
    from host_tools import boards
    from passo.config.boardfile import check

    has = flash_uf2.parse_answer(ask_board(flash_uf2.ask_command(port), port), port)
    if has.chip:
        flash_uf2.check_fits(has, check(boards.load(board)), board)
        return {}
    check_module(check(boards.load(board)), board)
    build_tree(board, out)
    files = [out / "main.py", out / STAMP, *sorted(path for path in (out / "passo").rglob("*.*") if path.name != FILE_LIST)]
    return {(path.relative_to(out).as_posix(), _file_digest(path.relative_to(out).as_posix(), path.read_bytes())): path for path in files}


def _file_digest(path, data):
    """Return the digest of a file on a board, as machines.py computes it: 16 hexadecimal digits."""
    return hashlib.sha256(path.encode() + b"\0" + data).hexdigest()[:16]


def become_machine(board, port):
    """Store a machine, choose it and start the board with it; after a failure the board starts with the machine it had. The board must be at rest,
    and its port free. Takes some ten seconds, a minute if much has to be copied. Raises Failure."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            store_machine(board, port, f"choose_machine({Path(board).stem!r})", Path(folder))
    except Failure:
        with contextlib.suppress(subprocess.SubprocessError):
            subprocess.run([*_mpremote_command(port), "reset"], capture_output=True, timeout=PROBE_TIMEOUT_S)
        raise


@app.command()
def choose(
    name: Annotated[str, typer.Argument(help="One of passo machine list.")],
    port: Port,
):
    """Choose a machine and start the board anew with it. The board must stand: its outputs are switched off.

    Settings are kept for each machine: those of the old one are put away, those of the new one come back.

    Example: passo machine choose lpt_router --port /dev/ttyACM0
    """
    _check_stored_name(name)
    _check_at_rest(port)
    _call_board(port, f"choose_machine({name!r})", "+", "reset")
    print(_("{} is chosen, and the board starts with it", name))


@app.command()
def back(port: Port):
    """Choose the machine that was chosen before, and start the board anew with it: for a change that does not start, or is wrong.

    A machine whose board file was replaced is kept as NAME_old, with its settings of then; the firmware before the first choice as before.

    Example: passo machine back --port /dev/ttyACM0
    """
    _check_at_rest(port)
    lines = _call_board(port, "choose_last()", "+", "reset")
    print(_("{} is chosen, and the board starts with it", next(line[7:] for line in lines if line.startswith("chosen "))))


@app.command()
def remove(
    name: Annotated[str, typer.Argument(help="One of passo machine list, but the chosen one.")],
    port: Port,
):
    """Remove a stored machine and its settings from the board. Its board file on this computer stays.

    Example: passo machine remove mine_old --port /dev/ttyACM0
    """
    _check_stored_name(name)
    _check_at_rest(port)
    _call_board(port, f"remove_machine({name!r})\nremove_unused()", "+", "reset")
    print(_("{} is removed", name))


@app.command()
def new(
    name: Annotated[str, typer.Argument(help="Name of the machine, and of its file NAME.py in this folder.")],
    like: Annotated[str, typer.Option(help="The board of boards/ that it is like.")],
    pairs: Pairs = (),
):
    """Write the board file of a machine that is like one of boards/, with its differences. Nothing is written if the firmware would refuse it.

    Examples:

        passo machine new mine --like lpt_router
        passo machine new mine --like lpt_router step_program.interval_us=250 axes.z=None
    """
    from host_tools import board_files

    board_files.check_name(name)
    file = Path(f"{name}.py")
    board_files.create(file, like, _parse_pairs(pairs))
    _print_written(file)


@app.command("set")
def set_(
    file: Annotated[Path, typer.Argument(help="A board file of your own.")],
    pairs: Pairs,
    port: Annotated[str | None, typer.Option(help="Store it on this board, too, and start the board with it.")] = None,
):
    """Change values of a board file; comments and order stay. FILE.old is what it was. Nothing is written if the firmware would refuse it.

    Examples:

        passo machine set mine.py axes.x.steps_per_m=81250 axes.x.invert=True
        passo machine set mine.py inputs.stop.active=0 outputs.fan=None
        passo machine set mine.py step_program.interval_us=250 --port /dev/ttyACM0
    """
    from host_tools import board_files, boards

    board_files.check_own(file)
    text = boards.read(file)
    changed = board_files.edit_text(file, text, _parse_pairs(pairs))
    if port is not None:
        board_files.check_name(file.stem)
        _check_at_rest(port)
    board_files.replace_file(file, text, changed)
    _print_written(file)
    if port is not None:
        become_machine(str(file), port)
        print(_("{0} starts with it; passo machine back --port {0} returns to what it was", port))


def _parse_pairs(pairs):
    """Return {path: value} of KEY=VALUE texts. Raises Failure."""
    from host_tools import board_edit

    return dict(board_edit.parse_pair(pair) for pair in pairs)


def _print_written(file):
    """Print that a board file is written."""
    print(_("{} is written", file))


def _check_stored_name(name):
    """Raise Failure if this is no name of a stored machine."""
    if not re.fullmatch(rf"\w{{1,32}}({OLD})?", name):
        raise Failure("{!r} is no name of a machine", name)


def _check_at_rest(port):
    """Raise Failure if a machine on that port says, in any language, that it is moving. A silent one is at its prompt, or starting."""
    check_port(port)
    try:
        state = _ask_state(port)
    except Failure:
        return
    if state.partition(":")[0].lower() not in ("idle", "alarm", "sleep", "check"):
        raise Failure("the machine is not at rest: {}; stop it first", state)


def _ask_state(port):
    """Return the state that the machine on a port reports; "idle" of a torch other than Passo's, which has no word for it. Raises Failure if nothing
    answers."""
    from host_tools.cli.log import find_language
    from host_tools.clients.grbl import GrblClient
    from host_tools.clients.plotter import PlotterClient
    from host_tools.clients.pulses import PulsesClient
    from host_tools.clients.torch import TorchClient

    kind = {"pulses": PulsesClient, "plotter": PlotterClient, "torch": TorchClient}.get(find_language(port, _BAUD))
    if kind is None:
        with GrblClient(port, _BAUD, 0.5) as client:
            return client.ask_status()["state"]
    with kind(port, _BAUD) as client:
        status = client.status()
    return status["state"] if status else "idle"
