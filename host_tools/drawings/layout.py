"""The drawings on the table: one drawing or several, copies in rows and columns, registration marks.

    sheet = nest_sheets([Sheet(…), Sheet(…)], (400, 300), options)
    copy_sheet(sheet, options)
    add_marks(sheet, box, (400, 300))
"""

import re
from dataclasses import dataclass

import numpy
import shapely
from shapely import affinity

from host_tools.drawings import nesting
from host_tools.drawings.placement import box_of
from host_tools.failure import Failure
from host_tools.language import _

_MOST_COPIES = 10_000
_CROSS_MM, _AWAY_MM = 5.0, 5.0  # the size of a registration mark, and how far it stands from the drawing


@dataclass
class Sheet:
    """Lines and areas by layer, in mm of the table, y up."""

    layers: dict  # {number: lines} of those that are drawn
    fills: dict  # {number: areas}
    names: dict  # {number: name or None}
    numbers: dict  # the same of all that the file has
    scale: float
    corner_px: tuple
    origin_mm: tuple
    page_mm: tuple
    notes: list


def nest_sheets(sheets, table, options):
    """Nest several drawings on one table, `options.gap` mm apart; return one Sheet. Raises Failure if there is no room."""
    (x, y), (width, height) = room_mm(table, options)
    shapes = [shape_of(sheet) for sheet in sheets]
    spots = nesting.nest_shapes(shapes, width, height, options.gap, options.turn, options.nesting)
    boxes = [shapely.box(*shape.bounds) for shape in shapes]
    used, full = nesting.fullness(shapes, spots, width)
    boxed = sum(box.area for box in boxes)
    whole = Sheet({}, {}, {}, {}, sheets[0].scale, (0.0, 0.0), (x, y), (x, y, x + width, y + height), [])
    for sheet, shape, (left, bottom, quarters) in zip(sheets, shapes, spots):
        ring = affinity.rotate(shape, 90 * quarters, origin=(0, 0)).bounds
        shift = complex(x + left - ring[0], y + bottom - ring[1])
        for number, lines in sheet.layers.items():
            whole.layers.setdefault(number, []).extend(line * 1j**quarters + shift for line in lines)
            areas = (affinity.rotate(area, 90 * quarters, origin=(0, 0)) for area in sheet.fills.get(number, []))
            whole.fills.setdefault(number, []).extend(affinity.translate(area, shift.real, shift.imag) for area in areas)
        for own, other in ((whole.names, sheet.names), (whole.numbers, sheet.numbers)):
            for number, name in other.items():
                own[number] = own.get(number) or name
        whole.notes += sheet.notes
    shares = full * 100, boxed / (used * width) * 100
    try:
        by_boxes = nesting.fullness(boxes, nesting.nest_shapes(boxes, width, height, options.gap, options.turn), width)[0]
        text = _("{} drawings on one sheet use {:.0f} mm of its height, {:.0f} % of that full, boxes {:.0f} %; by their boxes they would use {:.0f} mm")
        whole.notes.append(text.format(len(sheets), used, *shares, by_boxes))
    except Failure:
        text = _("{} drawings on one sheet use {:.0f} mm of its height, {:.0f} % of that full, boxes {:.0f} %; by their boxes there would be no room")
        whole.notes.append(text.format(len(sheets), used, *shares))
    return whole


def room_mm(table, options):
    """Return (corner, size) of the room for nested drawings, in mm."""
    x, y = options.origin or (options.margin, options.margin)
    return (x, y), (table[0] - x - options.margin, table[1] - y - options.margin)


def shape_of(sheet):
    return nesting.outline_of([line for lines in sheet.layers.values() for line in lines])


def copy_sheet(sheet, options):
    """Repeat the drawing in columns and rows. Raises Failure if `options.copies` is wrong."""
    if not options.copies:
        return
    match = re.fullmatch(r"(\d+)x(\d+)", options.copies)
    columns, rows = (int(match[1]), int(match[2])) if match else (0, 0)
    if not 1 <= columns * rows <= _MOST_COPIES:
        raise Failure("--copies wants COLUMNSxROWS, as in 3x2, not {!r}", options.copies)
    box = sheet.page_mm if options.place == "page" else box_of(sheet.layers.values())
    across, up = box[2] - box[0] + options.gap, box[3] - box[1] + options.gap
    shifts = [complex(column * across, row * up) for row in range(rows) for column in range(columns)]
    sheet.layers = {number: [line + shift for shift in shifts for line in lines] for number, lines in sheet.layers.items()}


def add_marks(sheet, box, table):
    """Add a cross at each corner of the drawing, by each pen: crosses that fall on each other show that the pens agree."""
    left, bottom, right, top = box
    for number in sheet.layers:
        for x in (max(left - _AWAY_MM, _CROSS_MM / 2), min(right + _AWAY_MM, table[0] - _CROSS_MM / 2)):
            for y in (max(bottom - _AWAY_MM, _CROSS_MM / 2), min(top + _AWAY_MM, table[1] - _CROSS_MM / 2)):
                for arm in (_CROSS_MM / 2, 1j * _CROSS_MM / 2):
                    sheet.layers[number].append(numpy.array([complex(x, y) - arm, complex(x, y) + arm]))


def check_room(sheet, table, steps_per_mm):
    """Raise Failure if anything leaves the table; half a step beyond its edge counts as on it."""
    left, bottom, right, top = box_of(sheet.layers.values())
    slack = [0.5 / each + 1e-9 for each in steps_per_mm]
    if left < -slack[0] or bottom < -slack[1] or right > table[0] + slack[0] or top > table[1] + slack[1]:
        raise Failure(
            "the drawing with its copies, {:.1f} × {:.1f} mm with its corner at {:.1f}, {:.1f}, leaves the table of {:g} × {:g} mm",
            right - left, top - bottom, left, bottom, *table,
        )
