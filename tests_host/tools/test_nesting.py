"""Nesting and hatching, judged by shapely."""

import csv
import math

import numpy
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely import affinity
from typer.testing import CliRunner

from host_tools.cli.main import app
from host_tools.drawings import hatch, nesting
from host_tools.failure import Failure

ANGLES = st.floats(0, 2 * math.pi)
SHAPES = st.lists(st.tuples(ANGLES, st.floats(5, 40)), min_size=3, max_size=8).map(
    lambda corners: shapely.Polygon([(r * math.cos(a), r * math.sin(a)) for a, r in corners]).buffer(0)
).filter(lambda shape: shape.area > 20)  # fmt: skip


@settings(max_examples=25, deadline=None)
@given(st.lists(SHAPES, min_size=1, max_size=6), st.sampled_from([0.0, 1.0, 3.7]), st.booleans(), st.sampled_from([0, 1, 417]))
def test_nested_shapes_keep_their_distance_and_the_sheet(shapes, gap, turn, order):
    width, height = 200.0, 150.0
    try:
        spots = nesting.nest_shapes(shapes, width, height, gap, turn, order)
    except Failure:
        assume(False)
    placed = [affinity.translate(nesting.turn_shape(shape, quarters), x, y) for shape, (x, y, quarters) in zip(shapes, spots)]
    sheet = shapely.box(-1e-6, -1e-6, width + 1e-6, height + 1e-6)
    for index, shape in enumerate(placed):
        assert sheet.contains(shape)
        assert all(shape.distance(other) >= max(gap, 1e-9) for other in placed[:index])
        assert turn or not spots[index][2]


def test_shapes_lie_in_each_other_s_bays():
    """Ten corners of angle iron: the shapes lie in each other, and the boxes need half as much again."""
    corner = shapely.Polygon([(0, 0), (60, 0), (60, 15), (15, 15), (15, 60), (0, 60)])
    shapes = [corner] * 10
    used, full = nesting.fullness(shapes, nesting.nest_shapes(shapes, 260, 1000, 1.0), 260)
    boxes = [shapely.box(0, 0, 60, 60)] * 10
    used_by_boxes, _ = nesting.fullness(boxes, nesting.nest_shapes(boxes, 260, 1000, 1.0), 260)
    assert used < 0.7 * used_by_boxes and full > 0.45


def test_a_wide_sheet_is_filled_in_a_low_strip():
    """Ten of them where six boxes have room side by side: each as low as it goes fills no bay, and takes the height of two boxes."""
    corner = shapely.Polygon([(0, 0), (60, 0), (60, 15), (15, 15), (15, 60), (0, 60)])
    spots = nesting.nest_shapes([corner] * 10, 380, 380, 3.0)
    used, _ = nesting.fullness([corner] * 10, spots, 380)
    assert used < 105


def test_each_number_is_an_order_of_its_own_and_always_the_same():
    shapes = [shapely.box(0, 0, 20 + 7 * number, 50 - 3 * number) for number in range(9)]
    found = [nesting.nest_shapes(shapes, 220, 220, 1.0, order=order) for order in range(8)]
    assert len({str(spots) for spots in found}) > 4
    assert found[:2] == [nesting.nest_shapes(shapes, 220, 220, 1.0, order=order) for order in range(2)]
    # As it was when this was written: a number that somebody has kept goes on to mean the same.
    assert [spot[:2] for spot in found[3]] == [(0.0, 68.0), (164.0, 0.0), (164.0, 29.0), (121.0, 0.0), (71.0, 0.0), (78.0, 43.0), (135.0, 65.0), (0.0, 0.0), (0.0, 40.0)]


def pieces(folder):
    """Files of drawings whose nesting hangs on their order."""
    made = []
    for number in range(7):
        width, height = 20 + 9 * number, 60 - 5 * number
        path = folder / f"{number}.svg"
        path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}mm" height="{height}mm" viewBox="0 0 {width} {height}"><path d="M0 0H{width}L0 {height}Z" fill="none" stroke="black"/></svg>')
        made.append(str(path))
    return made


def test_the_lowest_of_many_nestings_is_named_and_drawn_so(tmp_path):
    files, table = pieces(tmp_path), tmp_path / "table.csv"
    options = ["--board", "plotter_2014", "--gap", "2", "--margin", "60"]
    told = CliRunner().invoke(app, ["nest", *files, *options, "--tries", "8", "--workers", "2", "-o", str(table)])
    assert told.exit_code == 0, told.exception
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["nesting"] for row in rows] == [str(order) for order in range(8)]
    heights = {row["nesting"]: float(row["height_mm"]) for row in rows if not row["fault"]}
    assert len(set(heights.values())) > 2 and min(heights.values()) < heights["0"]
    best = told.stdout.splitlines()[-1].split("--nesting ")[1].split()[0]
    assert heights[best] == min(heights.values())
    for order in (best, "0"):
        drawn = CliRunner().invoke(app, ["draw", *files, *options, "--nesting", order, "--dry-run"])
        assert f"use {heights[order]:.0f} mm of its height" in drawn.output.replace("\n", " ")


def test_what_cannot_be_nested(tmp_path):
    files = pieces(tmp_path)
    for words, what in (
        ((files[0],), "several"), ((*files, "--workers", "2", "--dask", "tcp://127.0.0.1:1"), "give one of them"), ((*files, "--scale", "0"), "above 0"),
        ((*files, "-o", str(tmp_path / "a.txt")), "writes a table"), ((*files, "--scale", "5", "--tries", "2"), "no room for all of them in any order"),
    ):  # fmt: skip
        told = CliRunner().invoke(app, ["nest", *words])
        assert told.exit_code == 1 and what in str(told.exception), (words, told.exception)


@pytest.mark.slow
def test_nestings_on_a_cluster_are_those_of_this_pc(tmp_path):
    distributed = pytest.importorskip("distributed")
    files = pieces(tmp_path)
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, processes=True) as cluster:
        for name, words in (("here", ("--workers", "1")), ("there", ("--dask", cluster.scheduler_address))):
            told = CliRunner().invoke(app, ["nest", *files, "--gap", "2", "--margin", "60", "--tries", "12", *words, "-o", str(tmp_path / f"{name}.csv")])
            assert told.exit_code == 0, told.exception
    assert (tmp_path / "here.csv").read_text() == (tmp_path / "there.csv").read_text()


def test_no_room_is_told():
    with pytest.raises(Failure, match="no room on the sheet of 50 × 50 mm for all 2 drawings with 2 mm"):
        nesting.nest_shapes([shapely.box(0, 0, 40, 40)] * 2, 50, 50, 2)


@settings(max_examples=25, deadline=None)
@given(SHAPES, st.floats(-180, 180), st.floats(0.5, 5), st.booleans())
def test_hatches_lie_in_their_area_and_leave_no_strip(area, angle, spacing, crossed):
    lines = hatch.hatch_lines([area], hatch.Rule(angle, spacing, crossed))
    drawn = shapely.unary_union([shapely.LineString([(place.real, place.imag) for place in line]) for line in lines])
    assert area.buffer(1e-6).contains(drawn)
    assert area.buffer(-spacing * 0.51).difference(drawn.buffer(spacing * 0.51)).area < 1e-6
    assert drawn.length == pytest.approx((1 + crossed) * area.area / spacing, rel=0.2, abs=8 * area.length / 4)
    ways = {round(float(numpy.angle((line[-1] - line[0]) ** 2, deg=True)) / 2 % 180, 3) for line in lines if abs(line[-1] - line[0]) > 0.1}
    assert all(min(abs(way - wanted) % 180, 180 - abs(way - wanted) % 180) < 0.01 for way in ways for wanted in [angle % 180] if not crossed)


@pytest.mark.parametrize("text", ["45", "45,0", "45,1,twice", "a:45,1", "45,1,crossed,2", "nan,1", "45,nan"])
def test_hatches_that_cannot_be(text):
    with pytest.raises(Failure, match="--hatch wants"):
        hatch.parse_rules([text])


def test_hatches_by_layer():
    assert hatch.parse_rules(["45,1", "2:0,0.5,crossed"]) == {0: (45, 1, False), 2: (0, 0.5, True)}
    assert hatch.parse_rules(None) == {}
