"""A block: one line or one wait, checked and measured, on its way from the planner to the feeder.

Blocks live in the planner's pool and are filled again and again: nothing is allocated when one is fetched.
"""

from micropython import const

from passo.motion.line import Line

LINE = const(0)
WAIT = const(1)
FREE = const(2)  # axes that run independently of each other


class Block:
    def __init__(self, axes):
        self.line = Line(axes)
        self.kind = WAIT
        self.walker = None  # what the feeder walks: `line`, or the planner's independent axes
        self.tool = False  # the tool bit from this block's first word on
        self.ticks = 0  # WAIT: its length; others: whole ticks a dominant step
        self.ticks_rest = 0  # ticks that remain over all dominant steps, spread evenly
        self.first = 0  # dominant step to begin at: not 0 where an interrupted block is resumed
        self.tag = None  # whatever the controller wants back when the block has been played
