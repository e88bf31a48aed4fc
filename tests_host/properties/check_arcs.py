"""Arcs from the line of G-code to the last step, against the true arc in floats: of every length, sweep, plane and resolution.

The distance allowed between a step and the true arc, in steps: With one resolution: the walker keeps within 0.51 of the circle of whole steps
(check_circle.py), whose centre and start are each within √½ of the true ones; so its radius is within twice that, and the
circle within three times √½ of the true one. With two, or a radius above 2²⁰ steps: ¼ for the chord, √½ for its end and
½ for the line that is walked, on such a circle; a step is one of the coarser axis.
"""

from math import cos, pi, sin, sqrt

from draws import Random
from gcode_walk import NM_MM, Bench
from true_path import Arc, centre_by_radius

BOUND = 0.51 + 3 * sqrt(0.5)
CHORD_BOUND = 0.25 + sqrt(0.5) + 0.5 + 3 * sqrt(0.5)
LONGEST = 6000  # steps of an arc, so that it does not take long
PLANES = ((0, 1), (2, 0), (1, 2))
CASES = {
    "check_any_arc": (("seed", "seed"), ("plane", 0, 2), ("way", 0, 3), ("form", "choice", "centre", "radius", "sweep")),
    "check_tiny_arcs": (("seed", "seed"), ("plane", 0, 2), ("way", 0, 3), ("form", "choice", "centre", "radius", "sweep")),
    "check_nearly_whole_turns": (("seed", "seed"), ("plane", 0, 2), ("way", 0, 3), ("form", "choice", "centre", "sweep")),
    "check_unequal_axes": (("seed", "seed"), ("way", 0, 3), ("form", "choice", "centre", "radius", "sweep")),
}
RUNS = {"check_any_arc": 150, "check_tiny_arcs": 200, "check_nearly_whole_turns": 100, "check_unequal_axes": 60}
NOT_QUICK = ("check_turns_on_top", "check_grbls_rule")


def words_of(letters, values):
    """Values in nanometres as words in millimetres: exact."""
    text = ""
    for letter, value in zip(letters, values):
        text += "%s%s%d.%06d" % (letter, "-" if value < 0 else "", abs(value) // NM_MM, abs(value) % NM_MM)
    return text


def spread(random, low, high):
    """Between two positive numbers, every power of ten as often as another."""
    size = low * (high / low) ** (random.between(0, 1_000_000) / 1_000_000)
    return min(max(size, low), high)


class Asked(Arc):
    """An arc, and the line that asks for it."""

    def __init__(self, random, plane, way, form, sweep, radius, turns, rise, start):
        self.plane, self.rise, self.start = plane, rise, start
        sign = -1 if way & 1 else 1
        first = random.between(0, 62_831_853) / 10_000_000
        if random.between(0, 3) == 0:
            first = random.between(0, 8) * pi / 4
        last = first + sign * sweep
        # Differences of sines as products, which lose no digits however short the arc.
        by = 2 * radius * sin(sweep / 2) * sign
        middle = (first + last) / 2
        end = int_of(-by * sin(middle)), int_of(by * cos(middle))
        offsets = int_of(-radius * cos(first)), int_of(-radius * sin(first))
        centre = offsets[0] / NM_MM, offsets[1] / NM_MM
        relative = way & 2
        a, b = plane
        third = 3 - a - b
        place = [0, 0, 0] if relative else start[:]
        place[a] += end[0]
        place[b] += end[1]
        place[third] += rise
        text = ("G91" if relative else "G90") + ("G17", "G18", "G19")[PLANES.index(plane)] + ("G3", "G2")[way & 1] + "F3000"
        if form == "sweep":
            text += "H%.6f" % ((sweep + 2 * pi * (turns - 1)) * 180 / pi)
        else:
            text += words_of(["XYZ"[a], "XYZ"[b]], [place[a], place[b]])
        if rise:
            text += words_of(["XYZ"[third]], [place[third]])
        if form == "radius":
            size = int_of(radius) * (-1 if sweep > pi else 1)
            centre = centre_by_radius(end[0] / NM_MM, end[1] / NM_MM, size / NM_MM, sign < 0)
            text += words_of("R", [size])
        else:
            text += words_of(["IJK"[a], "IJK"[b]], offsets)
        if turns > 1 and form != "sweep":
            text += "P%d" % turns
        self.text = text
        Arc.__init__(self, (end[0] / NM_MM, end[1] / NM_MM), centre, sign < 0, turns, sweep)


def int_of(mm):
    return int(round(mm * NM_MM))


def hold(bench, arc, bound):
    """Walk `arc`; every step within `bound` of it, as many turns as it has, the third axis with them. How far it was off."""
    a, b = arc.plane
    third = 3 - a - b
    per_mm = [per_m / 1000 for per_m in bench.steps_per_m]
    coarse = min(per_mm[a], per_mm[b])
    path = bench.do(arc.text)
    assert abs(path[-1][third] - (arc.start[third] + arc.rise) / NM_MM * per_mm[third]) <= 0.5 + 1e-6
    start = arc.start[a] / NM_MM, arc.start[b] / NM_MM
    steps = arc.radius * coarse
    worst = turned = 0.0
    before = None
    rise = arc.rise / NM_MM * per_mm[third]
    slope = abs(rise) / (arc.wholly * steps)
    for place in path:
        off, angle = arc.distance(place[a] / per_mm[a] - start[0], place[b] / per_mm[b] - start[1])
        worst = max(worst, off * coarse)
        if before is None:
            before = angle if angle <= pi else angle - 2 * pi
            turned = before
        step = (angle - before + 3 * pi) % (2 * pi) - pi
        before = angle
        turned += step
        if steps > 8:
            share = min(max(turned / arc.wholly, 0), 1)
            assert abs(place[third] - path[0][third] - rise * share) <= 2 + slope * (bound + 2), (arc.text, place)
    assert worst <= bound, (arc.text, worst)
    if steps > 8:
        assert abs(turned - arc.wholly) <= bound / steps * 1.2, (arc.text, turned, arc.wholly)
    return worst


def start_at(random, bench):
    start = [random.between(-20 * NM_MM, 20 * NM_MM) for _ in range(3)]
    bench.do("G21G90G0" + words_of("XYZ", start))
    return start


def draw(seed, plane, way, form, length=None, sweep=None, steps_per_m=None):
    """(bench, arc): anything, or of the length in millimetres and the sweep given."""
    random = Random(seed)
    if steps_per_m is None:
        flat = random.choice((10_000, 80_000, 320_000, 1_000_000, random.between(10_000, 1_000_000)))
        steps_per_m = [flat, flat, flat]
        steps_per_m[3 - sum(PLANES[plane])] = random.choice((flat, 400_000))
    if sweep is None:
        sweep = spread(random, 6e-7, 359.999 * pi / 180)
        if random.between(0, 1):
            sweep = random.between(1, 359_999) * pi / 180_000
    if form == "sweep":  # rounded to the digits of the line
        sweep = max(int(sweep * 180 / pi * 1e6), 1) * pi / 180e6
    if form == "radius" and abs(sweep - pi) < 0.1:
        sweep = pi / 2  # the centre of half a turn hangs on its end's last digit
    if length is None:
        length = spread(random, 0.0001, 20)
    turns = random.choice((1, 1, 1, 2, 5)) if form != "radius" else random.choice((1, 1, 1, 3))
    longest = LONGEST * 1000 / max(steps_per_m)
    if length > longest:
        length = longest
    radius = length / sweep
    if radius > 5000:
        radius = 5000.0
        sweep = max(length / radius, 6e-7)
        if form == "sweep":
            sweep = max(int(sweep * 180 / pi * 1e6), 35) * pi / 180e6
    if 2 * pi * (turns - 1) * radius > longest:
        turns = 1
    if form == "radius" and radius < 1e-5:
        radius = 1e-5
        sweep = length / radius if length / radius < 3 else 3.0
    if form == "radius" and 2 * radius * sin(sweep / 2) < 1e-5:
        sweep = pi / 2  # an end on the start has no centre
    rise = 0
    if random.between(0, 1):
        rise = int_of(spread(random, 0.0001, 5)) * random.choice((-1, 1))
    bench = Bench(steps_per_m)
    start = start_at(random, bench)
    return bench, Asked(random, PLANES[plane], way, form, sweep, radius, turns, rise, start)


def bound_of(bench, arc):
    a, b = arc.plane
    steep = abs(arc.rise) * bench.steps_per_m[3 - a - b] > 100 * NM_MM * arc.radius * arc.sweep * bench.steps_per_m[a]
    if bench.steps_per_m[a] != bench.steps_per_m[b] or steep or arc.radius * bench.steps_per_m[a] / 1000 > 1 << 20:
        return CHORD_BOUND
    return BOUND


def check_any_arc(seed, plane, way, form):
    bench, arc = draw(seed, plane, way, form)
    hold(bench, arc, bound_of(bench, arc))


def check_tiny_arcs(seed, plane, way, form):
    """Down to a ten thousandth of a millimetre, on radii that a machine's arcs have."""
    random = Random(seed)
    length = spread(random, 0.0001, 0.02)
    bench, arc = draw(seed, plane, way, form, length, length / spread(random, 0.01, 100))
    hold(bench, arc, bound_of(bench, arc))


def check_nearly_whole_turns(seed, plane, way, form):
    """An end a hair behind the start is nearly a turn away, on it or a smaller hair ahead a whole one."""
    random = Random(seed)
    short = spread(random, 1e-5, 0.01)
    sweep = 2 * pi - short
    bench, arc = draw(seed, plane, way, form, spread(random, 0.0001, 5), sweep)
    hold(bench, arc, bound_of(bench, arc))


def check_unequal_axes(seed, way, form):
    random = Random(seed)
    scale = random.between(10_000, 500_000)
    steps_per_m = [scale, scale, scale * random.between(2, 20) // 8 or 1]
    bench, arc = draw(seed, random.between(1, 2), way, form, None, None, steps_per_m)
    hold(bench, arc, CHORD_BOUND)


def turned(text, start="G0X10Y0", steps_per_m=320_000):
    """(words, end, farthest from the start along X and Y in steps) of one line after `start`."""
    bench = Bench([steps_per_m] * 3)
    bench.do("G21G90" + start)
    path = bench.do(text)
    far = [max([abs(place[axis] - path[0][axis]) for place in path]) for axis in range(2)]
    return len(path) - 1, path[-1], far


def check_grbls_rule():
    """An end on the start, behind it or less than 5·10⁻⁷ rad ahead of it is a turn; farther ahead it is a tiny arc."""
    for text, circles, end in (
        ("G3X9.9999Y0.001I-10J0F1000", False, (3200, 0, 0)),
        ("G2X9.9999Y-0.001I-10J0F1000", False, (3200, 0, 0)),
        ("G3X9.9999Y-0.001I-10J0F1000", True, (3200, 0, 0)),
        ("G2X9.9999Y0.001I-10J0F1000", True, (3200, 0, 0)),
        ("G3X10Y0I-10J0F1000", True, (3200, 0, 0)),
        ("G2X10Y0I-10J0F1000", True, (3200, 0, 0)),
        ("G3Y0.000004I-10F1000", True, (3200, 0, 0)),
        ("G3Y0.000006I-10F1000", False, (3200, 0, 0)),
        ("G2Y-0.000004I-10F1000", True, (3200, 0, 0)),
        ("G2Y-0.000006I-10F1000", False, (3200, 0, 0)),
        ("G3Y0.000001R10F1000", False, (3200, 0, 0)),
        ("G3Y0.000001R-10F1000", True, (3200, 0, 0)),
        ("G3X9.9999Y0.001R10F1000", False, (3200, 0, 0)),
        ("G3X9.9999Y0.001I-10J0Z1F1000", False, (3200, 0, 320)),
        ("G3X9.9999Y0.001R10Z1F1000", False, (3200, 0, 320)),
        ("G3X9.9999Y0.001I-10J0Z1P2F1000", True, (3200, 0, 320)),
        ("G3I-10H0.01F1000", False, (3200, 1, 0)),
        ("G3I-10H359.999F1000", True, (3200, 0, 0)),
        ("G3I-10H0.001F1000", False, (3200, 0, 0)),
        ("G2I-10H0.001Z1F1000", False, (3200, 0, 320)),
        ("G3X10Y0I-0.0004J0Z1F1000", False, (3200, 0, 320)),  # a circle smaller than a step
    ):
        words, at, far = turned(text)
        assert at == end, (text, at)
        if circles:
            assert far == [6400, 3200], (text, far)
            assert 17_000 < words < 19_500, (text, words)
        else:
            assert far[0] == 0 and far[1] <= 1 and words <= max(end[2], 1), (text, far, words)


def check_turns_on_top():
    """P counts the tiny arc as a turn begun, and a nearly whole turn as one."""
    for text, whole in (
        ("G3X9.9999Y0.001I-10J0P3F1000", 2), ("G3X9.9999Y-0.001I-10J0P3F1000", 3), ("G2X10Y0I-10J0P2F1000", 2),
        ("G3Y0.000001R10P2F1000", 1), ("G3I-10H720.001F1000", 2), ("G3I-10H719.999F1000", 2), ("G2I-10H720F1000", 2),
    ):
        words, at, far = turned(text)
        assert at[:2] == (3200, 0) and far == [6400, 3200], text
        assert abs(words - whole * 18_101) <= 8, (text, words)
