"""Text of an SVG file as the outlines of its letters, in the fonts of this computer.

    pieces = collect(element, style_of, lengths)    # letters with their positions and fonts
    lines = outlines(pieces, deviation, left_out)   # polylines, in the element's own coordinates

A font that is not installed is replaced by the one that matplotlib takes for it, and `left_out` is told so. Letters follow
each other as the font has them; x, y, dx, dy, text-anchor and letter-spacing are kept; text along a path, rotated letters
and vertical text are not drawn.
"""

import logging
import warnings
from dataclasses import dataclass, field
from functools import lru_cache

import numpy

from host_tools.drawings import svg_geometry
from host_tools.drawings.svg_style import local_name
from host_tools.language import N_, _

_EM = 100.0  # matplotlib makes letters of this size
_GENERIC = {"sans-serif": "sans-serif", "serif": "serif", "monospace": "monospace", "cursive": "cursive",
            "fantasy": "fantasy", "system-ui": "sans-serif", "sans": "sans-serif"}  # fmt: skip
_DEEPEST = 100
_SPACE = "{http://www.w3.org/XML/1998/namespace}space"


@dataclass
class Letter:
    text: str
    style: dict
    size: float
    keep_space: bool
    x: float | None = None  # where it stands, if the file says so
    y: float | None = None
    dx: float = 0.0
    dy: float = 0.0


@dataclass
class _Run:
    """Letters of one font that follow each other."""

    style: dict
    size: float
    text: str
    dx: float
    dy: float


@dataclass
class _Chunk:
    """What stands from one place that the file gives to the next: text-anchor counts for the whole of it."""

    x: float
    y: float
    anchor: str
    runs: list = field(default_factory=list)


def collect(element, style, style_of, viewport, left_out):
    """The letters of a <text>, spaces collapsed. `style_of(child, style)` is the style of a <tspan>."""
    letters = []
    _collect(element, style, style_of, viewport, left_out, letters, False)
    return _collapsed(letters)


def _collapsed(letters):
    """Without blanks at the beginning and the end of a line, and behind other blanks."""
    kept = []
    for letter in letters:
        fresh = letter.x is not None or letter.y is not None
        while fresh and kept and _is_blank(kept[-1]):
            kept.pop()
        if not _is_blank(letter) or fresh or (kept and kept[-1].text != " "):
            kept.append(letter)
    while kept and _is_blank(kept[-1]):
        kept.pop()
    return kept


def _is_blank(letter):
    return letter.text == " " and not letter.keep_space


def _collect(element, style, style_of, viewport, left_out, letters, keep_space, depth=0):
    if depth == _DEEPEST:
        raise ValueError(f"{_DEEPEST} levels of text in text")
    keep_space = element.get(_SPACE, "preserve" if keep_space else "") == "preserve" or style.get(
        "white-space", ""
    ).startswith("pre")
    size = float(style["font-size"])
    first = len(letters)
    _spell(element.text, style, size, keep_space, letters)
    for child in element:
        tag = local_name(child.tag)
        if tag in ("tspan", "a"):
            inner = style_of(child, style)
            if inner.get("display") != "none":
                _collect(child, inner, style_of, viewport, left_out, letters, keep_space, depth + 1)
        elif tag == "textPath":
            left_out[N_("text along a path")] += 1
        _spell(child.tail, style, size, keep_space, letters)
    if element.get("rotate") not in (None, "0"):
        left_out[N_("the turning of single letters")] += 1
    for name, whole in (("x", viewport[0]), ("y", viewport[1]), ("dx", viewport[0]), ("dy", viewport[1])):
        positions = [svg_geometry.length(each, whole, size) for each in element.get(name, "").replace(",", " ").split()]
        for letter, position in zip(_collapsed(letters[first:]) if positions else (), positions):
            if getattr(letter, name) in (None, 0.0):  # what a <tspan> inside says goes before
                setattr(letter, name, position)


def _spell(text, style, size, keep_space, letters):
    for each in text or "":
        letters.append(Letter(" " if each.isspace() and each != "\xa0" else each, style, size, keep_space))


def outlines(letters, deviation, left_out):
    """The outlines of letters as polylines, y down."""
    lines = []
    x = y = 0.0
    for chunk in _chunks(letters):
        x = x if chunk.x is None else chunk.x
        y = y if chunk.y is None else chunk.y
        width = sum(run.dx + _advance(run, left_out) for run in chunk.runs)
        x -= {"middle": width / 2, "end": width}.get(chunk.anchor, 0.0)
        for run in chunk.runs:
            x, y = x + run.dx, y + run.dy
            if run.style.get("visibility", "visible") == "visible":
                lines += _drawn(run, x, y, deviation, left_out)
            x += _advance(run, left_out)
    return lines


def _chunks(letters):
    chunks = []
    for letter in letters:
        if not chunks or letter.x is not None or letter.y is not None:
            chunks.append(_Chunk(letter.x, letter.y, letter.style.get("text-anchor", "start")))
        runs = chunks[-1].runs
        spaced = _spacing(letter.style, letter.size)
        if runs and runs[-1].style is letter.style and not (letter.dx or letter.dy or spaced):
            runs[-1].text += letter.text
        else:
            runs.append(_Run(letter.style, letter.size, letter.text, letter.dx, letter.dy))
    return chunks


def _spacing(style, size):
    return svg_geometry.length(style.get("letter-spacing"), None, size)


def _advance(run, left_out):
    from matplotlib.textpath import text_to_path

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        width, _, _ = text_to_path.get_text_width_height_descent(run.text, _font(run.style, left_out), False)
    return width * run.size / _EM + _spacing(run.style, run.size)


def _drawn(run, x, y, deviation, left_out):
    from matplotlib.path import Path
    from matplotlib.textpath import text_to_path

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        vertices, codes = text_to_path.get_text_path(_font(run.style, left_out), run.text, False)
    missing = sum("missing from" in str(each.message) for each in said)
    if missing:
        left_out[N_("letters that the font has not (boxes are drawn for them)")] += missing
    scale = run.size / _EM
    y += _baseline(run.style.get("dominant-baseline"), run.size)
    lines = []
    for vertex, code in Path(vertices, codes).iter_segments(curves=True, simplify=False) if len(vertices) else ():
        positions = (vertex[0::2] * scale + x) - 1j * (vertex[1::2] * scale - y)
        if code == Path.MOVETO:
            lines.append([positions[0]])
        elif code == Path.CLOSEPOLY:
            lines[-1].append(lines[-1][0])
        elif code == Path.CURVE3:
            lines[-1] += svg_geometry.quadratic(lines[-1][-1], *positions, deviation)
        elif code == Path.CURVE4:
            lines[-1] += svg_geometry.cubic(lines[-1][-1], *positions, deviation)
        else:
            lines[-1].append(positions[0])
    return [numpy.array(line) for line in lines if len(line) > 1]


def _baseline(name, size):
    """How far below its position a line of text stands, by a dominant-baseline; as most fonts are made."""
    shares = {"middle": 0.26, "central": 0.35, "hanging": 0.73, "text-before-edge": 0.9, "text-after-edge": -0.21}
    return shares.get(name, 0.0) * size


def _font(style, left_out):
    families = tuple(
        part.strip().strip("'\"") for part in style.get("font-family", "sans-serif").split(",") if part.strip()
    )
    weight = style.get("font-weight", "normal")
    slant = style.get("font-style", "normal")
    font, replaced = _found(families, weight, slant)
    if replaced:
        left_out[_("the font {}, which is not on this computer ({} is drawn)", families[0], replaced)] = 1
    return font


@lru_cache(maxsize=256)
def _found(families, weight, slant):
    """matplotlib's font of a CSS family list, and the name of what stands for it if none of them is installed."""
    from matplotlib import font_manager

    known = {name.lower(): name for name in font_manager.get_font_names()}
    chosen = next(
        (known.get(name.lower()) or _GENERIC.get(name.lower()) for name in families
         if name.lower() in known or name.lower() in _GENERIC),
        None,
    )  # fmt: skip
    heavy = {"bold": 700, "bolder": 700, "lighter": 300}.get(weight, int(weight) if weight.isdigit() else 400)
    font = font_manager.FontProperties(
        family=[chosen or "sans-serif"], style=slant if slant in ("italic", "oblique") else "normal", weight=heavy, size=_EM
    )
    logger = logging.getLogger("matplotlib.font_manager")
    before = logger.level
    logger.setLevel(logging.ERROR)
    try:
        name = font_manager.get_font(font_manager.findfont(font)).family_name
    finally:
        logger.setLevel(before)
    return font, None if chosen else name
