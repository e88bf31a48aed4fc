"""The page and the torch's frames: which link has the motors, moves, jogs that end, seams, preferences, the origin."""

from boards.torch_manipulator import BOARD
from language_desk import LanguageDesk
from passo import errors
from passo.records import TICKS_PER_MS
from host_tools.page.torch_machine import TorchMachine


def connected(**changes):
    desk = LanguageDesk(BOARD, TorchMachine, **changes)
    assert desk.order("output", name="motors_on") == 0
    desk.settle()
    assert desk.machine.state["ours"] and desk.machine.state["state"] == "Idle", desk.machine.state
    return desk


def check_the_motors_are_handed_over_and_back():
    desk = LanguageDesk(BOARD, TorchMachine)
    assert not desk.machine.state["ours"]
    assert desk.order("step", by={"x": 1}, speed=600) == 0
    desk.settle()
    assert desk.place() == [0, 0] and desk.machine.log() == [errors.NO_MOTORS], desk.machine.log()
    desk.order("output", name="motors_on")
    desk.settle()
    desk.order("step", by={"x": 1}, speed=600)
    desk.settle()
    assert desk.place() == [48, 0] and desk.machine.state["m"] == [1.0, 0.0]
    desk.order("output", name="motors_off")
    desk.settle()
    assert not desk.machine.state["ours"]


def check_nothing_starts_from_another_computer():
    """A board that wants somebody at the machine: this language cannot tell who is there."""
    desk = connected(network={"presence": "button"}, inputs=[{"name": "button", "pin": 16, "active": 0, "pull": "up"}])
    for order in ({"do": "weave"}, {"do": "play", "what": "run"}, {"do": "run", "name": "a"}):
        assert desk.api.answer_order(order, True, True)["error"] in (errors.PRESENCE, errors.UNKNOWN_COMMAND), order
    assert desk.api.answer_order({"do": "weave"}, True, True)["error"] == errors.PRESENCE
    assert desk.api.answer_order({"do": "output", "name": "motors_on"}, True, True)["error"] == 0


def check_straight_and_on_their_own():
    """A place on the plane is reached straight: both axes end together. Each axis at its own speed: they do not."""
    desk = connected()
    assert desk.order("goto", to={"x": 10, "y": -5}, speed=600) == 0
    desk.settle()
    assert desk.place() == [480, -415]
    rows = desk.trail.rows
    ends = [max([at for at in range(1, len(rows)) if rows[at][1][axis] != rows[at - 1][1][axis]]) for axis in range(2)]
    assert abs(rows[ends[0]][0] - rows[ends[1]][0]) / TICKS_PER_MS < 30
    for tick, (x, y), _ in rows:
        assert abs(x / 48 + 2 * y / 83) < 0.1, (x, y)
    count = len(rows)
    assert desk.order("move", by={"x": -10, "y": 10}, xv=600, yv=1200) == 0
    desk.settle()
    assert desk.place() == [0, 415]
    rows = desk.trail.rows[count:]
    ends = [max([row[0] for at, row in enumerate(rows) if at and row[1][axis] != rows[at - 1][1][axis]]) for axis in range(2)]
    assert abs((ends[0] - rows[0][0]) / TICKS_PER_MS - 1000) < 20 and abs((ends[1] - rows[0][0]) / TICKS_PER_MS - 500) < 20


def check_a_jog_ends():
    for ramps in (False, True):
        desk = connected(planning={"independent_ramps": ramps})
        desk.hold_jog(1, 600, way={"x": 1})
        at = desk.port.now
        desk.order("release")
        desk.settle()
        took = (desk.trail.rows[-1][0] - at) / TICKS_PER_MS
        assert took < (400 if ramps else 60), took
        assert desk.place()[0] > 200 and desk.machine.state["state"] == "Idle", desk.machine.state
        at = desk.port.now
        assert desk.order("jog", lease=2, beat=desk.beats, way={"y": -1}, speed=600) == 0
        desk.settle()
        took = (desk.trail.rows[-1][0] - at) / TICKS_PER_MS
        assert 150 < took < (600 if ramps else 250), took
        assert desk.order("keep", lease=2, beat=desk.beats) == errors.LEASE
        place = desk.place()
        assert desk.order("step", by={"y": 1}, speed=600) == 0
        desk.settle()
        assert desk.place() == [place[0], place[1] + 83], "nothing was left over"


def check_stop_origin_and_preferences():
    desk = connected()
    assert desk.order("goto", to={"x": 100}, speed=600) == 0
    desk.run_ms(500)
    assert desk.machine.state["state"] in ("Run", "Jog") and abs(desk.machine.state["feed"] - 600) < 120
    assert desk.order("step", by={"x": 1}, speed=600) == errors.BUSY
    assert desk.api.answer_order({"do": "stop"}, False)["error"] == 0
    desk.settle()
    assert desk.machine.page_state()["lease"] == 1  # as other pages see that somebody has stopped
    stood = desk.place()
    assert 100 < stood[0] < 1000
    desk.run_ms(300)
    assert desk.place() == stood
    assert desk.order("origin") == 0
    desk.settle()
    assert desk.machine.state["m"] == [0, 0] and desk.place() == stood
    assert desk.order("configure", jogx=2, jogy=3, xv=300, yv=600) == 0
    desk.settle()
    told = desk.api.answer_order({"do": "preferences"}, True)
    assert told["jog"] == [2, 3] and told["speed"] == [300, 600] and told["scale"] == [48, 83], told
    desk.hold_jog(2, 60, way={"y": 1})  # STOP has used up a number
    desk.order("release")
    desk.settle()
    assert desk.place()[1] > stood[1]
    for fields in ({"jogx": 0, "jogy": 1, "xv": 1, "yv": 1}, {"jogx": 1}, {"jogx": 1, "jogy": 1, "xv": 1, "yv": True}):
        assert desk.order("configure", **fields) == errors.ORDER_FIELD
    desk.store.put_job("a", "MOVE")
    assert desk.order("run", name="a") == errors.UNKNOWN_COMMAND
    assert desk.order("home") == errors.UNKNOWN_COMMAND == desk.order("hold")


def check_a_seam():
    desk = connected()
    seam = {"shape": "zigzag", "to": {"x": 20, "y": 0}, "amplitude": 2, "pitch": 4, "speed": 600}
    assert desk.order("weave", **seam) == 0
    desk.settle()
    assert desk.place() == [960, 0]
    sides = [row[1][1] for row in desk.trail.rows]
    assert abs(max(sides) - 166) <= 1 and abs(min(sides) + 166) <= 1
    seam["shape"] = "circle"
    assert desk.order("weave", **seam) == errors.ORDER_FIELD
    assert desk.api.answer_order({"do": "weave"}, False)["error"] == errors.NO_SESSION
    plain = connected(weaving=None)
    assert plain.order("weave", **seam) == errors.UNKNOWN_COMMAND and "weave" in desk.machine.can and "weave" not in plain.machine.can
