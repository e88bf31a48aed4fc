"""Chords of an ellipse: within a quarter of a step before rounding, ends exact, the third axis linear."""

from math import atan2, cos, pi, sin, sqrt

from passo.motion.ellipse import Ellipse

CASES = {
    "check_chords": (
        ("radius", 1, 3000), ("start", 0, 6283), ("end", 0, 6283), ("clockwise", 0, 1), ("turns", 0, 2), ("rise", -900, 900),
    ),
    "check_inwards": (("start", 0, 6283), ("sweep", 1, 9000), ("clockwise", 0, 1), ("fast", 10, 5000), ("slow", 10, 5000)),
}
STEPS_PER_M = (48_000, 83_000, 100_000)


def check_chords(radius, start, end, clockwise, turns, rise):
    """`radius` in 1/48 mm; X has 48 steps/mm, Y 83, as on the welding torch."""
    first = [int(radius * cos(start / 1000)), int(radius * 83 / 48 * sin(start / 1000))]
    if not (first[0] or first[1]):
        return
    true = sqrt((first[0] / 48) ** 2 + (first[1] / 83) ** 2)
    last = [int(true * 48 * cos(end / 1000)), int(true * 83 * sin(end / 1000))]
    if not (last[0] or last[1]):
        return
    deltas = (last[0] - first[0], last[1] - first[1], rise)
    place = [first[0], first[1], 0]
    off = abs(sqrt((last[0] / 48) ** 2 + (last[1] / 83) ** 2) - true) * 83
    turned = 0.0
    ellipse = Ellipse(deltas, (0, 1, 2), (-first[0], -first[1]), STEPS_PER_M, bool(clockwise), turns)
    count = ellipse.left
    while ellipse.left:
        chord = ellipse.chord()
        before = atan2(place[1] / 83, place[0] / 48)
        place = [place[axis] + chord[axis] for axis in range(3)]
        assert abs(sqrt((place[0] / 48) ** 2 + (place[1] / 83) ** 2) - true) * 83 <= 0.71 * 83 / 48 + off
        step = (atan2(place[1] / 83, place[0] / 48) - before + 3 * pi) % (2 * pi) - pi
        turned += step
    assert place == [last[0], last[1], rise]
    assert abs(ellipse.radius_nm / 1e6 - true) < 0.001
    flat = abs(turned) * true
    assert abs(ellipse.length_nm / 1e6 - sqrt(flat * flat + (rise / 100) ** 2)) < 0.05
    if radius > 48:
        angle = (abs(turned) - 2 / (true * 48)) / count  # the ends of the whole are rounded too
        assert true * 83 * angle * angle / 8 <= 0.25


def check_inwards(start, sweep, clockwise, fast, slow):
    """v²/R asks no axis for more than it has, anywhere on the arc, and one of them, somewhere, for nearly all of it."""
    radius = 100_000
    sign = -1 if clockwise else 1
    ends = start / 1000, start / 1000 + sign * min(sweep / 1000, 6.28)
    first, last = [(int(radius * 48 * cos(angle)), int(radius * 83 * sin(angle))) for angle in ends]
    # The arc is that of the rounded ends; where one axis has much more than the other, that is seen.
    begun, ended = [angle + (atan2(y / 83, x / 48) - angle + 3 * pi) % (2 * pi) - pi for angle, (x, y) in zip(ends, (first, last))]
    way = [begun + (ended - begun) * part / 500 for part in range(501)]
    deltas = last[0] - first[0], last[1] - first[1], 0
    ellipse = Ellipse(deltas, (0, 1, 2), (-first[0], -first[1]), STEPS_PER_M, bool(clockwise))
    inwards = ellipse.inwards((fast * 1_000_000, slow * 1_000_000)) / 1e6
    used = max([max(abs(cos(angle)) * inwards / fast, abs(sin(angle)) * inwards / slow) for angle in way])
    assert 0.999 < used <= 1.00001, used
