"""Nesting and hatching, judged by shapely."""

import math

import numpy
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely import affinity

from host_tools.drawings import hatch, nesting
from host_tools.failure import Failure

ANGLES = st.floats(0, 2 * math.pi)
SHAPES = st.lists(st.tuples(ANGLES, st.floats(5, 40)), min_size=3, max_size=8).map(
    lambda corners: shapely.Polygon([(r * math.cos(a), r * math.sin(a)) for a, r in corners]).buffer(0)
).filter(lambda shape: shape.area > 20)  # fmt: skip


@settings(max_examples=25, deadline=None)
@given(st.lists(SHAPES, min_size=1, max_size=6), st.sampled_from([0.0, 1.0, 3.7]), st.booleans())
def test_nested_shapes_keep_their_distance_and_the_sheet(shapes, gap, turn):
    width, height = 200.0, 150.0
    try:
        spots = nesting.nested(shapes, width, height, gap, turn)
    except Failure:
        assume(False)
    placed = [affinity.translate(nesting.turned(shape, quarters), x, y) for shape, (x, y, quarters) in zip(shapes, spots)]
    sheet = shapely.box(-1e-6, -1e-6, width + 1e-6, height + 1e-6)
    for index, shape in enumerate(placed):
        assert sheet.contains(shape)
        assert all(shape.distance(other) >= max(gap, 1e-9) for other in placed[:index])
        assert turn or not spots[index][2]


def test_shapes_lie_in_each_other_s_bays():
    """Ten corners of angle iron: the shapes lie in each other, and the boxes need half as much again."""
    corner = shapely.Polygon([(0, 0), (60, 0), (60, 15), (15, 15), (15, 60), (0, 60)])
    shapes = [corner] * 10
    used, full = nesting.fullness(shapes, nesting.nested(shapes, 260, 1000, 1.0), 260)
    boxes = [shapely.box(0, 0, 60, 60)] * 10
    used_by_boxes, _ = nesting.fullness(boxes, nesting.nested(boxes, 260, 1000, 1.0), 260)
    assert used < 0.7 * used_by_boxes and full > 0.45


def test_a_wide_sheet_is_filled_in_a_low_strip():
    """Ten of them where six boxes have room side by side: each as low as it goes fills no bay, and takes the height of two boxes."""
    corner = shapely.Polygon([(0, 0), (60, 0), (60, 15), (15, 15), (15, 60), (0, 60)])
    spots = nesting.nested([corner] * 10, 380, 380, 3.0)
    used, _ = nesting.fullness([corner] * 10, spots, 380)
    assert used < 105


def test_no_room_is_told():
    with pytest.raises(Failure, match="no room on the sheet of 50 × 50 mm for all 2 drawings with 2 mm"):
        nesting.nested([shapely.box(0, 0, 40, 40)] * 2, 50, 50, 2)


@settings(max_examples=25, deadline=None)
@given(SHAPES, st.floats(-180, 180), st.floats(0.5, 5), st.booleans())
def test_hatches_lie_in_their_area_and_leave_no_strip(area, angle, spacing, crossed):
    lines = hatch.hatched([area], hatch.Rule(angle, spacing, crossed))
    drawn = shapely.unary_union([shapely.LineString([(place.real, place.imag) for place in line]) for line in lines])
    assert area.buffer(1e-6).contains(drawn)
    assert area.buffer(-spacing * 0.51).difference(drawn.buffer(spacing * 0.51)).area < 1e-6
    assert drawn.length == pytest.approx((1 + crossed) * area.area / spacing, rel=0.2, abs=8 * area.length / 4)
    ways = {round(float(numpy.angle((line[-1] - line[0]) ** 2, deg=True)) / 2 % 180, 3) for line in lines if abs(line[-1] - line[0]) > 0.1}
    assert all(min(abs(way - wanted) % 180, 180 - abs(way - wanted) % 180) < 0.01 for way in ways for wanted in [angle % 180] if not crossed)


@pytest.mark.parametrize("text", ["45", "45,0", "45,1,twice", "a:45,1", "45,1,crossed,2", "nan,1", "45,nan"])
def test_hatches_that_cannot_be(text):
    with pytest.raises(Failure, match="--hatch wants"):
        hatch.parsed([text])


def test_hatches_by_layer():
    assert hatch.parsed(["45,1", "2:0,0.5,crossed"]) == {0: (45, 1, False), 2: (0, 0.5, True)}
    assert hatch.parsed(None) == {}
