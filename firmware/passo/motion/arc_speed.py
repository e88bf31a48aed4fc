"""How fast an arc may be walked: what measure() finds out for lines, worked out with big integers, once an arc."""

from passo.motion.integers import NM_PER_M, isqrt
from passo.motion.measure_viper import measure
from passo.motion.profile import BIAS, MOST, TICKS_PER_S, TOP, floated
from passo.records import (
    ROW_SPAN, ROW_TICKS, ROW_TICKS_REST, WORK_ALONG, WORK_BEFORE, WORK_FEED, WORK_GIVEN, WORK_HEADING, WORK_IS_ARC,
    WORK_LENGTH, WORK_LENGTH_SHIFT, WORK_STEPS, WORK_STEPS_SHIFT, WORK_STRENGTH,
)  # fmt: skip


def set_speed(rows, at, work, limits, path, plane, center, deltas, clockwise, speed_nm_s, ticks):
    """Fill in the row rows[at:] of an arc `path` (2⁻¹⁰ steps) long, at `speed_nm_s` or in `ticks`; False where its steps
    would be too far apart. The rest is as Planner.arc() has it."""
    steps_per_m = limits.steps_per_m
    flat = path * NM_PER_M // (steps_per_m[plane[0]] << 10)
    rise = deltas[plane[2]] * NM_PER_M // steps_per_m[plane[2]] if plane[2] >= 0 else 0
    length = isqrt(flat * flat + rise * rise)
    if ticks:
        speed_nm_s = length * TICKS_PER_S // ticks or 1
    fastest, acceleration = _allowed(limits, plane, center, flat, rise, length)
    asked = speed_nm_s
    if speed_nm_s > fastest or not speed_nm_s:
        speed_nm_s = fastest
        ticks = 0
    if not ticks:
        ticks = -(-length * TICKS_PER_S // speed_nm_s) or 1
    if (ticks << 10) // path > MOST:
        return False
    top = min(TOP, MOST * path // (ticks << 10))
    work[WORK_IS_ARC] = 1
    work[WORK_FEED] = min(limits.part(asked), MOST) if asked else 0
    work[WORK_GIVEN] = top
    work[WORK_LENGTH], shift = floated(length, 1, 28)
    work[WORK_LENGTH_SHIFT] = 2 * BIAS - shift
    work[WORK_STEPS], work[WORK_STEPS_SHIFT] = floated(path, 1 << 10, 15)
    work[WORK_ALONG] = max(limits.part(fastest), limits.part(speed_nm_s))
    work[WORK_STRENGTH] = (acceleration << 28) // limits.strongest
    _set_direction(work, WORK_HEADING, limits, plane, (-center[0], -center[1]), clockwise, flat, rise, length)
    measure(rows, at, work, limits.terms)
    rows[at + ROW_TICKS] = max((ticks << 10) // path, 1)
    rows[at + ROW_TICKS_REST] = ((ticks << 10) % path << 7) // path
    rows[at + ROW_SPAN] = (2 * ticks * top << 10) // path
    place = deltas[plane[0]] - center[0], deltas[plane[1]] - center[1]
    _set_direction(work, WORK_BEFORE, limits, plane, place, clockwise, flat, rise, length)
    return True


def _allowed(limits, plane, center, flat, rise, length):
    """(highest speed, acceleration) along the path of an arc."""
    steps = isqrt((center[0] * center[0] + center[1] * center[1]) << 20)  # of 2⁻¹⁰
    radius = steps * NM_PER_M // limits.steps_per_m[plane[0]] >> 10
    weaker = min(limits.accelerations[plane[0]], limits.accelerations[plane[1]])
    speed = min(limits.speeds[plane[0]], limits.speeds[plane[1]], isqrt(weaker * radius)) * length // flat
    acceleration = weaker * length // flat
    if rise:
        speed = min(speed, limits.speeds[plane[2]] * length // abs(rise))
        acceleration = min(acceleration, limits.accelerations[plane[2]] * length // abs(rise))
    return speed or 1, acceleration or 1


def _set_direction(work, at, limits, plane, place, clockwise, flat, rise, length):
    """The arc's direction, of 2²⁸, at `place` seen from its centre."""
    x, y = place
    radius = isqrt((x * x + y * y) << 40) or 1  # so fine that the direction's length is 1 to 10⁻⁶, on any radius
    sign = -1 if clockwise else 1
    for axis in range(len(limits.steps_per_m)):
        work[at + axis] = 0
    work[at + plane[0]] = -sign * (y << 48) // radius * flat // length
    work[at + plane[1]] = sign * (x << 48) // radius * flat // length
    if plane[2] >= 0:
        work[at + plane[2]] = (rise << 28) // length
