"""Finds room for several drawings on one sheet: each as low as it goes, then as far left, turned by quarters if that helps. Then in lower and
lower strips: each as far left as it goes, then as low; the lowest strip counts in which all have room.

    spots = nest_shapes(shapes, 400, 300, gap=5)         # [(x, y, quarter turns)], where the corner of each shape's box stands
    spots = nest_shapes(shapes, 400, 300, order=417)     # another nesting
    outline_of([line, ...])                            # the shape of a drawing: a shapely geometry

A shape's place is sought on a grid of a millimetre, or more on large sheets, by FFT; shapes are covered by whole cells, so they keep the
gap for certain. Large ones come first, more or less: with each number of an order some come earlier than others.
"""

import math
import random

import numpy
import shapely
from shapely import affinity

from host_tools.failure import Failure

_MOST_CELLS = 600_000  # of the sheet
_LEAST_MM = 1.0
_LEAST_CHANCE = 0.2  # a shape may come as late as one with this share of its area
_STRIPS = 5  # tried: each takes as long as the nesting itself, or less


def outline_of(lines):
    """Return the area that lines enclose and cover, a shapely geometry."""
    parts = []
    for line in lines:
        pairs = numpy.column_stack((line.real, line.imag))
        if abs(numpy.diff(line)).sum() < 1e-9:
            parts.append(shapely.Point(pairs[0]))
            continue
        parts.append(shapely.LineString(pairs))
        if len(line) > 3 and abs(line[0] - line[-1]) < 1e-6:
            parts.append(shapely.Polygon(pairs).buffer(0))
    whole = shapely.unary_union([part.buffer(0.01) for part in parts])
    return shapely.unary_union([shapely.Polygon(part.exterior) for part in shapely.get_parts(whole)])


def nest_shapes(shapes, width, height, gap=0.0, turn=True, order=0):
    """Place shapes; return (x, y, quarters turned to the left) of each: x and y of its box's lower left corner then, in mm. `order` 0: the largest
    first; each other number is an order of its own, the same on every computer. Raises Failure if there is no room for one."""
    chance = random.Random(order)
    turns = sorted(range(len(shapes)), key=lambda each: -shapes[each].area * (chance.uniform(_LEAST_CHANCE, 1) if order else 1))
    spots = _place_shapes(shapes, turns, width, height, gap, turn, False)
    sides = [(right - left, top - bottom) for left, bottom, right, top in (shape.bounds for shape in shapes)]
    least = max(min(side) if turn else side[1] for side in sides)
    used, _ = fullness(shapes, spots, width)
    for _strip in range(_STRIPS):
        limit = (least + used) / 2
        try:
            lower = _place_shapes(shapes, turns, width, limit, gap, turn, True)
        except Failure:
            least = limit
        else:
            spots, used = lower, fullness(shapes, lower, width)[0]
    return spots


def _place_shapes(shapes, turns, width, height, gap, turn, across):
    """Place shapes in one order; `turns`: indices of the shapes in this order; `across`: as far left as possible, then as low, else the other way
    round."""
    cell = max(_LEAST_MM, math.sqrt(width * height / _MOST_CELLS))
    sheet = numpy.zeros((int(height / cell + 1e-9), int(width / cell + 1e-9)), bool)
    found = {}
    for index in turns:
        best = None
        for quarters in range(4 if turn else 1):
            shape = turn_shape(shapes[index], quarters)
            left, bottom, right, top = shape.bounds
            if right - left > width + 1e-9 or top - bottom > height + 1e-9:
                continue
            mask = _mask_cells(shape, gap, cell)
            spot = _find_free(sheet, mask, (right - left, top - bottom), (width, height), cell, gap, across)
            if spot and (best is None or spot[:2] < best[:2]):
                best = (*spot, quarters, mask)
        if best is None:
            raise Failure("there is no room on the sheet of {:g} × {:g} mm for all {} drawings with {:g} mm between them", width, height, len(shapes), gap)
        _, _, row, column, quarters, mask = best
        pad = _pad_cells(gap, cell)
        _put_mask(sheet, mask, row - pad, column - pad)
        found[index] = (column * cell, row * cell, quarters)
    return [found[index] for index in range(len(shapes))]


def turn_shape(shape, quarters):
    """Turn a shape to the left by quarters, and move its box's lower left corner to 0;0."""
    shape = affinity.rotate(shape, 90 * quarters, origin=(0, 0))
    left, bottom, _, _ = shape.bounds
    return affinity.translate(shape, -left, -bottom)


def _pad_cells(gap, cell):
    """Return the margin of a mask, in cells."""
    return math.ceil(gap / cell) + 1


def _mask_cells(shape, gap, cell):
    """Return the cells that a shape covers or comes near, with a margin of _pad_cells() cells around its box."""
    pad = _pad_cells(gap, cell)
    _, _, right, top = shape.bounds
    rows, columns = math.ceil(top / cell) + 2 * pad, math.ceil(right / cell) + 2 * pad
    # A cell is free if its centre is farther from the shape than the gap and half a cell's diagonal.
    near = shape.buffer(gap + cell * math.sqrt(0.5) + 1e-6)
    shapely.prepare(near)
    xs = (numpy.arange(columns) - pad + 0.5) * cell
    ys = (numpy.arange(rows) - pad + 0.5) * cell
    return shapely.contains_xy(near, *numpy.meshgrid(xs, ys))


def _find_free(sheet, mask, size, room, cell, gap, across):
    """Find the lowest free place: (top, column, row, column); with `across` the leftmost: (right end, row, row, column); None: no room. Shapes on
    the sheet have the gap around them already; the new shape needs none."""
    pad = _pad_cells(gap, cell)
    inner = mask[pad:-pad, pad:-pad]
    rows, columns = sheet.shape
    last_row = int((room[1] - size[1]) / cell + 1e-9)
    last_column = int((room[0] - size[0]) / cell + 1e-9)
    if not sheet.any():
        return (size[0] if across else size[1], 0, 0, 0)
    shape = (rows + inner.shape[0], columns + inner.shape[1])
    hits = numpy.fft.irfft2(numpy.fft.rfft2(sheet, shape) * numpy.conj(numpy.fft.rfft2(inner, shape)), shape)
    free = hits[: last_row + 1, : last_column + 1] < 0.5
    spots = numpy.argwhere(free.T if across else free)
    if not len(spots):
        return None
    first, second = spots[0].tolist()
    return (first * cell + size[0], second, second, first) if across else (first * cell + size[1], second, first, second)


def _put_mask(sheet, mask, row, column):
    """Mark a shape's cells on the sheet, in place: the mask's first cell lies at `row`, `column`, which may be negative. Cells off the sheet are
    dropped."""
    top, left = max(0, row), max(0, column)
    part = mask[top - row :, left - column :]
    part = part[: sheet.shape[0] - top, : sheet.shape[1] - left]
    sheet[top : top + part.shape[0], left : left + part.shape[1]] |= part


def fullness(shapes, spots, width):
    """Return (height used, share of the strip below it that the shapes cover)."""
    used = max(spot[1] + turn_shape(shape, spot[2]).bounds[3] for shape, spot in zip(shapes, spots))
    return used, sum(shape.area for shape in shapes) / (used * width)
