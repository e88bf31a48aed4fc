"""Arcs: every step within one step of the ideal circle, the helix's third axis of linear, fewest words, exact ends."""

from array import array
from math import atan2, cos, pi, sin, sqrt

from draws import Random
from passo.motion.arc import TooSteep, plan
from passo.motion.arc import MAX_RADIUS
from passo.motion.circle_viper import LEADS
from passo.motion.circle import COARSE, Circle
from passo.motion.line import MAX_RUN
from passo.records import (
    ARC_FIELDS, ARC_STEPS, ARC_TAIL_A, ARC_TAIL_B, ARC_TAIL_Z, ARC_Z_HIGH, ARC_Z_STEPS, CIRCLE_PATH, CIRCLE_U_AXIS,
    CIRCLE_WORDS,
)  # fmt: skip

TURN = 2 * pi
CASES = {
    "check_any_radius": (("radius", 1, 2000), ("seed", "seed")),
    "check_large_radius": (("radius", 2000, MAX_RADIUS - 1), ("seed", "seed")),
    "check_speed": (("radius", 3, 3000), ("seed", "seed")),
    "check_helix": (("radius", 1, 700), ("rise", -100_000, 100_000), ("seed", "seed")),
    "check_pieces": (("radius", 1, 300), ("rise", -300, 300), ("part", 0, 1000), ("seed", "seed")),
    "check_more_than_the_steps_show": (("radius", 20, 300), ("seed", "seed")),
    "check_end_off_the_circle": (("radius", 1, 300), ("dx", -5, 5), ("dy", -5, 5), ("seed", "seed")),
}
RUNS = {"check_any_radius": 60, "check_large_radius": 8, "check_speed": 25, "check_helix": 40, "check_pieces": 20}
NOT_QUICK = ("check_full_circles", "check_every_radius")
OUT = array("I", bytearray(4 * MAX_RUN))


def about(radius, angle):
    """The whole-step vector next to a polar one; never 0;0."""
    x = int(radius * cos(angle) + 1000.5 + MAX_RADIUS) - 1000 - MAX_RADIUS
    y = int(radius * sin(angle) + 1000.5 + MAX_RADIUS) - 1000 - MAX_RADIUS
    return (x, y) if x or y else (1, 0)


def draw_arc(radius, seed, rise=0, longest=0):
    """Return (plane, centre, deltas, clockwise, turns) of a random arc of about `radius`, in steps; `longest`: the most steps of the arc, 0: any."""
    random = Random(seed)
    angle = random.between(0, 6283) / 1000
    start = about(radius, angle)
    true = sqrt(start[0] ** 2 + start[1] ** 2)
    clockwise = random.choice((False, True))
    if longest and longest < 6 * radius:
        angle += random.between(0, 1000) / 1000 * longest / true * (-1 if clockwise else 1)
    else:
        longest = 0
        angle = random.between(0, 6283) / 1000
    end = about(true, angle)
    if not longest and random.between(0, 5) == 0:
        end = start
    planes = ((0, 1, 2), (2, 0, 1), (1, 2, 0))
    plane = random.choice(planes)
    deltas = [0, 0, 0]
    deltas[plane[0]] = end[0] - start[0]
    deltas[plane[1]] = end[1] - start[1]
    deltas[plane[2]] = rise
    turns = random.choice((0, 0, 0, 1, 3)) if radius < 300 and not longest else 0
    return plane, (-start[0], -start[1]), deltas, clockwise, turns


class Walk:
    """A whole arc walked, with the figures of its plan."""

    def __init__(self, plane, center, deltas, clockwise, turns):
        self.plane = plane
        self.center = center
        self.deltas = list(deltas)
        self.sign = -1 if clockwise else 1
        self.plan = array("i", [0] * ARC_FIELDS)
        path, self.swept = plan(self.plan, plane, center, deltas, clockwise, turns)
        self.path = path / 1024
        self.tail = max([abs(self.plan[i]) for i in (ARC_TAIL_A, ARC_TAIL_B, ARC_TAIL_Z)])  # words of the last line
        circle = Circle(3)
        circle.load(self.plan)
        self.masks = bytearray()
        self.runs = []  # (words, negative, path of a word in steps, dominant axis)
        self.length = 0
        while circle.left:
            count = min(circle.left, MAX_RUN)
            path = circle.state[CIRCLE_PATH] / circle.state[CIRCLE_WORDS]
            self.runs.append((count, circle.negative, path / (1 << COARSE), circle.state[CIRCLE_U_AXIS]))
            self.length += self.runs[-1][2] * count
            circle.walk(OUT, 0, count)
            self.masks.extend(bytes([OUT[i] for i in range(count)]))
        self.made = list(circle.made)
        self.radius = sqrt(center[0] ** 2 + center[1] ** 2)

    def places(self):
        """(x, y, z, run) relative to the centre after every word; the plane's axes first."""
        place = [0, 0, 0]
        a, b, z = self.plane
        word = 0
        for run in self.runs:
            for _ in range(run[0]):
                for axis in range(3):
                    if self.masks[word] >> axis & 1:
                        place[axis] += -1 if run[1] >> axis & 1 else 1
                word += 1
                yield place[a] - self.center[0], place[b] - self.center[1], place[z], run
        assert place == self.deltas == self.made


def hold_against_circle(walk):
    """Every step of `walk` within one step of the circle; the third axis within one step of linear in the angle, or, where
    it is the dominant one, within one and a half steps of the circle's. Returns how far they are off at most."""
    swept = walk.swept * TURN / (1 << 32)
    rise = walk.deltas[walk.plane[2]] - walk.plan[ARC_TAIL_Z]
    slope = abs(rise) / max(walk.path - walk.tail, 1)
    third = 1.0 if slope < 0.7 else 0.5 + 1.5 * slope
    turned = 0.0
    before = atan2(-walk.center[1], -walk.center[0])
    left = len(walk.masks) - walk.tail
    farthest = lag = 0.0
    for x, y, z, _ in walk.places():
        left -= 1
        if left < 0:
            continue
        farthest = max(farthest, abs(sqrt(x * x + y * y) - walk.radius))
        angle = atan2(y, x)
        step = (angle - before + 3 * pi) % TURN - pi
        before = angle
        turned += step * walk.sign
        if rise and swept:
            off = abs(z - rise * min(max(turned / swept, 0), 1))
            assert off <= third
            lag = max(lag, off / third)
    assert farthest < 0.51
    assert walk.tail or abs(turned - swept) * walk.radius < 1
    assert abs(walk.length - walk.path) < 0.75 + walk.path * 1e-6
    return farthest, lag


def hold_count(walk):
    """No word could be spared: none steps one axis of the plane where the one before stepped the other."""
    a, b = 1 << walk.plane[0], 1 << walk.plane[1]
    rise = abs(walk.plan[ARC_Z_STEPS])
    if walk.plan[ARC_Z_HIGH] >= LEADS:
        assert max(rise, walk.plan[ARC_STEPS]) + walk.tail <= len(walk.masks) <= rise + walk.plan[ARC_STEPS] + walk.tail
        return
    assert len(walk.masks) == walk.plan[ARC_STEPS] + walk.tail
    before = a | b
    for mask in walk.masks[: walk.plan[ARC_STEPS]]:
        mask &= a | b
        corner = mask != before and mask != a | b != before
        assert mask and not corner or walk.radius < 1.5  # the nearest way on a radius of √2 is a square
        before = mask


def check_every_radius():
    """Every radius from 1 to 2000: of the larger ones some 300 steps, so that it does not take long."""
    for radius in range(1, 2001):
        hold_arc(draw_arc(radius, radius, longest=300))


def check_any_radius(radius, seed):
    hold_arc(draw_arc(radius, seed))


def hold_arc(arc):
    """All that must be true of an arc. Returns (words, how far they are off the circle, and the third axis off linear)."""
    walk = Walk(*arc)
    farthest, lag = hold_against_circle(walk)
    hold_count(walk)
    return len(walk.masks), farthest, lag


def check_large_radius(radius, seed):
    arc = draw_arc(radius, seed, longest=20_000)
    arc[2][arc[0][2]] = max([abs(by) for by in arc[2]]) // 3
    hold_arc(arc)


def check_full_circles():
    """Every radius to 40, from every one of 16 directions, both ways: closes exactly, symmetrical, in fewest words."""
    for radius in range(1, 41):
        for direction in range(16):
            start = about(radius, direction * TURN / 16)
            for clockwise in (False, True):
                walk = Walk((0, 1, 2), (-start[0], -start[1]), (0, 0, 0), clockwise, 0)
                hold_against_circle(walk)
                assert walk.made == [0, 0, 0] and not walk.tail
                square = start[0] ** 2 + start[1] ** 2
                inside = max([d for d in range(radius + 2) if 2 * d * d <= square])
                assert len(walk.masks) >= 8 * inside
                assert len(walk.masks) <= 8 * inside + 8


def foot(walk, x, y, u_is_y):
    """Angle of the foot on the ideal circle that shares the dominant coordinate, in the walk's own sense."""
    if u_is_y:
        y = max(min(y, walk.radius), -walk.radius)
        return atan2(y, sqrt(walk.radius**2 - y * y) * (1 if x > 0 else -1)) * walk.sign
    x = max(min(x, walk.radius), -walk.radius)
    return atan2(sqrt(walk.radius**2 - x * x) * (1 if y > 0 else -1), x) * walk.sign


def check_speed(radius, seed):
    """A word's share of the time is the true arc from its foot to the next word's, octant changes included: 1 %."""
    walk = Walk(*draw_arc(radius, seed))
    worst = 0.0
    before = None
    left = len(walk.masks) - walk.tail
    for x, y, _, run in walk.places():
        if left > 0:
            here = foot(walk, x, y, run[3] == walk.plane[1])
            if before is not None:
                arc = ((here - before + 3 * pi) % TURN - pi) * walk.radius
                worst = max(worst, abs(each / arc - 1))
            before = here
            each = run[2]
        left -= 1
    assert worst < 0.01, worst


def check_helix(radius, rise, seed):
    """Any rise: where the third axis dominates, the circle keeps step with it."""
    arc = draw_arc(radius, seed, rise)
    try:
        hold_arc(arc)
    except TooSteep:
        return


def check_one_step_in_millions():
    """The third axis's only step, on the largest half circle there is, is not lost."""
    radius = MAX_RADIUS
    into = array("i", [0] * ARC_FIELDS)
    plan(into, (0, 1, 2), (-radius, 0), (-2 * radius, 0, -1))
    circle = Circle(3)
    circle.load(into)
    while circle.left:
        circle.walk(OUT, 0, circle.left)
    assert list(circle.made) == [-2 * radius, 0, -1]


def check_pieces(radius, rise, part, seed):
    """An arc walked in two pieces, cut at any word, is the same arc."""
    arc = draw_arc(radius, seed, rise)
    try:
        walk = Walk(*arc)
    except TooSteep:
        return
    first = len(walk.masks) * part // 1000
    circle = Circle(3)
    circle.load(walk.plan)
    masks = bytearray()
    while circle.left:
        count = min(circle.left, MAX_RUN, first - len(masks) if len(masks) < first else MAX_RUN)
        circle.walk(OUT, 0, count)
        masks.extend(bytes([OUT[i] for i in range(count)]))
    assert masks == walk.masks
    assert list(circle.made) == walk.deltas


def check_end_off_the_circle(radius, dx, dy, seed):
    """An end that is not on the circle is hit all the same, by a line no longer than it is off."""
    plane, center, deltas, clockwise, turns = draw_arc(radius, seed)
    deltas[plane[0]] += dx
    deltas[plane[1]] += dy
    if deltas[plane[0]] == center[0] and deltas[plane[1]] == center[1]:
        return
    walk = Walk(plane, center, deltas, clockwise, turns)
    for _ in walk.places():
        pass
    assert walk.tail <= 2 * max(abs(dx), abs(dy)) + 3


def check_what_is_refused():
    into = array("i", [0] * ARC_FIELDS)
    try:
        plan(into, (0, 1, 2), (MAX_RADIUS + 1, 0), (0, 0, 0))
    except ValueError:
        return
    raise AssertionError("accepted")


def check_what_is_no_circle():
    """A radius of less than a step, an end at the centre, a sweep that rounding has brought to nothing or below: a line."""
    for center, deltas, over_half in (
        ((0, 0), (0, 0, 7), True), ((0, 0), (1, 1, -7), None), ((5, 0), (5, 0, 0), None), ((5, 0), (0, 0, 3), False),
        ((3000, 0), (0, 1, 0), False), ((3000, 3000), (-1, 1, 9), False),
    ):
        walk = Walk((0, 1, 2), center, deltas, False, 0) if over_half is None else None
        into = array("i", [0] * ARC_FIELDS)
        plan(into, (0, 1, 2), center, deltas, False, 0, over_half)
        assert not into[ARC_STEPS]
        circle = Circle(3)
        circle.load(into)
        words = circle.left
        circle.walk(OUT, 0, words)
        assert circle.left == 0 and words == max([abs(by) for by in deltas])
        assert list(circle.made) == list(deltas)
        assert walk is None or walk.made == list(deltas)


def check_more_than_the_steps_show(radius, seed):
    """If rounding carries the end to the other side of the start, the plan adds or takes one turn: all else stays."""
    plane, center, deltas, clockwise, _ = draw_arc(radius, seed)
    turn = Walk(plane, center, deltas, clockwise, 0).swept  # 2³² is a whole one
    for over_half in (False, True):
        into = array("i", [0] * ARC_FIELDS)
        swept = plan(into, plane, center, deltas, clockwise, 1, over_half)[1]
        before = Walk(plane, center, deltas, clockwise, 1).swept
        off = (swept - before + (1 << 31)) >> 32
        if turn < 1 << 30:
            assert off == (1 if over_half else 0)
        elif turn > 3 << 30:
            assert off == (0 if over_half else -1)
        else:
            assert off == 0
