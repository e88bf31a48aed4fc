"""Radius compensation: the path of the listing, read by plain_reader.py, against shapely's buffer of the contour, within 0.01 mm."""

import math
import random

import pytest
from shapely import LinearRing, LineString, Point, Polygon

from host_tools.programs.compensation import LEFT, RIGHT, Piece, offset_contour
from host_tools.programs.listing import Listing
from host_tools.programs.ngc.interpreter import compile_program
from host_tools.programs.program_errors import ProgramError
from host_tools.programs.tool_table import Tool
from plain_reader import cut_points, events

WITHIN = 0.01
NOWHERE = (None, None, None)

# A contour begins at its first point, in the middle of a side: (x, y) a line, (x, y, centre x, centre y, clockwise) an arc.
SQUARE = ((10, 0), (20, 0), (20, 20), (0, 20), (0, 0), (10, 0))
ROUNDED = (
    (10, 0), (16, 0), (20, 4, 16, 4, False), (20, 16), (16, 20, 16, 16, False), (4, 20), (0, 16, 4, 16, False), (0, 4),
    (4, 0, 4, 4, False), (10, 0),
)  # fmt: skip
CIRCLE = ((20, 0), (20, 0, 0, 0, False))
HALF_MOON = ((15, 0), (0, 15, 0, 0, False), (0, 5), (0, -5, 8, 0, False), (0, -15), (15, 0, 0, 0, False))
ACUTE = ((10, 0), (40, 0), (0, 7), (0, 0), (10, 0))
BOTH = ((10, 0), (30, 0), (30, 30), (20, 30), (20, 12), (8, 12), (8, 30), (0, 30), (0, 0), (10, 0))
SCALLOP = ((10, 0), (20, 0), (20, 10), (10, 10, 15, 10, True), (0, 10, 5, 10, True), (0, 0), (10, 0))
STAR = tuple((math.cos(k * math.pi / 5) * (20, 9)[k % 2], math.sin(k * math.pi / 5) * (20, 9)[k % 2]) for k in range(10))
STAR = (((STAR[0][0] + STAR[1][0]) / 2, (STAR[0][1] + STAR[1][1]) / 2), *STAR[1:], STAR[0])
STAR += (STAR[0],)
SHAPES = {"square": SQUARE, "rounded": ROUNDED, "circle": CIRCLE, "half moon": HALF_MOON, "acute": ACUTE, "both": BOTH, "scallop": SCALLOP,
          "star": STAR}  # fmt: skip


def polygon(shape):
    """The contour for shapely, arcs as chords within 0.1 µm."""
    points = [shape[0]]
    for each in shape[1:]:
        if len(each) == 2:
            points.append(each)
            continue
        x, y, i, j, clockwise = each
        radius = math.dist(points[-1], (i, j))
        begin = math.atan2(points[-1][1] - j, points[-1][0] - i)
        sweep = (math.atan2(y - j, x - i) - begin) * (-1 if clockwise else 1) % math.tau or math.tau
        count = math.ceil(sweep / (2 * math.acos(1 - 1e-4 / radius)))
        turn = -sweep if clockwise else sweep
        points += [(i + radius * math.cos(begin + turn * k / count), j + radius * math.sin(begin + turn * k / count)) for k in range(1, count + 1)]
    return Polygon(points)


def backwards(shape):
    found = [shape[-1][:2]]
    for each, before in zip(shape[:0:-1], shape[-2::-1]):
        found.append((*before[:2], *each[2:4], not each[4]) if len(each) == 5 else before[:2])
    return tuple(found)


def start_of(shape):
    """(first place, unit vector along the contour there)."""
    first, second = shape[0], shape[1]
    along = complex(*second[:2]) - complex(*first[:2])
    if len(second) == 5:
        along = (complex(*first[:2]) - complex(*second[2:4])) * (-1j if second[4] else 1j)
    return complex(*first[:2]), along / abs(along)


def program(shape, side, radius, lead=1.0):
    """The contour as an NGC program, entered and left square to its first piece."""
    place, along = start_of(shape)
    away = place + along * 1j * side * (radius + lead)
    rows = [f"g0 x{away.real:.6f} y{away.imag:.6f}", f"g4{1 if side > 0 else 2} d1 g1 x{place.real:.6f} y{place.imag:.6f} f100"]
    before = shape[0]
    for each in shape[1:]:
        if len(each) == 2:
            rows.append(f"g1 x{each[0]:.6f} y{each[1]:.6f}")
        else:
            rows.append(f"g{2 if each[4] else 3} x{each[0]:.6f} y{each[1]:.6f} i{each[2] - before[0]:.6f} j{each[3] - before[1]:.6f}")
        before = each
    return "\n".join([*rows, f"g40 g1 x{away.real:.6f} y{away.imag:.6f}"])


def path_of(text, radius):
    listing = Listing()
    compile_program("p.ngc", text, listing, {1: Tool(2 * radius)}, NOWHERE)
    assert listing.warnings == []
    (points,) = cut_points(events(listing.codes))
    return points


def compare(shape, side, radius):
    """Raises ProgramError if the contour is refused."""
    points = path_of(program(shape, side, radius), radius)
    ring = LinearRing(points[1:-1])
    told = polygon(shape)
    outside = side == RIGHT if LinearRing(told.exterior.coords).is_ccw else side == LEFT
    wanted = told.buffer(radius if outside else -radius, quad_segs=500).boundary
    assert ring.hausdorff_distance(wanted) < WITHIN, (ring.wkt, wanted.wkt)
    assert ring.length == pytest.approx(wanted.length, abs=0.05)
    return points


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("name", SHAPES)
def test_shapes(name, turned):
    """Outside and inside, in both directions, with several tools."""
    shape = backwards(SHAPES[name]) if turned else SHAPES[name]
    for side in (LEFT, RIGHT):
        for radius in (0.5, 1.0, 2.0):
            compare(shape, side, radius)


def test_a_pocket_with_an_island():
    """The tool goes around inside the pocket, and outside around the island; both in one program."""
    pocket, island = ROUNDED, tuple((x / 4 + 7, y / 4 + 8) for x, y in SQUARE)
    text = program(pocket, LEFT, 2.0, 0.5) + "\ng0 z5\n" + program(backwards(island), LEFT, 2.0, 0.5)
    listing = Listing()
    compile_program("p.ngc", text, listing, {1: Tool(4.0)}, NOWHERE)
    around = [LineString(points[1:-1]) for points in cut_points(events(listing.codes))]
    free = polygon(pocket).buffer(-2.0, quad_segs=500), polygon(island).buffer(2.0, quad_segs=500)
    for path, wanted in zip(around, free, strict=True):
        assert path.hausdorff_distance(wanted.boundary) < WITHIN


def test_an_arc_of_the_tools_own_radius():
    """The tool turns on the spot in the pocket's corners."""
    points = path_of(program(ROUNDED, LEFT, 4.0), 4.0)
    wanted = Polygon([(4, 4), (16, 4), (16, 16), (4, 16)]).boundary
    assert LinearRing(points[1:-1]).hausdorff_distance(wanted) < WITHIN
    for radius in (4.01, 7.0):
        with pytest.raises(ProgramError) as refusal:
            compare(ROUNDED, LEFT, radius)
        assert refusal.value.number == 343 and refusal.value.place.line == 4


def random_contour(draw):
    """A polygon without crossings, beginning in the middle of its longest side."""
    count = draw.randrange(3, 12)
    angles = sorted(draw.uniform(0, math.tau) for _ in range(count))
    if max(b - a for a, b in zip(angles, angles[1:] + [angles[0] + math.tau])) > 3:
        return random_contour(draw)
    far = [draw.uniform(10, 30) for _ in range(count)]
    corners = [(radius * math.cos(angle), radius * math.sin(angle)) for radius, angle in zip(far, angles)]
    longest = max(range(count), key=lambda k: math.dist(corners[k], corners[k - 1]))
    corners = corners[longest:] + corners[:longest]
    middle = tuple((a + b) / 2 for a, b in zip(corners[-1], corners[0]))
    return (middle, *corners, middle)


def test_random_polygons():
    """150 polygons with corners of any angle. If one is refused, the tool cannot touch every side of it, or its lead is too long."""
    draw = random.Random(7)
    fitted = refused = 0
    for _ in range(150):
        shape = random_contour(draw)
        side, radius = draw.choice((LEFT, RIGHT)), draw.uniform(0.2, 3.0)
        try:
            compare(shape, side, radius)
            fitted += 1
        except ProgramError as error:
            refused += 1
            room = polygon(shape).buffer(radius if side == RIGHT else -radius, quad_segs=500).boundary
            sides = [LineString([a[:2], b[:2]]) for a, b in zip(shape, shape[1:])]
            inner = [LineString([each.interpolate(0.05, normalized=True), each.interpolate(0.95, normalized=True)]) for each in sides]
            far = max(room.distance(each) for each in inner) > radius + 5e-5
            split = room.geom_type != "LineString"
            place, along = start_of(shape)
            lead = Point(*(lambda p: (p.real, p.imag))(place + along * 1j * side * (radius + 1)))
            assert far or split or error.number in (342, 345) and lead.distance(LinearRing([each[:2] for each in shape])) < radius + 0.99, str(error)
    assert fitted > 90 and refused > 10, (fitted, refused)


def test_entries():
    """From ahead, beside and behind; the way in keeps off the contour."""
    contour = LineString([(0, 0), (30, 0)])
    for x, y in ((-10, 0), (-10, 10), (0, 10), (10, 10), (-5, -6), (-10, -3)):
        points = path_of(f"g0 x{x} y{y}\ng41 d1 g1 x0 y0 f100\nx30\ng40 g1 x40 y5", 3.0)
        assert points[0] == (x, y) and points[-1] == (40, 5)
        assert LineString(points).distance(contour) == pytest.approx(3.0, abs=0.005)


def test_tiny_arcs_make_no_whole_turns():
    """Corners of a fine polygon, and arcs of a great radius: an arc whose rounded ends are one place is a whole turn for a board."""
    rows = [f"x{40 * math.cos(a / 2000):.5f} y{40 * math.sin(a / 2000):.5f}" for a in range(1, 400)]
    points = path_of("\n".join(["g0 x50 y0", "g42 d1 g1 x40 y0 f100", *rows, "g40 x50 y20"]), 3.0)
    assert LineString(points).length < 40 and max(math.hypot(*point) for point in points[1:-1]) < 43.001
    listing = Listing()
    compile_program("p.ngc", "g0 x0 y0\ng3 x0.000001 y0.001 i-1000 f100\ng3 x0 y0 i-1000", listing, {}, NOWHERE)
    assert listing.codes[1] == "G1 Y0.001 F100" and listing.codes[2].startswith("G3")


def test_heights_and_words_inside_a_contour():
    listing = Listing()
    text = "g0 x-10 y0 z5\ng41 d1 g0 x0 y0\ng1 z-1 f60\nm8\ny10 z-2\nx10\nm9\ng0 z5\ng40\ng0 z6\ng0 x0 y0"
    compile_program("p.ngc", text, listing, {1: Tool(4.0)}, NOWHERE)
    assert listing.codes == [
        "G0 X-10 Y0 Z5", "G0 X-2", "G1 Z-1 F60", "M8", "G1 Y10 Z-2", "G2 X0 Y12 I2 J0", "G1 X10", "M9", "G0 Z5", "G0 Z6", "G0 X0 Y0",
    ]  # fmt: skip


def test_a_narrow_passage():
    """A slot of 0.8 mm into a chamber: further away than the look-ahead, it is a warning, because passes may overlap."""
    chamber = [(-0.4 + 8 * math.sin(k * 0.37 + 0.05), 18 - 8 * math.cos(k * 0.37 + 0.05)) for k in range(17)]
    rows = [f"x{x:.4f} y{y:.4f}" for x, y in [(0, 10), *chamber, (-0.8, 10), (-0.8, 0), (-6, 0)]]
    for radius, warned in ((0.3, False), (0.5, True)):
        listing = Listing()
        text = "\n".join(["g0 x-3 y-3", "g41 d1 g1 x0 y-3 f100", *rows, "g40 y-5"])
        compile_program("p.ngc", text, listing, {1: Tool(2 * radius)}, NOWHERE)
        assert bool(listing.warnings) == warned
        assert all("comes to 0.3" in each and "from line" in each for each in listing.warnings)
    with pytest.raises(ProgramError) as refusal:
        rows = ["g0 x-3 y-3", "g41 d1 g1 x0 y-3 f100", "y10", "x3 y14", "x-3 y14", *rows[-3:]]
        compile_program("p.ngc", "\n".join(rows), Listing(), {1: Tool(1.0)}, NOWHERE)
    assert refusal.value.number == 344


def test_pieces():
    """The offset alone, with the numbers of the contour's pieces."""
    path = offset_contour([Piece(0, 10), Piece(10, 10 + 10j), Piece(10 + 10j, 20 + 10j)], LEFT, 2.0)
    assert [number for _, number in path] == [0, 1, 2, 2]
    ends = [piece.end for piece, _ in path]
    assert all(abs(a - b) < 1e-9 for a, b in zip(ends, (8 + 2j, 8 + 10j, 10 + 12j, 20 + 12j)))
