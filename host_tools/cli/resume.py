"""`passo resume`: goes on with a G-code file where the board's journal says that it was interrupted."""

import re
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.lead_in import number_of, prepared
from host_tools.failure import Failure

_DONE, _HOMED = 1, 2
_JOURNAL = re.compile(r"\[JOURNAL:([0-9a-f]+)\|(\d+)\|(\d+)\|([-\d,]+)\]")


def interrupted(said, lines, stored=0):
    """(line to begin at, place in steps or None, whether the position is known) of an answer to `$JR`. `stored`: the CRC-32 of the same
    program as a stored job. Raises Failure if the journal is of another program, or this one has been done."""
    found = _JOURNAL.search("\n".join(said))
    if not found:
        raise Failure("the board does not say where its job is")
    job, line, flags = int(found[1], 16), int(found[2]), int(found[3])
    if job not in (number_of(lines), stored):
        raise Failure("the board's journal is of another file, or the file has changed; begin at a line with passo stream --from")
    known = bool(flags & _HOMED)
    if not line:
        return lines[0][0], None, known
    line = _line_of(lines, line)
    if flags & _DONE:
        if line >= lines[-1][0]:
            raise Failure("the file was done to its end")
        return line + 1, None, known
    return line, [int(part) for part in found[4].split(",")], known


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
    found = _JOURNAL.search("\n".join(said))
    return [int(part) for part in found[4].split(",")] if int(found[2]) and int(found[3]) & _DONE else None


def resume(
    file: Annotated[Path, typer.Argument(help="The G-code that was interrupted.")],
    port: Annotated[Optional[str], typer.Option(help="Serial port, pty or pyserial URL (socket://host:port).")] = None,
    baud: Annotated[int, typer.Option(help="Bits per second of a serial port.")] = 115200,
    home: Annotated[bool, typer.Option(help="Home the machine first: wanted after a power cut.")] = False,
    unverified: Annotated[bool, typer.Option("--unverified", help="Nothing can home: the operator has seen that zero is right.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the tool goes down.")] = False,
):
    """Go on with a file that `passo stream` was sending, or that ran as a stored job, when the cable, the PC, the board or the power failed.

    The board's journal says which line was under way, and where. State is replayed, nothing moves; the tool goes up, over the
    place, spindle and coolant go on, and you are asked before it goes down. The board file has to have the key `journal`.

    Examples:

        passo resume part.gcode

        passo resume part.gcode --home --port /dev/ttyACM0
    """
    from host_tools.cli import ports
    from host_tools.cli.stream import Panel
    from host_tools.clients.grbl import GrblClient, Refused
    from host_tools.programs import gcode_file, stored_job

    lines = gcode_file.read(file)
    with GrblClient(port or ports.only(), baud) as client:
        _settled(client)
        try:
            said = client.command("$JR")
        except Refused as refused:
            raise Failure(f"the board has no journal (docs/jobs.md): {refused}; passo stream --from LINE needs none") from None
        number, place, known = interrupted(said, lines, stored_job.crc(stored_job.gcode_job(file)))
        print(f"{file}: interrupted {'before' if place is None else 'in'} line {number}")
        _find_zero(client, known, home, unverified)
        with Panel(client, lines) as panel:
            for _ in went_on(client, lines, number, place, yes, panel.cycle, ended(said)):
                panel.done(_)
            client.wait_idle(panel.cycle)
        print(f"{file}: done{', unverified' if unverified and not known else ''}")


def went_on(client, lines, number, place, yes, cycle=None, end=None):
    """Send what is left; yields the numbers of the lines that are answered."""
    numbered = not any(b"N" in line.upper() for _, line in lines)
    rest = prepared(client, lines, number, place, yes, end)
    yield from client.stream(rest, True, cycle, numbered)


def _settled(client):
    """What was queued when the cable was cut is played to its end; nothing is reset while it moves."""
    state = client.ask_status()["state"]
    if state.startswith(("Hold", "Door")):
        raise Failure(f"the machine is held ({state}): ~ goes on, Ctrl-X ends it")
    if state in ("Run", "Jog", "Home"):
        client.wait_idle()


def _find_zero(client, known, home, unverified):
    if home:
        client.command("$H", 600)
    elif not known and not unverified:
        raise Failure("where the machine stands is not known since then: give --home; or --unverified, if you have seen that zero is right")
    elif client.ask_status()["state"] == "Alarm":  # it came to its stand as it should: where it is remains known
        client.command("$X")
    state = client.ask_status()["state"]
    if state != "Idle":
        raise Failure(f"the machine has to be idle, and its state is {state}")
