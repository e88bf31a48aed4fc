"""The page and the plotter's packets: the square of 2014, places, jogs that end, refusals, and a line that loses bytes."""

from boards.plotter_2014 import BOARD
from draws import Random
from language_desk import LanguageDesk
from panel_desk import Shelf
from passo import errors
from passo.records import TICKS_PER_MS
from host_tools.page.plotter_machine import PlotterMachine

SQUARE = "SPEED 1000\nMOVE 644 314\nLINE 644 454\nLINE 884 454\nLINE 884 314\nLINE 644 314\nEND\n"
CORNERS = [(644, 314), (644, 454), (884, 454), (884, 314), (644, 314)]
CASES = {"check_a_line_that_loses_bytes": (("seed", "seed"),)}
RUNS = {"check_a_line_that_loses_bytes": 3}


def homed():
    desk = LanguageDesk(BOARD, PlotterMachine, Shelf())
    assert desk.order("home") == 0
    desk.run_ms(100)
    desk.until(lambda state: state["state"] == "Idle" and not desk.machine.busy_error())
    assert desk.place() == [0, 0]
    return desk


def ended(desk):
    desk.until(lambda state: state["job"] and state["job"]["how"] != "run")
    desk.settle()
    return desk.machine.state["job"]


def drawn(desk):
    """Places that the pen was down at, without a second time in a row: it goes up and down there."""
    places = [place for _, place, tool in desk.trail.rows if tool]
    return [places[at] for at in range(len(places)) if not at or places[at] != places[at - 1]]


def check_the_square_of_2014():
    desk = homed()
    desk.store.put_job("square.txt", SQUARE)
    assert desk.order("run", name="square.txt", check=True) == 0
    assert ended(desk)["how"] == "done" and desk.place() == [0, 0]
    assert desk.order("run", name="square.txt", passes=2) == 0
    desk.until(lambda state: state["drawn"] == 3)
    assert desk.machine.state["job"]["line"] in (3, 4, 5), desk.machine.state["job"]
    job = ended(desk)
    assert (job["how"], job["pass"], job["line"], job["lines"]) == ("done", 2, 7, 7), job
    down = drawn(desk)
    assert [corner for corner in CORNERS if corner not in down] == []
    assert [place for place in down if place[0] not in (644, 884) and place[1] not in (314, 454)] == []


def check_places_and_jogs():
    desk = homed()
    assert desk.order("goto", to={"x": 30, "y": 20}, speed=1) == 0
    desk.settle()
    assert desk.place() == [300, 200] and desk.machine.state["m"] == [30, 20] and not drawn(desk)
    assert desk.order("step", by={"x": -1.5}, speed=1) == 0
    desk.settle()
    assert desk.place() == [285, 200]
    assert desk.order("goto", to={"x": 401}, speed=1) == errors.JOG_TRAVEL
    assert desk.order("jog", lease=1, beat=desk.beats, way={"x": 1, "y": 1}, speed=1) == errors.BUSY
    for lease, way, axis, sign in ((2, {"y": 1}, 1, 1), (3, {"x": -1}, 0, -1)):
        before = desk.place()
        desk.hold_jog(lease, 480, way=way)
        at = desk.port.now
        desk.order("release")
        desk.settle()
        assert (desk.place()[axis] - before[axis]) * sign > 30 and desk.place()[1 - axis] == before[1 - axis]
        took = (desk.trail.rows[-1][0] - at) / TICKS_PER_MS
        assert took < 100, took
        assert desk.machine.state["state"] == "Idle", desk.machine.state
    at = desk.port.now
    assert desk.order("jog", lease=4, beat=desk.beats, way={"y": 1}, speed=1) == 0
    desk.settle()
    took = (desk.trail.rows[-1][0] - at) / TICKS_PER_MS
    assert 150 < took <= 250, took
    before = desk.place()
    desk.run_ms(500)
    assert desk.place() == before and desk.order("keep", lease=4, beat=desk.beats) == errors.LEASE
    assert desk.order("step", by={"y": -1}, speed=1) == 0
    desk.settle()
    assert desk.place() == [before[0], before[1] - 10]


def check_refusals_and_stop():
    desk = homed()
    desk.store.put_job("far.txt", "MOVE 10 10\nLINE 5000 10\nEND\n")
    assert desk.order("run", name="far.txt") == 0
    job = ended(desk)
    assert job["how"] == "failed" and job["error"] == errors.TRAVEL and job["done"] <= 2, job
    desk.store.put_job("odd.txt", "MOVE 10 10\nCIRCLE 5\n")
    assert desk.order("run", name="odd.txt") == errors.UNKNOWN_COMMAND
    assert desk.machine.state["job"]["line"] == 2
    desk.store.put_job("square.txt", SQUARE)
    assert desk.order("run", name="square.txt") == 0
    desk.until(lambda state: state["state"] == "Run" and state["drawn"])
    assert desk.api.answer_order({"do": "stop"}, False)["error"] == 0
    desk.settle()
    stood = desk.place()
    assert desk.machine.state["job"]["error"] == errors.STOPPED and not desk.trail.rows[-1][2]
    desk.run_ms(500)
    assert desk.place() == stood
    desk.machine.job.fail(0)
    count = len(drawn(desk))
    assert desk.order("goto", to={"x": 1, "y": 1}, speed=1) == 0
    desk.settle()
    assert desk.place() == [10, 10] and len(drawn(desk)) == count, "stored points must be drawn later"
    assert desk.order("pace", speed=0) == errors.ORDER_FIELD and desk.order("pace", speed=500) == 0
    assert desk.order("zero", axes="x") == errors.UNKNOWN_COMMAND


def check_point_by_point_and_back():
    """The same lines as in one go, a point at each press; back with the pen up, and forward again; from the end of a job, too."""
    desk = homed()
    desk.store.put_job("square.txt", SQUARE)

    def play(what):
        error = desk.order("play", what=what)
        desk.run_ms(200)
        desk.until(lambda state: state["state"] == "Idle" and not desk.machine.unanswered)
        desk.run_ms(100)
        return error

    def job():
        return desk.machine.state["job"]

    assert desk.order("play", what="step") == errors.NO_SUCH_JOB
    assert desk.order("run", name="square.txt", single=True) == 0
    assert play("step_back") == 0 and desk.place() == [0, 0] and not job()["back"]
    assert play("step") == 0 and job()["done"] == 1 and desk.place() == [0, 0], "the speed"
    seen = []
    for number in range(len(CORNERS)):
        assert play("step") == 0
        seen.append(tuple(desk.place()))
        assert job()["how"] == "run" and job()["line"] == number + 2 and desk.machine.state["pen"] == "up", job()
    assert seen == CORNERS
    once = drawn(desk)
    assert job()["back"] and play("step_back") == 0 and tuple(desk.place()) == CORNERS[3] and drawn(desk) == once
    assert play("step") == 0 and tuple(desk.place()) == CORNERS[4] and len(drawn(desk)) > len(once)
    count = len(drawn(desk))
    assert play("back") == 0
    desk.until(lambda state: not state["job"]["back"] and state["state"] == "Idle")
    desk.settle()
    assert tuple(desk.place()) == CORNERS[0] and len(drawn(desk)) == count and job()["line"] == 2
    assert play("run") == 0
    assert ended(desk)["how"] == "done" and tuple(desk.place()) == CORNERS[-1]
    assert drawn(desk)[count - 1 :] == once, "another path than point by point"
    assert desk.order("play", what="step_back") == 0
    desk.until(lambda state: state["state"] == "Run")
    assert desk.order("play", what="back") == errors.BUSY and desk.machine.state["pen"] == "up"
    desk.run_ms(2000)
    assert tuple(desk.place()) == CORNERS[3] and job()["how"] == "run"
    assert desk.order("goto", to={"x": 1}, speed=1) == errors.BUSY
    assert desk.order("abort") == 0
    desk.settle()
    assert job()["error"] == errors.STOPPED and play("back") == errors.NO_SUCH_JOB


def check_a_step_stops_a_drawing_that_runs():
    """The board draws the points sent; the rest waits. The pen's state follows from the points drawn."""
    desk = homed()
    desk.store.put_job("square.txt", SQUARE.replace("SPEED 1000", "SPEED 3000"))
    assert desk.order("run", name="square.txt", passes=2) == 0
    pens = []
    while not desk.machine.page_state()["job"]["done"] >= 4:
        desk.cycle()
        tool = bool(desk.trail.rows and desk.trail.rows[-1][2])
        pens.append((tool, desk.machine.state["pen"]))
    assert (True, "down") in pens and (False, "up") in pens
    assert len([1 for tool, pen in pens if (pen == "down") != tool]) < len(pens) // 4, "the pen's state is wrong for longer than reports lag"
    assert desk.order("play", what="step") == 0
    desk.until(lambda state: state["state"] == "Idle")
    desk.run_ms(500)
    stood = desk.place()
    assert desk.machine.state["job"]["how"] == "run" and tuple(stood) in CORNERS and desk.machine.state["pen"] == "up"
    desk.run_ms(500)
    assert desk.place() == stood
    assert desk.order("play", what="run") == 0
    job = ended(desk)
    assert (job["how"], job["pass"]) == ("done", 2)
    assert [corner for corner in CORNERS if drawn(desk).count(corner) < 2] == []


def check_a_line_that_loses_bytes(seed):
    """Each way now and then: all points are drawn, and nothing else."""
    desk = homed()
    random = Random(seed)
    put, feed = desk.put, desk.machine.feed

    def torn(data):
        if len(data) and random.between(0, 14) == 0:
            at = random.between(0, len(data) - 1)
            data = data[:at] + data[at + 1 :]
        return bytes(data)

    desk.machine.wire.write = lambda data: put(torn(data))
    desk.machine.feed = lambda data, now: feed(torn(data), now)
    desk.store.put_job("square.txt", SQUARE)
    assert desk.order("run", name="square.txt") == 0
    desk.until(lambda state: state["job"]["how"] != "run", 300_000)
    assert desk.machine.state["job"]["how"] == "done", desk.machine.state
    down = drawn(desk)
    assert [corner for corner in CORNERS if corner not in down] == []
    assert [place for place in down if place[0] not in (644, 884) and place[1] not in (314, 454)] == []
