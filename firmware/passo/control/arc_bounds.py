"""How far an arc reaches beyond its ends."""

from passo.motion.circle import turns_off
from passo.motion.integers import isqrt

_DIRECTIONS = ((1, 0), (0, 1), (-1, 0), (0, -1))


def farthest(start, arc, steps_per_m):
    """The points on `arc` (a Motion from `start`) that lie farthest out along the axes of its plane, to the nearest step.
    """
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
    """True if `direction` lies on the way from `begin` counter-clockwise to `end`; a way of nothing is a whole turn."""
    turn = cross(begin, end)
    if not turn and begin[0] * end[0] + begin[1] * end[1] > 0:
        return True
    if turn >= 0:
        return cross(begin, direction) >= 0 and cross(direction, end) >= 0
    return not (cross(end, direction) > 0 and cross(direction, begin) > 0)


def cross(one, two):
    return one[0] * two[1] - one[1] * two[0]
