"""Which of several links may command: one at a time, so that two programs never pull at the same machine.

    links.refusal(command)      # 0, or errors.COMMANDED_ELSEWHERE

At the start it is the link that the board file names in "commands", its first where it names none. HAND_OVER gives the
command to any link, or takes it: from every link alike, whoever has it, but only while nothing moves and nothing waits
to. Whatever was sent before it, on any link, is dropped. To ask, and to make the machine safe, is never refused.
"""

import micropython

from passo import commands, errors
from passo.commands import DROPPED, Event

HARMLESS = (
    commands.BAD, commands.HELLO, commands.STATUS, commands.SYNC,
    commands.STOP, commands.HOLD, commands.DOOR, commands.JOG_CANCEL, commands.REST, commands.RESET,
)  # fmt: skip
_AT_REST = ("idle", "alarm", "sleep")


class Links:
    def __init__(self, board, machine):
        """`machine`: the controller; see its face towards its parts."""
        self.names = [link["name"] for link in board["links"]]
        self.commander = self.names.index(board["commands"] or self.names[0])
        self.speaker = self.commander  # whose bytes are being understood; set by the app
        self._machine = machine
        self.wary = 0  # mask of the links that move nothing until the machine is homed or unlocked; 0: it has been, or worse

    def lock(self, name):
        """Link `name` moves nothing from the start on, before the machine is homed or unlocked. Others may."""
        self.wary |= 1 << self.names.index(name)
        self._guard()

    def _guard(self):
        machine = self._machine
        if self.wary and machine.alarm in (0, errors.ALARM_LOCKED):
            machine.alarm = errors.ALARM_LOCKED if self.wary >> self.commander & 1 else 0

    @micropython.native
    def listening(self):
        """True if the link that is being read may command."""
        return self.speaker == self.commander

    def handlers(self):
        return {commands.HAND_OVER: self._hand_over}

    def refusal(self, command):
        """0, or why the command's link may not say this now."""
        link = command.link
        kind = command.kind
        if link is None or link.number == self.commander or kind in HARMLESS or kind == commands.HAND_OVER:
            return 0
        return errors.COMMANDED_ELSEWHERE

    def _hand_over(self, command):
        number = command.value - 1 if command.value else command.link.number
        if not 0 <= number < len(self.names):
            return errors.NO_SUCH_LINK
        machine = self._machine
        if number != self.commander:
            if machine.state not in _AT_REST or not machine.still():
                return errors.BUSY
            self.commander = number
            machine.forget()
            machine.tell(Event(DROPPED, None, errors.COMMANDED_ELSEWHERE, command))
            machine.notice(errors.NOTICE_HANDED_OVER)
            alarm = machine.alarm
            self._guard()
            if machine.alarm and not alarm:
                machine.notice(errors.NOTICE_LOCKED)
        return machine.accepted(command)
