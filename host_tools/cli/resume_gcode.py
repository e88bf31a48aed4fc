"""`passo resume` of G-code, and of a drawing or a picture as G-code: above the place, then down, then the rest."""

import time

from host_tools.cli.lead_in import prepare_start
from host_tools.clients.refusal import Refused
from host_tools.failure import Failure
from host_tools.language import _
from host_tools.programs.resume_line import end_position, resume_point
from host_tools.programs.job_record import find_zero
from passo import errors

_SLOWING = "Hold:1"  # on its way to a stand, a held one or an alarm's; or the tool goes up
_AGAIN_S = 0.1


def resume_program(file, port, baud, home, unverified, yes):
    """Go on with a G-code file at the line that the board's journal names. Raises Failure."""
    from host_tools.clients.grbl import GrblClient
    from host_tools.programs import compiler, stored_job

    program = compiler.read(file)
    compiler.print_notes(program)
    plain = program.listing is None
    lines = list(program.rows()) if plain else None
    with GrblClient(port, baud) as client:
        wait_until_settled(client)
        lines = lines or list(compiler.fit_to_machine(program, client.command("$I")).rows())
        go_on(client, lines, file, stored_job.crc_of(stored_job.gcode_lines(lines)) if plain else 0, home, unverified, yes)


def go_on(client, lines, name, stored, home, unverified, yes):
    """Go on with [(number, bytes)] of the program `name` at the line that the journal of a machine at rest names; `stored`: the CRC-32 of the same as
    a stored job. Raises Failure."""
    from host_tools.cli.stream import Panel, ask_settings

    try:
        said = client.command("$JR")
    except Refused as refused:
        if refused.number == errors.COMMANDED_ELSEWHERE:
            raise Failure("another link commands the machine: {}; $LINK=0 takes the command while it stands", refused) from None
        raise Failure("the board has no journal (docs/use/jobs.md): {}; passo stream --from LINE needs none", refused) from None
    number, place, known = resume_point(said, lines, stored)
    print(_("{}: interrupted before line {}", name, number) if place is None else _("{}: interrupted in line {}", name, number))
    find_zero(known, home, unverified, lambda: _home_machine(client))
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
    ask_settings([row for row in lines if row[0] >= number])
    rest = prepare_start(client, lines, number, place, yes, end_position(said), known or unverified)
    with Panel(client, lines) as panel:
        for done in client.stream(rest, True, panel.poll_keys, True):
            panel.count_line(done)
        client.wait_idle(panel.poll_keys)
    print(_("{}: done, unverified", name) if unverified and not known else _("{}: done", name))


def _home_machine(client):
    """Home the machine; reset it first if it is in an alarm in which `$H` is refused. Raises Refused."""
    try:
        client.home()
    except Refused as refused:
        if refused.number != errors.LOCKED:
            raise
        client.reset()
        client.home()


def wait_until_settled(client):
    """Wait until the machine has played the blocks queued when the cable was cut: it is not reset while it moves. Raises Failure if it is held."""
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
