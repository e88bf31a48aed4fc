"""Readers of drawings against programs that are not ours: the ink of rsvg-convert and hp2xx, Debian's, and our lines lie on each other.

Without these programs the tests skip.
"""

import shutil
import subprocess

import numpy
import pytest
from PIL import Image
from shapely import STRtree
from shapely import points as shapely_points

from host_tools.drawings.svg_file import SvgFile

SCALE = 4  # pixels a px
HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="200" height="120" fill="none" stroke="black">'


def rsvg_ink(path, tmp_path):
    """Places of black pixels, in px."""
    if not shutil.which("rsvg-convert"):
        pytest.skip("rsvg-convert is not installed: apt-get install librsvg2-bin")
    out = tmp_path / "oracle.png"
    subprocess.run(["rsvg-convert", "-z", str(SCALE), "-b", "white", "-o", out, path], check=True, env={"LANG": "en_US.UTF-8", "PATH": "/usr/bin:/bin"})
    rows, columns = numpy.nonzero(numpy.asarray(Image.open(out).convert("L")) < 128)
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
    "turned letters": '<text x="20" y="60" rotate="0 30 -30 90" font-family="DejaVu Sans" font-size="20" stroke="none" fill="black">turned</text>',
}


# What rsvg-convert 2.54 does not do.
BROWSER = ("css transform", "css transform about an origin", "text on a curve", "text on a line in the middle", "turned letters")


@pytest.mark.parametrize("name", SVG)
def test_svg_as_others_have_it(tmp_path, name):
    path = tmp_path / "a.svg"
    path.write_text(f"{HEAD}{SVG[name]}</svg>")
    ink = (chromium_ink if name in BROWSER else rsvg_ink)(path, tmp_path)
    page = SvgFile(path).outlines(0.02)
    lines = [line for lines in page.layers.values() for line in lines]
    thick = name in BROWSER  # letters are filled, strokes stretched
    on_ours, on_theirs = agreement(ink, lines, 1.6 if thick else 0.9)
    assert on_ours > 0.99 and on_theirs > 0.99, (on_ours, on_theirs)
    assert not page.left_out


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
