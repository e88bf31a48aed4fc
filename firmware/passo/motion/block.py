"""A block: one line, arc or wait, checked and measured, on its way from the planner to the feeder.

The planner keeps its blocks as rows of integers, ROW numbers and the deltas of each axis, because a hundred objects
with two dozen attributes would take twice the memory. A Block is one of these rows unpacked, for the feeder and for
whoever asks what is playing; it is filled again and again, so nothing is allocated when one is fetched.
"""

import micropython
from micropython import const

LINE = const(0)
WAIT = const(1)
FREE = const(2)  # axes that run independently of each other
ARC = const(3)
TRACK = const(4)  # a path written down step by step

COARSE = const(13)  # fraction bits of the lengths that an arc's walker tells the ramp

# A row. Only here and in the planner's passes.
_KIND = const(0)
_TOOL = const(1)
_TICKS = const(2)
_TICKS_REST = const(3)
_FIRST = const(4)
_TAG = const(5)
_RAPID = const(6)
_TOP = const(7)
_LIMIT = const(8)
_GAIN = const(9)
_SPAN = const(10)
_TIME = const(11)
_TIME_SHIFT = const(12)
_RATIO = const(13)
_RATIO_SHIFT = const(14)
_LEAVE = const(15)
_POWER = const(16)
_DYNAMIC = const(17)
ROW = const(18)  # then the line's signed steps, one number an axis


class Block:
    def __init__(self):
        self.kind = WAIT
        self.walker = None  # what the feeder walks: the planner's line or circle, independent axes, a track's walker
        self.tool = 0  # the tool bit from this block's first word on
        self.ticks = 0  # WAIT: its length; others: whole ticks a dominant step, of an arc: a step of path
        self.ticks_rest = 0  # LINE: ticks that remain over all dominant steps, spread evenly; ARC: 128ths of a tick
        self.first = 0  # dominant step to begin at: not 0 where an interrupted block is resumed; TRACK: place
        self.tag = 0  # a number that the controller wants back when the block has been played
        self.power = 0  # of the tool, 0 … 1000, at the programmed speed
        self.dynamic = 0  # 1: power in proportion to the speed
        self.rapid = 0  # 1: the override for rapid motion counts, not that for the feed
        # Speed, in the block's own unit, which is the programmed speed / top; q is its square (profile.py).
        self.top = 0
        self.limit = 0  # never above, whatever the override says
        self.gain = 0  # q a dominant step; 0: no acceleration, the programmed speed from first to last
        self.span = 0  # ticks a step · 2 · top
        self.time = self.time_shift = 0  # ticks a unit of speed takes: time / 2 ** time_shift
        self.ratio = self.ratio_shift = 0  # from the unit of the block before: ratio / 2 ** ratio_shift
        self.leave = 0  # q at the end, as planned
        self.speed = 0  # as programmed, in nm/s; only where the main loop asks

    @micropython.native
    def load(self, rows, at):  # ISR: no allocation
        """Unpack the row that begins at rows[at]; the walker is the planner's affair."""
        self.kind = rows[at + _KIND]
        self.tool = rows[at + _TOOL]
        self.ticks = rows[at + _TICKS]
        self.ticks_rest = rows[at + _TICKS_REST]
        self.first = rows[at + _FIRST]
        self.tag = rows[at + _TAG]
        self.rapid = rows[at + _RAPID]
        self.top = rows[at + _TOP]
        self.limit = rows[at + _LIMIT]
        self.gain = rows[at + _GAIN]
        self.span = rows[at + _SPAN]
        self.time = rows[at + _TIME]
        self.time_shift = rows[at + _TIME_SHIFT]
        self.ratio = rows[at + _RATIO]
        self.ratio_shift = rows[at + _RATIO_SHIFT]
        self.leave = rows[at + _LEAVE]
        self.power = rows[at + _POWER]
        self.dynamic = rows[at + _DYNAMIC]

    @micropython.native
    def store(self, rows, at):
        """Pack it into the row that begins at rows[at]."""
        rows[at + _KIND] = self.kind
        rows[at + _TOOL] = self.tool
        rows[at + _TICKS] = self.ticks
        rows[at + _TICKS_REST] = self.ticks_rest
        rows[at + _FIRST] = self.first
        rows[at + _TAG] = self.tag
        rows[at + _RAPID] = self.rapid
        rows[at + _TOP] = self.top
        rows[at + _LIMIT] = self.limit
        rows[at + _GAIN] = self.gain
        rows[at + _SPAN] = self.span
        rows[at + _TIME] = self.time
        rows[at + _TIME_SHIFT] = self.time_shift
        rows[at + _RATIO] = self.ratio
        rows[at + _RATIO_SHIFT] = self.ratio_shift
        rows[at + _LEAVE] = self.leave
        rows[at + _POWER] = self.power
        rows[at + _DYNAMIC] = self.dynamic


def set_leave(rows, at, leave):
    """Change how the block of a row is to be left."""
    rows[at + _LEAVE] = leave


def leave_of(rows, at):
    """How the block of a row is to be left."""
    return rows[at + _LEAVE]
