"""From SVG files to points in steps, and `passo draw` itself against the virtual board."""

import json
import math
import pprint
import re
import signal
import subprocess
import sys
import time
from collections import Counter
from functools import cache
from pathlib import Path

import numpy
import pytest
import svgelements
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import STRtree
from shapely import points as shapely_points

from host_tools import boards, interpreter
from host_tools.clients.grbl import GrblClient
from host_tools.drawings import contours, drawing
from host_tools.drawings.drawing import Options
from host_tools.failure import Failure
from host_tools.programs import estimate
from passo.config.boardfile import check as checked

ROOT = Path(__file__).resolve().parents[2]
NEAR_MM = 0.5


@cache
def plotter_board():
    return boards.load("plotter_2014")


def svg(tmp_path, body, attributes='width="100mm" height="100mm" viewBox="0 0 100 100"'):
    path = tmp_path / "a.svg"
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {attributes}><g stroke="black">{body}</g></svg>')
    return path


def outline_samples(path, every_mm, mm_per_px):
    """Points along every outline of the file, in px, one array a segment: svgelements' own curves, not vpype's."""
    arrays = []
    parsed = svgelements.SVG.parse(str(path))
    for element in parsed.elements(lambda item: isinstance(item, svgelements.Shape)):
        for segment in svgelements.Path(element):
            if isinstance(segment, svgelements.Move) or segment.start is None or segment.end is None:
                continue
            count = max(9, math.ceil(segment.length(error=1e-4) * mm_per_px / every_mm) + 1)
            arrays.append(numpy.asarray(segment.npoint(numpy.linspace(0, 1, count)), dtype=float).reshape(-1, 2))
    return arrays, (parsed.width, parsed.height)


def sampled(line, every_mm):
    """The points of a polyline, and points in between, at most `every_mm` apart."""
    along = numpy.concatenate(([0], numpy.cumsum(numpy.hypot(*numpy.diff(line, axis=0).T))))
    places = numpy.union1d(along, numpy.arange(0, along[-1], every_mm))
    return numpy.column_stack([numpy.interp(places, along, line[:, axis]) for axis in (0, 1)])


def farthest_mm(points, lines):
    """The largest distance of `points` from the nearest of `lines`, arrays of points each; at most 0.1 mm too large
    where that is small, because the lines are sampled every 0.2 mm."""
    samples = numpy.concatenate([sampled(line, 0.2) for line in lines])
    tree = STRtree(shapely_points(samples))
    return tree.query_nearest(shapely_points(numpy.asarray(points)), return_distance=True, all_matches=False)[1].max()


def drawn_and_outlines(path, options):
    """Drawn lines in mm, and the outlines' points and lines where the machine should have put them."""
    plan = drawing.load(path, plotter_board(), options)
    drawn = [numpy.array(line) / 10 for line in plan.lines]
    arrays, (width, height) = outline_samples(path, 1.0, plan.mm_per_px)
    left, bottom = plan.corner_px
    points, lines = [], []
    for array in arrays:
        inside = numpy.ones(len(array), dtype=bool)
        if options.crop:
            inside = (array >= 0).all(axis=1) & (array <= (width, height)).all(axis=1)
        placed = numpy.column_stack((array[:, 0] - left, bottom - array[:, 1])) * plan.mm_per_px + plan.origin_mm
        points.append(placed[inside])
        lines.append(placed)
    return plan, drawn, numpy.concatenate(points), lines


LONG = ("vpype_300_beziers", "vpype_900_quad_beziers")
FILES = [
    "cncjs_jsdc", *LONG, "vpype_all_shapes", "vpype_arc_with_rotate",
    "vpype_few_beziers", "vpype_multilayer_by_attributes", "vpype_no_size_viewbox", "vpype_plotter",
]


@pytest.mark.parametrize("options", [Options(), Options(fit=True, place="outlines", crop=False)], ids=["page", "fit"])
@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow if name in LONG else ()) for name in FILES])
def test_real_files_are_drawn_within_half_a_millimetre(corpus, name, options):
    plan, drawn, outline, outlines = drawn_and_outlines(corpus / f"{name}.svg", options)
    assert farthest_mm(outline, drawn) <= NEAR_MM
    inked = numpy.concatenate([sampled(line, 2) for line in drawn])
    assert farthest_mm(inked, outlines) <= NEAR_MM
    xs, ys = zip(*(point for line in plan.lines for point in line))
    assert 0 <= min(xs) and max(xs) <= 4000 and 0 <= min(ys) and max(ys) <= 3000


def test_every_real_svg_is_tried(corpus):
    assert sorted(path.stem for path in corpus.glob("*.svg")) == sorted(FILES + ["vpype_empty"])


def test_an_empty_file_is_a_clear_error(corpus):
    with pytest.raises(Failure, match="vpype_empty.svg: nothing to draw: the file has no lines"):
        drawing.load(corpus / "vpype_empty.svg", plotter_board())


@pytest.mark.parametrize("body, message", [
    ('<image width="9" height="9"/>', "of what it has, nothing can be drawn: picture"),
    ('<line x1="200" y1="200" x2="300" y2="200"/>', "outside the page"),
    ("", "no lines, curves or shapes"),
])
def test_nothing_to_draw_says_why(tmp_path, body, message):
    with pytest.raises(Failure, match=message):
        drawing.load(svg(tmp_path, body), plotter_board())


def test_no_svg_is_a_clear_error(tmp_path):
    with pytest.raises(Failure, match="no file"):
        drawing.load(tmp_path / "none.svg", plotter_board())
    (tmp_path / "b.svg").write_text("G1 X10")
    with pytest.raises(Failure, match="not an SVG file"):
        drawing.load(tmp_path / "b.svg", plotter_board())


def test_real_size_is_kept_and_y_points_up_from_the_page_s_lower_edge(tmp_path):
    path = svg(tmp_path, '<path d="M10 10 H30 V50"/>')
    plan = drawing.load(path, plotter_board(), Options(origin=(20, 30)))
    assert plan.scale == 1
    assert plan.lines in ([[(300, 1200), (500, 1200), (500, 800)]], [[(500, 800), (500, 1200), (300, 1200)]])
    plan = drawing.load(path, plotter_board(), Options(origin=(20, 30), place="outlines"))
    assert plan.lines in ([[(200, 700), (400, 700), (400, 300)]], [[(400, 300), (400, 700), (200, 700)]])


def size_of(box):
    return box[2] - box[0], box[3] - box[1]


def test_placement_options(tmp_path):
    path = svg(tmp_path, '<rect x="10" y="10" width="80" height="60"/>')
    plan = drawing.load(path, plotter_board())
    assert plan.page_mm == pytest.approx((0, 0, 100, 100)) and plan.box_mm == pytest.approx((10, 30, 90, 90))
    assert drawing.load(path, plotter_board(), Options(center=True)).page_mm == pytest.approx((150, 100, 250, 200))
    assert drawing.load(path, plotter_board(), Options(center=True, place="outlines")).box_mm == pytest.approx((160, 120, 240, 180))
    fitted = drawing.load(path, plotter_board(), Options(fit=True, margin=20))
    assert fitted.page_mm == pytest.approx((70, 20, 330, 280))
    fitted = drawing.load(path, plotter_board(), Options(fit=True, margin=20, place="outlines"))
    assert size_of(fitted.box_mm) == pytest.approx((260 * 80 / 60, 260))
    half = drawing.load(path, plotter_board(), Options(scale=0.5))
    assert half.box_mm == pytest.approx((5, 15, 45, 45))
    with pytest.raises(Failure, match="leaves the table of 400 × 300 mm"):
        drawing.load(path, plotter_board(), Options(scale=10))
    with pytest.raises(Failure, match="leaves the table"):
        drawing.load(path, plotter_board(), Options(origin=(330, 0)))
    with pytest.raises(Failure, match="margin"):
        drawing.load(path, plotter_board(), Options(margin=150, fit=True))
    with pytest.raises(Failure, match="page or outlines"):
        drawing.load(path, plotter_board(), Options(place="paper"))


def page_of(tmp_path, width, height, body, name="page.svg", unit="mm"):
    path = tmp_path / name
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}{unit}" height="{height}{unit}" '
        f'viewBox="0 0 {width} {height}"><g stroke="black" fill="none">{body}</g></svg>'
    )
    return path


def test_what_is_too_large_is_reduced_and_says_so(tmp_path):
    path = page_of(tmp_path, 1000, 1000, '<rect x="0" y="0" width="1000" height="1000"/>')
    plan = drawing.load(path, plotter_board())
    assert plan.page_mm == plan.box_mm == pytest.approx((0, 0, 300, 300))
    assert "does not fit the table of 400 × 300 mm: drawn at 30.0 %" in plan.notes[0]


@pytest.mark.parametrize("width", [400.0, 400.04, 400.11, 400.3, 402, 440])
def test_a_page_a_little_too_large_is_not_said_to_be_drawn_at_a_hundred_per_cent(tmp_path, width):
    plan = drawing.load(page_of(tmp_path, width, 200, f'<rect width="{width}" height="200"/>'), plotter_board())
    if width - 400 < 0.05:  # half a step
        assert plan.scale == 1 and not plan.notes
    else:
        assert plan.scale == pytest.approx(400 / width)
        said = float(re.search(r"drawn at ([\d.]+) %", plan.notes[0])[1])
        assert said < 100 and said == pytest.approx(plan.scale * 100, abs=0.05)


def test_a_page_larger_than_the_table_keeps_its_size_if_its_lines_are_on_the_table(tmp_path):
    plan = drawing.load(page_of(tmp_path, 420, 297, '<rect x="20" y="20" width="370" height="257"/>'), plotter_board())
    assert plan.scale == 1 and plan.box_mm == pytest.approx((20, 20, 390, 277)) and not plan.notes


FRAMES = [
    (100, 100, "mm"), (210, 297, "mm"), (297, 210, "mm"), (148, 210, "mm"), (200, 150, "mm"), (380, 280, "mm"),
    (105, 148, "mm"), (400, 300, "mm"), (8.5, 11, "in"), (5.5, 8.5, "in"), (1000, 1000, "px"), (793.7, 1122.5, "px"),
    (595.28, 841.89, "pt"), (21, 29.7, "cm"), (33.3, 77.7, "mm"), (0.1, 0.3, "in"),
]  # fmt: skip


@pytest.mark.parametrize("options", [Options(), Options(fit=True), Options(center=True), Options(scale=0.37)],
                         ids=["page", "fit", "center", "scale"])  # fmt: skip
@pytest.mark.parametrize("width, height, unit", FRAMES)
def test_a_frame_on_the_edge_of_its_page_has_four_sides(tmp_path, width, height, unit, options):
    plan = drawing.load(page_of(tmp_path, width, height, f'<rect width="{width}" height="{height}"/>', unit=unit), plotter_board(), options)
    left, bottom, right, top = (round(10 * side) for side in plan.page_mm)
    right, top = min(right, 4000), min(top, 3000)
    sides = {frozenset(side) for line in plan.lines for side in zip(line, line[1:])}
    corners = [(left, bottom), (right, bottom), (right, top), (left, top)]
    assert sides == {frozenset(side) for side in zip(corners, corners[1:] + corners[:1])}


def test_lines_a_hair_outside_the_page_are_drawn_on_its_edge_and_others_cut_there(tmp_path):
    body = '<path d="M-0.08 10 V50 M100.09 10 V50 M10 100.05 H50 M10 -0.05 H50 M-0.2 60 V90 M60 60 L140 60"/>'
    plan = drawing.load(page_of(tmp_path, 100, 100, body), plotter_board())
    assert {frozenset(line) for line in plan.lines} == {
        frozenset(line) for line in [((0, 900), (0, 500)), ((1000, 900), (1000, 500)), ((100, 0), (500, 0)),
                                     ((100, 1000), (500, 1000)), ((600, 400), (1000, 400))]
    }  # fmt: skip
    assert "70 mm of lines lie outside the page" in plan.notes[0]


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(st.integers(1, 3), st.lists(st.tuples(st.integers(-20, 220), st.integers(-20, 170)), min_size=2,
                                                  max_size=5)), min_size=1, max_size=6),
    st.sampled_from([{}, {"fit": True}, {"center": True}, {"scale": 0.7}, {"origin": (31, 17)},
                     {"place": "outlines", "fit": True}, {"place": "outlines"}, {"place": "outlines", "center": True}]),
)  # fmt: skip
def test_layers_drawn_one_after_the_other_fall_on_each_other(tmp_path_factory, lines, placed):
    """The ink of all layers drawn one by one is the ink of the whole, to the step."""
    groups = [
        f'<g id="layer{number}" stroke="black"><path d="M{" L".join(f"{x} {y}" for x, y in line)}"/></g>' for number, line in lines
    ]
    path = page_of(tmp_path_factory.mktemp("layers"), 200, 150, f"</g>{''.join(groups)}<g>")
    try:
        whole = drawing.load(path, plotter_board(), Options(**placed))
    except Failure as nothing:
        assert "nothing to draw" in str(nothing)
        return
    alone = [drawing.load(path, plotter_board(), Options(layers=(number,), **placed)) for number in whole.layers]
    ink = [frozenset(pair) for plan in alone for line in plan.lines for pair in zip(line, line[1:])]
    assert set(ink) == {frozenset(pair) for line in whole.lines for pair in zip(line, line[1:])}
    assert {(plan.scale, plan.origin_mm, plan.page_mm) for plan in alone} == {(whole.scale, whole.origin_mm, whole.page_mm)}


def test_layers_are_drawn_in_their_order_or_alone(tmp_path):
    path = tmp_path / "layers.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100" stroke="black">'
        '<g id="layer2"><path d="M0 90 H10"/></g><g id="layer1"><path d="M0 10 H20"/></g></svg>'
    )
    lengths = [abs(line[0][0] - line[1][0]) for line in drawing.load(path, plotter_board()).lines]
    assert lengths == [200, 100]
    assert len(drawing.load(path, plotter_board(), Options(layers=(2,))).lines) == 1
    with pytest.raises(Failure, match="no layer 3; it has 1, 2"):
        drawing.load(path, plotter_board(), Options(layers=(3,)))


def test_lines_are_joined_ordered_and_free_of_repeats(tmp_path):
    rows = "".join(f'<path d="M{x} {y} h10"/>' for y in range(0, 100, 5) for x in (20, 0, 10, 30))
    plan = drawing.load(svg(tmp_path, rows), plotter_board())
    assert len(plan.lines) == 20
    down, up = plan.lengths_mm()
    assert down == pytest.approx(800)
    assert up < 330  # the way there, and 5 mm from each row to the next
    for line in plan.lines:
        assert all(a != b for a, b in zip(line, line[1:]))


def test_a_dot_stays_a_dot(tmp_path):
    plan = drawing.load(svg(tmp_path, '<path d="M10 10 l0.001 0"/>'), plotter_board())
    assert len(plan.lines) == 1 and len(plan.lines[0]) == 2 and plan.lines[0][0] == plan.lines[0][1]


@pytest.mark.parametrize("most", [2, 3, 7, 50, 1000])
def test_objects_hold_every_line_and_no_more_points_than_asked(tmp_path, most):
    body = '<circle cx="50" cy="50" r="40"/>' + "".join(f'<path d="M{x} 5 v6 h2"/>' for x in range(0, 90, 9))
    plan = drawing.load(svg(tmp_path, body), plotter_board())
    objects = plan.objects(most)
    assert max(len(points) for points in objects) <= most
    assert all(not points[0][0] for points in objects)
    wanted = [pair for line in plan.lines for pair in zip(line, line[1:])]
    assert [(a[1:], b[1:]) for points in objects for a, b in zip(points, points[1:]) if b[0]] == wanted


STEPS = st.lists(st.lists(st.tuples(st.integers(0, 9000), st.integers(0, 9000)), min_size=2, max_size=6), max_size=8)


@given(STEPS, st.sampled_from(["plotter_2014", "plotter_esp32", "corexy_plotter"]))
def test_the_time_of_lines_is_that_of_their_objects(lines, board):
    times = estimate.Estimate(checked(boards.load(board)))
    assert times.lines_s(lines) == pytest.approx(sum(sum(times.object_s(points)) for points in drawing._cut_objects(lines, sys.maxsize)))


@given(st.lists(st.integers(2, 3500), min_size=1, max_size=6), st.integers(0, 99))
def test_thin_lines_keep_their_ends_and_their_course(counts, seed):
    """Pieces of a long line are thinned one by one: none gets lost, and none joins another line."""
    chance = numpy.random.default_rng(seed)
    lines = [numpy.cumsum(chance.normal(size=count) + 1j * chance.normal(size=count)) for count in counts]
    for line, thin in zip(lines, drawing._simplify_lines(lines, 0.5), strict=True):
        assert thin[0] == line[0] and thin[-1] == line[-1]
        kept = numpy.flatnonzero(numpy.isin(line, thin))
        assert (line[kept] == thin).all() and set(range(0, len(line), drawing._PIECE)) <= set(kept.tolist()) | ({0} if len(line) < 3 else set())
        chords = [(line[a], line[b], line[a : b + 1]) for a, b in zip(kept, kept[1:])]
        assert all(far_from_chord(a, b, between) <= 0.5 + 1e-9 for a, b, between in chords)


def far_from_chord(a, b, places):
    way = b - a
    share = numpy.clip(((places - a) * way.conjugate()).real / abs(way) ** 2, 0, 1)
    return abs(places - a - share * way).max()


def test_a_line_that_lies_on_itself_is_thinned_soon():
    """All its points at once took time by their square."""
    line = numpy.tile(100 * numpy.exp(2j * numpy.pi * numpy.arange(100) / 100), 5000)
    begun = time.process_time()
    (thin,) = drawing._simplify_lines([line], 0.01)
    assert time.process_time() - begun < 3 and len(thin) > 400_000  # 0.2; at once 12


def test_the_digest_tells_drawings_and_places_apart(tmp_path):
    path = svg(tmp_path, '<circle cx="50" cy="50" r="40"/>')
    digest = drawing.load(path, plotter_board()).digest(1000)
    assert drawing.load(path, plotter_board()).digest(1000) == digest
    assert drawing.load(path, plotter_board(), Options(origin=(1, 1))).digest(1000) != digest
    assert drawing.load(path, plotter_board()).digest(10) != digest


def test_the_contour_map_is_a_real_drawing(tmp_path):
    contours.save_contours(tmp_path / "map.svg")
    plan = drawing.load(tmp_path / "map.svg", plotter_board())
    assert plan.count_points() >= 5000
    assert plan.scale == 1
    assert size_of(plan.page_mm)[0] < 380 and size_of(plan.page_mm)[1] < 280


@pytest.fixture
def start():
    """Starts `passo …` as a process of its own; ends those still running after the test."""
    processes = []

    def run(*words, **options):
        command = [*interpreter.passo(), *map(str, words)]
        process = subprocess.Popen(command, text=True, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, **options)
        processes.append(process)
        return process

    yield run
    for process in processes:
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)


def port_of(process):
    return re.match(r"port: (\S+)", process.stdout.readline()).group(1)


def ink(trace):
    """Every place that the pen touched, in order, from the rows of a trace."""
    from host_tools.sim.measure import read_trace

    return [(row.x, row.y) for row in read_trace(trace) if row.tool]


def test_a_drawing_broken_off_by_ctrl_c_is_continued(tmp_path, start):
    path = svg(tmp_path, "".join(f'<path d="M0 {y} h40"/>' for y in range(0, 12, 3)))
    options = ["--speed", "200", "--origin", "5,5"]
    whole, parts = tmp_path / "whole.csv", tmp_path / "parts.csv"

    board = start("board", "--time", "fast", "--start", "30,20", "--trace", whole)
    assert start("draw", path, "--port", port_of(board), *options).wait(60) == 0
    board.send_signal(signal.SIGTERM)
    assert board.wait(10) == 0

    board = start("board", "--time", "real", "--start", "30,20", "--trace", parts)
    port = port_of(board)
    first = start("draw", path, "--port", port, *options)
    deadline = time.monotonic() + 120
    while parts.read_text().count(",1000\n") < 700 and time.monotonic() < deadline:
        time.sleep(0.1)
    first.send_signal(signal.SIGINT)
    assert first.wait(10) == 1
    assert "go on with the same command and --continue" in first.communicate()[1]

    moved = start("draw", path, "--port", port, "--speed", "200", "--origin", "6,5", "--continue")
    assert moved.wait(20) == 1
    assert "cannot continue: the drawing or its placement" in moved.communicate()[1]

    assert start("draw", path, "--port", port, *options, "--continue").wait(60) == 0
    board.send_signal(signal.SIGTERM)
    assert board.wait(10) == 0
    assert not Path(str(path) + ".journal").exists()

    wanted, done = ink(whole), ink(parts)
    assert set(done) == set(wanted)
    assert len(wanted) - 20 <= len(done) < len(wanted) + 500  # no more than one line drawn a second time


def amid_a_line(ask, least, most):
    """Wait until a line is drawn to the right and `ask()`, the pen's x, is amid it."""
    before = math.inf
    for _ in range(2000):
        here = ask()
        if before < here and least < here < most:
            return
        before = here
        time.sleep(0.02)
    raise AssertionError(f"no line is drawn: {here}")


def stop_amid_a_line(port, steps_per_mm):
    from host_tools.clients.plotter import PlotterClient

    with PlotterClient(port) as client:
        amid_a_line(lambda: client.status()["x"], 8 * steps_per_mm, 20 * steps_per_mm)
        client.stop()


def hold_and_reset_amid_a_line(port, _):
    """As somebody at another sender does."""
    with GrblClient(port, 115200) as client:
        amid_a_line(lambda: float(client.ask_status()["MPos"].split(",")[0]), 8, 20)
        client.real_time(b"!")
        while not client.ask_status()["state"].startswith("Hold:0"):
            time.sleep(0.05)
        client.reset()


@pytest.mark.parametrize("name, language, options, out, unlocked, stop", [
    ("plotter_2014", "plotter", ("--speed", "1000"), "--packets", (), stop_amid_a_line),
    ("laser_xy", "grbl", ("--feed", "3000", "--power", "300"), "-o", ("--unlock",), hold_and_reset_amid_a_line),
])  # fmt: skip
def test_a_stored_job_is_continued_amid_its_line(tmp_path, start, name, language, options, out, unlocked, stop):
    """The board's journal knows it; there is none beside the file. Each place is drawn."""
    path = svg(tmp_path, "".join(f'<path d="M2 {y} h30"/>' for y in range(2, 96, 3)))
    file, trace, job = tmp_path / "board.py", tmp_path / "t.csv", tmp_path / "job"
    file.write_text("BOARD = " + pprint.pformat({**boards.load(name), "jobs": {"language": language}, "journal": {"every_ms": 500}}))
    options = ("--board", file, *options)
    board = start("board", "--board", file, "--time", "real", "--start", "30,20", "--trace", trace)
    where = ("--port", port_of(board))
    assert start("draw", path, *options, out, job).wait(60) == 0
    assert start("jobs", "store", job, "--protocol", language, *where).wait(60) == 0
    if unlocked:
        with GrblClient(where[1], 115200) as client:
            client.command("$X")
    assert start("jobs", "run", "JOB", "--no-wait", "--protocol", language, *where).wait(60) == 0
    steps_per_m = boards.load(name)["axes"][0]["steps_per_m"]
    whole = 30 * steps_per_m // 1000
    deadline = time.monotonic() + 120
    while sum(not row.endswith(",0") for row in trace.read_text().splitlines()[1:-1]) < 3 * whole and time.monotonic() < deadline:
        time.sleep(0.05)
    stop(where[1], steps_per_m / 1000)
    assert 3 * whole < len(ink(trace)) < 31.5 * whole
    again = start("draw", path, *options, *where, *unlocked, "--continue", "--yes")
    assert again.wait(120) == 0 and "interrupted in " in again.communicate()[0]
    board.send_signal(signal.SIGTERM)
    assert board.wait(10) == 0  # the trace is whole
    drawn = Counter(ink(trace))
    rows = Counter(y for _, y in drawn)
    assert len(rows) == 32 and all(whole - 2 <= count <= whole + 1 for count in rows.values()), rows
    assert drawn.total() - len(drawn) < whole, "lines since the journal's last record may be drawn twice, no others"


def test_the_pen_that_draws_is_named_when_a_drawing_goes_on(tmp_path, start):
    path = svg(tmp_path, '<path d="M0 0 h20" stroke="red"/>' + "".join(f'<path d="M0 {y} h20" stroke="blue"/>' for y in range(3, 30, 3)))
    options = ["--speed", "200", "--pens", "colours"]
    board = start("board", "--time", "real", "--start", "30,20")
    port = port_of(board)
    first = start("draw", path, "--port", port, *options, stdin=subprocess.PIPE)
    first.stdin.write("\n")
    first.stdin.flush()
    wait_for_points(first, path, 8)
    first.send_signal(signal.SIGINT)
    assert first.wait(20) == 1
    again = start("draw", path, "--port", port, *options, "--continue", stdin=subprocess.PIPE)
    assert again.wait(60) == 0 and re.search("pen 2 .*draws on", again.communicate()[0])


def test_a_board_that_goes_away_leaves_a_journal_and_the_way_on(tmp_path, start):
    path = svg(tmp_path, "".join(f'<path d="M0 {y} h90"/>' for y in range(0, 96, 3)))
    board = start("board", "--time", "real", "--start", "30,20")
    drawing_ = start("draw", path, "--port", port_of(board), "--speed", "200", "--no-home")
    journal = Path(str(path) + ".journal")
    wait_for_points(drawing_, path, 5)
    board.kill()
    assert drawing_.wait(30) == 1
    kept = json.loads(journal.read_text())["drawn"]
    said = drawing_.communicate()[1]
    assert "went away" in said or "no answer" in said
    assert f"{kept} of 64 points drawn for certain" in said
    assert f"go on with the same command and --continue ({journal})" in said


def test_a_second_drawing_is_told_who_draws_and_the_first_goes_on(tmp_path, start):
    path = svg(tmp_path, "".join(f'<path d="M0 {y} h90"/>' for y in range(0, 96, 3)))
    board = start("board", "--time", "real", "--start", "30,20")
    port = port_of(board)
    first = start("draw", path, "--port", port, "--speed", "200", "--no-home")
    wait_for_points(first, path, 2)
    second = start("draw", path, "--port", port, "--journal", tmp_path / "other")
    assert second.wait(30) == 1
    assert f"port {port} is in use by passo draw {path}"[:80] in second.communicate()[1]
    wait_for_points(first, path, json.loads(Path(f"{path}.journal").read_text())["drawn"] + 2)
    first.send_signal(signal.SIGTERM)  # stops the machine too
    assert first.wait(20) == 1 and "pen up; go on with" in first.communicate()[1]


def wait_for_points(process, path, count):
    """Until the journal says that `count` points are drawn."""
    journal = Path(f"{path}.journal")
    deadline = time.monotonic() + 120
    while not (journal.exists() and json.loads(journal.read_text())["drawn"] >= count):
        assert time.monotonic() < deadline and process.poll() is None
        time.sleep(0.1)


def test_a_journal_that_cannot_be_written_is_noticed_before_the_port_is_opened(tmp_path, start):
    path = svg(tmp_path, '<path d="M0 0 h40"/>')
    process = start("draw", path, "--port", "/dev/nowhere", "--journal", tmp_path / "no" / "journal")
    assert process.wait(30) == 1
    assert "journal" in (said := process.communicate()[1]) and "cannot be written" in said and "nowhere" not in said


@pytest.mark.parametrize("board, spoken", [("torch_manipulator", "torch"), ("lpt_router", "pulses")])
def test_a_board_that_speaks_neither_language_is_refused(tmp_path, start, board, spoken):
    path = svg(tmp_path, '<path d="M0 0 h40"/>')
    for more in (["--dry-run"], ["--port", "/dev/nowhere"]):
        process = start("draw", path, "--board", board, *more)
        assert process.wait(30) == 1
        said = process.communicate()[1]
        assert f"board {board} speaks {spoken}: passo draw speaks to plotters, and in G-code" in said and len(said.splitlines()) == 1


def test_a_preview_has_table_page_and_time(tmp_path, monkeypatch, capsys):
    from test_plot import drawn_by

    from host_tools.cli import main as cli

    path = page_of(tmp_path, 100, 50, '<path d="M10 10 h80"/><image width="9" height="9"/>')
    monkeypatch.setattr(sys, "argv", ["passo", "draw", str(path), "--dry-run", "--preview", str(tmp_path / "a.png")])

    def run():
        with pytest.raises(SystemExit) as ended:
            cli.main()
        assert not ended.value.code

    seen = drawn_by(monkeypatch, run)
    assert {"table 400 × 300 mm", "page 100 × 50 mm"} <= set(seen["labels"])
    assert re.fullmatch(r"page.svg at 100.0 %, about 0:0\d", seen["title"])
    assert "picture" in capsys.readouterr().out


def test_send_shows_the_conversation_of_2014(start):
    board = start("board", "--time", "fast", "--start", "30,20")
    port = port_of(board)
    packets = ["REQUEST", "ORIGIN", "SPEED 1000", "MOVE 644 314", "LINE 644 454", "6c 03 74 01 c6 aa", "END", "STATUS"]
    output, errors = start("send", "--port", port, *packets).communicate(timeout=120)
    assert errors == ""
    lines = output.splitlines()
    for sent, received in [
        ("REQUEST [114, 0, 0, 0, 0, 114]", "REQUEST_OK [107]"),
        ("ORIGIN [111, 0, 0, 0, 0, 111]", "ORIGIN_OK [111]"),
        ("SPEED [115, 3, -24, 0, 0, 94]", "SPEED_OK [115]"),
        ("MOVE [109, 2, -124, 1, 58, 46]", "NEXT [110]"),
        ("LINE [108, 2, -124, 1, -58, -71]", "NEXT [110]"),
        ("LINE [108, 3, 116, 1, -58, -86]", "NEXT [110]"),
        ("END [101, 0, 0, 0, 0, 101]", "DONE [100]"),
    ]:
        assert any(sent in line and line.endswith(f"Received: {received}") for line in lines), sent
    assert "STATUS idle at 884, 454, 3 points drawn" in lines[-1]

    refused = start("send", "--port", port, "--timeout", "0.5", "LINE 5000 0")
    assert refused.wait(20) == 1
    assert "error 104" in refused.communicate()[1]


@pytest.mark.parametrize("words, message", [
    (["send", "--port", "/dev/nowhere", "REQUEST"], "cannot open port /dev/nowhere"),
    (["send", "--port", "x", "JUMP"], "'JUMP' is no packet"),
    (["send", "--port", "x", "OBJECT 1,2"], "OBJECT wants two points or more"),
    (["send", "--port", "x", "OBJECT 1,2 70000,3"], "OBJECT wants two points or more"),
    (["send", "--port", "x", "MOVE 1"], "MOVE wants 2 numbers from 0 to 65535, not 1"),
    (["draw", "none.svg", "--dry-run"], "no file none.svg"),
    (["draw", "none.svg", "--dry-run", "--board", "nix"], "unknown board 'nix'; known are"),
    (["plot", "none.csv"], "cannot read trace none.csv"),
])
def test_errors_are_one_line_and_a_non_zero_exit(start, words, message):
    process = start(*words)
    output, errors = process.communicate(timeout=120)
    assert process.returncode == 1
    assert message in errors and len(errors.splitlines()) == 1
