"""A block: one line, arc or wait, checked and measured, on its way from the planner to the feeder.

Blocks live in the planner's pool and are filled again and again: nothing is allocated when one is fetched.
"""

from micropython import const

from passo.motion.line import Line

LINE = const(0)
WAIT = const(1)
FREE = const(2)  # axes that run independently of each other
ARC = const(3)
TRACK = const(4)  # a path written down step by step

COARSE = const(13)  # fraction bits of the lengths that an arc's walker tells the ramp


class Block:
    def __init__(self, axes):
        self.line = Line(axes)
        self.plan = None  # ARC: what the circle's walker is loaded with; made when first needed
        self.kind = WAIT
        self.walker = None  # what the feeder walks: `line`, the planner's circle, independent axes, a track's walker
        self.tool = False  # the tool bit from this block's first word on
        self.ticks = 0  # WAIT: its length; others: whole ticks a dominant step, of an arc: a step of path
        self.ticks_rest = 0  # LINE: ticks that remain over all dominant steps, spread evenly; ARC: 128ths of a tick
        self.first = 0  # dominant step to begin at: not 0 where an interrupted block is resumed; TRACK: place
        self.tag = None  # whatever the controller wants back when the block has been played
        self.power = 0  # of the tool, 0 … 1000, at the programmed speed
        self.dynamic = False  # power in proportion to the speed
        self.rapid = 0  # 1: the override for rapid motion counts, not that for the feed
        # Speed, in the block's own unit, which is the programmed speed / top; q is its square (profile.py).
        self.top = 0
        self.limit = 0  # never above, whatever the override says
        self.gain = 0  # q a dominant step; 0: no acceleration, the programmed speed from first to last
        self.span = 0  # ticks a step · 2 · top
        self.time = self.time_shift = 0  # ticks a unit of speed takes: time / 2 ** time_shift
        self.ratio = self.ratio_shift = 0  # from the unit of the block before: ratio / 2 ** ratio_shift
        self.leave = 0  # q at the end, as planned
        # For the planner's passes, in nm/s and their squares.
        self.speed = 0
        self.fastest = 0  # what the axes allow here
        self.corner = 0  # square of the speed that the corner at its beginning allows
        self.reach = 0  # square that the whole block can gain or lose
        self.exit = 0
