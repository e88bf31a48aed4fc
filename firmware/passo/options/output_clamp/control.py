"""M10 and M11: the output `clamp`, which holds the work. Stop, alarm, reset, door, a lost host and M2 leave it as it is.

Only M11 (M65 P1 of p1_clamp) lets go, at a stand, and never while the spindle turns or is to turn again: first M5.
"""

from passo.commands import SPINDLE_OFF, STATUS_WORDS
from passo.control.switched_output import SwitchedOutput
from passo.options.output_clamp.errors import SPINDLE_TURNS

WORD = ("clamp", "Clamp")


class Clamp(SwitchedOutput):
    def __init__(self, board, machine, queue):
        SwitchedOutput.__init__(self, board, machine, queue, "clamp", True)
        if WORD not in STATUS_WORDS:
            STATUS_WORDS.append(WORD)

    def report(self, report):
        report["clamp"] = self.text()

    def unfit_to_end(self):
        """Return SPINDLE_TURNS if the clamp may not let go now, else 0."""
        turns = self._machine.spindle != SPINDLE_OFF or self._queue.lit()
        return SPINDLE_TURNS if turns else 0
