"""Fills of areas by parallel lines.

    rules = parse_rules(["45,1", "2:0,0.5,crossed"])     # of all layers, and of layer 2
    lines = hatch_lines(areas, rules[0])                # complex arrays
"""

import math
from typing import NamedTuple

import numpy
import shapely
from shapely import affinity

from host_tools.failure import Failure

_MOST_LINES = 200_000


class Rule(NamedTuple):
    angle: float  # degrees
    spacing: float  # mm
    crossed: bool


def parse_rules(texts):
    """Return {layer, or 0 for all others: Rule} of the texts behind --hatch. Raises Failure."""
    rules = {}
    for text in texts or ():
        layer, colon, rest = text.partition(":") if ":" in text else ("0", ":", text)
        parts = rest.split(",")
        try:
            rule = Rule(float(parts[0]), float(parts[1]), parts[2:] == ["crossed"])
            if not 0.01 <= rule.spacing <= 1000 or not math.isfinite(rule.angle) or len(parts) > 3 or len(parts) == 3 and not rule.crossed:
                raise ValueError
            rules[int(layer)] = rule
        except (ValueError, IndexError):
            raise Failure("--hatch wants [LAYER:]ANGLE,SPACING[,crossed], as in 45,1 or 2:0,0.5,crossed, not {!r}", text) from None
    return rules


def hatch_lines(areas, rule):
    """Return the lines of a Rule in areas, shapely geometries in mm, which may lie on each other."""
    whole = shapely.unary_union([area.buffer(0) for area in areas])
    lines = []
    for angle in (rule.angle, rule.angle + 90)[: 1 + rule.crossed]:
        lines += _parallel_lines(whole, angle, rule.spacing)
    return lines


def _parallel_lines(whole, angle, spacing):
    """Return the parallel lines in an area, `spacing` mm apart, at `angle` degrees, each other one back. Raises Failure if there are too many."""
    level = affinity.rotate(whole, -angle, origin=(0, 0))
    if level.is_empty:
        return []
    left, bottom, right, top = level.bounds
    first, last = math.ceil(bottom / spacing - 1e-9), math.floor(top / spacing + 1e-9)
    if last - first > _MOST_LINES:
        raise Failure("--hatch: more than {} lines in an area", _MOST_LINES)
    heights = numpy.arange(first, last + 1) * spacing
    if not len(heights):
        return []
    ends = numpy.stack([numpy.column_stack((numpy.full(len(heights), x), heights)) for x in (left - 1, right + 1)], axis=1)
    shapely.prepare(level)
    back = complex(math.cos(math.radians(angle)), math.sin(math.radians(angle)))
    found = []
    for index, cut in enumerate(shapely.intersection(shapely.linestrings(ends), level)):
        for part in shapely.get_parts(cut):
            if part.geom_type == "LineString" and part.length > 1e-6:
                line = numpy.array([complex(*place) for place in part.coords]) * back
                found.append(line if index % 2 == 0 else line[::-1])
    return found
