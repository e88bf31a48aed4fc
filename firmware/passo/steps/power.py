"""Analogue power: how strong the tool is while it is on, 0 … 1000, as marks in the step stream.

    power.play(played)       # what plays the words, or feeds it: `level` is now what the output should show

A mark is a word's number and a value; it counts from the moment that word begins. One producer, one consumer, as with
the ring: segments_viper.py puts them. There is at most one mark a segment, so there is room for them as long as there is for
segments.
"""

from passo.memory import zeros
from passo.records import *


class Power:
    def __init__(self):
        self.value = 0  # of the last mark played
        self.level = 0  # what the output should show
        self._dark = False  # that is none, whatever the value, until the next mark
        self._percent = 100
        self._least = 0
        self.marks = zeros(POWER_MARKS + POWER_FIELDS * POWER_SIZE)

    def next(self):
        """The word of the next mark to be played, or -1."""
        marks = self.marks
        tail = marks[POWER_TAIL]
        if tail == marks[POWER_HEAD]:
            return -1
        return marks[POWER_MARKS + POWER_FIELDS * (tail % POWER_SIZE) + POWER_WORD]

    def play(self, played):  # ISR: no allocation
        """`played` words have begun: take up the marks among them."""
        marks = self.marks
        tail = marks[POWER_TAIL]
        if tail == marks[POWER_HEAD]:
            return
        value = self.value
        while tail != marks[POWER_HEAD]:
            at = POWER_MARKS + POWER_FIELDS * (tail % POWER_SIZE)
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
        self.marks[POWER_TAIL] = self.marks[POWER_HEAD]
        self.value = self.level = 0
        self._dark = False
