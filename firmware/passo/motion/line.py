"""Straight lines in integer steps, for any number of axes, in every octant; and when they step at constant speed.

Bresenham's method (IBM Systems Journal 4(1), 1965): the axis with most steps, the dominant one, steps every time; each
other axis carries a decision variable and steps when it is above zero. A decision of exactly zero takes no step, as in
the machines this follows, so a minor axis is never more than half a step off the ideal line.

    line = Line(2)
    line.begin((5, -3))
    line.walk(out, 0, 5)    # out[0:5] are masks: bit 0 a step of x, bit 1 a step of y; line.negative is 0b10

A line has at most MAX_STEPS dominant steps, so that no product here reaches 2³⁰.

Steady cuts lines at constant speed into segments of about a millisecond: how many dominant steps, and how many ticks they last.

    ramp.begin(block)
    ramp.cut(rows, at, ramp.state, line.state, left, percent, hold)     # RAMP_STEPS, RAMP_TICKS, RAMP_PACE of ramp.state

A segment is never cut inside a dominant interval: below 1000 steps/s it is one step long. A line's total is exact: the ticks
that do not divide by its steps are spread over all of it. Overrides do not count. ramp.py accelerates. All may run in an
interrupt: no allocation, no integer of 2³⁰.
"""

from array import array

import micropython
from micropython import const

from passo.motion.line_viper import begin, walk
from passo.records import *

MAX_STEPS = const(2_097_151)  # 2²¹ − 1
MAX_RUN = const(500)  # most steps one walk() may take
LONGEST_TICKS = const(0x1FFFFFFF)  # of one wait, or of one dominant step: 43 s


class Line:
    """One line's walker: `total` dominant steps, `left` of them to come; masks of the axes `moving`, and `negative`."""

    def __init__(self, axes):
        self.total = self.left = self.moving = self.negative = 0
        self.state = array("i", [axes] + [0] * (4 + 3 * axes))
        self.made = memoryview(self.state)[LINE_RISE + 2 * axes :]  # signed steps since the feeder last cleared them

    def begin(self, deltas):
        """Start on a vector, in steps. Raises ValueError above MAX_STEPS."""
        self.load(array("i", deltas), 0)
        if self.total > MAX_STEPS:
            raise ValueError("a line of more than %d steps" % MAX_STEPS)

    @micropython.native
    def load(self, rows, at):  # ISR: no allocation
        """Start on the vector rows[at : at + axes] of an array, none above MAX_STEPS."""
        state = self.state
        total = self.total = begin(rows, at, state)
        self.left = total
        self.moving = state[LINE_MOVING]
        self.negative = state[LINE_NEGATIVE]

    @micropython.native
    def walk(self, out, at, count):  # ISR: no allocation
        """Write the masks of the next `count` (≤ left, ≤ MAX_RUN) dominant steps to out[at:]; add them to `made`."""
        walk(out, at, count, self.state)
        self.left -= count


def refuse(result):
    """Raise ValueError for a result of block_viper.plan_block() below 0."""
    if result == -1:
        raise ValueError("steps more than 43 s apart")
    raise ValueError("a line of more than %d steps" % MAX_STEPS)


def dominant(deltas, ticks):
    """Return a line's dominant steps. Raises ValueError if there are too many, or too far apart at constant speed."""
    total = max([abs(delta) for delta in deltas])
    if total > MAX_STEPS:
        refuse(-2)
    if total and ticks // total > LONGEST_TICKS:
        refuse(-1)
    return total


@micropython.native
def cut(rows, at, state, walker, left, percent, hold):  # ISR: no allocation
    """The next segment of the line whose row begins at rows[at], with `left` ≥ 1 dominant steps to come. With `hold` its steps
    are 0: the machine stands."""
    state[RAMP_STEPS] = 0
    state[RAMP_PACE] = -1
    if hold:
        return
    each = rows[at + ROW_TICKS]
    steps = TICKS_PER_MS // each or 1
    if steps > left:
        steps = left
    if steps > MAX_RUN:
        steps = MAX_RUN
    carry = state[RAMP_CARRY] + steps * rows[at + ROW_TICKS_REST]
    state[RAMP_CARRY] = carry % state[RAMP_TOTAL]
    state[RAMP_TICKS] = steps * each + carry // state[RAMP_TOTAL]
    state[RAMP_STEPS] = steps


class Steady:
    """Lines at programmed speed. After cut() the first fields of `state` tell of the segment."""

    def __init__(self):
        self.state = array("i", [0] * STEADY_FIELDS)
        self.cut = cut  # of the block under way: cut(rows, at, state, walker.state, left, percent, hold)
        self.even = cut  # cuts lines at constant speed
        self.take_up = None  # begins an accelerated line: ramp_viper.begin()

    def stall(self):  # ISR: no allocation
        """The machine stands: the next block begins at rest."""
        self.state[RAMP_Q] = self.state[RAMP_V] = 0

    def moving(self):  # ISR: no allocation
        """Return True when the next segment begins at a speed that was reached by acceleration: it could not stand here."""
        return self.state[RAMP_Q] > self.state[RAMP_START]

    def begin(self, block):  # ISR: no allocation
        """Take up `block`, a line."""
        state = self.state
        state[RAMP_Q] = state[RAMP_V] = state[RAMP_CARRY] = 0
        state[RAMP_TOTAL] = block.walker.total
        self.cut = self.even
