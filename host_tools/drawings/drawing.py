"""From a drawing's file to objects of points in steps, its page placed on the machine's table.

    drawing = load("map.svg", boards.load("plotter_2014"), Options(fit=True))
    for points in drawing.objects(1000):            # [(pen_down, x, y), ...], first of each a MOVE
        ...

The page lies with its lower left corner at 0;0, in its real size, whichever layers are drawn. So layers that are drawn one
after the other, and files of one page size, fall on each other. Curves become chords that stray at most a quarter of the
tolerance; points within half the tolerance of their neighbours' line are left out; rounding to steps adds at most half a step
an axis. `notes` lists what cannot be drawn. Layers are drawn in ascending order.
"""

import hashlib
import json
import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy
import shapely
from shapely.affinity import affine_transform

from host_tools import boards
from host_tools.drawings import hatch, layout, placement, sources, svg_area
from host_tools.drawings.line_order import join, join_in_order, travel_length
from host_tools.drawings.page import move_lines
from host_tools.drawings.placement import MM_PER_PX, Options, percent_text  # noqa: F401
from host_tools.drawings.shorter import shorten
from host_tools.failure import Failure
from host_tools.language import N_, _

_JOIN_MM = 0.05  # lines whose ends are this close are joined
_JOINING = 0.2  # share of the time that ordering takes
_PIECE = 1000  # points of a line that are thinned at once: the time of more grows with their square, if the line lies on itself
_EDGE_MM = 0.1  # a line outside the page by less is moved onto its edge


@dataclass
class Part:
    """The lines of one layer, or of one pen, in drawing order, each a list of (x, y) steps, of two points or more."""

    number: int
    name: str | None
    lines: list


@dataclass
class Drawing:
    """Polylines in steps, in drawing order, with figures for people."""

    name: str
    parts: list  # of Part
    steps_per_mm: tuple[float, float]
    scale: float  # of the real size
    mm_per_px: float
    corner_px: tuple[float, float]  # lower left corner of the drawing, in the file
    origin_mm: tuple[float, float]  # position of that corner on the machine
    page_mm: tuple[float, float, float, float]  # the page on the machine: left, bottom, right, top
    box_mm: tuple[float, float, float, float]  # the same of the outlines
    layers: dict = field(default_factory=dict)  # number: name or None, of all in the file
    notes: list = field(default_factory=list)
    before_mm: float = 0.0  # travel with the pen up in the order of the file

    @property
    def lines(self):
        """The lines of all parts."""
        return [line for part in self.parts for line in part.lines]

    def objects(self, most):
        """Cut the drawing into objects of at most `most` points, each [(pen_down, x, y), ...] in steps, with a MOVE first. Each part begins a new
        object."""
        return [points for part in self.parts for points in _cut_objects(part.lines, most)]

    def part_starts(self, most):
        """Return {index of an object: the Part that begins with it}, without the first part."""
        first, found = 0, {}
        for part in self.parts:
            found[first] = part
            first += len(_cut_objects(part.lines, most))
        found.pop(0, None)
        return found

    def digest(self, most):
        """Return 64 hex digits (SHA-256) that are equal if and only if the objects are equal."""
        return hashlib.sha256(json.dumps(self.objects(most)).encode()).hexdigest()

    def count_points(self):
        """Return the number of points of all lines."""
        return sum(len(line) for line in self.lines)

    def lengths_mm(self):
        """Return the lengths that the pen draws, and that it travels while it is up, from 0;0, in mm."""
        down = up = 0.0
        place = (0, 0)
        for line in self.lines:
            up += self._distance_mm(place, line[0])
            down += sum(self._distance_mm(a, b) for a, b in zip(line, line[1:]))
            place = line[-1]
        return down, up

    def _distance_mm(self, a, b):
        return math.hypot((b[0] - a[0]) / self.steps_per_mm[0], (b[1] - a[1]) / self.steps_per_mm[1])


def _cut_objects(lines, most):
    """Cut lines into objects of at most `most` points; a line that is cut goes on from its last point."""
    cut = [[]]
    for line in lines:
        if len(cut[-1]) + len(line) > most and len(line) <= most:
            cut.append([])
        for index, (x, y) in enumerate(line):
            if len(cut[-1]) >= most - (index == 0):
                cut.append([])
            if not cut[-1] and index:
                cut[-1].append((False, *line[index - 1]))
            cut[-1].append((index > 0, x, y))
    return [points for points in cut if points]


def load(path, board, options=None, progress=None):
    """Read, position and order a drawing: a path, or several, which are nested on the sheet. Raises Failure if there is nothing to draw,
    or no room. Calls `progress(text, share)` now and then: the step under way, and its share done, 0…1."""
    options = options or Options()
    progress = progress or (lambda text, share: None)
    if options.place not in ("page", "outlines"):
        raise Failure("--place takes page or outlines, not {!r}", options.place)
    if options.pens not in ("none", "layers", "colours"):
        raise Failure("--pens takes none, layers or colours, not {!r}", options.pens)
    if options.scale is not None and options.scale <= 0:
        raise Failure("--scale must be above 0")
    progress(N_("reading"), 0.0)
    paths = [path] if isinstance(path, (str, Path)) else list(path)
    sheets = [_place_file(each, board, options, progress, len(paths) > 1) for each in paths]
    sheet = sheets[0] if len(sheets) == 1 else layout.nest_sheets(sheets, placement.table_mm(board), options)
    rules = hatch.parse_rules(options.hatch)
    for number, areas in sheet.fills.items():
        rule = rules.get(number, rules.get(0))
        if rule and areas:
            sheet.layers.setdefault(number, []).extend(hatch.hatch_lines(areas, rule))
    layout.copy_sheet(sheet, options)
    box = placement.box_of(sheet.layers.values())
    if options.marks:
        layout.add_marks(sheet, box, placement.table_mm(board))
    layout.check_room(sheet, placement.table_mm(board), boards.steps_per_mm(board))
    steps_per_mm, most = boards.steps_per_mm(board), boards.travel_steps(board)
    numbers = sorted(number for number, lines in sheet.layers.items() if lines)
    ordered, before_mm = _order_layers([sheet.layers[number] for number in numbers], options, progress)
    parts = [Part(number, sheet.names.get(number), _to_steps(lines, steps_per_mm, most)) for number, lines in zip(numbers, ordered)]
    return Drawing(
        ", ".join(map(str, paths)), parts, steps_per_mm, sheet.scale, MM_PER_PX * sheet.scale, sheet.corner_px, sheet.origin_mm,
        sheet.page_mm, box, sheet.numbers, sheet.notes, before_mm,
    )  # fmt: skip


def load_shapes(paths, board, options):
    """Load several drawings to nest; return (shapes, (width, height) of the room for them, in mm). Raises Failure."""
    found = [layout.shape_of(_place_file(path, board, options, lambda text, share: None, True)) for path in paths]
    return found, layout.room_mm(placement.table_mm(board), options)[1]


def _place_file(path, board, options, progress, several):
    """Read one file and position it on the table. If there are several files, each is positioned by itself, at 0;0."""
    file = sources.open_drawing(path)
    factor = options.scale or 1.0
    if options.place == "page" and options.fit and options.scale is None and not several:
        factor = placement.fit_factor((0.0, 0.0, *file.size_px), board, options)
    page = _read_page(file, path, factor, options, progress)
    if several:
        place = placement.Alone(page, options)
    else:
        place = placement.Placement(page, board, options)
        if place.factor > factor:
            page = _read_page(file, path, place.factor, options, progress)
            place = placement.Placement(page, board, options)
    names = {number: page.names.get(number) for number in sorted(page.layers)}
    chosen = _select_layers(page, path, options)
    scale = MM_PER_PX * place.factor
    (left, bottom), (x, y) = place.corner_px, place.origin_mm
    layers = {
        number: move_lines(lines, lambda places: (places - complex(left, bottom)).conjugate() * scale + complex(x, y)) for number, lines in chosen.items()
    }
    fills = {
        number: [affine_transform(area, [scale, 0, 0, -scale, x - left * scale, y + bottom * scale]) for area in page.fills.get(number, [])]
        for number in chosen
    }
    return layout.Sheet(
        layers, fills, names, names, place.factor, place.corner_px, place.origin_mm, place.on_table((0.0, 0.0, *page.size_px)),
        [*_notes_of(page, options), *place.notes],
    )  # fmt: skip


def _read_page(file, path, factor, options, progress):
    """Read a page and crop it. Curves are flattened so that they are as fine as `options.tolerance` after scaling by `factor`. Raises Failure."""
    deviation_px = options.tolerance / 4 / MM_PER_PX / max(factor, 1e-3)
    page = file.outlines(deviation_px, lambda share: progress(N_("reading"), share), options.pens == "colours", bool(options.hatch), options.unseen)
    page.layers = {number: lines for number, lines in page.layers.items() if lines or page.fills.get(number)}
    if not any(page.layers.values()):
        raise Failure("{}: nothing to draw: {}", path, _why_empty(page))
    if options.crop:
        progress(N_("cropping"), 0.0)
        whole = _total_length(page.layers)
        page.layers = {number: _crop_lines(lines, page.size_px) for number, lines in page.layers.items()}
        sheet = svg_area.rectangle(0, 0, *page.size_px)
        page.fills = {number: [area.intersection(sheet) for area in areas] for number, areas in page.fills.items()}
        page.layers = {number: lines for number, lines in page.layers.items() if lines or page.fills.get(number)}
        page.lost_mm = (whole - _total_length(page.layers)) * MM_PER_PX
        if not any(page.layers.values()):
            raise Failure("{}: nothing to draw: all of it lies outside the page (--no-crop draws it)", path)
    return page


def _crop_lines(lines, size_px):
    """Return the parts of lines that lie on the page. Lines outside by less than _EDGE_MM are moved onto its edge."""
    edge, (width, height) = _EDGE_MM / MM_PER_PX, size_px
    if lines:
        left, top, right, bottom = placement.box_of([lines])
        if left >= 0 and top >= 0 and right <= width and bottom <= height:
            return lines
    inside = svg_area.clip_lines(lines, svg_area.rectangle(-edge, -edge, width + edge, height + edge))
    return move_lines(inside, lambda places: numpy.clip(places.real, 0, width) + 1j * numpy.clip(places.imag, 0, height))


def _total_length(layers):
    """Return the sum of the lengths of all lines, in the unit of their points."""
    every = [line for lines in layers.values() for line in lines]
    if not every:
        return 0.0
    places = numpy.concatenate(every)
    ways = abs(places[1:] - places[:-1])
    ways[numpy.cumsum([len(line) for line in every[:-1]], dtype=int) - 1] = 0.0  # between two lines
    return float(ways.sum())


def _select_layers(page, path, options):
    """Return {number: lines} of the layers that `options` choose. Raises Failure if one of them is not in the file."""
    if not options.layers:
        return page.layers
    unknown = sorted(set(options.layers) - set(page.layers))
    if unknown:
        raise Failure("{} has no layer {}; it has {}", path, unknown[0], ", ".join(map(str, sorted(page.layers))))
    return {number: page.layers[number] for number in options.layers}


def _why_empty(page):
    """Return a text for people: the reason why nothing of a page can be drawn."""
    reasons = [_count_text(page.left_out)] if page.left_out else []
    reasons += _unseen_of(page)
    if reasons:
        return _("of what it has, nothing can be drawn: {}", "; ".join(reasons))
    return _("the file has no lines, curves or shapes")


def _unseen_of(page):
    """Yield a sentence for shapes that nobody sees, and one for white backgrounds, if the page left any out."""
    if page.unseen:
        yield _("{} × a shape that nobody sees (no stroke, and no fill or one without area; width or opacity 0) is left out; --unseen draws it", page.unseen)
    if page.backgrounds:
        yield _("a white background over the whole page is left out; --unseen draws its edge")


def _count_text(left_out):
    return ", ".join(f"{count} × {_(what)}" if count > 1 else _(what) for what, count in sorted(left_out.items()))


def _notes_of(page, options):
    """Yield sentences about a page for people: the reader's notes, things left out or covered, and the mm of lines outside the page, if above 0.1."""
    yield from page.notes
    if page.left_out:
        yield _("left out, or not as it should be: {}", _count_text(page.left_out))
    if not options.unseen:
        yield from _unseen_of(page)
    if page.covered:
        yield _("{} × a shape below a white area over the whole page, where no viewer shows it, is drawn all the same", page.covered)
    if page.lost_mm > 0.1:
        yield _("{:g} mm of lines lie outside the page and are left out; --no-crop draws them", round(page.lost_mm, 1))


def _order_layers(layers, options, progress):
    """Join, thin and order the lines of each layer, for little travel with the pen up from 0;0. Returns (lines of each layer; the travel in the
    order of the file, mm)."""
    ordered, pen = [], 0j
    before_mm, old = 0.0, 0j
    count, done = sum(map(len, layers)), 0
    for lines in layers:
        before_mm += travel_length(lines, old)
        old = lines[-1][-1]
        progress(N_("ordering"), done / count)
        thin = _simplify_lines(join_in_order(lines, _JOIN_MM) if options.keep_order else join(lines, _JOIN_MM), options.tolerance / 2)
        thin = [_repeat_line(line, options.repeat) for line in thin] if options.repeat > 1 else thin
        if not options.keep_order:

            def report_share(share, done=done, size=len(lines)):
                progress(N_("ordering"), (done + (_JOINING + (1 - _JOINING) * share) * size) / count)

            thin = shorten(thin, pen, report_share)
        ordered.append(thin)
        pen = thin[-1][-1]
        done += len(lines)
    return ordered, before_mm


def _simplify_lines(lines, tolerance):
    """Remove the points that lie within `tolerance` of the line through their neighbours (Douglas and Peucker, by shapely). Returns the lines.
    Of a long line each _PIECE-th point stays."""
    long = [number for number, line in enumerate(lines) if len(line) > 2]
    if not long:
        return lines
    pieces = [lines[number][first : first + _PIECE + 1] for number in long for first in range(0, len(lines[number]) - 1, _PIECE)]
    ends = numpy.cumsum([-(-(len(lines[number]) - 1) // _PIECE) for number in long])
    points = numpy.concatenate(pieces)
    made = shapely.simplify(shapely.linestrings(points.real, points.imag, indices=numpy.repeat(numpy.arange(len(pieces)), list(map(len, pieces)))), tolerance)
    places, owner = shapely.get_coordinates(made, return_index=True)
    joint = numpy.append(False, owner[1:] != owner[:-1])  # the first point of a piece, which ends the piece before it
    joint[numpy.searchsorted(owner, numpy.append(0, ends[:-1]))] = False
    places, owner = places[~joint], numpy.searchsorted(ends, owner[~joint], side="right")
    kept = numpy.split(places[:, 0] + 1j * places[:, 1], numpy.flatnonzero(numpy.diff(owner)) + 1)
    lines = list(lines)
    for number, line in zip(long, kept):
        lines[number] = line
    return lines


def _repeat_line(line, times):
    """Return a line that is drawn several times: a closed line goes round again, an open one goes there and back."""
    closed = line[0] == line[-1]
    ways = [line if closed or index % 2 == 0 else line[::-1] for index in range(times)]
    return numpy.concatenate([ways[0], *(way[1:] for way in ways[1:])]) if times > 1 else line


def _to_steps(lines, steps_per_mm, travel):
    """Round lines in mm to points in steps, without repeats. A line shorter than a step stays as a dot: the same point twice."""
    if not lines:
        return []
    points = numpy.concatenate(lines)
    firsts = numpy.cumsum([0, *map(len, lines)])
    xs = numpy.clip(numpy.rint(points.real * steps_per_mm[0]), 0, travel[0]).astype(int)
    ys = numpy.clip(numpy.rint(points.imag * steps_per_mm[1]), 0, travel[1]).astype(int)
    fresh = numpy.append(True, (xs[1:] != xs[:-1]) | (ys[1:] != ys[:-1]))
    fresh[firsts[:-1]] = True
    bounds = numpy.concatenate([[0], numpy.cumsum(fresh)])[firsts].tolist()
    places = list(zip(xs[fresh].tolist(), ys[fresh].tolist()))
    return [places[begin:end] * (1 if end - begin > 1 else 2) for begin, end in zip(bounds, bounds[1:])]
