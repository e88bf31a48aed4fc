"""`passo blackbox`: the events before an alarm or a crash, read off the board, drawn, and replayed on the virtual board."""

from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.failure import Failure
from host_tools.language import _


def blackbox(
    file: Annotated[Optional[Path], typer.Argument(help="A file that --save has written, from anywhere.")] = None,
    port: Annotated[Optional[str], typer.Option("--port", help="Serial port of the board (passo ports): its USB plug.")] = None,
    older: Annotated[bool, typer.Option("--older", help="The one before: a board keeps two.")] = False,
    save: Annotated[Optional[Path], typer.Option("--save", metavar="FILE", help="Write all that was read into one file, to look at later or to send.")] = None,
    picture: Annotated[Optional[Path], typer.Option("--picture", help="Write the timeline as a picture, .png.")] = None,
    replay: Annotated[bool, typer.Option("--replay/--no-replay", help="Play it on the virtual board.")] = True,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the firmware ends: a board that is read begins anew.")] = False,
):
    """Read a board's black box: the last seconds before an alarm, a crash or a reset. Draw them, and play them on the virtual board.

    The board file has to have `"blackbox": True`. The virtual board is given the same bytes and inputs and goes the same way, to the step. Exit status 1 if it does not.

    Example: passo blackbox --port /dev/ttyACM0 --save yesterday.zip --picture yesterday.png

    Example: passo blackbox yesterday.zip
    """
    from host_tools.programs.blackbox import Box, pack_files, unpack_files

    if (file is None) == (port is None):
        raise Failure("which black box? Give --port, or a file that --save has written")
    if file and not file.is_file():
        raise Failure("no file {}", file)
    files = unpack_files(file.read_bytes()) if file else read_board_files(port, yes)
    if save:
        save.write_bytes(pack_files(files))
        print(_("{}: all of it", save))
    box = Box.from_files(files, older)
    played = replay_box(box) if replay else None
    for line in report_lines(box, played):
        print(line)
    if picture:
        from host_tools.programs.timeline import draw_timeline

        draw_timeline(picture, box, played)
        print(_("{}: the timeline", picture))
    if played and played.faults:
        raise typer.Exit(1)


def read_board_files(port, yes):
    """Return {name: bytes} of a board's black box files. Ends its firmware, and starts it anew. Raises Failure; typer.Abort if the user says no."""
    from host_tools.cli.flash import check_port
    from host_tools.prove.connection import PortBoard

    check_port(port)
    if not yes and not typer.confirm(_("The firmware ends, and begins anew: it must stand, and does not know its position then. Go on?")):
        raise typer.Abort
    with PortBoard(port) as board:
        board.restart_interpreter()
        return files_of(board)


_READ = """
from binascii import b2a_base64
for name in {}:
    try:
        file = open(name, "rb")
    except OSError:
        continue
    print("=", name)
    while True:
        data = file.read(510)
        if not data:
            break
        print(b2a_base64(data).decode(), end="")
    file.close()
"""


def files_of(board):
    """Return {name: bytes} of those programs.blackbox.FILES that are on a board in the raw REPL. Raises Failure if it has no black box."""
    import base64

    from host_tools.programs.blackbox import FILE, FILES

    files, name = {}, None
    for line in board.exec(_READ.format(FILES)).splitlines():
        if line.startswith("= "):
            name = line[2:]
            files[name] = b""
        elif line:
            files[name] += base64.b64decode(line)
    if FILE not in files:
        raise Failure('there is no black box on {}: nothing has happened, or its board file lacks "blackbox": True', board.name)
    return files


def replay_box(box):
    """Play the box on the virtual board; return the Replay at its end. If it cannot be played, print the reason and return None."""
    from host_tools.sim.blackbox import Replay

    try:
        return Replay(box, box.settings).run()
    except Failure as failure:
        print(failure)
        return None


def report_lines(box, played):
    """Yield lines for people: the events with their seconds before the end, the crash, the result of the replay (`played`, or None)."""
    from host_tools.programs.timeline import lines_of, mm_text, reason_text

    yield _("{}, written behind {}. Seconds before its end:", box.board["name"], reason_text(box))
    yield from lines_of(box)
    if box.crash:
        yield box.crash.rstrip()
    if played is None:
        return
    for ms, text in played.faults:
        yield _("the virtual board: {:.3f} s: {}", (ms - box.end_ms) / 1000, text)
    if played.faults:
        yield _("The virtual board went another way than the board.")
    elif box.why == "reset":
        yield _("The virtual board went through all places that the board has noted. The reset came behind the last: where, nobody has seen; {} steps are played from its orders.", len(played.path) - 1)  # fmt: skip
    else:
        yield _("The virtual board went the same way, {} steps, to {}.", len(played.path) - 1, mm_text(box.board, played.path[-1]))
