"""From an SVG file to objects of points in steps, its page placed on the machine's table.

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

from host_tools import boards
from host_tools.drawings import placement
from host_tools.drawings.placement import MM_PER_PX, Options, percent  # noqa: F401
from host_tools.failure import Failure
from host_tools.language import N_, _

_JOIN_MM = 0.05  # lines whose ends are this close are joined
_EDGE_MM = 0.1  # a line outside the page by less is moved onto its edge


@dataclass
class Part:
    """What one layer, or one pen, draws: lines in drawing order, each a list of (x, y) steps, of two points or more."""

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
    corner_px: tuple[float, float]  # lower left, in the file, of what is placed
    origin_mm: tuple[float, float]  # where that corner stands on the machine
    page_mm: tuple[float, float, float, float]  # the page on the machine: left, bottom, right, top
    box_mm: tuple[float, float, float, float]  # the same of the outlines
    layers: dict = field(default_factory=dict)  # number: name or None, of all in the file
    notes: list = field(default_factory=list)

    @property
    def lines(self):
        """Those of all parts."""
        return [line for part in self.parts for line in part.lines]

    def objects(self, most):
        """The drawing cut into objects of at most `most` points, each [(pen_down, x, y), ...] and begun by a MOVE. A part
        begins a new one."""
        return [points for part in self.parts for points in _cut(part.lines, most)]

    def changes(self, most):
        """{index of an object: the Part that begins with it}, but of the first part."""
        first, found = 0, {}
        for part in self.parts:
            found[first] = part
            first += len(_cut(part.lines, most))
        found.pop(0, None)
        return found

    def digest(self, most):
        """64 hex digits that are equal if and only if the objects of points are."""
        return hashlib.sha256(json.dumps(self.objects(most)).encode()).hexdigest()

    def points(self):
        return sum(len(line) for line in self.lines)

    def lengths_mm(self):
        """Lengths drawn and travelled with the pen up, from 0;0, in mm."""
        down = up = 0.0
        place = (0, 0)
        for line in self.lines:
            up += self._mm(place, line[0])
            down += sum(self._mm(a, b) for a, b in zip(line, line[1:]))
            place = line[-1]
        return down, up

    def _mm(self, a, b):
        return math.hypot((b[0] - a[0]) / self.steps_per_mm[0], (b[1] - a[1]) / self.steps_per_mm[1])


def _cut(lines, most):
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
    """Read, position and order the drawing of an SVG file. Raises Failure if there is nothing to draw, or no room.
    Calls `progress(text, share)` now and then: what is being done, and its share done, 0…1."""
    from host_tools.drawings import sources

    options = options or Options()
    progress = progress or (lambda text, share: None)
    steps_per_mm = boards.steps_per_mm(board)
    if options.place not in ("page", "outlines"):
        raise Failure("--place takes page or outlines, not {!r}", options.place)
    if options.scale is not None and options.scale <= 0:
        raise Failure("--scale must be above 0")
    progress(N_("reading"), 0.0)
    file = sources.opened(path)
    factor = options.scale or 1.0
    if options.place == "page" and options.fit and options.scale is None:
        factor = placement.fitted((0.0, 0.0, *file.size_px), board, options)
    page = _read(file, path, factor, options, progress)
    place = placement.Placement(page, board, options)
    if place.factor > factor:
        page = _read(file, path, place.factor, options, progress)
    chosen = _chosen(page, path, options)
    mm_per_px = MM_PER_PX * place.factor
    left, bottom = place.corner_px
    placed = {
        number: [(line - complex(left, bottom)).conjugate() * mm_per_px + complex(*place.origin_mm) for line in lines]
        for number, lines in sorted(chosen.items())
    }
    box = placement.box_of(placed.values())
    travel = boards.travel_steps(board)
    parts = [
        Part(number, page.names.get(number), _to_steps(lines, steps_per_mm, travel))
        for number, lines in zip(placed, _ordered(list(placed.values()), options.tolerance, progress))
    ]
    names = {number: page.names.get(number) for number in sorted(page.layers)}
    notes = [*_notes_of(page), *place.notes]
    return Drawing(
        str(path), parts, steps_per_mm, place.factor, mm_per_px, place.corner_px, place.origin_mm,
        place.on_table((0.0, 0.0, *page.size_px)), box, names, notes,
    )  # fmt: skip


def _read(file, path, factor, options, progress):
    """The page, cropped; curves as fine as `options.tolerance` after scaling by `factor`."""
    deviation_px = options.tolerance / 4 / MM_PER_PX / max(factor, 1e-3)
    page = file.outlines(deviation_px, lambda share: progress(N_("reading"), share))
    page.layers = {number: lines for number, lines in page.layers.items() if lines}
    if not page.layers:
        raise Failure("{}: nothing to draw: {}", path, _why_empty(page))
    if options.crop:
        progress(N_("cropping"), 0.0)
        whole = _length(page.layers)
        page.layers = {number: _cropped(lines, page.size_px) for number, lines in page.layers.items()}
        page.layers = {number: lines for number, lines in page.layers.items() if lines}
        page.lost_mm = (whole - _length(page.layers)) * MM_PER_PX
        if not page.layers:
            raise Failure("{}: nothing to draw: all of it lies outside the page (--no-crop draws it)", path)
    return page


def _cropped(lines, size_px):
    """The parts of lines on the page; lines outside by less than _EDGE_MM are moved onto its edge."""
    import numpy

    from host_tools.drawings import svg_area

    edge, (width, height) = _EDGE_MM / MM_PER_PX, size_px
    inside = svg_area.clipped(lines, svg_area.rectangle(-edge, -edge, width + edge, height + edge))
    return [numpy.clip(line.real, 0, width) + 1j * numpy.clip(line.imag, 0, height) for line in inside]


def _length(layers):
    return sum(float(abs(line[1:] - line[:-1]).sum()) for lines in layers.values() for line in lines)


def _chosen(page, path, options):
    """The layers that are drawn."""
    if not options.layers:
        return page.layers
    unknown = sorted(set(options.layers) - set(page.layers))
    if unknown:
        raise Failure("{} has no layer {}; it has {}", path, unknown[0], ", ".join(map(str, sorted(page.layers))))
    return {number: page.layers[number] for number in options.layers}


def _why_empty(page):
    if page.left_out:
        return _("of what it has, nothing can be drawn: {}", _counted(page.left_out))
    return _("the file has no lines, curves or shapes")


def _counted(left_out):
    return ", ".join(f"{count} × {_(what)}" if count > 1 else _(what) for what, count in sorted(left_out.items()))


def _notes_of(page):
    if page.left_out:
        yield _("left out, or not as it should be: {}", _counted(page.left_out))
    if page.unpainted:
        yield _("{} × a shape without stroke and fill, which a viewer does not show, is drawn", page.unpainted)
    if page.lost_mm > 0.1:
        yield _("{:.0f} mm of lines lie outside the page and are left out; --no-crop draws them", page.lost_mm)


def _ordered(layers, tolerance_mm, progress):
    """The lines of each layer, joined, thinned, and ordered for little pen-up travel from 0;0."""
    import numpy
    from shapely.geometry import LineString

    from host_tools.drawings.line_order import joined, sorted_from

    ordered = []
    pen = 0j
    count = sum(map(len, layers))
    done = 0
    for lines in layers:
        thin, way = [], []
        for index, line in enumerate(joined(lines, _JOIN_MM)):
            if index % 64 == 0:
                progress(N_("ordering"), (done + index) / count)
            if len(line) > 2:
                points = numpy.column_stack((line.real, line.imag))
                kept = numpy.asarray(LineString(points).simplify(tolerance_mm / 2).coords)
                line = kept[:, 0] + 1j * kept[:, 1]
            thin.append(line)
        for line in sorted_from(thin, pen):
            if len(line) > 3 and line[0] == line[-1]:
                nearest = int(numpy.argmin(abs(line[:-1] - pen)))
                line = numpy.concatenate((line[nearest:-1], line[: nearest + 1]))
            way.append(line)
            pen = line[-1]
        ordered.append(way)
        done += len(lines)
    return ordered


def _to_steps(lines, steps_per_mm, travel):
    """Integer points without repeats. A line shorter than a step stays as a dot: the same point twice."""
    import numpy

    result = []
    for line in lines:
        xs = numpy.clip(numpy.rint(line.real * steps_per_mm[0]), 0, travel[0]).astype(int)
        ys = numpy.clip(numpy.rint(line.imag * steps_per_mm[1]), 0, travel[1]).astype(int)
        fresh = numpy.append(True, (xs[1:] != xs[:-1]) | (ys[1:] != ys[:-1]))
        points = list(zip(xs[fresh].tolist(), ys[fresh].tolist()))
        result.append(points if len(points) > 1 else points * 2)
    return result
