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
from micropython import const

MAX_STEPS = const(2_097_151)  # 2²¹ − 1
MAX_RUN = const(255)  # most steps one walk() may take: rise · MAX_RUN stays below 2³⁰


class Line:
    """One line's walker: `total` dominant steps, `left` of them to come; masks of the axes `moving`, and `negative`."""

    def __init__(self, axes):
        self.axes = axes
        self.total = self.left = self.moving = self.negative = 0
        self.made = array("i", [0] * axes)  # signed steps of each axis since the feeder last cleared them
        self._deltas = array("i", [0] * axes)
        self._decision = array("i", [0] * axes)
        self._dominant = 0

    def begin(self, deltas):
        """Start on the vector `deltas`, in steps. Raises ValueError above MAX_STEPS."""
        total = 0
        moving = negative = 0
        for axis in range(self.axes):
            steps = deltas[axis]
            if steps:
                moving |= 1 << axis
            if steps < 0:
                negative |= 1 << axis
                steps = -steps
            if steps > total:
                total = steps
                self._dominant = axis
            self._deltas[axis] = steps
        if total > MAX_STEPS:
            raise ValueError("a line of more than %d steps" % MAX_STEPS)
        self.total = self.left = total
        self.moving = moving
        self.negative = negative
        for axis in range(self.axes):
            self._decision[axis] = 2 * self._deltas[axis] - total

    def seek(self, index):
        """Stand before dominant step `index` (0 … total), as if that many had been walked."""
        if not 0 <= index <= self.total:
            raise ValueError("no step %d in a line of %d" % (index, self.total))
        self.left = self.total - index
        for axis in range(self.axes):
            rise = 2 * self._deltas[axis]
            self._decision[axis] = rise * (index + 1) - self.total - 2 * self.total * self._steps(axis, index)

    def offset(self, axis, index):
        """Signed steps of `axis` after `index` dominant steps: the line's place in closed form."""
        steps = self._steps(axis, index)
        return -steps if self.negative >> axis & 1 else steps

    def _steps(self, axis, index):
        if not self.total:
            return 0
        return (2 * self._deltas[axis] * index + self.total - 1) // (2 * self.total)

    def walk(self, out, at, count):  # ISR: no allocation
        """Write the masks of the next `count` (≤ left, ≤ MAX_RUN) dominant steps to out[at:]; add them to `made`."""
        dominant = self._dominant
        fall = 2 * self.total
        for i in range(at, at + count):
            out[i] = 1 << dominant
        for axis in range(self.axes):
            rise = 2 * self._deltas[axis]
            steps = count
            if axis != dominant:
                steps = 0
                if rise:
                    steps = self._walk_minor(out, at, count, axis, rise, fall)
            self.made[axis] += -steps if self.negative >> axis & 1 else steps
        self.left -= count

    def _walk_minor(self, out, at, count, axis, rise, fall):  # ISR: no allocation
        bit = 1 << axis
        before = decision = self._decision[axis]
        for i in range(at, at + count):
            if decision > 0:
                out[i] |= bit
                decision -= fall
            decision += rise
        self._decision[axis] = decision
        return (rise * count + before - decision) // fall
