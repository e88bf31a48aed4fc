"""The path of a tool's centre beside a contour of lines and arcs: radius compensation.

    contour = [Piece(0, 10), Piece(10, 10 + 5j, …)]
    for piece, number in offset_contour(contour, LEFT, 3.0): …        # `number` of the contour's piece that it belongs to

Points are complex numbers, x + y·j, in mm. Outside corners get an arc around the corner, at inside corners the tool turns where
it touches both sides. An inside corner or arc that the tool does not fit into is refused, never rounded over.

`gouges` says where a path comes nearer to the contour than the radius: at places that are no neighbours, on the way in or out.
"""

import cmath
import math
from dataclasses import dataclass

from host_tools.programs.program_errors import DOES_NOT_FIT, ENTRY, ProgramError

LEFT, RIGHT = 1, -1
SMALL = 1e-6  # mm: less is no distance
_SMOOTH = 1e-4  # sine of a corner that is none
TOUCH = 0.005  # mm that a path may come nearer than the radius: the inexactness of a program's arcs
_SAG = 0.0005  # mm between an arc and the chords that it is checked by


@dataclass
class Piece:
    """A line, or an arc of less than a turn, or a whole one: of that start and end are the same, but so may be those of an arc of which
    next to nothing is left."""

    start: complex
    end: complex
    centre: complex | None = None
    clockwise: bool = False
    whole: bool = False

    def __post_init__(self):
        self.start, self.end = complex(self.start), complex(self.end)
        if self.centre is not None:
            self.centre = _on_bisector(self.start, self.end, complex(self.centre))

    @property
    def radius(self):
        return abs(self.start - self.centre)

    @property
    def sweep(self):
        """The angle of the arc in radians, positive in either direction."""
        if self.whole:
            return math.tau
        return self.angle_to(self.end) if abs(self.start - self.end) > SMALL else 0.0

    def angle_to(self, point):
        """Return the radians from the start to `point`, in the arc's direction, 0 … 2π."""
        ratio = (point - self.centre) / (self.start - self.centre)
        return (-cmath.phase(ratio) if self.clockwise else cmath.phase(ratio)) % math.tau

    @property
    def length(self):
        return abs(self.end - self.start) if self.centre is None else self.radius * self.sweep

    def direction_at(self, at):
        """Return the unit vector along the piece at its point `at`."""
        if self.centre is None:
            return (self.end - self.start) / abs(self.end - self.start)
        return (at - self.centre) / abs(at - self.centre) * (-1j if self.clockwise else 1j)

    def point_beside(self, at, distance):
        """Return the point `distance` mm to the left of the piece at its point `at`."""
        return at + 1j * self.direction_at(at) * distance

    def chord_points(self, sag=_SAG):
        """Return points on the piece whose chords are at most `sag` mm away from it."""
        if self.centre is None:
            return [self.start, self.end]
        step = 2 * math.acos(max(0.0, 1 - sag / self.radius)) if self.radius > sag else math.pi / 4
        count = max(1, math.ceil(self.sweep / step))
        turn = self.sweep / count * (-1 if self.clockwise else 1)
        spoke = self.start - self.centre
        return [self.centre + spoke * cmath.rect(1, turn * each) for each in range(count)] + [self.end]


def _on_bisector(start, end, centre):
    """Return the centre, moved so that both ends are equally far from it: programs round theirs."""
    chord = end - start
    if abs(chord) < SMALL:
        return centre
    along = chord / abs(chord)
    middle = (start + end) / 2
    return centre - along * ((centre - middle) * along.conjugate()).real


def _cross_product(a, b):
    return (a.conjugate() * b).imag


def _dot_product(a, b):
    return (a.conjugate() * b).real


def offset_contour(contour, side, radius):
    """Move a contour by the tool's radius (mm) to one side; return [(piece, number in the contour)]. Its first piece begins, and its last ends,
    square to the contour. Raises ProgramError; if a pair of pieces does not fit, without a detail, and `pieces` are their numbers."""
    path = []
    for number, piece in enumerate(contour):
        beside = _offset_piece(piece, side * radius)
        if beside is None:
            if piece.radius < radius - SMALL:
                raise _misfit_error(number, number, "radius {:.3f} of the arc, {:.3f} of the tool", piece.radius, radius)
            continue  # the tool turns on the spot: it has the arc's own radius
        if path:
            before, origin = path[-1]
            corner = contour[number - 1].end
            turn = side * _turn_sine(contour[number - 1], piece)
            if turn < -_SMOOTH or math.isnan(turn):
                path.append((Piece(before.end, beside.start, corner, side == LEFT), number))
            elif turn > _SMOOTH or origin != number - 1:
                path[-1], beside = _join_at_crossing(path[-1], beside, number)
            else:
                beside = _cut_piece(beside, before.end, beside.end, beside.whole)
        path.append((beside, number))
    return path


def _turn_sine(before, piece):
    """Return the sine of the angle by which the contour turns left between two pieces; 2 or -2 if it turns back, to the left or the right by the
    points beside the corner; nan if it goes back on itself."""
    into, out = before.direction_at(before.end), piece.direction_at(piece.start)
    sine = _cross_product(into, out)
    if abs(sine) > _SMOOTH or _dot_product(into, out) > 0:
        return sine
    # Back along a line: around its end, on either side. Two arcs that meet in a cusp have it on one side only.
    behind, ahead = (each.chord_points()[at] - before.end for each, at in ((before, -2), (piece, 1)))
    between = _cross_product(-behind / abs(behind), ahead / abs(ahead))
    return math.copysign(2, between) if abs(between) > SMALL else math.nan


def lead_around(place, corner, start, side, radius):
    """Return the pieces from `place` to `start`, which lies a radius beside `corner`: a line that touches the circle around the corner, then along
    the circle, so that they never come nearer. None if `place` is too near."""
    away = place - corner
    if abs(away) < radius:
        return None
    if _dot_product(start - place, start - corner) <= 0:
        return [Piece(place, start)]
    touch = corner + cmath.rect(radius, cmath.phase(away) - side * math.acos(radius / abs(away)))
    return [Piece(place, touch), Piece(touch, start, corner, side == LEFT)]


def lead_alongside(entry, first, path, side, radius):
    """Return the pieces of a way in that ends beside the end of `entry`, in its direction, then goes around the corner to the start of `path`. The
    start of `entry` is the tool's centre, its end the tool's edge. At an inside corner `path` begins later. `first`: the contour's first piece,
    or None. Raises ProgramError."""
    into = entry.direction_at(entry.end)
    end = entry.end + 1j * into * side * radius
    way = Piece(entry.start, end) if entry.centre is None else _tangent_arc(entry, end, into, radius)
    if first is None:
        return [way]
    turn = side * _turn_sine(entry, first)
    if turn < -_SMOOTH or math.isnan(turn):
        return [way, Piece(end, path[0][0].start, first.start, side == LEFT)]
    if turn > _SMOOTH:
        (way, _), beside = _join_at_crossing((way, 0), path[0][0], 0)
        path[0] = beside, path[0][1]
    return [way]


def _tangent_arc(entry, end, into, radius):
    """Return the arc from the start of `entry` that arrives at `end` in the direction `into`. Raises ProgramError if the arc's radius is below the
    tool's."""
    inward = into * (-1j if entry.clockwise else 1j)
    off = entry.start - end
    height = _dot_product(inward, off)
    if height < SMALL:
        raise ProgramError(ENTRY, "the arc's radius is {:.3f}, the tool's {:.3f}", entry.radius, radius)
    return Piece(entry.start, end, end + inward * (_dot_product(off, off) / (2 * height)), entry.clockwise)


def _misfit_error(first, second, detail="", *values):
    error = ProgramError(DOES_NOT_FIT, detail, *values)
    error.pieces = (first, second)
    return error


def _offset_piece(piece, left):
    """Return the piece moved `left` mm to its left; None if nothing is left of an arc."""
    if piece.centre is not None:
        if piece.radius + (left if piece.clockwise else -left) < SMALL:
            return None
    return _cut_piece(piece, piece.point_beside(piece.start, left), piece.point_beside(piece.end, left), piece.whole)


def _cut_piece(piece, start, end, whole=False):
    moved = Piece.__new__(Piece)
    moved.start, moved.end, moved.centre, moved.clockwise, moved.whole = start, end, piece.centre, piece.clockwise, whole
    return moved


def _join_at_crossing(before, beside, number):
    """Cut two offset pieces around an inside corner where they cross. Raises ProgramError if they do not."""
    first, origin = before
    if abs(first.end - beside.start) < 10 * SMALL:
        return before, beside
    found = [point for point in crossings(first, beside) if _is_on_piece(first, point) and _is_on_piece(beside, point)]
    if not found:
        raise _misfit_error(origin, number)
    # Of two crossings the first one on the way: beyond it the tool would cut into the contour.
    point = min(found, key=lambda point: _distance_along(beside, point) - _distance_along(first, point))
    cut = _cut_piece(first, first.start, point)
    if abs(cut.start - cut.end) < SMALL and first.whole:
        raise _misfit_error(origin, number)
    return (cut, origin), _cut_piece(beside, point, beside.end)


def _distance_along(piece, point):
    if piece.centre is None:
        return _dot_product(piece.direction_at(piece.start), point - piece.start)
    return piece.angle_to(point) * piece.radius


def _is_on_piece(piece, point):
    """True if `point`, which lies on the line or circle of the piece, lies on the piece."""
    if min(abs(point - piece.start), abs(point - piece.end)) < SMALL:
        return True
    if piece.centre is None:
        return abs(piece.end - piece.start) > SMALL and 0 < _distance_along(piece, point) < piece.length
    return piece.angle_to(point) <= piece.sweep


def crossings(a, b):
    """Return the points where the lines and circles of two pieces cross; one point for circles that touch."""
    if a.centre is None and b.centre is None:
        across = _cross_product(a.end - a.start, b.end - b.start)
        if abs(across) < SMALL * SMALL:
            return []
        return [a.start + (a.end - a.start) * (_cross_product(b.start - a.start, b.end - b.start) / across)]
    if a.centre is None:
        return _line_and_circle(a, b)
    if b.centre is None:
        return _line_and_circle(b, a)
    apart = b.centre - a.centre
    distance = abs(apart)
    if distance < SMALL:
        return []
    along = (distance * distance + a.radius**2 - b.radius**2) / (2 * distance)
    return _crossing_pair(a.centre + apart / distance * along, apart / distance * 1j, a.radius, along)


def _line_and_circle(line, arc):
    """Return the points, mm, where the endless line crosses the arc's circle; [] if there is none, or the line is shorter than SMALL."""
    if abs(line.end - line.start) < SMALL:
        return []
    way = line.direction_at(line.start)
    foot = line.start + way * _dot_product(way, arc.centre - line.start)
    return _crossing_pair(foot, way, arc.radius, abs(foot - arc.centre))


def _crossing_pair(middle, way, radius, height):
    """Return the two points on a line (`middle`, unit vector `way`) that are `radius` mm from a centre `height` mm beside `middle`; [] if the centre
    is farther away."""
    square = radius * radius - height * height
    if square < -2 * radius * SMALL:
        return []
    reach = math.sqrt(max(0.0, square))
    return [middle - way * reach, middle + way * reach]


def gouges(path, contour, radius):
    """Return [(number in `path`, number in `contour`, distance in mm)] of the pieces that come nearer to each other than the radius. Needs shapely."""
    import numpy
    from shapely import LineString, STRtree, distance

    if not path or not contour:
        return []
    told = [LineString([(point.real, point.imag) for point in piece.chord_points()]) for piece in contour]
    ways = [LineString([(point.real, point.imag) for point in piece.chord_points()]) for piece in path]
    least = radius - TOUCH
    of_path, of_contour = STRtree(told).query(ways, predicate="dwithin", distance=least)
    apart = distance(numpy.array(ways)[of_path], numpy.array(told)[of_contour])
    return [(int(one), int(other), float(far)) for one, other, far in zip(of_path, of_contour, apart) if far < least]
