"""Analogue power: how strong the tool is while it is on, 0 … 1000, as marks in the step stream.

    power.play(played)       # what plays the words, or feeds it: `level` is now what the output should show

A mark is a word's number and a value; it counts from the moment that word begins. One producer, one consumer, as with
the ring: segments_viper.py puts them, one a segment at most, and an option one a dot of a row.

The dots of rows lie in a ring behind the marks: queueing a row puts them, and the feeder gives them back once words have been made of the row's last step.

take_marks() and scale() are one text for all interpreters; see motion/block_viper.py. Their values have POWER_FINE bits behind the thousandths.
"""
# Shared with interrupts: power

import micropython
from micropython import const

from passo.arrays import zeros
from passo.records import *

_A_SEGMENT = const(256)  # more marks than a segment of a line has: it has 255 steps at most


@micropython.viper
def take_marks(power: ptr32, played: int) -> int:  # ISR: no allocation
    """Give back the marks that began among `played` words. Returns the value of the last of them; -1: none did."""
    tail = power[POWER_TAIL]
    value = -1
    while tail != power[POWER_HEAD]:
        mark = power[POWER_MARKS + (tail & power[POWER_MASK])]
        if (played - 1 - (mark >> POWER_WORD)) & POWER_WORDS > POWER_WORDS >> 1:
            break
        value = mark & POWER_LEVEL
        tail = (tail + 1) & COUNT_MASK
    power[POWER_TAIL] = tail
    return value


@micropython.viper
def scale(power: ptr32, value: int) -> int:  # ISR: no allocation
    """Return the output's power for a value, both with POWER_FINE bits behind the thousandths: with the override, and a spindle's lowest speed."""
    if value == 0:
        return 0
    value = value * power[POWER_PERCENT] // 100
    least = power[POWER_LEAST]
    if value >= POWER_MOST << POWER_FINE:
        return POWER_MOST << POWER_FINE
    if least == 0:
        return value
    one = 1 << POWER_FINE
    value -= least << POWER_FINE
    return one if value <= 0 else one + value * (POWER_MOST - 1) // (POWER_MOST - least)


def power_items(marks, dots):
    """Return the length of Power.marks with room for `marks` marks and `dots` dots, three a number."""
    return POWER_MARKS + marks + (dots + 2) // 3


class Power:
    def __init__(self, marks, dots):
        """Room for `marks` marks and `dots` dots of rows, powers of two; `dots` 0: there are no rows."""
        self.value = 0  # of the last mark played
        self.level = 0  # the power that the output should show
        self.fine = 0  # the same with POWER_FINE bits behind
        self._dark = False  # that is none, whatever the value, until the next mark
        self.marks = made = zeros(power_items(marks, dots))
        made[POWER_MASK] = marks - 1
        made[POWER_PERCENT] = 100
        made[POWER_WAIT] = marks - _A_SEGMENT if dots else marks
        made[DOTS_AT] = POWER_MARKS + marks
        made[DOTS_MASK] = max(dots - 1, 0)

    def next(self, played):
        """Return the number of the word of the next mark to be played, which is `played` or one of those to come; -1: there is none."""
        marks = self.marks
        tail = marks[POWER_TAIL]
        if tail == marks[POWER_HEAD]:
            return -1
        return played + ((marks[POWER_MARKS + (tail & marks[POWER_MASK])] >> POWER_WORD) - played & POWER_WORDS) & COUNT_MASK

    @micropython.native
    def play(self, played):  # ISR: no allocation
        """Take up the marks among the first `played` words, which have begun. One function, because the feeder's interrupt calls it."""
        marks = self.marks
        value = take_marks(marks, played)
        if value >= 0:
            self.value = value >> POWER_FINE
            self._dark = False
            self.fine = value = scale(marks, value)
            self.level = value >> POWER_FINE

    def set(self, value):  # ISR: no allocation
        """Set the power to `value`, 0 … 1000, whatever the last mark said."""
        self.value = value
        self._dark = False
        self._show()

    def show(self, played, on):
        """Show the value of the last mark at a stand, `played` words having begun; without `on` the output is off until the next mark."""
        self.play(played)
        self._dark = not on
        self._show()

    def _show(self):
        """Bring `level` and `fine` up to `value`. An interrupt may take up a mark meanwhile: then again."""
        value = -1
        while value != self.value:  # an interrupt may take up a mark meanwhile
            value = self.value
            self.fine = 0 if self._dark else scale(self.marks, value << POWER_FINE)
            self.level = self.fine >> POWER_FINE

    def adjust(self, percent, least):
        """Count every value as `percent` of itself from now on. Values up to `least`, but 0, show as the weakest level, those above it share the
        range that is left (a spindle's lowest speed at the weakest signal)."""
        marks = self.marks
        if marks[POWER_PERCENT] != percent or marks[POWER_LEAST] != least:
            marks[POWER_PERCENT] = percent
            marks[POWER_LEAST] = least
            self._show()

    def clear(self):
        """Forget all marks: everything not yet played is dropped. The power is off."""
        marks = self.marks
        marks[POWER_TAIL] = marks[POWER_HEAD]
        marks[DOTS_TAIL] = marks[DOTS_HEAD]
        self.value = self.level = self.fine = 0
        self._dark = False
