"""A block: one line, arc or wait, checked and measured, on its way from the planner to the feeder.

The planner keeps its blocks as rows of integers, ROW numbers and the deltas of each axis, because a hundred objects
with two dozen attributes would take twice the memory. A Block is one of these rows unpacked, for the feeder and for
whoever asks what is playing; it is filled again and again, so nothing is allocated when one is fetched.
"""

# ruff: noqa: F821

import micropython
from micropython import const

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows

LINE = const(0)
WAIT = const(1)
FREE = const(2)  # axes that run independently of each other
ARC = const(3)
TRACK = const(4)  # a path written down step by step

COARSE = const(13)  # fraction bits of the lengths that an arc's walker tells the ramp

# A row. What is noted as "of 2²⁸" is a fraction of the machine's fastest speed or of its square (profile.py). q is the square
# of a speed in the block's own unit, which is the programmed speed / TOP.
KIND = const(0)
TOOL = const(1)  # the tool bit from this block's first word on
TICKS = const(2)  # WAIT: its length; others: whole ticks a dominant step, of an arc: a step of path
TICKS_REST = const(3)  # LINE: ticks that remain over all dominant steps, spread evenly; ARC: 128ths of a tick
FIRST = const(4)  # dominant step to begin at: not 0 where an interrupted block is resumed; TRACK: place
TAG = const(5)  # a number that the controller wants back when the block has been played
RAPID = const(6)  # 1: the override for rapid motion counts, not that for the feed
TOP = const(7)
LIMIT = const(8)  # never above, whatever the override says
GAIN = const(9)  # q a dominant step; 0: no acceleration, the programmed speed from first to last
SPAN = const(10)  # ticks a step · 2 · TOP
TIME = const(11)  # ticks a unit of speed takes: TIME / 2 ** TIME_SHIFT
TIME_SHIFT = const(12)
RATIO = const(13)
RATIO_SHIFT = const(14)
UNIT = const(15)  # q of a square of 2²⁸: · UNIT / 2 ** UNIT_SHIFT
POWER = const(16)  # of the tool, 0 … 1000, at the programmed speed
DYNAMIC = const(17)  # 1: power in proportion to the speed
SPEED = const(18)  # as programmed, of 2²⁸
SQUARE = const(19)  # its square
CORNER = const(20)  # square of the speed at which the corner at its beginning may be passed
REACH = const(21)  # square of the speed that it can gain or lose
EXIT = const(22)  # square of the speed at its end, as planned
UNIT_SHIFT = const(23)
FASTEST = const(24)  # square of the speed that the axes allow
ROW = const(25)  # then the line's signed steps, one number an axis
_UNIT = const(15)  # the same, known to the compiler
_UNIT_SHIFT = const(23)


class Block:
    """What others than the ramp and the feeder ask of a row, which read it themselves; `start` is the planner's to fill in."""

    def __init__(self):
        self.kind = WAIT
        self.walker = None  # what the feeder walks: the planner's line or circle, independent axes, a track's walker
        self.ticks = self.ticks_rest = self.first = self.tag = self.dynamic = 0
        self.start = 0  # q at which it may be begun and ended without a ramp
        self.rows = None  # where it stands as a row
        self.at = 0

    @micropython.native
    def load(self, rows, at):  # ISR: no allocation
        """Unpack the row that begins at rows[at]; the walker is the planner's affair."""
        self.rows = rows
        self.at = at
        self.kind = rows[at + KIND]
        self.first = rows[at + FIRST]
        self.tag = rows[at + TAG]
        self.dynamic = rows[at + DYNAMIC]
        self.start = 0
        self.ticks = rows[at + TICKS]
        self.ticks_rest = rows[at + TICKS_REST]


@micropython.viper
def q_of(square: int, rows: ptr32, at: int, limit: int) -> int:  # ISR: no allocation
    """q of the square of a speed, in a block's units; `limit` squared at most."""
    unit = rows[at + _UNIT]
    shift = rows[at + _UNIT_SHIFT]
    if shift >> 30 & 1:  # negative, also where it was read into 64 bits
        shift = 0 - ((0 - shift) & 0x3FFFFFFF)
    shift -= 14
    q = (square >> 14) * unit + ((square & 0x3FFF) * unit >> 14)
    most = limit * limit
    if shift < 0:
        if q >= most >> (0 - shift):
            return most
        return q << (0 - shift)
    q >>= shift
    return q if q < most else most
