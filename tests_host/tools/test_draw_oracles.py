"""Readers of drawings against programs that are not ours: the ink of rsvg-convert and hp2xx, Debian's, and our lines lie on each other.

Without these programs the tests skip.
"""

import gzip
import os
import random
import re
import shutil
import subprocess
from pathlib import Path

import numpy
import pytest
import shapely
from PIL import Image
from shapely import STRtree
from shapely import points as shapely_points

from host_tools import boards
from host_tools.drawings import hpgl_encoded, sources, svg_area, svg_style
from host_tools.drawings.drawing import load
from host_tools.drawings.hpgl import UNIT_PX
from host_tools.drawings.placement import Options, box_of
from host_tools.drawings.svg_file import SvgFile
from host_tools.failure import Failure

SCALE = 4  # pixels a px
HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="200" height="120" fill="none" stroke="black">'


def rsvg_page(path, tmp_path):
    """The page as rsvg-convert draws it, grey, row by row."""
    if not shutil.which("rsvg-convert"):
        pytest.skip("rsvg-convert is not installed: apt-get install librsvg2-bin")
    out = tmp_path / "oracle.png"
    subprocess.run(["rsvg-convert", "-z", str(SCALE), "-b", "white", "-o", out, path], check=True, env={**os.environ, "LANG": "en_US.UTF-8", "LANGUAGE": "en", "LC_ALL": "en_US.UTF-8", "PATH": "/usr/bin:/bin"})
    return numpy.asarray(Image.open(out).convert("L"))


def svg_page_black(path, tmp_path):
    """Which pixels rsvg-convert has black, row by row."""
    return rsvg_page(path, tmp_path) < 128


def rsvg_ink(path, tmp_path):
    """Places of black pixels, in px."""
    rows, columns = numpy.nonzero(svg_page_black(path, tmp_path))
    return numpy.column_stack((columns + 0.5, rows + 0.5)) / SCALE


def chromium_ink(path, tmp_path):
    """The same by a browser."""
    if not shutil.which("chromium"):
        pytest.skip("chromium is not installed")
    page, out = tmp_path / "oracle.html", tmp_path / "oracle.png"
    page.write_text(f'<html lang="en"><body style="margin:0">{path.read_text()}</body></html>')
    subprocess.run(
        ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--lang=en", f"--force-device-scale-factor={SCALE}",
         "--window-size=400,400", f"--user-data-dir={tmp_path / 'profile'}", f"--screenshot={out}", page.as_uri()], check=True, capture_output=True, timeout=120,
    )  # fmt: skip
    rows, columns = numpy.nonzero(numpy.asarray(Image.open(out).convert("L")) < 128)
    return numpy.column_stack((columns + 0.5, rows + 0.5)) / SCALE


def samples(lines, every=0.25):
    """Places along lines of complex numbers."""
    found = []
    for line in lines:
        along = numpy.concatenate(([0.0], numpy.cumsum(abs(numpy.diff(line)))))
        at = numpy.append(numpy.arange(0.0, along[-1], every), along[-1])
        found.append(numpy.interp(at, along, line.real) + 1j * numpy.interp(at, along, line.imag))
    places = numpy.concatenate(found) if found else numpy.zeros(0, complex)
    return numpy.column_stack((places.real, places.imag))


def agreement(ink, lines, near):
    """(share of the ink that lies within `near` of our lines, share of our lines that lie so near to ink)."""
    ours = samples(lines)
    if not len(ink) or not len(ours):
        return (float(len(ink) == len(ours)),) * 2

    def share(places, of):
        tree = STRtree(shapely_points(of))
        return float((tree.query_nearest(shapely_points(places), return_distance=True, all_matches=False)[1] <= near).mean())

    return share(ink, ours), share(ours, ink)


SVG = {
    "blanks between texts on two paths": '<defs><path id="a" d="M20 60C60 10 140 10 180 60"/><path id="b" d="M20 110C60 60 140 60 180 110"/></defs><text font-family="DejaVu Sans" font-size="14" stroke="none" fill="black">\n'
        '<textPath href="#a"> one path\n <textPath href="#b"> never</textPath></textPath>\n <textPath href="#b"> another </textPath>\n</text>',
    "blanks before a place": '<g font-family="DejaVu Sans" font-size="20" stroke="none" fill="black" text-anchor="middle"><text x="100" y="30"> one <tspan x="100" y="60">two </tspan> <tspan x="100" y="90"> three</tspan> </text></g>',
    "a line as around": '<text x="9" y="50" font-family="DejaVu Sans" font-size="20" stroke="none" fill="black" dominant-baseline="hanging">Ag<tspan dominant-baseline="no-change">Ag</tspan></text>',
    "accents turn with their letters": '<text x="30" y="60" font-family="DejaVu Sans" font-size="30" stroke="none" fill="black" rotate="20">a&#x306;e&#x301;</text>',
    "sizes by name": '<g font-family="DejaVu Sans" stroke="none" fill="black"><text x="9" y="30" font-size="x-large">Ag<tspan font-size="smaller">Ag</tspan></text>'
        '<text x="90" y="30" font-size="xx-small">Ag</text><g font-size="15"><text x="9" y="80" font-size="larger">Ag</text><text x="120" y="80" font-size="-5">Ag</text></g></g>',
    "weights from those around": '<g font-family="DejaVu Sans" font-size="14" stroke="none" fill="black"><g font-weight="bold"><text x="9" y="40" font-weight="lighter">A</text>'
        '<text x="60" y="40" font-weight="bolder">A</text></g><text x="110" y="40" font-weight="bolder">A</text></g>',
    "text on a path of two parts": '<defs><path id="w" d="M20 90l40 -60M100 90l60 -40"/></defs><text font-family="DejaVu Sans" font-size="14" stroke="none" fill="black"><textPath href="#w">in parts of a path</textPath></text>',
    "a text that names no font": '<text x="8" y="60" font-size="20" stroke="none" fill="black">10mm snap</text>',
    "a switch takes the language": '<switch><path systemLanguage="pt,de" d="M10 10h90"/><path systemLanguage="en" d="M10 30h90"/><path d="M10 50h90"/></switch>',
    "a switch without a language that suits": '<switch><path systemLanguage="fi" d="M10 10h90"/><path d="M10 50h90"/></switch>',
    "a switch passes over extensions": '<switch><path requiredExtensions="http://x" d="M10 10h90"/><path d="M10 50h90"/></switch>',
    "important hides": '<style>.a{display:none!important}</style><path class="a" style="display:inline" d="M10 10h90"/><path d="M10 30h90"/>',
    "descendants": '<style>.a .b{display:none} g>line{stroke-dasharray:10 5}</style><g class="a"><path class="b" d="M10 10h90"/><line x1="10" y1="40" x2="150" y2="40"/></g><path class="b" d="M10 20h90"/>',
    "siblings and positions": '<style>path+path{display:none} rect:nth-child(odd){transform:translate(20px,0)}</style><g><rect x="5" y="5" width="30" height="30"/><rect x="5" y="50" width="30" height="30"/></g><g><path d="M100 10h50"/><path d="M100 30h50"/></g>',
    "specificity": '<style>#p{display:inline} path.a{display:none} path{display:none}</style><path id="p" class="a" d="M10 10h90"/><path class="a" d="M10 30h90"/><rect x="10" y="50" width="20" height="20"/>',
    "css transform": '<style>.t{transform:translate(30px,20px) rotate(30deg) scale(2,.5)}</style><path class="t" d="M0 0h40v40"/><path transform="translate(3,4)" style="transform:translate(90px,10px)" d="M0 0h40v40"/>',
    "css transform about an origin": '<rect style="transform:rotate(45deg);transform-origin:100px 60px" x="80" y="50" width="40" height="20"/>',
    "groups that are invisible": '<g opacity="0"><path d="M10 10h90"/></g><g style="opacity:0%"><path d="M10 30h90"/></g><g opacity="1"><path d="M10 50h90"/></g>',
    "text on a curve": '<defs><path id="w" d="M20 90C60 10 140 10 180 90"/></defs><text font-family="DejaVu Sans" font-size="14" stroke="none" fill="black"><textPath xlink:href="#w">along a path</textPath></text>',
    "text on a line in the middle": '<defs><path id="w" d="M20 90L180 40"/></defs><text font-family="DejaVu Sans" font-size="16" stroke="none" fill="black" text-anchor="middle"><textPath href="#w" startOffset="50%">middle</textPath></text>',
    "long text": '<g font-family="DejaVu Sans" font-size="20" stroke="none" fill="black"><text x="10" y="30" textLength="120">ABCD</text><text x="100" text-anchor="middle" y="90" textLength="50" lengthAdjust="spacingAndGlyphs">ABCD</text></g>',
    "words apart, capitals": '<text x="10" y="50" font-family="DejaVu Sans" font-size="20" stroke="none" fill="black" style="word-spacing:8px;letter-spacing:1px;text-transform:uppercase">a b c</text>',
    "raised letters": '<text x="10" y="50" font-family="DejaVu Sans" font-size="20" stroke="none" fill="black">x<tspan style="baseline-shift:sub">3</tspan>z<tspan baseline-shift="super">2</tspan><tspan baseline-shift="4">3</tspan></text>',
    "a first dx moves all letters": '<g font-family="DejaVu Sans" font-size="20" stroke="none" fill="black" text-anchor="middle"><text x="90" y="50" dx="30">ABC</text><text x="150" y="100" dx="-40 5 5" text-anchor="end">ABC</text></g>',
    "lines of text hang, stand and are centred": '<g font-family="DejaVu Sans" font-size="20" stroke="none" fill="black"><text x="9" y="30" dominant-baseline="central">AgT<tspan dx="4">x</tspan></text>'
        '<text x="80" y="30" dominant-baseline="middle">AgT</text><text x="140" y="30" dominant-baseline="hanging">AgT</text><g dominant-baseline="text-before-edge"><text x="9" y="60">AgT</text></g>'
        '<text x="80" y="90" dominant-baseline="text-after-edge">AgT</text><text x="140" y="80" dominant-baseline="mathematical">AgT</text></g>',
    "letters moved one by one keep close": '<text x="10" y="50" dx="0 1 1 1 1" font-family="DejaVu Sans" font-size="30" stroke="none" fill="black">AVATo</text>',
    "a font of no weight": '<text x="10" y="50" font-weight="1500" font-family="DejaVu Sans" font-size="30" stroke="none" fill="black">bold</text>',
    "a radius that is missing or negative is the other": '<ellipse cx="40" cy="40" rx="30"/><ellipse cx="120" cy="40" rx="-1" ry="20"/><rect x="20" y="75" width="60" height="40" rx="-5" ry="15"/>',
    "turned letters": '<text x="20" y="60" rotate="0 30 -30 90" font-family="DejaVu Sans" font-size="20" stroke="none" fill="black">turned</text>',
}


@pytest.mark.parametrize("shape, ends", [
    ('path fill="black" d="M10 10v20h50v-20"', True), ('polyline fill="black" points="10,10 10,30 60,30 60,10"', True),
    ('path stroke="black" fill="black" d="M10 10v20h50v-20"', False), ('path stroke="black" fill="none" d="M10 10v20h50v-20"', False),
    ('path fill="black" d="M10 10v20h50v-20M70 10v20"', True),
])
def test_the_edge_of_an_area_is_closed(tmp_path, shape, ends):
    """As found in 16 of 120 icons of @mdi/svg: rsvg-convert fills up to the edge that no one has written."""
    path = tmp_path / "a.svg"
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" width="200" height="120"><{shape}/></svg>')
    page = SvgFile(path).outlines(0.02)
    first, *others = [line for lines in page.layers.values() for line in lines]
    assert (first[0] == first[-1]) == ends and all(len(line) == 2 for line in others)
    if ends and not others:
        ink = rsvg_ink(path, tmp_path)
        assert abs(numpy.array(box_of([[first]])) - [*(ink.min(0)), *(ink.max(0))]).max() < 0.5


# Constructs that rsvg-convert 2.54 does not draw.
BROWSER = ("blanks between texts on two paths", "blanks before a place", "a line as around", "accents turn with their letters",
           "sizes by name", "weights from those around", "text on a path of two parts", "css transform", "css transform about an origin", "text on a curve", "text on a line in the middle", "turned letters", "long text", "words apart, capitals",
           "a first dx moves all letters", "lines of text hang, stand and are centred", "letters moved one by one keep close", "a font of no weight",
           "a radius that is missing or negative is the other")  # fmt: skip


@pytest.mark.parametrize("name", SVG)
def test_svg_as_others_have_it(tmp_path, name):
    path = tmp_path / "a.svg"
    path.write_text(f"{HEAD}{SVG[name]}</svg>")
    ink = (chromium_ink if name in BROWSER else rsvg_ink)(path, tmp_path)
    page = SvgFile(path).outlines(0.02)
    lines = [line for lines in page.layers.values() for line in lines]
    thick = name in BROWSER or "<text" in SVG[name]  # letters are filled, strokes stretched
    on_ours, on_theirs = agreement(ink, lines, 1.6 if thick else 0.9)
    assert on_ours > 0.99 and on_theirs > 0.99, (on_ours, on_theirs)
    assert not page.left_out


def test_a_font_that_is_not_installed_is_the_one_that_fontconfig_takes(tmp_path, monkeypatch):
    """librsvg and browsers ask it too."""
    if not shutil.which("fc-match"):
        pytest.skip("fontconfig is not installed: apt-get install fontconfig")
    (tmp_path / "fonts.conf").write_text(
        '<?xml version="1.0"?><!DOCTYPE fontconfig SYSTEM "fonts.dtd"><fontconfig><include>' + os.environ["FONTCONFIG_FILE"] + '</include><match target="pattern"><test name="family">'
        '<string>Elsewhere Sans</string></test><edit name="family" mode="prepend" binding="strong"><string>DejaVu Sans Mono</string></edit></match></fontconfig>'
    )
    monkeypatch.setenv("FONTCONFIG_FILE", str(tmp_path / "fonts.conf"))
    path = tmp_path / "a.svg"
    path.write_text(f'{HEAD}<text x="8" y="60" font-size="30" stroke="none" fill="black" font-family="Elsewhere Sans">10mm nap</text></svg>')
    page = SvgFile(path).outlines(0.02)
    assert list(page.left_out) == ["the font Elsewhere Sans, which is not on this computer (DejaVu Sans Mono is drawn)"]
    assert min(agreement(rsvg_ink(path, tmp_path), page.layers[1], 1.9)) > 0.99


def named(tmp_path, text, **options):
    """(page of an SVG file of these elements, all its lines)."""
    path = tmp_path / "a.svg"
    path.write_text(f"{HEAD}{text}</svg>")
    page = SvgFile(path).outlines(0.02, **options)
    return page, [line for lines in page.layers.values() for line in lines]


def test_letters_that_a_font_has_not_come_from_another_or_are_named(tmp_path, monkeypatch):
    """DejaVu Sans Mono has no U+05D0, DejaVu Sans has; without fontconfig nothing stands in for U+5201."""
    if shutil.which("fc-match"):
        text = '<text x="9" y="90" font-size="80" font-family="{}">&#x5d0;</text>'
        (page, other), (_, same) = (named(tmp_path, text.format(font)) for font in ("DejaVu Sans Mono", "DejaVu Sans"))
        assert len(other) == len(same) and all(numpy.allclose(a, b) for a, b in zip(other, same)) and other
        assert list(page.left_out) == ["text from right to left (drawn from left to right)"]
    monkeypatch.setenv("PATH", "")
    page, _ = named(tmp_path, '<text x="9" y="90" font-size="40" font-family="DejaVu Sans Mono">a&#x5201;&#x5201;</text>')
    assert page.left_out == {"letters that the font has not (boxes are drawn for them)": 2}


@pytest.mark.parametrize("text, name", [
    ('<linearGradient id="g"><stop stop-color="red"/><stop offset="1"/></linearGradient><path fill="url(#g)" d="M9 9h50v50"/>', "gradient"),
    ('<radialGradient id="g"><stop stop-color="red"/><stop offset="1"/></radialGradient><path stroke="url(#g)" d="M9 9h50v50"/>', "gradient"),
    ('<defs><path id="p" fill="context-stroke" d="M9 9h50v50"/></defs><use href="#p" fill="red"/>', "paint of a <use>"),
    ('<text y="50" font-size="20" style="font-variation-settings:\'wght\' 100">a</text>', "letters varied"),
    ('<text y="50" font-size="20" font-stretch="condensed">a</text>', "letters varied"),
    ('<text y="50" font-size="20" letter-spacing="5%">a</text>', "space between letters"),
    ('<text id="t" y="50" font-size="20">a</text><text y="90"><tref href="#t"/>b</text>', "text of another place"),
    ('<path id="w" d="M0 50h90"/><text><textPath href="#w">a</textPath>b</text>', "text behind text"),
    ('<path id="w" d="M0 50h90"/><text x="9"><textPath href="#w">a</textPath></text>', "places of letters"),
    ('<path id="w" d="M0 50h90"/><text dy="9"><textPath href="#w">a</textPath></text>', "places of letters"),
    ('<path id="w" d="M0 50h90"/><text><textPath href="#w">a<tspan x="9">b</tspan></textPath></text>', "places of letters"),
    ('<path id="w" d="M0 50h90"/><text><textPath href="#w" path="M0 0h9">a</textPath></text>', "path that a <textPath>"),
    ('<rect x="1rem" y="9" width="9" height="9"/>', "length in rem"),
    ('<text y="50" dominant-baseline="hanging">a<tspan alignment-baseline="alphabetic">b</tspan></text>', "text moved by"),
    ('<clipPath id="c"><path d="M0 0h40v40h-40z"/></clipPath><path clip-path="url(#c)" fill="red" d="M9 9h50v50z"/>', "new edge of an area"),
])  # fmt: skip
def test_what_is_drawn_in_part_is_named(tmp_path, text, name):
    page, lines = named(tmp_path, text)
    (only,) = page.left_out
    assert only.startswith(name) and page.left_out[only] == 1 and lines


def test_an_area_whose_stroke_its_clip_path_takes_away_keeps_its_edge(tmp_path):
    """An edge that vanishes without a note would be a loss."""
    text = '<clipPath id="c"><rect x="60" y="30" width="60" height="60"/></clipPath><g clip-path="url(#c)"><rect x="9" y="9" width="180" height="100" fill="black"/></g>'
    page, (line,) = named(tmp_path, text)
    assert box_of([[line]]) == pytest.approx((60, 30, 120, 90), abs=0.05) and line[0] == line[-1] and not page.left_out
    assert agreement(rsvg_ink(tmp_path / "a.svg", tmp_path), samples([line]), 43)[1] == 1.0
    _, lines = named(tmp_path, text.replace('fill="black"', 'fill="none"'))
    assert not lines, "a stroke alone has no edge"


@pytest.mark.parametrize("around, bolder, lighter", [(1, 400, 1), (100, 400, 100), (300, 400, 100), (400, 700, 100), (600, 900, 400), (800, 900, 700), (950, 950, 700)])
def test_weights_go_by_the_table_of_css(around, bolder, lighter):
    assert (svg_style.font_weight("bolder", around), svg_style.font_weight("lighter", around)) == (bolder, lighter)


SMOOTH = {  # S goes on from C and S only, T from Q and T only: the last is what svgelements does otherwise
    "S behind T": '<path d="M30 10T40 100S170 100 170 30"/>', "S behind Q": '<path d="M30 10Q40 20 40 60s60 50 90 20"/>',
    "T behind C": '<path d="M30 30C40 20 40 40 60 60T160 30"/>', "T behind S": '<path d="M30 30S40 40 60 60t80 -30 t20 20"/>',
    "S behind C": '<path d="M30 30C40 20 40 40 60 60S160 100 160 30"/>', "T behind Q": '<path d="M30 60Q40 40 60 60T100 60 140 90"/>',
}


@pytest.mark.parametrize("name", SMOOTH)
def test_curves_go_on_as_others_have_them(tmp_path, name):
    page, lines = named(tmp_path, SMOOTH[name])
    assert min(agreement(rsvg_ink(tmp_path / "a.svg", tmp_path), lines, 0.9)) == 1.0


CLIPS = {  # as in resvg's tests masking/clipPath: the part of an area within its clip has an edge all around
    "an area larger than its clip path": '<clipPath id="c"><path d="M60 10 100 110 10 40h110L30 110z"/></clipPath><rect width="200" height="120" stroke="none" fill="black" clip-path="url(#c)"/>',
    "an area that its clip path cuts": '<clipPath id="c"><circle cx="60" cy="60" r="40"/></clipPath><path d="M20 20h100v60h-100zM50 40v20h20v-20z" fill-rule="evenodd" stroke="none" fill="black" clip-path="url(#c)"/>',
    "a clip path in a clip path": '<clipPath id="b"><rect x="30" y="30" width="60" height="60"/></clipPath><clipPath id="c"><circle cx="60" cy="60" r="40"/></clipPath><g clip-path="url(#b)"><g clip-path="url(#c)"><rect width="200" height="120" stroke="none" fill="black"/></g></g>',
    "a rule from around": '<g clip-rule="evenodd"><clipPath id="c"><path d="M100 5l40 110l-100 -70l125 0l-100 70z"/></clipPath></g><rect width="200" height="120" stroke="none" fill="black" clip-path="url(#c)"/>',
    "letters": '<clipPath id="c"><rect x="30" y="40" width="60" height="14"/></clipPath><text x="10" y="60" font-family="DejaVu Sans" font-size="40" stroke="none" fill="black" clip-path="url(#c)">MOM</text>',
    "a stroke": '<clipPath id="c"><circle cx="60" cy="60" r="40"/></clipPath><path d="M0 50h200M60 0v99" clip-path="url(#c)"/>',
}


@pytest.mark.parametrize("name", CLIPS)
def test_what_a_clip_path_leaves(tmp_path, name):
    path = tmp_path / "a.svg"
    path.write_text(f"{HEAD}{CLIPS[name]}</svg>")
    black = svg_page_black(path, tmp_path)
    page = SvgFile(path).outlines(0.02)
    lines = [line for lines in page.layers.values() for line in lines]
    if name == "a stroke":
        assert agreement(rsvg_ink(path, tmp_path), lines, 0.9) == (1.0, 1.0) and len(lines) == 2
        return
    edge = black & ~(numpy.roll(black, 1, 0) & numpy.roll(black, -1, 0) & numpy.roll(black, 1, 1) & numpy.roll(black, -1, 1))
    rows, columns = numpy.nonzero(edge)
    on_ours, on_theirs = agreement(numpy.column_stack((columns + 0.5, rows + 0.5)) / SCALE, lines, 0.7)
    assert on_ours > 0.99 and on_theirs > 0.99 and all(line[0] == line[-1] for line in lines)
    assert not page.left_out


def test_the_root_s_clip_path_cuts_all(tmp_path):
    path = tmp_path / "a.svg"
    head = HEAD.replace("fill=", 'clip-path="url(#c)" fill=')
    path.write_text(f'{head}<clipPath id="c"><rect width="50" height="60"/></clipPath><path d="M0 50h200"/><g><path d="M0 70h9"/></g></svg>')
    page = SvgFile(path).outlines(0.02)
    assert agreement(rsvg_ink(path, tmp_path), page.layers[1], 0.9) == (1.0, 1.0) and not page.layers.get(2)


@pytest.mark.parametrize("paint, shown", [
    ("url(#none)", False), ("url(#none) none", False), ("url(#none) black", True), ("url(#empty)", False), ("url(#leads)", True), ("url(#itself)", False),
    ("url(#shape) black", True), ("url(#pattern)", True),
])  # fmt: skip
def test_paints_that_lead_nowhere(tmp_path, paint, shown):
    """A shape that no paint is left of is left out, and named."""
    path = tmp_path / "a.svg"
    path.write_text(
        f'{HEAD}<linearGradient id="empty"/><linearGradient id="full"><stop/></linearGradient><linearGradient id="leads" xlink:href="#full"/>'
        f'<linearGradient id="itself" xlink:href="#itself"/><pattern id="pattern" width="4" height="4" patternUnits="userSpaceOnUse"><rect width="2" height="4" fill="black"/>'
        f'</pattern><defs><path id="shape"/></defs><rect x="10" y="10" width="99" height="99" stroke="none" fill="{paint}"/></svg>'
    )
    page = SvgFile(path).outlines(0.02)
    assert bool(len(rsvg_ink(path, tmp_path))) == shown == (not page.unseen) == bool(page.layers)
    assert page.left_out == ({"pattern (the edge of its area is drawn)": 1} if "pattern" in paint else {})


@pytest.mark.parametrize("query, held", [
    ("print", False), ("screen", True), ("all", True), ("only screen", True), ("not print", True), ("not screen", False),
    ("print, screen", True), ("(prefers-color-scheme: dark)", False), ("screen and (prefers-color-scheme: light)", True),
])
def test_media(tmp_path, query, held):
    path = tmp_path / "a.svg"
    for head in (f"<style>@media {query} {{ path {{ display: none }} }}</style>", f'<style media="{query}">path {{ display: none }}</style>'):
        path.write_text(f'{HEAD}{head}<path d="M0 0h9"/><rect width="9" height="9"/></svg>')
        page = SvgFile(path).outlines(0.1)
        assert len(page.layers[1]) == 2 - held and not page.left_out


def test_what_a_sheet_has_and_nobody_reads_is_named(tmp_path):
    path = tmp_path / "a.svg"
    path.write_text(f'{HEAD}<style>@import "b.css"; @media (min-width: 9px) {{ path {{ display: none }} }} a{{{{ {{fill:red}} >>> b{{fill:red}}</style><path d="M0 0h9"/></svg>')
    page = SvgFile(path).outlines(0.1)
    assert len(page.layers[1]) == 1 and page.left_out["style rule that cannot be read"] >= 2


# --- HPGL by hp2xx

FRAME = "IN;SP1;PU0,0;PD0,100;PU9000,7000;PD9000,6900;PU;"


def encoded(number, base):
    """A number of PE's."""
    rest, digits = abs(number) * 2 + (number < 0), []
    while rest >= base:
        digits.append(63 + rest % base)
        rest //= base
    return bytes([*digits, rest + (191 if base == 64 else 95)]).decode("latin-1")


def hpgl_program(seed):
    """Instructions at random. Arcs are whole chords long: hp2xx leaves out the rest of a wedge's last chord."""
    chance = random.Random(seed)

    def place():
        return f"{chance.randint(1000, 7000)},{chance.randint(1000, 5000)}"

    def way():
        return f"{chance.randint(-800, 800)},{chance.randint(-800, 800)}"

    def polyline():
        base = chance.choice((64, 32))
        flags = ("<=", "", "", "=", f":{encoded(chance.randint(1, 8), base)}<=")
        ways = [f"{flag}{encoded(chance.randint(800, 3000), base)}{encoded(chance.randint(800, 1500), base)}" for flag in flags]
        return f"PU{place()};PE{'7' if base == 32 else ''}{''.join(ways)};PU;"

    def sweep(most):
        return 10 * chance.randint(1, most // 10) * chance.choice((-1, 1))

    kinds = [
        lambda: f"PU{place()};PD{place()},{place()};", lambda: f"PA;PU{place()};PR;PD{way()},{way()};PA;",
        lambda: f"PU{place()};CI{chance.randint(100, 900)},{chance.choice([5, 10, 45])};",
        lambda: f"PU{place()};PD;AA{place()},{sweep(180)},{chance.choice([5, 10])};", lambda: f"PU{place()};PD;AR{way()},{sweep(360)},5;",
        lambda: f"PU{place()};EA{place()};", lambda: f"PU{place()};ER{way()};",
        lambda: f"PU{place()};EW{chance.randint(100, 900)},{chance.randint(0, 360)},{abs(sweep(300))},10;", lambda: f"SP{chance.randint(1, 8)};",
        lambda: f"PU{place()};PM0;PD{place()},{place()};PU{place()};PM1;PD{place()},{place()};PM2;EP;",
        lambda: f"PU{place()};PD;BZ{place()},{place()},{place()};BR{way()},{way()},{way()};", polyline,
    ]  # fmt: skip
    words = [FRAME]
    if chance.random() < 0.5:
        ends = f"{chance.randint(500, 1500)},{chance.randint(500, 1500)},{chance.randint(6000, 8000)},{chance.randint(5000, 6500)}"
        words.append(f"IP{ends};SC0,8000,0,6000{chance.choice(['', ',0', ',1'])};")
    return "".join(words + [chance.choice(kinds)() for _ in range(chance.randint(3, 12))]) + "PU;SP0;"


def hp2xx_lines(path, box):
    """hp2xx's polylines, in px of our page: their box laid on ours."""
    if not shutil.which("hp2xx"):
        pytest.skip("hp2xx is not installed: apt-get install hp2xx")
    svg = subprocess.run(["hp2xx", "-q", "-m", "svg", "-f", "-", path], capture_output=True, text=True, timeout=60).stdout
    lines = []
    for data in re.findall(r'<path d="([^"]*)"', svg):
        places = [complex(float(x), float(y)) for x, y in re.findall(r"[ML] *([-\d.]+), *([-\d.]+)", data)]
        lines.append(numpy.array(places if len(places) > 1 else places * 2))
    theirs = box_of([lines])
    assert max(box[2] - box[0], box[3] - box[1]) > 1, "a dot of ours would have any drawing laid on it"
    scale = (box[2] - box[0]) / (theirs[2] - theirs[0])
    return [(line.real - theirs[0]) * scale + box[0] + 1j * ((line.imag - theirs[3]) * scale + box[3]) for line in lines]


def hpgl_agreement(path, near=0.5, window=None):
    """`window`: the part that hp2xx draws, in plotter units."""
    file = sources.open_drawing(path)
    page = file.outlines(0.01)
    lines = [line for lines in page.layers.values() for line in lines]
    if window:
        places = file._place_line(numpy.array([complex(*window[:2]), complex(*window[2:])]))
        lines = svg_area.clip_lines(lines, shapely.box(places[0].real, places[1].imag, places[1].real, places[0].imag))
    return agreement(samples(hp2xx_lines(path, box_of([lines]))), lines, near), page


@pytest.mark.parametrize("seed", range(30))
def test_hpgl_as_hp2xx_has_it(tmp_path, seed):
    path = tmp_path / "a.plt"
    path.write_text(hpgl_program(seed), encoding="latin-1")
    (on_ours, on_theirs), page = hpgl_agreement(path)
    assert on_ours > 0.98 and on_theirs > 0.98 and not page.left_out, path.read_bytes()


def test_a_real_hpgl_file_as_hp2xx_has_it(corpus):
    (on_ours, on_theirs), page = hpgl_agreement(corpus / "hpgl-buddy_demo-g.hpgl")
    assert on_ours > 0.999 and on_theirs > 0.999 and not page.left_out and list(page.layers) == [5]


SAMPLES = Path("/usr/share/doc/hp2xx/hp-tests")
# With a label of letters otherwise made; hp2xx does not cut the last one's at the window.
LABELLED = {"286x192.5_lh.hpg.gz": None, "286x192.5_qh.hpg.gz": None, "286x192.5_qh2.hpg.gz": (-10830, 0, 0, 7910)}


@pytest.mark.slow
@pytest.mark.parametrize("name", [
    "286x192.5_lq.hpg.gz", "286x192.5_qq.hpg.gz", "acad.hp.gz", "at.hpg", "bz.hp", "charsize.hp", "ci.hp", "colors.hp", "ew.hpg", "inter.hp.gz", "iw.hp", "la.hp",
    "miter.hp", "mycolors.hp", "win_1.hp.gz", *LABELLED,
])
def test_hp2xx_s_own_samples(tmp_path, name):
    """Those without letters of another font, gaps in lines, fills of a pen's width, and sheets that hp2xx chooses otherwise."""
    if not (SAMPLES / name).exists():
        pytest.skip("hp2xx's samples are not there: apt-get install hp2xx")
    data = (SAMPLES / name).read_bytes()
    path = tmp_path / name.removesuffix(".gz")
    path.write_bytes(gzip.decompress(data) if name.endswith(".gz") else data)
    (on_ours, on_theirs), _ = hpgl_agreement(path, 1.0, LABELLED.get(name))
    least = 0.98 if name in LABELLED else 0.99
    assert on_ours > least and on_theirs > least, (on_ours, on_theirs)


@pytest.mark.parametrize("words", [
    "IW1000,1000,4000,3000;RO90;", "RO90;IW1000,1000,4000,3000;", "IW1000,1000,4000,3000;RO180;", "PS6000,4000;IW;", "PS4000,6000;IW;", "RO90;PS6000,4000;IW;",
])
def test_hpgl_s_window_as_hp2xx_has_it(tmp_path, words):
    """It turns with the numbers, is the sheet if it has none itself, and a sheet's long side is x."""
    path = tmp_path / "a.plt"
    path.write_text(f"IN;SP1;{words}PU500,200;PD5000,7000;PD3500,500;PD-500,2500;PD7000,2600;PU;SP0;")
    (on_ours, on_theirs), page = hpgl_agreement(path)
    assert on_ours == on_theirs == 1.0 and not page.left_out


def test_a_turned_sheet_is_as_large_as_the_file_says(tmp_path):
    path = tmp_path / "a.plt"
    path.write_text("IN;PS8000,4000;RO90;SP1;PU100,100;PD3000,7000;PU;")
    assert sources.open_drawing(path).size_px == pytest.approx((8000 * UNIT_PX, 4000 * UNIT_PX))


def test_hpgl_s_later_sheets_are_named(tmp_path):
    path = tmp_path / "a.plt"
    path.write_text("PG;IN;SP1;PU0,0;PD400,0;PG;PU0,0;PD0,400;PG;PG;PU0,0;PD9,9;PG;")
    page = sources.open_drawing(path).outlines(0.01)
    assert len(page.layers[1]) == 1 and page.left_out == {"sheet behind the first": 2}


@pytest.mark.parametrize("words", ["DI0,1;", "LO1;", "DI1,1;", "DR1,1;"])
def test_hpgl_labels_stand_where_hp2xx_has_them(tmp_path, words):
    """Letters are others; cells and directions are the same."""
    path = tmp_path / "a.plt"
    path.write_text(f"{FRAME}IP0,0,9000,7000;SI0.5,0.7;{words}PU3000,3000;LBHEH\x03;PD;PU;SP0;")
    page = sources.open_drawing(path).outlines(0.01)
    ours = [line for lines in page.layers.values() for line in lines]
    theirs = hp2xx_lines(path, box_of([ours]))
    letters = [[line for line in lines if 200 < line.real.mean() < 700] for lines in (ours, theirs)]
    assert numpy.abs(numpy.subtract(*(box_of([each]) for each in letters))).max() < 60 * UNIT_PX


def test_hpgl_labels_go_on_where_the_last_one_ended(tmp_path):
    """A carriage return goes back to where labels began since the pen was moved or turned, a line feed down only; as hp2xx's samples do."""

    def begins(text):
        path = tmp_path / "a.plt"
        path.write_text(f"IN;SI0.4,0.5;PU3000,3000;{text}")  # a cell is 240 by 400 units
        lines = sources.open_drawing(path).outlines(0.01).layers[1]
        left, low = box_of([lines])[0], box_of([lines])[3]
        return sorted({(round((line.real.min() - left) / UNIT_PX / 240), round((low - line.imag.max()) / UNIT_PX / 400)) for line in lines})

    assert begins("LBI\x03LBI\x03") == [(0, 0), (1, 0)]
    assert begins("LBI\r\nI\x03LBI\x03") == [(0, 0), (0, 1), (1, 0)]
    assert begins("LBI\nI\x03") == [(0, 1), (1, 0)]
    assert begins("LBI\r\x03LBII\x03") == [(0, 0), (1, 0)]
    assert begins("LBII\x03PR0,-400;LBI\r\x03LBI\x03") == [(0, 1), (1, 1), (2, 0)]
    assert begins("BLII\x03PR0,-400;PB;") == begins("PR0,-400;LBII\x03") == [(0, 0), (1, 0)]
    assert begins("LBII\x03CP;LBI\x03") == [(0, 0), (0, 1), (1, 1)]
    assert begins("LBII\x03CP1,-1;LBI\r\x03LBI\x03") == [(0, 0), (0, 1), (1, 1), (3, 0)]
    star = "".join(f"DI{way};LB  I\r\x03" for way in ("1,0", "0,1", "-1,0", "0,-1"))
    path = tmp_path / "b.plt"
    path.write_text(f"IN;SI0.4,0.5;PU3000,3000;{star}")
    box = box_of([sources.open_drawing(path).outlines(0.01).layers[1]])
    assert abs((box[2] - box[0]) - (box[3] - box[1])) < 1 < 500 * UNIT_PX < box[2] - box[0], "four ways from one place"


def test_hpgl_s_symbols_stand_on_the_places(tmp_path):
    path = tmp_path / "a.plt"
    path.write_text("IN;SI0.4,0.5;PU0,0;PD3000,0;SMX;PU1000,2000;PD2000,2000;SM;PU;PA2500,1000;")
    lines = [line / UNIT_PX for line in sources.open_drawing(path).outlines(0.01).layers[1]]
    left, bottom = min(line.real.min() for line in lines), max(line.imag.max() for line in lines)
    strokes = [line for line in lines if line.imag.min() != line.imag.max()]
    middles = sorted({(round((line[0].real + line[-1].real) / 2 - left), round(bottom - (line[0].imag + line[-1].imag) / 2)) for line in strokes})
    assert len(lines) == 2 + len(strokes) and middles == [(1000, 2000), (2000, 2000)]


def hpgl_words(tmp_path, words):
    """(ours, hp2xx's) lines of instructions, but for the frame's."""
    path = tmp_path / "a.plt"
    path.write_text(f"{FRAME}IP0,0,9000,7000;SI0.5,0.7;{words}PU;SP0;")
    page = sources.open_drawing(path).outlines(0.01)
    assert not page.left_out
    ours = [line for lines in page.layers.values() for line in lines]
    return [[line / UNIT_PX for line in lines if 10 < line.real.mean() < 840] for lines in (ours, hp2xx_lines(path, box_of([ours])))]


@pytest.mark.parametrize("words", ["SMo;", "SM.;", "SM*;", "SMH;", "SL0.5;SMH;", "SL0.5;DI1,1;SMH;", "SR4,6;SMX;"])
def test_hpgl_s_symbols_are_where_hp2xx_has_them(tmp_path, words):
    """Letters are others; their middles are the same, and of X and H the sizes."""
    boxes = [numpy.array(box_of([lines])) for lines in hpgl_words(tmp_path, f"{words}PU3000,3000;SM;")]
    middles, sizes = ([sign * each[:2] + each[2:] for each in boxes] for sign in (1, -1))
    assert numpy.abs(middles[0] - middles[1]).max() / 2 < 25
    if words[-2] in "XH":
        assert numpy.abs(sizes[0] - sizes[1]).max() < 60


@pytest.mark.parametrize("words, end", [("DT#,0;", "#"), ("DT#,1;", "#"), ("DT#;", "#"), ("DT#,0;DT;", "\x03"), ("DT#,0;DT*;", "*"), ("DT*,0;", "*")])
def test_hpgl_labels_end_as_hp2xx_ends_them(tmp_path, words, end):
    """DT's second number: the terminator is drawn, too."""
    found = [
        {round((line.real.min() + line.real.max() - 2250) / 600) for line in lines}
        for lines in hpgl_words(tmp_path, f"{words}PU1000,3000;LBIX{end}LBIX{end}")
    ]
    assert found[0] == found[1] == set(range(6 if words.endswith(",0;") else 4)), found


def test_a_backspace_in_a_label_writes_over_the_letter_before(tmp_path):
    """As a spectrum analyser of HP does, to strike out its zeros."""
    found = [
        sorted(round((line.real.min() + line.real.max() - 2250) / 600) for line in lines)
        for lines in hpgl_words(tmp_path, "DT#;PU1000,1000;LBIII\x08I#LBI#")
    ]
    assert set(found[0]) == set(found[1]) == {0, 1, 2, 3}, found


MEASURES = {"minus": "\u2212", "degree": "\u00b0", "plus or minus": "\u00b1", "micro": "\u00b5"}


@pytest.mark.parametrize("name", MEASURES)
@pytest.mark.parametrize("words, codec", [("SD1,277;", "hp-roman8"), ("", "hp-roman8"), ("SD1,14;", "latin-1"), ("AD1,341;SA;", "cp437"), ("SD1,14;AD1,277;SA;SS;", "latin-1"), ("", "utf-8")])
def test_hpgl_labels_have_the_signs_of_measures(tmp_path, name, words, codec):
    """gnuplot's pcl5 writes its minus as byte 246 of Roman-8; of a file that names no set it was taken for a letter of Latin-1."""
    sign = {"hp-roman8": "\u2014", "latin-1": "\u00ad", "cp437": "-", "utf-8": "\u2212"}[codec] if name == "minus" else MEASURES[name]
    path = tmp_path / "a.plt"
    path.write_bytes(b"IN;SP1;%sSI0.5,0.7;PU1000,1000;LBI%sI\3PU;" % (words.encode(), sign.encode(codec)))
    page = sources.open_drawing(path).outlines(0.01)
    lines = page.layers[1]
    path.write_bytes(b"IN;SP1;SI0.5,0.7;PU1000,1000;LBI I\3PU;")
    without = sources.open_drawing(path).outlines(0.01).layers[1]
    (left, _, right, _), inner = box_of([without]), lines[1:-1]
    assert not page.left_out and len(without) == 2 and len(inner) == {"minus": 1, "degree": 1, "plus or minus": 3, "micro": 3}[name]
    assert left < box_of([inner])[0] and box_of([inner])[2] < right, "between its neighbours"


def test_hpgl_that_is_too_much_is_refused_or_named(tmp_path):
    """A label of 120 000 letters is named; arcs that ask for 20 million chords are refused in a second or two."""
    path = tmp_path / "a.plt"
    path.write_text("IN;SP1;PU0,0;PD400,0;LB" + "Passo " * 20_000 + "\3PU;")
    page = sources.open_drawing(path).outlines(0.05)
    assert page.left_out == {"text of more than 10000 letters": 1} and len(page.layers[1]) == 1
    path.write_text("IN;SP1;PU0,0;" + "CI5000,0.36;" * 20_000)
    with pytest.raises(Failure, match="a.plt: its arcs have more than 1000000 chords"):
        sources.open_drawing(path)


def test_the_page_of_an_hpgl_file_holds_all_that_is_drawn(tmp_path):
    path = tmp_path / "a.plt"
    path.write_text("IN;SP1;PU300,200;CI200;PU900,400;CI333;PU0,500;PD900,400,700,30;PU;")
    for deviation in (0.5, 0.01, 0.0005):
        page = sources.open_drawing(path).outlines(deviation)
        box = box_of(page.layers.values())
        assert min(box[:2]) >= -1e-9 and box[2] <= page.size_px[0] + 1e-9 and box[3] <= page.size_px[1] + 1e-9
    for board in ("plotter_2014", "router_3axis"):
        load(path, boards.load(board), Options(crop=False))


def test_an_hpgl_comment_without_quotes_ends_at_its_semicolon(tmp_path):
    for comment in ("CO circles; of these;", 'CO "circles; of these";'):
        path = tmp_path / "a.plt"
        path.write_text(f"{comment}PU500,500;CI100;")
        assert len(sources.open_drawing(path).outlines(0.01).layers[1]) == 1


@pytest.mark.parametrize("text", ["PU0,0;PD400,0;", "\x1b.(;IN;PU0,0\nPD400,0", "in;pu0 0;pd400 0;", "IN;PUPA0,0;PDPA400,0;PU", "IN;PA;PU0,0;PR;PD400,0;", "\x03INCA2PAPU0,0PD400,0"])
def test_hpgl_as_people_write_it(tmp_path, text):
    path = tmp_path / "a.plt"
    path.write_text(text)
    page = sources.open_drawing(path).outlines(0.01)
    assert [[round(place.real / UNIT_PX) for place in line] for line in page.layers[1]] == [[0, 400]]


def test_three_points_make_their_circle(tmp_path):
    path = tmp_path / "a.plt"
    path.write_text("IN;PU1000,1000;PD;AT2000,2000,3000,1000;")
    (line,) = sources.open_drawing(path).outlines(0.01).layers[1]
    assert abs(abs(line / UNIT_PX - (2000 + 1j * (2000 - 1000))) - 1000).max() < 1 and len(line) > 100


def test_what_hpgl_has_and_no_pen_draws_is_named(tmp_path):
    path = tmp_path / "a.plt"
    path.write_text("IN;LT2;QQ5;PU0,0;PD99,1e30;PD400,0;LB\u00e3\x03;SC0,0,1,1;", encoding="latin-1")
    page = sources.open_drawing(path).outlines(0.01)
    assert sum(page.left_out.values()) == 5, page.left_out


@pytest.mark.parametrize("text, found", [
    ("\x40\x00", []), ("", []), ("C", []), ("?" * 99, []), ("<=", []), ("\u00bf\u00bf", [(True, False, 0.0, 0.0)]), (":\u00c1", [1]),
    ("=<\u00c1\u00c2\u00c1\u00c2", [(False, True, 1.0, -1.0), (True, False, 1.0, -1.0)]), (">\u00c3\u00c1\u00c1", [(True, False, 0.25, 0.25)]),
    ("7``", [(True, False, -0.0, -0.0)]), ("7AaAa", [(True, False, 33.0, 33.0)]),
])  # fmt: skip
def test_hpgl_s_encoded_numbers(text, found):
    assert hpgl_encoded.decode_moves(text) == found


PAGE = '<svg xmlns="http://www.w3.org/2000/svg" width="99mm" height="99mm" stroke="black">{}</svg>'
ITSELF = "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nA\n10\n0\n20\n0\n0\nINSERT\n2\nA\n10\n0\n20\n0\n0\nENDBLK\n0\nENDSEC\n"
ENTITIES = "0\nSECTION\n2\nENTITIES\n{}\n0\nENDSEC\n0\nEOF\n"
LAUGHS = "".join(f"<!ENTITY {chr(98 + n)} '{(chr(38) + chr(97 + n) + ';') * 10}'>" for n in range(12))


@pytest.mark.parametrize("name, text, message", [
    ("a.plt", "\x8c\x00\xff" * 999, "has no instruction of HPGL"), ("a.hpgl", "", "has no instruction of HPGL"),
    ("a.plt", "IN;IP0,0,1,1;SC0,1e-300,0,1e-300;PU0,0;PD1,1;", "too far away"), ("a.plt", "IN;PS1e8,5;PU0,0;PD1,1;", "too far away"),
    ("a.svg", "", "no element found"), ("a.svg", "\x8c\x00\xff" * 999, "not well-formed"), ("a.svg", "<html/>", "it begins with <html>"),
    ("a.svg", PAGE.format('<path d="M1 1L1e300 5"/>'), "too far away"), ("a.svg", PAGE.format('<path d="M1 1L5 5"/><g>'), "mismatched tag"),
    ("a.svg", f"<!DOCTYPE z [<!ENTITY a 'aaaaaaaaaa'>{LAUGHS}]>" + PAGE.format("<text>&m;</text>"), "cannot|can be read"),
    ("a.svg", "<!DOCTYPE z [<!ENTITY x SYSTEM 'file:///etc/passwd'>]>" + PAGE.format('<text y="9">&x;</text>'), "undefined entity"),
    ("a.svg", PAGE.format('<path style="' + "a:(" * 5000 + '" d="M1 1L5 5"/>'), "its numbers cannot be drawn"),
    ("a.svg", PAGE.format("<g>" * 20000 + "</g>" * 20000), "lies in more than 100 others"),
    ("a.dxf", "", "nothing to draw|can be read"), ("a.dxf", "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n0\n10\n1", "is cut off"),
    ("a.dxf", ITSELF + ENTITIES.format("0\nINSERT\n8\n0\n2\nA\n10\n1\n20\n1"), "cannot be drawn|can be read"),
    ("a.dxf", ENTITIES.format("0\nLINE\n8\n0\n10\nnan\n20\n0\n11\n5\n21\ninf"), "nothing can be drawn: number that is none"),
    ("a.gcode", "", "has no line of G-code"), ("a.gcode", "\x00\xff" * 999, "is no text"), ("a.nc", "G1XnanYinf", "error 302"),
])  # fmt: skip
def test_what_is_no_drawing_is_refused(tmp_path, name, text, message):
    """Empty, cut off, binary, endless, and with numbers that are none: a Failure, and no other exception."""
    path = tmp_path / name
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(Failure, match=message):
        load([path], boards.load("plotter_2014"))


def test_a_style_sheet_nested_too_deep_is_named(tmp_path):
    path = tmp_path / "a.svg"
    path.write_text(PAGE.format("<style>" + "a{" * 5000 + '</style><path d="M1 1L50 50"/>'))
    page = sources.open_drawing(path).outlines(0.01)
    assert len(page.layers[1]) == 1 and page.left_out == {"style rule that cannot be read": 1}


# --- DXF: ezdxf's own drawing as SVG, and its entities walked by themselves


def dxf(tmp_path, seed=1, units=4):
    """A file of entities at random, and its points as ezdxf's path module makes them of each entity."""
    import ezdxf
    from ezdxf import path as paths

    chance = random.Random(seed)
    document = ezdxf.new("R2010", setup=True, units=4)
    document.header["$INSUNITS"] = units
    space = document.modelspace()
    for name in ("CUT", "PEN"):
        document.layers.add(name)
    document.layers.add("OFF").off()

    def place(size=100):
        return chance.uniform(0, size), chance.uniform(0, size)

    block = document.blocks.new("B")
    block.add_lwpolyline([(0, 0, 0, 0, 0.7), (9, 0), (9, 5)], close=True)
    block.add_circle((3, 3), 2)
    for _ in range(12):
        layer = {"layer": chance.choice(["CUT", "PEN"])}
        kind = chance.randrange(6)
        if kind == 0:
            space.add_line(place(), place(), dxfattribs=layer)
        elif kind == 1:
            space.add_arc(place(), chance.uniform(1, 20), chance.uniform(0, 360), chance.uniform(0, 360), dxfattribs=layer)
        elif kind == 2:
            space.add_ellipse(place(), (*place(20), 0), chance.uniform(0.1, 1), 0, chance.uniform(1, 6.28), dxfattribs=layer)
        elif kind == 3:
            space.add_spline([place() for _ in range(5)], dxfattribs=layer)
        elif kind == 4:
            space.add_lwpolyline([(*place(), 0, 0, chance.uniform(-1, 1)) for _ in range(4)], close=chance.random() < 0.5, dxfattribs=layer)
        else:
            more = {"rotation": chance.uniform(0, 360), "xscale": chance.choice([1, 2, -1])}
            space.add_blockref("B", place(), dxfattribs={**layer, **more})
    points = []
    waiting = list(space)
    for entity in waiting:
        if entity.dxftype() == "INSERT":
            waiting += entity.virtual_entities()
        else:
            points.append(numpy.array([complex(p.x, p.y) for p in paths.make_path(entity).flattening(0.0005)]))
    space.add_line((0, 0), (500, 500), dxfattribs={"layer": "OFF"})
    path = tmp_path / "a.dxf"
    document.saveas(path)
    return path, points


@pytest.mark.parametrize("seed, units, mm", [(seed, 4, 1.0) for seed in range(8)] + [(9, 1, 25.4), (10, 5, 10.0), (11, 0, 1.0)])
def test_dxf_entities_are_drawn_where_they_are(tmp_path, seed, units, mm):
    path, points = dxf(tmp_path, seed, units)
    page = sources.open_drawing(path).outlines(0.02)
    lines = [line for lines in page.layers.values() for line in lines]
    scale = mm * 96 / 25.4
    theirs = box_of([points])
    assert page.size_px == pytest.approx(((theirs[2] - theirs[0]) * scale, (theirs[3] - theirs[1]) * scale), rel=1e-3)
    wanted = [(line.real - theirs[0]) * scale + 1j * (page.size_px[1] - (line.imag - theirs[1]) * scale) for line in points]
    on_ours, on_theirs = agreement(samples(wanted), lines, 0.3)
    assert on_ours > 0.999 and on_theirs > 0.999
    assert set(page.names.values()) <= {"CUT", "PEN", "0"} and not page.left_out


def test_a_dxf_survey_far_from_its_zero(tmp_path):
    import ezdxf

    document = ezdxf.new("R2010", setup=True, units=6)  # metres
    document.modelspace().add_lwpolyline([(550_000, 7_500_000), (550_000.4, 7_500_000), (550_000.4, 7_500_000.3)])
    path = tmp_path / "a.dxf"
    document.saveas(path)
    page = sources.open_drawing(path).outlines(0.02)
    assert page.size_px == pytest.approx((400 * 96 / 25.4, 300 * 96 / 25.4), rel=1e-4)
    (line,) = page.layers[1]
    assert abs(line - [0 + 300j * 96 / 25.4, (400 + 300j) * 96 / 25.4, 400 * 96 / 25.4]).max() < 0.01


def test_a_dxf_of_a_whole_town_is_drawn_small(tmp_path):
    import ezdxf

    document = ezdxf.new("R2010", setup=True, units=6)
    document.modelspace().add_circle((500_000, 500_000), 10_000)
    path = tmp_path / "a.dxf"
    document.saveas(path)
    plan = load(path, boards.load("plotter_2014"))
    places = numpy.array([place for part in plan.parts for line in part.lines for place in line]) / plan.steps_per_mm
    assert abs(numpy.hypot(*(places - 150).T) - 150).max() < 0.2
    assert any("0.0015 %" in note for note in plan.notes), plan.notes


def test_dxf_blocks_that_were_made_flat(tmp_path):
    """Blocks in blocks, their third scale 0: some programs write them so."""
    import ezdxf

    document = ezdxf.new("R2010", setup=True, units=4)
    document.blocks.new("I").add_circle((0, 0), 2)
    document.blocks.new("O").add_blockref("I", (10, 0), dxfattribs={"zscale": 0, "xscale": 2, "yscale": 2})
    for place in ((0, 0), (30, 0)):
        document.modelspace().add_blockref("O", place, dxfattribs={"zscale": 0})
    path = tmp_path / "a.dxf"
    document.saveas(path)
    lines = sources.open_drawing(path).outlines(0.02).layers[1]
    scale = 96 / 25.4
    assert sorted(round(float(line.real.min() / scale), 1) for line in lines) == [0, 30]
    assert all(line.real.max() - line.real.min() == pytest.approx(8 * scale, rel=0.01) for line in lines)


def test_dxf_hatches_are_areas_and_text_is_outlines(tmp_path):
    import ezdxf

    document = ezdxf.new("R2010", setup=True, units=4)
    space = document.modelspace()
    hatch = space.add_hatch(color=3)
    for size in (0, 5):
        hatch.paths.add_polyline_path([(size, size), (20 - size, size), (20 - size, 20 - size), (size, 20 - size)], is_closed=True)
    space.add_text("Passo", height=8, dxfattribs={"insert": (40, 0)})
    path = tmp_path / "a.dxf"
    document.saveas(path)
    page = sources.open_drawing(path).outlines(0.02, fills=True)
    ((number, areas),) = page.fills.items()
    scale = 96 / 25.4
    assert sum(area.area for area in areas if area.bounds[2] < 21 * scale) == pytest.approx((400 - 100) * scale**2)
    letters = [line for line in page.layers[number] if line.real.min() > 30 * scale]
    assert len(letters) >= 7 and box_of([letters])[3] - box_of([letters])[1] == pytest.approx(8 * scale, rel=0.15)


def test_a_binary_dxf_is_drawn(tmp_path):
    import ezdxf

    document = ezdxf.new("R2000", units=4)
    document.modelspace().add_line((0, 0), (30, 40))
    path = tmp_path / "a.dxf"
    document.saveas(path, fmt="bin")
    page = sources.open_drawing(path).outlines(0.02)
    assert page.size_px == pytest.approx((30 * 96 / 25.4, 40 * 96 / 25.4)) and len(page.layers[1]) == 1


@pytest.mark.parametrize("below", ["line", "hatch"])
def test_a_wipeout_covers_what_was_drawn_before(tmp_path, below):
    """As in ezdxf's wipeout_door.dxf: walls behind a door."""
    import ezdxf

    document = ezdxf.new("R2010", setup=True, units=4)
    space = document.modelspace()
    if below == "line":
        space.add_lwpolyline([(0, 0), (30, 0), (30, 30)])
    else:
        space.add_hatch(color=3).paths.add_polyline_path([(0, 0), (30, 0), (30, 30), (0, 30)], is_closed=True)
    space.add_wipeout([(10, -5), (20, -5), (20, 5), (10, 5)])
    space.add_line((12, 0), (18, 0))
    path = tmp_path / "a.dxf"
    document.saveas(path)
    page = sources.open_drawing(path).outlines(0.02, fills=True)
    scale = 96 / 25.4
    bottom = sorted(
        sorted((round(float(a.real / scale)), round(float(b.real / scale)))) for line in page.layers[1] for a, b in zip(line, line[1:])
        if a.imag == b.imag and a.imag > 29 * scale
    )  # fmt: skip
    assert bottom == [[0, 10], [12, 18], [20, 30]] and not page.left_out
    assert sum(area.area for area in page.fills.get(1, [])) == pytest.approx((900 - 50) * scale**2 if below == "hatch" else 0)


def test_a_picture_of_a_dxf_is_named_and_nothing_is_written_in_its_place(tmp_path):
    import ezdxf

    document = ezdxf.new("R2010", setup=True, units=4)
    document.modelspace().add_image(document.add_image_def("not_here.jpg", (640, 360)), (10, 10), (64, 36))
    document.modelspace().add_line((0, 0), (30, 40))
    path = tmp_path / "a.dxf"
    document.saveas(path)
    page = sources.open_drawing(path).outlines(0.02)
    assert page.left_out == {"picture": 1} and [len(lines) for lines in page.layers.values()] == [5], "a line, and the picture's frame"


def test_dxf_bodies_are_named(tmp_path):
    import ezdxf
    from ezdxf.acis import api
    from ezdxf.render.forms import cube

    document = ezdxf.new("R2000", units=4)
    api.export_dxf(document.modelspace().add_3dsolid(), [api.body_from_mesh(cube())])
    document.modelspace().add_line((0, 0), (30, 40))
    path = tmp_path / "a.dxf"
    document.saveas(path)
    page = sources.open_drawing(path).outlines(0.02)
    assert page.left_out == {"3DSOLID": 1} and len(page.layers[1]) == 1


@pytest.mark.parametrize("text, message", [
    ("0\nSECTION\n2\nENTITIES\n0\nLINE\n", "is cut off"), ("hello", "is not a DXF file that can be read"),
    ("0\nSECTION\n2\nENTITIES\n0\nLINE\n10\n0\n20\n0\n11\n1e30\n21\n1\n0\nENDSEC\n0\nEOF\n", "too far away"),
])
def test_files_that_are_no_dxf(tmp_path, text, message):
    from host_tools import boards
    from host_tools.drawings import drawing
    from host_tools.failure import Failure

    path = tmp_path / "a.dxf"
    path.write_text(text)
    with pytest.raises(Failure, match=message):
        drawing.load(path, boards.load("plotter_2014"))


def test_a_dxf_line_without_a_place_is_left_out_and_named(tmp_path):
    words = [0, "SECTION", 2, "ENTITIES"]
    for x in ("1", "nan"):
        words += [0, "LINE", 8, 0, 10, x, 20, 1, 11, 5, 21, 5]
    path = tmp_path / "a.dxf"
    path.write_text("\n".join(map(str, [*words, 0, "ENDSEC", 0, "EOF", ""])))
    page = sources.open_drawing(path).outlines(0.1)
    assert [len(lines) for lines in page.layers.values()] == [1] and page.left_out == {"number that is none, or that cannot be read": 1}


@pytest.mark.parametrize("subclass", [(), (100, "AcDbEntity")])
def test_splines_of_old_inkscape_are_drawn(tmp_path, subclass):
    """No header, no subclass, and one handle for all: ezdxf refuses them."""
    words = [999, "DXF created by Inkscape", 0, "SECTION", 2, "ENTITIES"]
    for y in (0, 10):
        words += [0, "SPLINE", 5, 43, 8, 0, 62, 256, *subclass, 70, 8, 71, 3, 72, 8, 73, 4, 74, 0]
        words += [word for knot in (0, 0, 0, 0, 1, 1, 1, 1) for word in (40, knot)]
        words += [word for x in (0, 10, 20, 30) for word in (10, x, 20, y, 30, 0)]
    path = tmp_path / "a.dxf"
    path.write_text("\n".join(map(str, [*words, 0, "ENDSEC", 0, "EOF", ""])))
    lines = [line for lines in sources.open_drawing(path).outlines(0.1).layers.values() for line in lines]
    assert sorted((round(line.real.min()), round(line.real.max()), round(line.imag[0])) for line in lines) == [(0, 113, 0), (0, 113, 38)]
