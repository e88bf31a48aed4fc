"""A router with lost motion on the virtual board, before a plant that has it: ends, contours, speeds, homing, halts, probing, journal, settings."""

import copy
import math
import random

import pytest
from asked import Asked

from host_tools import boards
from host_tools.sim.pages import Pages
from passo.config.board_error import BoardError
from passo.config.boardfile import check

PLAY = {"x": 16, "y": 24, "z": 10}  # steps: 50 and 75 µm of 320 steps/mm, 25 of 400
UM = {"x": 50, "y": 75, "z": 25}
START = (3000, 2000, -4000)


def router(backlash=None, **changes):
    board = {**copy.deepcopy(boards.load("router_3axis")), "idle_release_ms": 0, "journal": None, **changes}
    return {**board, "backlash": UM if backlash is None else backlash} if backlash != {} else board


class Router(Asked):
    def __init__(self, board=None, start=START, play=PLAY, **options):
        Asked.__init__(self, board or router(), start=start, play=play, **options)

    def settle(self):
        self.stand()
        return self.place()

    def place(self):
        """Return the axes' places, which the board and the carriages agree on."""
        found = self.machine.app.controller.queue.position()
        assert found == list(self.plant.position)
        return found

    def rows(self, *lines):
        """(µs, x, y, z, tool) of all that these lines do."""
        self.stand()
        first = len(self.machine.trace.rows())
        self.do(*lines)
        self.stand()
        return self.machine.trace.rows()[first:]


@pytest.fixture
def homed():
    made = Router()
    made.do("$X", "$H", "G21G90F2000")
    assert made.settle() == [0, 0, 0]
    return made


def test_homing_ends_where_it_does_without_play(homed):
    """Each edge is where the carriage was; machine zero is the pull-off from it, to the step, and the next move takes up its part."""
    homed.do("G0X10Y10Z-5", "G0X0Y0Z0")
    assert homed.settle() == [0, 0, 0]


@pytest.mark.parametrize("seed", range(6))
def test_ends_are_exact_whatever_turns(seed):
    """Lines from one step to centimetres, arcs, helices, jogs, dwells: behind each the carriages are where the board says and the program asked."""
    chance = random.Random(seed)
    made = Router()
    made.do("$X", "$H", "G21G90G17F4000", "G0X60Y60Z-20")
    place = [19200, 19200, -8000]
    for _ in range(60):
        for axis in range(3):
            far = chance.choice((0, 1, 2, 7, 40, 700, 6000))
            place[axis] = min(max(place[axis] + chance.choice((-1, 1)) * far, -30000 if axis == 2 else 6400), 0 if axis == 2 else 38400)
        words = "X%.6fY%.6fZ%.6f" % (place[0] / 320, place[1] / 320, place[2] / 400)
        kind = chance.choice(("G1", "G1", "G0", "$J=G90", "G93", "G2"))
        if kind == "G2":
            made.do("G1" + words, chance.choice(("G2", "G3")) + words + "I%.3fJ%.3f" % (chance.uniform(-5, 5), chance.uniform(1, 5)))
        elif kind == "G93":
            made.do("G93G1%sF30" % words, "G94F4000")
        else:
            if kind[0] == "$":
                made.settle()
            made.do(kind + words + ("F3000" if kind[0] == "$" else ""))
        if kind[0] == "$" or chance.random() < 0.3:
            assert made.settle() == place
    assert made.settle() == place


def off_circle(rows, radius_mm, middle):
    return [math.dist((x / 320, y / 320), middle) - radius_mm for _, x, y, *_ in rows]


def circle(board, play, radius=10.0, feed=1500):
    """µm off the circle: furthest inside and outside, over a whole circle that begins at 45°."""
    made = Router(board, play=play)
    side = radius / math.sqrt(2)
    made.do("$X", "$H", "G21G90G17", "G0X%.4fY%.4f" % (80 + side, 80 + side), "G1X%.4fF500" % (80 + side + 0.5), "X%.4f" % (80 + side))
    rows = made.rows("G3X%.4fY%.4fI%.4fJ%.4fF%d" % (80 + side, 80 + side, -side, -side, feed))
    off = off_circle(rows, radius, (80, 80))
    return min(off) * 1000, max(off) * 1000


@pytest.mark.parametrize("radius, feed", [(10.0, 1500), (25.0, 3000), (2.0, 500)])
def test_arcs_leave_no_mark_at_the_quadrants(radius, feed):
    """With play and none taken up a circle is off by all of it; taken up, by two steps and what the way of taking up is long; no play: one."""
    same = {"x": 50, "y": 50}
    played = {"x": 16, "y": 16}
    without = circle(router({}), played, radius, feed)
    taken = circle(router(same), played, radius, feed)
    none = circle(router({}), {}, radius, feed)
    assert max(map(abs, without)) > 40
    assert max(map(abs, none)) < 4
    assert max(map(abs, taken)) < 8.5, (without, taken, none)


def test_a_zigzag_does_not_stop_and_keeps_its_time():
    """Forty turns of Y amid a way along X: 75 µm each. Nowhere does X stand, and the whole takes hardly longer than without play."""
    times, gaps = [], []
    for board, play in ((router({}), {}), (router(), PLAY)):
        made = Router(board, play=play)
        made.do("$X", "$H", "G21G90F1200", "G0X20Y20Z-5")
        made.settle()
        lines = ["G1X%.2fY%.2f" % (20 + k, 20 + k % 2 * 0.5) for k in range(1, 41)]
        first = len(made.machine.trace.rows())
        for line in lines:
            made.machine.send(line.encode() + b"\n")
        made.settle()
        rows = made.machine.trace.rows()[first:]
        xs = [(row[0], row[1]) for row in rows]
        moved = [now[0] for before, now in zip(xs, xs[1:]) if now[1] != before[1]]
        middle = moved[200:-200]
        gaps.append(max(b - a for a, b in zip(middle, middle[1:])) / 1000)
        times.append((rows[-1][0] - rows[0][0]) / 1e6)
    assert times[1] < times[0] * 1.12 and gaps[1] < 8, (times, gaps)


def test_a_turn_on_one_axis_loses_only_the_time_of_the_play(homed):
    """X back and forth: the carriage does 10 mm each way at the feed, and stands as long as 50 µm take."""
    homed.do("G1X20Y20F600")
    homed.settle()
    for goal in (30, 20, 30):
        rows = homed.rows("G1X%d" % goal)
        assert len(rows) == 3200 and abs(rows[-1][1] - goal * 320) == 0
        quarter, half = rows[800], rows[2400]
        assert abs(half[1] - quarter[1]) / 320 / (half[0] - quarter[0]) * 1e6 == pytest.approx(10, rel=1e-3)


@pytest.mark.parametrize("seed", range(8))
def test_halts_leave_the_position_exact(seed):
    """Holds, resets, jogs broken off at any moment, amid taking up too: board and carriages agree, and the next line ends to the step."""
    chance = random.Random(seed)
    made = Router()
    made.do("$X", "$H", "G21G90G17F5000", "G0X50Y50Z-10")
    made.settle()
    for _ in range(6):
        x, y = chance.uniform(10, 90), chance.uniform(10, 90)
        kind = chance.choice(("reset", "hold", "jog", "hold and reset"))
        made.machine.send(b"G91\nG1X-.02Y.01\nX.03Y-.02\nX-.02\nG90\n")
        made.machine.send(f"$J=G90X{x:.3f}Y{y:.3f}F5000\n".encode() if kind == "jog" else f"G1X{x:.3f}Y{y:.3f}\nG3X50Y50R80\n".encode())
        made.machine.run_ms(chance.choice((3, 7, 12, 30, 100, 400)) + chance.randint(0, 9))
        if kind == "jog":
            made.machine.send(b"\x85")
        elif kind != "reset":
            made.machine.send(b"!")
            made.machine.run_ms(chance.randint(250, 600))
        if "reset" in kind:
            made.machine.send(b"\x18")
            made.machine.run_ms(300)
            made.place()
            made.do("$X", "G90F5000")
        elif kind == "hold":
            made.place()
            made.machine.send(b"~")
        made.machine.run_ms(100)
        made.machine.settle()
        made.place()
        x, y = chance.randint(3200, 28800), chance.randint(3200, 28800)
        made.do(f"G90G1X{x / 320:.5f}Y{y / 320:.5f}F4000")
        made.machine.settle()
        assert made.place()[:2] == [x, y], kind


def test_the_status_report_is_the_carriages_amid_motion(homed):
    """Many short lines that turn all the time: each report is where the carriages are at that moment."""
    homed.do("G1X20Y20Z-5")
    homed.settle()
    chance = random.Random(1)
    for _ in range(40):
        lines = ["G91"] + ["G1X%.3fY%.3fZ%.3f" % tuple(chance.uniform(-1, 1) for _ in range(3)) for _ in range(3)] + ["G90"]
        homed.machine.send("".join(line + "\n" for line in lines).encode())
        for _ in range(4):
            homed.machine.run_ms(chance.randint(1, 40))
            assert homed.machine.app.controller.queue.position() == list(homed.plant.position)
    homed.settle()


def test_a_probe_is_told_where_the_axis_is(homed):
    """Down by Z, touched, up again, down: the play of Z is in neither contact."""
    homed.do("G0X20Y20Z-5")
    homed.settle()
    found = []
    for _ in range(2):
        homed.machine.take()
        homed.machine.send(b"G38.2Z-20F200\n")
        homed.machine.run_until(lambda: homed.plant.position[2] <= -4000, 20_000)
        homed.plant.set_input(homed.machine.port.now, "probe", True)
        touched = homed.plant.position[2]
        homed.machine.run_until(lambda: b"ok" in homed.machine.replies_so_far(), 20_000)
        said = homed.machine.take().decode()
        found.append(float(said.split("[PRB:")[1].split(":")[0].split(",")[2]) * 400 - touched)
        homed.plant.set_input(homed.machine.port.now, "probe", False)
        homed.do("G0Z-5")
        assert homed.settle()[2] == -2000
    assert all(abs(each) <= 1.5 for each in found), found


def test_a_journal_keeps_where_the_axes_are():
    """The power goes amid a zigzag; homed, the machine goes on to the step."""
    pages = Pages()
    made = Router(router(journal={"every_ms": 1000}), pages=pages)
    made.do("$X", "$H", "$JR=89ABCDEF", "N1G21G90G54F900", "N2G1X20Y10", "N3G1X25Y15Z-3", "N4G1X22Y40")
    made.machine.run_ms(4000)
    place = list(made.plant.position)
    again = Router(router(journal={"every_ms": 1000}), start=place, pages=pages)
    job, line, _, found = again.ask("$JR").split("[JOURNAL:")[1].split("]")[0].split("|")
    x, y, z = (int(each) for each in found.split(","))
    assert (job, line) == ("89abcdef", "4") and max(abs(x - place[0]), abs(y - place[1])) <= 15 * 320, (found, place)
    assert abs((25 - x / 320) / 3 - (y / 320 - 15) / 25) < 0.01 and z == -1200
    again.do("$X", "$H", "G21G90", "G0X22Y40Z-3")
    assert again.settle() == [7040, 12800, -1200]


def test_the_settings_are_those_of_grblhal():
    made = Router(router({"x": 50}), play={"x": 16, "z": 10})
    said = made.ask("$$")
    assert "$160=0.050" in said and "$161=0.000" in said and "$162=0.000" in said and "$163" not in said
    made.do("$X", "$162=0.025", "$H", "G21G90F1000", "G1Z-5", "G1Z-2X30Y30", "Z-6X20")
    assert made.settle() == [6400, 9600, -2400]
    assert "error" in made.ask("$160=2.001") and "error" in made.ask("$160=-1") and "error" in made.ask("$163=.1")
    before = made.machine.app.controller.queue.position()
    made.do("$160=0", "$162=0")
    assert made.machine.app.controller.queue.position() == before
    assert made.machine.app.planner.ready, "nothing to take up: lines come in batches"


def test_a_machine_without_the_key_has_no_such_settings():
    made = Router(router({}), play={})
    assert "$160" not in made.ask("$$") and made.ask("$160=0.1").startswith("error:3")
    assert type(made.machine.app.planner).__module__ == "passo.motion.planner"


@pytest.mark.parametrize("changes, words", [
    ({"backlash": {"a": 10}}, "backlash: there is no axis 'a'"),
    ({"backlash": {"x": 2001}}, "backlash.x: 2001 is not within 0 … 2000"),
    ({"backlash": {"x": True}}, "backlash.x: True is not within 0 … 2000"),
    ({"backlash": [10]}, "backlash: .* is no dict"),
    ({"backlash": {"x": 10}, "encoders": [{"motor": "x", "pins": [18, 19], "pulses": 500, "steps": 1600}]}, "backlash: remove encoders"),
    ({"backlash": {"x": 10}, "kinematics": "corexy"}, "backlash: remove kinematics"),
    ({"kinematics": "corexy", "backlash": {"x": 10}}, "backlash: remove kinematics"),
    ({"backlash": {"x": 10}, "links": [{"name": "pc", "port": "usb", "protocol": "keys"}]}, "the language keys moves by single steps"),
])  # fmt: skip
def test_what_cannot_be_taken_up(changes, words):
    with pytest.raises(BoardError, match=words):
        check({**router({}), **changes})
