"""Which of several links may command: one at a time, so that two programs never pull at the same machine.

At the start it is the link that the board file names in "commands", its first if it names none. HAND_OVER gives the
command to any link, or takes it: from every link alike, whoever has it, but only while nothing moves and nothing waits
to. Whatever was sent before it, on any link, is dropped. To ask, and to make the machine safe, is never refused.
"""

from passo import commands, errors
from passo.commands import DROPPED, Event
from passo.control.feature import Feature


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
