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

MAX_STEPS = const(2_097_151)  # 2²¹ − 1
MAX_RUN = const(500)  # most steps one walk() may take

# A walker's state, in one array for the sake of its twin in machine code.
_AXES = const(0)
_DOMINANT = const(1)
_FALL = const(2)  # twice the dominant steps: what a step takes off an axis's decision
_NEGATIVE = const(3)
_RISE = const(4)  # three numbers an axis, axes times the first, then the second, then the third:
#   rise: twice its steps, what every dominant step adds to its decision
#   decision, with the fall added so that it is never negative: a step is due above the fall
#   made: its signed steps since the feeder last cleared them

try:
    from passo.motion.line_viper import walk
except (ImportError, NameError, ValueError):  # an interpreter that has no machine code of its own
    from passo.motion.line_plain import walk


class Line:
    """One line's walker: `total` dominant steps, `left` of them to come; masks of the axes `moving`, and `negative`."""

    def __init__(self, axes):
        self.axes = axes
        self.total = self.left = self.moving = self.negative = 0
        self._deltas = array("i", [0] * axes)
        self._state = array("i", [axes] + [0] * (3 + 3 * axes))
        self.made = memoryview(self._state)[_RISE + 2 * axes :]  # signed steps since the feeder last cleared them

    @micropython.native
    def begin(self, deltas, at=0):  # ISR: no allocation
        """Start on the vector deltas[at : at + axes], in steps. Raises ValueError above MAX_STEPS."""
        state = self._state
        total = dominant = 0
        moving = negative = 0
        for axis in range(self.axes):
            steps = deltas[at + axis]
            if steps:
                moving |= 1 << axis
            if steps < 0:
                negative |= 1 << axis
                steps = -steps
            if steps > total:
                total = steps
                dominant = axis
            self._deltas[axis] = steps
        if total > MAX_STEPS:
            raise ValueError("a line of more than %d steps" % MAX_STEPS)
        self.total = self.left = total
        self.moving = moving
        self.negative = negative
        state[_DOMINANT] = dominant
        state[_FALL] = 2 * total
        state[_NEGATIVE] = negative
        for axis in range(self.axes):
            rise = 2 * self._deltas[axis]
            state[_RISE + axis] = rise
            state[_RISE + self.axes + axis] = rise + total

    def seek(self, index):
        """Stand before dominant step `index` (0 … total), as if that many had been walked."""
        if not 0 <= index <= self.total:
            raise ValueError("no step %d in a line of %d" % (index, self.total))
        self.left = self.total - index
        for axis in range(self.axes):
            decision = 2 * self._deltas[axis] * (index + 1) + self.total - 2 * self.total * self._steps(axis, index)
            self._state[_RISE + self.axes + axis] = decision

    def offset(self, axis, index):
        """Signed steps of `axis` after `index` dominant steps: the line's place in closed form."""
        steps = self._steps(axis, index)
        return -steps if self.negative >> axis & 1 else steps

    def _steps(self, axis, index):
        if not self.total:
            return 0
        return (2 * self._deltas[axis] * index + self.total - 1) // (2 * self.total)

    @micropython.native
    def walk(self, out, at, count):  # ISR: no allocation
        """Write the masks of the next `count` (≤ left, ≤ MAX_RUN) dominant steps to out[at:]; add them to `made`."""
        walk(out, at, count, self._state)
        self.left -= count
