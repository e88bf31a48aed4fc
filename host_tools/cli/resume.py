"""`passo resume`: goes on with a file where the board's journal says that it was interrupted."""

from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.link import BAUD
from host_tools.cli.options import AnyBaud, Port
from host_tools.failure import Failure


Protocol = Annotated[Optional[str], typer.Option(help="grbl, pulses or plotter; default by the file's name.")]
_LANGUAGES = {".txt": "pulses", ".svg": "plotter", ".packets": "plotter"}


def resume(
    file: Annotated[Path, typer.Argument(help="What was interrupted: G-code, a pulse file, a drawing.")],
    port: Port = None,
    baud: AnyBaud = None,
    protocol: Protocol = None,
    home: Annotated[bool, typer.Option(help="Home the machine first: wanted after a power cut.")] = False,
    unverified: Annotated[bool, typer.Option("--unverified", help="Nothing can home: the operator has seen that zero is right.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the tool goes down.")] = False,
):
    """Go on with a file that `passo stream`, `pulses play` or `draw` was sending, or that ran as a stored job, when the cable, the PC, the board or the power failed.

    The board's journal says which line was under way, and where. State is replayed, nothing moves; the tool goes up, over the
    place, spindle and coolant go on, and you are asked before it goes down. The board file has to have the key `journal`.

    A program in a dialect of its own is compiled again, as passo stream did; one with a tool table is resumed by the file that
    passo compile makes of it, if that is what was streamed.

    A .txt is a pulse file, an .svg or .packets a drawing, with the options that it was begun with; anything else is G-code.

    Examples:

        passo resume part.gcode
        passo resume part.gcode --home --port /dev/ttyACM0
        passo resume hexagon.txt --unverified
        passo resume map.svg --home
    """
    from host_tools.cli import ports

    protocol = protocol or _LANGUAGES.get(file.suffix.lower(), "grbl")
    if protocol not in _RESUMES:
        raise Failure("--protocol is {}, not {!r}", ", ".join(_RESUMES), protocol)
    _RESUMES[protocol](file, port or ports.only_port(), baud or BAUD[protocol], home, unverified, yes)


def _resume_pulses(*arguments):
    """Go on with a pulse file."""
    from host_tools.cli import resume_pulses

    resume_pulses.resume_pulse_file(*arguments)


def _resume_plotter(*arguments):
    """Go on with a drawing."""
    from host_tools.cli import resume_plotter

    resume_plotter.resume_drawing(*arguments)


def _resume_gcode(*arguments):
    """Go on with G-code."""
    from host_tools.cli import resume_gcode

    resume_gcode.resume_program(*arguments)


_RESUMES = {"grbl": _resume_gcode, "pulses": _resume_pulses, "plotter": _resume_plotter}
