"""Analogue power: how strong the tool is while it is on, 0 … 1000, as marks in the step stream.

    power.play(played)       # what plays the words, or feeds it: `level` is now what the output should show

A mark is a word's number and a value; it counts from the moment that word begins. One producer, one consumer, as with
the ring: segments_viper.py puts them, one a segment at most, and dots_viper.py one a dot of a row.

The dots of rows lie in a ring behind the marks: who queues a row puts them, and the feeder gives them back once words have been made
of the row's last step.
"""

from micropython import const

from passo.memory import zeros
from passo.records import *

_A_SEGMENT = const(256)  # more marks than a segment of a line has: it has 255 steps at most


def power_items(marks, dots):
    """Numbers that Power.marks has."""
    return POWER_MARKS + POWER_FIELDS * marks + dots


class Power:
    def __init__(self, marks, dots):
        """Room for so many marks, and dots of rows, powers of two; `dots` 0: there are no rows."""
        self.value = 0  # of the last mark played
        self.level = 0  # what the output should show
        self._dark = False  # that is none, whatever the value, until the next mark
        self._percent = 100
        self._least = 0
        self.marks = made = zeros(power_items(marks, dots))
        made[POWER_MASK] = marks - 1
        made[POWER_WAIT] = marks - _A_SEGMENT if dots else marks
        made[DOTS_AT] = POWER_MARKS + POWER_FIELDS * marks
        made[DOTS_MASK] = max(dots - 1, 0)

    def next(self):
        """The word of the next mark to be played, or -1."""
        marks = self.marks
        tail = marks[POWER_TAIL]
        if tail == marks[POWER_HEAD]:
            return -1
        return marks[POWER_MARKS + POWER_FIELDS * (tail & marks[POWER_MASK]) + POWER_WORD]

    def play(self, played):  # ISR: no allocation
        """`played` words have begun: take up the marks among them."""
        marks = self.marks
        tail = marks[POWER_TAIL]
        if tail == marks[POWER_HEAD]:
            return
        value = self.value
        while tail != marks[POWER_HEAD]:
            at = POWER_MARKS + POWER_FIELDS * (tail & marks[POWER_MASK])
            if (played - 1 - marks[at + POWER_WORD]) & COUNT_MASK >= COUNT_HALF:
                break
            value = marks[at + POWER_LEVEL]
            tail = (tail + 1) & COUNT_MASK
        marks[POWER_TAIL] = tail
        self.set(value)

    def set(self, value):  # ISR: no allocation
        """The power is `value`, whatever the last mark said."""
        self.value = value
        self._dark = False
        self.level = self.scaled(value)

    def show(self, played, on):
        """At a stand, `played` words having begun: the value counts, or the output is off until the next mark."""
        self.play(played)
        self._dark = not on
        self._show()

    def _show(self):
        value = -1
        while value != self.value:  # an interrupt may take up a mark meanwhile
            value = self.value
            self.level = 0 if self._dark else self.scaled(value)

    def adjust(self, percent, least):
        """Every value counts `percent` of itself from now on; those up to `least`, but 0, show as the weakest level,
        those above it share the range that is left (a spindle's lowest speed at the weakest signal)."""
        self._percent = percent
        self._least = least
        self._show()

    def scaled(self, value):  # ISR: no allocation
        if not value:
            return 0
        value = value * self._percent // 100
        if value >= POWER_MOST:
            return POWER_MOST
        if not self._least:
            return value
        return 1 if value <= self._least else 1 + (value - self._least) * (POWER_MOST - 1) // (POWER_MOST - self._least)

    def clear(self):
        """Forget all marks: everything not yet played is dropped. The power is off."""
        marks = self.marks
        marks[POWER_TAIL] = marks[POWER_HEAD]
        marks[DOTS_TAIL] = marks[DOTS_HEAD]
        self.value = self.level = 0
        self._dark = False
