"""The letters of the inputs that are active, as a status report has them: XYZ limits, then those of commands.INPUTS and of options."""

from passo.config.board_error import inputs_of
from passo.control.feature import Feature


class Pins(Feature):
    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        names = [item["name"] for item in board["inputs"]]
        self._inputs = machine.inputs
        self._settings = machine.settings
        self._shown = self._inputs.limits + [(letter, name) for name, letter, _, _ in inputs_of(board) if letter and name in names]
        self._levels = self._settings_of = None  # that the text is of
        self._text = ""

    def report(self, report):
        """Add the letters of active inputs, read anew only if a pin or setting has changed."""
        inputs = self._inputs
        levels = inputs.levels()
        if levels != self._levels or self._settings_of != self._settings.version:
            self._levels = levels
            self._settings_of = self._settings.version
            self._read_letters(inputs.read)
        presence = self._machine.presence
        if presence:
            report["pins"] = self._text + ("N" if inputs.input(presence) else "n")
        else:
            report["pins"] = self._text

    def _read_letters(self, read):
        """Set the text of letters from the inputs that are active."""
        self._text = "".join([item[0] for item in self._shown if read(item[1])])
