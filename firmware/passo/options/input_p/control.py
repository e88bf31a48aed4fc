"""Waiting for an input, M66: one of those that the board file names p0 … p9.

    M66 P0 L3 Q5        until p0 is active, but 5 s at most

L 0 looks at the input once and needs no Q. L 1 waits until the input becomes active, 2 until it becomes inactive, 3 while it is not active,
4 while it is active. The axes stand meanwhile and keep their current, as for G4. Until the next M66 status reports show the result, as with
grblHAL: `In:1` active, `In:0` inactive, `In:-1` time-out. LinuxCNC keeps it in #5399. A time-out is no error in either.

The main loop looks once a cycle: a change has to last 20 ms to be seen for sure. In a hold, and while the door is open, neither time nor
input counts; if the input has changed by the time the machine goes on, L 1 and 2 take that for a change.
"""

from micropython import const

from passo import commands, errors
from passo.commands import STATUS_WORDS
from passo.control.feature import Feature
from passo.records import COUNT_MASK

_WORD = ("found", "In")  # the result of M66, in reports
_WAYS = const(5)  # to wait, L: odd ones want the input active, 1 and 2 a change


class Inputs(Feature):
    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        if _WORD not in STATUS_WORDS:
            STATUS_WORDS.append(_WORD)
        self._names = [item["name"] for item in board["inputs"]]
        self._found = None
        self._was = False  # the input, as it was in the last cycle
        self._left_ms = 0
        self._looked_ms = 0

    def handlers(self):
        return {commands.CODE + 66: self._begin_wait}

    def busy(self):
        """Return True while M66 waits."""
        return self._machine.busy_with(commands.CODE + 66)

    def report(self, report):
        report["found"] = self._found

    def _begin_wait(self, command):
        """Do M66: check it, and begin to wait. Returns the number of an error, or 0."""
        machine = self._machine
        name = "p%d" % command.value
        if name not in self._names or not 0 <= command.power < _WAYS or command.power and command.feed <= 0:
            return errors.NUMBER_RANGE
        result = machine.gate()
        if result or machine.checking:
            return result or machine.confirm_command(command)
        self._found = None
        self._was = machine.inputs.input(name)
        self._left_ms = command.feed
        self._looked_ms = machine.port.machine_ms()
        return machine.begin(command, self._go_on_waiting)

    def _go_on_waiting(self, now_ms):
        """End the wait if the input is as wanted, or the time is over. In a hold neither counts."""
        machine = self._machine
        passed_ms = (now_ms - self._looked_ms) & COUNT_MASK
        self._looked_ms = now_ms
        if machine.hold:
            return
        command = machine.command
        mode = command.power
        active = machine.inputs.input("p%d" % command.value)
        self._left_ms -= passed_ms
        if not mode or active == mode % 2 and (mode > 2 or active != self._was):
            self._found = int(active)
            machine.finish()
        elif self._left_ms <= 0:
            self._found = -1
            machine.finish()
        self._was = active
