"""The highest speed and acceleration of an arc. plan_block() does this for lines; here with big integers, once an arc.

On a circle an axis has its share of the speed and of the ramp's acceleration, cos φ if its own direction is φ away, and
sin φ of v²/R, which points to the centre. The limits of an arc are the highest that hold from its first step to its last:
a quarter from 30° to 60° of a circle may be 15 % faster than a whole one. Each of the two accelerations alone stays within
every axis's; together they ask no axis for more than √2 of its own, which is what a whole circle at its highest speed does
as it sets out. With an override above 100 % likewise.
"""

from passo.motion.cordic import TURN
from passo.motion.integers import isqrt
from passo.motion.look_ahead_viper import corner
from passo.motion.block_viper import plan_block
from passo.motion.limits import BIAS, MOST, ONE, TOP, short_float
from passo.records import (
    ARC_TAIL_A, ARC_TAIL_B, NM_PER_M, ROW_SPAN, ROW_TICKS, ROW_TICKS_REST, TICKS_PER_S, SCRATCH_ALONG, SCRATCH_BEFORE,
    SCRATCH_ARC_TOP, SCRATCH_FEED, SCRATCH_HEADING, SCRATCH_IS_ARC, SCRATCH_LENGTH, SCRATCH_LENGTH_SHIFT, SCRATCH_STEPS, SCRATCH_STEPS_SHIFT,
    SCRATCH_STRENGTH,
)  # fmt: skip


def set_speed(rows, at, scratch, limits, plan, path, swept, plane, center, deltas, clockwise, speed_nm_s, ticks):
    """Fill in the row rows[at:] of an arc `path` (2⁻¹⁰ steps) long that sweeps `swept` (2⁻³² turn), at `speed_nm_s` or in
    `ticks`; False if its steps would be too far apart. Other arguments: Planner.arc()."""
    steps_per_m = limits.steps_per_m
    flat = path * NM_PER_M // (steps_per_m[plane[0]] << 10)
    rise = deltas[plane[2]] * NM_PER_M // steps_per_m[plane[2]] if plane[2] >= 0 else 0
    length = isqrt(flat * flat + rise * rise)
    if ticks:
        speed_nm_s = length * TICKS_PER_S // ticks or 1
    start = -center[0], -center[1]
    end = deltas[plane[0]] - center[0], deltas[plane[1]] - center[1]
    reach = shares(start, end, swept)
    fastest, acceleration = _arc_limits(limits, plan, plane, center, reach, (flat, rise, length), speed_nm_s)
    asked = speed_nm_s
    if speed_nm_s > fastest or not speed_nm_s:
        speed_nm_s = fastest
        ticks = 0
    if not ticks:
        ticks = -(-length * TICKS_PER_S // speed_nm_s) or 1
    if (ticks << 10) // path > MOST:
        return False
    top = min(TOP, MOST * path // (ticks << 10))
    scratch[SCRATCH_IS_ARC] = 1
    scratch[SCRATCH_FEED] = min(limits.part(asked), MOST) if asked else 0
    scratch[SCRATCH_ARC_TOP] = top
    scratch[SCRATCH_LENGTH], shift = short_float(length, 1, 28)
    scratch[SCRATCH_LENGTH_SHIFT] = 2 * BIAS - shift
    scratch[SCRATCH_STEPS], scratch[SCRATCH_STEPS_SHIFT] = short_float(path, 1 << 10, 15)
    scratch[SCRATCH_ALONG] = max(limits.part(fastest), limits.part(speed_nm_s))
    scratch[SCRATCH_STRENGTH] = (acceleration << 28) // limits.strongest
    _set_direction(scratch, SCRATCH_HEADING, limits, plane, start, clockwise, flat, rise, length)
    plan_block(rows, at, scratch, limits.fields)
    corner(rows, at, scratch, limits.fields)
    rows[at + ROW_TICKS] = max((ticks << 10) // path, 1)
    rows[at + ROW_TICKS_REST] = ((ticks << 10) % path << 7) // path
    rows[at + ROW_SPAN] = (2 * ticks * top << 10) // path
    _set_direction(scratch, SCRATCH_BEFORE, limits, plane, end, clockwise, flat, rise, length)
    return True


def shares(start, end, swept):
    """Return the largest shares, of 2²⁸, that the two axes have of the radius on the way from `start` to `end`, vectors from the centre. `swept`:
    angle in 2⁻³² turn."""
    found = []
    for axis in range(2):
        # An arc of less than half a turn crosses an axis if the other coordinate changes its sign.
        share = ONE
        if swept < TURN // 2 and start[1 - axis] * end[1 - axis] > 0:
            share = max(_share(start, axis), _share(end, axis))
        found.append(share)
    return found


def _share(point, axis):
    """Return the share, 0 … 2²⁸, that an axis has of the length of the vector `point`."""
    radius = isqrt((point[0] * point[0] + point[1] * point[1]) << 40)
    return min((abs(point[axis]) << 48) // radius, ONE)


def _arc_limits(limits, plan, plane, center, reach, lengths, asked):
    """Return (highest speed in nm/s, acceleration in nm/s²) along the path of an arc; both are 1 at least. `lengths`, nm: in the plane, along the
    third axis, in all; `asked`: the speed asked for in nm/s, 0: the highest."""
    flat, rise, length = lengths
    steps = isqrt((center[0] * center[0] + center[1] * center[1]) << 20)  # of 2⁻¹⁰
    radius = steps * NM_PER_M // limits.steps_per_m[plane[0]] >> 10
    tail = plan[ARC_TAIL_A], plan[ARC_TAIL_B]
    # An axis moves along the path by the share that the other has of the radius.
    speed = inwards = acceleration = 0
    for axis in range(2):
        fastest, strongest = limits.speeds[plane[axis]], limits.accelerations[plane[axis]]
        moves, points = reach[1 - axis], reach[axis]
        each = (fastest << 28) // moves
        last = abs(tail[axis])
        if last:  # on the last line, whose direction is its own, the axis gets no more than half a step ahead of its fastest
            each = min(each, 2 * fastest * max(abs(tail[0]), abs(tail[1])) // (2 * last - 1))
        speed = min(speed or each, each)
        each = (strongest << 28) // points
        inwards = min(inwards or each, each)
        each = (strongest << 28) // moves
        acceleration = min(acceleration or each, each)
    speed = min(speed, isqrt(inwards * radius)) * length // flat
    if rise:
        speed = min(speed, limits.speeds[plane[2]] * length // abs(rise))
    along = min(asked or speed, speed) * flat // length
    acceleration = _beside(limits, plane, reach, along * along // radius, acceleration, 1)
    inwards = _beside(limits, plane, reach, acceleration, inwards, 0)
    speed = min(speed, max(along, isqrt(inwards * radius)) * length // flat)
    acceleration = acceleration * length // flat
    if rise:
        acceleration = min(acceleration, limits.accelerations[plane[2]] * length // abs(rise))
    return speed or 1, acceleration or 1


def _beside(limits, plane, reach, other, most, along):
    """As much of one acceleration, up to `most`, as leaves both together within √2 of every axis's: `along` 1, of the ramp's,
    `other` being v²/R; 0: the other way round. On the way from here to there an axis may have the most of both at once, or
    of each at an end."""
    for axis in range(2):
        double = 2 * limits.accelerations[plane[axis]] ** 2
        of_one, of_other = reach[axis ^ along], reach[axis ^ along ^ 1]
        both = isqrt(double - other * other) if other * other < double else 0
        ends = ((isqrt(double) << 28) - other * of_other) // of_one
        most = min(most, max(both, ends))
    return most


def _set_direction(scratch, at, limits, plane, point, clockwise, flat, rise, length):
    """Write the arc's direction at `point`, a vector from its centre, to scratch[at:], of 2²⁸ for each axis. `flat`, `rise` and `length` in nm."""
    x, y = point
    radius = isqrt((x * x + y * y) << 40) or 1  # so fine that the direction's length is 1 to 10⁻⁶, on any radius
    sign = -1 if clockwise else 1
    for axis in range(len(limits.steps_per_m)):
        scratch[at + axis] = 0
    scratch[at + plane[0]] = -sign * (y << 48) // radius * flat // length
    scratch[at + plane[1]] = sign * (x << 48) // radius * flat // length
    if plane[2] >= 0:
        scratch[at + plane[2]] = (rise << 28) // length
