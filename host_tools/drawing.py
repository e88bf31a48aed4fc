"""From an SVG file to objects of points in steps, placed on the machine's area.

    drawing = load("map.svg", boards.load("plotter_2014"), Options(fit=True))
    for points in drawing.objects(1000):            # [(pen_down, x, y), ...], first of each a MOVE
        ...

vpype reads the file: transforms, layers, all shapes. Curves become chords no longer than the tolerance, points within
half the tolerance of their neighbours' line are left out, and rounding to steps adds at most half a step an axis.
Text and pictures inside an SVG are not outlines and are left out. Layers are drawn one after another, lowest first.
"""

import hashlib
import json
import math
from dataclasses import dataclass, field

from host_tools import boards
from host_tools.failure import Failure

MM_PER_PX = 25.4 / 96
_JOIN_MM = 0.05  # ends this close are one line
_EPSILON_MM = 1e-6


@dataclass
class Options:
    """How a drawing is placed. Lengths in mm, `scale` as a factor of the real size."""

    margin: float = 10.0
    fit: bool = False
    scale: float | None = None
    origin: tuple[float, float] | None = None  # of the drawing's lower left corner
    tolerance: float = 0.1
    crop: bool = True
    layers: tuple[int, ...] = ()


@dataclass
class Drawing:
    """Polylines in steps, in drawing order, and what a person wants to know about them."""

    name: str
    lines: list  # of lists of (x, y) steps, two points or more each
    steps_per_mm: tuple[float, float]
    scale: float  # of the real size
    mm_per_px: float
    corner_px: tuple[float, float]  # of the outlines' box in the file: left, bottom
    origin_mm: tuple[float, float]  # where that corner stands on the machine
    size_mm: tuple[float, float]
    notes: list = field(default_factory=list)

    def objects(self, most):
        """The drawing cut into objects of at most `most` points, each [(pen_down, x, y), ...] and begun by a MOVE."""
        cut = [[]]
        for line in self.lines:
            if len(cut[-1]) + len(line) > most and len(line) <= most:
                cut.append([])
            for index, (x, y) in enumerate(line):
                if len(cut[-1]) >= most - (index == 0):
                    cut.append([])
                if not cut[-1] and index:
                    cut[-1].append((False, *line[index - 1]))
                cut[-1].append((index > 0, x, y))
        return [points for points in cut if points]

    def digest(self, most):
        """What the drawing is and where it stands, as 64 hex digits: equal if and only if the objects are."""
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


def load(path, board, options=None):
    """Read, place and order the drawing of an SVG file. Raises Failure where there is nothing to draw or no room."""
    options = options or Options()
    steps_per_mm = boards.steps_per_mm(board)
    notes = []
    layers, size_px = _read(path, options.tolerance / MM_PER_PX, options, notes)
    box = _box(layers)
    factor = _scale(box, board, options, notes)
    if factor > 1:
        layers, size_px = _read(path, options.tolerance / MM_PER_PX / factor, options, [])
        box = _box(layers)
    mm_per_px = MM_PER_PX * factor
    left, top, right, bottom = box
    size = ((right - left) * mm_per_px, (bottom - top) * mm_per_px)
    origin = _origin(size, board, options)
    placed = [
        [(line - complex(left, bottom)).conjugate() * mm_per_px + complex(*origin) for line in lines]
        for _, lines in sorted(layers.items())
    ]
    lines = _to_steps(_ordered(placed, options.tolerance), steps_per_mm, boards.travel_steps(board))
    return Drawing(str(path), lines, steps_per_mm, factor, mm_per_px, (left, bottom), origin, size, notes)


def _read(path, quantum_px, options, notes):
    """{layer: [complex array, ...]} in px of 1/96 inch, y down, and the page's size."""
    import vpype

    try:
        document = vpype.read_multilayer_svg(str(path), quantization=quantum_px, crop=False)
    except FileNotFoundError as error:
        raise Failure(f"no file {path}") from error
    except Exception as error:
        raise Failure(f"{path} is not an SVG file that can be read: {error}") from error
    whole = document.length()
    if options.crop:
        document.crop(0, 0, *document.page_size)
        lost_mm = (whole - document.length()) * MM_PER_PX
        if lost_mm > 0.1:
            notes.append(f"{lost_mm:.0f} mm of lines lie outside the page and are left out; --no-crop draws them")
    layers = {number: [line for line in lines if len(line) > 1] for number, lines in document.layers.items()}
    layers = {number: lines for number, lines in layers.items() if lines}
    if options.layers:
        unknown = sorted(set(options.layers) - set(layers))
        if unknown:
            raise Failure(f"{path} has no layer {unknown[0]}; it has {', '.join(map(str, sorted(layers))) or 'none'}")
        layers = {number: layers[number] for number in options.layers}
    if not layers:
        why = "all of it lies outside the page (--no-crop draws it)" if whole else _why_empty(path)
        raise Failure(f"{path}: nothing to draw: {why}")
    return layers, document.page_size


def _why_empty(path):
    with open(path, encoding="utf-8", errors="replace") as file:
        text = file.read()
    if "<text" in text:
        return "it has text but no outlines; convert the text to paths first"
    if "<image" in text:
        return "it has a picture but no outlines"
    return "the file has no lines, curves or shapes"


def _box(layers):
    everything = [line for lines in layers.values() for line in lines]
    return (
        min(line.real.min() for line in everything), min(line.imag.min() for line in everything),
        max(line.real.max() for line in everything), max(line.imag.max() for line in everything),
    )


def _table_mm(board):
    return tuple(steps / per_mm for steps, per_mm in zip(boards.travel_steps(board), boards.steps_per_mm(board)))


def _scale(box, board, options, notes):
    """The factor of the real size: the one asked for, or 1, or as much less as makes the drawing fit."""
    width, height = (box[2] - box[0]) * MM_PER_PX, (box[3] - box[1]) * MM_PER_PX
    room = [table - 2 * options.margin for table in _table_mm(board)]
    if min(room) <= 0:
        raise Failure(f"a margin of {options.margin:g} mm leaves no room on the table")
    if options.scale is not None:
        if options.scale <= 0:
            raise Failure("--scale must be above 0")
        return options.scale
    largest = min(room[0] / max(width, 1e-9), room[1] / max(height, 1e-9))
    if options.fit:
        return largest if max(width, height) > 1e-6 else 1.0
    if largest < 1:
        notes.append(f"its real size of {width:.1f} × {height:.1f} mm does not fit: drawn at {largest * 100:.1f} %")
    return min(1.0, largest)


def _origin(size, board, options):
    """Where the lower left corner stands: as asked for, or so that the drawing is in the middle of the table."""
    table = _table_mm(board)
    origin = options.origin
    if origin is None:
        origin = tuple((room - length) / 2 for room, length in zip(table, size))
    for low, length, room in zip(origin, size, table):
        if low < -_EPSILON_MM or low + length > room + _EPSILON_MM:
            raise Failure(
                f"the drawing, {size[0]:.1f} × {size[1]:.1f} mm with its corner at {origin[0]:.1f}, {origin[1]:.1f}, "
                f"leaves the table of {table[0]:g} × {table[1]:g} mm; use --fit, or a smaller --scale or --origin"
            )
    return origin


def _ordered(layers, tolerance_mm):
    """Lines of all layers, joined, thinned and put in an order with little pen-up travel, from 0;0 on."""
    import numpy
    import vpype
    from shapely.geometry import LineString
    from vpype_cli import execute

    ordered = []
    pen = 0j
    for lines in layers:
        collection = vpype.LineCollection(lines)
        collection.merge(tolerance=_JOIN_MM)
        thin = []
        for line in collection:
            if len(line) > 2:
                points = numpy.column_stack((line.real, line.imag))
                kept = numpy.asarray(LineString(points).simplify(tolerance_mm / 2).coords)
                line = kept[:, 0] + 1j * kept[:, 1]
            thin.append(line)
        # linesort keeps the first line first: a dot where the pen stands makes it begin there.
        document = vpype.Document(vpype.LineCollection([numpy.array([pen, pen]), *thin]))
        for line in list(execute("linesort", document).layers[1])[1:]:
            if len(line) > 3 and line[0] == line[-1]:
                nearest = int(numpy.argmin(abs(line[:-1] - pen)))
                line = numpy.concatenate((line[nearest:-1], line[: nearest + 1]))
            ordered.append(line)
            pen = line[-1]
    return ordered


def _to_steps(lines, steps_per_mm, travel):
    """Integer points without repeats. A line shorter than a step stays as a dot: the same point twice."""
    result = []
    for line in lines:
        points = []
        for place in line:
            x = min(max(round(float(place.real) * steps_per_mm[0]), 0), travel[0])
            y = min(max(round(float(place.imag) * steps_per_mm[1]), 0), travel[1])
            if not points or points[-1] != (x, y):
                points.append((x, y))
        result.append(points if len(points) > 1 else points * 2)
    return result
