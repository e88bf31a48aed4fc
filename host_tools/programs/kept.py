"""What a contour leaves standing: the areas beside it that no piece of it wants gone.

    kept = Kept(pieces, LEFT)
    kept.known                  # False: the contour encloses nothing, each of its pieces has material behind it
    kept.reached(piece, 3.0)    # does a tool of this radius on its way along `piece` cut into what is left?

The pieces, as chords, divide the plane into areas. Each piece says of the area on the tool's side that it goes, of the other that it
stays; what only stays is left. Ends that divide nothing, such as lead-ins, lead-outs and edges longer than the part, lie in the air. Needs
shapely. Costs some 0.2 ms a piece: ask only for pieces that come too near.
"""

import numpy
import shapely

from host_tools.programs.compensation import TOUCH

_GRID = TOUCH / 2  # mm: ends that lie nearer to each other are the same
_BESIDE = 2 * TOUCH  # mm beside a piece: which area lies there
_NOISE = 0.02  # share of an area's edge that may say otherwise, where passes lie on each other


class Kept:
    def __init__(self, pieces, side):
        self.known = False
        self.doubtful = False  # more of the contour divides nothing than encloses something
        self._area = None
        ends = [point for piece in pieces for pair in _chords(piece) for point in pair]
        starts, stops = numpy.array(ends[::2]), numpy.array(ends[1::2])
        ahead = (stops - starts) / numpy.abs(stops - starts)
        starts[0] -= ahead[0] * _BESIDE  # what ends on another piece, but for rounding, crosses it
        stops[-1] += ahead[-1] * _BESIDE
        chords = _lines(starts, stops)
        edges = shapely.get_parts(shapely.unary_union(chords, grid_size=_GRID))
        edges = edges[shapely.length(edges) > 0]
        areas = shapely.get_parts(shapely.polygonize(edges))
        if len(areas):
            self._judge(edges, areas, chords, ahead * side)

    def _judge(self, edges, areas, chords, ahead):
        """`ahead`: of each chord the way with the tool to its left."""
        middles, ways = _longest(edges)
        inside = shapely.STRtree(areas)
        sides = [_areas_of(inside, middles + 1j * ways * by) for by in (_BESIDE, -_BESIDE)]
        of_edge, of_chord = shapely.STRtree(chords).query(_points(middles), predicate="dwithin", distance=TOUCH)
        along = (ways[of_edge].conjugate() * ahead[of_chord]).real
        goes = [numpy.zeros(len(edges), bool), numpy.zeros(len(edges), bool)]
        goes[0][of_edge[along > 0.5]] = True
        goes[1][of_edge[along < -0.5]] = True
        lengths = shapely.length(edges)
        divides = sides[0] != sides[1]
        if not divides.any():
            return
        stays_mm, goes_mm = numpy.zeros(len(areas) + 1), numpy.zeros(len(areas) + 1)  # the last is what lies outside
        for this, other in ((0, 1), (1, 0)):
            numpy.add.at(goes_mm, sides[this][divides & goes[this]], lengths[divides & goes[this]])
            numpy.add.at(stays_mm, sides[this][divides & goes[other]], lengths[divides & goes[other]])
        left = (stays_mm > 0) & (goes_mm <= _NOISE * stays_mm)
        if left[sides[0][~divides]].any():
            return  # a loop at the end of a line, not a line that leads to a loop
        self.known = True
        self.doubtful = bool(lengths[~divides].sum() > lengths[divides].sum())
        kept = [area for area, stays in zip(areas, left[:-1]) if stays]
        if left[-1]:
            kept.append(shapely.union_all(areas).envelope.buffer(1e5, join_style="mitre").difference(shapely.union_all(areas)))
        kept = [area for area in kept if not area.buffer(-TOUCH / 2).is_empty]
        self._area = shapely.union_all(kept) if kept else None

    def reached(self, piece, radius):
        """True if the tool's centre, on `piece`, comes nearer to what is left than its radius."""
        if self._area is None:
            return False
        way = shapely.LineString([(point.real, point.imag) for point in piece.points()])
        return bool(shapely.distance(way, self._area) < radius - TOUCH)


def _chords(piece):
    points = piece.points()
    return [pair for pair in zip(points, points[1:]) if abs(pair[1] - pair[0]) > 1e-9]


def _lines(starts, stops):
    return shapely.linestrings(numpy.stack([numpy.stack([each.real, each.imag], -1) for each in (starts, stops)], 1))


def _points(places):
    return shapely.points(places.real, places.imag)


def _longest(edges):
    """(middle, way along it) of the longest chord of each edge."""
    middles, ways = [], []
    for edge in edges:
        points = shapely.get_coordinates(edge) @ numpy.array([1, 1j])
        steps = numpy.diff(points)
        at = int(numpy.argmax(numpy.abs(steps)))
        middles.append((points[at] + points[at + 1]) / 2)
        ways.append(steps[at] / abs(steps[at]))
    return numpy.array(middles), numpy.array(ways)


def _areas_of(tree, places):
    """The number of the area in which each place lies; the count of the areas: in none."""
    found = numpy.full(len(places), len(tree.geometries))
    of_place, of_area = tree.query(_points(places), predicate="intersects")
    found[of_place] = of_area
    return found
