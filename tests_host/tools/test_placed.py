"""A drawing of the plotter's page put elsewhere: its job is made anew of the file that it came from."""

import pytest

from host_tools import boards
from host_tools.drawings.packets import packet_lines
from host_tools.panel import job_facts
from host_tools.panel.drawn import job_of
from host_tools.panel.store import Store
from passo import errors
from passo.config.boardfile import check

SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30">'
    '<path d="M5 5 L35 5 L35 25 Z" fill="none" stroke="black"/></svg>'
)


@pytest.fixture
def store(tmp_path):
    board = check(boards.load("plotter_2014"))
    return Store(tmp_path / "jobs", packet_lines, job_of(board), job_facts.packets_of(board))


def box(store, name="map.svg.txt"):
    """Left, bottom, right, top of what is drawn, mm."""
    scale = boards.steps_per_mm(boards.load("plotter_2014"))
    words = [line.split() for _, line in store.lines(name)]
    points = [(int(word[1]) / scale[0], int(word[2]) / scale[1]) for word in words if word[0] in (b"MOVE", b"LINE")]
    xs, ys = zip(*points)
    return [round(value, 1) for value in (min(xs), min(ys), max(xs), max(ys))]


def test_it_is_put_elsewhere_and_made_larger(store):
    assert store.add("map.svg", 0, SVG, True) == 0
    assert [name for name, _ in store.names()] == ["map.svg.txt"]
    left, low, right, top = before = box(store)
    assert (right - left, top - low) == pytest.approx((30, 20), abs=0.2)
    assert store.about("map.svg.txt", {})["placed"]
    assert store.place("map.svg.txt", (20, 12, 30)) == 0
    assert box(store) == pytest.approx([20, 12, 50, 32], abs=0.2)
    assert store.place("map.svg.txt", (20, 12, 15)) == 0 and store.place("map.svg.txt", (10, 10, 60)) == 0
    assert box(store) == pytest.approx([10, 10, 70, 50], abs=0.2), "of the file, not of what was drawn small before"
    assert store.place("map.svg.txt", (left, low, right - left)) == 0
    assert box(store) == pytest.approx(before, abs=0.2)


def test_what_leaves_the_table_is_refused_and_the_job_stays(store):
    store.add("map.svg", 0, SVG, True)
    before = box(store)
    for place in ((-1, 0, 30), (0, 0, 5000), (1000, 1000, 30)):
        assert store.place("map.svg.txt", place) == errors.DRAWING
    assert box(store) == before


def test_jobs_without_a_file_stay_where_they_are(store):
    assert store.put("own.txt", "MOVE 1 1\nLINE 2 2\nEND\n") == 0
    assert store.place("own.txt", (1, 1, 1)) == errors.NO_SUCH_JOB and "placed" not in store.about("own.txt", {})
    assert store.place("none.txt", (1, 1, 1)) == errors.NO_SUCH_JOB and store.place("../x", (1, 1, 1)) == errors.JOB_NAME
    store.add("map.svg", 0, SVG, True)
    assert store.put("map.svg.txt", "MOVE 1 1\nLINE 2 2\nEND\n") == 0, "words in the drawing's place"
    assert store.place("map.svg.txt", (1, 1, 1)) == errors.NO_SUCH_JOB
    store.add("map.svg", 0, SVG, True)
    assert store.remove("map.svg.txt") == 0 and [path.name for path in store._folder.iterdir()] == ["own.txt"]


def test_a_single_upright_line_has_no_width(store):
    store.add("line.svg", 0, SVG.replace("L35 5 L35 25 Z", "L5 25"), True)
    assert store.place("line.svg.txt", (50, 40, 0.001)) == 0
    assert box(store, "line.svg.txt") == pytest.approx([50, 40, 50, 60], abs=0.2)
