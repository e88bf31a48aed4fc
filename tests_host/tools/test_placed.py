"""A drawing of the plotter's page put elsewhere: its job is made anew of the file that it came from."""

from types import SimpleNamespace

import pytest

from host_tools import boards
from host_tools.drawings.packets import packet_lines
from host_tools.panel import job_facts
from host_tools.panel.drawing_jobs import gcode_of, words_of
from host_tools.panel.store import Store, gcode_lines
from passo import errors
from passo.config.boardfile import check

SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30">'
    '<path d="M5 5 L35 5 L35 25 Z" fill="none" stroke="black"/></svg>'
)


@pytest.fixture
def store(tmp_path):
    board = check(boards.load("plotter_2014"))
    return Store(tmp_path / "jobs", packet_lines, words_of(board, SimpleNamespace(settings={})), job_facts.packets_of(board))


def box(store, name="map.svg.txt"):
    """Return the left, bottom, right and top of the drawing, mm."""
    scale = boards.steps_per_mm(boards.load("plotter_2014"))
    words = [line.split() for _, line in store.lines_of(name)]
    points = [(int(word[1]) / scale[0], int(word[2]) / scale[1]) for word in words if word[0] in (b"MOVE", b"LINE")]
    xs, ys = zip(*points)
    return [round(value, 1) for value in (min(xs), min(ys), max(xs), max(ys))]


def test_it_is_put_elsewhere_and_made_larger(store):
    assert store.add_piece("map.svg", 0, SVG, True) == 0
    assert [name for name, _ in store.job_names()] == ["map.svg.txt"]
    left, low, right, top = before = box(store)
    assert (right - left, top - low) == pytest.approx((30, 20), abs=0.2)
    assert store.facts_of("map.svg.txt", {})["placed"]
    assert store.place_job("map.svg.txt", (20, 12, 30)) == 0
    assert box(store) == pytest.approx([20, 12, 50, 32], abs=0.2)
    assert store.place_job("map.svg.txt", (20, 12, 15)) == 0 and store.place_job("map.svg.txt", (10, 10, 60)) == 0
    assert box(store) == pytest.approx([10, 10, 70, 50], abs=0.2), "the size must be that of the file, not of the last placing"
    assert store.place_job("map.svg.txt", (left, low, right - left)) == 0
    assert box(store) == pytest.approx(before, abs=0.2)


PLT = "IN;SP1;PU200,200;PD1400,200,1400,1000,200,200;PU;SP0;"  # 30 × 20 mm
DXF = "0\nSECTION\n2\nENTITIES\n" + "".join(
    f"0\nLINE\n8\n0\n10\n{a}\n20\n{b}\n11\n{c}\n21\n{d}\n" for a, b, c, d in ((5, 5, 35, 5), (35, 5, 35, 25), (35, 25, 5, 5))
) + "0\nENDSEC\n0\nEOF\n"
GCODE = "G21 G90 F600\nG0 Z2\nG0 X5 Y5\nG1 Z-1\nG1 X35\nY25\nX5 Y5\nG0 Z2\n"
DRAWINGS = {"map.svg": SVG, "map.plt": PLT, "map.HPGL": PLT, "map.dxf": DXF, "map.nc": GCODE}


@pytest.mark.parametrize("name", DRAWINGS)
def test_any_drawing_is_a_job_of_a_plotter(store, name):
    assert store.add_piece(name, 0, DRAWINGS[name], True) == 0
    left, low, right, top = box(store, f"{name}.txt")
    assert (right - left, top - low) == pytest.approx((30, 20), abs=0.2)
    assert store.place_job(f"{name}.txt", (20, 12, 60)) == 0
    assert box(store, f"{name}.txt") == pytest.approx([20, 12, 80, 52], abs=0.2)


class Machine:
    """A board's settings."""

    def __init__(self, **settings):
        self.settings = {int(number[1:]): value for number, value in settings.items()}


LASER = Machine(s30="500", s32="1", s100="80.000", s101="80.000", s130="300.000", s131="200.000")


@pytest.mark.parametrize("name", ["map.svg", "map.plt", "map.HPGL", "map.dxf"])
@pytest.mark.parametrize("machine, down, axes", [(LASER, "M4 S150", "XY"), (Machine(s30="9000", s32="0", s100="80", s101="80", s130="300", s131="200"), "M3 S9000", "XY"),
                                                 (Machine(), "G1 Z0 F300", "XYZ")])  # fmt: skip
def test_any_drawing_is_a_program_of_a_laser_a_pen_or_a_router(tmp_path, name, machine, down, axes):
    """By the machine's settings: those of router_3axis hold only until they are known."""
    store = Store(tmp_path / "jobs", gcode_lines, gcode_of(check(boards.load("router_3axis")), machine), job_facts.gcode_facts)
    assert store.add_piece(name, 0, DRAWINGS[name], True) == 0
    ((made, _),) = store.job_names()
    text = (tmp_path / "jobs" / made).read_text()
    assert made == f"{name}.gcode" and down in text.splitlines() and {"Z"} & set(text) == set(axes) & {"Z"}
    assert store.facts_of(made, {})["placed"] and store.place_job(made, (20, 12, 60)) == 0
    words = [word for line in (tmp_path / "jobs" / made).read_text().splitlines() if line[:2] == "G1" for word in line.split()]
    xs, ys = ([float(word[1:]) for word in words if word[0] == axis] for axis in "XY")
    assert [min(xs), max(xs), min(ys), max(ys)] == pytest.approx([20, 80, 12, 52], abs=0.2)
    if machine is LASER:
        assert store.place_job(made, (20, 12, 290)) == errors.DRAWING, "beyond $130"


def test_g_code_is_a_router_s_own_language(tmp_path):
    store = Store(tmp_path / "jobs", gcode_lines, gcode_of(check(boards.load("router_3axis")), LASER), job_facts.gcode_facts)
    assert store.add_piece("map.nc", 0, GCODE, True) == 0
    assert (tmp_path / "jobs" / "map.nc").read_text() == GCODE and "placed" not in store.facts_of("map.nc", {})
    assert store.add_piece("none.dxf", 0, "hello", True) == errors.DRAWING and store.add_piece("none.plt", 0, "", True) == errors.NOT_A_JOB


def test_what_leaves_the_table_is_refused_and_the_job_stays(store):
    store.add_piece("map.svg", 0, SVG, True)
    before = box(store)
    for place in ((-1, 0, 30), (0, 0, 5000), (1000, 1000, 30)):
        assert store.place_job("map.svg.txt", place) == errors.DRAWING
    assert box(store) == before


def test_jobs_without_a_file_stay_where_they_are(store):
    assert store.put_job("own.txt", "MOVE 1 1\nLINE 2 2\nEND\n") == 0
    assert store.place_job("own.txt", (1, 1, 1)) == errors.NO_SUCH_JOB and "placed" not in store.facts_of("own.txt", {})
    assert store.place_job("none.txt", (1, 1, 1)) == errors.NO_SUCH_JOB and store.place_job("../x", (1, 1, 1)) == errors.JOB_NAME
    store.add_piece("map.svg", 0, SVG, True)
    assert store.put_job("map.svg.txt", "MOVE 1 1\nLINE 2 2\nEND\n") == 0, "words in the drawing's place"
    assert store.place_job("map.svg.txt", (1, 1, 1)) == errors.NO_SUCH_JOB
    store.add_piece("map.svg", 0, SVG, True)
    assert store.remove_job("map.svg.txt") == 0 and [path.name for path in store._folder.iterdir()] == ["own.txt"]


def test_a_single_upright_line_has_no_width(store):
    store.add_piece("line.svg", 0, SVG.replace("L35 5 L35 25 Z", "L5 25"), True)
    assert store.place_job("line.svg.txt", (50, 40, 0.001)) == 0
    assert box(store, "line.svg.txt") == pytest.approx([50, 40, 50, 60], abs=0.2)
