"""`passo resume`: goes on with a file where the board's journal says that it was interrupted: here with G-code."""

import time
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.lead_in import prepared
from host_tools.cli.link import BAUD
from host_tools.cli.options import AnyBaud, Port
from host_tools.clients.refusal import Refused
from host_tools.failure import Failure
from host_tools.language import _
from host_tools.programs.interrupted import ended, interrupted
from host_tools.programs.job_record import find_zero
from passo import errors


Protocol = Annotated[Optional[str], typer.Option(help="grbl, pulses or plotter; default by the file's name.")]
_SLOWING = "Hold:1"  # on its way to a stand, a held one or an alarm's; or the tool goes up
_AGAIN_S = 0.1
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
    _RESUMES[protocol](file, port or ports.only(), baud or BAUD[protocol], home, unverified, yes)


def _resume_pulses(*arguments):
    from host_tools.cli import resume_pulses

    resume_pulses.resume(*arguments)


def _resume_plotter(*arguments):
    from host_tools.cli import resume_plotter

    resume_plotter.resume(*arguments)


def _resume_gcode(file, port, baud, home, unverified, yes):
    from host_tools.clients.grbl import GrblClient
    from host_tools.programs import compiler, gcode_file, stored_job

    program = compiler.read(file)
    compiler.tell(program)
    plain = program.listing is None
    lines = gcode_file.read(file) if plain else list(program.rows())
    with GrblClient(port, baud) as client:
        settled(client)
        go_on(client, lines, file, stored_job.crc(stored_job.gcode_job(file)) if plain else 0, home, unverified, yes)


def go_on(client, lines, name, stored, home, unverified, yes):
    """Go on with [(number, bytes)] of the program `name` where the journal of a settled() machine says; `stored`: the CRC-32 of the
    same as a stored job. Raises Failure."""
    from host_tools.cli.stream import Panel

    try:
        said = client.command("$JR")
    except Refused as refused:
        if refused.number == errors.COMMANDED_ELSEWHERE:
            raise Failure("another link commands the machine: {}; $LINK=0 takes the command while it stands", refused) from None
        raise Failure("the board has no journal (docs/jobs.md): {}; passo stream --from LINE needs none", refused) from None
    number, place, known = interrupted(said, lines, stored)
    print(_("{}: interrupted before line {}", name, number) if place is None else _("{}: interrupted in line {}", name, number))
    find_zero(known, home, unverified, lambda: _home(client))
    if client.ask_status()["state"] == "Alarm":  # it came to its stand as it should: where it is remains known
        try:
            client.command("$X")
        except Refused as refused:
            if refused.number != errors.LOCKED:
                raise
            raise Failure("the machine is in alarm: give --home") from None
    state = client.ask_status()["state"]
    if state != "Idle":
        raise Failure("the machine has to be idle, and its state is {}", state)
    rest = prepared(client, lines, number, place, yes, ended(said))
    with Panel(client, lines) as panel:
        for done in client.stream(rest, True, panel.cycle, panel.numbered):
            panel.done(done)
        client.wait_idle(panel.cycle)
    print(_("{}: done, unverified", name) if unverified and not known else _("{}: done", name))


def _home(client):
    """Home the machine. Reset it first if it is in an alarm in which `$H` is refused."""
    try:
        client.home()
    except Refused as refused:
        if refused.number != errors.LOCKED:
            raise
        client.reset()
        client.home()


def settled(client):
    """What was queued when the cable was cut is played to its end; nothing is reset while it moves."""
    state = client.ask_status()["state"]
    if state == _SLOWING:
        print(_("the machine moves ({}): waiting until it stands", state))
        while state == _SLOWING:
            time.sleep(_AGAIN_S)
            state = client.ask_status()["state"]
    if state.startswith(("Hold", "Door")):
        raise Failure("the machine is held ({}): ~ goes on, Ctrl-X ends it", state)
    if state in ("Run", "Jog", "Home"):
        print(_("the machine moves ({}): waiting until it stands", state))
        client.wait_idle()


_RESUMES = {"grbl": _resume_gcode, "pulses": _resume_pulses, "plotter": _resume_plotter}
