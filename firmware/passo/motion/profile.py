"""What acceleration makes of a block: limits of its axes along its direction, corner speeds, and the ramp's own units.

Lengths are nanometres, speeds nm/s, accelerations nm/s², directions unit vectors of 2³⁰. Big integers, once a block.

The ramp's unit of speed is the block's programmed speed / `top`. `top` is 16 000, so that the square of twice that, the
highest override, stays below 2³⁰; less where steps are more than 2.7 ms apart, so that `span` does.
"""

from passo.motion.integers import NM_PER_M, isqrt

TICKS_PER_S = 12_500_000  # of steps.word, which this room may not import
ONE = 1 << 30
TOP = 16_000
LEAST_TOP = 64
FASTEST = 32_000  # twice TOP: its square is the largest q
MOST = (1 << 29) - 1
_STRAIGHT = ONE - ONE // 1_000_000  # cosine beyond which two directions are one, or opposite


class Limits:
    """Of a machine: the axes' resolution, and what each can do."""

    def __init__(self, steps_per_m, speeds, accelerations, junction_deviation):
        """`speeds` in nm/s and `accelerations` in nm/s², each axis; the deviation in nm."""
        self.steps_per_m = list(steps_per_m)
        self.speeds = list(speeds)
        self.accelerations = list(accelerations)
        self.junction_deviation = junction_deviation

    def vector(self, deltas):
        """(length, direction) of a vector of steps."""
        along = [(deltas[axis] * NM_PER_M << 16) // self.steps_per_m[axis] for axis in range(len(deltas))]
        length = isqrt(sum([part * part for part in along])) or 1
        return (length >> 16) or 1, [(part << 30) // length for part in along]

    def along(self, limits, direction):
        """The weakest of the axes' `limits`, seen along `direction`."""
        least = 0
        for axis in range(len(direction)):
            part = abs(direction[axis])
            if part:
                here = (limits[axis] << 30) // part
                if not least or here < least:
                    least = here
        return least or 1

    def corner(self, before, after):
        """Square of the speed at which the corner between two directions may be passed.

        Junction deviation (S. K. Jeon, 2011): the speed on a circle that touches both lines and comes within the
        deviation of the corner, v² = a·δ·s / (1 − s), s the sine of half the angle between the lines; a is the weakest
        axis's acceleration along the change of direction. None: there is no corner.
        """
        cosine = sum([before[axis] * after[axis] for axis in range(len(before))]) >> 30
        if cosine > _STRAIGHT:
            return None
        if cosine < -_STRAIGHT:
            return 0
        turn = [after[axis] - before[axis] for axis in range(len(before))]
        size = isqrt(sum([part * part for part in turn])) or 1
        acceleration = self.along(self.accelerations, [(part << 30) // size for part in turn])
        half = isqrt((ONE + cosine) << 29)  # sine of half the angle between the lines, of 2³⁰
        return acceleration * self.junction_deviation * half // (ONE - half)


def set_units(block, steps, ticks, length, fastest, acceleration, before):
    """Fill in the ramp's numbers of `block`: `steps` of path, in 2⁻¹⁰; `ticks` long, `length` nm; `before`: the
    block before or None. Returns the square of the speed that the whole block can gain, in nm²/s².

    `block.speed` is set. A block too slow for the ramp's units keeps its speed throughout.
    """
    top = min(TOP, MOST * steps // (ticks << 10))
    if top < LEAST_TOP:
        block.gain = 0
        return 0
    speed = block.speed
    block.top = top
    block.limit = max(min(FASTEST, 2 * top, top * fastest // speed), 1)
    block.span = (2 * ticks * top << 10) // steps
    block.gain = max(min((2 * acceleration * length * top * top << 10) // (steps * speed * speed), MOST), 2)
    block.time, block.time_shift = scaled(TICKS_PER_S * speed, top * acceleration, 15)
    block.ratio = block.ratio_shift = 0
    if before is not None and before.gain:
        block.ratio, block.ratio_shift = scaled(before.speed * top, before.top * speed, 14)
    return block.gain * steps * speed * speed // (top * top << 10)


def scaled(value, by, bits):
    """(m, e) with m / 2ᵉ next to value / by from below and m of `bits` bits; e may be negative."""
    shift = 0
    while value >= by << bits:
        by <<= 1
        shift -= 1
    while value < by << (bits - 1):
        value <<= 1
        shift += 1
    return value // by, shift


def square_in_units(block, square, speed):
    """q of a square in nm²/s², in the units of `block`, programmed for `speed`, from below."""
    q = square * block.top * block.top // (speed * speed)
    return min(q, block.limit * block.limit)
