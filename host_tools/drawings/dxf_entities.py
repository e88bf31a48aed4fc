"""Entities of a DXF document as other programs show them, where ezdxf would draw something else.

    mend_document(document)
    check_size(document)        # raises TooMany: blocks in blocks and arrays multiply

A spline whose knots begin or end outside its domain is cut to it (de Boor's knots by Boehm's insertion, The NURBS Book, A5.1). The frame of a
polyline or mesh that was made a spline is removed: no program draws it.
"""

import numpy
from ezdxf.entities import Hatch, Insert, MPolygon, Polyline, Spline

_FRAME = 16  # of a vertex: a control point of the frame
_SAME = 1e-9  # knots nearer than this, of the whole span, are one
_MOST = 25_000  # entities of blocks, as often as they are inserted: some 3 s
_LETTERS, _VERTICES = 1, 10  # that take as long as an entity


class TooMany(ValueError):
    """Its text is the name of a block that is too much to draw."""


def mend_document(document):
    """Change the entities that ezdxf would draw in another way than CAD programs do."""
    for entity in document.entitydb.values():
        if isinstance(entity, Insert) and not entity.dxf.zscale:
            entity.dxf.zscale = 1.0  # of a flat block: ezdxf would divide by it
        elif isinstance(entity, Spline):
            _clamp_spline(entity)
        elif isinstance(entity, Polyline):
            _remove_frame(entity)
        elif isinstance(entity, (Hatch, MPolygon)):
            for edge in (each for path in entity.paths for each in getattr(path, "edges", ())):
                if hasattr(edge, "knot_values"):
                    found = clamp_knots(edge.control_points, edge.knot_values, edge.weights, edge.degree)
                    if found:
                        edge.control_points, edge.knot_values, edge.weights = found


def _clamp_spline(spline):
    found = clamp_knots(spline.control_points, spline.knots, spline.weights, spline.dxf.degree)
    if found:
        spline.control_points, spline.knots, spline.weights = found


def clamp_knots(points, knots, weights, degree):
    """Return (points, knots, weights) of the same curve whose knots begin and end with its domain (The NURBS Book, A5.1); None if they do already,
    or are no knots."""
    points, knots = [tuple(each) for each in points], numpy.array(knots, dtype=float)
    count = len(points)
    if degree < 1 or count <= degree or len(knots) != count + degree + 1 or len(weights) not in (0, count):
        return None
    begin, end = knots[degree], knots[count]
    if not begin < end or (numpy.diff(knots) < 0).any():
        return None
    near = _SAME * (end - begin)
    if knots[0] > begin - near and knots[-1] < end + near:
        return None
    of_weight = numpy.array(weights if len(weights) else [1.0] * count)[:, None]
    rows = numpy.hstack((numpy.array(points, dtype=float) * of_weight, of_weight))
    for knot, side in ((begin, "right"), (end, "left")):
        for _again in range(degree - int((abs(knots - knot) <= near).sum())):
            rows, knots = _with_knot(rows, knots, knot, side, degree)
    first = int(numpy.flatnonzero(knots <= begin + near)[-1]) - degree
    last = int(numpy.flatnonzero(knots >= end - near)[0]) - 1
    rows, inner = rows[first : last + 1], knots[(knots > begin + near) & (knots < end - near)]
    knots = numpy.concatenate(([begin] * (degree + 1), inner, [end] * (degree + 1))) - begin
    if len(knots) != len(rows) + degree + 1:
        return None
    places = [tuple(row) for row in (rows[:, :-1] / rows[:, -1:]).tolist()]
    return places, knots.tolist(), rows[:, -1].tolist() if len(weights) else []


def _with_knot(rows, knots, knot, side, degree):
    """Insert one more knot, on that side of its equals, and a row more, without a change of the curve (Boehm, 1980)."""
    at = int(numpy.searchsorted(knots, knot, side)) - 1
    changed = []
    for index in range(at - degree + 1, at + 1):
        share = (knot - knots[index]) / (knots[index + degree] - knots[index])
        changed.append(share * rows[index] + (1 - share) * rows[index - 1])
    return numpy.vstack((rows[: at - degree + 1], changed, rows[at:])), numpy.insert(knots, at + 1, knot)


def _remove_frame(polyline):
    """Remove the vertices of the frame of a spline polyline or mesh, in place. Nothing changes if all vertices or none are the frame's, or the mesh's
    size does not fit."""
    kept = [vertex for vertex in polyline.vertices if not vertex.dxf.flags & _FRAME]
    if not kept or len(kept) == len(polyline.vertices):
        return
    if polyline.is_polygon_mesh:
        size = polyline.dxf.m_smooth_density, polyline.dxf.n_smooth_density
        if size[0] * size[1] != len(kept):
            return
        polyline.dxf.m_count, polyline.dxf.n_count = size
    polyline.vertices[:] = kept


def check_size(document):
    """Raise TooMany if blocks in blocks, and arrays of them, are too many entities to draw."""
    counts = {}

    def count_block(name, inside):
        """Return the count of entities of a block, 0 if there is none or it contains itself. `inside`: names of the blocks around it."""
        block = document.blocks.get(name)
        if block is None or name in inside:
            return 0  # ezdxf names a block that contains itself
        if name not in counts:
            counts[name] = count_layout(block, (*inside, name))
        return counts[name]

    def count_layout(layout, inside=()):
        """Return the count of entities of a layout, inserted blocks as often as their arrays repeat them. Raises TooMany if an insert counts more
        than _MOST."""
        total = 0
        for entity in layout:
            count = _weight_of(entity)
            if isinstance(entity, Insert):
                count = max(1, entity.mcount) * (1 + count_block(entity.dxf.name, inside) + len(entity.attribs))
            elif entity.dxf.hasattr("geometry"):
                count += count_block(entity.dxf.geometry, inside)  # of a dimension
            if count > _MOST and entity.dxf.hasattr("name"):
                raise TooMany(entity.dxf.name)
            total += count
        return total

    space = document.modelspace()
    if count_layout(space) - sum(map(_weight_of, space)) > _MOST:
        raise TooMany(next(entity.dxf.name for entity in space if isinstance(entity, Insert)))


def _weight_of(entity):
    """Return as how many simple entities this one counts, by the time that it takes."""
    if entity.dxftype() in ("TEXT", "MTEXT", "ATTRIB"):
        return 1 + len(entity.dxf.get("text", "")) // _LETTERS
    return 1 + (len(entity) if hasattr(entity, "__len__") else 0) // _VERTICES
