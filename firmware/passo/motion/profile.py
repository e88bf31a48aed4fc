"""What a machine's axes can do, and how fast a block may be begun and ended: the terms that measure_viper.py reckons with.

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

from passo.motion.integers import NM_PER_M, isqrt

TICKS_PER_S = 12_500_000  # of steps.word, which this room may not import
ONE = 1 << 28
TOP = 16_000
FASTEST = 32_000  # twice TOP: its square is the largest q
MOST = (1 << 29) - 1
TERMS = 36
BIAS = 1000  # of exponents, so that none is negative

# `work`, between the planner and measure(), look_back().
FEED = 0  # the speed asked for, of 2²⁸; 0: as fast as may be. An arc's, too
GIVEN, GIVEN_SHIFT = 1, 2  # ticks that a line is to last, as a float; 0: its length over its speed. An arc: top
STEPS_SHIFT = 3
IS_ARC = 8
LENGTH, LENGTH_SHIFT = 9, 10  # an arc's, nm as length / 2 ** shift, length of 27 or 28 bits
ALONG, STRENGTH = 11, 12  # an arc's highest speed and acceleration
STEPS = 13  # an arc's path, steps · 2 ** STEPS_SHIFT
SPEED = 14  # after measure(): the speed programmed
LIMITED = 15  # after measure(): 1, the axes cannot go as fast as asked for
HEADING = 16  # direction at the block's beginning, of 2²⁸; a line's measure() finds out
BEFORE = 20  # direction at the end of the block before
THROUGH = 24  # 1: motion goes through from the block before; from here on up to 28, that block's speed and top
STRIDE = 31
SIZE = 32
ALL = 33  # 1: go on where nothing has changed
FACTOR = 34  # squares of the overrides of feed and of rapid motion, of 4096
WORK = 36


class Limits:
    """Of a machine: the axes' resolution, and what each can do."""

    def __init__(self, steps_per_m, speeds, accelerations, junction_deviation, start_speed=0, jerk=0):
        """`speeds` in nm/s and `accelerations` in nm/s², each axis; the deviation in nm. Four axes at most.

        `start_speed`, nm/s along the path: up to it the machine begins, turns a corner and stops without a ramp.
        `jerk`, nm/s³ along the path: what acceleration changes by in a second at most; 0: at once (see smooth.py).
        """
        self.steps_per_m = list(steps_per_m)
        self.speeds = list(speeds)
        self.accelerations = list(accelerations)
        self.junction_deviation = junction_deviation
        self.jerk = jerk
        self.fastest = isqrt(sum([speed * speed for speed in speeds])) + 1
        self.strongest = isqrt(sum([each * each for each in accelerations])) + 1
        self.start = min((start_speed * start_speed << 28) // (self.fastest * self.fastest), ONE - 1)
        self.terms = self._terms()

    def length(self, deltas):
        """Of a vector of steps, in nanometres, 1 at least."""
        along = [(deltas[axis] * NM_PER_M << 16) // self.steps_per_m[axis] for axis in range(len(deltas))]
        return (isqrt(sum([part * part for part in along])) >> 16) or 1

    def part(self, speed):
        """`speed` in nm/s as a fraction of the fastest, 1 at least."""
        return (speed << 28) // self.fastest or 1

    def speed(self, part):
        """The other way round."""
        return part * self.fastest >> 28

    def _terms(self):
        """What measure() wants to know, in an array: a number, or a float as two of them."""
        terms = array("i", bytearray(4 * TERMS))
        axes = len(self.steps_per_m)
        finest = 0
        while (NM_PER_M << finest + 1) // min(self.steps_per_m) < ONE:
            finest += 1
        squared = self.fastest * self.fastest
        terms[0] = axes
        terms[1] = BIAS + finest - 14
        terms[2], terms[3] = floated(TICKS_PER_S << 28, self.fastest, 28)
        terms[4], terms[5] = floated(2 * self.strongest << 28, squared, 15)  # gain
        terms[6], terms[7] = floated(TICKS_PER_S * self.fastest, self.strongest, 15)  # time
        terms[8], terms[9] = floated(self.strongest * self.junction_deviation, squared, 15)  # corner
        for axis in range(axes):
            terms[16 + axis] = (NM_PER_M << finest) // self.steps_per_m[axis]
            terms[20 + axis], shift = floated(self.speeds[axis] << 28, self.fastest, 29)
            terms[24 + axis] = shift + 15
            terms[28 + axis], shift = floated(self.accelerations[axis] << 28, self.strongest, 29)
            terms[32 + axis] = shift + 15
        return terms


def floated(value, by, bits):
    """(m, BIAS + e) with m · 2ᵉ next to value / by from below and m of `bits` bits."""
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
