"""Axes that run independently: each has its own rate, its own count (or none: endless) and its own next-due tick.

Steps that fall due within `least` ticks of each other share a word. An axis's due times are counted from its own
nominal ones, so what sharing moves never accumulates: the mean rate is exact.

    axes = Timed(2, least=50)
    axes.set(0, 100, 12_500, 0, 1)         # 100 steps of x, 1 ms apart
    axes.set(1, ENDLESS, 4_166, 2, 3)      # y for ever, 4166 ⅔ ticks apart
    planner.free(axes, tool=False)

Rates and counts may be changed while it runs; the change is felt at the axis's next step.
"""

from array import array
from micropython import const

from passo.steps.word import HOLD_TICKS

ENDLESS = const(-1)
_SEGMENT_TICKS = const(12_500)


class Timed:
    def __init__(self, axes, least):
        self.axes = axes
        self.least = least
        self.moving = self.negative = 0  # masks of the axes that have been set, and that count down
        self.ticks = 0  # length of the segment that walk() wrote
        self.made = array("i", [0] * axes)  # signed steps since the feeder last cleared them
        self.togo = array("i", [0] * axes)  # steps to come; ENDLESS: no end
        self._due = array("i", [0] * axes)
        self._each = array("i", [0] * axes)
        self._rest = array("i", [0] * axes)
        self._over = array("i", [1] * axes)
        self._carry = array("i", [0] * axes)

    def set(self, axis, steps, each, rest=0, over=1, negative=False):
        """Run `axis` for `steps` (≥ 0 or ENDLESS), a step every each + rest/over ticks (each ≥ 2 · least, < 2²⁹)."""
        if steps < ENDLESS:
            raise ValueError("%d is not a number of steps" % steps)
        if each < 2 * self.least or each >= 0x1FFFFFFF:
            raise ValueError("a step every %d ticks; at least %d" % (each, 2 * self.least))
        if not 0 <= rest < over:
            raise ValueError("rest %d/%d is not below one tick" % (rest, over))
        self.togo[axis] = 0  # an interrupt from here on leaves the axis alone
        self._each[axis] = each
        self._rest[axis] = rest
        self._over[axis] = over
        self._carry[axis] = 0
        if self._due[axis] > each:
            self._due[axis] = each
        self.moving |= 1 << axis
        self.negative = self.negative & ~(1 << axis) | (1 << axis if negative else 0)
        self.togo[axis] = steps

    def active(self):  # ISR: no allocation
        """True while an axis has steps to come, or its last step's interval still runs."""
        for axis in range(self.axes):
            if self.togo[axis] or self._due[axis]:
                return True
        return False

    def walk(self, words, at, room, base, bits):  # ISR: no allocation
        """Write at least one and at most `room` words, about a millisecond, to words[at:]. Returns how many."""
        count = 0
        self.ticks = 0
        while count < room and self.ticks < _SEGMENT_TICKS and self.active():
            mask = 0
            if self._wait() <= self.least:
                mask = self._step()
            gap = self._wait()
            if gap > HOLD_TICKS:
                gap = HOLD_TICKS
            words[at + count] = gap << bits | base | mask
            self._pass(gap)
            count += 1
        return count

    def _wait(self):  # ISR: no allocation
        """Ticks to the next step; when none is to come, to the end of the last interval that runs."""
        soonest = -1
        last = 0
        for axis in range(self.axes):
            due = self._due[axis]
            if self.togo[axis] and (soonest < 0 or due < soonest):
                soonest = due
            if due > last:
                last = due
        return last if soonest < 0 else soonest

    def _step(self):  # ISR: no allocation
        """Step every axis that is due within `least`; returns their mask."""
        mask = 0
        for axis in range(self.axes):
            if self.togo[axis] and self._due[axis] <= self.least:
                mask |= 1 << axis
                if self.togo[axis] > 0:
                    self.togo[axis] -= 1
                self.made[axis] += -1 if self.negative >> axis & 1 else 1
                carry = self._carry[axis] + self._rest[axis]
                due = self._due[axis] + self._each[axis]
                if carry >= self._over[axis]:
                    carry -= self._over[axis]
                    due += 1
                self._carry[axis] = carry
                self._due[axis] = due
        return mask

    def _pass(self, ticks):  # ISR: no allocation
        for axis in range(self.axes):
            due = self._due[axis] - ticks
            self._due[axis] = due if due > 0 else 0
        self.ticks += ticks
