"""STEP/DIR drivers of a machine one axis of which has two motors, one at each side of a gantry.

    drive = GantryDrive(axes=3, axis=0)
    drive.use_motors(2)     # from the next word on only the second motor steps; 3: both
"""

import micropython

from passo.options.gantry.drive_viper import double_steps, tally


class GantryDrive:
    def __init__(self, axes, axis):
        self._axes = axes
        self._axis = axis
        self._motors = 3

    def use_motors(self, motors):
        """Let only the motors of this mask step in all words made from now on: 1 the first, 2 the second."""
        self._motors = motors

    def pin_masks(self, motor):
        """Return (step, direction) of motor 0 or 1, as masks of the pins."""
        bit = 1 << (self._axes if motor else self._axis)
        return bit, bit << self._axes + 1

    @micropython.native
    def apply(self, words, at, count):  # ISR: no allocation
        """Turn words[at : at + count] from the step form into pins; the tool bit and time stay."""
        double_steps(words, at, count, self._axes, self._axis, self._motors)

    @micropython.native
    def tally(self, words, mask, word, until, position):  # ISR: no allocation
        """Add what the words from count `word` to `until` step to `position`; returns how many of them step."""
        return tally(words, mask, word, until, self._axes, self._axis, position)

    def levels(self):
        """Return the pins' levels before the first word: 0."""
        return 0

    def directions(self, word):
        """Return the directions of a word as it was played, in the step form."""
        axes = self._axes
        return (word >> axes + 1 & (1 << axes) - 1) << axes

    def seek(self, position):
        """Do nothing: these motors have no phase here."""


def create(board):
    """Return the GantryDrive of a checked board."""
    return GantryDrive(len(board["axes"]), board["additions"].more_motors[0]["axis"])
