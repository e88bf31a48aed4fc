"""Reads the outlines of an SVG file, layer by layer, in px of 1/96 inch, and counts what cannot be drawn.

    file = SvgFile("map.svg")
    page = file.outlines(deviation_px=0.1)
    page.layers             # {1: [complex array, ...], ...}: x + iy, y down
    page.left_out           # {"picture": 2, ...}

It reads shapes, paths, <use> and <symbol>, text as the outlines of its letters, and dashes, cut by clip paths. Fills are not
hatched. Each top-level group is a layer; its number is the first one in its label or id, or else its index among the groups;
elements in no group are layer 1. vpype numbers layers in the same way.
"""

import math
import re
from dataclasses import dataclass, replace

import numpy
import shapely

from host_tools.drawings import svg_area, svg_geometry, svg_paint, svg_style, svg_text, svg_transform
from host_tools.drawings.page import LONGEST_TEXT, TOO_LONG, Page, cut_inks
from host_tools.drawings.svg_faults import count_by_letters, name_faults, name_of, count_unreadable
from host_tools.drawings.svg_page import page_size, root_of, view_box
from host_tools.drawings.svg_shapes import SHAPES, Shapes, element_length
from host_tools.drawings.svg_style import local_name
from host_tools.failure import Failure
from host_tools.language import N_, current_language

_WAY_PX = 0.05  # how finely the path of a text is followed
_CLIP_PX = 0.02  # a line along the edge of its clip path is inside: 5 µm
_HREF = "{http://www.w3.org/1999/xlink}href"
_FLAT = {  # paints, by svg_paint's kinds
    "pattern": N_("pattern (the edge of its area is drawn)"), "gradient": N_("gradient (the edge of its area is drawn)"),
    "context": N_("paint of a <use> or marker around (context-fill, context-stroke)"),
}  # fmt: skip
_URL = re.compile(r"url\(\s*['\"]?#([^'\")]+)['\"]?\s*\)")
_ANIMATIONS = frozenset("animate animateColor animateMotion animateTransform set".split())
_DEEPEST = 100  # of elements in elements, <use> and clip paths included
_DEEPEST_CLIP = 10  # of clip paths, each of which takes long
_MOST_USES = 30_000  # of <use>, clip paths and the shapes in a <use>: those that lead to each other multiply; 3 s
_POINTS, _OF_LETTER = 50, 5  # points of a line that count as a shape; shapes that a letter counts as; an edge of a clip path's area counts as one


@dataclass(frozen=True)
class _Context:
    """Properties that an element inherits: style, matrix, clip paths."""

    matrix: tuple
    style: dict
    viewport: tuple[float, float]
    used: tuple = ()  # targets of <use> so far
    depth: int = 0


class SvgFile:
    def __init__(self, path):
        """Raises Failure if the file is not there, or is no SVG."""
        self._path = path
        self._uses = 0
        self._root = root_of(path)
        self._by_id, self._paints = {}, {}
        self._parents = {child: parent for parent in self._root.iter() for child in parent}
        sheets = []
        self._count = self._animations = 0
        for element in self._root.iter():
            self._by_id.setdefault(element.get("id"), element)
            tag = local_name(element.tag)
            self._count += tag in SHAPES or tag == "text"
            self._animations += tag in _ANIMATIONS
            if tag == "style" and element.get("type", "").strip().lower() in ("", "text/css"):
                sheets.append(("".join(element.itertext()), element.get("media", "")))
        self._sheet = svg_style.Sheet(sheets, self._root)
        self._animations += self._sheet.animations
        self._shapes = Shapes()
        with name_faults(self._path, self._root):
            self.size_px = page_size(self._root, self._sheet.style(self._root, {}))

    def _count_uses(self, element, count=1):
        """Count a <use>, a clip path, or the shapes that a <use> shows. Raises Failure."""
        self._uses += count
        if self._uses > _MOST_USES:
            raise Failure("{}: {}: the copies made by <use> are more than {} shapes of {} points: make fewer copies", self._path, name_of(element), _MOST_USES, _POINTS)

    def outlines(self, deviation_px, progress=None, by_colour=False, fills=False, unseen=False):
        """Return the page; chords are at most `deviation_px` from their curves. `progress(share)` is called now and then, 0…1. `by_colour`: a layer
        is a colour; `fills`: with the areas that are filled; `unseen`: with shapes that nobody sees. Raises Failure."""
        self._fills, self._unseen, self._boxes = fills, unseen, {}
        self._deviation = deviation_px
        self._progress = progress
        self._done = 0
        self._page = Page(self.size_px, by_colour=by_colour)
        self._shapes.begin(self._page, deviation_px, fills, unseen)
        if self._sheet.unknown:
            self._page.left_out[N_("style rule that cannot be read")] += len(self._sheet.unknown)
        if self._animations:
            self._page.left_out[N_("animation (drawn as without it)")] += self._animations
        width, height = self.size_px
        if width <= 0 or height <= 0:
            return self._page
        with name_faults(self._path, self._root):
            context = self._inner_context(self._root, _Context(svg_geometry.IDENTITY, {"font-size": 16.0}, self.size_px))
            if context:
                self._sort_layers(self._in_view_box(self._root, context, 0.0, 0.0, width, height))
        return self._page

    def _sort_layers(self, context):
        """Sort the top-level elements into layers."""
        groups = 0
        pending = [(child, context) for child in reversed(self._root)]
        while pending:
            child, around = pending.pop()
            tag = local_name(child.tag)
            if tag in ("switch", "a") and not child.get("clip-path"):
                inner = self._inner_context(child, around)
                pending += [(each, inner) for each in reversed(self._visible_children(child))] if inner else []
                continue
            number, name = 1, None
            if tag in ("g", "svg"):
                if self._style_of(child, around.style).get("display") == "none":
                    continue
                groups += 1
                number, name = svg_style.layer_of(child, groups)
            self._page.add_inks(number, name, self._clip_inks(self._lines_or_failure(child, around), self._root, context))

    # --- elements; each returns Inks in px of the page

    def _lines_or_failure(self, element, context):
        """Return the inks of an element. A number that cannot be drawn becomes a Failure that names the element."""
        with name_faults(self._path, element):
            return self._lines_of(element, context)

    def _lines_of(self, element, context):
        """Return the inks of an element and all in it, in px of the page, cut by its clip path; [] if nothing of it is shown. Raises Failure."""
        tag = local_name(element.tag)
        inner = self._inner_context(element, context)
        if inner is None:
            return []
        if tag in SHAPES:
            lines = self._shapes.shape_inks(tag, element, inner)
            if inner.used:
                self._count_uses(element, sum(1 + len(line) // _POINTS for ink in lines for line in ink.lines))
            self._count_one()
        elif tag == "text":
            lines = self._text_inks(element, inner)
        elif tag in ("g", "a", "switch"):
            lines = self._lines_of_children(self._visible_children(element), inner)
        elif tag == "svg":
            lines = self._viewport_inks(element, element, inner)
        elif tag == "use":
            lines = self._use_inks(element, inner)
        else:
            self._note_left_out(tag, inner.style)
            return []
        if lines:
            self._name_paints(inner.style, tag)
        return self._clip_inks(lines, element, inner) if lines else lines

    def _inner_context(self, element, context, ink=True):
        """Return the context of an element's own coordinates and style; None if nothing of it is shown. `ink`: False for a clip path's shapes, whose
        opacity does not count."""
        if context.depth == _DEEPEST:
            raise Failure("{}: {} lies in more than {} others", self._path, name_of(element), _DEEPEST)
        style = self._style_of(element, context.style)
        if style.get("display") == "none" or not _conditions_hold(element):
            return None
        if ink and svg_style.is_invisible(style.get("opacity")):
            self._page.unseen += 1
            if not self._unseen:
                return None
        faults = count_unreadable(element)
        if faults:
            self._page.left_out[N_("number that is none, or that cannot be read")] += faults
        if style.get(svg_style.UNREAD):
            self._page.left_out[N_("value of a style that cannot be read, or lacks its unit")] += style[svg_style.UNREAD]
        lengths = count_by_letters(element)
        if lengths:
            self._page.left_out[N_("length in rem, ex or ch (by the size of letters alone)")] += lengths
        return replace(context, matrix=self._matrix_of(element, style, context), style=style, depth=context.depth + 1)

    def _name_paints(self, style, tag):
        """Count the kinds of paint, of something shown, that are not drawn."""
        for what, name in (("mask", N_("mask")), ("filter", N_("filter")), ("offset-path", N_("offset-path of CSS"))):
            if style.get(what, "none") != "none":
                self._page.left_out[name] += 1
        if tag in SHAPES or tag == "text":
            kinds = [self._paint_of(style.get(what, "none"))[1] for what in ("fill", "stroke")]
            for kind, named in _FLAT.items():
                if kind in kinds:
                    self._page.left_out[named] += 1

    def _lines_of_children(self, children, context):
        return [line for child in children for line in self._lines_or_failure(child, context)]

    def _visible_children(self, element):
        """Return the children that are shown; of a <switch> the first that suits and can be drawn."""
        if local_name(element.tag) != "switch":
            return list(element)
        suit = (child for child in element if local_name(child.tag) not in ("", "foreignObject") and _conditions_hold(child))
        return [child for child in [next(suit, None)] if child is not None]

    def _note_left_out(self, tag, style):
        """Count a visible picture, content that is not SVG, or a text in a frame in `left_out`; other elements are ignored."""
        kinds = {"image": N_("picture"), "foreignObject": N_("text or other content that is not SVG"),
                 "flowRoot": N_("text in a frame (convert it to text or to paths)")}  # fmt: skip
        if tag in kinds and style.get("visibility", "visible") == "visible":
            self._page.left_out[kinds[tag]] += 1

    def _count_one(self):
        self._done += 1
        if self._progress and self._done % 64 == 0:
            self._progress(min(1.0, self._done / self._count))

    def _text_inks(self, element, context):
        """Return the inks of a <text>, in px of the page: the outlines of its letters."""
        self._count_one()
        if context.style.get("writing-mode", "").startswith(("v", "tb")):
            self._page.left_out[N_("vertical text")] += 1
            return []
        stretch = svg_geometry.stretch_of(context.matrix)
        if not stretch:
            return []
        if not svg_style.is_painted(context.style, "fill") and not svg_style.is_painted(context.style, "stroke"):
            self._page.unseen += 1
            if not self._unseen:
                return []
        svg_geometry.check_bound(context.style["font-size"] * stretch)
        count = sum(map(len, element.itertext()))
        if count > LONGEST_TEXT:
            self._page.left_out[TOO_LONG] += 1
            return []
        if context.used:
            self._count_uses(element, _OF_LETTER * count)
        letters = svg_text.collect_letters(element, context.style, self._style_of, context.viewport, self._page.left_out, self._path_finder(context))
        lines = svg_text.outlines_of(letters, self._deviation / stretch, self._page.left_out)
        lines = svg_geometry.transform_lines(lines, context.matrix)
        return self._shapes.inks(lines, lines if self._fills and svg_style.is_painted(context.style, "fill") else [], context.style)

    def _path_finder(self, context):
        """Return a function from a <textPath> to the path on which its letters stand, polylines, or None."""

        def find_path(element):
            """Return the polylines of the shape that a <textPath> names, its own matrix carried out; None if it names none, or a matrix leaves no
            extent."""
            target = self._by_id.get((element.get("href") or element.get(_HREF) or "").removeprefix("#"))
            if target is None or local_name(target.tag) not in SHAPES:
                return None
            style = self._style_in_place(target)
            matrix = self._matrix_of(target, style, replace(context, matrix=svg_geometry.IDENTITY))
            stretch = svg_geometry.stretch_of(svg_geometry.compose_matrices(context.matrix, matrix))
            segments = self._shapes.path_segments(local_name(target.tag), target, replace(context, style=style), stretch)
            return svg_geometry.transform_lines(svg_geometry.flatten_segments(segments, _WAY_PX / stretch), matrix) if stretch else None

        return find_path

    def _use_inks(self, element, context):
        """Return the inks of the element that a <use> names, moved by its x and y; [] if there is no such element, which `left_out` counts. Raises
        Failure if the <use> leads to itself, or there are too many copies."""
        target = self._by_id.get((element.get("href") or element.get(_HREF) or "").removeprefix("#"))
        if target is None:
            self._page.left_out[N_("<use> of something that is not in the file")] += 1
            return []
        if target in context.used:
            raise Failure("{}: {} leads to itself", self._path, name_of(element))
        self._count_uses(element)
        moved = (1.0, 0.0, 0.0, 1.0, element_length(context.style.get("x"), "x", context), element_length(context.style.get("y"), "y", context))
        inner = replace(context, matrix=svg_geometry.compose_matrices(context.matrix, moved), used=(*context.used, target))
        if local_name(target.tag) not in ("symbol", "svg"):
            return self._lines_or_failure(target, inner)
        inner = self._inner_context(target, inner)
        if inner is None:
            return []
        return self._clip_inks(self._viewport_inks(target, element, inner), target, inner)

    def _viewport_inks(self, element, sized, context):
        """Return the inks of a <symbol>, or of an <svg> inside the file: its viewBox fitted to its size, or to that of the <use>."""
        x, y = element_length(element.get("x"), "x", context), element_length(element.get("y"), "y", context)
        width = element_length(sized.get("width") or element.get("width") or "100%", "x", context)
        height = element_length(sized.get("height") or element.get("height") or "100%", "y", context)
        if width <= 0 or height <= 0:
            return []
        lines = self._lines_of_children(list(element), self._in_view_box(element, context, x, y, width, height))
        if context.style.get("overflow", "hidden") in ("visible", "auto"):
            return lines
        edge = numpy.array([x + 1j * y, x + width + 1j * y, x + width + 1j * (y + height), x + 1j * (y + height)])
        area = svg_area.fill_area(svg_geometry.transform_lines([edge], context.matrix), "nonzero")
        return cut_inks(lines, svg_area.grow_area(area, _CLIP_PX), self._page.left_out)

    def _in_view_box(self, element, context, x, y, width, height):
        """Return the context inside a viewport."""
        box = view_box(element)
        if box is None:
            matrix = svg_geometry.compose_matrices(context.matrix, (1.0, 0.0, 0.0, 1.0, x, y))
            return replace(context, matrix=matrix, viewport=(width, height))
        fitted = svg_geometry.view_box_matrix(box, element.get("preserveAspectRatio"), x, y, width, height)
        return replace(context, matrix=svg_geometry.compose_matrices(context.matrix, fitted), viewport=(box[2], box[3]))

    # --- clip paths

    def _clip_inks(self, inks, element, context):
        """Return the inks cut by the element's clip path. They stay as they are without one; a clip path of CSS, or one that is not in the file, goes
        to `left_out`."""
        value = context.style.get("clip-path", "none")
        match = _URL.match(value)
        lines = [line for ink in inks for line in ink.lines]
        if lines and not match and value != "none":
            self._page.left_out[N_("clip path by a shape of CSS")] += 1
        if not match or not lines:
            return inks
        clip = self._by_id.get(match[1])
        if clip is None or local_name(clip.tag) != "clipPath":
            self._page.left_out[N_("clip path that is not in the file")] += 1
            return inks
        return cut_inks(inks, svg_area.grow_area(self._clip_area(clip, lines, context), _CLIP_PX), self._page.left_out)

    def _clip_area(self, clip, lines, context):
        """Return the area that a <clipPath> leaves of an element with the outlines `lines`. Raises Failure."""
        if clip in context.used:
            raise Failure("{}: {} leads to itself", self._path, name_of(clip))
        if sum(local_name(each.tag) == "clipPath" for each in context.used) == _DEEPEST_CLIP:
            raise Failure("{}: {} lies in more than {} others", self._path, name_of(clip), _DEEPEST_CLIP)
        self._count_uses(clip)
        matrix = context.matrix
        if clip.get("clipPathUnits") == "objectBoundingBox":
            matrix = svg_geometry.compose_matrices(matrix, svg_geometry.box_matrix(lines, matrix))
        style = self._style_in_place(clip)
        around = replace(context, matrix=self._matrix_of(clip, style, replace(context, matrix=matrix)), style=style, used=(*context.used, clip))
        area = svg_area.fill_area([], "nonzero")
        for child in clip:
            part = self._area_of(child, around)
            area = area if part is None else area.union(part)
        match = _URL.match(style.get("clip-path", "none"))
        if match and self._by_id.get(match[1]) is not None:
            area = area.intersection(self._clip_area(self._by_id[match[1]], lines, replace(context, used=around.used)))
        if context.used:
            self._count_uses(clip, int(shapely.get_num_coordinates(area)))
        return area

    def _area_of(self, child, context):
        """Return the inside of one shape of a <clipPath>, or None."""
        inner = self._inner_context(child, context, ink=False)
        tag = local_name(child.tag)
        if inner is None or inner.style.get("visibility", "visible") != "visible":
            return None
        if tag == "use":
            target = self._by_id.get((child.get("href") or child.get(_HREF) or "").removeprefix("#"))
            if target is None or local_name(target.tag) == "use":
                return None
            moved = (1.0, 0.0, 0.0, 1.0, element_length(inner.style.get("x"), "x", inner), element_length(inner.style.get("y"), "y", inner))
            return self._area_of(target, replace(inner, matrix=svg_geometry.compose_matrices(inner.matrix, moved)))
        stretch = svg_geometry.stretch_of(inner.matrix)
        if tag == "text":
            rings = [line for ink in self._text_inks(child, inner) for line in ink.lines]
        elif tag in SHAPES and stretch:
            rings = svg_geometry.flatten_segments(self._shapes.path_segments(tag, child, inner, stretch), self._deviation / stretch)
            rings = svg_geometry.transform_lines(rings, inner.matrix)
        else:
            return None
        area = svg_area.fill_area(rings, inner.style.get("clip-rule", "nonzero"))
        match = _URL.match(inner.style.get("clip-path", "none"))
        if match and self._by_id.get(match[1]) is not None:
            area = area.intersection(self._clip_area(self._by_id[match[1]], rings, inner))
        return area

    # --- attributes

    def _style_of(self, element, inherited):
        """Return an element's style as a dict: texts, but font-size in px, font-weight as a number, and fill and stroke as paint_of() returns them.
        `inherited`: its parent's."""
        style = self._sheet.style(element, inherited)
        for name, number, usual in (("font-size", svg_style.font_size, 16.0), ("font-weight", svg_style.font_weight, 400)):
            around = inherited.get(name, usual)
            own = style.get(name, around)
            style[name] = number(own, around) if isinstance(own, str) else own
        for what in ("fill", "stroke"):
            if what in style:
                style[what] = self._paint_of(style[what])[0]
        return style

    def _paint_of(self, value):
        """Return svg_paint.paint_of() of a paint, computed once."""
        if value not in self._paints:
            self._paints[value] = svg_paint.paint_of(value, self._by_id, self._plain_style)
        return self._paints[value]

    def _plain_style(self, element):
        """Return the properties of an element at its place in the file, as texts."""
        parent = self._parents.get(element)
        return self._sheet.style(element, {} if parent is None else self._plain_style(parent))

    def _style_in_place(self, element):
        """Return the style of an element, at its place in the file, that is drawn elsewhere."""
        parent = self._parents.get(element)
        return self._style_of(element, {} if parent is None else self._style_in_place(parent))

    def _matrix_of(self, element, style, context):
        """Return the matrix of an element of `style` in a context."""
        try:
            own = svg_transform.of_style(style, context.viewport, lambda with_stroke: self._box_of(element, style, context, with_stroke))
            return context.matrix if own is svg_geometry.IDENTITY else svg_geometry.compose_matrices(context.matrix, own)
        except svg_geometry.TooFar:
            raise
        except ValueError:
            self._page.left_out[N_("transform that cannot be read")] += 1
            return context.matrix

    # --- boxes that transforms refer to

    def _box_of(self, element, style, context, with_stroke):
        """Return left, top, width and height of an element in its own coordinates, painted or not; None if it has no extent."""
        key = id(element), context.viewport, style["font-size"], with_stroke
        if key not in self._boxes:
            page, self._page = self._page, Page(self.size_px)
            self._shapes.begin(self._page, self._deviation, False, True)
            inner = replace(context, matrix=self._own_matrix(element, style, context), style=style, depth=context.depth + 1)
            fine = self._deviation / (svg_geometry.stretch_of(context.matrix) or 1.0)
            places = numpy.concatenate([numpy.zeros(0, complex), *self._extent_lines(element, inner, fine)])
            self._page = page
            self._shapes.begin(page, self._deviation, self._fills, self._unseen)
            grown = element_length(style.get("stroke-width", "1"), None, inner) / 2 if with_stroke and svg_style.is_painted(style, "stroke") else 0.0
            sides = (places.real, places.imag) if len(places) else ()
            lows, sizes = [each.min() - grown for each in sides], [each.max() - each.min() + 2 * grown for each in sides]
            self._boxes[key] = (*map(float, lows), *map(float, sizes)) or None
        return self._boxes[key]

    @staticmethod
    def _own_matrix(element, style, context):
        """Return the matrix of an element's own coordinates; of a <use>, as browsers have it, without its x and y."""
        if local_name(element.tag) != "use":
            return svg_geometry.IDENTITY
        inner = replace(context, style=style)
        return (1.0, 0.0, 0.0, 1.0, -element_length(style.get("x"), "x", inner), -element_length(style.get("y"), "y", inner))

    def _extent_lines(self, element, context, fine):
        """Return the lines of an element, and of those in it, in its own coordinates; chords are at most `fine` from their curves."""
        tag = local_name(element.tag)
        if tag in SHAPES:
            segments = self._shapes.path_segments(tag, element, context, svg_geometry.stretch_of(context.matrix))
            return svg_geometry.transform_lines(svg_geometry.flatten_segments(segments, fine), context.matrix)
        if tag == "text":
            return [line for ink in self._text_inks(element, context) for line in ink.lines]
        if tag == "use":
            return [line for ink in self._use_inks(element, context) for line in ink.lines]
        lines = []
        for child in self._visible_children(element) if tag in ("g", "a", "svg", "switch") else ():
            inner = self._inner_context(child, context)
            lines += self._extent_lines(child, inner, fine) if inner else []
        return lines


def _conditions_hold(element):
    """True if an element's conditions hold: its language is that of `passo`, and it wants no extension."""
    languages = element.get("systemLanguage")
    if languages is not None:
        wanted = [each.strip().lower() for each in languages.split(",")]
        if not any(each == current_language() or each.startswith(current_language() + "-") for each in wanted):
            return False
    return element.get("requiredExtensions") is None
