"""The page and the kit of two motors: keys sent are what the motors do, and a motor held by a button stops."""

from boards.two_motor_kit import BOARD
from language_desk import LanguageDesk
from passo import errors
from passo.records import TICKS_PER_MS
from host_tools.page.keys_machine import KeysMachine


def kit():
    def made(write, tell, board):
        machine = KeysMachine(write, tell, board)
        machine.note_port(True)
        return machine

    desk = LanguageDesk(BOARD, made)
    assert desk.machine.state["state"] == "Idle" and desk.machine.state["link"]
    return desk


def turned(desk, milliseconds):
    """Return the steps of both motors within `milliseconds`."""
    before = desk.place()
    desk.run_ms(milliseconds)
    return [now - then for now, then in zip(desk.place(), before)]


def check_keys_are_what_the_motors_do():
    desk = kit()
    assert desk.order("motor", motor=1, what="on") == 0
    desk.run_ms(200)
    assert desk.machine.state["state"] == "Run" and desk.machine.state["motors"][0]["rate"] == 250
    x, y = turned(desk, 400)
    assert abs(x - 100) <= 3 and y == 0
    assert desk.order("motor", motor=2, what="speed", speed=5) == 0
    assert desk.order("motor", motor=2, what="on") == 0
    assert desk.order("motor", motor=1, what="reverse") == 0
    desk.run_ms(200)
    x, y = turned(desk, 400)
    assert abs(x + 100) <= 3 and abs(y - 20) <= 2
    assert desk.order("motor", motor=1, what="off") == 0
    desk.run_ms(200)
    assert turned(desk, 200)[0] == 0 and [motor["on"] for motor in desk.machine.state["motors"]] == [False, True]
    assert desk.order("motor", motor=0, what="on") == 0
    desk.run_ms(200)
    assert desk.api.answer_order({"do": "stop"}, False)["error"] == 0
    desk.run_ms(200)
    assert turned(desk, 300) == [0, 0] and desk.machine.state["state"] == "Idle"
    for fields in ({"motor": 3, "what": "on"}, {"motor": 1, "what": "away"}, {"motor": 0, "what": "reverse"}, {"motor": 1, "what": "speed", "speed": 128}):
        assert desk.order("motor", **fields) == errors.ORDER_FIELD, fields
    assert desk.order("home") == desk.order("zero", axes="x") == errors.UNKNOWN_COMMAND


def check_a_motor_held_by_a_button_stops():
    desk = kit()
    for lease, way in ((1, {"x": 1}), (2, {"y": 1}), (3, {"x": -1})):
        before = desk.place()
        desk.hold_jog(lease, 300, way=way)
        at = desk.port.now
        desk.order("release")
        desk.run_ms(300)
        axis = "xy".index(list(way)[0])
        assert (desk.place()[axis] - before[axis]) * way["xy"[axis]] > 50
        assert (desk.trail.rows[-1][0] - at) / TICKS_PER_MS < 60
    at = desk.port.now
    assert desk.order("jog", lease=4, beat=desk.beats, way={"y": 1}, speed=1) == 0
    desk.run_ms(600)
    took = (desk.trail.rows[-1][0] - at) / TICKS_PER_MS
    assert 150 < took <= 250, took
    assert desk.order("keep", lease=4, beat=desk.beats) == errors.LEASE
    desk.machine.note_port(False)
    assert desk.order("motor", motor=1, what="on") == errors.NO_ANSWER
