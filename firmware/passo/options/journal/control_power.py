"""The input that says that the power fails: an alarm at once, in which the journal writes down what is known."""

from passo import errors
from passo.control.feature import Feature


class PowerFail(Feature):
    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        self._input = board["journal"]["power"]

    def look(self, now_ms):
        """Raise an alarm as soon as the input says that the power fails."""
        machine = self._machine
        if not machine.alarm and machine.inputs.input(self._input):
            machine.raise_alarm(errors.ALARM_POWER, self._input)
