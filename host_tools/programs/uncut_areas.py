"""The areas that a contour leaves standing: the areas beside it that no piece of it wants gone.

    kept = UncutAreas(pieces, LEFT)
    kept.known                  # False: the contour encloses nothing, each of its pieces has material behind it
    kept.reaches_area(piece, 3.0)    # does a tool of this radius on its way along `piece` cut into what is left?

The pieces, as chords, divide the plane into areas. Each piece marks the area on the tool's side as cut, and the other one as
standing; an area that no piece marks as cut is left. Ends that divide nothing, such as lead-ins, lead-outs and edges longer than the part,
lie in the air. An area is disputed if the first or the last piece alone takes it and others leave it: that is a lead through the part, or
a pass of its own. Needs shapely. Costs some 0.2 ms a piece: ask only for pieces that come too near.
"""

import numpy
import shapely

from host_tools.programs.compensation import TOUCH

_GRID = TOUCH / 2  # mm: ends that lie nearer to each other are the same
_BESIDE = 2 * TOUCH  # mm beside a piece: which area lies there
_NOISE = 0.02  # share of an area's edge that may say otherwise, where passes lie on each other
_TANGENT = 0.1  # the same, where a lead touches a piece along it


class UncutAreas:
    def __init__(self, pieces, side):
        self.known = False
        self.doubtful = False  # more of the contour divides nothing than encloses something
        self._area = self._disputed = None
        ends = [point for piece in pieces for pair in _chords_of(piece) for point in pair]
        starts, stops = numpy.array(ends[::2]), numpy.array(ends[1::2])
        ahead = (stops - starts) / numpy.abs(stops - starts)
        starts[0] -= ahead[0] * _BESIDE  # a piece that ends on another one, but for rounding, crosses it
        stops[-1] += ahead[-1] * _BESIDE
        chords = _line_strings(starts, stops)
        edges = shapely.get_parts(shapely.unary_union(chords, grid_size=_GRID))
        edges = edges[shapely.length(edges) > 0]
        areas = shapely.get_parts(shapely.polygonize(edges))
        if len(areas):
            counts = [len(_chords_of(piece)) for piece in pieces]
            inner = numpy.ones(len(chords), bool)
            inner[: counts[0]] = inner[len(chords) - counts[-1] :] = False
            self._judge_areas(edges, areas, chords, ahead * side, inner)

    def _judge_areas(self, edges, areas, chords, ahead, inner):
        """`ahead`: of each chord the way with the tool to its left; `inner`: it is of neither the first nor the last piece."""
        middles, ways = _longest_chords(edges)
        inside = shapely.STRtree(areas)
        sides = [_areas_of(inside, middles + 1j * ways * by) for by in (_BESIDE, -_BESIDE)]
        of_edge, of_chord = shapely.STRtree(chords).query(_point_geometries(middles), predicate="dwithin", distance=TOUCH)
        along = (ways[of_edge].conjugate() * ahead[of_chord]).real
        goes = [numpy.zeros(len(edges), bool), numpy.zeros(len(edges), bool)]
        goes[0][of_edge[along > 0.5]] = True
        goes[1][of_edge[along < -0.5]] = True
        between = numpy.zeros(len(edges), bool)
        between[of_edge[inner[of_chord]]] = True
        lengths = shapely.length(edges)
        divides = sides[0] != sides[1]
        if not divides.any():
            return

        def mm_by_area(say, of):
            """mm of the edges `of` that say so, by area; the last is what lies outside."""
            found = numpy.zeros(len(areas) + 1)
            for side in (0, 1):
                numpy.add.at(found, sides[side][of & say[side]], lengths[of & say[side]])
            return found

        stays_mm, goes_mm = mm_by_area(goes[::-1], divides), mm_by_area(goes, divides)
        left = (stays_mm > 0) & (goes_mm <= _NOISE * stays_mm)
        inner_mm = mm_by_area(goes[::-1], divides & between)
        disputed = ~left & (inner_mm > 0) & (mm_by_area(goes, divides & between) <= _TANGENT * inner_mm)
        if left[sides[0][~divides]].any():
            return  # a loop at the end of a line, not a line that leads to a loop
        self.known = True
        self.doubtful = bool(lengths[~divides].sum() > lengths[divides].sum())
        kept = [area for area, stays in zip(areas, left[:-1]) if stays]
        if left[-1]:
            kept.append(shapely.union_all(areas).envelope.buffer(1e5, join_style="mitre").difference(shapely.union_all(areas)))
        kept = [area for area in kept if not area.buffer(-TOUCH / 2).is_empty]
        self._area = shapely.union_all(kept) if kept else None
        taken = [area for area, this in zip(areas, disputed[:-1]) if this and not area.buffer(-TOUCH / 2).is_empty]
        self._disputed = shapely.union_all(taken) if taken else None

    def reaches_disputed(self, piece, radius):
        """True if the tool's centre, on `piece`, comes nearer than its radius to an area that other pieces leave and the first or the last takes."""
        return _is_nearer(piece, self._disputed, radius)

    def reaches_area(self, piece, radius):
        """True if the tool's centre, on `piece`, comes nearer than its radius to an area that the contour leaves."""
        return _is_nearer(piece, self._area, radius)


def _is_nearer(piece, area, radius):
    """True if the way of the tool's centre along a piece comes nearer to an area than `radius` mm, by more than TOUCH; False without an area."""
    if area is None:
        return False
    way = shapely.LineString([(point.real, point.imag) for point in piece.chord_points()])
    return bool(shapely.distance(way, area) < radius - TOUCH)


def _chords_of(piece):
    points = piece.chord_points()
    return [pair for pair in zip(points, points[1:]) if abs(pair[1] - pair[0]) > 1e-9]


def _line_strings(starts, stops):
    return shapely.linestrings(numpy.stack([numpy.stack([each.real, each.imag], -1) for each in (starts, stops)], 1))


def _point_geometries(places):
    return shapely.points(places.real, places.imag)


def _longest_chords(edges):
    """Return (middle, unit vector along it) of the longest chord of each edge."""
    middles, ways = [], []
    for edge in edges:
        points = shapely.get_coordinates(edge) @ numpy.array([1, 1j])
        steps = numpy.diff(points)
        at = int(numpy.argmax(numpy.abs(steps)))
        middles.append((points[at] + points[at + 1]) / 2)
        ways.append(steps[at] / abs(steps[at]))
    return numpy.array(middles), numpy.array(ways)


def _areas_of(tree, places):
    """Return the number of the area in which each place lies; the count of the areas if it lies in none."""
    found = numpy.full(len(places), len(tree.geometries))
    of_place, of_area = tree.query(_point_geometries(places), predicate="intersects")
    found[of_place] = of_area
    return found
