"""Which parts of an SVG file are drawn, and at which place, and the notes on the rest; geometry by hand, text by its letters' boxes."""

import math

import numpy
import pytest
import svgelements
from hypothesis import given, settings
from hypothesis import strategies as st

from host_tools import boards
from host_tools.drawings import drawing, svg_area, svg_file, svg_geometry, svg_path
from host_tools.drawings.svg_file import SvgFile
from host_tools.failure import Failure

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="200" height="100" '


def page_of(tmp_path, body, attributes='viewBox="0 0 200 100" fill="none" stroke="black"', head=HEAD):
    path = tmp_path / "a.svg"
    path.write_text(f"{head}{attributes}>{body}</svg>", encoding="utf-8")
    return SvgFile(path).outlines(0.01)


def lines_of(page, layer=1):
    """Polylines as lists of rounded places."""
    return [[(round(each.real, 2), round(each.imag, 2)) for each in line] for line in page.layers.get(layer, [])]


def box_of(lines):
    xs, ys = zip(*(place for line in lines for place in line))
    return min(xs), min(ys), max(xs), max(ys)


# --- clip paths


def test_a_clip_path_cuts_lines_in_the_coordinates_of_what_it_clips(tmp_path):
    page = page_of(tmp_path, '''
        <g transform="translate(100 0)" clip-path="url(#c)"><path d="M-50 10 H50 M0 40 H5"/></g>
        <clipPath id="c"><rect x="0" y="0" width="20" height="30"/></clipPath>
    ''')
    assert len(lines_of(page)) == 1 and numpy.allclose(lines_of(page)[0], [(100, 10), (120, 10)], atol=0.03)


@pytest.mark.parametrize("rule, pieces", [("nonzero", [(10, 90)]), ("evenodd", [(10, 30), (60, 90)])])
def test_clip_rules(tmp_path, rule, pieces):
    page = page_of(tmp_path, f'''
        <clipPath id="c"><path clip-rule="{rule}" d="M10 10H90V90H10Z M30 30H60V70H30Z"/></clipPath>
        <path clip-path="url(#c)" d="M0 50H200"/>
    ''')
    got = [(line[0][0], line[-1][0]) for line in lines_of(page)]
    assert numpy.allclose(got, pieces, atol=0.03)


def test_a_hole_of_the_other_direction_is_a_hole_with_nonzero_too(tmp_path):
    page = page_of(tmp_path, '''
        <clipPath id="c"><path d="M10 10H90V90H10Z M30 30V70H60V30Z"/></clipPath>
        <path clip-path="url(#c)" d="M0 50H200"/>
    ''')
    assert numpy.allclose([(line[0][0], line[-1][0]) for line in lines_of(page)], [(10, 30), (60, 90)], atol=0.03)


def test_clip_paths_of_the_box_of_their_clip_and_of_their_groups(tmp_path):
    page = page_of(tmp_path, '''
        <clipPath id="half" clipPathUnits="objectBoundingBox"><rect width="0.5" height="1"/></clipPath>
        <clipPath id="low"><rect y="20" width="200" height="80"/></clipPath>
        <clipPath id="both" clip-path="url(#low)"><use href="#box" x="5"/></clipPath>
        <defs><rect id="box" width="100" height="100"/></defs>
        <g clip-path="url(#low)"><path clip-path="url(#half)" d="M10 0H50V40"/></g>
        <path clip-path="url(#both)" d="M60 10V30M160 10V30M0 50H80"/>
        <path clip-path="url(#half)" d="M100 60H140V61"/>
    ''')
    assert numpy.allclose(lines_of(page)[0], [(60, 20), (60, 30)], atol=0.03)
    assert numpy.allclose(lines_of(page)[1], [(5, 50), (80, 50)], atol=0.03)
    assert numpy.allclose(lines_of(page)[2], [(100, 60), (120, 60)], atol=0.03)
    assert len(lines_of(page)) == 3


@pytest.mark.parametrize("size", [(100, 50), (33.3, 77.7), (0.1, 0.3), (123.456, 45.679)])
def test_a_frame_on_the_edge_of_its_clip_path_stays_whole(tmp_path, size):
    shape = f'<rect x="1.1" y="2.2" width="{size[0]}" height="{size[1]}"'
    page = page_of(tmp_path, f'<clipPath id="c">{shape}/></clipPath>{shape} clip-path="url(#c)" transform="rotate(17)"/>')
    assert [len(line) for line in lines_of(page)] == [5]


def test_a_line_that_crosses_itself_stays_one_line(tmp_path):
    loop = "M20 20 L80 80 L80 20 L20 80"
    page = page_of(tmp_path, f'<clipPath id="c"><circle cx="50" cy="50" r="70"/></clipPath><path clip-path="url(#c)" d="{loop}"/>')
    assert lines_of(page) == [[(20, 20), (80, 80), (80, 20), (20, 80)]]
    page = page_of(tmp_path, f'<clipPath id="c"><rect x="30" width="170" height="100"/></clipPath>'
                             f'<path clip-path="url(#c)" d="{loop}"/>')
    assert numpy.allclose(lines_of(page)[0], [(30, 30), (80, 80), (80, 20), (30, 70)], atol=0.03) and len(lines_of(page)) == 1


PLACES = st.builds(complex, st.integers(-30, 130), st.integers(-30, 130))


@settings(max_examples=150, deadline=None)
@given(st.lists(PLACES, min_size=2, max_size=7), st.lists(PLACES, min_size=3, max_size=7), st.sampled_from(["nonzero", "evenodd"]))
def test_what_is_left_of_a_line_is_what_lies_inside(line, ring, rule):
    """Against a winding number of each place, counted by rays; places near an edge may fall either way."""
    line, ring = numpy.array(line), numpy.array(ring)
    left = svg_area.clip_lines([line], svg_area.fill_area([ring], rule))
    closed = numpy.append(ring, ring[0])
    for share in numpy.linspace(0, 1, 23):
        for a, b in zip(line, line[1:]):
            place = a + share * (b - a)
            if min(distance(place, *edge) for edge in zip(closed, closed[1:])) < 1e-6:
                continue
            turns = winding(closed, place)
            inside = turns % 2 if rule == "evenodd" else turns
            kept = any(distance(place, *pair) < 1e-6 for part in left for pair in zip(part, part[1:])) or any(
                abs(place - each) < 1e-6 for part in left for each in part
            )
            other = any(distance(place, c, d) < 1e-6 for c, d in zip(line, line[1:]) if (c, d) != (a, b))
            assert kept == bool(inside) or (kept and other)


def distance(place, a, b):
    if a == b:
        return abs(place - a)
    share = ((place - a) * (b - a).conjugate()).real / abs(b - a) ** 2
    return abs(place - a - min(max(share, 0), 1) * (b - a))


def winding(closed, place):
    """How often a ring goes round a place, by the edges that a ray to the right crosses."""
    turns = 0
    for a, b in zip(closed, closed[1:]):
        if (a.imag > place.imag) != (b.imag > place.imag):
            if a.real + (place.imag - a.imag) * (b.real - a.real) / (b.imag - a.imag) > place.real:
                turns += 1 if b.imag > a.imag else -1
    return turns


# --- dashes


def test_dashes(tmp_path):
    page = page_of(tmp_path, '<path stroke-dasharray="10 5" stroke-dashoffset="3" d="M0 0H20V10"/>')
    assert lines_of(page) == [[(0, 0), (7, 0)], [(12, 0), (20, 0), (20, 2)], [(20, 7), (20, 10)]]
    page = page_of(tmp_path, '<path style="stroke-dasharray:4" transform="scale(2)" d="M0 0H20"/>')
    assert lines_of(page) == [[(0, 0), (8, 0)], [(16, 0), (24, 0)], [(32, 0), (40, 0)]]
    page = page_of(tmp_path, '<g stroke-dasharray="1"><path stroke-dasharray="none" d="M0 0H20"/></g>')
    assert lines_of(page) == [[(0, 0), (20, 0)]]
    page = page_of(tmp_path, '<path fill="black" stroke="none" stroke-dasharray="1" d="M0 0H20V9Z"/>')
    assert len(lines_of(page)) == 1


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(1, 30), min_size=1, max_size=5), st.integers(-100, 100), st.lists(PLACES, min_size=2, max_size=6, unique=True))
def test_dashes_cover_their_share_of_a_line(pattern, offset, line):
    line = numpy.array(line)
    whole = abs(numpy.diff(line)).sum()
    period = pattern * (1 + len(pattern) % 2)
    wanted, at = 0.0, -(offset % sum(period))
    while at < whole:
        for number, span in enumerate(period):
            if number % 2 == 0:
                wanted += max(0.0, min(at + span, whole) - max(at, 0.0))
            at += span
    dashes = svg_geometry.dash_lines([line], pattern, offset)
    assert sum(abs(numpy.diff(dash)).sum() for dash in dashes) == pytest.approx(wanted, abs=1e-6)


# --- symbols, uses, viewports


def test_a_symbol_is_fitted_to_its_use_and_not_drawn_by_itself(tmp_path):
    symbol = '<symbol id="s" viewBox="10 10 20 10"><path d="M10 10L30 20M0 15H40"/></symbol>'
    assert lines_of(page_of(tmp_path, symbol)) == []
    page = page_of(tmp_path, symbol + '<use href="#s" x="100" y="50" width="40" height="40"/>')
    assert numpy.allclose(lines_of(page)[0], [(100, 60), (140, 80)])
    assert numpy.allclose(lines_of(page)[1], [(100, 70), (140, 70)], atol=0.03)  # the rest is outside
    page = page_of(tmp_path, symbol.replace("<symbol ", '<symbol preserveAspectRatio="none" overflow="visible" ')
                   + '<use xlink:href="#s" x="100" y="50" width="40" height="40"/>')
    assert numpy.allclose(lines_of(page)[0], [(100, 50), (140, 90)])
    assert numpy.allclose(lines_of(page)[1], [(80, 70), (160, 70)])


def test_use_repeats_what_it_names(tmp_path):
    page = page_of(tmp_path, '''
        <defs><g id="g" transform="scale(2)"><path id="p" d="M0 0H5"/></g></defs>
        <g transform="translate(0 10)"><use xlink:href="#g" x="3"/></g><use href="#p" transform="rotate(90)"/>
        <use href="#gone"/>
    ''')
    assert lines_of(page) == [[(3, 10), (13, 10)], [(0, 0), (0, 5)]]
    assert page.left_out == {"<use> of something that is not in the file": 1}


DOUBLED = '<g id="u0"><path d="M1 1H2"/></g>' + "".join(f'<g id="u{n}"><use href="#u{n - 1}"/><use href="#u{n - 1}"/></g>' for n in range(1, 40))
CLIPS = "".join(f"""<clipPath id="c{n}"><rect width="5" height="5" clip-path="url(#c{n - 1})"/><rect width="4" height="5" clip-path="url(#c{n - 1})"/>
</clipPath>""" for n in range(12))  # fmt: skip


@pytest.mark.parametrize("body, why", [
    ('<g id="loop"><use id="u" href="#loop"/></g>', '<use id="u"> leads to itself'),
    ('<g id="a"><use href="#b"/></g><g id="b"><use id="u" href="#a"/></g>', "leads to itself"),
    ('<clipPath id="c"><rect width="5" height="5" clip-path="url(#c)"/></clipPath><path d="M0 0H9" clip-path="url(#c)"/>', 'id="c"> leads to itself'),
    (CLIPS + '<path d="M0 0H9" clip-path="url(#c11)"/>', "lies in more than 10 others"),
    (DOUBLED, "more than 500 shapes"),
    ("<g>" * 20_000 + '<path d="M0 0H9"/>' + "</g>" * 20_000, "<g> lies in more than 100 others"),
    ("<text>" + "<tspan>" * 20_000 + "a" + "</tspan>" * 20_000 + "</text>", "<text>: its numbers cannot be drawn: 100 levels"),
])  # fmt: skip
def test_what_has_no_end_is_refused_by_name(tmp_path, monkeypatch, body, why):
    monkeypatch.setattr(svg_file, "_MOST_USES", 500)
    with pytest.raises(Failure) as refusal:
        page_of(tmp_path, body)
    assert why in str(refusal.value)


def test_a_tree_of_many_elements_is_drawn(tmp_path):
    page = page_of(tmp_path, "<g>" * 90 + '<path d="M0 0H9"/>' + "</g>" * 90)
    assert lines_of(page) == [[(0, 0), (9, 0)]]


HUGE = (
    '<path id="p" d="M0 0L{} 5"/>', '<path id="p" d="M0 0C{} 0 1 1 2 2"/>', '<path id="p" d="M0 0Q{} 0 2 2"/>', '<path id="p" d="M0 0A{} 5 0 0 1 9 9"/>',
    '<path id="p" d="m0 0l{} 5l{} 5"/>', '<rect id="p" width="{}" height="5" rx="2"/>', '<circle id="p" r="{}"/>', '<polyline id="p" points="0,0 {},3"/>',
    '<rect id="p" width="9" height="9" transform="scale({})"/>', '<circle id="p" r="9" transform="matrix({} 0 0 1 0 0)"/>',
    '<svg id="p" width="9" height="4" viewBox="0 0 {} 3"/>', '<text id="p" x="4 {}">ab</text>', '<rect id="p" width="9" height="9" stroke-dasharray="{} 1"/>',
)  # fmt: skip


@pytest.mark.parametrize("number", ["NaN", "inf", "1e308", "-1e308", "1e400", "1e12", "1e-320"])
def test_numbers_that_are_none_or_lead_too_far(tmp_path, number):
    """Each place they can stand in: refused by the element's name, or left out; never drawn without an end."""
    for body in HUGE:
        try:
            page = page_of(tmp_path, body.replace("{}", number))
        except Failure as refusal:
            assert 'id="p">: ' in str(refusal) and ("too far away" in str(refusal) or "cannot be drawn" in str(refusal)), refusal
        else:
            drawable = "viewBox" in body or "dasharray" in body  # of units of the file's own
            assert number in ("NaN", "inf", "1e-320") or number == "-1e308" and "path" not in body or number == "1e12" and drawable, (number, body)
            assert all((abs(line) < 2e7).all() for lines in page.layers.values() for line in lines)


def test_an_svg_inside_and_percentages(tmp_path):
    page = page_of(tmp_path, '''
        <svg x="50%" y="10" width="50" height="50" viewBox="0 0 10 10"><path d="M0 0L10 10"/><line x2="50%" y2="100%"/></svg>
        <line x1="0" y1="50%" x2="100%" y2="50%"/>
    ''')
    lines = lines_of(page)
    assert [(100, 10), (150, 60)] in lines and [(100, 10), (125, 60)] in lines and [(0, 50), (200, 50)] in lines


@pytest.mark.parametrize("head, size", [
    ('width="100mm" height="50mm" ', (100 * 96 / 25.4, 50 * 96 / 25.4)), ('width="2in" ', (192, 96)), ('height="1in" ', (192, 96)),
    ("", (200, 100)), ('width="100%" height="100%" ', (200, 100)), ('width="9pc" height="9pt" ', (144, 12)),
])  # fmt: skip
def test_the_size_of_the_page(tmp_path, head, size):
    path = tmp_path / "a.svg"
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {head}viewBox="0 0 200 100"/>')
    assert SvgFile(path).size_px == pytest.approx(size)


@pytest.mark.parametrize("aspect, place", [
    (None, (0, 50, 200, 150)), ("none", (0, 0, 200, 200)), ("xMinYMin", (0, 0, 200, 100)), ("xMaxYMax meet", (0, 100, 200, 200)),
    ("xMidYMid slice", (-100, 0, 300, 200)),
])  # fmt: skip
def test_aspects(aspect, place):
    a, b, c, d, e, f = svg_geometry.view_box_matrix([5, 5, 20, 10], aspect, 0, 0, 200, 200)
    assert (a * 5 + e, d * 5 + f, a * 25 + e, d * 15 + f) == pytest.approx(place) and b == c == 0


NUMBERS = st.integers(-50, 50).map(lambda number: number / 4)
STEPS = st.one_of(
    st.tuples(st.sampled_from(["translate", "scale"]), st.lists(NUMBERS, min_size=1, max_size=2)),
    st.tuples(st.just("rotate"), st.one_of(st.lists(NUMBERS, min_size=1, max_size=1), st.lists(NUMBERS, min_size=3, max_size=3))),
    st.tuples(st.sampled_from(["skewX", "skewY"]), st.lists(NUMBERS, min_size=1, max_size=1)),
    st.tuples(st.just("matrix"), st.lists(NUMBERS, min_size=6, max_size=6)),
)


@settings(max_examples=100, deadline=None)
@given(st.lists(STEPS, max_size=4), st.sampled_from([" ", ", ", ""]))
def test_transforms_are_those_of_svgelements(steps, between):
    text = between.join(f"{name}({' '.join(map(str, given))})" for name, given in steps)
    other = svgelements.Matrix(text)
    for place in ((0, 0), (1, 0), (0, 1)):
        (line,) = svg_geometry.transform_lines([numpy.array([complex(*place)])], svg_geometry.read_matrix(text))
        assert (line[0].real, line[0].imag) == pytest.approx(tuple(other.point_in_matrix_space(place)), rel=1e-6, abs=1e-6)


# --- text


def test_text_stands_where_the_file_says(tmp_path):
    font = "font-family=\"'DejaVu Sans'\" font-size=\"20\""
    left = box_of(lines_of(page_of(tmp_path, f'<text x="50" y="50" {font}>HIH</text>')))
    middle = box_of(lines_of(page_of(tmp_path, f'<text x="50" y="50" text-anchor="middle" {font}>HIH</text>')))
    right = box_of(lines_of(page_of(tmp_path, f'<text x="50" y="50" text-anchor="end" {font}>  HIH\n </text>')))
    width = left[2] - left[0]
    assert left[1] == pytest.approx(50 - 20 * 0.729, abs=0.1) and left[3] == pytest.approx(50, abs=0.05)
    assert 50 < left[0] < 53 and 30 < width < 42
    assert (middle[0] + middle[2]) / 2 == pytest.approx(50, abs=0.1)
    assert right[2] < 50 and right[2] == pytest.approx(100 - left[0], abs=0.1)
    turned = box_of(lines_of(page_of(tmp_path, f'<text transform="translate(9 9) rotate(90)" x="50" y="50" {font}>HIH</text>')))
    assert turned[3] - turned[1] == pytest.approx(width, abs=0.05)


def test_lines_runs_and_letters_of_text(tmp_path):
    page = page_of(tmp_path, '''<text x="10" y="20" font-size="10">
        <tspan x="10" y="20">II</tspan>
        <tspan x="10" dy="1.5em" font-size="20">I</tspan></text>''')
    boxes = [box_of([line]) for line in lines_of(page)]
    assert [round(box[3]) for box in boxes] == [20, 20, 50]  # y goes on from the line before: 1.5 of its own 20
    assert boxes[0][0] < boxes[1][0] and boxes[2][0] - 10 == pytest.approx(2 * (boxes[0][0] - 10), abs=0.1)
    page = page_of(tmp_path, '<text x="10 50 90" y="20" font-size="10">III<tspan dx="5">I</tspan></text>')
    lefts = [box_of([line])[0] for line in lines_of(page)]
    assert lefts[1] - lefts[0] == pytest.approx(40, abs=0.02) and lefts[2] - lefts[0] == pytest.approx(80, abs=0.02)
    step = box_of(lines_of(page_of(tmp_path, '<text font-size="10">II</text>'))[1:])[0] - box_of(
        lines_of(page_of(tmp_path, '<text font-size="10">II</text>'))[:1])[0]
    assert lefts[3] - lefts[2] == pytest.approx(step + 5, abs=0.05)
    spaced = lines_of(page_of(tmp_path, '<text font-size="10" letter-spacing="4">II</text>'))
    assert box_of(spaced[1:])[0] - box_of(spaced[:1])[0] == pytest.approx(step + 4, abs=0.05)


def test_text_is_clipped_hidden_and_said_to_be_in_another_font(tmp_path):
    page = page_of(tmp_path, '''<clipPath id="c"><rect width="200" height="45"/></clipPath>
        <text clip-path="url(#c)" y="50" font-size="20">H</text><text visibility="hidden">H</text><text display="none">H</text>
        <text y="90" font-family="Nowhere Bold">$x$</text>''')
    assert box_of([line for line in lines_of(page) if line[0][1] < 60])[3] == pytest.approx(45, abs=0.03)
    assert [what for what in page.left_out] == ["the font Nowhere Bold, which is not on this computer (DejaVu Sans is drawn)"]
    assert len(lines_of(page)) >= 4  # a dollar sign is a letter


def test_text_falls_on_the_outlines_that_matplotlib_writes_of_it(tmp_path):
    """The same figure with its text as text and as paths: turned, centred, at the right edge, of several sizes."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    layers = []
    for kind in ("none", "path"):
        with plt.rc_context({"svg.fonttype": kind, "font.family": "DejaVu Sans", "text.parse_math": False}):
            figure = plt.figure(figsize=(4, 3))
            figure.patch.set_visible(False)
            figure.text(0.5, 0.8, "Título em $português$", ha="center", size=14)
            figure.text(0.9, 0.6, "right aligned", ha="right", weight="bold")
            figure.text(0.1, 0.1, "Steigung", rotation=30, style="italic")
            figure.savefig(tmp_path / f"{kind}.svg")
            plt.close(figure)
        layers.append([line for lines in SvgFile(tmp_path / f"{kind}.svg").outlines(0.01).layers.values() for line in lines])
    text, path = layers
    assert len(text) == len(path) > 60
    for one, other in zip(text, path):
        centres = [(line.real.min() + line.real.max() + 1j * (line.imag.min() + line.imag.max())) / 2 for line in (one, other)]
        assert abs(centres[0] - centres[1]) < 0.5  # px: a layout in whole pixels and one in fractions


# --- the rest


def test_what_is_not_drawn_is_said(tmp_path):
    page = page_of(tmp_path, '''
        <image width="9" height="9"/><image width="9" height="9"/><foreignObject/><flowRoot/>
        <text font-size="60"><textPath href="#p">along it</textPath></text><text><textPath href="#gone">along</textPath></text>
        <mask id="m"><path d="M0 0H9"/></mask><marker id="k"><path d="M0 0H9"/></marker><pattern><path d="M0 0H9"/></pattern>
        <path id="p" mask="url(#m)" marker-end="url(#k)" d="M0 0H9"/><path clip-path="url(#gone)" d="M0 1H9"/>
        <path d="M0 2H9 L5"/><rect stroke="none" width="5" height="5"/><g transform="turn(3)"><path d="M0 4H9"/></g>
        ''')
    assert page.left_out == {
        "picture": 2, "text or other content that is not SVG": 1, "text in a frame (convert it to text or to paths)": 1,
        "letters beyond the end of their path": 7, "text along a path that is not in the file": 1, "mask": 1, "marker (arrow head)": 1, "clip path that is not in the file": 1,
        "rest of a path behind a mistake in it": 1, "transform that cannot be read": 1,
    }  # fmt: skip
    assert page.unseen == 1 and len(lines_of(page)) == 4
    assert lines_of(page)[:3] == [[(0, 0), (9, 0)], [(0, 1), (9, 1)], [(0, 2), (9, 2)]]
    plan = drawing.load(tmp_path / "a.svg", boards.load("plotter_2014"))
    assert any("2 × picture" in note and "mask" in note for note in plan.notes)
    assert any("1 × a shape that nobody sees" in note for note in plan.notes)


@pytest.mark.parametrize("what, lines, left_out", [
    ('<polyline points="1,1 5,5 nan,7 9,9"/>', [[(1, 1), (5, 5)]], {"rest of a path behind a mistake in it": 1}),
    ('<polygon points="1,1 5,5 1,5 inf 7"/>', [[(1, 1), (5, 5), (1, 5), (1, 1)]], {"rest of a path behind a mistake in it": 1}),
    ('<path d="M1 1L5 5LNaN 7L8 8"/>', [[(1, 1), (5, 5)]], {"rest of a path behind a mistake in it": 1}),
    ('<line x1="nan" y1="2" x2="5" y2="Infinity"/>', [[(0, 2), (5, 0)]], {"number that is none, or that cannot be read": 2}),
    ('<line x1="2" y1="2" x2="five" y2="5px" stroke-dasharray="none"/>', [[(2, 2), (0, 5)]], {"number that is none, or that cannot be read": 1}),
    ('<g transform="translate(nan)"><path d="M1 1L5 5"/></g>', [[(1, 1), (5, 5)]], {"transform that cannot be read": 1}),
    ('<rect x="1" y="1" width="2" height="2" rx="auto" ry=" "/>', [[(1, 1), (3, 1), (3, 3), (1, 3), (1, 1)]], {}),
    ('<polyline points=" 1,1-3-.5.5,1e1,2 "/>', [[(1, 1), (-3, -0.5), (0.5, 10)]], {"rest of a path behind a mistake in it": 1}),
])  # fmt: skip
def test_numbers_that_are_none_are_said(tmp_path, what, lines, left_out):
    page_of(tmp_path, what)
    file = SvgFile(tmp_path / "a.svg")
    for _ in range(2):  # shapes are read once
        page = file.outlines(0.01)
        assert page.left_out == left_out
        assert [[(round(x, 6), round(y, 6)) for x, y in line] for line in lines_of(page)] == lines


def test_styles_hide_and_paint(tmp_path):
    page = page_of(tmp_path, '''<style>.h{display:none} #v, path.w{visibility:hidden} /* line { display: none } */
        .d { stroke-dasharray: 5 }</style>
        <path class="a h" d="M0 0H9"/><path id="v" d="M0 1H9"/><path class="w" d="M0 2H9"/>
        <g visibility="hidden"><path style="visibility:visible" d="M0 3H9"/><path d="M0 4H9"/></g>
        <path class="d" style="stroke-dasharray:none !important" d="M0 5H9"/><path class="d" d="M0 6H9"/>
        <switch><path requiredExtensions="x" d="M0 7H9"/><path d="M0 8H9"/><path d="M0 9H9"/></switch>
        <a><path d="M0 10H9"/></a><x:y xmlns:x="else"><path d="M0 11H9"/></x:y>''')
    assert [line[0][1] for line in lines_of(page)] == [3, 5, 6, 8, 10]


def test_shapes_curves_and_dots(tmp_path):
    page = page_of(tmp_path, '''<circle cx="50" cy="50" r="20"/><ellipse cx="50" cy="50" rx="10" ry="30"/>
        <rect x="10" y="10" width="40" height="20" rx="500"/><polyline points="1,2 3,4"/><polygon points="1 2 3 4 5,0"/>
        <path stroke-linecap="round" d="M7 7h0"/><path d="M8 8h0"/><path d="M9 9"/><circle r="0"/><path/>''')
    circle, ellipse, rect, *rest = page.layers[1]
    assert abs(abs(circle - (50 + 50j)) - 20).max() < 0.011 and circle[0] == circle[-1]
    middles = (circle[1:] + circle[:-1]) / 2
    assert abs(abs(middles - (50 + 50j)) - 20).max() < 0.011
    assert box_of(lines_of(page)[1:2]) == (40, 20, 60, 80)
    assert box_of(lines_of(page)[2:3]) == (10, 10, 50, 30)
    assert lines_of(page)[3:] == [[(1, 2), (3, 4)], [(1, 2), (3, 4), (5, 0), (1, 2)], [(7, 7), (7, 7)]]


@settings(max_examples=60, deadline=None)
@given(st.lists(st.builds(complex, st.integers(0, 100), st.integers(0, 100)), min_size=4, max_size=4), st.sampled_from([0.3, 0.03]))
def test_chords_keep_their_distance_from_curves(places, deviation):
    a, b, c, d = (f"{place.real} {place.imag}" for place in places)
    t = numpy.linspace(0, 1, 400)
    p, q, r, s = places
    cubic = (1 - t) ** 3 * p + 3 * (1 - t) ** 2 * t * q + 3 * (1 - t) * t**2 * r + t**3 * s
    quadratic = (1 - t) ** 2 * p + 2 * (1 - t) * t * q + t**2 * r
    for data, curve in ((f"M{a}C{b} {c} {d}", cubic), (f"M{a}Q{b} {c}", quadratic)):
        segments, whole = svg_path.read(data)
        (line,) = svg_geometry.flatten_segments(segments, deviation)
        assert whole
        assert max(min(distance(place, *pair) for pair in zip(line, line[1:])) for place in curve) <= deviation + 1e-9


def test_layers_have_vpype_s_numbers_and_lose_nothing(tmp_path):
    ink = 'xmlns:i="http://www.inkscape.org/namespaces/inkscape"'
    page = page_of(tmp_path, f'''<g id="layer1" i:label="Cut 7" {ink}><g id="layer9"><path d="M0 0H1"/></g></g>
        <g id="layer2"><path d="M0 0H2"/></g><g id="zero0"><path d="M0 0H3"/></g><g><path d="M0 0H4"/></g>
        <path id="p" d="M0 0H5"/><use href="#p" y="1"/><g id="layer5" display="none"><path d="M0 0H6"/></g>''')
    assert {number: [line[1][0] for line in lines_of(page, number)] for number in page.layers} == {
        7: [1], 2: [2], 1: [3, 5, 5], 4: [4]
    }
    assert page.names == {7: "Cut 7", 2: "layer2", 1: "zero0"}


def test_files_that_are_no_svg(tmp_path):
    path = tmp_path / "a.svg"
    for text, said in (("G1 X1", "not an SVG file"), ("<html/>", "begins with <html>"), ("", "not an SVG file")):
        path.write_text(text)
        with pytest.raises(Failure, match=said):
            SvgFile(path)
    with pytest.raises(Failure, match="not an SVG file|Is a directory"):
        SvgFile(tmp_path)


def test_progress_is_told(tmp_path):
    path = tmp_path / "a.svg"
    path.write_text(HEAD + 'stroke="black">' + '<path d="M0 0H9"/>' * 1000 + "</svg>")
    shares = []
    SvgFile(path).outlines(0.1, shares.append)
    assert len(shares) > 10 and shares == sorted(shares) and 0 < shares[0] < 0.2 and 0.9 < shares[-1] <= 1
    assert math.isclose(SvgFile(path).size_px[0], 200)
