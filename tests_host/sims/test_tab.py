"""The machine of a browser's tab, in stepped time under CPython: the messages for the page."""

import json

import pytest

from host_tools.sim.tab import Tab, start
from host_tools.sim.tab_jobs import Jobs
from host_tools.site.builder import BOARDS, demo_jobs
from passo import errors

JOB = "G21 G90 G94\nG0 X2 (over; there)\nG1 Y1.5 Z-1 F1200 ; down\n\n\nM2\n"


class Page:
    """Hears what the tab says; orders."""

    def __init__(self, board, jobs):
        self.last = {}
        self.told = []
        self.places = []
        self._id = 0
        self.tab = Tab(board, jobs, self._hear, BOARDS, "stepped")

    def _hear(self, text):
        message = json.loads(text)
        self.told.append(message)
        self.last[message["t"]] = message
        if message["t"] == "machine":
            width = len(self.tab.plant.position) + 1
            trail = message["trail"]
            self.places += [tuple(trail[at : at + width]) for at in range(0, len(trail), width)]

    def order(self, **order):
        """The error of an order's answer; 0: none."""
        self._id += 1
        self.tab.hear(json.dumps({**order, "id": self._id}))
        assert self.told[-1]["id"] == self._id
        return self.told[-1].get("error", 0)

    def until(self, condition, turns=40_000):
        for _ in range(turns):
            if condition():
                return
            self.tab.turn(0)
        raise AssertionError(self.last)

    def state(self, name):
        self.until(lambda: self.last.get("state", {}).get("state") == name)

    def job_ends(self):
        self.until(lambda: (self.last["state"]["job"] or {}).get("how") in ("done", "failed"))
        return self.last["state"]["job"]


def router(jobs=None):
    page = Page("router_3axis", jobs or {})
    page.state("Alarm")
    return page


def test_a_router_homes_from_the_middle_and_runs_a_job():
    page = router({"part.gcode": JOB})
    assert page.tab.plant.position == start(page.tab._board)
    assert page.order(do="run", name="part.gcode") == errors.BUSY  # not before it is homed
    assert page.order(do="home") == 0
    page.state("Idle")
    assert page.tab.plant.position == [0, 0, 0]
    page.places.clear()
    assert page.order(do="run", name="part.gcode") == 0
    job = page.job_ends()
    assert (job["how"], job["error"], job["line"]) == ("done", 0, 6)
    assert page.tab.plant.position == [640, 480, -400]
    assert page.places[-1][:3] != page.places[0][:3] and page.last["machine"]["faults"] == 0
    assert max(place[0] for place in page.places) <= 640 and min(place[2] for place in page.places) >= -400


def test_a_refused_line_is_told_by_its_number_in_the_file():
    page = router({"wrong.gcode": "G21\n\n(nothing)\nG1 X1 Q\n"})
    page.order(do="unlock")
    page.state("Idle")
    page.order(do="run", name="wrong.gcode")
    job = page.job_ends()
    assert job["how"] == "failed" and job["line"] == 4 and job["error"]


def test_a_jog_that_nobody_holds_ends():
    page = router()
    page.order(do="unlock")
    page.state("Idle")
    page.until(lambda: "settings" in page.last)
    before = page.tab.plant.position[0]
    assert page.order(do="jog", lease=1, beat=page.last["state"]["beat"], way={"x": 1}, speed=3000) == 0
    page.state("Jog")
    page.state("Idle")
    assert 0 < page.tab.plant.position[0] - before < 320 * 50 * 0.75  # 200 ms of lease, and the ramp, at 50 mm/s


def test_stop_halts_at_once():
    page = router()
    page.order(do="unlock")
    page.state("Idle")
    page.order(do="step", by={"x": 50}, speed=3000)
    page.state("Jog")
    page.tab.hear('{"do": "stop"}')
    at = page.tab.plant.position[0]
    page.state("Alarm")
    assert page.tab.plant.position[0] - at < 320 * 50 * 0.02


@pytest.mark.parametrize("name, points", [("square.txt", [(200, 150), (200, 550), (600, 550), (600, 150)])])
def test_a_plotter_draws_the_square_of_2014(name, points):
    page = Page("plotter_2014", demo_jobs()["plotter_2014"])
    page.state("Idle")
    assert page.order(do="home") == 0
    page.state("Home")
    page.state("Idle")
    page.places.clear()
    assert page.order(do="run", name=name) == 0
    assert page.job_ends()["how"] == "done"
    drawn = [place[:2] for place in page.places if place[2]]
    for x, y in points:
        assert min(abs(px - x) + abs(py - y) for px, py in drawn) <= 2
    low, high = points[0], points[2]
    assert all(low[0] <= x <= high[0] and low[1] <= y <= high[1] and (x in (low[0], high[0]) or y in (low[1], high[1])) for x, y in drawn)


def test_a_plotter_refuses_what_is_no_packet_and_stops():
    page = Page("plotter_2014", {"wrong.txt": "MOVE 1 1\nLINE 70000 1\n", "far.txt": "MOVE 9 9\nLINE 4000 3000\nEND\n"})
    page.state("Idle")
    assert page.order(do="run", name="wrong.txt") == errors.UNKNOWN_COMMAND
    assert page.last["answer"]["error"] and page.order(do="zero", axes="x") == errors.UNKNOWN_COMMAND
    assert page.order(do="home") == 0
    page.state("Home")
    page.state("Idle")
    assert page.order(do="run", name="far.txt") == 0
    page.state("Run")
    assert page.order(do="stop") == 0
    page.state("Idle")
    assert page.last["state"]["job"]["how"] == "failed"
    assert page.tab.plant.position[0] < 4000


def test_jobs_of_a_tab():
    kept = Jobs({"a.gcode": JOB}, "grbl")
    assert kept.lines_of("a.gcode")[:3] == [(1, b"N1G21G90G94"), (2, b"N2G0X2"), (3, b"N3G1Y1.5Z-1F1200")]
    assert kept.lines_of("b.gcode") == kept.remove_job("b.gcode") == kept.text_piece("b.gcode", 0) == errors.NO_SUCH_JOB
    for name in ("../x", "", "a" * 61, ".x", "x.", "ü", "a/b"):
        assert kept.put_job(name, "") == errors.JOB_NAME, name
    assert kept.add_piece("c", 0, "G0", False) == 0
    assert kept.add_piece("c", 1, "X1", True) == errors.JOB_PIECE
    assert kept.add_piece("c", 2, " X1\n", True) == 0
    assert kept.text_piece("c", 3) == ("X1\n", 6)
    assert kept.put_job("d", "x" * 8_000_001) == errors.JOB_SIZE
    assert kept.put_job("d", " \n") == kept.put_job("photo.png", "\x89PNG\0") == kept.add_piece("e", 0, "", True) == errors.NOT_A_JOB
    assert [name for name, _ in kept.job_names()] == ["a.gcode", "c"]
    assert Jobs({"noise": "G0 X1\x11(!\x18?~ü)\r\n%\r\n"}, "grbl").lines_of("noise") == [(1, b"N1G0X1")]
    assert Jobs({"noise": "G0\nX1!"}, "grbl").lines_of("noise") == {"error": errors.JOB_LINE, "line": 2, "text": ""}
    assert Jobs({"n": "N7 G0 X1\nG0 X2\n"}, "grbl").lines_of("n") == [(1, b"N1G0X1"), (2, b"N2G0X2")]


def test_every_order_for_jobs_is_known_in_a_tab():
    """A tab's jobs have what a PC's page asks of its folder."""
    from host_tools.panel.store import Store

    asked = {"add_piece", "facts_of", "job_names", "lines_of", "put_job", "remove_job", "text_piece"}
    assert asked <= set(dir(Store)) and asked <= set(dir(Jobs))
    assert Jobs({"part.gcode": "G0X1"}, "grbl").facts_of("part.gcode", {}) == {}
