"""Arcs as chords: if the plane's axes differ in steps/mm, and for helices too steep for the circle's walker.

    ellipse = Ellipse(deltas, (0, 1, 2), center, steps_per_m)
    while ellipse.left:
        planner.line(ellipse.chord(), …)

In steps such an arc is part of an ellipse. A chord stays within ¼ step of it before its ends are rounded to whole
steps: the sagitta of a chord of the angle φ is R·(1 − cos φ/2) < R·φ² / 8. The third axis is linear in the swept angle.
Big integers, once a chord.
"""

from passo.motion.circle import turns_off
from passo.motion.arc_speed import shares
from passo.motion.cordic import TURN, arc_length, rotate, vector
from passo.motion.integers import isqrt, length_nm
from passo.records import NM_PER_M


class Ellipse:
    """`left` chords to come, `radius_nm`, and `length_nm` along the arc, the third axis included."""

    def __init__(self, deltas, plane, center, steps_per_m, clockwise=False, turns=0, over_half=None):
        """Vectors are in steps, arguments as of Planner.arc(). An arc too short for a step along it is one chord. If the
        end is not on the circle the radius changes evenly."""
        self._deltas = list(deltas)
        self._a, self._b, third = plane
        self._center = center
        wide, high = steps_per_m[self._b], steps_per_m[self._a]  # brings both axes to one unit
        self._wide, self._high = wide, high
        x, y = -center[0] * wide, -center[1] * high
        end_x, end_y = (deltas[self._a] - center[0]) * wide, (deltas[self._b] - center[1]) * high
        start, radius = vector(x, y)
        sweep = (vector(end_x, end_y)[0] - start) % TURN
        cross = x * end_y - y * end_x
        if clockwise:
            sweep = TURN - sweep
            cross = -cross
        dot = x * end_x + y * end_y
        if not cross and dot > 0:
            sweep = TURN
        sweep += (turns + turns_off(cross, dot, over_half)) * TURN
        if sweep < 0 or not radius or not (end_x or end_y):
            sweep = 0
        # ¼ step for φ = √(2 / R), R in steps of the finer axis.
        steps = radius // min(wide, high) + 1
        angle = arc_length(1 << 20, sweep)
        self._count = (isqrt(angle * angle * steps // 2) >> 20) + 1
        self.left = self._count
        self._x, self._y = x, y
        self._sweep = -sweep if clockwise else sweep
        last_x, last_y = rotate(x, y, self._sweep)
        self._off_x, self._off_y = end_x - last_x, end_y - last_y
        self._before = [0] * len(deltas)
        self.radius_nm = radius * NM_PER_M // (wide * high)
        rise = deltas[third] * NM_PER_M // steps_per_m[third] if third >= 0 else 0
        self.flat_nm = arc_length(self.radius_nm, sweep)
        self.length_nm = isqrt(self.flat_nm * self.flat_nm + rise * rise) if sweep else length_nm(deltas, steps_per_m)

    def inwards(self, accelerations):
        """Return the highest v²/R, in the unit of `accelerations`, at which neither of the plane's two axes exceeds its own of them."""
        end = self._deltas[self._a] - self._center[0], self._deltas[self._b] - self._center[1]
        reach = shares((self._x, self._y), (end[0] * self._wide, end[1] * self._high), abs(self._sweep))
        return min([(strongest << 28) // share for strongest, share in zip(accelerations, reach)])

    def chord(self):
        """Return the next chord, in steps of all axes. The last one ends at `deltas` exactly. Only while `left` > 0."""
        self.left -= 1
        count = self._count
        i = count - self.left
        here = self._deltas
        if self.left:
            x, y = rotate(self._x, self._y, self._sweep * i // count)
            x += self._off_x * i // count
            y += self._off_y * i // count
            here = [2 * delta * i // count + 1 >> 1 for delta in self._deltas]
            here[self._a] = self._center[0] + (2 * x + self._wide) // (2 * self._wide)
            here[self._b] = self._center[1] + (2 * y + self._high) // (2 * self._high)
        chord = [to - at for to, at in zip(here, self._before)]
        self._before = here
        return chord
