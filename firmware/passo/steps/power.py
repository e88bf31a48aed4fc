"""Analogue power: how strong the tool is while it is on, 0 … 1000, as marks in the step stream.

    power.put(word, 700)     # the feeder: from that word on
    power.play(played)       # what plays the words, or feeds it: `level` is now what the output should show

A mark is a word's number and a value; it counts from the moment that word begins. One producer, one consumer, as with
the ring. There is at most one mark a segment, so there is room for them as long as there is for segments.
"""

from array import array

from micropython import const

_SIZE = const(128)
_COUNT = const(0x1FFFFFFF)
_HALF = const(0x10000000)
FULL = const(1000)


class Power:
    def __init__(self):
        self.value = 0  # of the last mark played
        self.level = 0  # what the output should show
        self._dark = False  # that is none, whatever the value, until the next mark
        self._percent = 100
        self._least = 0
        self.words = array("i", [0] * _SIZE)
        self.values = array("h", [0] * _SIZE)
        self.head = 0  # marks put and marks played, for ever, modulo 2²⁹
        self.tail = 0

    def put(self, word, value):  # ISR: no allocation
        """From the word number `word` on the power is `value`."""
        at = self.head % _SIZE
        self.words[at] = word
        self.values[at] = value
        self.head = (self.head + 1) & _COUNT

    def next(self):
        """The word of the next mark to be played, or -1."""
        return self.words[self.tail % _SIZE] if self.tail != self.head else -1

    def play(self, played):  # ISR: no allocation
        """`played` words have begun: take up the marks among them."""
        tail = self.tail
        if tail == self.head:
            return
        value = self.value
        while tail != self.head and (played - 1 - self.words[tail % _SIZE]) & _COUNT < _HALF:
            value = self.values[tail % _SIZE]
            tail = (tail + 1) & _COUNT
        self.tail = tail
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
        if value >= FULL:
            return FULL
        if not self._least:
            return value
        return 1 if value <= self._least else 1 + (value - self._least) * (FULL - 1) // (FULL - self._least)

    def clear(self):
        """Forget all marks: everything not yet played is dropped. The power is off."""
        self.tail = self.head
        self.set(0)
