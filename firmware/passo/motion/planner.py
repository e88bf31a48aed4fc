"""The queue of blocks between the controller and the feeder, and the rule by which they are let go.

    retired          fetched                     added          all count for ever, modulo 2²⁹
       |  being played  |  look-ahead: may change  |
    . [b b b b b b b b b b b b b b b b b b b b b b b] . .

A block is released to the feeder only when the look-ahead is full, or everything queued has been flushed: then the same
job gives the same ticks however fast it arrived. A fetched block stays in its place until its last word has been
played, because a hold may come back to it.

The main loop adds and flushes; the feeder, in an interrupt, fetches and retires.
"""

from micropython import const

from passo.motion.block import FREE, LINE, WAIT, Block

LOOK_AHEAD = const(64)
IN_FLIGHT = const(64)
_COUNT = const(0x1FFFFFFF)
LONGEST_TICKS = const(0x1FFFFFFF)  # of one wait, or of one dominant step: 43 s


class Planner:
    def __init__(self, axes):
        self.axes = axes
        self._pool = [Block(axes) for _ in range(LOOK_AHEAD + IN_FLIGHT)]
        self.clear()

    def clear(self):
        """Forget every block. Only while the feeder is stopped."""
        self._added = self._flushed = self._fetched = self._retired = 0

    def room(self):
        """How many more blocks can be queued now."""
        return len(self._pool) - ((self._added - self._retired) & _COUNT)

    def empty(self):
        """True when every block has been played to its last word."""
        return self._added == self._retired

    def line(self, deltas, ticks, tool, tag=None):
        """Queue the line `deltas` (steps), to last `ticks` at its programmed speed. A line of no steps is no block.

        Raises ValueError where it has too many steps, or steps further apart than LONGEST_TICKS.
        """
        block = self._pool[self._added % len(self._pool)]
        line = block.line
        line.begin(deltas)
        if not line.total:
            return
        if ticks // line.total > LONGEST_TICKS:
            raise ValueError("steps more than 43 s apart")
        block.kind = LINE
        block.walker = line
        block.ticks = max(ticks // line.total, 1)
        block.ticks_rest = ticks % line.total
        self._add(block, tool, tag)

    def wait(self, ticks, tool, tag=None):
        """Queue `ticks` (1 … LONGEST_TICKS) without a step, the tool bit as given from their start."""
        block = self._pool[self._added % len(self._pool)]
        block.kind = WAIT
        block.walker = None
        block.ticks = ticks
        block.ticks_rest = 0
        self._add(block, tool, tag)

    def free(self, walker, tool, tag=None):
        """Queue axes that run independently: `walker` is a steps.timed.Timed with its axes set."""
        block = self._pool[self._added % len(self._pool)]
        block.kind = FREE
        block.walker = walker
        self._add(block, tool, tag)

    def _add(self, block, tool, tag):
        block.tool = tool
        block.tag = tag
        block.first = 0
        self._added = (self._added + 1) & _COUNT

    def flush(self):
        """Nothing more is coming for now: release all that is queued."""
        self._flushed = self._added

    def next(self):  # ISR: no allocation
        """The next block released, or None."""
        fetched = self._fetched
        if fetched == self._flushed and (self._added - fetched) & _COUNT < LOOK_AHEAD:
            return None
        if fetched == self._flushed:
            self._flushed = (fetched + 1) & _COUNT
        self._fetched = (fetched + 1) & _COUNT
        return self._pool[fetched % len(self._pool)]

    def retire(self):  # ISR: no allocation
        """The oldest fetched block has been played to its last word."""
        self._retired = (self._retired + 1) & _COUNT

    def playing(self):
        """The oldest block not yet played to its last word, or None."""
        if self._retired == self._fetched:
            return None
        return self._pool[self._retired % len(self._pool)]
