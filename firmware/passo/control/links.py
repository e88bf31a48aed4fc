"""Which of several links may command: one at a time, so that two programs never pull at the same machine.

At the start it is the link that the board file names in "commands", its first if it names none. HAND_OVER gives the
command to any link, or takes it: from every link alike, whoever has it, but only while nothing moves and nothing waits
to. Whatever was sent before it, on any link, is dropped. To ask, and to make the machine safe, is never refused.
"""

from micropython import const

from passo import commands, errors
from passo.commands import DROPPED, Event
from passo.control.feature import Feature

NEVER_WAITS = const(1)  # for others of its link
HARMLESS = const(2)  # it asks, or makes the machine safe: of any link
ANY_LINK = const(4)  # also of a link that does not command
ASKS = const(8)  # the same, if it has no `value` and no `tool`
OF_LENDER = const(16)  # also of the link that has started a stored job, while it runs
STARTS = const(32)  # with a `value` of 0 it starts tool or program: somebody has to be at the machine if the board file says so
# Which of these each kind is. Options add their own kinds.
RIGHTS = {
    commands.BAD: NEVER_WAITS | HARMLESS, commands.HELLO: NEVER_WAITS | HARMLESS, commands.STATUS: NEVER_WAITS | HARMLESS,
    commands.STOP: NEVER_WAITS | HARMLESS, commands.HOLD: NEVER_WAITS | HARMLESS, commands.DOOR: NEVER_WAITS | HARMLESS,
    commands.JOG_CANCEL: NEVER_WAITS | HARMLESS, commands.RESET: NEVER_WAITS | HARMLESS, commands.SYNC: HARMLESS,
    commands.RESUME: NEVER_WAITS | OF_LENDER | STARTS, commands.OVERRIDE: NEVER_WAITS | OF_LENDER, commands.TOGGLE: NEVER_WAITS | OF_LENDER,
    commands.HAND_OVER: NEVER_WAITS | ANY_LINK, commands.SETTING: ASKS,
}  # fmt: skip


class Links(Feature):
    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        self._count = len(board["links"])  # stored jobs come by one more, which is given no command

    def join(self, link):
        """Return the serial line of `link`. A black box overrides this, to record what comes."""
        return link.serial

    def handlers(self):
        return {commands.HAND_OVER: self._hand_over}

    def _hand_over(self, command):
        """Give the command to link `value` (from 1), 0: to the one that asks. Returns 0, NO_SUCH_LINK, or BUSY while anything moves."""
        machine = self._machine
        number = command.value - 1 if command.value else command.link.number
        if not 0 <= number < self._count:
            return errors.NO_SUCH_LINK
        if number != machine.commander:
            if machine.lender >= 0 or machine.state not in ("idle", "alarm", "sleep") or not self._queue.still():
                return errors.BUSY
            machine.hand_over(number)
            machine.tell(Event(DROPPED, None, errors.COMMANDED_ELSEWHERE, command))
            machine.notice(errors.NOTICE_HANDED_OVER)
            alarm = machine.alarm
            machine.guard()
            if machine.alarm and not alarm:
                machine.notice(errors.NOTICE_LOCKED)
        return machine.confirm_command(command)
