"""Each drawing below PASSO_CORPUS beside hp2xx, rsvg-convert, Chromium and ezdxf: where they differ, `passo draw` says so, or a reason is known.

    PASSO_CORPUS=~/drawings .venv/bin/python -m pytest tests_host/tools/test_draw_corpus.py

The end of the run prints a row for each file and program: how much of theirs lies on ours, of ours on theirs, and the word for a difference.
"""

import math
import re
import shutil
from contextlib import contextmanager
from pathlib import Path

import numpy
import pytest
from test_draw_beside import edges, screenshots
from test_draw_oracles import SCALE as RSVG_SCALE
from test_draw_oracles import agreement, hp2xx_lines, rsvg_page, samples
from test_dxf_beside import drawn_by_ezdxf

from host_tools.drawings import sources, svg_area, svg_geometry, svg_style
from host_tools.drawings.placement import MM_PER_PX, box_of
from host_tools.drawings.svg_file import SvgFile
from host_tools.drawings.svg_shapes import Shapes, element_length
from host_tools.failure import Failure

pytestmark = pytest.mark.slow

SHARE, NEAR_PX, CHROMIUM_SCALE = 0.98, 1.7, 3
LIGHTEST = 235  # of 255: darker pixels are ink
MOST_PX = 3000  # a side of a page that is looked at
MOST_MM = 30_000  # of lines that are compared
COLUMNS = 4  # of files on one page of the browser
MOST_SHOT = 60_000_000  # pixels of its picture
_STYLED = re.compile(r"[\"';{\s](rotate|scale|translate|transform|transform-box|transform-origin|r|cx|cy|rx|ry|x|y|width|height|d)\s*:")
_NESTED_USE = re.compile(r"<use[^>]*\swidth\s*=")
NO_FONT = "a text names no font, and each program takes its own"


def grow(ink, by):
    """Pixels (a mask) that lie within `by` pixels of dark ones."""
    rows, columns = ink.shape
    reach = math.floor(by)
    grown = numpy.zeros((rows + 2 * reach, columns + 2 * reach), bool)
    for down in range(-reach, reach + 1):
        for right in range(-reach, reach + 1):
            if math.hypot(down, right) <= by:
                grown[reach + down : reach + down + rows, reach + right : reach + right + columns] |= ink
    return grown[reach : reach + rows, reach : reach + columns]


def share_on_ink(lines, ink, scale):
    """How much of our lines lies within NEAR_PX of ink. Looked up in the picture: dense drawings have millions of dark pixels."""
    ours = samples(lines)
    if not len(ours) or not ink.any():
        return float(bool(len(ours)) == bool(ink.any()))
    columns, rows = (numpy.clip(numpy.floor(ours[:, axis] * scale).astype(int), 0, ink.shape[1 - axis] - 1) for axis in (0, 1))
    return float(grow(ink, NEAR_PX * scale)[rows, columns].mean())


@contextmanager
def stroke_widths():
    """A list that gets the width in px of each stroke that is read."""
    found, shape = [], Shapes.shape_inks

    def note(shapes, tag, element, context):
        if svg_style.is_painted(context.style, "stroke"):
            found.append(element_length(context.style.get("stroke-width", "1"), None, context) * svg_geometry.stretch_of(context.matrix))
        return shape(shapes, tag, element, context)

    Shapes.shape_inks = note
    try:
        yield found
    finally:
        Shapes.shape_inks = shape


def compare_ink(grey, scale, lines, width):
    """(how much of the ink's edges lies on our lines, how much of our lines on ink). An edge lies half of the widest stroke beside its line, at
    a corner 1.5 times as far."""
    ink = grey < LIGHTEST
    return agreement(edges(ink, scale), lines, NEAR_PX + 0.75 * width)[0], share_on_ink(lines, ink, scale)


def rsvg_reason(text):
    """The reason why librsvg 2.54 draws a file otherwise than browsers, "" if it does not."""
    if _STYLED.search(text) or "transform-origin" in text:
        return "librsvg knows no transform-origin, and no transform or geometry of a style sheet"
    if _NESTED_USE.search(text) and not re.search("<symbol", text):
        return "librsvg gives the size of a <use> to no inner <svg>"
    return NO_FONT if "<text" in text and "font-family" not in text else ""


def chromium_reason(text):
    if re.search(r"\sr[xy]\s*=\s*.auto", text):
        return "Chromium takes no radius auto of an attribute; Firefox and librsvg do"
    if not re.search(r"<svg[^>]*\swidth\s*=", text):
        return "a page without a size is as large as the browser's window"
    return NO_FONT if "<text" in text and "font-family" not in text else ""


def svg_rows(paths, folder):
    """(path, program, how much of theirs lies on ours, of ours on theirs, Page, a known reason of a difference), or (path, Failure)."""
    pages, widths = {}, {}
    for path in paths:
        try:
            with stroke_widths() as widths[path]:
                page = SvgFile(path).outlines(0.02)
        except Failure as failure:
            yield path, failure
            continue
        long = sum(float(abs(numpy.diff(line)).sum()) for lines in page.layers.values() for line in lines)
        if max(page.size_px) > MOST_PX or long * MM_PER_PX > MOST_MM:
            yield path, Failure("too large to be compared")
        else:
            pages[path] = page
    pages = dict(sorted(pages.items(), key=lambda item: item[1].size_px))
    left = list(pages)
    while left:
        area = CHROMIUM_SCALE**2 * pages[left[-1]].size_px[0] * max(page.size_px[1] for page in pages.values())
        count = max(1, int(MOST_SHOT / max(area, 1)) // COLUMNS * COLUMNS)
        group, left = left[-count:], left[:-count]
        copies = [Path(shutil.copyfile(path, folder / f"{number}.svg")) for number, path in enumerate(group)]
        side = tuple(math.ceil(max(pages[path].size_px[axis] for path in group)) for axis in (0, 1))
        for path, copy, grey in zip(group, copies, screenshots(folder, copies, side, min(COLUMNS, len(group)))):
            page, wide, text = pages[path], max(widths[path], default=0.0), path.read_text(errors="replace")
            width, height = page.size_px
            lines = svg_area.clip_lines([line for lines in page.layers.values() for line in lines], svg_area.rectangle(0, 0, width, height))
            grey = grey[: math.ceil(height * CHROMIUM_SCALE), : math.ceil(width * CHROMIUM_SCALE)]
            yield path, "chromium", *compare_ink(grey, CHROMIUM_SCALE, lines, wide), page, chromium_reason(text)
            yield path, "rsvg-convert", *compare_ink(rsvg_page(copy, folder), RSVG_SCALE, lines, wide), page, rsvg_reason(text)


def one_by_one(rows):
    """The same function for files, of one for a file."""

    def rows_of(paths, folder):
        for path in paths:
            try:
                yield path, *rows(path, folder)
            except Failure as failure:
                yield path, failure

    return rows_of


def hpgl_row(path, _folder):
    page = sources.open_drawing(path).outlines(0.01)
    lines = [line for lines in page.layers.values() for line in lines]
    theirs, ours = agreement(samples(hp2xx_lines(path, box_of([lines]))), lines, 0.5)
    return "hp2xx", theirs, ours, page, "a label has the letters of the plotter, which hp2xx forms otherwise" if b"LB" in path.read_bytes() else ""


def dxf_reason(document):
    """The reason why ezdxf draws a file, or a block of it, otherwise than a CAD program, "" if it does not."""
    frozen = {layer.dxf.name for layer in document.layers if layer.is_frozen()}
    if any(insert.dxf.layer in frozen for insert in document.query("INSERT")):
        return "ezdxf draws what is in a block on a frozen layer"
    if any(len(set(list(spline.knots)[: spline.dxf.degree + 1])) > 1 for spline in document.query("SPLINE")):
        return "ezdxf draws the whole knot vector of a spline that is not clamped"
    if any(line.dxf.flags & 4 for line in document.query("POLYLINE")):
        return "ezdxf draws the frame of a polyline that was fitted to a spline"
    return ""


def dxf_row(path, folder):
    from ezdxf import recover

    page = sources.open_drawing(path).outlines(0.01)
    lines = [line for lines in page.layers.values() for line in lines]
    if not lines:
        return "ezdxf", 0.0, 0.0, page, ""
    left, top, right, bottom = box_of([lines])
    if min(right - left, bottom - top) < 1e-6:
        return "ezdxf", 1.0, 1.0, page, "ezdxf has no page for a drawing without height or width: not compared"
    theirs = drawn_by_ezdxf(path, folder)
    there = box_of([theirs])
    scale = (there[2] - there[0]) / (right - left)
    ours = [(line.real - left) * scale + there[0] + 1j * ((line.imag - top) * scale + there[1]) for line in lines]
    return "ezdxf", *agreement(samples(theirs, 1.0), ours, 1.5), page, dxf_reason(recover.readfile(path)[0])


READERS = {(".svg",): svg_rows, (".dxf",): one_by_one(dxf_row), sources.HPGL: one_by_one(hpgl_row)}


def words_of(page):
    """The remarks of `passo draw` about a file."""
    words = [f"{count} × {name}" if count > 1 else name for name, count in page.left_out.items()]
    return words + ["a shape that nobody sees is left out"] * bool(page.unseen) + ["a white page is left out"] * bool(page.backgrounds)


def row_text(path, program, theirs, ours, page, known):
    """The row of one comparison, and True for a difference without a word."""
    word, same = "; ".join(filter(None, [*words_of(page), known])), min(theirs, ours) > SHARE
    said = "" if same and not known.endswith("not compared") else word or "DIFFERS"
    return f"{path.name:32} {program:13} {theirs:.4f} {ours:.4f}  {said}", not same and not word


def test_each_drawing_lies_on_what_others_draw_or_a_word_says_why_not(corpus, tmp_path, show):
    text, wordless = [], []
    for suffixes, rows in READERS.items():
        for path, *found in rows(sorted(path for path in corpus.rglob("*") if path.suffix.lower() in suffixes), tmp_path):
            row, without = row_text(path, *found) if len(found) > 1 else (f"{path.name:32} not compared: {found[0]}", False)
            text.append(row)
            wordless += [row] if without else []
    show("drawings beside other programs: file, program, theirs on ours, ours on theirs", "\n".join(text))
    assert text and not wordless
