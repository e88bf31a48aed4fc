"""Polylines (complex numbers, x + iy) cut by areas, and areas made of closed polylines.

    area = fill_area(rings, "evenodd")                 # a shapely geometry
    inside = clip_lines(lines, area)

Lines are cut segment by segment, so that a line that crosses itself stays one line.
"""

import numpy
import shapely

_SAME_PX = 1e-7
_FEW_EDGES, _MOST_CROSSINGS = 300, 20_000


def rectangle(left, top, right, bottom):
    return shapely.box(left, top, right, bottom)


def fill_area(rings, rule):
    """Return the area that `rings`, closed or to be closed, enclose by the rule "nonzero" or "evenodd". Raises ValueError if their edges cross too
    often."""
    closed = []
    for ring in rings:
        ring = _without_repeats(numpy.append(ring, ring[0]))
        if len(ring) > 3:
            closed.append(ring)
    if not closed:
        return shapely.Polygon()
    _check_crossings(closed)
    drawn = shapely.unary_union([shapely.LineString(_xy_pairs(ring)) for ring in closed])
    faces = shapely.get_parts(shapely.polygonize([drawn]))
    inside = []
    for face in faces:
        position = shapely.point_on_surface(face)
        turns = sum(_winding_number(ring, complex(position.x, position.y)) for ring in closed)
        if turns % 2 if rule == "evenodd" else turns:
            inside.append(face)
    return shapely.unary_union(inside) if inside else shapely.Polygon()


def _check_crossings(rings):
    """Raise ValueError if edges cross too often: each crossing makes a face, and each face is compared with each edge."""
    pairs = [_xy_pairs(ring) for ring in rings]
    edges = shapely.linestrings(numpy.concatenate([numpy.stack((each[:-1], each[1:]), axis=1) for each in pairs]))
    if len(edges) < _FEW_EDGES:
        return
    tree, crossings = shapely.STRtree(edges), 0
    for begin in range(0, len(edges), _FEW_EDGES):
        crossings += tree.query(edges[begin : begin + _FEW_EDGES], "crosses").shape[1]
        if crossings > _MOST_CROSSINGS:
            raise ValueError(f"an area whose edges cross more than {_MOST_CROSSINGS // 2} times")


def grow_area(area, by):
    """Return `area` with its edges `by` px further out, so that a line along an edge lies within it for certain."""
    return shapely.buffer(area, by, join_style="mitre", cap_style="square")


def edge_lines(area):
    """Return the closed lines around an area and its holes."""
    rings = []
    for part in shapely.get_parts(area):
        if part.geom_type == "Polygon" and not part.is_empty:
            rings += [part.exterior, *part.interiors]
    return [numpy.array([complex(*place) for place in ring.coords]) for ring in rings]


def clip_lines(lines, area):
    """Return the parts of `lines` inside `area`, in their order and direction. A dot is a line of the same position twice."""
    shapely.prepare(area)
    left, top, right, bottom = area.bounds if not area.is_empty else (0.0, 0.0, -1.0, -1.0)
    box_is_area = not area.is_empty and area.area >= (right - left) * (bottom - top) * (1 - 1e-12)
    kept = []
    for line in lines:
        xs, ys = line.real, line.imag
        if xs.min() > right or xs.max() < left or ys.min() > bottom or ys.max() < top:
            continue
        in_box = xs.min() >= left and xs.max() <= right and ys.min() >= top and ys.max() <= bottom
        if in_box and box_is_area:
            kept.append(line)
        else:
            kept += _cut_line(line, area)
    return kept


def subtract_area(lines, area):
    """Return the parts of `lines` outside `area`."""
    if area.is_empty:
        return lines
    left, top, right, bottom = area.bounds
    kept = []
    for line in lines:
        xs, ys = line.real, line.imag
        if xs.min() > right or xs.max() < left or ys.min() > bottom or ys.max() < top:
            kept.append(line)
        else:
            around = rectangle(min(xs.min(), left), min(ys.min(), top), max(xs.max(), right), max(ys.max(), bottom))
            kept += _cut_line(line, shapely.difference(grow_area(around, max(right - left, bottom - top)), area))
    return kept


def _cut_line(line, area):
    """Return the parts of a line inside an area, in its direction; the line itself if it lies inside as a whole."""
    points = _xy_pairs(_without_repeats(line))
    if len(points) < 2:
        return [line] if shapely.intersects(area, shapely.Point(points[0])) else []
    if shapely.covers(area, shapely.LineString(points)):
        return [line]
    segments = shapely.linestrings(numpy.stack((points[:-1], points[1:]), axis=1))
    whole = shapely.covers(area, segments)
    touched = shapely.intersects(area, segments)
    runs = []
    for segment, is_whole, is_touched, start, end in zip(segments, whole, touched, points, points[1:]):
        if is_whole:
            _append_piece(runs, complex(*start), complex(*end))
        elif is_touched:
            for a, b in _segment_pieces(shapely.intersection(segment, area), complex(*start)):
                _append_piece(runs, a, b)
    return [numpy.array(run) for run in runs]


def _append_piece(runs, a, b):
    """Append the way from `a` to `b` to the last run if that ends at `a` within _SAME_PX, else as a new run."""
    if runs and abs(runs[-1][-1] - a) < _SAME_PX:
        runs[-1].append(b)
    else:
        runs.append([a, b])


def _segment_pieces(geometry, start):
    """Return the remaining parts of a segment, as pairs of positions in its direction."""
    found = []
    for part in shapely.get_parts(geometry):
        if part.geom_type == "LineString" and not part.is_empty:
            ends = sorted((complex(*part.coords[0]), complex(*part.coords[-1])), key=lambda position: abs(position - start))
            found.append(tuple(ends))
    return sorted(found, key=lambda ends: abs(ends[0] - start))


def _without_repeats(line):
    return line[numpy.append(True, line[1:] != line[:-1])]


def _xy_pairs(line):
    return numpy.column_stack((line.real, line.imag))


def _winding_number(ring, position):
    """Return how often a closed ring goes round `position`, which is not on it."""
    turned = numpy.angle((ring[1:] - position) / (ring[:-1] - position)).sum()
    return round(turned / (2 * numpy.pi))
