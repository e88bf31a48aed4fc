"""The limits of a machine's axes (resolution, speed, acceleration, jerk) in the units that block_viper.py computes with, and
how fast a corner may be passed.

    planner.limits(Limits(steps_per_m, speeds, accelerations, junction_deviation))

Lengths are nanometres, speeds nm/s, accelerations nm/s². Speeds count as fractions, of 2²⁸, of `fastest`, which no path
exceeds; their squares as fractions of its square.

The ramp's unit of speed is the block's programmed speed / `top`. `top` is 16 000, so that the square of twice that, the
highest override, stays below 2³⁰; less where steps are more than 2.7 ms apart, so that `span` does. A block slower than
64 units keeps its speed throughout.

The corner between two blocks is passed at most at the speed of junction deviation (S. K. Jeon, 2011): that of a circle
which touches both lines and comes within the deviation of the corner, v² = a·δ·s / (1 − s), s the sine of half the angle
between the lines; a is the weakest axis's acceleration along the change of direction. With t = √(1 − s²), the sine of
half the angle turned through, which is half the length of that change, it is a·δ·s·(1 + s) / t²: nothing cancels out.
"""

from array import array

from passo.motion.integers import isqrt
from passo.records import (
    LIMIT_AXES, LIMIT_CORNER, LIMIT_CORNER_SHIFT, LIMIT_FASTEST, LIMIT_FASTEST_SHIFT, LIMIT_FIELDS, LIMIT_FINEST,
    LIMIT_GAIN, LIMIT_GAIN_SHIFT, LIMIT_SPEED, LIMIT_SPEED_SHIFT, LIMIT_STEP, LIMIT_STRONGEST, LIMIT_STRONGEST_SHIFT,
    LIMIT_TIME, LIMIT_TIME_SHIFT, LIMIT_WHOLE, NM_PER_M, TICKS_PER_S,
)  # fmt: skip

ONE = 1 << 28
_NM_M_40_S = 25_000_000
TOP = 16_000  # the square of twice that is the largest q
MOST = (1 << 29) - 1
BIAS = 1000  # of exponents, so that none is negative


class Limits:
    """The limits of a machine."""

    def __init__(self, steps_per_m, speeds, accelerations, junction_deviation, start_speed=0, jerk=0):
        """`speeds` in nm/s and `accelerations` in nm/s², each axis; the deviation in nm. Four axes at most.

        `start_speed`, nm/s along the path: up to it the machine begins, turns a corner and stops without a ramp.
        `jerk`, nm/s³ along the path: the most change of acceleration in a second; 0: any (options/planning_s_curves).
        """
        self.steps_per_m = list(steps_per_m)
        self.speeds = list(speeds)
        self.accelerations = list(accelerations)
        self.junction_deviation = junction_deviation
        self.jerk = jerk
        self.ready = all([speed > _NM_M_40_S // steps for steps, speed in zip(steps_per_m, speeds)])  # a step of each axis takes 40 s at most
        self.fastest = isqrt(sum([speed * speed for speed in speeds])) + 1
        self.strongest = isqrt(sum([each * each for each in accelerations])) + 1
        self.start = min((start_speed * start_speed << 28) // (self.fastest * self.fastest), ONE - 1)
        self.fields = self._fields()

    def length(self, deltas):
        """Return the length of a vector of steps in nanometres, 1 at least."""
        along = [(deltas[axis] * NM_PER_M << 16) // self.steps_per_m[axis] for axis in range(len(deltas))]
        return (isqrt(sum([part * part for part in along])) >> 16) or 1

    def part(self, speed):
        """Return `speed`, in nm/s, as a fraction of 2²⁸ of `fastest`, 1 at least."""
        return (speed << 28) // self.fastest or 1

    def _fields(self):
        """Return LIMIT_… of records.py, for plan_block(): an array of numbers, and of short floats as two of them each."""
        fields = array("i", bytearray(4 * LIMIT_FIELDS))
        axes = len(self.steps_per_m)
        finest = 0
        while (NM_PER_M << finest + 1) // min(self.steps_per_m) < ONE:
            finest += 1
        squared = self.fastest * self.fastest
        fields[LIMIT_AXES] = axes
        fields[LIMIT_FINEST] = BIAS + finest - 14
        fields[LIMIT_SPEED], fields[LIMIT_SPEED_SHIFT] = short_float(TICKS_PER_S << 28, self.fastest, 28)
        fields[LIMIT_GAIN], fields[LIMIT_GAIN_SHIFT] = short_float(2 * self.strongest << 28, squared, 15)  # gain
        fields[LIMIT_TIME], fields[LIMIT_TIME_SHIFT] = short_float(TICKS_PER_S * self.fastest, self.strongest, 15)  # time
        fields[LIMIT_CORNER], fields[LIMIT_CORNER_SHIFT] = short_float(self.strongest * self.junction_deviation, squared, 15)  # corner
        fields[LIMIT_WHOLE] = self.fastest if self.fastest < 1 << 30 else 0
        for axis in range(axes):
            fields[LIMIT_STEP + axis] = (NM_PER_M << finest) // self.steps_per_m[axis]
            fields[LIMIT_FASTEST + axis], shift = short_float(self.speeds[axis] << 28, self.fastest, 29)
            fields[LIMIT_FASTEST_SHIFT + axis] = shift + 15
            fields[LIMIT_STRONGEST + axis], shift = short_float(self.accelerations[axis] << 28, self.strongest, 29)
            fields[LIMIT_STRONGEST_SHIFT + axis] = shift + 15
        return fields


def short_float(value, by, bits):
    """Return (m, BIAS + e) with m · 2ᵉ next to value / by from below and m of `bits` bits; (0, BIAS) for 0."""
    if not value:
        return 0, BIAS
    shift = BIAS
    while value >= by << bits:
        by <<= 1
        shift += 1
    while value < by << (bits - 1):
        value <<= 1
        shift -= 1
    return value // by, shift
