"""The plan of an arc, for the circle's walker: computed with big integers, once a block.

    path, turned = plan(into, plane, center, deltas, clockwise, turns, over_half)

Vectors are in steps, the plane's axes have equal steps/mm. `into` is an array of ARC_FIELDS integers (records.py).
"""

from array import array
from micropython import const

from passo.arrays import zeros
from passo.motion.circle import turns_off
from passo.motion.circle_viper import LEADS
from passo.motion.cordic import QUARTER, arc_length, vector
from passo.motion.integers import isqrt
from passo.records import *

MAX_RADIUS = const(0x100000)  # 2²⁰ steps
MAX_SLOPE = const(128)  # most steps of the third axis along one step of the circle
MOST_STEPS = const(1 << 28)  # of path in one arc
_FRACTION = const(20)  # bits of a length along the circle


class TooSteep(ValueError):
    """The third axis would take more than MAX_SLOPE steps along one step of the circle."""


class Plans:
    """The plans of the arcs in the queue, each slot used again in its turn."""

    def __init__(self):
        self.plan = array("i", bytearray(4 * ARC_FIELDS))  # the one that is being worked out
        self._users = array("i", [-1] * ARCS)  # the number of the block that each slot was last used for
        self.oldest = -1  # that of the next slot: there is no room until it has been played
        self._next = 0
        self.used = False  # since clear()
        self.plans = zeros(ARC_FIELDS * ARCS)

    def clear(self):
        """Forget the blocks that use the slots: all are free. Only while no arc is queued."""
        for slot in range(ARCS):
            self._users[slot] = -1
        self.oldest = -1
        self.used = False

    def store(self, number):
        """Copy `plan` to the next slot, for the block of this number. Returns the index in `plans` where the copy begins."""
        slot = self._next
        self.used = True
        self._users[slot] = number
        first = slot * ARC_FIELDS
        self.plans[first : first + ARC_FIELDS] = self.plan
        self._next = (slot + 1) % ARCS
        self.oldest = self._users[self._next]
        return first


def region_of(x, y, leaving):
    """Return (region, u, w) of a point on a counter-clockwise arc, in steps from the centre. A point on a diagonal belongs to the region that is left
    (`leaving`) or entered. Raises ValueError for the centre itself."""
    for region in range(4):
        u, w = ((y, x), (-x, y), (-y, -x), (x, -y))[region]
        if w > abs(u) or w > 0 and w == (u if leaving else -u):
            return region, u, w
    raise ValueError("a radius of 0")


def nearest(square, u):
    """Return the w ≥ 0, in steps, whose u² + w² is nearest to `square`."""
    w = isqrt(max(square - u * u, 0))
    below = square - u * u - w * w
    return w + 1 if 2 * w + 1 - below < below else w


def _rise(square, u):
    """Return asin(u / √square) in 2⁻³² turn, signed: −¼ … ¼ turn."""
    if u * u >= square:
        return QUARTER if u > 0 else -QUARTER
    angle, _ = vector(isqrt((square - u * u) << 40), u << 20)
    return angle - (1 << 32) if angle > QUARTER else angle


def plan(into, plane, center, deltas, clockwise=False, turns=0, over_half=None):
    """Work out the arc from here to `deltas` (all axes) about `center` (the plane's two, from here).

    `plane`: (a, b, third axis or -1); counter-clockwise is from a to b. `turns` full ones come on top. `over_half`: the arc sweeps more
    than half a turn, without `turns`, as it was before rounding; an end in the direction of the start is a full turn, then, and else none.
    None: only the steps are known; it is a full turn. An arc too short or too small for a step along the circle has no ARC_STEPS, only the
    last line.

    Returns (length along the circle, with that of the last short line, in 2⁻¹⁰ steps; angle swept, 2⁻³² turn). Raises
    ValueError for a radius above MAX_RADIUS or an arc of more than 2²⁸ steps, and TooSteep.
    """
    sign = -1 if clockwise else 1
    x, y = -center[0], -center[1] * sign
    end_x, end_y = deltas[plane[0]] - center[0], (deltas[plane[1]] - center[1]) * sign
    square = x * x + y * y
    if square > MAX_RADIUS * MAX_RADIUS:
        raise ValueError("an arc of a radius of more than %d steps" % MAX_RADIUS)
    into[ARC_AXIS_A], into[ARC_AXIS_B], into[ARC_AXIS_Z] = plane
    into[ARC_MIRROR] = 1 if clockwise else 0
    cross = x * end_y - y * end_x
    turns += turns_off(cross, x * end_x + y * end_y, over_half)
    if turns < 0 or not square or not end_x and not end_y:
        return _straight(into, plane, deltas)
    inside = isqrt(square >> 1)
    across = nearest(square, inside)
    start = region_of(x, y, False)
    region, u, w = start
    last, end_u, _ = region_of(end_x, end_y, True)
    end_u = max(min(end_u, inside), -across)
    quarters = (last - region) & 3
    if not quarters:
        if cross < 0 or cross == 0 and x * end_x + y * end_y > 0:
            quarters = 4
        elif end_u < u:
            end_u = u
    quarters += 4 * turns
    if quarters and end_u == -across:  # a region begins at the end of the one before
        quarters -= 1
        end_u = inside
    steps, end, tail = _steps(square, inside, across, start, end_u, quarters, end_x, end_y)
    if steps > 1 and end_u - 1 >= (1 - across if quarters else u) and (tail[0] or tail[1]):
        less, before, other = _steps(square, inside, across, start, end_u - 1, quarters, end_x, end_y)
        if less + max(abs(other[0]), abs(other[1])) < steps + max(abs(tail[0]), abs(tail[1])):
            steps, end, tail = less, before, other
    into[ARC_REGION], into[ARC_U], into[ARC_W] = region, u, w
    into[ARC_INSIDE], into[ARC_ACROSS], into[ARC_STEPS] = inside, across, steps
    into[ARC_TAIL_A], into[ARC_TAIL_B] = tail[0], tail[1] * sign
    return _measure(into, square, end, quarters, deltas[plane[2]] if plane[2] >= 0 else 0)


def _straight(into, plane, deltas):
    """Fill in the plan of an arc without a step along the circle. Returns (length in 2⁻¹⁰ steps, 0), as plan() does."""
    for which in range(ARC_REGION, ARC_FIELDS):
        into[which] = 0
    z = deltas[plane[2]] if plane[2] >= 0 else 0
    into[ARC_TAIL_A], into[ARC_TAIL_B], into[ARC_TAIL_Z] = deltas[plane[0]], deltas[plane[1]], z
    into[ARC_PATH] = max(abs(into[ARC_TAIL_A]), abs(into[ARC_TAIL_B])) or abs(z)
    return into[ARC_PATH] << 10, 0


def _measure(into, square, end, quarters, z):
    """Fill in the lengths of an arc to `end` (u, w), and the third axis's `z` steps. Returns and raises what plan() does. It is apart from plan()
    because a board that has run for a while may have no room for both in one piece."""
    u, inside, across, steps = into[ARC_U], into[ARC_INSIDE], into[ARC_ACROSS], into[ARC_STEPS]
    swept = _rise(square, end[0]) - _rise(square, u) + quarters * QUARTER if steps else 0
    shift = 0  # fraction bits that bring the radius to 2²⁸ … 2²⁹
    while square << 2 * (shift + 1) < 1 << 58:
        shift += 1
    radius = isqrt(square << 2 * shift)
    corner = QUARTER - _rise(square, across - 1) - _rise(square, inside)
    turned = path = arc_length(radius, swept)  # ARC_SHIFT fraction bits
    extra = max(abs(into[ARC_TAIL_A]), abs(into[ARC_TAIL_B])) << shift
    tail_z = z  # whole steps on the last line, `extra` long behind `turned` along the circle: it does not stand
    if turned:
        tail_z = abs(z) * extra // (turned + extra) * (-1 if z < 0 else 1)
    z -= tail_z
    ratio = (abs(z) << (30 + shift)) // turned if turned else 0
    if steps and ratio >> 15 < LEADS:  # a word's time passes after its step: the last one's too
        for sign, at in (1, end[0]), (-1, u):
            angle = corner
            if -across < at < inside:
                angle = _rise(square, at + 1) - _rise(square, at)
            path += sign * arc_length(radius, angle)
    whole = (path >> shift) + (extra >> shift or abs(tail_z))
    if whole >= MOST_STEPS:
        raise ValueError("an arc of more than %d steps" % MOST_STEPS)
    if steps and abs(z) << shift > MAX_SLOPE * turned:
        raise TooSteep("a helix of more than %d steps along one of its circle's" % MAX_SLOPE)
    into[ARC_RADIUS], into[ARC_SHIFT] = radius, shift
    into[ARC_DIAGONAL] = arc_length(isqrt(square << 2 * _FRACTION), corner) if steps else 0
    into[ARC_Z_STEPS], into[ARC_Z_HIGH], into[ARC_Z_LOW] = z, ratio >> 15, ratio & 0x7FFF
    into[ARC_TAIL_Z] = tail_z
    into[ARC_PATH] = whole
    into[ARC_PATH_FINE] = ((path << _FRACTION) >> shift) & ((1 << _FRACTION) - 1)
    return whole << 10 | into[ARC_PATH_FINE] >> 10, swept


def _steps(square, inside, across, start, end_u, quarters, end_x, end_y):
    """Return (steps of the circle from `start`, as of region_of(), to the end's region and `end_u`; (u, w) there; steps (x, y) from there to the
    end)."""
    region, u, w = start
    if quarters:
        steps = inside - u + (quarters - 1) * (inside + across) + end_u + across
    else:
        steps = end_u - u
    if steps:
        region = (region + quarters) & 3
        u, w = end_u, inside if end_u == -across else nearest(square, end_u)
    x, y = ((w, u), (-u, w), (-w, -u), (u, -w))[region]
    return steps, (u, w), (end_x - x, end_y - y)
