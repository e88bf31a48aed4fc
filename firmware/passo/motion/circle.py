"""Arcs and helices in integer steps: the walker.

The midpoint circle (J. E. Bresenham, Comm. ACM 20(2), 1977; its midpoint form by M. L. V. Pitteway and J. R. Van Aken):
the plane's dominant axis steps every time, the other when that brings x² + y² − R² nearer to zero. The decision stays
within R, so no product reaches 2³⁰ for radii to MAX_RADIUS, and a step is at most half a step off the ideal circle along
the minor axis. Centre and start are whole steps, R is the start's distance; the end is hit by a last short line if need be.
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

from passo.motion.arc_plan import (
    D, DIAGONAL, E, FINE, LEADS, PATH, PATH_FINE, PLAN, REGION, STEPS, TAIL_A, TAIL_B, TAIL_Z, U, W, Z_HIGH, Z_LOW, Z_STEPS,
)
from passo.motion.block import COARSE
from passo.motion.circle_run import Run
from passo.motion.circle_viper import length, root, straight
from passo.motion.line import MAX_RUN

_ONE = const(1 << 20)
_Z_BITS = const(21)
_Z_ONE = const(1 << 21)


class Circle(Run):
    """One arc's walker; `made` and the masks `moving` and `negative` as in Line."""

    def __init__(self, axes):
        Run.__init__(self, axes)
        self.to_go = self.fine = 0  # path from the run's beginning to the arc's end: to_go − fine / 2²⁰
        self.total = 0  # steps of the circle and of the last line
        self._steps = self._z = self._z_sum = self._sixty_fourths = self._tail = self._used = self._next = 0

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
        count = min(straight(plan, u, self._w), self._steps)
        before = self._next
        if u <= -plan[E]:
            long = plan[DIAGONAL]
            near = root(plan, u, self._w, self._error, 1)
            if before < 0:
                before = long
        else:
            near = root(plan, u, self._w, self._error, 0)
            if before < 0:
                before = length(plan, near, u, 1)
            long = length(plan, near, u, count)
            near = plan[PLAN] - near
        if u + count >= plan[D]:
            self._next = plan[DIAGONAL]
        else:
            self._next = length(plan, near, u + count, 1)
        self._steps -= count
        # A word's time passes after its step: a run lasts from its first step to the first one of the next. Where the
        # third axis leads, time is its own.
        self._used = long
        if plan[Z_HIGH] < LEADS:
            self._used += self._next - before
        self._begin(count, self._climb(count, long), self._used)

    def _run_tail(self):  # ISR: no allocation
        """The last short line, from the circle to the end, where there is one."""
        self.left = 0
        if not self._tail:
            return
        self._tail = 0
        self._begin_tail()
        self.to_go = self.path >> COARSE
        self.fine = 0

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
