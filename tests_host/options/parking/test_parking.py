"""Parking on the virtual board: while the door is open Z goes up first, and comes back to the path, which is the one without a door, step by step."""

import copy
import random

import pytest
from asked import Asked

from host_tools import boards
from passo.config.board_error import BoardError
from passo.config.boardfile import check

Z_MM = 400
JOB = [
    "M3S12000", "M8", "G1Z-12F900", *[f"G1X{20 + n % 7}Y{20 + 0.3 * n:.3f}F2400" for n in range(30)], "G2X40Y40R15", "G4P0.4",
    *[f"G1X{40 + 0.05 * n:.3f}Y{40 + (n % 3) * 0.05:.3f}" for n in range(60)], "G3X20Y20Z-9R30", "G0X10Y10", "G1Z-12F300", "M9",
]  # fmt: skip


def router(parking=None, **changes):
    board = {**copy.deepcopy(boards.load("router_3axis")), "idle_release_ms": 0, **changes}
    board["spindle"] = {**board["spindle"], "spin_up_ms": 300, "coolant_ms": 100}
    return {**board, "parking": {"target_mm": -2, "mm_min": 1500, "pull_out_mm_min": 600, **(parking or {})}}


class Parked(Asked):
    left = ()  # lines to be sent
    waits = 0  # for answers

    def __init__(self, board=None, lines=(), **options):
        Asked.__init__(self, board or router(), **options)
        self.do("$X", *lines, "$H", "G21G90G17", "G0X20Y20Z-5")
        self.stand()

    def door(self, open_):
        self.plant.set_input(self.machine.port.now, "door", open_)

    def hear(self):
        heard = self.machine.take()
        assert b"ALARM" not in heard and b"error" not in heard, heard
        self.waits -= heard.count(b"ok")
        return heard.decode()

    def state(self):
        self.hear()
        self.machine.send(b"?")
        self.machine.run_until(lambda: b">" in self.machine.replies_so_far(), 1000)
        return self.hear().split("<")[-1].split("|")[0]

    def until(self, state, limit_ms=30_000):
        for _ in range(limit_ms // 20):
            if self.state() == state:
                return
            self.machine.run_ms(20)
        raise AssertionError((state, self.state()))

    def feed(self, lines):
        """Send as a sender does, eight lines ahead of their answers; pump() goes on with it."""
        self.left = [line.encode() + b"\n" for line in lines]
        self.waits = 0
        self.pump()

    def pump(self):
        self.hear()
        while self.left and self.waits < 8:
            self.machine.send(self.left.pop(0))
            self.waits += 1
            self.machine.run_ms(1)
            self.hear()

    def finish(self, limit_ms=120_000):
        for _ in range(limit_ms // 20):
            self.pump()
            self.machine.run_ms(20)
            if self.state() == "Idle" and not self.left and not self.waits:  # a host that asks no more counts as lost
                self.stand()
                return
        raise AssertionError(self.state())

    def rows(self):
        """(x, y, z, tool) of each step."""
        return [tuple(row[1:4]) + (row[-1],) for row in self.machine.trace.rows()]


def path(rows):
    """The way without what goes up from it and comes back to the same step: excursions of Z alone above the step they began at."""
    return [row[:3] for index, row in enumerate(rows) if not index or row[:3] != rows[index - 1][:3]]


def undisturbed(lines=JOB, before=()):
    made = Parked(lines=before)
    first = len(made.rows())
    made.feed(lines)
    made.finish()
    return path(made.rows()[first - 1 :])


def without_excursions(rows, places):
    """The way without what goes up from one of `places` (x, y, z), where the door found the machine, and comes back to it."""
    way = path(rows)
    for x, y, z in set(places):
        index = 0
        while (x, y, z) in way[index:]:
            index = way.index((x, y, z), index)
            end = index
            while end + 1 < len(way) and way[end + 1][:2] == (x, y) and way[end + 1][2] >= z:
                end += 1
            if way[end][2] == z:
                way[index + 1 : end + 1] = []
            index += 1
    return way


def park(made, places):
    """Open the door until the machine is parked, close it, and go on. Append where the path was left."""
    made.door(True)
    made.until("Door:1")
    assert made.plant.position[2] == -2 * Z_MM and not made.plant.tool
    places.append((*made.plant.position[:2], made.machine.app.controller.features["pauses"]._path))
    made.door(False)
    made.until("Door:0")
    made.machine.send(b"~")


@pytest.mark.parametrize(
    "before, seeds", [((), range(3)), (("$141=4000",), range(1)), pytest.param((), range(3, 20), marks=pytest.mark.slow),
    pytest.param(("$141=4000",), range(1, 9), marks=pytest.mark.slow)], ids=["ramps", "S-curves", "many ramps", "many S-curves"],
)  # fmt: skip
def test_the_path_is_the_one_without_a_door(before, seeds):
    """The door opens at random instants, amid lines, arcs, tiny lines, a dwell, and again while Z comes back."""
    wanted = undisturbed(before=before)
    for seed in seeds:
        chance = random.Random(seed)
        made = Parked(lines=before)
        first = len(made.rows())
        made.feed(JOB)
        places = []
        for _ in range(3):
            for _ in range(chance.randint(5, 60)):
                made.pump()
                made.machine.run_ms(20)
            if made.state() == "Idle":
                break
            park(made, places)
            if chance.random() < 0.6:  # again, on its way back
                made.machine.run_ms(chance.randint(1, 1400))
                park(made, places)
            made.until("Run")
        made.finish()
        assert places
        assert without_excursions(made.rows()[first - 1 :], places) == wanted, seed
        assert made.plant.position == [3200, 3200, -4800] and not made.plant.errors


def test_with_limited_jerk():
    """Amid a long line and an arc with S-curves."""
    lines, before = ("G1X60Y50F1800", "G2X40Y40R15", "G1X20"), ("$141=4000",)
    wanted = undisturbed(lines, before)
    made = Parked(lines=before)
    first = len(made.rows())
    made.feed(lines)
    places = []
    for ms in (700, 1400):
        made.machine.run_ms(ms)
        park(made, places)
        made.machine.run_ms(900)
        park(made, places)
        made.until("Run")
    made.finish()
    assert without_excursions(made.rows()[first - 1 :], places) == wanted


def test_up_first_then_off_and_on_before_down():
    """Along the excursion: pulled out at $57 with the spindle on, up without; down without to that height, plunged with."""
    made = Parked()
    made.feed(JOB[:4] + ["G1X60F900"])
    made.machine.run_ms(2500)
    made.door(True)
    first = len(made.machine.trace.rows())
    made.until("Door:1")
    made.door(False)
    made.until("Door:0")
    made.machine.send(b"~")
    made.until("Run")
    rows = [row for row in made.machine.trace.rows()[first:]]
    left = made.machine.app.controller.features["pauses"]._path
    out, top = left + 5 * Z_MM, -2 * Z_MM
    zs = [(row[3], row[-1] > 0, row[0]) for row in rows if row[3] > left]
    highest = max(range(len(zs)), key=lambda index: zs[index][0])
    up, down = zs[: highest + 1], zs[highest + 1 :]
    assert up[-1][0] == top
    assert all(on for z, on, _ in up if z < out) and not any(on for z, on, _ in up if z > out + 1)
    assert not any(on for z, on, _ in down if z > out) and all(on for z, on, _ in down if z < out - 1)
    pulled = [t for z, _, t in up if left + 200 < z < out - 200]
    assert abs((pulled[-1] - pulled[0]) / (len(pulled) - 1) - 1e6 / (600 / 60 * Z_MM)) < 3, "at $57"
    rises = [t for z, _, t in up if out + 900 < z < top - 900]
    assert abs((rises[-1] - rises[0]) / (len(rises) - 1) - 1e6 / (1500 / 60 * Z_MM)) < 2, "at $59"
    on_at = next(t for z, on, t in down if z < out)
    assert on_at - down[-1 - sum(z < out for z, _, _ in down)][2] > 300_000, "the spindle has its time before it goes down"


def test_lines_overrides_and_a_reset_meanwhile():
    made = Parked()
    made.feed(["G1X40F1200"])
    made.machine.run_ms(400)
    made.door(True)
    made.until("Door:2")
    for line in ("G1Y40", "G1X20"):
        assert made.ask(line).endswith("ok")
    made.machine.send(b"\x91\x91")  # feed 120 %
    made.until("Door:1")
    made.do("G1Y20")
    made.door(False)
    made.until("Door:0")
    made.machine.send(b"~")
    made.finish()
    assert made.plant.position == [6400, 6400, -2000]
    assert made.machine.app.planner.percent[0] == 120
    made.feed(["G1X40F1200"])
    made.machine.run_ms(400)
    made.door(True)
    made.until("Door:2")
    made.machine.run_ms(100)
    made.door(False)
    made.machine.send(b"\x18")
    made.machine.run_ms(300)
    made.stand()
    made.do("$X", "G90G0X20Y20Z-5")
    made.stand()
    assert made.plant.position == [6400, 6400, -2000], "to the step, though it was stopped on its way up"


@pytest.mark.parametrize("how", ["$41=0", "high", "$32=1", "unhomed"])
def test_it_stays_where_it_may_not_park(how):
    board = router()
    board["spindle"].update({"pwm": True, "pin": 20})
    made = Parked(board)
    if how[0] == "$":
        made.do(how)
    if how == "high":
        made.do("G0Z-1")
    if how == "unhomed":
        made.machine.send(b"\x18")
        made.machine.run_ms(200)
        made.machine.app.controller.machine.homed = False
        made.do("$X")
    made.stand()
    made.feed(["G91G1X20F600"])
    made.machine.run_ms(300)
    z = made.plant.position[2]
    made.door(True)
    made.until("Door:1")
    assert made.plant.position[2] == z
    made.door(False)
    made.until("Door:0")
    made.machine.send(b"~")
    made.finish()
    assert made.plant.position[2] == z


def test_at_rest_with_the_door_open_it_parks_too_and_comes_back():
    made = Parked()
    made.door(True)
    made.until("Door:1")
    assert made.plant.position == [6400, 6400, -800]
    made.do("G91G1X1F600")
    made.door(False)
    made.until("Door:0")
    made.machine.send(b"~")
    made.finish()
    assert made.plant.position == [6720, 6400, -2000]


@pytest.mark.parametrize("before", [(), ("G1X25F600",)], ids=["at rest", "amid a motion"])
def test_m62_waits_for_the_programs_motion_not_for_parking(before):
    """The output is on from the next motion of the program on, which the door lets begin only when all is closed."""
    outputs = [*boards.load("router_3axis")["outputs"], {"name": "p0", "pin": 22, "active": 1, "role": "none"}]
    made = Parked(router(outputs=outputs))
    changes = []
    show = made.plant.output
    made.machine.port.world.output = lambda tick, name, level: (changes.append((made.plant.position[:], level)) if name == "p0" else None, show(tick, name, level))
    made.do(*before, "M62P0")
    made.machine.run_ms(100)
    assert not any(on for _, on in changes)
    made.door(True)
    made.until("Door:1")
    made.machine.run_ms(200)
    made.door(False)
    made.until("Door:0")
    made.machine.send(b"~")
    made.finish()
    assert not any(on for _, on in changes), changes
    x = made.plant.position[0]
    made.do("G91G1X5F600")
    made.finish()
    (place,) = [place for place, on in changes if on]
    assert place == [x, 6400, -2000], "as the first step is made"


def test_a_wait_for_an_input_parks_and_goes_on():
    """The input's level meanwhile counts once the axis is back."""
    made = Parked(router(inputs=[*boards.load("router_3axis")["inputs"], {"name": "p0", "pin": 22, "active": 1, "pull": "down"}]))
    made.plant.set_input(made.machine.port.now, "p0", False)
    made.feed(["M66P0L1Q100", "G91G1X5F600"])
    made.machine.run_ms(200)
    park(made, places := [])
    assert places == [(6400, 6400, -2000)]
    made.until("Run")
    made.machine.run_ms(300)
    made.door(True)
    made.until("Door:1")
    made.plant.set_input(made.machine.port.now, "p0", True)
    made.machine.run_ms(300)
    assert made.plant.position == [6400, 6400, -2 * Z_MM]
    made.door(False)
    made.until("Door:0")
    made.machine.send(b"~")
    made.finish()
    assert made.plant.position == [8000, 6400, -2000]


def test_the_end_of_a_program():
    made = Parked(router({"at_end": True}))
    made.do("M3S1000", "G1Z-10F900", "M30")
    made.stand()
    assert made.plant.position == [6400, 6400, -800] and not made.plant.tool
    made.do("G90G1Z-1F900", "M2")
    made.stand()
    assert made.plant.position[2] == -400, "never down"
    made.do("$41=0", "G1Z-10F900", "M2")
    made.stand()
    assert made.plant.position[2] == -4000
    other = Parked(router())
    other.do("G1Z-10F900", "M30")
    other.stand()
    assert other.plant.position[2] == -4000


def test_the_journal_keeps_where_the_path_was_left():
    """The data for `passo resume`: the line under way, and a place on it."""
    made = Parked(router(journal={"every_ms": 100}))
    made.do("$JR=0000BEEF")
    made.feed(["N1G1X60F600"])
    made.machine.run_ms(1000)
    made.door(True)
    made.until("Door:1")
    made.machine.run_ms(500)
    line, flags, place = made.ask("$JR").split("[JOURNAL:")[1].split("]")[0].split("|")[1:]
    assert line == "1" and [int(each) for each in place.split(",")][2] == -2000
    made.door(False)
    made.until("Door:0")
    made.machine.send(b"~")
    made.finish()


WRONG = [
    ({"parking": {"axis": "y"}, "homing": {"sensors": {"z": "limit_z"}, "seek_steps_s": 800, "locate_steps_s": 400, "pull_off_steps": 640}}, "an axis y that homes"),
    ({"inputs": [each for each in boards.load("router_3axis")["inputs"] if each["name"] != "door"]}, "door"),
    ({"backlash": {"x": 50}}, "backlash"),
    ({"parking": {"target": 3}}, "unknown key"),
]


@pytest.mark.parametrize("changes, said", WRONG)
def test_board_files_that_cannot_park(changes, said):
    board = router()
    board.update({**changes, "parking": changes.get("parking", board["parking"])})
    with pytest.raises(BoardError, match=said):
        check(board)
