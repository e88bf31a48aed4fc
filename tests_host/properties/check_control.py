"""The controller: homing in every circumstance, refusals that move nothing, stop, alarm, store, motors' current."""

from boards.plotter_2014 import BOARD
from passo import errors
from passo.config.boardfile import BoardError, check
from passo.control import point_buffer
from passo.control.log import Log
from passo.control.motors import HOLDING, RELEASED, RUNNING
from passo.control.point_buffer import PointBuffer
from passo.control.sensor import Sensor
from table import EDGE, Machine, Table

PULL_OFF = BOARD["homing"]["pull_off_steps"]
TRAVEL = [axis["travel_steps"] for axis in BOARD["axes"]]
CASES = {
    "check_homing_from_anywhere": (("x", 0, 400), ("y", 0, 300), ("noise", 0, 60)),
    "check_store": (("capacity", 1, 9), ("points", "list", 40, ("put", 0, 1), ("x", 0, 65535), ("y", 0, 65535))),
    "check_store_with_little_memory": (
        ("capacity", 1, 1300), ("pieces", 1, 6), ("work", "list", 12, ("filled", 0, 700), ("taken", 0, 700)),
    ),
    "check_stop_anywhere": (("turns", 1, 250),),
    "check_sensor_noise": (("spikes", "list", 30, ("at", 0, 99)),),
    "check_sensor_in_slow_cycles": (("cycle_ms", 3, 30), ("first_ms", 1, 500), ("wide_ms", 1, 3)),
}
RUNS = {"check_homing_from_anywhere": 15, "check_stop_anywhere": 12}
NOT_QUICK = ("check_dead_and_stuck_sensors",)
SQUARE = ((0, 50, 40), (1, 50, 90), (1, 110, 90), (1, 110, 40), (1, 50, 40))


def check_homing_from_anywhere(x, y, noise):
    """From any start, also on a sensor, the origin is the same place; a reading that lies just before the edge may
    move it by one step."""
    machine = Machine(Table((x, y), noise=noise and noise + 20))
    assert machine.ask("ORIGIN") == b"o"
    for place in machine.table.place:
        assert 0 <= place - EDGE - PULL_OFF <= (1 if noise else 0)
    assert machine.app.controller.position() == [0, 0]
    assert machine.app.controller.machine.homed
    assert machine.table.lowest[0] >= min(x, EDGE) - 10 and machine.table.lowest[1] >= min(y, EDGE) - 10


def check_dead_and_stuck_sensors():
    """A numbered alarm, bounded travel, coils and pen off; ORIGIN_OK is withheld; a repaired sensor homes again."""
    for barrier, level, number in (
        ("barrier_x", 0, errors.ALARM_SENSOR_DEAD), ("barrier_x", 1, errors.ALARM_SENSOR_STUCK),
        ("barrier_y", 0, errors.ALARM_SENSOR_DEAD), ("barrier_y", 1, errors.ALARM_SENSOR_STUCK),
    ):
        table = Table((200, 150), {barrier: level})
        machine = Machine(table)
        assert machine.ask("ORIGIN", turns=60_000) == b""
        status = machine.status()
        assert status["state"] == "alarm" and status["error"] == number
        axis = "xy".find(barrier[-1])
        assert abs(table.place[axis] - table.start[axis]) <= 2 * TRAVEL[axis]
        assert machine.app.controller.machine.motors.state == RELEASED and table.pen == 0
        assert machine.ask("LINE", 10, 10, turns=50) == b""
        assert machine.app.controller.machine.log.last == errors.LOCKED
        table.fault = {}
        table.place = [200, 150]
        assert machine.ask("ORIGIN") == b"o"
        assert machine.status()["state"] == "idle"


def check_a_sensor_that_dies_between_seek_and_locate():
    machine = Machine(Table((60, 60)))
    machine.send("ORIGIN")
    while machine.app.controller.features["homing"]._stage < 3:
        machine.app.cycle()
    machine.table.fault = {"barrier_x": 0}
    machine.cycles(20_000)
    assert machine.status()["error"] == errors.ALARM_SENSOR_DEAD
    assert machine.table.lowest[0] >= EDGE - 3 * PULL_OFF


def check_conversation_of_2014():
    machine = Machine()
    answers = [machine.ask("REQUEST"), machine.ask("ORIGIN"), machine.ask("SPEED", 1000)]
    points = ((0, 644, 314), (1, 644, 454), (1, 884, 454), (1, 884, 314), (1, 644, 314))
    for pen, x, y in points:
        answers.append(machine.ask("LINE" if pen else "MOVE", x, y))
    start = machine.port.now
    answers.append(machine.ask("END"))
    assert b"".join(answers) == b"kosnnnnnd"
    seconds = (machine.port.now - start) / 12_500_000
    assert 3.12 < seconds < 3.12 + 0.2  # 1404 dominant steps of 2.225 ms, and the pen's two movements
    assert machine.app.controller.position() == [644, 314]
    assert machine.table.pen == 0


def check_pen_is_down_on_lines_only():
    machine = Machine()
    machine.ask("ORIGIN")
    zero = machine.table.place[:]
    machine.table.path = []
    machine.draw(SQUARE)
    seen = [(x - zero[0], y - zero[1], pen) for x, y, pen in machine.table.path]
    corner = seen.index((50, 40, 0))
    for x, y, pen in seen[: corner + 1]:
        assert pen == 0
    for x, y, pen in seen[corner + 1 :]:
        assert pen == 1 and (x in (50, 110) or y in (40, 90))
    assert seen[-1] == (50, 40, 1)
    assert len(seen) == 50 + 2 * 50 + 2 * 60


def check_refusals_move_nothing():
    machine = Machine()
    machine.ask("ORIGIN")
    steps = machine.table.steps
    for name, x, y, number in (
        ("LINE", TRAVEL[0] + 1, 0, errors.TRAVEL), ("MOVE", 0, TRAVEL[1] + 1, errors.TRAVEL),
        ("SPEED", 0, 0, errors.SPEED_RANGE), ("SPEED", 65535, 0, errors.SPEED_RANGE),
        ("LEFT", 0, 0, errors.JOG_TRAVEL), ("DOWN", 0, 0, errors.JOG_TRAVEL),
    ):
        assert machine.ask(name, x, y, turns=200) == b""
        status = machine.status()
        assert status["error"] == number and status["state"] == "idle"
        assert machine.status()["error"] == 0
    assert machine.table.steps == steps
    assert machine.ask("MOVE", TRAVEL[0], TRAVEL[1]) == b"n"
    assert machine.ask("MOVE", 0, 0) == b"n"


def check_jogs():
    machine = Machine()
    machine.ask("ORIGIN")
    for name, x, y in (("UP", 0, 10), ("RIGHT", 10, 10), ("UP", 10, 20), ("LEFT", 0, 20), ("DOWN", 0, 10)):
        assert machine.ask(name) == b"n"
        assert machine.status()["state"] == "jog"
        while machine.app.controller.busy():
            machine.app.cycle()
        machine.app.cycle()
        assert machine.app.controller.position() == [x, y]
    # Between the points of an object, too: the points stay, and the object is drawn from where the head stands then.
    assert machine.ask("MOVE", 50, 50) == b"n" and machine.ask("UP") == b"n" and machine.ask("LINE", 50, 60) == b"n"
    assert machine.ask("RIGHT") == b"n"
    machine.cycles(100)
    status = machine.status()
    assert (status["state"], status["x"], status["y"]) == ("idle", 10, 20)
    zero = [place - at for place, at in zip(machine.table.place, machine.app.controller.position())]
    machine.table.path = []
    machine.send("UP")
    machine.send("END")  # waits for the jog
    assert machine.cycles(300) == b"nd"
    assert machine.status()["drawn"] == 2
    drawn = [(x - zero[0], y - zero[1]) for x, y, pen in machine.table.path if pen]
    assert drawn == [(50, y) for y in range(51, 61)]
    for pen, x, y in SQUARE:
        machine.ask("LINE" if pen else "MOVE", x, y)
    machine.send("END")
    machine.cycles(20)
    assert machine.ask("UP", turns=50) == b"" and machine.status()["error"] == errors.BUSY  # while it draws


def check_a_jog_key_held():
    """NEXT is withheld while more is ahead than the board file's time; a host that does not wait for it is not obeyed."""
    for waits in (True, False):
        machine = Machine()
        machine.ask("ORIGIN")
        answers = b""
        for _ in range(60):
            if waits:
                assert machine.ask("UP") == b"n"
            else:
                machine.send("UP")
                answers += machine.cycles(1)
        before = machine.app.controller.position()[1]
        machine.cycles(300)
        place = machine.app.controller.position()[1]
        assert machine.status()["state"] == "idle"
        each_ms = (2 * 1000 + 225) / 1000
        assert (place - before - 20) * each_ms <= 100, (before, place)  # one behind the time, one that waits
        assert place == 600 if waits else place < 600


def check_stop_anywhere(turns):
    """Stopped at any moment: DONE, pen up, object dropped, position what the pins saw, and the machine goes on."""
    machine = Machine()
    machine.ask("ORIGIN")
    zero = machine.table.place[:]
    for pen, x, y in SQUARE:
        machine.ask("LINE" if pen else "MOVE", x, y)
    machine.send("END")
    machine.cycles(turns)
    assert machine.ask("STOP") == b"d"
    late = machine.cycles(200)  # the drawing's own DONE, where that was just coming, and then STOP's
    status = machine.status()
    assert late == b"" or late == b"d" and status["drawn"] == len(SQUARE)
    place = [machine.table.place[axis] - zero[axis] for axis in range(2)]
    assert machine.table.pen == 0
    assert [status["x"], status["y"]] == place == machine.app.controller.position()
    assert status["state"] == "idle" and status["free"] == BOARD["store_points"]
    drawn = status["drawn"]
    assert 0 <= drawn <= len(SQUARE)
    if drawn == len(SQUARE):
        assert place == [50, 40]
    elif drawn:
        _, x0, y0 = SQUARE[drawn - 1]
        _, x1, y1 = SQUARE[drawn]
        assert min(x0, x1) <= place[0] <= max(x0, x1) and min(y0, y1) <= place[1] <= max(y0, y1)
    machine.draw(SQUARE)
    assert machine.app.controller.position() == [50, 40]


def check_stop_while_homing():
    machine = Machine()
    machine.send("ORIGIN")
    machine.cycles(100)
    assert machine.ask("STOP") == b"d"
    assert not machine.app.controller.machine.homed
    x, y = machine.app.controller.position()
    assert x < -10 and y == 0  # counted from where it was switched on
    for name, answer in (("UP", b"n"), ("RIGHT", b"n"), ("LEFT", b""), ("DOWN", b"n"), ("DOWN", b"")):
        assert machine.ask(name, turns=60) == answer, name
        machine.cycles(60)
        if not answer:
            assert machine.status()["error"] == errors.JOG_TRAVEL
    assert machine.app.controller.position() == [x + 10, y]
    assert machine.ask("ORIGIN") == b"o"


def check_commands_wait_while_drawing():
    """Commands that come between END and DONE are answered after DONE, in order."""
    machine = Machine()
    machine.ask("ORIGIN")
    for pen, x, y in SQUARE:
        machine.ask("LINE" if pen else "MOVE", x, y)
    for name, x, y in (("END", 0, 0), ("SPEED", 900, 0), ("MOVE", 9, 9), ("END", 0, 0)):
        machine.send(name, x, y)
    answers = b""
    while not machine.app.controller.position() == [9, 9]:
        answers += machine.cycles(1)
    answers += machine.cycles(100)
    assert answers == b"dsnd"
    assert machine.app.controller.features["drawing"].speed == 900


def check_an_object_longer_than_the_store():
    """Drawn while it arrives: NEXT is withheld until there is room, no point is lost."""
    machine = Machine(store_points=10)
    machine.ask("ORIGIN")
    machine.table.path = []
    zero = machine.table.place[:]
    points = [(i & 1, 10 + 3 * i, 20 + (7 * i) % 31) for i in range(60)]
    machine.draw(points)
    seen = [(x - zero[0], y - zero[1]) for x, y, _ in machine.table.path]
    at = 0
    for _, x, y in points:
        at = seen.index((x, y), at)
    assert machine.status()["drawn"] == 60


def check_too_many_waiting():
    machine = Machine()
    machine.send("ORIGIN")
    for _ in range(100):
        machine.send("SPEED", 1000)
    machine.cycles(3)
    assert machine.status()["error"] == errors.TOO_MANY_WAITING
    machine.cycles(40_000)
    assert machine.app.controller.machine.homed


def check_homing_required():
    homing = dict(BOARD["homing"])
    homing["required"] = True
    machine = Machine(homing=homing)
    assert machine.ask("LINE", 5, 5, turns=20) == b""
    assert machine.status()["error"] == errors.NOT_HOMED
    machine.ask("ORIGIN")
    assert machine.ask("LINE", 5, 5) == b"n"


def check_no_homing():
    machine = Machine(homing=None)
    assert machine.ask("ORIGIN", turns=20) == b""
    assert machine.status()["error"] == errors.NO_HOMING


def check_motor_current():
    """Released at power-up, running in motion, holding soon after, released after the board file's time."""
    machine = Machine()
    motors = machine.app.controller.machine.motors
    machine.cycles(5)
    assert motors.state == RELEASED
    machine.ask("UP")
    machine.cycles(5)
    assert motors.state == RUNNING
    while machine.app.controller.busy():
        machine.app.cycle()
    machine.cycles(BOARD["idle_release_ms"] - 20)
    assert motors.state == HOLDING
    machine.cycles(100)
    assert motors.state == RELEASED
    machine.ask("UP")
    while machine.app.controller.busy():
        machine.app.cycle()
    assert machine.app.controller.position() == [0, 20]


def check_speed_along_the_path():
    """In steps a second the speed is the path's, at every slope; lines last their length over it."""
    machine = Machine(speed={"unit": "steps_per_s", "default": 400, "min": 10, "max": 2000, "overhead_us": 0})
    for x, y, length in ((300, 0, 300), (300, 400, 400), (0, 0, 500)):
        start = machine.port.now
        machine.draw(((0, x, y),))
        seconds = (machine.port.now - start) / 12_500_000
        assert length / 400 <= seconds <= length / 400 + 0.06


def check_sensor_noise(spikes):
    """Readings wrong for less than the debouncing time change nothing, and a true edge keeps its first place."""
    level = [0]
    sensor = Sensor(lambda: level[0], 5)
    noisy = set([at for at in spikes if at % 7 == 0])
    for ms in range(100):
        level[0] = 1 if ms in noisy else 0
        sensor.sample(ms, ms)
        assert not sensor.active
    for ms in range(100, 120):
        level[0] = 0 if ms in (101, 103) else 1
        sensor.sample(ms, ms)
    assert sensor.active and sensor.edge == (98 if 98 in noisy else 100)


class _Latch:
    """Stands for the interrupt of a sensor's pin: it keeps the position of the first edge since begin()."""

    seen = False

    def begin(self, _):
        self.seen = False

    def rise(self, position):
        if not self.seen:
            self.seen = True
            self.position = position


class _Axis:
    def lend(self):
        return (None,)

    def axis(self, _, latch):
        return latch.position


def check_sensor_in_slow_cycles(cycle_ms, first_ms, wide_ms):
    """The main loop may look less often than the debouncing time: noise between two looks, or during one, is noise, and the edge
    that comes later has its own place."""
    latch = _Latch()
    level = [0]
    sensor = Sensor(lambda: level[0], 2, latch, _Axis(), 0)
    for ms in range(1000):
        level[0] = 1 if first_ms <= ms < first_ms + wide_ms or ms >= 700 else 0
        if ms in (first_ms, 700):
            latch.rise(ms)
        if ms % cycle_ms == 0:
            sensor.sample(ms, ms)
            assert not sensor.active or ms >= 700, (ms, "noise is none")
    assert sensor.active and sensor.edge == 700


class _Memory:
    """A heap with room for `pieces`; a piece that a store drops comes back."""

    def __init__(self, store, pieces):
        self.store = store
        self.pieces = pieces

    def __call__(self, size):
        if len([chunk for chunk in self.store._chunks + [self.store._spare] if chunk is not None]) >= self.pieces:
            raise MemoryError
        return bytearray(size)


def check_store_with_little_memory(capacity, pieces, work):
    """take() returns the points in the order of put(), also if there is no memory for all of them; an empty store takes more."""
    store = PointBuffer(capacity)
    point_buffer.bytearray = _Memory(store, pieces)
    try:
        first = last = 0
        for filled, taken in work + [(1, 9999)]:
            while filled:
                places = store.free_rows()
                if places is None:
                    break
                data, at, room = places
                assert 0 < room <= store.free() and at + 5 * room <= len(data)
                for _ in range(min(room, filled)):
                    data[at : at + 5] = bytes((last & 1, last >> 8, last & 255, 7, last & 255))
                    at += 5
                    last += 1
                    store.count += 1
                    filled -= 1
            assert store.count == last - first and (store.count or not filled), "an empty store has room"
            for _ in range(min(taken, store.count)):
                assert store.take() == (first, 7 << 8 | first & 255, first & 1 == 1)
                first += 1
    finally:
        del point_buffer.bytearray


def check_store(capacity, points):
    store = PointBuffer(capacity)
    kept = []
    for put, x, y in points:
        if put and store.free():
            store.put(x, y, bool(x & 1))
            kept.append((x, y, bool(x & 1)))
        elif not put and store.count:
            assert store.take() == kept.pop(0)
        assert store.count == len(kept) and store.free() == capacity - len(kept)
    store.clear()
    assert store.free() == capacity


def check_log_keeps_the_last():
    log = Log(lambda: 100 + log.count)
    for number in range(40):
        log.add(number, str(number))
    assert len(log.entries) == 32 and log.entries[-1] == (139, 39, "39") and log.last == 39


def broken(path, value):
    """The board file with the item at `path` replaced, or removed where `value` is ..."""
    board = copy(BOARD)
    part = board
    for key in path[:-1]:
        part = part[key]
    if value is ...:
        del part[path[-1]]
    else:
        part[path[-1]] = value
    return board


def copy(value):
    if isinstance(value, dict):
        return {key: copy(item) for key, item in value.items()}
    if isinstance(value, list):
        return [copy(item) for item in value]
    return value


def check_board_errors_name_their_place():
    for path, value, words in (
        (("chip",), "z80", ("chip", "z80", "rp2040")),
        (("colour",), "red", ("unknown key", "colour")),
        (("axes", 0, "pins"), ..., ("axes[0].pins", "missing")),
        (("axes", 0, "pins"), [2, 3, 4], ("axis x", "unipolar", "4")),
        (("axes", 0, "pins"), [2, 3, 4, "five"], ("axis x", "five")),
        (("axes", 1, "pins"), [6, 7, 8, 5], ("pin 5", "axis x", "axis y")),
        (("tool", "pin"), 14, ("pin 14", "tool", "barrier_x")),
        (("tool", "on_ms"), -1, ("tool.on_ms", "-1")),
        (("tool",), ..., ("tool", "missing")),
        (("axes",), [], ("axes", "1 … 4")),
        (("axes",), [BOARD["axes"][0]] * 4, ("axes", "too many", "3")),
        (("axes", 0, "travel_steps"), True, ("axes[0].travel_steps", "int")),
        (("axes", 0), 7, ("axes[0]", "dict")),
        (("homing", "sensors"), {"z": "barrier_x"}, ("no axis", "z")),
        (("homing", "sensors"), {"x": "barrier"}, ("homing.sensors.x", "no input")),
        (("speed", "default"), 100, ("speed.default", "100")),
        (("drive",), {"kind": "pbl3770a", "mode": "wave"}, ("axis x",)),
        (("drive", "mode"), "eighth", ("drive.mode", "unipolar", "'eighth'", "half")),
        (("links", 0, "tx"), 10, ("pin 10", "tool", "pc")),
    ):
        try:
            check(broken(path, value))
        except BoardError as error:
            for word in words:
                assert word in str(error), str(error)
            continue
        raise AssertionError("accepted: %r" % (path,))


def check_a_checked_board_is_a_board():
    board = check(BOARD)
    again = check(board)
    added, anew = board.pop("additions"), again.pop("additions")
    assert again == board and anew.__dict__ == added.__dict__
    assert board["homing"]["required"] is False


def check_speeds_the_player_cannot_play_are_refused():
    for speed in (
        {"unit": "steps_per_s", "default": 400, "min": 10, "max": 900_000, "overhead_us": 0},
        {"unit": "half_period_us", "default": 10, "min": 1, "max": 100, "overhead_us": 0},
    ):
        try:
            Machine(speed=speed)
        except BoardError as error:
            assert "speed" in str(error)
            continue
        raise AssertionError("accepted")


def check_unknown_protocol():
    links = [dict(BOARD["links"][0])]
    links[0]["protocol"] = "esperanto"
    try:
        Machine(links=links)
    except BoardError as error:
        assert "esperanto" in str(error) and "plotter" in str(error)
        return
    raise AssertionError("accepted")


def check_two_links_answer_separately():
    second = dict(BOARD["links"][0])
    second["name"] = "pc2"
    second["port"] = "usb"
    machine = Machine(links=[BOARD["links"][0], second])
    machine.send("REQUEST")
    machine.cycles(10)
    assert machine.port.lines["pc2"].outgoing == b""
