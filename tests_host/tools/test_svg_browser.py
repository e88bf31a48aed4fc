"""SVG files beside Chromium: transforms, boxes and geometry by style sheets, units of the file's own; and what nobody sees."""

import re
import shutil
import subprocess
import time

import numpy
import pytest
from matplotlib import font_manager
from PIL import Image
from test_draw_oracles import agreement, rsvg_ink

from host_tools import boards
from host_tools.drawings import drawing, svg_area, svg_font
from host_tools.drawings.placement import MM_PER_PX, Options, box_of
from host_tools.drawings.svg_file import SvgFile
from host_tools.failure import Failure

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="200" height="120" fill="none" stroke="black">'
SIDE, COLUMNS, SCALE = (200, 120), 6, 3
RECT = '<rect x="80" y="50" width="40" height="20" style="{}"/>'
AS_BROWSERS = {
    **{style: RECT.format(style) for style in (
        "rotate:45deg", "rotate:-.1turn", "translate:20px 5px", "translate:10%", "scale:2 1", "scale:50%", "rotate:z 30deg", "rotate:1 0 0 60deg", "rotate:y 60deg",
        "translate:20px;rotate:20deg;scale:1.5 .5;transform:skewX(20deg)", "translate:20px;transform:rotate(10deg)", "transform:translate(20px 5px)", "transform:translate(20,5)",
        "transform:rotate(30)", "rotate:30", "translate:9 9", "scale:2px", "transform:rotateZ(30deg)", "transform:translate3d(9px,9px,0)", "transform:rotateX(60deg)",
        "transform:rotate(45deg);transform-origin:center;transform-box:fill-box", "transform:rotate(45deg);transform-box:fill-box", "rotate:45deg;transform-origin:right top;transform-box:fill-box",
        "translate:50% 100%;transform-box:fill-box", "scale:.5;transform-origin:50% 50%;transform-box:fill-box;stroke-width:6", "scale:.5;transform-origin:0 0;transform-box:stroke-box;stroke-width:6",
        "transform:rotate(45deg);transform-origin:center", "transform:rotate(45deg);transform-origin:100px 60px;transform-box:view-box", "-webkit-transform:rotate(20deg)",
        "width:90px;rx:9px", "width:90;height:9px", "x:10px;y:1cm", "width:auto", "x:25%", "rx:auto;ry:5px", "x:-5px;width:-5px",
    )},
    "an attribute's transform is another": '<rect x="9" y="9" width="40" height="20" transform="translate(20,5) rotate(20)"/><text x="9" y="90" font-size="1" rotate="45"/>',
    "a sheet's circle": "<style>circle{r:8px;cx:40px;cy:30px}</style><circle/><circle cx='99' cy='90' r='5' style='r:20px'/>",
    "a sheet without units": "<style>circle{r:8;cx:40px}</style><circle cx='9' cy='60' r='30'/>",
    "an ellipse": "<ellipse style='cx:90px;cy:50px;rx:40px'/><ellipse cx='50' cy='90' rx='9' ry='9' style='rx:auto;ry:20px'/>",
    "a path": "<style>#p{d:path('M10 10L150 100H20')}</style><path id='p' d='M0 0L10 20'/><path d='M9 110h90' style='d:none'/><path d='M9 115h90' style='d:inherit'/>",
    "a use that is moved": "<defs><rect id='r' width='30' height='20'/></defs><use href='#r' style='x:50px;y:40px'/><use href='#r' x='5' y='5' style='rotate:10deg'/>",
    "an svg inside": "<svg x='9' y='9' width='20' height='20' viewBox='0 0 10 10' style='x:60px;width:80px;height:80px'><circle cx='5' cy='5' r='4' stroke-width='.1'/></svg>",
    "a group about its own box": "<g style='rotate:30deg;transform-origin:center;transform-box:fill-box'><rect x='50' y='40' width='40' height='20'/><g transform='translate(50 0)'><circle cx='80' cy='60' r='10'/></g></g>",
    "boxes in boxes": "<style>g,rect{transform-box:fill-box;transform-origin:100% 50%}</style><g style='scale:.8'><rect style='rotate:20deg' x='50' y='40' width='40' height='20'/><rect style='rotate:-20deg' x='90' y='80' width='40' height='20'/></g>",
    "hidden shapes count for a box": "<g style='scale:.5;transform-origin:center;transform-box:fill-box'><rect x='20' y='20' width='100' height='80' stroke='none'/><rect x='40' y='30' width='40' height='20'/></g>",
    "a turned box of a viewBox": "<svg viewBox='0 0 1000 600'><rect x='400' y='250' width='200' height='100' stroke-width='5' style='rotate:45deg;transform-origin:center;transform-box:fill-box'/></svg>",
}  # fmt: skip


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """{name: ink of Chromium}, all on one page."""
    if not shutil.which("chromium"):
        pytest.skip("chromium is not installed")
    folder = tmp_path_factory.mktemp("chromium")
    rows = -(-len(AS_BROWSERS) // COLUMNS)
    cells = "".join(
        f'<iframe srcdoc="" style="position:absolute;border:0;left:{index % COLUMNS * SIDE[0]}px;top:{index // COLUMNS * SIDE[1]}px;width:{SIDE[0]}px;height:{SIDE[1]}px" '
        f'src="{index}.svg"></iframe>'.replace('srcdoc="" ', "")
        for index in range(len(AS_BROWSERS))
    )
    for index, body in enumerate(AS_BROWSERS.values()):
        (folder / f"{index}.svg").write_text(f"{HEAD}{body}</svg>")
    (folder / "page.html").write_text(f'<body style="margin:0">{cells}</body>')
    subprocess.run(
        ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--allow-file-access-from-files", f"--force-device-scale-factor={SCALE}",
         f"--window-size={COLUMNS * SIDE[0]},{rows * SIDE[1]}", f"--user-data-dir={folder / 'profile'}", f"--screenshot={folder / 'page.png'}", (folder / "page.html").as_uri()],
        check=True, capture_output=True, timeout=120,
    )  # fmt: skip
    black = numpy.asarray(Image.open(folder / "page.png").convert("L")) < 128
    wide, high = SIDE[0] * SCALE, SIDE[1] * SCALE
    found = {}
    for index, name in enumerate(AS_BROWSERS):
        top, left = index // COLUMNS * high, index % COLUMNS * wide
        rows_of, columns_of = numpy.nonzero(black[top : top + high, left : left + wide])
        found[name] = numpy.column_stack((columns_of + 0.5, rows_of + 0.5)) / SCALE
    return found


@pytest.mark.parametrize("name", AS_BROWSERS)
def test_shapes_stand_where_a_browser_has_them(tmp_path, pictures, name):
    path = tmp_path / "a.svg"
    path.write_text(f"{HEAD}{AS_BROWSERS[name]}</svg>")
    page = SvgFile(path).outlines(0.02)
    shown = svg_area.rectangle(0, 0, *SIDE)
    lines = svg_area.clip_lines([line for lines in page.layers.values() for line in lines], shown)
    ink = pictures[name]
    near = 3.6 if "stroke-width:6" in name else 2.2 if "scale:2" in name or "inside" in name else 1.2
    assert min(agreement(ink, lines, near)) > 0.99, lines and box_of([lines])


NANOMETRES = {
    "shapes of KiCad": "<path d='M{20} {20} L{140} {20} {140} {90}Z'/><circle cx='{60}' cy='{70}' r='{20}'/><rect x='{100}' y='{30}' width='{20}' height='{20}' transform='translate({20} {10})'/>",
    "text": "<text x='{20}' y='{60}' font-family='DejaVu Sans' font-size='{40}' stroke='none' fill='black'>Pa</text>",
    "a clip path, dashes and a use": "<clipPath id='c'><circle cx='{100}' cy='{60}' r='{50}'/></clipPath><defs><path id='p' d='M0 0h{200}'/></defs>"
        "<use href='#p' y='{60}' clip-path='url(#c)'/><path d='M0 {20}h{200}' stroke-dasharray='{20} {10}'/>",
    "text along a path": "<path id='w' d='M{10} {60}h{180}'/><text font-family='DejaVu Sans' font-size='{20}' stroke='none' fill='black'><textPath href='#w'>Passo</textPath></text>",
    "a style": "<rect x='{20}' y='{20}' width='{40}' height='{30}' style='translate:{10}px;rx:{5}px;rotate:20deg;transform-box:fill-box;transform-origin:center'/>",
}  # fmt: skip


@pytest.mark.parametrize("name", NANOMETRES)
def test_drawings_in_nanometres_are_where_those_in_mm_are(tmp_path, name):
    """KiCad's: the bound on coordinates holds on the page, not in the file's units."""
    path, found = tmp_path / "a.svg", []
    for unit in (1, 10**6):
        body = re.sub(r"{(\d+)}", lambda match, unit=unit: str(int(match[1]) * unit), NANOMETRES[name])
        path.write_text(f"{HEAD}<svg viewBox='0 0 {200 * unit} {120 * unit}' stroke-width='{unit}'>{body}</svg></svg>")
        page = SvgFile(path).outlines(0.02)
        found.append([line for lines in page.layers.values() for line in lines])
        assert not page.left_out
    assert len(found[0]) == len(found[1]) and all(one == pytest.approx(other, abs=0.05) for one, other in zip(*found))
    if name.startswith("shapes"):
        assert min(agreement(rsvg_ink(path, tmp_path), found[1], 0.9)) > 0.99


def test_a_page_far_from_zero_and_one_of_no_size(tmp_path):
    path = tmp_path / "a.svg"
    path.write_text(f"{HEAD}<svg viewBox='1000000000 2000000000 200 120'><path d='M1000000020 2000000020h100v60'/></svg></svg>")
    assert box_of(SvgFile(path).outlines(0.02).layers.values()) == pytest.approx((20, 20, 120, 80), abs=1e-3)
    for body in ('<path id="p" d="M0 0H1e8"/>', '<path id="p" transform="translate(1e8 0)" d="M0 0H9"/>', '<text id="p" font-size="1e8" y="9">a</text>', '<circle id="p" r="1e11"/>'):
        path.write_text(f"{HEAD.replace('stroke=', 'fill=')}{body}</svg>".replace('fill="none"', 'stroke="black"', 1))
        with pytest.raises(Failure, match='id="p">: .* px is too far away'):
            SvgFile(path).outlines(0.02)


# --- what nobody sees

VISIBLE = '<path d="M20 40h60" stroke="#000"/>'
UNSEEN = {
    "no paint": '<rect width="30" height="30" stroke="none" fill="none"/>',
    "no width": '<rect width="30" height="30" stroke-width="0"/>', "no width in mm": '<rect width="30" height="30" style="stroke-width:0mm"/>',
    "clear stroke": '<rect width="30" height="30" stroke-opacity="0"/>', "clear": '<g opacity="0"><rect width="30" height="30"/></g>', "clear colours": '<rect width="30" height="30" stroke="rgba(0,0,0,0)" fill="#0000"/>',
    "text": '<text y="30" stroke="none" fill="none">Passo</text>',
    "a line of a fill alone": '<line x1="9" y1="80" x2="90" y2="99" stroke="none"/>', "straight paths of a fill alone": '<path d="M9 80L90 99M20 70h50h-20z" fill="red" stroke="none"/>',
    "clear by four digits": '<rect width="30" height="30" stroke="#f000" fill="#12345600"/>', "clear behind a slash": '<rect width="30" height="30" stroke="rgb(9 9 9 / 0%)" fill="hsl(90 50% 50% / 0)"/>',
}  # fmt: skip
PAGES = {
    "white": '<rect width="200" height="120" fill="#fff" stroke="none"/>', "of per cent": '<rect width="100%" height="100%" style="fill:white;stroke:none"/>',
    "a path": '<path d="M0 120H200V0H0Z" fill="rgb(255,255,255)" stroke="none"/>', "a polygon of graphviz": '<g transform="translate(4 116)"><polygon fill="white" stroke="transparent" points="-4,4 -4,-116 196,-116 196,4"/></g>',
    "a white edge": '<rect width="200" height="120" fill="#fff" stroke="#fff"/>', "a px larger": '<rect x="-1" y="-1" width="202" height="122" fill="#ffffff" stroke="none"/>',
    "far larger": '<rect x="-900" y="-900" width="3000" height="2000" fill="white" stroke="none"/>', "a circle around": '<circle cx="100" cy="60" r="500" fill="white" stroke="none"/>',
    "round twice": '<path d="M0 0h200v120h-200z M0 0h200v120h-200z" fill="white" stroke="none"/>', "of mm": '<rect width="60mm" height="40mm" fill="hsl(0,0%,100%)" stroke="none"/>',
    "of a sheet": '<style>.k{fill:rgb(100%,100%,100%);stroke:none}</style><g><rect class="k" width="200" height="120"/></g>', "an edge of no width": '<rect width="200" height="120" fill="white" stroke-width="0"/>',
    "behind a clip path": '<clipPath id="c"><rect width="200" height="120"/></clipPath><g clip-path="url(#c)"><rect width="200" height="120" fill="white" stroke="none"/></g>',
    "of an svg inside": '<svg width="200" height="120" viewBox="0 0 20 12"><rect width="100%" height="100%" fill="white" stroke="none"/></svg>',
    "of a symbol": '<symbol id="s" viewBox="0 0 10 6" overflow="visible"><rect width="10" height="6" fill="#fff" stroke="none"/></symbol><use href="#s"/>',
    "round corners of a px": '<rect width="200" height="120" rx="1" fill="white" stroke="none"/>',
    "a gradient": '<linearGradient id="g"><stop stop-color="#fff"/><stop offset="1" style="stop-color:white"/></linearGradient><rect width="200" height="120" fill="url(#g)" stroke="none"/>',
    "a gradient of another": '<style>stop{stop-color:rgb(255,255,255)}</style><radialGradient id="h"><stop/><stop offset="1"/></radialGradient><linearGradient id="g" href="#h"/><rect width="200" height="120" fill="url(#g)" stroke="none"/>',
    "a clear gradient": '<linearGradient id="g"><stop stop-color="#fff"/><stop offset="1" stop-color="#fff" stop-opacity="0"/></linearGradient><rect width="200" height="120" fill="url(#g)" stroke="none"/>',
    "a pattern": '<pattern id="g" width="9" height="9" patternUnits="userSpaceOnUse"><g fill="white" stroke="white"><path d="M0 0h9v9z"/><circle r="4"/></g></pattern><rect width="200" height="120" fill="url(#g)" stroke="none"/>',
    "by blanks": '<rect width="200" height="120" fill="hsl(40 50% 100%)" stroke="none"/>', "of lightness": '<rect width="200" height="120" style="fill:oklch(100% 0 0);stroke:none"/>', "of red, green and blue": '<path d="M0 0H200V120H0Z" fill="rgb(100% 100% 100%)" stroke="#ffff"/>',
    "by currentColor": '<g color="white"><rect width="200" height="120" fill="currentColor" stroke="none"/></g>', "by a use": '<defs><rect id="r" width="200" height="120"/></defs><use href="#r" fill="#fff" stroke="none"/>',
}  # fmt: skip


def page_of(tmp_path, body, **options):
    path = tmp_path / "a.svg"
    path.write_text(f"{HEAD}{body}{VISIBLE}</svg>")
    page = SvgFile(path).outlines(0.02, **options)
    return page, [line for lines in page.layers.values() for line in lines]


@pytest.mark.parametrize("name", [*UNSEEN, *PAGES])
def test_what_nobody_sees_is_left_out_and_named(tmp_path, name):
    body = {**UNSEEN, **PAGES}[name]
    page, lines = page_of(tmp_path, body)
    assert len(lines) == 1 and (page.unseen, page.backgrounds) == ((1, 0) if name in UNSEEN else (0, 1)) and not page.left_out
    ink = rsvg_ink(tmp_path / "a.svg", tmp_path)
    assert min(agreement(ink, lines, 0.9)) > 0.99, "nobody sees it in librsvg's picture either"
    plan = drawing.load(tmp_path / "a.svg", boards.load("plotter_2014"))
    assert any("--unseen draws it" in note for note in plan.notes) and len(plan.lines) == 1
    plan = drawing.load(tmp_path / "a.svg", boards.load("plotter_2014"), Options(unseen=True, crop=False, place="outlines"))
    assert len(plan.lines) > 1 and not any("--unseen" in note for note in plan.notes)

GREY_AT_THE_END = '<linearGradient id="g"><stop stop-color="#fff"/><stop offset="1" stop-color="#eee"/></linearGradient><rect width="200" height="120" fill="url(#g)" stroke="none"/>'
GREY_DOTS = '<pattern id="g" width="9" height="9" patternUnits="userSpaceOnUse"><path d="M0 0h9v9z" fill="white" stroke="none"/><circle r="4" fill="#eee"/></pattern><rect width="200" height="120" fill="url(#g)" stroke="none"/>'


@pytest.mark.parametrize("body", [
    '<rect width="200" height="120" fill="#fff"/>', '<rect width="200" height="120" fill="#eee" stroke="none"/>', '<rect width="150" height="120" fill="#fff" stroke="none"/>',
    '<rect x="9" y="9" width="182" height="102" fill="#fff" stroke="none"/>', GREY_AT_THE_END, GREY_DOTS, '<path d="M0 0L200 120V0L0 120Z" fill="#fff" stroke="none"/>', '<rect width="200" height="120"/>',
])  # fmt: skip
def test_frames_and_smaller_areas_are_drawn(tmp_path, body):
    page, lines = page_of(tmp_path, body)
    assert len(lines) > 1 and not page.backgrounds and not page.unseen


@pytest.mark.parametrize("more, covered", [("", 2), ('fill-opacity="0.5" ', 0), ('opacity=".9"', 0), ('opacity="100%"', 2)])
def test_what_lies_below_a_white_page_is_drawn_and_named(tmp_path, more, covered):
    """A viewer hides it, unless the white is clear."""
    path = tmp_path / "a.svg"
    path.write_text(f'{HEAD}{VISIBLE}<text y="30">A</text><rect width="200" height="120" fill="#fff" stroke="none" {more}/><path d="M20 90h60"/></svg>')
    for unseen in (False, True):
        plan = drawing.load(path, boards.load("plotter_2014"), Options(unseen=unseen))
        found = [note for note in plan.notes if "no viewer shows it" in note]
        assert found == ([f"{covered} × a shape below a white area over the whole page, where no viewer shows it, is drawn all the same"] if covered else [])
        assert len(plan.lines) > 3


@pytest.mark.parametrize("opacity, covered", [("1", 1), ("100%", 1), (".9", 0), ("0", 0)])
def test_a_gradient_hides_what_lies_below_if_it_is_not_clear(tmp_path, opacity, covered):
    page, lines = page_of(tmp_path, f'<path d="M9 9h9"/><linearGradient id="g"><stop stop-color="#fff" stop-opacity="{opacity}"/></linearGradient><rect width="200" height="120" fill="url(#g)" stroke="none"/>')
    assert page.covered == covered and page.backgrounds == 1 and len(lines) == 2


OTHERWISE = {  # (what is drawn, the same in other words)
    "x and y of a symbol": ('<symbol id="s" x="10" y="5" width="40" height="40" viewBox="0 0 20 20"><path d="M2 2h9"/></symbol><use href="#s" x="30" y="20"/>', '<path d="M44 29h18"/>'),
    "a use turned about its box": ('<defs><path id="q" d="M0 0h40v30"/></defs><use href="#q" x="60" y="30" style="transform-box:fill-box;transform-origin:center;rotate:180deg"/>', '<path d="M-20 0h-40v-30"/>'),
    "an attribute with units": ('<path transform="translate(20px 10px)" d="M0 0h40v30"/>', '<path d="M0 0h40v30"/>'),
    "no radius of an inherit": ('<style>circle{r:inherit}</style><circle cx="90" cy="60" r="25"/>', ""),
    "first width": ('<rect width="90" height="20" style="width:initial"/>', ""),
    "a sheet of another type": ('<style type="text/x">path{display:none}</style>', ""),
    "a path with a rule for areas": ("<path d=\"M9 9h9\" style=\"d:path(evenodd,'M5 5h5')\"/>", '<path d="M9 9h9"/>'),
    "dashes of the author's measure": ('<path pathLength="4" stroke-dasharray="1 1" stroke-dashoffset="-1" d="M9 60h100"/>', '<path d="M34 60h25M84 60h25"/>'),
}


@pytest.mark.parametrize("name", OTHERWISE)
def test_what_browsers_draw_otherwise_than_librsvg(tmp_path, name):
    (_, lines), (_, wanted) = (page_of(tmp_path, body) for body in OTHERWISE[name])
    assert sorted(map(str, (line.round(3) + 0 for line in lines))) == sorted(map(str, (line.round(3) + 0 for line in wanted)))


@pytest.mark.parametrize("body, name", [
    ('<rect transform="rotate(10deg)" width="9" height="5"/>', "value of a style that cannot be read, or lacks its unit"),
    ('<path style="offset-path:path(\'M90 60h50\')" d="M0 0h9"/>', "offset-path of CSS"), ("<style>g{.k{display:none}}</style>", "style rule that cannot be read"),
])  # fmt: skip
def test_css_that_is_not_drawn_is_named(tmp_path, body, name):
    assert page_of(tmp_path, body)[0].left_out == {name: 1}


@pytest.mark.parametrize("animation", [
    '<set attributeName="stroke-opacity" to="1"/>', '<animate attributeName="stroke-opacity" to="1" dur="1s"/>', '<animateTransform attributeName="transform" type="rotate" to="90" dur="1s"/>',
    '<animateMotion path="M0 0h9" dur="1s"/>', "<style>@keyframes k{to{stroke-opacity:1}} path{animation:k 1s}</style>",
])  # fmt: skip
@pytest.mark.parametrize("around", ['<rect width="9" height="9" stroke-opacity="0">{}</rect>', '<g display="none">{}<path d="M1 1h9"/></g>', '<path id="p" d="M0 9h9" stroke="none"/>{}'])
def test_animations_are_named(tmp_path, animation, around):
    """Also in drawings that show only by animation: all is drawn as without it."""
    page, lines = page_of(tmp_path, around.format(animation))
    assert page.left_out == {"animation (drawn as without it)": 1} and len(lines) == 1
    plan = drawing.load(tmp_path / "a.svg", boards.load("plotter_2014"))
    assert any("animation (drawn as without it)" in note for note in plan.notes)


def test_several_white_pages_are_left_out_and_what_lies_between_is_drawn(tmp_path):
    white = '<rect width="200" height="120" fill="#fff" stroke="none"/>'
    page, lines = page_of(tmp_path, f'{white}<path d="M9 9h9"/>{white}')
    assert page.backgrounds == 2 and page.covered == 1 and len(lines) == 2


def test_a_drawing_of_nothing_visible_says_how_to_draw_it(tmp_path):
    path = tmp_path / "a.svg"
    path.write_text(f'{HEAD}<rect width="30" height="30" stroke="none"/><rect width="200" height="120" fill="#fff" stroke="none"/></svg>')
    with pytest.raises(Failure, match="1 × a shape that nobody sees.*--unseen draws it.*white background.*--unseen"):
        drawing.load(path, boards.load("plotter_2014"))


def test_the_size_of_the_page_by_css(tmp_path):
    path = tmp_path / "a.svg"
    for attributes, size in (
        ('viewBox="0 0 4 3" style="width:100mm;height:75mm"', (100, 75)), ('viewBox="0 0 4 3" width="100mm" height="75mm" style="width:100%;height:auto"', (100, 75)),
        ('viewBox="0 0 4 3" width="9mm" style="width:40mm"', (40, 30)),
    ):  # fmt: skip
        path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {attributes}><path stroke="black" d="M0 0h1"/></svg>')
        assert [each * MM_PER_PX for each in SvgFile(path).size_px] == pytest.approx(size)


# --- fonts


@pytest.fixture
def old_list(monkeypatch):
    """matplotlib's list from before DejaVu Sans Mono was installed."""
    if not shutil.which("fc-match"):
        pytest.skip("fontconfig is not installed: apt-get install fontconfig")
    manager = font_manager.fontManager
    monkeypatch.setattr(manager, "ttflist", [each for each in manager.ttflist if "Mono" not in each.name])
    manager._findfont_cached.cache_clear()
    caches = (svg_font._find_font, svg_font._letter_sets, svg_font._is_slanted, svg_font.font_heights)
    for cache in caches:
        cache.cache_clear()
    yield
    manager._findfont_cached.cache_clear()
    for cache in caches:
        cache.cache_clear()


def text_of(tmp_path, style):
    path = tmp_path / "a.svg"
    path.write_text(f'{HEAD}<text x="9" y="60" font-size="30" stroke="none" fill="black" style="{style}">Damped</text></svg>')
    return SvgFile(path).outlines(0.02)


@pytest.mark.parametrize("weight", ["normal", "bold"])
def test_a_font_that_was_installed_later_is_drawn(tmp_path, old_list, weight):
    page = text_of(tmp_path, f"font-family:DejaVu Sans Mono;font-weight:{weight}")
    assert not page.left_out and min(agreement(rsvg_ink(tmp_path / "a.svg", tmp_path), page.layers[1], 1.9 if weight == "normal" else 3.0)) > 0.99


@pytest.mark.parametrize("families, named", [
    ("Never Seen, sans-serif", True), ("Never Seen, DejaVu Serif", True), ("Never Seen", True), ("'DejaVu Serif', Never Seen", False), ("serif", False), ("dejavu sans", False),
])  # fmt: skip
def test_a_stand_in_is_always_said(tmp_path, families, named):
    page = text_of(tmp_path, f"font-family:{families}")
    assert [each.startswith("the font Never Seen, which is not") for each in page.left_out] == [True] * named
    if named:
        assert min(agreement(rsvg_ink(tmp_path / "a.svg", tmp_path), page.layers[1], 1.9)) > 0.99


# --- bounds: each answers within some seconds, and says which element is too much


def copies(leaf, levels, each):
    """`leaf`, each**levels times, by <use> in <use>."""
    groups = ""
    for level in range(1, levels + 1):
        uses = "".join(f'<use href="#u{level - 1}" x="{x / 10}"/>' for x in range(each))
        groups += f'<g id="u{level}">{uses}</g>'
    return f'<defs><g id="u0">{leaf}</g>{groups}</defs><use href="#u{levels}"/>'


def zigzag(count):
    return " ".join(f"{997 * index % 199},{613 * index % 113}" for index in range(count))


TOO_MUCH = {
    "uses": (copies('<path d="M0 0h5"/>', 9, 10), "copies made by <use>"), "a long path": (copies(f'<polyline points="{zigzag(20_000)}"/>', 3, 10), "copies made by <use>"),
    "many shapes": (copies('<path d="M0 0h5"/>' * 1000, 3, 10), "copies made by <use>"),
    "text": (copies('<text fill="black" font-size="5">' + "Passo " * 300 + "</text>", 3, 10), "copies made by <use>"),
    "clip paths": (f'<clipPath id="c"><polygon points="{zigzag(150)}"/></clipPath>' + copies('<path clip-path="url(#c)" d="M0 9h99"/>', 3, 10), "copies made by <use>"),
    "a clip path": (f'<clipPath id="c"><polygon points="{zigzag(2000)}"/></clipPath><path id="p" clip-path="url(#c)" d="M0 9h99"/>', "cross more than 10000 times"),
}  # fmt: skip


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow if name in ("uses", "many shapes", "text", "clip paths") else ()) for name in TOO_MUCH])
def test_what_multiplies_is_refused_soon(tmp_path, name):
    path = tmp_path / "a.svg"
    body, why = TOO_MUCH[name]
    path.write_text(f"{HEAD}{body}</svg>")
    begun = time.process_time()
    with pytest.raises(Failure, match=why):
        SvgFile(path).outlines(0.05)
    assert time.process_time() - begun < 20  # 5 s alone


def test_a_thousand_copies_are_drawn(tmp_path):
    path = tmp_path / "a.svg"
    circle = '<circle cx="9" cy="9" r="5"/>'
    path.write_text(f"{HEAD}{copies(circle, 3, 10)}</svg>")
    assert len(SvgFile(path).outlines(0.05).layers[1]) == 1000


@pytest.mark.parametrize("text", ["Passo " * 20_000, '<tspan dx="1">Passo </tspan>' * 20_000])
def test_a_long_label_is_named(tmp_path, text):
    page, lines = page_of(tmp_path, f'<text fill="black" y="9">{text}</text>')
    assert page.left_out == {"text of more than 10000 letters": 1} and len(lines) == 1


def test_short_dashes_are_named(tmp_path):
    page, lines = page_of(tmp_path, '<path stroke-dasharray=".001" d="M0 9h99"/>')
    assert page.left_out == {"dashes too short to draw (drawn without gaps)": 1} and len(lines) == 2


def test_big_pictures_in_a_file_cost_little(tmp_path):
    """expat read a picture of n parts n times: 60 MB took minutes."""
    path = tmp_path / "a.svg"
    picture = "A" * 20_000_000
    path.write_text(f'{HEAD}<style>a{{fill:url(data:font/woff2;base64,{picture})}}</style><image href="data:image/png;base64,{picture}" width="9" height="9"/>{VISIBLE}</svg>')
    begun = time.process_time()
    page = SvgFile(path).outlines(0.05)
    assert time.process_time() - begun < 3 and page.left_out == {"picture": 1} and len(page.layers[1]) == 1
