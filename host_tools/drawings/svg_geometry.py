"""Shapes of an SVG file as polylines: arrays of complex numbers x + iy.

    segments, whole = svg_path.read("M0 0C1 1 2 2 3 0")
    lines = flatten_segments(segments, 0.1)        # chords at most 0.1 from their curves
    lines = transform_lines(lines, compose_matrices(parent, read_matrix("rotate(30)")))

A matrix is (a, b, c, d, e, f) as in SVG's read_matrix(): x' = ax + cy + e, y' = bx + dy + f.
"""

import math
import re
from functools import lru_cache

import numpy

from host_tools.language import N_

IDENTITY = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
_PX = {"": 1.0, "px": 1.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "q": 96 / 101.6, "in": 96.0, "pt": 4 / 3, "pc": 16.0}
_OF_LETTERS = {"em": 1.0, "rem": 1.0, "ex": 0.5, "ch": 0.5}  # of the font's size
_LENGTH = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z%]*)\s*$")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_NEXT = re.compile(rf"[\s,]*({_NUMBER.pattern})")
_APART = re.compile(r"[\s,]+|(?<=[\d.])(?=[-+])(?<![eE])")
_TURN = {"deg": 1.0, "rad": 180 / math.pi, "grad": 0.9, "turn": 360.0}
_STEP = re.compile(r"(\w+)\s*\(([^()]*)\)")
_FARTHEST_PX = 1e7  # 2.6 km: a position beyond is a mistake in the file
_LARGEST = 1e15  # of numbers in units of the file's own: KiCad's are nanometres
_MOST_REACH_PX = 1e10  # of a shape that a matrix takes back to the page: a curve of it has 300 000 chords at most
_MOST_KEPT = 100  # chords of a curve whose weights are kept: 300 kB in all
_MOST_DASHES = 20_000  # of one line: more are a mistake in the file


class TooFar(ValueError):
    """A number that is none, or too large for a drawing. Its text says which."""


def check_bound(value, most=_FARTHEST_PX):
    """Return a number of px on the page. Raises TooFar if its size is above `most`."""
    if not -most <= value <= most:
        raise TooFar(f"{value:g}")
    return value


def check_finite(value):
    """Return a number in units of the file's own. Raises TooFar if it is not finite, or too large."""
    return check_bound(value, _LARGEST)


def check_reach(size):
    """Return the size of a shape, in px. Raises TooFar if it is too large."""
    return check_bound(size, _MOST_REACH_PX)


def on_page(lines):
    """Return lines, in px of the page. Raises TooFar if one leaves the largest page."""
    if lines:
        every = numpy.concatenate(lines)
        for places in (every.real, every.imag) if len(every) else ():
            check_bound(float(places[abs(places).argmax()]))
    return lines


def length_px(text, whole=None, font_size=16.0, default=0.0):
    """Return a length in px; `whole` is 100 %. Returns `default` if there is none, or it cannot be read. Raises TooFar."""
    match = _LENGTH.match(text) if text else None
    if not match:
        return default
    number, unit = float(match[1]), match[2].lower()
    if unit == "%":
        return default if whole is None else check_finite(number * whole / 100)
    if unit in _OF_LETTERS:
        return check_finite(number * font_size * _OF_LETTERS[unit])
    return check_finite(number * _PX[unit]) if unit in _PX else default


def are_lengths(text):
    """True of lengths or numbers, none or several, in units that are known."""
    found = [_LENGTH.match(part) for part in _APART.split(text.strip()) if part]
    return all(match and (match[2].lower() in _PX or match[2].lower() in _OF_LETTERS or match[2] == "%") for match in found)


def up_to_a_mistake(text):
    """Return (numbers of a list of points up to its first mistake, True if there is none). Raises TooFar."""
    text, found, at = text or "", [], 0
    while match := _NEXT.match(text, at):
        found.append(check_finite(float(match[1])))
        at = match.end()
    return found, len(found) % 2 == 0 and not text[at:].strip(", \t\r\n")


def read_numbers(text):
    """Return all numbers of a text. Raises TooFar."""
    found = list(map(float, _NUMBER.findall(text or "")))
    if found:
        check_finite(max(found, key=abs))
    return found


# --- matrices


def read_matrix(text, viewport=(0.0, 0.0), font_size=16.0):
    """Return the matrix of a transform attribute, or of the property of a style sheet, which has units. `viewport`: the size of which per cent are.
    Raises ValueError if it cannot be read, TooFar."""
    text = text or ""
    found = IDENTITY
    if text.strip() == "none":
        return found
    for name, arguments in _STEP.findall(text):
        parts = [part for part in _APART.split(arguments.strip()) if part]
        given = [_read_argument(name, index, part, viewport, font_size) for index, part in enumerate(parts)]
        found = compose_matrices(found, _step_matrix(name, given))
    if _STEP.sub("", text).replace(",", " ").strip():
        raise ValueError(f"{text!r} is no transform")
    return found


def _read_argument(name, index, text, viewport, font_size):
    """Return one argument of a transform function: angles in degrees, lengths of translate and rotate in px, others as plain numbers. `index`: its
    position among the arguments. Raises ValueError if it is no number or has a wrong unit, TooFar."""
    match = _LENGTH.match(text)
    if not match:
        raise ValueError(f"{text!r} is no number")
    unit = match[2].lower()
    if unit in _TURN:
        return check_finite(float(match[1]) * _TURN[unit])
    if name.startswith(("translate", "rotate")):
        down = name == "translateY" or index == (2 if name == "rotate" else 1)
        return length_px(text, viewport[down], font_size, math.nan)
    if unit == "%" and name.startswith("scale"):
        return check_finite(float(match[1]) / 100)
    if unit:
        raise ValueError(f"{text!r} is no number")
    return check_finite(float(match[1]))


def _step_matrix(name, given):
    """Return the matrix of one transform function and its arguments; angles are degrees. Raises ValueError if it does not take as many arguments."""
    if (name, len(given)) == ("matrix", 6):
        return tuple(given)
    if name == "translate" and len(given) in (1, 2):
        return (1.0, 0.0, 0.0, 1.0, given[0], given[1] if len(given) > 1 else 0.0)
    if name in ("translateX", "translateY") and len(given) == 1:
        return (1.0, 0.0, 0.0, 1.0, *((given[0], 0.0) if name == "translateX" else (0.0, given[0])))
    if name == "scale" and len(given) in (1, 2):
        return (given[0], 0.0, 0.0, given[-1], 0.0, 0.0)
    if name in ("scaleX", "scaleY") and len(given) == 1:
        return (given[0], 0.0, 0.0, 1.0, 0.0, 0.0) if name == "scaleX" else (1.0, 0.0, 0.0, given[0], 0.0, 0.0)
    if name == "rotate" and len(given) in (1, 3):
        cosine, sine = math.cos(math.radians(given[0])), math.sin(math.radians(given[0]))
        x, y = given[1:] or (0.0, 0.0)
        return (cosine, sine, -sine, cosine, x - cosine * x + sine * y, y - sine * x - cosine * y)
    if name == "skew" and len(given) in (1, 2):
        across, down = (math.tan(math.radians(each)) for each in (given + [0.0])[:2])
        return (1.0, down, across, 1.0, 0.0, 0.0)
    if name in ("skewX", "skewY") and len(given) == 1:
        lean = math.tan(math.radians(given[0]))
        return (1.0, lean, 0.0, 1.0, 0.0, 0.0) if name == "skewY" else (1.0, 0.0, lean, 1.0, 0.0, 0.0)
    raise ValueError(f"{name} does not want {len(given)} numbers")


def matrix_about(by, text, viewport, font_size):
    """Return a matrix about a transform-origin, by default 0 0. Raises ValueError, TooFar."""
    words = (text or "0 0").replace(",", " ").split()
    shares = {"left": "0%", "top": "0%", "center": "50%", "right": "100%", "bottom": "100%"}
    if words[0] in ("top", "bottom") or len(words) > 1 and words[1] in ("left", "right"):
        words[:2] = reversed((*words, "center")[:2])
    x, y = (length_px(shares.get(word, word), whole, font_size, math.nan) for word, whole in zip((*words, "center")[:2], viewport))
    if math.isnan(x) or math.isnan(y):
        raise ValueError(f"{text!r} is no place")
    return compose_matrices(compose_matrices((1.0, 0.0, 0.0, 1.0, x, y), by), (1.0, 0.0, 0.0, 1.0, -x, -y))


def compose_matrices(outer, inner):
    """Return the matrix that first does `inner`, then `outer`. Raises TooFar."""
    a, b, c, d, e, f = outer
    p, q, r, s, t, u = inner
    return tuple(check_finite(each) for each in (a * p + c * q, b * p + d * q, a * r + c * s, b * r + d * s, a * t + c * u + e, b * t + d * u + f))


def inverse_of(of):
    """Return the inverse matrix, or None if there is none."""
    a, b, c, d, e, f = of
    size = a * d - b * c
    if not size:
        return None
    return (d / size, -b / size, -c / size, a / size, (c * f - d * e) / size, (b * e - a * f) / size)


def box_matrix(lines, matrix):
    """Return the matrix from 0…1 to the box of `lines`, in the coordinates of `matrix`."""
    back = inverse_of(matrix)
    if back is None:
        return IDENTITY
    positions = numpy.concatenate(transform_lines(lines, back))
    left, top = positions.real.min(), positions.imag.min()
    return (positions.real.max() - left, 0.0, 0.0, positions.imag.max() - top, left, top)


@lru_cache(maxsize=256)
def stretch_of(of):
    """Return the largest factor by which a matrix lengthens anything: its spectral norm."""
    return float(numpy.linalg.norm(numpy.array([[of[0], of[2]], [of[1], of[3]]]), 2))


def is_straight(line):
    """True if all points lie on one line through the first and the farthest from it, but for 1e-9 of that distance."""
    from_first = line - line[0]
    farthest = from_first[abs(from_first).argmax()]
    return bool(abs((from_first * farthest.conjugate()).imag).max() <= 1e-9 * abs(farthest) ** 2)


def transform_lines(lines, by):
    a, b, c, d, e, f = by
    return [a * line.real + c * line.imag + e + 1j * (b * line.real + d * line.imag + f) for line in lines]


def view_box_matrix(view_box, aspect, x, y, width, height):
    """Return the matrix that shows `view_box` (x, y, width, height) in a viewport, by a preserveAspectRatio (SVG 2, 8.2)."""
    left, top, wide, high = view_box
    across, down = width / wide, height / high
    words = (aspect or "xMidYMid meet").split()
    if words[0] != "none":
        across = down = max(across, down) if "slice" in words else min(across, down)
    share = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
    spare_x, spare_y = width - wide * across, height - high * down
    if words[0] != "none":
        x += spare_x * share.get(words[0][1:4], 0.5)
        y += spare_y * share.get(words[0][5:8], 0.5)
    return (across, 0.0, 0.0, down, x - left * across, y - top * down)


# --- shapes


def shape_path(tag, lengths, points):
    """Return the path data of a basic shape, or None if it is not drawn. `lengths(name, axis)` reads an attribute."""
    if tag == "line":
        return _path_data("M", lengths("x1", "x"), lengths("y1", "y"), "L", lengths("x2", "x"), lengths("y2", "y"))
    if tag in ("polyline", "polygon"):
        positions, _ = up_to_a_mistake(points)
        if len(positions) < 4:
            return None
        return _path_data("M", *positions[: len(positions) // 2 * 2]) + ("Z" if tag == "polygon" else "")
    if tag == "rect":
        return _rect_path(lengths)
    x, y = lengths("cx", "x"), lengths("cy", "y")
    across, down = [lengths("r", None)] * 2 if tag == "circle" else _corner_radii(lengths)
    if across <= 0 or down <= 0:
        return None
    arc = ("A", across, down, 0, 0, 1)
    return _path_data("M", x + across, y, *arc, x, y + down, *arc, x - across, y, *arc, x, y - down, *arc, x + across, y, "Z")


def _corner_radii(lengths):
    """Return rx and ry; one that is missing or negative is the other."""
    across, down = (value if value is not None and value >= 0 else None for value in (lengths("rx", "x", None), lengths("ry", "y", None)))
    return (across if across is not None else down or 0.0), (down if down is not None else across or 0.0)


def _rect_path(lengths):
    """Return the path data of a <rect>, its corners rounded by half a side at most; None if a side is 0 or less. `lengths(name, axis)` reads an
    attribute, in px."""
    x, y, width, height = lengths("x", "x"), lengths("y", "y"), lengths("width", "x"), lengths("height", "y")
    if width <= 0 or height <= 0:
        return None
    across, down = _corner_radii(lengths)
    across, down = min(across, width / 2), min(down, height / 2)
    if across <= 0 or down <= 0:
        return _path_data("M", x, y, "H", x + width, "V", y + height, "H", x, "Z")
    arc = ("A", across, down, 0, 0, 1)
    right, bottom = x + width, y + height
    return _path_data(
        "M", x + across, y, "H", right - across, *arc, right, y + down, "V", bottom - down, *arc, right - across, bottom,
        "H", x + across, *arc, x, bottom - down, "V", y + down, *arc, x + across, y, "Z",
    )  # fmt: skip


def _path_data(*parts):
    return " ".join(part if isinstance(part, str) else repr(part) for part in parts)


def flatten_segments(segments, deviation):
    """Return the polylines of a path's segments, one a subpath, no chord further than `deviation` from its curve. A subpath without length is its
    position twice; a move that nothing follows is left out."""
    lines, line = [], []

    def finish_line():
        """Append the line under way to `lines`, without repeated positions; a line without length stays as a dot of two."""
        if len(line) > 1:
            array = numpy.array(line)
            moved = array[1:] != array[:-1]
            lines.append(array if moved.all() else array[numpy.append(True, moved)] if moved.any() else array[:2])

    for kind, *points in segments:
        if kind == "M":
            finish_line()
            line = points
        elif kind == "L":
            line += points[0]
        elif kind == "C":
            line += flatten_cubic(line[-1], *points, deviation)
        elif kind == "Q":
            line += flatten_quadratic(line[-1], *points, deviation)
        elif kind == "A":
            line += _flatten_arc(*points, deviation)
        else:
            line += points
            finish_line()
            line = points
    finish_line()
    return lines


def _inner_positions(count, *points):
    """Return the positions between the ends of a Bézier curve of these control points, at which its `count` chords meet."""
    weights = _kept_weights if count <= _MOST_KEPT else _bezier_weights
    return (weights(count, len(points)) @ numpy.array(points)).tolist()


def _bezier_weights(count, size):
    """Return the weights (Bernstein) of `size` control points, 4 or 3, at the `count` − 1 inner positions: a row each."""
    t = numpy.linspace(0, 1, count + 1)[1:-1, None]
    s = 1 - t
    return numpy.hstack((s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t) if size == 4 else (s * s, 2 * s * t, t * t))


_kept_weights = lru_cache(maxsize=None)(_bezier_weights)


def flatten_cubic(a, b, c, d, deviation):
    """Return the positions of a cubic Bézier curve behind `a`, its end included, no chord further than `deviation` from it."""
    # A chord over the n-th part of a curve is at most max |B''| / 8n² off; B'' runs between 6 (a - 2b + c) and the next.
    bend = max(abs(a - 2 * b + c), abs(b - 2 * c + d))
    count = max(1, math.ceil(math.sqrt(0.75 * bend / deviation)))
    if count == 1:
        return [d]
    return [*_inner_positions(count, a, b, c, d), d]


def flatten_quadratic(a, b, c, deviation):
    """Return the positions of a quadratic Bézier curve behind `a`, its end included, no chord further than `deviation` from it."""
    count = max(1, math.ceil(math.sqrt(abs(a - 2 * b + c) / deviation / 4)))
    if count == 1:
        return [c]
    return [*_inner_positions(count, a, b, c), c]


def _flatten_arc(segment, end, deviation):
    """Return the positions of an elliptic arc behind its start, its end included, no chord further than `deviation` from it."""
    radius = max(float(segment.rx), float(segment.ry)) if segment.rx and segment.ry else 0.0
    sweep = abs(float(segment.sweep))
    if not radius or not sweep:
        return [end]
    step = 2 * math.acos(max(0.0, 1 - min(deviation, radius) / radius))
    count = max(2, math.ceil(sweep / step))
    positions = numpy.asarray(segment.npoint(numpy.linspace(0, 1, count + 1)[1:-1]), dtype=float).reshape(-1, 2)
    return [*(positions[:, 0] + 1j * positions[:, 1]), end]


def dash_lines(lines, pattern, offset, left_out=None):
    """Return the dashes of polylines, by a stroke-dasharray (lengths) and its offset. A line of too many dashes stays whole, and `left_out` counts
    it."""
    if not pattern or min(pattern) < 0 or sum(pattern) <= 0:
        return lines
    pattern = list(pattern) * (2 if len(pattern) % 2 else 1)
    period = sum(pattern)
    ends = numpy.cumsum(pattern)
    starts = ends - pattern
    dashes = []
    for line in lines:
        along = numpy.concatenate(([0.0], numpy.cumsum(abs(numpy.diff(line)))))
        whole = along[-1]
        if whole / period * len(pattern) > _MOST_DASHES:
            dashes.append(line)
            if left_out is not None:
                left_out[N_("dashes too short to draw (drawn without gaps)")] += 1
            continue
        begin = -(offset % period)
        for number in range(math.ceil((whole - begin) / period)):
            for start, end in zip(starts[::2], ends[::2]):
                low, high = begin + number * period + start, begin + number * period + end
                if (high > 0 or high == low == 0) and low < whole:
                    dashes.append(_part_between(line, along, max(low, 0.0), min(high, whole)))
    return dashes


def _part_between(line, along, low, high):
    """Return the part of a line from the distance `low` to `high` along it; `along`: the distances of its points."""
    inner = line[(along > low) & (along < high)]
    real = numpy.interp([low, high], along, line.real)
    imag = numpy.interp([low, high], along, line.imag)
    return numpy.concatenate(([real[0] + 1j * imag[0]], inner, [real[1] + 1j * imag[1]]))
