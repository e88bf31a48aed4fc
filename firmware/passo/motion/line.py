"""Straight lines in integer steps, for any number of axes, in every octant.

Bresenham's method (IBM Systems Journal 4(1), 1965): the axis with most steps, the dominant one, steps every time; each
other axis carries a decision variable and steps when it is above zero. A decision of exactly zero takes no step, as in
the machines this follows, so a minor axis is never more than half a step off the ideal line.

    line = Line(2)
    line.begin((5, -3))
    line.walk(out, 0, 5)    # out[0:5] are masks: bit 0 a step of x, bit 1 a step of y; line.negative is 0b10

A line has at most MAX_STEPS dominant steps, so that no product here reaches 2³⁰.
"""

from array import array

import micropython
from micropython import const

from passo.motion.line_viper import begin, walk
from passo.records import *

MAX_STEPS = const(2_097_151)  # 2²¹ − 1
MAX_RUN = const(500)  # most steps one walk() may take


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
