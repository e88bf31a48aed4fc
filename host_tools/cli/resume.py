"""`passo resume`: goes on with a file where the board's journal says that it was interrupted: here with G-code."""

from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.lead_in import number_of, prepared
from host_tools.cli.link import BAUD
from host_tools.failure import Failure
from host_tools.programs.job_record import NO_JOURNAL, Record, find_zero


def interrupted(said, lines, stored=0):
    """(line to begin at, place in steps or None, whether the position is known) of an answer to `$JR`. `stored`: the CRC-32 of the same
    program as a stored job. Raises Failure if the journal is of another program, or this one has been done."""
    record = Record.of(said)
    line = record.line
    if record.job not in (number_of(lines), stored):
        raise Failure("the board's journal is of another file, or the file has changed; begin at a line with passo stream --from")
    if not line:
        return lines[0][0], None, record.known
    line = _line_of(lines, line)
    if record.done:
        if line >= lines[-1][0]:
            raise Failure("the file was done to its end")
        return line + 1, None, record.known
    return line, record.place, record.known


Protocol = Annotated[Optional[str], typer.Option(help="grbl, pulses or plotter; default by the file's name.")]
_LANGUAGES = {".txt": "pulses", ".svg": "plotter", ".packets": "plotter"}


def _line_of(lines, number):
    """The line of the file that has the N word `number`; a file without N words gets the numbers of its lines. Raises Failure."""
    from host_tools.clients.grbl import N_WORD

    if not any(b"N" in line.upper() for _, line in lines):
        return number
    found = [known for known, line in lines if (word := N_WORD.match(line.upper())) and int(word[1]) == number]
    if len(found) != 1:
        raise Failure(f"{len(found) or 'no'} lines of the file are N{number}, which was interrupted; begin at a line with passo stream --from")
    return found[0]


def ended(said):
    """Where the line ended, steps, that an answer to `$JR` says is done; None if none is."""
    record = Record.of(said)
    return record.place if record.line and record.done else None


def resume(
    file: Annotated[Path, typer.Argument(help="What was interrupted: G-code, a pulse file, a drawing.")],
    port: Annotated[Optional[str], typer.Option(help="Serial port, pty or pyserial URL (socket://host:port).")] = None,
    baud: Annotated[Optional[int], typer.Option(help="Bits per second of a serial port.")] = None,
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
        raise Failure(f"--protocol is {', '.join(_RESUMES)}, not {protocol!r}")
    _RESUMES[protocol](file, port or ports.only(), baud or BAUD[protocol], home, unverified, yes)


def _resume_pulses(*arguments):
    from host_tools.cli import resume_pulses

    resume_pulses.resume(*arguments)


def _resume_plotter(*arguments):
    from host_tools.cli import resume_plotter

    resume_plotter.resume(*arguments)


def _resume_gcode(file, port, baud, home, unverified, yes):
    from host_tools.cli.stream import Panel
    from host_tools.clients.grbl import GrblClient, Refused
    from host_tools.programs import compiler, gcode_file, stored_job

    program = compiler.read(file)
    compiler.tell(program)
    plain = program.listing is None
    lines = gcode_file.read(file) if plain else list(program.rows())
    with GrblClient(port, baud) as client:
        _settled(client)
        try:
            said = client.command("$JR")
        except Refused as refused:
            raise Failure(f"{NO_JOURNAL}: {refused}; passo stream --from LINE needs none") from None
        number, place, known = interrupted(said, lines, stored_job.crc(stored_job.gcode_job(file)) if plain else 0)
        print(f"{file}: interrupted {'before' if place is None else 'in'} line {number}")
        find_zero(known, home, unverified, client.home)
        if client.ask_status()["state"] == "Alarm":  # it came to its stand as it should: where it is remains known
            client.command("$X")
        state = client.ask_status()["state"]
        if state != "Idle":
            raise Failure(f"the machine has to be idle, and its state is {state}")
        rest = prepared(client, lines, number, place, yes, ended(said))
        with Panel(client, lines) as panel:
            for done in client.stream(rest, True, panel.cycle, panel.numbered):
                panel.done(done)
            client.wait_idle(panel.cycle)
        print(f"{file}: done{', unverified' if unverified and not known else ''}")


def _settled(client):
    """What was queued when the cable was cut is played to its end; nothing is reset while it moves."""
    state = client.ask_status()["state"]
    if state.startswith(("Hold", "Door")):
        raise Failure(f"the machine is held ({state}): ~ goes on, Ctrl-X ends it")
    if state in ("Run", "Jog", "Home"):
        client.wait_idle()


_RESUMES = {"grbl": _resume_gcode, "pulses": _resume_pulses, "plotter": _resume_plotter}
