"""How `passo stream --from` and `passo resume` get a machine to where a program goes on: step by step, and asked before the tool
goes down."""

import select
import sys

from host_tools.failure import Failure
from host_tools.language import _
from passo import errors

_SIGN_S = 0.3
_WAIT_S = 600  # that a way, a spindle or a dwell may take


def announce_program(client, lines, name):
    """Tell a board with a journal the number of the program that begins, and remember its name on this PC."""
    from host_tools.clients.grbl import Refused
    from host_tools.programs import program_names

    number = program_names.remember_program(lines, name)
    try:
        client.command(f"$JR={number:08x}")
    except Refused as refused:
        if refused.number not in (errors.STATEMENT, errors.BUSY):
            raise


def prepare_start(client, lines, number, place=None, yes=False, end=None, sure=True):
    """Bring the machine to the start of line `number`, or to `place` (steps) on its way, in the state of the program there. Return the lines still to
    be sent. `yes`: do not ask. `end`: position of an interrupted program before that line, steps. `sure`: False if zero is not known for certain, see
    plan_stages(). Raises Failure, also if the operator says no: the tool is up then, spindle and coolant are off."""
    from host_tools.programs.resume_line import plan_stages
    from host_tools.programs.replay_machine import Machine

    stages, rest, dot = plan_stages(Machine.of_answers(client.command("$$"), client.command("$#"), client.command("$I")), lines, number, place, end, sure)
    if dot:
        print(_("line {}: goes on at dot {} of {}", number, *dot))
    try:
        _carry_out(client, stages, number, yes)
    except KeyboardInterrupt:
        client.halt()
        raise Failure("not gone on: stopped on the way there") from None
    return rest


def _carry_out(client, stages, number, yes):
    """Send the lines of each stage and wait for its end; before the tool goes down ask the operator, unless `yes`. Raises Failure."""
    from host_tools.programs import replay

    moving = any(what == replay.DOWN for what, _ in stages)
    for what, sent in stages:
        if what == (replay.DOWN if moving else replay.GO) and not yes:
            _require_agreement(client, _("line {}: next is {}", number, " ".join(sent)))
        for line in sent:
            client.command(line, _WAIT_S)
        client.command("G4P0", _WAIT_S)


def _require_agreement(client, next_):
    """Ask the operator. Unless the answer is yes, also on Ctrl-C, switch spindle and coolant off and raise Failure."""
    agrees = False
    try:
        agrees = operator_agrees(next_, client.ask_status)
    finally:
        if not agrees:
            client.command("M5")
            client.command("M9")
    if not agrees:
        raise Failure("not gone on: the tool is up, spindle and coolant are off")


def operator_agrees(next_, idle=None):
    """Ask the operator before the tool goes down; True if the answer is yes. Calls `idle()` three times a second meanwhile: a board that watches its
    host, the spindle on, needs signs of it. Raises Failure without a terminal."""
    if not sys.stdin.isatty():
        raise Failure("nobody can be asked before the tool goes down; look at the machine, then give --yes")
    print(next_)
    print(_("The tool goes down. Is the place right, and all clear? [y/N]"), end=" ", flush=True)
    while idle and not select.select([sys.stdin], [], [], _SIGN_S)[0]:
        idle()
    return sys.stdin.readline().strip().lower() in _("y, yes").split(", ")
