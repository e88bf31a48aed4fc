"""Jobs that follow a map of heights, and the program that faces the work: by geometry, and on the virtual machine."""

import math
import random

import pytest

from host_tools.page.set_up import PROBING
from host_tools.programs import surfacing
from host_tools.programs.height_map import Grid, Unfollowed, level_job

SLOPE = (0.01, -0.02, 0.3)
FACE = {"x": 100, "y": 80, "tool": 20, "overlap": 40, "depth": 1.2, "cut": 0.5, "feed": 1500, "plunge": 300, "rpm": 12000, "safe": 5}


def plane(x, y):
    return SLOPE[0] * x + SLOPE[1] * y + SLOPE[2]


def grid_of(height, size=(0, 0, 100, 80, 5, 4)):
    grid = Grid(*size)
    grid.heights = [height(x, y) for x, y in grid.probe_points()]
    return grid


def moves(text):
    """[(code, {letter: value})] of the lines that move."""
    found = []
    for line in [each for each in text.split("\n") if each[:1] != "("]:
        words = [(word[0], float(word[1:])) for word in line.split() if word[0].isalpha()]
        values = {letter: value for letter, value in words if letter != "G"}
        if {"X", "Y", "Z"} & set(values):
            found.append(([value for letter, value in words if letter == "G"][-1:] or [None], values))
    return found


def test_lines_follow_a_plane_exactly_and_end_where_they_ended():
    text = level_job("G21 G90\nG0 X5 Y5 Z5\nG1 Z-1 F300\nG1 X95 Y70\nX10\nG0 Z5\nM2\n", grid_of(plane))
    placed = [(each["X"], each["Y"], each["Z"]) for _, each in moves(text)]
    cut = [(x, y, z) for x, y, z in placed if z < 3]
    assert len(cut) > 30 and all(abs(z - (plane(x, y) - 1)) < 0.0011 for x, y, z in cut)
    assert (95, 70) in [(x, y) for x, y, _ in cut] and (10, 70) in [(x, y) for x, y, _ in cut]
    longest = max(math.dist(a[:2], b[:2]) for a, b in zip(cut, cut[1:]))
    assert longest <= grid_of(plane).longest_piece() + 0.001
    assert "F300" in text and text.rstrip().endswith("M2")


@pytest.mark.parametrize("arc, centre, radius, turn", [
    ("G2 X40 Y40 I20 J0", (40, 20), 20, 0.25), ("G3 X20 Y20 I20 J0", (40, 20), 20, 1), ("G2 X40 Y40 R20", (40, 20), 20, 0.25), ("G3 X40 Y40 R20", (20, 40), 20, 0.25),
    ("G2 X40 Y40 R-20", (20, 40), 20, 0.75),
])  # fmt: skip
def test_arcs_stay_arcs(arc, centre, radius, turn):
    text = level_job("G90 G21 G0 X20 Y20 Z2\nG1 Z0 F100\n" + arc + "\n", grid_of(plane))
    points = [(each["X"], each["Y"], each["Z"]) for _, each in moves(text)][1:]
    way = points[1:] if turn == 1 else points
    assert all(abs(math.dist(point[:2], centre) - radius) < 0.0015 and abs(point[2] - plane(*point[:2])) < 0.0011 for point in way)
    length = sum(math.dist(a[:2], b[:2]) for a, b in zip(points, points[1:]))
    assert abs(length - turn * 2 * math.pi * radius) < 0.2


def test_a_bump_is_followed_between_its_points():
    chance = random.Random(3)
    grid = grid_of(lambda x, y: chance.uniform(-1, 1))
    for (x, y), z in zip(grid.probe_points(), grid.heights):
        assert abs(grid.height_at(x, y) - z) < 1e-9
    assert grid.height_at(-50, -50) == grid.height_at(0, 0), "beyond the edge it is that of the edge"
    middle = grid.height_at(grid.dx / 2, 0)
    assert abs(middle - (grid.height_at(0, 0) + grid.height_at(grid.dx, 0)) / 2) < 1e-9


def test_inches_become_millimetres():
    text = level_job("G20 G90\nG0 X1 Y1 Z1\nG1 Z-0.1 F10\n", grid_of(lambda x, y: 0.0))
    assert moves(text)[-1][1]["Z"] == -2.54 and "F254" in text and "G20" not in text


@pytest.mark.parametrize("line, why", [
    ("G91", "relative"), ("G81 X1 Y1 Z-1 R1", "cycle"), ("G92 X0", "cycle"), ("G55", "cycle"), ("G18\nG2 X1 Z1 I1", "plane"), ("G53 G0 Z0\nG1 X5", "place"),
    ("G2 X50 Y50 R1", "arc"), ("G1 X1.2.3", "length"), ("G38.2 Z-1", "cycle"),
])  # fmt: skip
def test_what_cannot_be_followed_names_its_line(line, why):
    with pytest.raises(Unfollowed) as error:
        level_job("G21 G90 (a note; G91)\nG0 X1 Y1 Z1\nG1 X2 F100\n" + line + "\n", grid_of(plane))
    assert error.value.args == (4 + line.count("\n"), why)


def test_facing_covers_the_work_and_goes_down_beside_it():
    lines = surfacing.surface_lines(FACE)
    text = "\n".join(lines)
    x = y = z = None
    cuts, depths = [], set()
    for _, values in moves(text):
        to = values.get("X", x), values.get("Y", y), values.get("Z", z)
        if z is not None and z < 0 and to[2] == z:
            cuts.append(((x, y), to[:2]))
        if to[2] is not None and to[2] < 0 and (z is None or z >= 0):
            assert x < -FACE["tool"] / 2 or x > FACE["x"] + FACE["tool"] / 2, "it goes down beside the work"
            depths.add(to[2])
        x, y, z = to
    assert depths == {-0.4, -0.8, -1.2}
    rows = sorted({a[1] for a, b in cuts if a[1] == b[1]})
    assert rows[0] == 0 and rows[-1] == 80 and max(b - a for a, b in zip(rows, rows[1:])) <= 12.0001
    assert surfacing.surface_lines({**FACE, "tool": 0.1, "depth": 100, "cut": 0.01}) is None


@pytest.mark.unmeasured
@pytest.mark.slow
def test_the_machine_touches_a_map_and_a_job_follows_it(tmp_path):
    from panel_process import PanelProcess

    with PanelProcess(tmp_path) as panel:
        page = panel.page()
        page.until(lambda state: state["link"])
        page.order("home")
        page.until(lambda state: state["state"] == "Home")
        page.until(lambda state: state["state"] == "Idle")
        for line in ("G10L2P1X166Y104Z-40", "G0X0Y0"):
            assert page.order("line", line=line)["error"] == 0
            page.until(lambda state: state["state"] == "Idle" and (line[0:3] == "G10" or state["w"][:2] == [0, 0]))
        fields = {"x0": 0, "y0": 0, "x1": 30, "y1": 32, "columns": 3, "rows": 3, "safe": 15, "deep": 2, "feed": 300}
        assert page.order("map", what="probe", **{**fields, "columns": 1})["error"]
        assert page.order("map", what="level", name="part.nc")["error"], "there is no map yet"
        assert page.order("map", what="probe", **fields)["error"] == 0
        job = page.until(lambda state: state["job"] and state["job"]["how"] in ("done", "failed"))["job"]
        assert (job["name"], job["how"], job["error"], job["line"]) == (PROBING, "done", 0, job["lines"])
        found = page.order("map", what="get")
        # The plate lies in the middle of this part of the piece: 20 × 20 mm, 12 mm high, and the tool has 6 mm.
        wanted = [[0, 0, 0], [0, 12, 0], [0, 12, 0]]
        rows = [found["heights"][3 * row : 3 * row + 3][:: -1 if row % 2 else 1] for row in range(3)]
        assert found["whole"] and all(abs(is_ - was) < 0.04 for told, row in zip(rows, wanted) for is_, was in zip(told, row)), rows
        page.put("part.nc", "G21 G90\nG0 X0 Y0 Z5\nG1 Z-1 F300\nG1 Y16\nG1 X15\n")
        answer = page.order("map", what="level", name="part.nc")
        assert answer["name"] == "part-level.nc"
        text = (tmp_path / "jobs" / "part-level.nc").read_text()
        assert abs(moves(text)[-1][1]["Z"] - 11) < 0.04
        page.put("wrong.nc", "G21\nG91\nG1 X1\n")
        assert page.order("map", what="level", name="wrong.nc")["why"] == "relative"
        made = page.order("make", what="surface", **FACE)
        assert made["name"] == "surface.gcode"
        assert page.order("run", name="surface.gcode", check=True)["error"] == 0
        assert page.until(lambda state: state["job"]["name"] == "surface.gcode" and state["job"]["how"] in ("done", "failed"))["job"]["how"] == "done"
