"""The event log: the last refusals and alarms by number, for every status report and for later questions."""

from array import array

from micropython import const

_SIZE = const(32)


class Log:
    """Takes its memory at the start: entries made one by one would lie where large pieces are wanted later, and stay there."""

    def __init__(self, clock):
        """`clock()`: machine milliseconds."""
        self._clock = clock
        self._numbers = array("i", bytearray(4 * 2 * _SIZE))  # of each entry: machine milliseconds, number
        self._who = [""] * _SIZE
        self.count = 0  # entries since the start
        self.last = 0  # the latest number nobody has read; 0: none
        self.pins = None  # a function that returns the counts of inputs that forbid motion; None: there is none
        self.counts = {}  # of each number: how many times since the start

    def add(self, number, who=None):
        """Add an entry, in place of the oldest of 32. `who`: the link or input it came from."""
        index = self.count % _SIZE
        self._numbers[2 * index] = self._clock()
        self._numbers[2 * index + 1] = number
        self._who[index] = who
        self.count += 1
        self.counts[number] = self.counts.get(number, 0) + 1
        self.last = number

    @property
    def entries(self):
        """[(machine milliseconds, number, who)], the oldest first, 32 at most."""
        return [self._entry_at(count % _SIZE) for count in range(max(self.count - _SIZE, 0), self.count)]

    def newest(self):
        """Return the last entry, (machine milliseconds, number, who); only if `count` is above 0."""
        return self._entry_at((self.count - 1) % _SIZE)

    def _entry_at(self, index):
        """Return (machine milliseconds, number, who) of a row of the ring."""
        return self._numbers[2 * index], self._numbers[2 * index + 1], self._who[index]
