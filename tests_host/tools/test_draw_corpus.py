"""Each drawing below PASSO_CORPUS beside hp2xx, rsvg-convert, Chromium and ezdxf: where they differ, `passo draw` says so, or a reason is known.

    PASSO_CORPUS=~/drawings .venv/bin/python -m pytest tests_host/tools/test_draw_corpus.py

The end of the run prints a row for each file and program: how much of theirs lies on ours, of ours on theirs, and the word for a difference.
"""

import math
import re
import shutil
from pathlib import Path

import numpy
import pytest
from shapely import STRtree, points
from test_draw_beside import edges, screenshots
from test_draw_oracles import SCALE as RSVG_SCALE
from test_draw_oracles import agreement, hp2xx_lines, rsvg_page, samples
from test_dxf_beside import drawn_by_ezdxf

from host_tools.drawings import sources, svg_area
from host_tools.drawings.placement import box_of
from host_tools.drawings.svg_file import SvgFile
from host_tools.failure import Failure

pytestmark = pytest.mark.slow

SHARE, NEAR_PX, CHROMIUM_SCALE = 0.98, 1.7, 3
LIGHTEST = 235  # of 255: what is darker is ink
MOST_PX = 3000  # a side of a page that is looked at
MOST_PIXELS = 40_000
TOGETHER, COLUMNS = 12, 4  # files on one page of the browser
_STYLED = re.compile(r"[\"';{\s](rotate|scale|translate|transform|transform-box|transform-origin|r|cx|cy|rx|ry|x|y|width|height|d)\s*:")
_NESTED_USE = re.compile(r"<use[^>]*\swidth\s*=")
NO_FONT = "a text names no font, and each program takes its own"


def places_of(ink, scale):
    """Places of dark pixels in px, of a large dark area only some."""
    rows, columns = numpy.nonzero(ink)
    step = math.isqrt(len(rows) // MOST_PIXELS) + 1
    some = (rows % step == 0) & (columns % step == 0)
    return numpy.column_stack((columns[some] + 0.5, rows[some] + 0.5)) / scale


def compare_ink(grey, scale, lines):
    """(how much of the ink's edges lies on our lines, how much of our lines on ink). An edge lies half a stroke beside its line, as far as edges
    are from our lines that lie on ink."""
    ink = grey < LIGHTEST
    edge, ours = edges(ink, scale), samples(lines)
    if not len(edge) or not len(ours):
        return (float(len(edge) == len(ours)),) * 2
    half = STRtree(points(edge)).query_nearest(points(ours), return_distance=True, all_matches=False)[1]
    return agreement(edge, lines, NEAR_PX + 1.5 * float(numpy.quantile(half, 0.9)))[0], agreement(places_of(ink, scale), lines, NEAR_PX)[1]


def rsvg_reason(text):
    """What librsvg 2.54 draws otherwise than browsers, "" for nothing."""
    if _STYLED.search(text) or "transform-origin" in text:
        return "librsvg knows no transform-origin, and no transform or geometry of a style sheet"
    if _NESTED_USE.search(text) and not re.search("<symbol", text):
        return "librsvg gives the size of a <use> to no inner <svg>"
    return NO_FONT if "<text" in text and "font-family" not in text else ""


def chromium_reason(text):
    if re.search(r"\sr[xy]\s*=\s*.auto", text):
        return "Chromium takes no radius auto of an attribute; Firefox and librsvg do"
    return NO_FONT if "<text" in text and "font-family" not in text else ""


def svg_rows(paths, folder):
    """(path, program, how much of theirs lies on ours, of ours on theirs, Page, a known reason of a difference), or (path, Failure)."""
    pages = {}
    for path in paths:
        try:
            page = SvgFile(path).outlines(0.02)
        except Failure as failure:
            yield path, failure
            continue
        if max(page.size_px) <= MOST_PX:
            pages[path] = page
    pages = dict(sorted(pages.items(), key=lambda item: item[1].size_px))
    for first in range(0, len(pages), TOGETHER):
        group = list(pages)[first : first + TOGETHER]
        copies = [Path(shutil.copyfile(path, folder / f"{number}.svg")) for number, path in enumerate(group)]
        side = tuple(math.ceil(max(pages[path].size_px[axis] for path in group)) for axis in (0, 1))
        for path, copy, grey in zip(group, copies, screenshots(folder, copies, side, COLUMNS)):
            page, text = pages[path], path.read_text(errors="replace")
            width, height = page.size_px
            lines = svg_area.clip([line for lines in page.layers.values() for line in lines], svg_area.rectangle(0, 0, width, height))
            grey = grey[: math.ceil(height * CHROMIUM_SCALE), : math.ceil(width * CHROMIUM_SCALE)]
            yield path, "chromium", *compare_ink(grey, CHROMIUM_SCALE, lines), page, chromium_reason(text)
            yield path, "rsvg-convert", *compare_ink(rsvg_page(copy, folder), RSVG_SCALE, lines), page, rsvg_reason(text)


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
    """What ezdxf draws otherwise than a CAD program does, "" for nothing."""
    space = document.modelspace()
    frozen = {layer.dxf.name for layer in document.layers if layer.is_frozen()}
    if any(insert.dxf.layer in frozen for insert in space.query("INSERT")):
        return "ezdxf draws what is in a block on a frozen layer"
    if any(len(set(list(spline.knots)[: spline.dxf.degree + 1])) > 1 for spline in space.query("SPLINE")):
        return "ezdxf draws the whole knot vector of a spline that is not clamped"
    if any(line.dxf.flags & 4 for line in space.query("POLYLINE")):
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
    """What `passo draw` says of a file."""
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
            row, without = row_text(path, *found) if len(found) > 1 else (f"{path.name:32} refused: {found[0]}", False)
            text.append(row)
            wordless += [row] if without else []
    show("drawings beside other programs: file, program, theirs on ours, ours on theirs", "\n".join(text))
    assert text and not wordless
