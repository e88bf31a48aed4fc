"""A block: one line, arc or wait, checked and measured, on its way from the planner to the feeder.

The planner keeps its blocks as rows of integers, ROW_… of records.py and the deltas of each axis, because a hundred objects
with two dozen attributes would take twice the memory.
"""

from micropython import const

LINE = const(0)
WAIT = const(1)
INDEPENDENT = const(2)  # axes that run independently of each other
ARC = const(3)
STEP_PROGRAM = const(4)  # a path written down step by step

COARSE = const(13)  # fraction bits of the lengths that an arc's walker tells the ramp


class Block:
    """The block fetched last. The planner fills it in again and again, so nothing is allocated when one is fetched."""

    def __init__(self, rows):
        self.kind = WAIT
        self.walker = None  # its geometry: the planner's line or circle, independent axes, a step program; a wait has none
        self.start = 0  # q at which it may be begun and ended without a ramp
        self.rows = rows  # its row begins at rows[at]
        self.at = 0
