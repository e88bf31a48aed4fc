"""A CoreXY plotter on the virtual board: homing, ends, arcs, halts, settings, and options that one belt excludes."""

import copy
import math
import random
import sys

import polar
import pytest
from asked import Asked
from passo.config.board_error import BoardError
from passo.config.boardfile import check
from passo.options.kinematics import manifest, motion
from passo.protocols.plotter.host import COMMANDS, packet

from host_tools import boards
from host_tools.sim.job import VirtualJob
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.pages import Pages

NAME = "corexy_plotter"


class Belt(Asked):
    def __init__(self, board=NAME, **options):
        Asked.__init__(self, board, **options)

    def settle(self):
        self.stand()
        return self.places()

    def places(self):
        """Return the places of axes and motors, which the board and the pins agree on."""
        queue = self.machine.app.controller.queue
        motors = self.machine.app.feeder.position(self.machine.app.player.words_played())
        assert queue.position() == list(self.plant.position)
        return list(self.plant.position), list(motors)


@pytest.fixture
def belt():
    return Belt(start=(3001, 2002))


def test_each_axis_homes_by_both_motors(belt):
    """X first, then Y: while one seeks its barrier the other stays, and the pins of both motors step."""
    belt.do("$H")
    assert belt.settle()[0] == [0, 0]
    rows = belt.machine.trace.rows()
    xs, ys = [row[1] for row in rows], [row[2] for row in rows]
    split = next(number for number, y in enumerate(ys) if y != ys[0])
    assert len(set(ys[:split])) == 1 and max(xs[split:]) - min(xs[split:]) <= 1
    assert xs[0] == 3001 and ys[0] == 2002


@pytest.mark.parametrize("start", [(0, 0), (-100, 5000), (24000, -150), (17, 17439)])
def test_homing_from_anywhere(start):
    belt = Belt(start=start, bounce_ms=3)
    belt.do("$H")
    assert belt.settle()[0] == [0, 0]


@pytest.mark.parametrize("fault, alarm", [({"limit_x": "dead"}, "ALARM:9"), ({"limit_y": "stuck"}, "ALARM:8")])
def test_a_barrier_that_fails_ends_in_an_alarm(fault, alarm):
    belt = Belt(start=(400, 300), faults=fault)
    assert alarm in belt.ask("$H")


def test_lines_arcs_and_helices_end_to_the_step(belt):
    belt.do("$H", "G21G90G17", "G1X10Y5F3000")
    assert belt.settle()[0] == [800, 400]
    for line, end in (
        ("G1X20", [1600, 400]), ("Y20", [1600, 1600]), ("G2X10Y10I-10J0", [800, 800]), ("G3X10Y10I5J5", [800, 800]),
        ("G2X30R20", [2400, 800]), ("G0X0Y0", [0, 0]), ("G1X.0125Y.0125", [1, 1]), ("G1X.0125Y0", [1, 0]), ("G91G1X-.0125", [0, 0]),
    ):  # fmt: skip
        belt.do(line)
        places, motors = belt.settle()
        assert places == end, line


def test_a_circle_is_round_and_goes_the_right_way(belt):
    """Within a step of the circle, and counter-clockwise with G3."""
    belt.do("$H", "G90G0X20Y10")
    belt.settle()
    before = len(belt.machine.trace.rows())
    belt.do("G3X20Y10I-5J0F2000")
    belt.settle()
    rows = belt.machine.trace.rows()[before:]
    places = [((row[1] - 1200) / 400, (row[2] - 800) / 400) for row in rows]
    assert all(abs((x * x + y * y) ** 0.5 - 1) * 400 <= 1.1 for x, y in places)
    turns = [x * v - y * u for (x, y), (u, v) in zip(places[::40], places[40::40])]
    assert min(turns) > 0 and len(places) > 2000


def test_feeds_are_those_of_the_path(belt):
    """30 mm at F600, along X, Y and both diagonals: 3 s and the ramps', to a thousandth."""
    belt.do("$H", "G90G0X100Y100")
    belt.settle()
    for way in ("X30", "Y30", "X21.2132Y21.2132", "X-21.2132Y21.2132"):
        first = len(belt.machine.trace.rows())
        belt.do(f"G91G1{way}F600")
        belt.settle()
        rows = belt.machine.trace.rows()[first:]
        middle = rows[len(rows) // 4], rows[3 * len(rows) // 4]
        far = sum((b - a) ** 2 for a, b in zip(middle[0][1:3], middle[1][1:3])) ** 0.5 / 80
        assert far / (middle[1][0] - middle[0][0]) * 1e6 == pytest.approx(10, rel=1e-3), way


def test_a_diagonal_is_the_work_of_one_motor(belt):
    """At full speed X alone has 250 mm/s, a diagonal 250 / √2: then one motor turns as fast as before, the other rests."""
    belt.do("$H")
    belt.settle()
    found = []
    for way in ("X100", "Y150", "X-70Y-70", "X70Y-70"):
        first = len(belt.machine.trace.rows())
        belt.do(f"G91G0{way}")
        belt.settle()
        rows = belt.machine.trace.rows()[first:]
        a, b = rows[len(rows) * 2 // 5], rows[len(rows) * 3 // 5]
        found.append(sum((q - p) ** 2 for p, q in zip(a[1:3], b[1:3])) ** 0.5 / 80 / (b[0] - a[0]) * 1e6)
    assert found == [pytest.approx(speed, rel=2e-3) for speed in (250, 250, 176.78, 176.78)]


@pytest.mark.parametrize("seed", range(8))
def test_halts_leave_both_positions_exact(seed):
    """Holds, resets and jogs broken off, at any moment: board and pins agree, and the next line ends to the step."""
    chance = random.Random(seed)
    belt = Belt(start=(2000, 2000))
    belt.do("$H", "G90F9000")
    belt.settle()
    for _ in range(6):
        x, y = chance.uniform(0, 200), chance.uniform(0, 200)
        kind = chance.choice(("reset", "hold", "jog", "hold and reset"))
        belt.machine.send(f"$J=G90X{x:.3f}Y{y:.3f}F9000\n".encode() if kind == "jog" else f"G1X{x:.3f}Y{y:.3f}\n".encode())
        belt.machine.run_ms(chance.randint(5, 400))
        if kind == "jog":
            belt.machine.send(b"\x85")
        elif kind != "reset":
            belt.machine.send(b"!")
            belt.machine.run_ms(chance.randint(250, 600))
        if "reset" in kind:
            belt.machine.send(b"\x18")
            belt.machine.run_ms(300)
            belt.do("$X", "G90F9000")
        elif kind == "hold":
            belt.machine.send(b"~")
        belt.machine.run_ms(100)
        belt.machine.settle()
        belt.places()
        x, y = chance.randint(0, 16000), chance.randint(0, 16000)
        belt.do(f"G90G1X{x / 80:.4f}Y{y / 80:.4f}F9000")
        belt.machine.settle()
        assert belt.places()[0] == [x, y], kind


def speed_of(belt, milliseconds=100):
    """Return mm/s along the path, over the next `milliseconds`."""
    first = len(belt.machine.trace.rows())
    belt.machine.run_ms(milliseconds)
    rows = belt.machine.trace.rows()[first:]
    return math.dist(rows[0][1:3], rows[-1][1:3]) / 80 / (rows[-1][0] - rows[0][0]) * 1e6


def test_overrides_hold_for_the_path_and_end_at_what_a_motor_can(belt):
    """120 mm/s along a diagonal at 100, 50 and 200 %: a motor is at its limit at 176.8 mm/s. Held, and gone on with, to the step."""
    belt.do("$H", "G90F7200", "G1X200Y200")
    belt.machine.run_ms(200)
    assert speed_of(belt) == pytest.approx(120, rel=2e-3)
    for byte, times, speed in ((b"\x92", 5, 60), (b"\x91", 15, 176.78)):
        belt.machine.send(byte * times)
        belt.machine.run_ms(200)
        assert speed_of(belt) == pytest.approx(speed, rel=2e-3)
    belt.machine.send(b"!")
    belt.machine.run_ms(400)
    stood = belt.places()[0]
    belt.machine.run_ms(300)
    assert belt.places()[0] == stood and abs(stood[0] - stood[1]) <= 1 and 0 < stood[0] < 16000
    belt.machine.send(b"\x90~")
    assert belt.settle()[0] == [16000, 16000]


def with_z():
    """The plotter with a third axis and a touch probe, instead of its pen."""
    board = copy.deepcopy(boards.load(NAME))
    x, y = board["axes"]
    x["pins"], y["pins"] = [2, 5], [3, 6]
    board["axes"].append({**y, "name": "z", "pins": [4, 7], "steps_per_m": 400000, "travel_steps": 20000, "max_mm_min": 3000})
    board.update(servo=None, tool={"pin": 8})
    board["inputs"].append({"name": "probe", "pin": 11, "active": 0, "pull": "up"})
    return board


def test_arcs_stand_in_every_plane_and_ramps_are_s_curves_too():
    """In ZX and YZ no pair of motors walks a circle: chords. Ends to the step, within a hundredth of a millimetre of the circle."""
    belt = Belt(with_z(), start=(100, 100, 0))
    belt.do("$H", "$141=20000", "G21G90F1500", "G0X20Y20Z20")
    assert belt.settle()[0] == [1600, 1600, 8000]
    for words, axis, middle in (("G18G2X30Z20I5K0", 0, (25, 20)), ("G18G3X20Z20I-5K0", 0, (25, 20)), ("G19G2Y30Z20J5K0", 1, (25, 20)),
                                ("G19G3Y20Z20J-5K0", 1, (25, 20))):  # fmt: skip
        first = len(belt.machine.trace.rows())
        belt.do(words)
        belt.settle()
        rows = belt.machine.trace.rows()[first:]
        assert len(rows) > 2000
        assert max(abs(math.dist((row[1 + axis] / 80, row[3] / 400), middle) - 5) for row in rows) < 0.0125 * 1.1, words
    belt.do("G17G2X20Y20I5J5Z25P2", "G3X28Y24Z20R7")
    assert belt.settle()[0] == [2240, 1920, 8000]


@pytest.mark.parametrize("x, y", [(40, 0), (0, 40), (30, 20), (-25, 25), (25, 25)])
def test_a_probe_is_told_in_axes(x, y):
    """G38.2 along X, Y and across, both motors turning: the result is the axes' place as the probe touched, to a step; jogs go on from there."""
    belt = Belt(with_z(), start=(100, 100, 0))
    belt.do("$H", "G21G90F600", "G0X50Y50")
    belt.settle()
    belt.machine.take()
    belt.machine.send(f"G91G38.2X{x}Y{y}F1200\n".encode())
    belt.machine.run_ms(700)
    belt.plant.set_input(belt.machine.port.now, "probe", True)
    touched = list(belt.plant.position)
    belt.machine.run_until(lambda: b"ok" in belt.machine.replies_so_far(), 20_000)
    said = belt.machine.take().decode()
    found = [float(each) * 80 for each in said.split("[PRB:")[1].split(":")[0].split(",")[:2]]
    assert all(abs(a - b) <= 2 for a, b in zip(found, touched)), (found, touched)
    assert math.dist(touched[:2], (4000, 4000)) > 800, "it was under way"
    belt.plant.set_input(belt.machine.port.now, "probe", False)
    belt.do("$J=G90X50Y50F6000")
    assert belt.settle()[0][:2] == [4000, 4000]


def test_a_plotter_s_packets_draw_in_axes():
    """Points of the language of 2014, in steps: homed, a triangle, back."""
    board = {**copy.deepcopy(boards.load(NAME)), "journal": None, "idle_release_ms": 0}
    board["links"][1].update(protocol="plotter", idle_gap_ms=80)
    board["links"][1].pop("lost")
    belt = Belt({**board, "commands": "pc"}, start=(300, 200))

    def ask(name, *points):
        belt.machine.take("pc")
        belt.machine.send(packet(COMMANDS[name], *points), "pc")
        belt.machine.run_until(lambda: belt.machine.replies_so_far("pc"), 120_000)
        return belt.machine.take("pc")

    assert ask("ORIGIN") == b"o" and belt.settle()[0] == [0, 0]
    first = len(belt.machine.trace.rows())
    for name, x, y in (("MOVE", 400, 100), ("LINE", 900, 300), ("LINE", 400, 800), ("LINE", 400, 100), ("MOVE", 7, 4)):
        assert ask(name, x, y) == b"n"
    assert ask("END") == b"d" and belt.settle()[0] == [7, 4]
    drawn = [tuple(row[1:3]) for row in belt.machine.trace.rows()[first:]]
    assert {(400, 100), (900, 300), (400, 800)} <= set(drawn)


@pytest.mark.parametrize("seed", range(3))
def test_a_journal_keeps_the_place_of_the_axes(seed):
    """The power goes amid a diagonal line: its flash tells a place on that line, at most a second back."""
    chance, pages = random.Random(seed), Pages()
    belt = Belt(start=(500, 400), pages=pages)
    belt.do("$H", "$JR=89ABCDEF", "N1G21G90G54F3000", "N2M3S1000", "N3G1X20Y10")
    belt.machine.settle()
    belt.do("N4X100Y90")
    belt.machine.run_ms(chance.randint(1200, 2000))
    place = list(belt.plant.position)
    said = Belt(start=place, pages=pages).ask("$JR")
    job, line, _, found = said.split("[JOURNAL:")[1].split("]")[0].split("|")
    x, y = (int(each) for each in found.split(","))
    assert (job, line) == ("89abcdef", "4") and abs(x - y - 800) <= 1 and 0 <= place[0] - x <= 3000, (found, place)


def test_travel_limits_are_those_of_the_axes(belt):
    belt.do("$H", "$20=1", "G90G0X300Y218")
    assert belt.settle()[0] == [24000, 17440]
    assert "ALARM:2" in belt.ask("G0X300.1")


def test_one_belt_has_one_resolution(belt):
    belt.do("$101=100")
    said = belt.ask("$$")
    assert "$100=100.000" in said and "$101=100.000" in said
    belt.do("$X", "G91G1X10Y10F600")
    belt.machine.settle()
    assert list(belt.plant.position) == [4001, 3002]


@pytest.mark.parametrize("fast, other", [(110, 111), (111, 110)])
@pytest.mark.parametrize("steps", [100, 101])
def test_steps_of_one_belt_are_no_more_than_either_axis_allows(belt, fast, other, steps):
    settings = belt.machine.app.controller.machine.settings
    belt.do("$100=200", f"${other}=60")
    while "ok" in belt.ask(f"${fast}={2 * settings.value(fast) // 1000}"):
        pass
    assert "error:12" in belt.ask(f"${steps}=401"), "the other axis has the same steps, and is as fast"
    assert settings.steps_per_m == [200_000, 200_000]


def test_the_status_report_is_the_axes_position_amid_motion(belt):
    belt.do("$H", "G90G1X50Y20F6000")
    for _ in range(20):
        belt.machine.run_ms(20)
        belt.machine.take()
        belt.machine.send(b"?")
        belt.machine.run_until(lambda: b">" in belt.machine.replies_so_far(), 1000)
        text = belt.machine.take().decode()
        x, y = (float(each) for each in text.split("MPos:")[1].split("|")[0].split(",")[:2])
        assert abs(x * 0.4 - y) < 0.05
    assert belt.settle()[0] == [4000, 1600]


def test_passo_check_sees_the_axes(monkeypatch):
    job = VirtualJob(NAME, inside=True)
    job.run([(1, b"G21G90"), (2, b"M3S1000"), (3, b"G1X30F3000"), (4, b"Y20"), (5, b"G2X30Y20I-10"), (6, b"G0X5Y1")])
    assert not job.errors and list(job.track.position) == [400, 80]
    assert job.track.high == [30.0, pytest.approx(30, abs=0.02)] and job.track.low[0] == 0
    assert max(job.track.fastest) < 15001


@pytest.mark.parametrize("changes, words", [
    ({"axes": "one"}, "two axes with the same steps_per_m are wanted"),
    ({"axes": "other steps"}, "two axes with the same steps_per_m are wanted"),
    ({"links": [{"name": "pc", "port": "usb", "protocol": "keys"}]}, "the language keys moves one axis by one motor"),
    ({"links": [{"name": "pc", "port": "usb", "protocol": "plotter"}]}, "a link that speaks grbl is wanted"),
    ({"encoders": [{"motor": "x", "pins": [16, 17], "pulses": 500, "steps": 1600}]}, "remove encoders: it wants a motor for each axis"),
])
def test_what_one_belt_cannot_be(changes, words):
    board = {**copy.deepcopy(boards.load(NAME)), "journal": None}
    if changes.get("axes") == "one":
        board.update(axes=board["axes"][:1], homing=None, player="timer")
    elif changes.get("axes"):
        board["axes"][1]["steps_per_m"] = 40000
    else:
        board.update(changes)
    with pytest.raises(BoardError, match=words):
        check(board)


def test_an_unknown_kinematics_is_refused():
    with pytest.raises(BoardError, match="kinematics: 'delta' is none of none, corexy"):
        check({**boards.load(NAME), "kinematics": "delta"})


@pytest.fixture
def polar_board(monkeypatch):
    """The board file of a polar plotter, whose kinematics only tests have."""
    monkeypatch.setitem(motion.MAPS, "polar", polar)
    monkeypatch.setitem(manifest.RULES, "kinematics", ("none", "corexy", "polar"))
    return {**boards.load(NAME), "kinematics": "polar", "homing": None, "journal": None}


def test_a_polar_plotter_follows_by_the_same_contract(polar_board):
    """Lines are straight and circles round on the paper, to 0.04 mm, a step of the turntable; the machine says where it is, to a step; after a reset too."""
    machine = VirtualMachine(polar_board, start=(0, 0))
    machine.run_ms(100)
    said = []

    def do(line):
        machine.take()
        machine.send(line.encode() + b"\n")
        machine.run_until(lambda: b"ok" in machine.replies_so_far() or b"error" in machine.replies_so_far(), 60_000)
        said.append(machine.take())
        assert b"error" not in said[-1], (line, said[-1])

    def places(first):
        found = []
        for row in machine.trace.rows()[first:]:
            far, angle = row[1] / 80 + polar.POLE_MM, row[2] * 2 * math.pi / polar.TURN_STEPS
            found.append((far * math.cos(angle) - polar.POLE_MM, far * math.sin(angle)))
        return found

    def at():
        return [steps / 80 for steps in machine.app.controller.queue.position()]

    do("$X")
    do("G21G90G17F3000")
    corners = [(0, 0), (50, 0), (50, 60), (0, 40), (30, -8), (0, 0)]  # within the hard ends of both motors
    for begin, end in zip(corners, corners[1:]):
        first = len(machine.trace.rows())
        do(f"G1X{end[0]}Y{end[1]}")
        machine.settle()
        assert at() == pytest.approx(end, abs=1.1 / 80)
        long = math.dist(begin, end)
        for x, y in places(first):
            off = ((x - begin[0]) * (end[1] - begin[1]) - (y - begin[1]) * (end[0] - begin[0])) / long
            assert abs(off) < 0.04, (begin, end, x, y, off)
    first = len(machine.trace.rows())
    do("G0X40Y10")
    do("G2X40Y10I-15J5F2000")
    machine.settle()
    begun = next(number for number, (x, y) in enumerate(places(first)) if math.dist((x, y), (40, 10)) < 0.02)
    radii = [math.dist((x, y), (25, 15)) for x, y in places(first)[begun:]]
    assert max(radii) - min(radii) < 0.06 and max(radii) == pytest.approx(math.hypot(15, 5), abs=0.03)
    machine.send(b"G1X0Y-30\n")
    machine.run_ms(200)
    machine.send(b"\x18")
    machine.run_ms(300)
    assert at() == pytest.approx(places(0)[-1], abs=1.1 / 80)
    do("$X")
    do("G21G90G1X12Y34F3000")
    machine.settle()
    assert places(0)[-1] == pytest.approx((12, 34), abs=0.02) and not machine.plant.errors
