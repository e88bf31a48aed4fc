"""An output that codes of G-code switch at a stand: M10 and M11 if they are its own, M64 P and M65 P if its name begins with p0_ … p9_.

The board file's name for it ends in what it is: `vacuum`, `p1_vacuum`. A class of few lines says what switches it off.
"""

from passo import commands, errors
from passo.control.feature import Feature


def output_of(board, what):
    """Return the name of the output that is called so: `vacuum` or p0_vacuum … p9_vacuum."""
    return [item["name"] for item in board["outputs"] if item["name"].rpartition("_")[2] == what][0]


class SwitchedOutput(Feature):
    def __init__(self, board, machine, queue, what, own):
        """`own`: M10 and M11 are this output's."""
        Feature.__init__(self, board, machine, queue)
        self._name = name = output_of(board, what)
        self._own = own
        number = name[1:].partition("_")[0] if name[0] == "p" else ""
        self._number = int(number) if number.isdigit() else -1
        self.on = False

    def handlers(self):
        return {commands.CODE + 10: self._switch_on, commands.CODE + 11: self._switch_off} if self._own else None

    def guard(self, handlers):
        """Put M64 and M65 of this output's number before the handlers of other features."""
        if self._number >= 0:
            for code, handler in ((64, self._switch_on), (65, self._switch_off)):
                handlers[commands.CODE + code] = self._by_number(handler, handlers.get(commands.CODE + code))

    def _by_number(self, own, other):
        """Return a handler: `own` for this output's number, `other` (None: NUMBER_RANGE) for all others."""
        def handle(command):
            if command.value == self._number:
                return own(command)
            return other(command) if other else errors.NUMBER_RANGE

        return handle

    def text(self):
        """Return the status's text: 1 on, 0 off, and the number if M10 and M11 are another output's."""
        return "%d" % self.on + ("" if self._own or self._number < 0 else "P%d" % self._number)

    def _switch_on(self, command):
        return self._switch_to(command, True)

    def _switch_off(self, command):
        return self._switch_to(command, False)

    def _switch_to(self, command, on):
        """Switch the output at a stand. Returns 0, LATER, or an error."""
        machine = self._machine
        result = machine.gate()
        if result or machine.checking:
            return result or machine.confirm_command(command)
        if not on:
            result = self.unfit_to_end()
            if result:
                return result
        self.put(on)
        return machine.confirm_command(command)

    def unfit_to_end(self):
        """Return 0, or the error that forbids to switch it off now."""
        return 0

    def put(self, on):
        """Switch the output now."""
        self.on = on
        self._machine.port.output(self._name, on)
