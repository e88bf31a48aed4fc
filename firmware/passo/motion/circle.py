"""Arcs and helices in integer steps: the walker.

The midpoint circle (J. E. Bresenham, Comm. ACM 20(2), 1977; its midpoint form by M. L. V. Pitteway and J. R. Van Aken): the plane's
dominant axis steps every time, the other when that brings x² + y² − R² nearer to zero. The decision stays within R, so no product reaches
2³⁰ for radii to MAX_RADIUS, and a step is at most half a step off the ideal circle along the minor axis. Centre and start are whole steps,
R is the start's distance; the end is hit by a last short line if need be. A helix's third axis is within one step of linear in the swept
angle (half a step of rounding, and the larger sweep of a diagonal step); if it is itself the dominant axis, within its steps on one and a
half steps of the circle.

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

`left` counts words to the end of the run, 0 only at the arc's end. All may run in an interrupt: no allocation, no integer
of 2³⁰. The kernels are in circle_viper.py.
"""

from array import array

import micropython
from micropython import const

from passo.motion import line
from passo.motion.circle_viper import load, run, walk
from passo.records import *

COARSE = const(13)  # fraction bits of CIRCLE_PATH


def turns_off(cross, dot, over_half):
    """Return the turns (−1, 0 or 1) to add to the angle between start and end in whole steps, which is above 0 and at most a full turn. `cross` and
    `dot`: the products of the two vectors; `over_half`: as of arc.plan()."""
    if dot <= 0 or over_half is None:
        return 0
    if over_half:
        return 1 if cross > 0 else 0
    return 0 if cross > 0 else -1


class Circle:
    """One arc's walker; `made` and the masks `moving` and `negative` as in Line."""

    def __init__(self, axes):
        self.axes = axes
        self.left = self.moving = self.negative = 0
        self.state = array("i", [0] * (CIRCLE_LINE + LINE_RISE + 3 * axes))
        self._line = memoryview(self.state)[CIRCLE_LINE:]
        self._line[LINE_AXES] = axes
        self.made = self._line[LINE_RISE + 2 * axes :]
        self._tail = array("i", [0] * axes)
        self._ending = False  # the tail is being walked

    @micropython.native
    def load(self, plans, first=0):  # ISR: no allocation
        """Stand at the beginning of the arc whose plan is plans[first : first + ARC_FIELDS]."""
        self._ending = False
        load(plans, first, self.state)
        self._run()

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
        """Set up the next run, or the last line; `left` is 0 if there is none."""
        state = self.state
        left = run(state)
        if not left:
            left = self._last_line(state)
        self.left = left
        self.moving = state[CIRCLE_MOVING]
        self.negative = state[CIRCLE_NEGATIVE]

    def _last_line(self, state):  # ISR: no allocation
        """Set up the tail, from the circle to the end: all axes by Bresenham's method."""
        a, b, z = state[ARC_TAIL_A], state[ARC_TAIL_B], state[ARC_TAIL_Z]
        if not (a or b or z):
            return 0
        tail = self._tail
        for axis in range(self.axes):
            tail[axis] = 0
        tail[state[ARC_AXIS_A]] = a
        tail[state[ARC_AXIS_B]] = b
        if z:
            tail[state[ARC_AXIS_Z]] = z
        state[ARC_TAIL_A] = state[ARC_TAIL_B] = state[ARC_TAIL_Z] = 0
        self._ending = True
        words = line.begin(tail, 0, self._line)
        state[CIRCLE_WORDS] = words
        state[ARC_PATH] = max(abs(a), abs(b)) or words
        state[ARC_PATH_FINE] = 0
        state[CIRCLE_PATH] = state[ARC_PATH] << COARSE
        state[CIRCLE_MOVING] = self._line[LINE_MOVING]
        state[CIRCLE_NEGATIVE] = self._line[LINE_NEGATIVE]
        return words
