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

`left` counts words to the end of the run, 0 only at the arc's end. All but seek() and offset() may run in an interrupt; what
every run costs is circle_viper.py's.
"""

from array import array

import micropython
from micropython import const

from passo.motion import line
from passo.motion.arc_plan import AXIS_A, AXIS_B, AXIS_Z, PATH, PATH_FINE, TAIL_A, TAIL_B, TAIL_Z
from passo.motion.block import COARSE
from passo.motion.circle_viper import load, run, walk
from passo.motion.line import MAX_RUN

# A walker's state. It begins with the arc's plan, where REGION, U and W are where it is, STEPS those of the circle to come
# after this run, PATH and PATH_FINE what there is to go from the run's beginning, PATH − PATH_FINE / 2²⁰ steps, and the
# tail is 0 once it is begun. Of the run:
WORDS = const(21)
RUN_PATH = const(22)  # its length in 2⁻¹³ steps along the circle
MOVING = const(23)
NEGATIVE = const(24)
U_AXIS = const(25)  # the dominant axis, and the other
W_AXIS = const(26)
RISE = const(27)  # which of its words are steps of the circle, by Bresenham's method: all, unless the third axis dominates
FALL = const(28)
DECISION = const(29)
Z_RISE = const(30)  # of the third axis a word, 21 fraction bits
PLACE = const(31)  # of it between two steps
# Of the arc:
Z_LEFT = const(32)  # steps of the third axis to come after this run
Z_SUM = const(33)  # its place after the run
Z_OVER = const(34)  # what rounding has left over for it, 2⁻²⁰ of path
ERROR = const(35)  # u² + w² − R²
USED = const(36)  # length of the run, 2⁻²⁰
NEXT = const(37)  # of the step after it; −1: not known yet
REST = const(38)  # what rounding has left over of RUN_PATH, 2⁻²⁰
_LINE = const(39)  # the state of a line's walker, for the tail; here too the steps made are counted


class Circle:
    """One arc's walker; `made` and the masks `moving` and `negative` as in Line."""

    def __init__(self, axes):
        self.axes = axes
        self.left = self.moving = self.negative = 0
        self.state = array("i", [0] * (_LINE + 5 + 3 * axes))
        self._line = memoryview(self.state)[_LINE:]
        self._line[0] = axes
        self.made = self._line[5 + 2 * axes :]
        self._tail = array("i", [0] * axes)
        self._ending = False  # the tail is being walked
        self._plan = None

    @micropython.native
    def load(self, plan):  # ISR: no allocation
        """Stand at the beginning of the arc `plan`."""
        self._plan = plan
        self._ending = False
        load(plan, self.state)
        self._run()

    def seek(self, index):
        """Stand before word `index`, as if that many had been walked. Walks them: main loop only."""
        self.load(self._plan)
        self._skip(index)
        for axis in range(self.axes):
            self.made[axis] = 0

    def offset(self, axis, index):
        """Signed steps of `axis` after `index` words. Walks them, on a walker of its own: main loop only."""
        other = Circle(self.axes)
        other.load(self._plan)
        other._skip(index)
        return other.made[axis]

    def _skip(self, index):
        scratch = array("I", [0] * MAX_RUN)
        while index > 0 and self.left:
            count = min(index, self.left, MAX_RUN)
            self.walk(scratch, 0, count)
            index -= count

    @micropython.native
    def walk(self, out, at, count):  # ISR: no allocation
        """Write the masks of the next `count` (≤ left, ≤ MAX_RUN) words to out[at:]; add them to `made`."""
        left = self.left - count
        self.left = left
        if self._ending:
            line.walk(out, at, count, self._line)
        else:
            walk(out, at, count, self.state)
            if not left:
                self._run()

    @micropython.native
    def _run(self):  # ISR: no allocation
        """Set up the next run, or the last line; `left` stays 0 where there is none."""
        state = self.state
        left = run(state)
        if not left:
            left = self._last_line(state)
        self.left = left
        self.moving = state[MOVING]
        self.negative = state[NEGATIVE]

    def _last_line(self, state):  # ISR: no allocation
        """The tail, from the circle to the end: all axes by Bresenham's method."""
        a, b, z = state[TAIL_A], state[TAIL_B], state[TAIL_Z]
        if not (a or b or z):
            return 0
        tail = self._tail
        for axis in range(self.axes):
            tail[axis] = 0
        tail[state[AXIS_A]] = a
        tail[state[AXIS_B]] = b
        if z:
            tail[state[AXIS_Z]] = z
        state[TAIL_A] = state[TAIL_B] = state[TAIL_Z] = 0
        self._ending = True
        words = line.begin(tail, 0, self._line)
        state[WORDS] = words
        state[PATH] = max(abs(a), abs(b)) or words
        state[PATH_FINE] = 0
        state[RUN_PATH] = state[PATH] << COARSE
        state[MOVING] = self._line[4]
        state[NEGATIVE] = self._line[3]
        return words
