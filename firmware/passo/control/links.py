"""Which of several links may command: one at a time, so that two programs never pull at the same machine.

    links.refusal(command)      # 0, or errors.COMMANDED_ELSEWHERE

At the start it is the link that the board file names in "commands", its first where it names none. HAND_OVER gives the
command to any link, or takes it: from every link alike, whoever has it, but only while nothing moves and nothing waits
to. To ask, and to make the machine safe, is never refused.
"""

import micropython

from passo.protocols import commands, errors

FREE = (
    commands.BAD, commands.HELLO, commands.STATUS, commands.SYNC, commands.HAND_OVER,
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

    @micropython.native
    def listening(self):
        """True if the link that is being read may command."""
        return self.speaker == self.commander

    def handlers(self):
        return {commands.HAND_OVER: self._hand_over}

    def refusal(self, command):
        """0, or why the command's link may not say this now."""
        link = command.link
        if link is None or link.number == self.commander or command.kind in FREE:
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
            machine.notice(errors.NOTICE_HANDED_OVER)
        return machine.accepted(command)
