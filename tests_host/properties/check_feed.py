"""Speed along the path, taken from the words: the programmed feed within 1 % in cruise, on lines of every slope and on arcs.

It is measured between feet on the ideal path that share a word's dominant coordinate: over every interval between two
words, to a tick, and with the set-up times of DIR changes, which delay a few steps, over every two milliseconds.
"""

from math import atan2, pi, sqrt

from check_circle import Walk, draw_arc, foot
from passo.motion.limits import Limits
from passo.records import FEED_SETUP
from passo.steps.word import TICKS_PER_S
from rig import Rig

MM = 1_000_000
STEPS_PER_M = 400_000
ACCELERATION_MM_S2 = 20_000
SEGMENT_S = 0.006  # the longest, of an arc
FEED_MM_S = ("feed", 1, 100)
CASES = {
    "check_lines": (("x", -3000, 3000), ("y", -3000, 3000), ("z", -3000, 3000), FEED_MM_S),
    "check_slopes": (("steps", 300, 1000), FEED_MM_S),
    "check_arcs": (("radius", 40, 1500), ("slope", -600, 600), FEED_MM_S, ("seed", "seed")),
}
RUNS = {"check_lines": 30, "check_slopes": 2, "check_arcs": 30}


def steps_of(add, feed, setup):
    """Return [(tick, place, number of the word)] of the steps that `add(planner)` queues at `feed`, in cruise only, and the feed's steps in a second."""
    rig = Rig(axes=3)
    if not setup:
        rig.feeder.state[FEED_SETUP] = 0
    rig.planner.limits(Limits([STEPS_PER_M] * 3, [1000 * MM] * 3, [ACCELERATION_MM_S2 * MM] * 3, 0))
    add(rig.planner)
    steps = []
    place = [0, 0, 0]
    for tick, moves in rig.steps_of(rig.run()):
        place = [at + by for at, by in zip(place, moves)]
        steps.append((tick, place, len(steps)))
    per_s = feed * STEPS_PER_M / 1000
    ramp = per_s * per_s / (2 * ACCELERATION_MM_S2 * STEPS_PER_M / 1000)
    away = int(1.1 * ramp + per_s * SEGMENT_S) + 4  # and a segment that is part ramp, part cruise
    return steps[away:-away], per_s


def hold_feed(add, feet, feed, tail=0):
    """`feet(steps)`: how far along the path the foot of each is."""
    worst = 0.0
    for setup in (False, True):
        steps, per_s = steps_of(add, feed, setup)
        steps = steps[: len(steps) - tail]
        along = feet(steps)
        window = TICKS_PER_S // 500 if setup else 1
        grain = 0 if setup else 1
        first = 0
        for last in range(1, len(steps)):
            while first < last - 1 and steps[last][0] - steps[first + 1][0] >= window:
                first += 1
            ticks = steps[last][0] - steps[first][0]
            if ticks < window:
                continue
            ideal = (along[last] - along[first]) / per_s * TICKS_PER_S
            assert abs(ticks - ideal) <= 0.01 * ideal + grain, (setup, ticks, ideal, steps[first], steps[last])
            worst = max(worst, (abs(ticks - ideal) - grain) / ideal)
    return worst


def hold_line(deltas, feed):
    total = max([abs(delta) for delta in deltas])
    length = sqrt(sum([delta * delta for delta in deltas]))
    axis = [abs(delta) for delta in deltas].index(total)

    def add(planner):
        planner.line(deltas, int(length / STEPS_PER_M * 1000 / feed * TICKS_PER_S), False)

    return hold_feed(add, lambda steps: [abs(step[1][axis]) * length / total for step in steps], feed)


def check_lines(x, y, z, feed):
    if max(abs(x), abs(y), abs(z)) > 20:
        hold_line((x, y, z), feed)


def check_slopes(steps, feed):
    """Sixty-four directions round the compass, the diagonals and axes among them."""
    for part in range(64):
        around = (part & 15) * steps // 8 - steps
        x, y = ((around, -steps), (steps, around), (-around, steps), (-steps, -around))[part >> 4]
        hold_line((x, y, steps // 3), feed)


def check_arcs(radius, slope, feed, seed):
    """`slope`: thousandths of a step of the third axis along one step of the circle."""
    plane, center, deltas, clockwise, _ = draw_arc(radius, seed)
    a, b, third = plane
    true = sqrt(center[0] ** 2 + center[1] ** 2)
    feed = min(feed, int(sqrt(ACCELERATION_MM_S2 * true * 1000 / STEPS_PER_M)))  # the most that v²/R allows
    sign = -1 if clockwise else 1
    swept = (atan2(deltas[b] - center[1], deltas[a] - center[0]) - atan2(-center[1], -center[0])) * sign % (2 * pi)
    deltas[third] = int(slope * (swept or 2 * pi) * true / 1000)
    ratio = sqrt(1 + (deltas[third] / (true * (swept or 2 * pi))) ** 2)

    walk = Walk(plane, center, deltas, clockwise, 0)
    along = []  # of every word's foot
    before = None
    at = 0.0
    for x, y, _, run in walk.places():
        angle = foot(walk, x, y, run[3] == b)
        if before is not None:
            at += (angle - before + 3 * pi) % (2 * pi) - pi
        before = angle
        along.append(at * true * ratio)

    def add(planner):
        planner.arc(deltas, plane, center, False, clockwise, speed_nm_s=feed * MM)

    hold_feed(add, lambda steps: [along[step[2]] for step in steps], feed, walk.tail)
