"""A run of an arc: a few steps over which everything is linear, set up for walking and walked.

What a run is, and how one follows the other, is circle.py's affair: `_run()` sets up the next, or leaves `left` at 0.
"""

from array import array
from micropython import const

from passo.motion.arc_plan import AXIS_A, AXIS_B, AXIS_Z, FINE, MIRROR, PLAN, TAIL_A, TAIL_B, TAIL_Z, Z_STEPS
from passo.motion.block import COARSE
from passo.motion.circle_viper import walk

_Z_ONE = const(1 << 21)


class Run:
    """`left` words of it to come."""

    def __init__(self, axes):
        self.axes = axes
        self.left = 0  # words to the end of the run
        self.words = self.path = 0  # of the run: words, and length in 2⁻¹³ steps along the circle
        self._u_axis = self._w_axis = 0  # the dominant axis of the run, and the other
        self._region = self._u = self._w = self._error = self._coarse = 0
        self._count = self._rise = self._fall = self._decision = 0
        self._w_rise = self._w_decision = self._z_rise = self._z_decision = self._z_start = self._z_climb = 0
        self.moving = self.negative = 0
        self.made = array("i", [0] * axes)
        self._plan = array("i", [0] * (PLAN + 1))
        self._after = array("i", [0] * 3)

    def _begin(self, count, z, length):  # ISR: no allocation
        """A run of `count` circle steps and `z` steps of the third axis that lasts as long as `length` of path."""
        plan = self._plan
        words = count if count > z else z
        length += self._coarse
        if length < 0:
            length = 0
        self.path = length >> (FINE - COARSE)
        self._coarse = length & ((1 << (FINE - COARSE)) - 1)
        self.words = self.left = words
        self._count = count
        self._rise = 2 * count
        self._fall = 2 * words
        self._decision = self._rise - words
        self._z_rise = 0
        if z:
            self._z_rise = self._z_climb // words
            self._z_start += self._z_climb % words  # less than 2⁻¹⁰ step: nothing is lost at the end
        odd = self._region & 1
        self._u_axis = plan[AXIS_A] if odd else plan[AXIS_B]
        self._w_axis = plan[AXIS_B] if odd else plan[AXIS_A]
        # ccw: u points to +y −x −y +x, w to +x +y −x −y; w's steps turn round at u = 0; cw mirrors y.
        u_back = self._region in (1, 2)
        w_back = (self._region >= 2) != (self._u >= 0)
        if plan[MIRROR]:
            if odd:
                w_back = not w_back
            else:
                u_back = not u_back
        negative = 0
        if u_back:
            negative |= 1 << self._u_axis
        if w_back:
            negative |= 1 << self._w_axis
        moving = 1 << self._u_axis | 1 << self._w_axis
        if plan[Z_STEPS]:
            moving |= 1 << plan[AXIS_Z]
            if plan[Z_STEPS] < 0:
                negative |= 1 << plan[AXIS_Z]
        self.moving = moving
        self.negative = negative

    def _begin_tail(self):  # ISR: no allocation
        """The last short line, from the circle to the end: all axes by Bresenham's method."""
        plan = self._plan
        a, b, z = plan[TAIL_A], plan[TAIL_B], plan[TAIL_Z]
        words = max(abs(a), abs(b), abs(z))
        self.left = self.words = words
        self.path = (max(abs(a), abs(b)) or words) << COARSE
        self._count = -1
        self._fall = 2 * words
        self._rise, self._decision = 2 * abs(a), 2 * abs(a) - words
        self._w_rise, self._w_decision = 2 * abs(b), 2 * abs(b) - words
        self._z_rise, self._z_decision = 2 * abs(z), 2 * abs(z) - words
        self.moving = self.negative = 0
        for i in range(3):
            delta = plan[TAIL_A + i]
            if delta:
                self.moving |= 1 << plan[i]
                if delta < 0:
                    self.negative |= 1 << plan[i]

    def walk(self, out, at, count):  # ISR: no allocation
        """Write the masks of the next `count` (≤ left, ≤ MAX_RUN) words to out[at:]; add them to `made`."""
        if self._count < 0:
            self._walk_tail(out, at, count)
        elif self._rise == self._fall:
            self._walk_circle(out, at, count)
            if self._z_rise:
                self._walk_third(out, at, count)
        else:
            self._walk_steep(out, at, count)
        self.left -= count
        if not self.left:
            self._run()

    def _add(self, axis, steps):  # ISR: no allocation
        self.made[axis] += -steps if self.negative >> axis & 1 else steps

    def _walk_circle(self, out, at, count):  # ISR: no allocation
        u_bit = 1 << self._u_axis
        after = self._after
        made = walk(out, at, count, self._u, self._w, self._error, u_bit, u_bit | 1 << self._w_axis, after)
        self._u = after[0]
        self._w = after[1]
        self._error = after[2]
        self._add(self._u_axis, count)
        self._add(self._w_axis, made)

    def _walk_third(self, out, at, count):  # ISR: no allocation
        bit = 1 << self._plan[AXIS_Z]
        rise = self._z_rise
        place = self._z_start
        steps = 0
        for i in range(at, at + count):
            place += rise
            if place >= _Z_ONE:
                out[i] |= bit
                place -= _Z_ONE
                steps += 1
        self._z_start = place
        self._add(self._plan[AXIS_Z], steps)

    def _walk_steep(self, out, at, count):  # ISR: no allocation
        """The third axis dominates: it steps every time, and the circle now and then."""
        bit = 1 << self._plan[AXIS_Z]
        decision = self._decision
        for i in range(at, at + count):
            if decision > 0:
                self._walk_circle(out, i, 1)
                out[i] |= bit
                decision -= self._fall
            else:
                out[i] = bit
            decision += self._rise
        self._decision = decision
        self._add(self._plan[AXIS_Z], count)

    def _walk_tail(self, out, at, count):  # ISR: no allocation
        plan = self._plan
        a, b, z = plan[AXIS_A], plan[AXIS_B], plan[AXIS_Z]
        for i in range(at, at + count):
            mask = 0
            if self._decision > 0:
                mask = 1 << a
                self._decision -= self._fall
                self._add(a, 1)
            if self._w_decision > 0:
                mask |= 1 << b
                self._w_decision -= self._fall
                self._add(b, 1)
            if self._z_rise and self._z_decision > 0:
                mask |= 1 << z
                self._z_decision -= self._fall
                self._add(z, 1)
            self._decision += self._rise
            self._w_decision += self._w_rise
            self._z_decision += self._z_rise
            out[i] = mask
