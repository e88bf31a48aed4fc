"""Teach-in on a virtual router: moves by hand come back as lines and arcs, which make the same steps again."""

import math

import pytest

from host_tools.panel.hand_path import fit_program
from panel_desk import Desk
from test_whole_turns import swept

STEPS, STEPS_Z = 320, 400  # a mm
SCALES = (STEPS,) * 3


def seen(*place):
    """A place as a report tells it: a whole step, in thousandths of a mm."""
    return tuple(round(round(value * STEPS) / STEPS, 3) for value in place)


def around(count, turn, radius=10.0, depth=0.0):
    """Places on an arc about 0;radius that begins at 0;0, anticlockwise."""
    angles = [turn * n / count for n in range(count + 1)]
    return [seen(radius * math.sin(angle), radius - radius * math.cos(angle), depth * angle / turn) for angle in angles]


def test_an_arc_a_helix_and_a_turn():
    for turn, depth, end in ((1.5, 0, "X9.975 Y9.294 Z0.000"), (1.5, -3, "X9.975 Y9.294 Z-3.000"), (2 * math.pi, 0, "X0.000 Y0.000 Z0.000")):
        places = around(40, turn, depth=depth)
        assert fit_program([places[0], places[-1]], [places[1:-1]], SCALES) == [f"G3 {end} I0.0000 J10.0000"]
        back = places[::-1]
        assert fit_program([back[0], back[-1]], [back[1:-1]], SCALES)[0].startswith("G2 X0.000 Y0.000")


@pytest.mark.parametrize("beyond", [-0.004, -0.0005, 0.0003, 0.0005, 0.001, 0.02])
def test_a_turn_that_ends_beside_its_start_is_not_lost(beyond):
    """A circle by hand, left or closed some steps too early or too late, both ways."""
    for places in (around(40, math.tau + beyond), around(40, math.tau + beyond)[::-1]):
        lines = ["G1 X{:.3f} Y{:.3f}".format(*places[0]), *fit_program([places[0], places[-1]], [places[1:-1]], SCALES)]
        assert sum(swept([(line + " F100").replace(" ", "").encode() for line in lines], [STEPS] * 3)) > 6.0, lines


def test_places_near_to_each_other_are_an_arc_and_those_far_from_each_other_are_none():
    near, far = around(200, 1.5), around(6, 1.5)
    assert len(fit_program(near, [[] for _ in near[1:]], SCALES)) == 1
    assert [line[:2] for line in fit_program(far, [[] for _ in far[1:]], SCALES)] == ["G1"] * 6


def test_an_arc_in_another_plane():
    places = [(y, 0.0, x) for x, y, _ in around(40, 1.5)]
    for z in (STEPS, 400):
        lines = fit_program([places[0], places[-1]], [places[1:-1]], (STEPS, STEPS, z))
        assert lines == ["G18", "G3 X9.294 Y0.000 Z9.975 K0.0000 I10.0000", "G17"]


@pytest.fixture(scope="module")
def taught():
    """(path by hand, path of the program, its text): places in steps."""
    desk = Desk(recognise=fit_program)
    start = desk.place()
    assert desk.order("teach", what="begin") == 0
    desk.run_ms(100)
    desk.board.world.path = []
    for order in (
        {"do": "step", "by": {"x": 3.1}}, {"do": "step", "by": {"x": 2.2}}, {"do": "step", "by": {"x": 1.5, "y": -1.5, "z": 0.4}},
        {"do": "line", "line": "G91G2X4Y-4J-4F1500"}, {"do": "line", "line": "G3X0I2.5"}, {"do": "line", "line": "G18G2X-3Z-3K-3"},
        {"do": "line", "line": "G17G90"}, {"do": "step", "by": {"y": 2.125}}, {"do": "step", "by": {"y": -1}},
    ):  # fmt: skip
        assert desk.api.answer_order({"speed": 2000, **order}, True)["error"] == 0, order
        desk.settle()
    made, desk.board.world.path = desk.board.world.path, None
    end = desk.place()
    assert desk.order("teach", what="save", name="t") == 0
    assert 0 == desk.order("step", by={"x": (start[0] - end[0]) / STEPS, "y": (start[1] - end[1]) / STEPS, "z": (start[2] - end[2]) / STEPS_Z}, speed=3000)
    desk.settle()
    assert desk.place() == start, (desk.place(), start)
    desk.board.world.path = []
    assert desk.order("run", name="t") == 0
    desk.settle()
    assert desk.machine.state["job"]["how"] == "done" and desk.place() == end
    return *([row[1:4] for row in path] for path in (made, desk.board.world.path)), desk.store.jobs["t"]


def test_lines_and_arcs_are_recognised(taught):
    codes = [line.split()[0] for line in taught[2].split("\n")[2:-2]]
    assert codes == ["G1", "G1", "G2", "G3", "G18", "G2", "G1", "G1", "G17"], taught[2]


def beside(path, other):
    """True if each place of `path` lies within a step, on every axis, of one that `other` passes at about the same time."""
    return all(
        any(max(abs(at - to) for at, to in zip(place, near)) <= 1 for near in other[max(0, index - 3) : index + 4])
        for index, place in enumerate(path)
    )


def test_the_same_path_is_made_again(taught):
    """An arc by hand is known by the places that reports have told: its centre is right to a few thousandths."""
    made, again, _ = taught
    assert made[-1] == again[-1] and beside(made, again) and beside(again, made)
