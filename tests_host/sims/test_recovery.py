"""A job of the page whose board loses its power goes on where it was: offered, asked before the tool goes down, and only there."""

import pytest

from host_tools.panel.recovery import RecoverableJobs
from host_tools.panel.store import Store, gcode_lines
from host_tools.programs import program_names
from host_tools.sim.pages import Pages
from panel_desk import Desk
from passo import commands, errors
from passo.config.boardfile import check
from router import BOARD, World

JOB = "G21G90G54\nF3000\nM3S5000\nG0Z-2\nG0X4Y4\nG1Z-4\nX8\nY8\nX4\nY4\nG0Z-2\nM5\nM30\n"
STEPS, STEPS_Z = 320, 400
START = (600, 500, -400)


def desk(tmp_path, pages, place=START, journal=True):
    board = dict(BOARD)
    board["journal"] = {"every_ms": 200}
    made = Desk(world=World(place), pages=pages, journal=check(board)["journal"] if journal else None)
    store = Store(tmp_path / "jobs", gcode_lines)
    made.machine.job = RecoverableJobs(made.machine, made.told.append, store)
    made.store = made.api.store = store
    made.run_ms(300)
    return made


def test_a_board_is_asked_for_nothing_that_it_has_not(tmp_path):
    """The panel sends neither $F nor $JR, which it would log as refused; when the page is loaded, loaded again, and the board has begun anew."""
    made = desk(tmp_path, Pages(), journal=False)
    said = []
    write = made.machine.wire.write
    made.machine.wire.write = lambda data: (said.append(data), write(data))[1]
    for _ in range(2):
        assert made.order("stored", what="list") == 0
        made.run_ms(500)
        assert [event for event in made.told if event["t"] == "stored"][-1]["jobs"] is None
        assert made.order("stop") == 0
        made.run_ms(500)
        assert made.order("unlock") == 0
        made.machine.lose_board()
        made.run_ms(500)
    assert b"$I\n" in said and b"$F\n" not in said and b"$JR\n" not in said
    assert not [number for _, number, who in made.board.controller.machine.log.entries if number < 100], made.board.controller.machine.log.entries


def bottom(path):
    """Return the places passed at the lowest Z with the tool on: the cuts, and the places where the tool came down."""
    lowest = min(row[3] for row in path)
    return {row[1:4] for row in path if row[3] == lowest and row[4]}


def home(made):
    assert made.order("home") == 0
    made.run_ms(300)
    made.settle()
    made.run_ms(300)


@pytest.fixture
def cut(tmp_path):
    """(a desk beside a board that was switched on again amid the job, the path until then)."""
    pages = Pages()
    made = desk(tmp_path, pages)
    assert made.machine.state["recover"] is None
    assert made.store.put_job("part.gcode", JOB) == 0
    home(made)
    made.board.world.path = []
    assert made.order("run", name="part.gcode") == 0
    while made.machine.state["w"][1] < 6 or made.machine.state["m"][2] > -3:
        made.cycle()
    world = made.board.world
    again = desk(tmp_path, pages, world.place)
    again.board.world.tool = 0
    return again, bottom(world.path)


def whole(tmp_path):
    made = desk(tmp_path, Pages())
    made.store.put_job("part.gcode", JOB)
    home(made)
    made.board.world.path = []
    assert made.order("run", name="part.gcode") == 0
    made.settle()
    assert made.machine.state["job"]["how"] == "done", made.machine.state["job"]
    assert made.machine.state["recover"] is None, "it has been done to its end"
    return bottom(made.board.world.path)


def test_it_goes_on_where_it_was(cut, tmp_path):
    made, before = cut
    offer = made.machine.state["recover"]
    assert offer["name"] == "part.gcode" and offer["line"] in (7, 8) and not offer["known"] and not offer["next"]
    assert made.order("recover", what="begin") == errors.NOT_HOMED
    assert made.order("recover", what="down") == errors.ORDER_FIELD
    home(made)
    assert made.machine.state["recover"]["known"]
    path = made.board.world.path = []
    assert made.order("recover", what="begin") == 0
    made.run_ms(200)
    made.settle()
    assert "Z" in made.machine.state["recover"]["next"], made.machine.state
    assert made.board.world.tool == 1 and min(row[3] for row in path) > -3 * STEPS_Z, "the tool is on, and up"
    assert made.order("recover", what="down") == 0
    made.settle()
    job = made.machine.state["job"]
    assert job["how"] == "done" and made.board.world.tool == 0, job
    after = bottom(path)
    (tmp_path / "other").mkdir()
    assert before | after == whole(tmp_path / "other") and len(before & after) < len(after) / 2, "cut twice"
    made.run_ms(200)
    assert made.machine.state["recover"] is None


def test_it_does_not_go_down_elsewhere(cut):
    made, _ = cut
    home(made)
    assert made.order("recover", what="begin") == 0
    made.run_ms(200)
    made.settle()
    assert made.order("step", by={"x": 1}, speed=1000) == 0
    made.settle()
    assert made.order("recover", what="down") == errors.COMMANDED_ELSEWHERE
    assert made.order("recover", what="drop") == 0
    made.run_ms(200)
    assert made.board.world.tool == 0 and made.machine.state["recover"] is None
    assert made.order("recover", what="down") == errors.NO_SUCH_JOB


def test_it_does_not_go_down_behind_a_power_cut_while_it_asked(cut):
    """The machine's place is not known then: it begins anew, tool up."""
    made, _ = cut
    home(made)
    assert made.order("recover", what="begin") == 0
    made.run_ms(200)
    made.settle()
    assert made.machine.state["recover"]["next"]
    made.machine.note_port(False)
    made.run_ms(500)
    assert made.machine.state["recover"]["next"] == "" and made.order("recover", what="down") == errors.ORDER_FIELD
    assert made.order("recover", what="begin") == 0
    made.run_ms(200)
    made.settle()
    assert made.order("recover", what="down") == 0
    made.settle()
    assert made.machine.state["job"]["how"] == "done"


def test_a_board_without_journal_offers_nothing(tmp_path):
    made = Desk()
    made.machine.job = RecoverableJobs(made.machine, made.told.append, Store(tmp_path, gcode_lines))
    made.run_ms(500)
    assert made.machine.state["recover"] is None
    assert made.order("recover", what="begin") == errors.NO_SUCH_JOB


PAUSED = "G21\nM0\nG4P0.1\n"


def paused_and_done(made):
    assert made.store.put_job("paused.gcode", PAUSED) == 0
    assert made.order("run", name="paused.gcode") == 0
    while made.machine.state["state"] != "Hold":
        made.cycle()
    assert made.order("resume") == 0


def cut_amid(made, name="part.gcode"):
    """A job is stopped on its path at the bottom, and the machine stands."""
    assert made.order("run", name=name) == 0
    made.run_ms(300)
    while made.machine.state["w"][1] < 6 or made.machine.state["m"][2] > -3:
        made.cycle()
    assert made.order("abort") == 0
    made.run_ms(2000)


def ready(tmp_path):
    made = desk(tmp_path, Pages())
    assert made.store.put_job("part.gcode", JOB) == 0
    home(made)
    return made


@pytest.mark.parametrize("reset", (False, True), ids=("", "a reset drops the question"))
def test_a_job_behind_one_with_a_pause_is_offered(tmp_path, reset):
    made = ready(tmp_path)
    paused_and_done(made)
    job = made.machine.job
    while reset and made.machine.wire.oldest_line() != b"$JR":
        made.cycle()
    assert not reset or made.order("stop") == 0
    made.run_ms(500)
    while job.is_running():
        made.cycle()
    cut_amid(made)
    offer = made.machine.state["recover"]
    assert offer and offer["name"] == "part.gcode" and offer["line"] in (8, 9) and offer["known"], offer


def test_a_job_that_does_not_begin_leaves_the_one_before(tmp_path):
    made = ready(tmp_path)
    cut_amid(made)
    offer = made.machine.state["recover"]
    assert made.store.put_job("paused.gcode", PAUSED) == 0
    made.board.app.controller.machine.raise_alarm(errors.ALARM_POWER, "test")
    made.run_ms(300)
    assert made.order("run", name="paused.gcode")
    made.run_ms(300)
    assert made.order("unlock") == 0
    made.run_ms(300)
    home(made)
    assert made.machine.state["recover"] == offer


def test_a_job_too_large_to_be_looked_for_is_not_taken_for_another(tmp_path, monkeypatch):
    """The board's journal has its lines under a number of its own."""
    made = ready(tmp_path)
    cut_amid(made)
    assert made.store.put_job("large.gcode", JOB.replace("X8", "X9")) == 0
    monkeypatch.setattr("host_tools.panel.store._MOST_KNOWN", 0)
    cut_amid(made, "large.gcode")
    monkeypatch.undo()
    (tmp_path / "jobs" / "large.gcode").unlink()
    home(made)
    assert made.machine.state["recover"] is None


def test_no_line_goes_before_the_board_knows_whose_it_is(tmp_path):
    """A board that does not take the job's number gets none of its lines, and its journal stays."""
    made = ready(tmp_path)
    cut_amid(made)
    offer, place = made.machine.state["recover"], made.place()
    handlers = made.board.app.controller.machine.handlers
    asked = handlers[commands.JOURNAL]
    handlers[commands.JOURNAL] = lambda command: asked(command) if command.target is None else errors.BUSY
    assert made.store.put_job("paused.gcode", JOB.replace("X8", "X9")) == 0
    assert made.order("run", name="paused.gcode") == 0
    made.run_ms(1000)
    assert made.machine.state["job"]["how"] == "failed" and made.place() == place
    assert made.machine.state["recover"] == offer


def test_what_is_forgotten_is_offered_again_once_it_has_begun_again(tmp_path):
    made = ready(tmp_path)
    cut_amid(made)
    job, offer = made.machine.job, made.machine.state["recover"]
    assert made.order("recover", what="forget") == 0
    home(made)
    assert made.machine.state["recover"] is None
    job._begin_job("part.gcode", "run")
    job._finish_job("failed", errors.STOPPED)
    home(made)
    assert made.machine.state["recover"] == offer


def begin_at(made, line, name="part.gcode"):
    assert made.order("recover", what="from", name=name, line=line) == 0
    made.run_ms(300)
    return made.machine.state["recover"]


@pytest.mark.parametrize("journal", (True, False), ids=("", "no journal"))
def test_a_job_is_begun_at_a_line(tmp_path, journal):
    """The page shows the state restored there before anything moves; then as after a crash: over the place, asked, down, and the rest of it."""
    made = desk(tmp_path, Pages(), journal=journal)
    assert made.store.put_job("part.gcode", JOB) == 0
    home(made)
    path = made.board.world.path = []
    offer = begin_at(made, 9)
    assert offer["name"] == "part.gcode" and offer["line"] == 9 and not offer["known"] and not path
    held = offer["held"]
    assert held["place"] == [8, 8, -4] and held["rpm"] == 5000 and held["spindle"] == 3 and held["feed"] == 3000 and held["system"] == "G54", held
    assert made.order("recover", what="begin") == errors.NOT_HOMED, "the operator has not seen that zero is right"
    assert made.order("recover", what="begin", unverified=True) == 0
    made.run_ms(200)
    made.settle()
    assert "Z" in made.machine.state["recover"]["next"] and min(row[3] for row in path) > -3 * STEPS_Z
    assert made.order("recover", what="down") == 0
    made.run_ms(100)
    made.settle()
    job = made.machine.state["job"]
    assert job["how"] == "done" and made.machine.state["recover"] is None and made.board.world.tool == 0, job
    (tmp_path / "other").mkdir()
    after = bottom(path)
    assert after < whole(tmp_path / "other") and len(after) > 8 * STEPS - 10, "the last two of four sides"


def test_a_job_that_was_begun_at_a_line_is_offered_after_a_cut(tmp_path):
    """The journal knows it as that job, at the line that it had come to."""
    made = ready(tmp_path)
    begin_at(made, 7)
    assert made.order("recover", what="begin", unverified=True) == 0
    made.run_ms(200)
    made.settle()
    assert made.order("recover", what="down") == 0
    while made.machine.state["w"][1] < 6 or made.machine.state["m"][2] > -3:
        made.cycle()
    assert made.order("abort") == 0
    made.run_ms(2000)
    offer = made.machine.state["recover"]
    assert offer and offer["name"] == "part.gcode" and offer["line"] in (8, 9) and "held" not in offer, offer


def test_a_chosen_line_that_is_left_gives_way_to_what_was_interrupted(tmp_path):
    made = ready(tmp_path)
    cut_amid(made)
    offer = made.machine.state["recover"]
    assert begin_at(made, 9)["line"] == 9
    home(made)
    assert made.machine.state["recover"]["line"] == 9, "homing does not lose the choice"
    assert made.order("recover", what="forget") == 0
    made.run_ms(500)
    assert made.machine.state["recover"] == offer


@pytest.mark.parametrize("line, text", ((400, "ends before"), (4, "probes"), (6, "line 5, $X: error 184")))
def test_a_line_that_cannot_be_begun_at_says_why(tmp_path, line, text):
    made = ready(tmp_path)
    assert made.store.put_job("strange.gcode", "G21G90\nF100\nG38.2Z-5\nG0Z-1\nG1X1\n" if line != 6 else "G21G90\nF100\nG0X1\nG0Z-1\n$X\nG1X1\n") == 0
    assert begin_at(made, line, "strange.gcode") is None
    assert [event for event in made.told if event["t"] == "refused" and text in event["text"]], made.told
    assert made.order("recover", what="from", name="none.gcode", line=1) == errors.NO_SUCH_JOB
    assert made.order("recover", what="from", name="strange.gcode", line=0) == errors.ORDER_FIELD


def test_a_job_of_another_folder_is_told_and_gone_on_with_once_its_file_is_here(tmp_path, monkeypatch):
    """As one that `passo stream` has begun: the page names it, ends it, forgets it, and goes on with it behind the file."""
    monkeypatch.setattr(program_names, "KEPT", tmp_path / "begun.json")
    made = ready(tmp_path)
    for what in ("forget", "drop", "begin"):
        made.machine.job = RecoverableJobs(made.machine, made.told.append, made.store)
        home(made)
        cut_amid(made)
        made.store = made.api.store = Store(tmp_path / f"other {what}", gcode_lines)
        made.machine.job = RecoverableJobs(made.machine, made.told.append, made.store)
        made.run_ms(500)
        offer = made.machine.state["recover"]
        assert {**offer, "line": 0} == {"name": "part.gcode", "line": 0, "known": True, "next": "", "absent": True}
        assert made.order("recover", what="begin") == errors.NO_SUCH_JOB
        assert made.store.put_job("another.gcode", "G21\nG0X1\n") == 0
        made.run_ms(500)
        assert made.machine.state["recover"] == offer
        if what != "begin":
            assert made.order("recover", what=what) == 0
            made.settle()
        assert made.store.put_job("part.gcode", JOB) == 0
        made.run_ms(500)
        if what != "begin":
            assert made.machine.state["recover"] is None
    assert "absent" not in made.machine.state["recover"]
    assert made.order("recover", what="begin") == 0
    made.settle()
    assert made.order("recover", what="down") == 0
    made.settle()
    assert made.machine.state["recover"] is None and made.board.world.tool == 0
