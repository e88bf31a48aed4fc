"""Text of an SVG file as the outlines of its letters, in the fonts of this computer.

    pieces = collect_letters(element, style_of, lengths)    # letters with their positions and fonts
    lines = outlines_of(pieces, deviation, left_out)   # polylines, in the element's own coordinates

A font that is not installed is named in `left_out`. Letters follow each other as the font has them; x, y, dx, dy, rotate,
textLength, text-anchor, letter-spacing, word-spacing, baseline-shift and text-transform are kept, and letters stand on the path of a
<textPath>, each by its middle. Vertical text is not drawn; text from right to left, small capitals and lines under text are named.
"""

import unicodedata
import warnings
from dataclasses import dataclass, field
from functools import lru_cache

import numpy

from host_tools.drawings import svg_font, svg_geometry
from host_tools.drawings.svg_style import local_name
from host_tools.language import N_

_DEEPEST = 100
_SPACE = "{http://www.w3.org/XML/1998/namespace}space"


# Of ascent, descent and the height of an x.
_SHARES = {
    "middle": (0, 0, 0.5), "central": (0.5, -0.5, 0), "hanging": (0.8, 0, 0), "mathematical": (0.5, 0, 0), "ideographic": (0, -1, 0),
    **dict.fromkeys(("text-before-edge", "before-edge", "text-top"), (1, 0, 0)), **dict.fromkeys(("text-after-edge", "after-edge", "text-bottom"), (0, -1, 0)),
}  # fmt: skip


@dataclass
class Letter:
    text: str
    style: dict
    size: float
    keep_space: bool
    x: float | None = None  # its position, if the file gives one
    y: float | None = None
    dx: float = 0.0
    dy: float = 0.0
    rotate: float = 0.0  # degrees
    way: object = None  # of a <textPath>: Way
    up: float = 0.0  # above its line
    wide: float = 1.0  # how much wider than its font has it


@dataclass
class Way:
    """The line below letters: polylines one behind the other, and how far along them they begin."""

    lines: list
    begin: float

    def __post_init__(self):
        self.line = numpy.concatenate(self.lines)
        steps = abs(numpy.diff(self.line))
        steps[numpy.cumsum([len(line) for line in self.lines])[:-1] - 1] = 0.0  # from one to the next
        self.along = numpy.concatenate(([0.0], numpy.cumsum(steps)))

    def position_at(self, distance):
        """Return (position, direction as a complex number of length 1) at a distance along the way, or None off its ends."""
        if not 0 <= distance <= self.along[-1]:
            return None
        index = min(max(int(numpy.searchsorted(self.along, distance, "right")) - 1, 0), len(self.line) - 2)
        while index and self.along[index + 1] == self.along[index]:
            index -= 1
        step = self.line[index + 1] - self.line[index]
        return self.line[index] + (distance - self.along[index]) * step / abs(step), step / abs(step)


@dataclass
class _Run:
    """Letters of one font that follow each other."""

    style: dict
    size: float
    text: str
    dx: float = 0.0
    dy: float = 0.0
    rotate: float = 0.0
    up: float = 0.0
    wide: float = 1.0


@dataclass
class _Chunk:
    """The text from one position that the file gives to the next: text-anchor counts for the whole of it."""

    x: float
    y: float
    anchor: str
    way: object = None
    runs: list = field(default_factory=list)


def collect_letters(element, style, style_of, viewport, left_out, way_of):
    """Return the letters of a <text>, spaces collapsed. `style_of(child, style)`: the style of a <tspan>, `way_of(child)`: the polylines of a
    <textPath>, or None."""
    letters = []
    _collect_into(element, style, (style_of, way_of), viewport, left_out, letters, False)
    return _without_end(letters)


def _without_end(letters):
    """Return the letters without blanks at the end."""
    count = len(letters)
    while count and _is_blank(letters[count - 1]):
        count -= 1
    return letters[:count]


def _is_blank(letter):
    return letter.text == " " and not letter.keep_space


def _collect_into(element, style, found_by, viewport, left_out, letters, keep_space, depth=0):
    """Append the letters of a <text> or <tspan>, and of all in it, to `letters`; its x, y, dx, dy and rotate go to letters without their own.
    `found_by`: (style_of, way_of) of collect_letters(). Raises ValueError at _DEEPEST levels."""
    if depth == _DEEPEST:
        raise ValueError(f"{_DEEPEST} levels of text in text")
    keep_space = element.get(_SPACE, "preserve" if keep_space else "") == "preserve" or style.get(
        "white-space", ""
    ).startswith("pre")
    style_of, way_of = found_by
    size = float(style["font-size"])
    first = len(letters)
    _name_others(element, style, left_out)
    _add_letters(element.text, style, size, keep_space, letters)
    for child in element:
        tag = local_name(child.tag)
        if tag in ("tspan", "a"):
            inner = style_of(child, style)
            if inner.get("display") != "none":
                begin = len(letters)
                _collect_into(child, inner, found_by, viewport, left_out, letters, keep_space, depth + 1)
                for letter in letters[begin:]:
                    letter.up += _shift_px(inner.get("baseline-shift"), size)
        elif tag == "tref":
            left_out[N_("text of another place (<tref>)")] += 1
        elif tag == "textPath" and way_of:
            begin, inner = len(letters), style_of(child, style)
            _collect_on_path(child, inner, found_by, viewport, left_out, letters, keep_space, depth + 1)
            for letter in letters[begin:]:
                letter.up += _shift_px(inner.get("baseline-shift"), size)
        _add_letters(child.tail, style, size, keep_space, letters)
    turns = svg_geometry.read_numbers(element.get("rotate"))
    for index, letter in enumerate(letters[first:] if turns else ()):
        letter.rotate = letter.rotate or turns[min(index, len(turns) - 1)]
    for name, whole in (("x", viewport[0]), ("y", viewport[1]), ("dx", viewport[0]), ("dy", viewport[1])):
        positions = [svg_geometry.length_px(each, whole, size) for each in element.get(name, "").replace(",", " ").split()]
        for letter, position in zip(letters[first:], positions):
            if getattr(letter, name) in (None, 0.0):  # a <tspan> inside goes before
                setattr(letter, name, position)
    _stretch_letters(element, _without_end(letters[first:]), viewport[0], size, left_out)


def _name_others(element, style, left_out):
    """Count text that is drawn otherwise than the file has it."""
    text = "".join((element.text or "", *(child.tail or "" for child in element)))
    if text.strip() and (style.get("direction") == "rtl" or any(unicodedata.bidirectional(each) in ("R", "AL") for each in text)):
        left_out[N_("text from right to left (drawn from left to right)")] += 1
    if text.strip() and "small-caps" in style.get("font-variant", ""):
        left_out[N_("small capitals (drawn as small letters)")] += 1
    if style.get("text-decoration", "none").split()[:1] not in (["none"], []):
        left_out[N_("line under, over or through text")] += 1
    if style.get("font-variation-settings", "normal") != "normal" or style.get("font-stretch", "normal") not in ("normal", "100%"):
        left_out[N_("letters varied or stretched by their font (drawn as they are)")] += 1
    if "%" in style.get("letter-spacing", "") + style.get("word-spacing", ""):
        left_out[N_("space between letters in per cent")] += 1
    line = style.get("dominant-baseline", "auto")
    if style.get("alignment-baseline", "auto") not in ("auto", "baseline", "alphabetic" if line == "auto" else line):
        left_out[N_("text moved by alignment-baseline")] += 1


def _stretch_letters(element, letters, whole, size, left_out):
    """Carry out textLength: widen blanks between letters, or the letters, so that they are as long as the file says."""
    wanted = svg_geometry.length_px(element.get("textLength"), whole, size)
    if wanted <= 0 or not letters or any(letter.x is not None for letter in letters[1:]):
        return
    runs = [_Run(letter.style, letter.size, letter.text, letter.dx) for letter in letters]
    natural = sum(_run_lengths(runs, left_out)) + sum(run.dx for run in runs[1:])
    if element.get("lengthAdjust") == "spacingAndGlyphs":
        for letter in letters:
            letter.wide *= wanted / natural if natural > 0 else 1.0
    else:
        for letter in letters[1:]:
            letter.dx += (wanted - natural) / (len(letters) - 1)


def _shift_px(text, size):
    """Return how far above its line a <tspan> of baseline-shift stands, in px; `size` is its parent's. As Inkscape has it."""
    return {"super": 0.4 * size, "sub": -0.2 * size}.get(text, svg_geometry.length_px(text, size, size))


def _collect_on_path(element, style, found_by, viewport, left_out, letters, keep_space, depth):
    """Collect the letters of a <textPath>."""
    lines = found_by[1](element)
    if style.get("display") == "none":
        return
    if not lines or not sum(abs(numpy.diff(line)).sum() for line in lines):
        left_out[N_("text along a path that is not in the file")] += 1
        return
    if element.get("side") == "right":
        lines = [line[::-1] for line in reversed(lines)]
    first = len(letters)
    way = Way(lines, 0.0)
    way.begin = svg_geometry.length_px(element.get("startOffset"), way.along[-1], float(style["font-size"]))
    if element.get("path") is not None:
        left_out[N_("path that a <textPath> has of its own")] += 1
    _collect_into(element, style, (found_by[0], None), viewport, left_out, letters, keep_space, depth)
    left_out.update({_PLACED: 1} if any(letter.x is not None or letter.y is not None for letter in letters[first:]) else {})
    for letter in letters[first:]:
        letter.way, letter.x, letter.y = letter.way or way, None, None


_PLACED = N_("places of letters along a path (x, y, dy)")
_CASES = {"uppercase": str.upper, "lowercase": str.lower, "capitalize": str.title}


def _add_letters(text, style, size, keep_space, letters):
    """Append the letters of a text of `size` px, with text-transform carried out. Combining signs join the letter before; of several blanks the first
    is appended, unless `keep_space`."""
    text = _CASES.get(style.get("text-transform"), str)(text or "")
    for each in text:
        letter = Letter(" " if each.isspace() and each != "\xa0" else each, style, size, keep_space)
        if unicodedata.combining(each) and letters:
            letters[-1].text += each
        elif not _is_blank(letter) or letters and not _is_blank(letters[-1]):  # of several blanks the first, none at the beginning
            letters.append(letter)


def outlines_of(letters, deviation, left_out):
    """Return the outlines of letters as polylines, y down."""
    lines = []
    x = y = 0.0
    behind = False
    for chunk in _find_chunks(letters):
        x = x if chunk.x is None else chunk.x
        y = y if chunk.y is None else chunk.y
        ways = _run_lengths(chunk.runs, left_out)
        width = sum(run.dx for run in chunk.runs[1:]) + sum(ways)  # the first one's dx moves the whole
        before = {"middle": width / 2, "end": width}.get(chunk.anchor, 0.0)
        if chunk.way:
            left_out.update({_PLACED: 1} if (chunk.x, chunk.y) != (None, None) or any(run.dy for run in chunk.runs) else {})
            lines += _on_way(chunk, chunk.way.begin - before, ways, deviation, left_out)
            behind = True
            continue
        if behind and None in (chunk.x, chunk.y) and any(run.text.strip() for run in chunk.runs):
            left_out[N_("text behind text along a path (drawn as if that were not there)")] += 1
        x -= before
        for run, way in zip(chunk.runs, ways):
            x, y = x + run.dx, y + run.dy
            drawn = _letter_outlines(run, x, y - run.up, deviation, left_out)
            lines += svg_geometry.transform_lines(drawn, svg_geometry.read_matrix(f"rotate({run.rotate} {x} {y - run.up})")) if run.rotate else drawn
            x += way
    return lines


def _on_way(chunk, at, ways, deviation, left_out):
    """Return the outlines of letters along a path; those whose middle is off its ends are not shown."""
    lines, off = [], 0.0
    for run, way in zip(chunk.runs, ways):
        wide = _advance_px(run, left_out)
        at, off = at + run.dx, off + run.dy
        found = chunk.way.position_at(at + wide / 2)
        if found is not None:
            place, direction = found
            turned = direction * complex(numpy.exp(1j * numpy.radians(run.rotate)))
            for line in _letter_outlines(run, -wide / 2, -run.up, deviation, left_out):
                lines.append(place + 1j * direction * off + line * turned)
        elif run.text.strip():
            left_out[N_("letters beyond the end of their path")] += 1
        at += way
    return lines


def _find_chunks(letters):
    """Return the _Chunks of letters: a new one at each x, y or path of the file. Letters of one style that follow each other plainly are one _Run."""
    chunks = []
    for letter in letters:
        if not chunks or letter.x is not None or letter.y is not None or letter.way is not chunks[-1].way:
            chunks.append(_Chunk(letter.x, letter.y, letter.style.get("text-anchor", "start"), letter.way))
        runs = chunks[-1].runs
        single = letter.dx or letter.dy or letter.rotate or letter.way or _spacing_px(letter.style, letter.size)
        same = runs and runs[-1].style is letter.style and (runs[-1].up, runs[-1].wide) == (letter.up, letter.wide)
        if same and not single and not runs[-1].rotate:
            runs[-1].text += letter.text
        else:
            runs.append(_Run(letter.style, letter.size, letter.text, letter.dx, letter.dy, letter.rotate, letter.up, letter.wide))
    return chunks


def _spacing_px(style, size, text=" "):
    """Return the extra px behind a letter, and behind a blank."""
    words = text == " " and svg_geometry.length_px(style.get("word-spacing"), None, size)
    return svg_geometry.length_px(style.get("letter-spacing"), None, size) + words


def _advance_px(run, left_out):
    """Return the length of a run in px, with its spacing, stretched as it is drawn. A font that is not installed goes to `left_out`."""
    from matplotlib.textpath import text_to_path

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        width, _, _ = text_to_path.get_text_width_height_descent(run.text, svg_font.font_of(run.style, left_out, run.text), False)
    return (width * run.size / svg_font.EM + _spacing_px(run.style, run.size, run.text)) * run.wide


def _run_lengths(runs, left_out):
    """Return how far each run's end is from its begin; letters of the same kind stand as close as within a run."""
    ways = [_advance_px(run, left_out) for run in runs]
    for index, (run, after) in enumerate(zip(runs, runs[1:])):
        if (after.style, after.size, after.wide) == (run.style, run.size, run.wide):
            pair = run.text[-1:] + after.text[:1]
            ways[index] += _kerning_share(svg_font.font_of(run.style, left_out, pair), pair) * run.size * run.wide
    return ways


@lru_cache(maxsize=4096)
def _kerning_share(font, pair):
    """Return how much wider two letters are together than one by one, as a part of the font's size; negative: closer."""
    from matplotlib.textpath import text_to_path

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        whole, *parts = (text_to_path.get_text_width_height_descent(text, font, False)[0] for text in (pair, *pair))
    return (whole - sum(parts)) / svg_font.EM


def _letter_outlines(run, x, y, deviation, left_out):
    """Return the outlines of letters whose line begins at a position; none if they are hidden."""
    if run.style.get("visibility", "visible") != "visible":
        return []
    from matplotlib.path import Path
    from matplotlib.textpath import text_to_path

    font = svg_font.font_of(run.style, left_out, run.text)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        vertices, codes = text_to_path.get_text_path(font, run.text, False)
    missing = svg_font.count_missing(font, run.text)
    if missing:
        left_out[N_("letters that the font has not (boxes are drawn for them)")] += missing
    scale = run.size / svg_font.EM
    y += _baseline_px(run.style.get("dominant-baseline"), font, run.size)
    lines = []
    for vertex, code in Path(vertices, codes).iter_segments(curves=True, simplify=False) if len(vertices) else ():
        positions = (vertex[0::2] * scale * run.wide + x) - 1j * (vertex[1::2] * scale - y)
        if code == Path.MOVETO:
            lines.append([positions[0]])
        elif code == Path.CLOSEPOLY:
            lines[-1].append(lines[-1][0])
        elif code == Path.CURVE3:
            lines[-1] += svg_geometry.flatten_quadratic(lines[-1][-1], *positions, deviation)
        elif code == Path.CURVE4:
            lines[-1] += svg_geometry.flatten_cubic(lines[-1][-1], *positions, deviation)
        else:
            lines[-1].append(positions[0])
    return [numpy.array(line) for line in lines if len(line) > 1]


def _baseline_px(name, font, size):
    """Return how far below its position a line of text stands, in px, by a dominant-baseline, as browsers have it."""
    share = _SHARES.get(name)
    return sum(part * height for part, height in zip(share, svg_font.font_heights(font))) * size if share else 0.0
