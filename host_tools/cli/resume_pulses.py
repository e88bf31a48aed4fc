"""`passo resume` of a pulse file: the tool off, over the position by hand, then the rest as a stream, forward or backward."""

import time

from host_tools.cli.lead_in import operator_agrees
from host_tools.cli.pulses_panel import Panel, status_text
from host_tools.cli.pulses_stream import jog_by, play_long
from host_tools.clients.pulses import PulsesClient
from host_tools.clients.refusal import Refused
from host_tools.clients.serial_port import LinkError
from host_tools.failure import Failure
from host_tools.language import _
from host_tools.programs.job_record import BACK, Record, find_zero
from host_tools.programs.long_pulses import LongFile


_QUIET_S = 1.2


def resume_pulse_file(file, port, baud, home, unverified, yes):
    """Go on with a pulse file at the command that the board's journal names. Raises Failure."""
    with PulsesClient(port, baud) as client:
        status = _first_status(client)
        source = LongFile(file, "xyz"[: len(status["place"].split(","))])
        try:
            if any(line.startswith("[JOB:") for line in _ask_optional(client, "$F?")):
                raise Failure("a stored job runs on the board: passo pulses status, stop")
            _stop_run(client, status)
            record = Record.of_job(client.ask("$JR"))
        except Refused as refused:
            raise Failure("the board has no journal (docs/use/jobs.md): {}; passo pulses play --from COMMAND needs none", refused) from None
        if record.job != source.job_number():
            raise Failure("the board's journal is of another file, or the file has changed; begin at a command with passo pulses play --from")
        number, times, backward = start_of_rest(record, source)
        way = _(", backward") if backward else _(", {} times to go", times) if times > 1 else ""
        print(_("{}: interrupted before command {}", file, number) + way)
        find_zero(record.is_known, home, unverified, client.home)
        if client.status()["state"] == "alarm":  # the host was lost, and it came to a stand: where it is remains known
            client.command("stop")  # behind a halting input it is unlocked only then
            client.command("unlock")
        if client.status()["state"] == "alarm":
            raise Failure("the machine is in alarm: give --home")
        _go_to_start(client, source, number, record.place, yes)
        try:
            play_long(client, source, number, backward, times)
        except KeyboardInterrupt:
            client.command("stop")
            raise Failure("stopped by Ctrl-C") from None
        with Panel(client) as panel:
            status = panel.follow_run(True)
        done = _("{}: done, unverified", file) if unverified and not record.is_known else _("{}: done", file)
        print(f"{done}; {status_text(status)}")


def _first_status(client):
    """Return the status. If the cable was cut amid a command, the board refuses that a second after its last byte: ask once more then. Raises
    LinkError."""
    try:
        return client.status()
    except LinkError:
        raise
    except Failure:
        time.sleep(_QUIET_S)
        client.read_lines()
        client.said = []
        return client.status()


def _ask_optional(client, line):
    """Return the answer to a line; [] from a board that does not know it, without stored jobs."""
    try:
        return client.ask(line)
    except Refused:
        return []  # a board without stored jobs


def _stop_run(client, status):
    """Pause a run that still plays, and end it: the tool is off, and the journal has the position."""
    if status["state"] in ("run", "hold"):
        client.command("pause")
        with Panel(client) as panel:
            while panel.follow_run(False)["state"] == "run":
                pass
    if status["state"] != "alarm":
        client.command("stop")


def start_of_rest(record, source):
    """Return (command to begin at, times to play, True if backward) of a journal's Record. Raises Failure if nothing is left."""
    number, times = record.line, max(record.flags >> 8, 1)
    backward = bool(record.flags & BACK)
    if backward and not number:
        raise Failure("the file was played back to its start")
    while not backward and number >= source.total:
        number, times = number - source.total, times - 1
        if times < 1:
            raise Failure("the file was done to its end")
    return number, 1 if backward else times, backward


def _go_to_start(client, source, number, position, yes):
    """Go up, tool off, over `position` (steps), then down to it, if the operator agrees. Raises Failure."""
    here = _read_position(client)
    axes = len(here)
    position = position[:axes]
    top = here[-1]
    if axes == 3:
        top = max(top, position[2] - source.seek(number).place[2] + source.highest_steps(), position[2])
        jog_by(client, (0, 0, top - here[2]))
    across = [to - at for to, at in zip(position, here)]
    if axes == 3:
        across[2] = 0
    jog_by(client, across)
    if not yes and not operator_agrees(_("next is command {}, at {} steps", number, ", ".join(map(str, position)))):
        raise Failure("not gone on: the tool is off")
    if axes == 3:
        jog_by(client, (0, 0, position[2] - top))
    if _read_position(client) != position:
        raise Failure("the machine is not at the place: {}, not {}", _read_position(client), position)


def _read_position(client):
    """Return the machine's position in steps, one number an axis."""
    return [int(part) for part in client.status()["place"].split(",")]
