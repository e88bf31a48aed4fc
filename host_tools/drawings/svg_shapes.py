"""Shapes of an SVG file as Inks, in px of the page: flattened, dashed, placed, with the areas that they fill.

    shapes = Shapes()
    shapes.begin(page, 0.1, False)                  # chords at most 0.1 px off, no areas
    inks = shapes.shape_inks("path", element, context)
"""

import math

import numpy

from host_tools.drawings import svg_area, svg_geometry, svg_path, svg_style
from host_tools.drawings.page import Ink
from host_tools.language import N_

_EDGE_PX = 1.0  # sizes are rounded to whole px
SHAPES = frozenset("path rect circle ellipse line polyline polygon".split())


def element_length(text, axis, context, default=0.0):
    """Return a length of an element, in px of its own coordinates; `axis`: "x", "y" or None, of which per cent are."""
    width, height = context.viewport
    whole = {"x": width, "y": height}.get(axis, math.hypot(width, height) / math.sqrt(2))
    return svg_geometry.length_px(text, whole, context.style["font-size"], default)


class Shapes:
    def __init__(self):
        self._segments = {}  # (id of an element, viewport): read once for all sizes

    def begin(self, page, deviation, fills, unseen):
        """Begin a page, which counts the faults of shapes. `deviation`: px between chord and curve; `unseen`: draw also shapes that nobody sees."""
        self._page, self._deviation, self._fills, self._unseen = page, deviation, fills, unseen

    def shape_inks(self, tag, element, context):
        """Return the inks of a shape in px of the page: dashed, an area's edge closed; [] if it is hidden or has no extent. Counts unseen shapes,
        backgrounds and markers in the page."""
        style = context.style
        if style.get("visibility", "visible") != "visible":
            return []
        stretch = svg_geometry.stretch_of(context.matrix)
        if not stretch:
            return []
        segments = self.path_segments(tag, element, context, stretch)
        lines = svg_geometry.flatten_segments(segments, self._deviation / stretch)
        stroked, filled = svg_style.is_painted(style, "stroke"), svg_style.is_painted(style, "fill")
        if not stroked and (not filled or lines and all(map(svg_geometry.is_straight, lines))):  # such a fill has no area
            self._page.unseen += 1
            if not self._unseen:
                return []
        if filled and not stroked:  # the edge of an area is closed
            lines = [numpy.append(line, line[0]) if len(line) > 2 and line[0] != line[-1] else line for line in lines]
        edges = svg_geometry.transform_lines(lines, context.matrix) if filled and tag != "line" else []
        if edges and self._is_background(style, stroked, edges):
            self._page.backgrounds += 1
            if svg_style.is_opaque(style):
                self._page.covered = self._page.drawn
            if not self._unseen:
                return []
        rings = edges if self._fills else []
        for name in ("marker-start", "marker-mid", "marker-end"):
            if style.get(name, "none") != "none":
                self._page.left_out[N_("marker (arrow head)")] += 1
        if stroked and style.get("stroke-linecap", "butt") == "butt":
            lines = [line for line in lines if len(line) > 2 or line[0] != line[-1]]
        if stroked:
            lines = self._dash_lines(lines, element, context)
        return self.inks(svg_geometry.transform_lines(lines, context.matrix), rings, style, edges)

    def _is_background(self, style, stroked, edges):
        """True of a white area over the whole page, a px at its edge aside."""
        if not svg_style.is_white(_paint_colour(style, "fill")) or stroked and not svg_style.is_white(_paint_colour(style, "stroke")):
            return False
        width, height = self._page.size_px
        places = numpy.concatenate(edges)
        if places.real.min() > _EDGE_PX or places.imag.min() > _EDGE_PX or places.real.max() < width - _EDGE_PX or places.imag.max() < height - _EDGE_PX:
            return False
        inner = svg_area.rectangle(_EDGE_PX, _EDGE_PX, max(width - _EDGE_PX, _EDGE_PX), max(height - _EDGE_PX, _EDGE_PX))
        return svg_area.fill_area(edges, style.get("fill-rule", "nonzero")).covers(inner)

    def inks(self, lines, rings, style, edges=()):
        """Return lines in the colour of their stroke, or else of their fill, and the area that is filled. `edges`: of the area under a stroke."""
        rule = style.get("fill-rule", "nonzero")
        svg_geometry.on_page(lines)
        self._page.drawn += bool(lines)
        if svg_style.is_painted(style, "stroke"):
            inks = [Ink(_paint_colour(style, "stroke"), lines, under=Ink(_paint_colour(style, "fill"), edges, rule=rule) if edges else None)]
        else:
            inks = [Ink(_paint_colour(style, "fill"), lines, rule=rule if svg_style.is_painted(style, "fill") else "")]
        area = svg_area.fill_area(rings, rule) if rings else None
        if area is not None and not area.is_empty:
            inks.append(Ink(_paint_colour(style, "fill"), [], [area]))
        return inks

    def path_segments(self, tag, element, context, stretch):
        """Return the segments of a shape, read once. Raises TooFar."""
        key = id(element), context.viewport, context.style["font-size"]
        if key not in self._segments:
            data = context.style.get("d") if tag == "path" else self._basic_path(tag, element, context)
            data = None if data == "none" else data
            reach = max(map(abs, svg_geometry.read_numbers(data)), default=0.0)
            segments, whole = svg_path.read(data) if data else ([], True)
            if tag in ("polyline", "polygon"):
                whole = svg_geometry.up_to_a_mistake(element.get("points"))[1]
            self._segments[key] = segments, whole, reach
        segments, whole, reach = self._segments[key]
        svg_geometry.check_reach(reach * stretch)
        if not whole:
            self._page.left_out[N_("rest of a path behind a mistake in it")] += 1
        return segments

    def _basic_path(self, tag, element, context):
        """Return the path data of a basic shape, its lengths from the style, else the attributes; None if it is not drawn."""

        def read_length(name, axis, default=0.0):
            return element_length(context.style.get(name, element.get(name)), axis, context, default)

        return svg_geometry.shape_path(tag, read_length, element.get("points"))

    def _dash_lines(self, lines, element, context):
        """Return the dashes of lines by stroke-dasharray and stroke-dashoffset, scaled by pathLength if there is one; the lines themselves without a
        pattern."""
        style = context.style
        text = style.get("stroke-dasharray", "none")
        if text == "none":
            return lines
        pattern = [element_length(part, None, context) for part in text.replace(",", " ").split()]
        offset = element_length(style.get("stroke-dashoffset"), None, context)
        counted = element_length(element.get("pathLength"), None, context)
        if counted > 0:  # the author's own measure of the whole path
            share = sum(float(abs(numpy.diff(line)).sum()) for line in lines) / counted
            pattern, offset = [share * part for part in pattern], share * offset
        return svg_geometry.dash_lines(lines, pattern, offset, self._page.left_out)


def _paint_colour(style, what):
    value = style.get(what, "none" if what == "stroke" else "black")
    return style.get("color", "black") if value.lower() == "currentcolor" else value
