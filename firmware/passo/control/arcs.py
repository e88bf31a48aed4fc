"""A language's questions about an arc, in nanometres from its start: the centre from R, whether I J K fit, the end of a sweep; and how far
an arc of steps reaches beyond its ends.

Both kinds of centre follow RS274/NGC (NIST IR 6556, 3.5.3).
"""

from micropython import const

from passo import errors
from passo.motion.circle import turns_off
from passo.motion.cordic import TURN, rotate
from passo.motion.integers import isqrt

_CLOSE_NM = const(5_000)  # start and end radius may differ by this, or by a thousandth, but not by _FAR_NM
_FAR_NM = const(500_000)
_FINE = const(40)  # bits after the point
_CLOSES = const(2_000_000)  # 1 / 5·10⁻⁷
_DIRECTIONS = ((1, 0), (0, 1), (-1, 0), (0, -1))


def check_centre(x, y, i, j):
    """Return 0 if the point (x, y) lies on the circle about (i, j) through (0, 0), else errors.TARGET. All in nm."""
    radius = isqrt(i * i + j * j)
    if not radius:
        return errors.TARGET
    off = abs(isqrt((x - i) * (x - i) + (y - j) * (y - j)) - radius)
    if off > _CLOSE_NM and (off > _FAR_NM or off * 1000 > radius):
        return errors.TARGET
    return 0


def centre_of(x, y, radius, clockwise):
    """Return (error, i, j), nm: the centre of the arc of `radius` from (0, 0) to (x, y). A negative radius is the long way round."""
    square = x * x + y * y
    if not square:
        return errors.TARGET, 0, 0
    height = 4 * radius * radius - square
    if height < 0:
        chord = isqrt(square)
        if chord - 2 * abs(radius) > _CLOSE_NM // 5:  # a half circle whose R was rounded is still one
            return errors.RADIUS, 0, 0
        height = 0
    slope = isqrt((height << 2 * _FINE) // square)  # height / chord
    if clockwise == (radius > 0):
        slope = -slope
    return 0, (x - (y * slope >> _FINE)) // 2, (y + (x * slope >> _FINE)) // 2


def over_half(x, y, i, j, clockwise):
    """Return True if the arc about (i, j) from (0, 0) to (x, y) sweeps more than half a turn: grbl's rule (mc_arc in
    motion_control.c), without its roundings. An end behind the start is nearly a turn away; one less than 5·10⁻⁷ rad ahead of
    it (ARC_ANGULAR_TRAVEL_EPSILON) closes the circle."""
    cross = j * x - i * y
    if clockwise:
        cross = -cross
    dot = i * (i - x) + j * (j - y)
    return cross < 0 or dot > 0 and cross * _CLOSES <= dot


def end_of(i, j, sweep_udeg, clockwise):
    """Return (x, y), nm: where the arc about (i, j) from (0, 0) ends that sweeps `sweep_udeg` ≥ 0 millionths of a degree."""
    sweep = (sweep_udeg * TURN + 180_000_000) // 360_000_000
    x, y = rotate(-i, -j, -sweep if clockwise else sweep)
    return i + x, j + y


def farthest(start, arc, steps_per_m):
    """Return the points on `arc` (a Motion from `start`) that lie farthest out along the axes of its plane, to the nearest step."""
    i, j = arc.centre
    wide, high = steps_per_m[arc.second], steps_per_m[arc.first]  # brings both axes to one unit
    square = 4 * (i * i * wide * wide + j * j * high * high)
    reach = (isqrt(square // (wide * wide)) + 1) // 2, (isqrt(square // (high * high)) + 1) // 2
    centre = start[arc.first] + i, start[arc.second] + j
    end = (arc.target[arc.first] - centre[0]) * wide, (arc.target[arc.second] - centre[1]) * high
    begin = (-i * wide, -j * high)
    if arc.clockwise:
        begin, end = end, begin
    turns = arc.turns + turns_off(cross(begin, end), begin[0] * end[0] + begin[1] * end[1], arc.over_half)
    points = []
    for direction in _DIRECTIONS:
        if turns > 1 or turns and swept(begin, direction, end):
            point = list(arc.target)
            point[arc.first] = centre[0] + reach[0] * direction[0]
            point[arc.second] = centre[1] + reach[1] * direction[1]
            points.append(point)
    return points


def swept(begin, direction, end):
    """Return True if `direction` lies on the way from `begin` counter-clockwise to `end`. If both are equal, the way is a whole turn."""
    turn = cross(begin, end)
    if not turn and begin[0] * end[0] + begin[1] * end[1] > 0:
        return True
    if turn >= 0:
        return cross(begin, direction) >= 0 and cross(direction, end) >= 0
    return not (cross(end, direction) > 0 and cross(direction, begin) > 0)


def cross(one, two):
    """Return the cross product of two vectors: above 0 if `two` lies counter-clockwise of `one`."""
    return one[0] * two[1] - one[1] * two[0]
