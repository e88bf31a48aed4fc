"""Arcs and helices in integer steps: the walker.

The midpoint circle (J. E. Bresenham, Comm. ACM 20(2), 1977; its midpoint form by M. L. V. Pitteway and J. R. Van Aken):
the plane's dominant axis steps every time, the other when that brings x² + y² − R² nearer to zero. The decision stays
within R, so no product reaches 2³⁰ for radii to MAX_RADIUS, and a step is at most half a step off the ideal circle
along the
minor axis. Centre and start are whole steps, R is the start's distance; the end is hit by a last short line if need be.
A helix's third axis is within one step of linear in the swept angle (half a step of rounding, and what a diagonal step
sweeps more than another), where it is itself the dominant axis within what it does on one and a half steps of the circle.

The circle is seen as four regions, each a quarter about an axis direction. In a region the path is `u`, the dominant
axis, counting up from −E to D, and `w`, the other axis, growing while u < 0 and shrinking after it. D is the last whole
step inside the diagonal, E the step of the other axis there.

                 w                     ccw: region 0 right (u = y, w = x), 1 top (u = −x, w = y),
           . - - | - - .                    2 left (u = −y, w = −x), 3 bottom (u = x, w = −y)
        E .      |      . D            cw: the same with y mirrored

The arc is walked in *runs*: a few steps over which everything is linear, the third axis and time included. A run ends
where a minor axis turns round (u = 0), before and after a diagonal, and where the path's slope would have changed the
length of a step by 0.8 %. Its length is that of the true arc between its ends, 2R·atan(k / (w₁ + w₂)), to 2⁻²⁰.
Runs follow from the geometry alone: speed, hold and resume never change the path.

    circle = Circle(3)
    circle.load(plan)         # from arc.plan()
    while circle.left:
        circle.walk(out, 0, min(circle.left, MAX_RUN))

`left` counts words to the end of the run, 0 only at the arc's end. All but seek() may run in an interrupt.
"""

from array import array
from micropython import const

from passo.motion.block import COARSE
from passo.motion.integers import divide
from passo.motion.line import MAX_RUN

MAX_RADIUS = const(0x100000)  # 2²⁰ steps
MAX_SLOPE = const(128)  # most steps of the third axis along one step of the circle
LEADS = const(22_938)  # Z_HIGH from which the third axis dominates somewhere: 0.7 steps a step
FINE = const(20)  # fraction bits of a length here
_LONGEST = const(255)  # most words of a run, so that no product here reaches 2³⁰
_ONE = const(1 << 20)
_Z_BITS = const(21)
_Z_ONE = const(1 << 21)

# The plan: what arc.plan() works out for the walker, small integers only.
PLAN = const(21)
AXIS_A, AXIS_B, AXIS_Z, MIRROR, REGION, U, W = 0, 1, 2, 3, 4, 5, 6
RADIUS, SHIFT, D, E, STEPS, DIAGONAL = 7, 8, 9, 10, 11, 12
Z_STEPS, Z_HIGH, Z_LOW, TAIL_A, TAIL_B, TAIL_Z, PATH = 13, 14, 15, 16, 17, 18, 19
PATH_FINE = 20


class Circle:
    """One arc's walker; `made` and the masks `moving` and `negative` as in Line."""

    def __init__(self, axes):
        self.axes = axes
        self.left = 0  # words to the end of the run
        self.words = self.path = 0  # of the run: words, and length in 2⁻¹³ steps along the circle
        self.to_go = self.fine = 0  # path from the run's beginning to the arc's end: to_go − fine / 2²⁰
        self.total = 0  # steps of the circle and of the last line
        self._u_axis = self._w_axis = 0  # the dominant axis of the run, and the other
        self.moving = self.negative = 0
        self.made = array("i", [0] * axes)
        self._plan = array("i", [0] * PLAN)

    def load(self, plan):  # ISR: no allocation
        """Stand at the beginning of the arc `plan`."""
        mine = self._plan
        for i in range(PLAN):
            mine[i] = plan[i]
        self._region = mine[REGION]
        self._u = mine[U]
        self._w = mine[W]
        self._error = 0  # u² + w² − R²
        self._steps = mine[STEPS]  # circle steps to come after this run
        self._z = abs(mine[Z_STEPS])  # steps of the third axis to come after this run
        self._z_sum = _Z_ONE >> 1
        self._sixty_fourths = self._coarse = 0  # what rounding has left over
        self._tail = mine[TAIL_A] or mine[TAIL_B] or mine[TAIL_Z]
        tail = max(abs(mine[TAIL_A]), abs(mine[TAIL_B]), abs(mine[TAIL_Z]))
        self.total = mine[STEPS] + tail
        self.to_go = mine[PATH] + 1
        self.fine = _ONE - mine[PATH_FINE]
        self._used = 0  # length of the run before, 2⁻²⁰
        self._next = -1  # length of the next step: not known yet
        self._run()

    def seek(self, index):
        """Stand before word `index`, as if that many had been walked. Walks them: main loop only."""
        scratch = array("I", [0] * MAX_RUN)
        self.load(array("i", self._plan))
        while index > 0 and self.left:
            count = min(index, self.left, MAX_RUN)
            self.walk(scratch, 0, count)
            index -= count
        for axis in range(self.axes):
            self.made[axis] = 0

    def offset(self, axis, index):
        """Signed steps of `axis` after `index` words. Walks them, on a walker of its own: main loop only."""
        other = Circle(self.axes)
        other.load(self._plan)
        scratch = array("I", [0] * MAX_RUN)
        while index > 0 and other.left:
            count = min(index, other.left, MAX_RUN)
            other.walk(scratch, 0, count)
            index -= count
        return other.made[axis]

    def last(self):  # ISR: no allocation
        """True in the arc's last run."""
        return not self._steps and not self._tail

    # --- planning a run

    def _run(self):  # ISR: no allocation
        """Set up the next run; `left` stays 0 where there is none."""
        plan = self._plan
        self.fine += self._used
        self.to_go -= self.fine >> FINE
        self.fine &= _ONE - 1
        self._used = 0
        if not self._steps:
            self._run_tail()
            return
        if self._u >= plan[D]:  # over the diagonal: the axes change their parts
            self._region = (self._region + 1) & 3
            self._u, self._w = -self._w, self._u
        u = self._u
        count = min(self._straight(u, self._w), self._steps)
        before = self._next
        if u <= -plan[E]:
            length = plan[DIAGONAL]
            root = self._root(1)
            if before < 0:
                before = length
        else:
            root = self._root(0)
            if before < 0:
                before = self._measure(root, u, 1)
            length = self._measure(root, u, count)
            root = self._sum - root
        if u + count >= plan[D]:
            self._next = plan[DIAGONAL]
        else:
            self._next = self._measure(root, u + count, 1)
        self._steps -= count
        # A word's time passes after its step: a run lasts from its first step to the first one of the next. Where the
        # third axis leads, time is its own.
        self._used = length
        if plan[Z_HIGH] < LEADS:
            self._used += self._next - before
        self._begin(count, self._climb(count, length), self._used)

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

    def _run_tail(self):  # ISR: no allocation
        """The last short line, from the circle to the end: the longest axis is walked as u, the others as w and z."""
        self.left = 0
        if not self._tail:
            return
        self._tail = 0
        plan = self._plan
        a, b, z = plan[TAIL_A], plan[TAIL_B], plan[TAIL_Z]
        words = max(abs(a), abs(b), abs(z))
        self.left = self.words = words
        self.to_go = max(abs(a), abs(b)) or words
        self.path = self.to_go << COARSE
        self.fine = 0
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

    def _straight(self, u, w):  # ISR: no allocation
        """How many steps from here may be one run."""
        plan = self._plan
        if u <= -plan[E]:
            return 1
        if u < 0:
            ends = -u
            slope = -u
        else:
            ends = plan[D] - u - 1  # the step onto the diagonal is a run of its own
            slope = u
        if ends < 1:
            return 1
        ratio = (w << 6) // (slope + 1)
        count = _LONGEST
        if ratio < 1024:
            count = 3 * (ratio * w >> 14)  # w² / 85u
        if count > w >> 3:
            count = w >> 3
        steep = plan[Z_HIGH] >> 15  # whole steps of the third axis a step
        if steep and count * (steep + 1) > 320:
            count = 320 // (steep + 1)
        if count > _LONGEST:
            count = _LONGEST
        if u >= 0 and count > 1:  # the slope grows on the way
            if w < 8192:
                most = w * w // (85 * u + 43 * count)
                if count > most:
                    count = most
            else:
                count -= count >> 4
        if count > ends:
            count = ends
        return count if count > 0 else 1

    def _climb(self, count, length):  # ISR: no allocation
        """Steps of the third axis that belong to `count` steps of the circle, `length` (2⁻²⁰) of path: the ratio has 30
        fraction bits, nothing is lost. Over a diagonal a step of the circle may be two long: the third axis makes up for
        it later, so that it costs no word of its own."""
        plan = self._plan
        if not plan[Z_STEPS]:
            return 0
        length += self._sixty_fourths
        part = length >> 14
        self._sixty_fourths = length & 0x3FFF
        climb = part * plan[Z_HIGH] + (part * plan[Z_LOW] >> 15)
        total = self._z_sum + climb
        steps = total >> _Z_BITS
        over = total & (_Z_ONE - 1)
        if steps > self._z or not self._steps:
            climb += (self._z - steps) << _Z_BITS  # the end is exact
            steps = self._z
        elif steps > count and plan[Z_HIGH] < LEADS:
            over = total - (count << _Z_BITS)
            steps = count
        self._z_start = self._z_sum
        self._z_climb = climb
        self._z_sum = over
        self._z -= steps
        return steps

    # --- lengths on the true circle; roots have SHIFT fraction bits

    def _root(self, after):  # ISR: no allocation
        """√(R² − u²), here or one step on, from w and the error: w − error / 2w, less the square of that over 2w."""
        w = self._w
        error = self._error
        if after:
            error += 2 * self._u + 1
            if error + w < 0:
                error += 2 * w + 1
                w += 1
        shift = self._plan[SHIFT]
        if w < 1:
            return 0
        part = (error << (shift - 1)) // w
        root = (w << shift) - part
        if shift > 14:
            part >>= shift - 14
            root -= (part * part // (2 * w)) >> (28 - shift)
        if root > self._plan[RADIUS]:
            root = self._plan[RADIUS]
        return root if root > 0 else 0

    def _measure(self, root, u, count):  # ISR: no allocation
        """Length, in 2⁻²⁰ steps, of the true arc from u to u + count, where √(R² − u²) is `root`.

        Leaves w₁ + w₂ in `_sum`: it is the root of its own equation sum = 2w₁ − count·(2u + count) / sum, which two
        rounds solve to 2·10⁻⁶.
        """
        plan = self._plan
        shift = plan[SHIFT]
        scale = shift - 8  # what makes R a number of 21 bits
        fall = count * (2 * u + count) << scale
        total = 2 * root
        if total < 256:
            total = 256
        for _ in range(2):
            by = total >> 8
            total = 2 * root - divide(fall, by, shift)
            if total > 2 * plan[RADIUS]:
                total = 2 * plan[RADIUS]
            if total < 256:
                total = 256
        self._sum = total
        by = total >> 8
        excess = divide((plan[RADIUS] - (total >> 1)) >> 7, by, FINE)  # R / mean w − 1
        length = (count << FINE) + count * excess
        chord = divide(count << scale, by, 12)
        return length - ((length >> 16) * (chord * chord) // 3 >> 8)

    # --- walking

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
        u = self._u
        w = self._w
        first = w
        error = self._error
        u_bit = 1 << self._u_axis
        both = u_bit | 1 << self._w_axis
        if u < 0:
            for i in range(at, at + count):
                error += 2 * u + 1
                u += 1
                near = error + 2 * w + 1
                if near < -error:
                    error = near
                    w += 1
                    out[i] = both
                else:
                    out[i] = u_bit
        else:
            for i in range(at, at + count):
                error += 2 * u + 1
                u += 1
                near = error - 2 * w + 1
                if -near < error:
                    error = near
                    w -= 1
                    out[i] = both
                else:
                    out[i] = u_bit
        self._u = u
        self._w = w
        self._error = error
        self._add(self._u_axis, count)
        self._add(self._w_axis, abs(w - first))

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
