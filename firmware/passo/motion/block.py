"""A block: one line, arc or wait, checked and measured, on its way from the planner to the feeder.

The planner keeps its blocks as rows of integers, ROW numbers and the deltas of each axis, because a hundred objects
with two dozen attributes would take twice the memory. A Block is one of these rows unpacked, for the feeder and for
whoever asks what is playing; it is filled again and again, so nothing is allocated when one is fetched.
"""

import micropython
from micropython import const

from passo.records import ROW_DYNAMIC, ROW_FIRST, ROW_KIND, ROW_TAG, ROW_TICKS

LINE = const(0)
WAIT = const(1)
INDEPENDENT = const(2)  # axes that run independently of each other
ARC = const(3)
STEP_PROGRAM = const(4)  # a path written down step by step

COARSE = const(13)  # fraction bits of the lengths that an arc's walker tells the ramp


class Block:
    """A row unpacked. Ramp and feeder read an accelerated row itself; the planner fills in `start`."""

    def __init__(self):
        self.kind = WAIT
        self.walker = None  # its geometry: the planner's line or circle, independent axes, a step program; a wait has none
        self.ticks = self.first = self.tag = self.dynamic = 0
        self.start = 0  # q at which it may be begun and ended without a ramp
        self.rows = None  # its row begins at rows[at]
        self.at = 0

    @micropython.native
    def load(self, rows, at):  # ISR: no allocation
        """Unpack the row that begins at rows[at]; the walker is the planner's affair."""
        self.rows = rows
        self.at = at
        self.kind = rows[at + ROW_KIND]
        self.first = rows[at + ROW_FIRST]
        self.tag = rows[at + ROW_TAG]
        self.dynamic = rows[at + ROW_DYNAMIC]
        self.start = 0
        self.ticks = rows[at + ROW_TICKS]
