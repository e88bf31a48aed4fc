"""A router with a rotary table on the virtual board: feeds, positions, homing, offsets, halts, files that are refused; and A as a fourth linear axis."""

import copy
import math
import random

import pytest
from asked import Asked
from passo.config.board_error import BoardError
from passo.config.boardfile import check
from typer.testing import CliRunner

from host_tools import boards
from host_tools.cli.main import app
from host_tools.sim.machine import VirtualMachine

NAME = "router_4axis"
US_PER_S = 1_000_000


def board_of(rotary=True, **more):
    board = {**copy.deepcopy(boards.load(NAME)), **more}
    board["journal"] = None
    for link in board["links"]:
        link.pop("lost")
    if not rotary:
        del board["rotary"]
        board["axes"][3].update(steps_per_m=80_000, travel_steps=32_000, max_mm_min=6000, accel_mm_s2=400)
    return board


class Table(Asked):
    def __init__(self, start=(2000, 2000, -2000, 0), rotary=True, unlock=True, **more):
        Asked.__init__(self, board_of(rotary, **more), start=start)
        if unlock:
            self.do("$X")

    def settle(self):
        self.stand()
        return list(self.plant.position)

    def seconds(self, *lines):
        """From the first step to the last."""
        before = len(self.machine.trace.rows())
        self.do(*lines)
        self.settle()
        rows = self.machine.trace.rows()[before:]
        return (rows[-1][0] - rows[0][0]) / US_PER_S

    def status(self):
        self.machine.take()
        self.machine.send(b"?")
        self.machine.run_until(lambda: b">" in self.machine.replies_so_far(), 1000)
        return self.machine.take().decode()


@pytest.fixture
def table():
    return Table()


def lasts(mm_or_degrees, per_min, accelerations):
    """Seconds of a move that speeds up and slows down: `accelerations` that the axes allow along it, of which the least counts."""
    speed = per_min / 60
    return mm_or_degrees / speed + speed / min(accelerations)


@pytest.mark.parametrize("x, a", [(50, 900), (50, -90), (-3, 360), (20, 0.5), (0, 360), (0, -7)])
@pytest.mark.parametrize("feed", [pytest.param(60, marks=pytest.mark.slow), 600])
def test_f_counts_for_the_linear_axes_and_degrees_only_where_nothing_else_moves(table, x, a, feed):
    if x and abs(a / x) * feed > 21_600:
        feed = 60
    whole = math.hypot(x, a)
    along = x or a
    # The speed along all axes is the feed times whole / along; so are the accelerations seen along the linear part.
    accelerations = [limit * abs(along / part) for limit, part in ((250, x), (1000, a)) if part]
    found = table.seconds("G91", f"G1X{x}A{a}F{feed}")
    assert found == pytest.approx(lasts(abs(along), feed, accelerations), rel=0.001, abs=0.03), whole
    assert table.machine.app.controller.queue.position() == [x * 320, 0, 0, round(a * 53.333)]


@pytest.mark.parametrize("words, seconds", [("G93 G1X10A90F2", 30), ("G93 G1A90F4", 15), ("G20 G1A90F90", 60), ("G20 G1X1A90F2", 30), ("G1A90F90", 60)])
def test_other_feeds(table, words, seconds):
    """G93: the time of the line. G20: A in degrees, and degrees a minute where only A moves."""
    assert table.seconds("G91", words) == pytest.approx(seconds, rel=0.01)
    assert table.plant.position[3] == round(90 * 53.333)


@pytest.mark.parametrize(
    "lines, seconds",
    [
        (("G21F90", "G20", "G1A90"), 60), (("G20F90", "G21", "G1A90"), 60), (("G21G1X0F90", "G20G1A90"), 60), (("G20G1X0F90", "G21", "G1X0", "G1A90"), 60),
        (("G21F900", "G20", "G1X0", "G1X0A0", "G1A0", "G1A90F90"), 60), (("G20F2", "G21", "G1X25.4A90"), 30),
    ],
)  # fmt: skip
def test_degrees_a_minute_are_the_number_that_was_given(table, lines, seconds):
    """In whichever unit the lines before it were, singly or in a batch; where X moves, too, it is a length."""
    assert table.seconds("G91", *lines) == pytest.approx(seconds, rel=0.01)
    assert table.plant.position[3] == round(90 * 53.333)


def test_the_short_way_is_half_a_turn_at_most():
    table = Table(short_way=True)
    for words, degrees in (("G90G0A350", -10), ("A0", 0), ("A180", 180), ("A0", 0), ("A-180", -180), ("G91G1A540F21600", 360), ("G90G1X1A10F6000", 370),
                           ("G53G0A0", 360), ("G10L20P1A90", 360), ("G0A80", 350), ("G53G0A190", 190), ("G0A270", 180)):  # fmt: skip
        table.do(words)
        assert abs(table.machine.app.controller.machine.target[3] - degrees * 53.333) <= 1, words
    random_ = random.Random(3)
    for _ in range(60):
        before = table.machine.app.controller.machine.target[3]
        wanted = random_.randrange(-2_000_000, 2_000_000) / 1000
        table.do(f"G53G0A{wanted:.3f}")
        gone = table.machine.app.controller.machine.target[3]
        assert abs(gone - before) <= 180 * 53.333 + 1 and abs((gone / 53.333 - wanted + 180) % 360 - 180) < 0.02, wanted
    table.settle()


def test_without_the_key_a_turns_as_far_as_its_word_says():
    table = Table()
    table.do("G90G0A350")
    assert table.machine.app.controller.machine.target[3] == round(350 * 53.333)


def test_a_linear_fourth_axis_counts_like_the_others():
    table = Table(rotary=False)
    found = table.seconds("G91", "G1X30A40F600")
    assert found == pytest.approx(lasts(50, 600, (250 * 50 / 30, 400 * 50 / 40)), rel=0.001)
    table.do("G20", "G1A1F60")
    assert table.settle()[3] == round(40 * 80 + 25.4 * 80)


def test_a_table_turns_without_an_end_and_homing_leaves_it_where_it_stands():
    table = Table(unlock=False)
    said = table.ask("$H")
    assert said.endswith("ok") and table.settle() == [0, 0, 0, 0]
    table.do("G91", "G1A1800F21600", "G1A360", "G1A-2760")
    assert table.settle()[3] == round(53.333 * -600)
    table.do("$20=1", "G1A-300")
    assert table.settle()[3] == round(53.333 * -900) and "MPos:0.000,0.000,0.000,-900." in table.status()
    assert table.ask("G1X-1F100").startswith("ALARM:2"), "the travel of X holds"
    table = Table(start=(2000, 2000, -2000, 0), unlock=False)
    table.do("$X", "G91G1A90F3600")
    table.settle()
    table.do("$H")
    assert table.settle() == [0, 0, 0, 4800] and ",90.0" in table.status()
    assert table.ask("$HA").startswith("error"), "it has no sensor"


def test_offsets_jogs_and_returns(table):
    table.do("G1A90F3600", "G92A0", "G10L2P2A30", "G54G1A10")
    assert table.settle()[3] == 5333
    table.do("G92.1", "G55G1A0", "G28.1", "G54")
    table.settle()
    table.do("$J=G91A-45F3600")
    assert table.settle()[3] == round(-15 * 53.333)
    table.do("G28A0", "G30")
    assert table.settle()[3] == 0
    said = table.ask("$#")
    assert "[G55:0.000,0.000,0.000,30.000]" in said and "[G28:0.000,0.000,0.000,30.000]" in said
    assert "[AXS:4:XYZA]\r\n[ROTARY:A,ENDLESS]\r\n" in table.ask("$I") and "$103=53.333" in table.ask("$$")
    table.settle()
    table.do("$13=1")
    assert "A" not in table.status() and ",0.000" in table.status(), "degrees are no inches: $13 counts for nothing here"


def test_what_is_refused_moves_nothing(table):
    for line, number in (("G2X5Y5I5A10F600", 20), ("G81X1Z-1R-1A5F60", 20), ("G1A1A2F60", 25), ("G1B5F60", 20), ("G1A50000F60", 15)):
        assert table.ask(line) == f"error:{number}", line
    assert table.settle() == [2000, 2000, -2000, 0]
    table.do("G2X5Y5I5J0F600", "G81X6Y5Z-1R-0.5F600", "G80")
    assert table.settle()[3] == 0


def test_three_axes_have_no_a():
    machine = VirtualMachine("router_3axis")
    machine.send(b"$X\n$I\n")
    machine.run_ms(500)
    assert b"AXS" not in machine.take()
    machine.send(b"G1A1F60\nG0A1A2\n$HA\n")
    machine.run_ms(500)
    assert machine.take() == b"error:20\r\nerror:20\r\nerror:3\r\n"


def test_a_hold_amid_a_turn_goes_on_to_the_step(table):
    table.do("G91", "G1X20A1000F600")
    for _ in range(20):
        table.machine.run_ms(90)
        table.machine.send(b"!")
        table.machine.run_ms(300)
        assert "Hold:0" in table.status()
        table.machine.send(b"~")
    assert table.settle() == [2000 + 6400, 2000, -2000, 53_333]


@pytest.mark.parametrize("rotary", [True, False])
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 6))])
def test_random_programs_end_to_the_step_within_all_limits(seed, rotary):
    """Lines of any of four axes, by the kernel and by the parser: where they end, and no axis faster than it may be."""
    chance = random.Random(seed)
    table = Table(rotary=rotary, start=(48_000, 32_000, -16_000, 0 if rotary else 16_000))
    start = list(table.plant.position)
    per_mm = (320, 320, 400, 53.333 if rotary else 80)
    at = [0.0] * 4
    before = len(table.machine.trace.rows())
    for _ in range(30):
        at = [chance.choice((here, here, round(chance.uniform(-20, 20), 3))) for here in at]
        words = "".join(f"{letter}{to:.3f}" for letter, to in zip("XYZA", at))
        table.do(f"{chance.choice(('G0', 'G1'))}{words}F{chance.randint(60, 6000)}")
    places = table.settle()
    assert places == [begun + math.floor(abs(to) * each + 0.5) * (1 if to >= 0 else -1) for begun, to, each in zip(start, at, per_mm)]
    rows = table.machine.trace.rows()[before:]
    for axis, fastest in enumerate((5000, 5000, 1500, 21_600 if rotary else 6000)):
        steps_s = fastest / 60 * per_mm[axis]
        window = US_PER_S // 50
        moved, first = 0, 0
        changes = [(row[0], abs(row[1 + axis] - last[1 + axis])) for last, row in zip(rows, rows[1:])]
        for us, steps in changes:
            moved += steps
            while changes[first][0] <= us - window:
                moved -= changes[first][1]
                first += 1
            assert moved <= steps_s / 50 * 1.01 + 1, (axis, us)


def test_passo_check_says_degrees(tmp_path):
    """A drawing on a cylinder: no axis is out of its travel, and A is listed in degrees."""
    file = tmp_path / "cylinder.nc"
    file.write_text("G21G90\nG1X10A720F600\nG93G1X0A-90F6\nG94\nM30\n")
    done = CliRunner().invoke(app, ["check", str(file), "--board", NAME])
    assert done.exit_code == 0, done.output
    assert "A         -90.0" in done.output and "720.0" in done.output and "°" in done.output.split("\nA")[1]


def test_a_board_file_says_which_axis_turns():
    board = board_of()
    wrong = {**board, "rotary": "z"}, {**boards.load("router_3axis"), "rotary": "a"}, {**board, "axes": [*board["axes"][:3], {**board["axes"][3], "name": "b"}]}
    for each in (*wrong, {**board, "links": [{**link, "protocol": "plotter"} for link in board["links"]]}):
        with pytest.raises(BoardError, match="rotary"):
            check(copy.deepcopy(each))
    for other in ({"backlash": {"x": 20}}, {"kinematics": "corexy"}):
        with pytest.raises(BoardError, match="remove"):
            check({**copy.deepcopy(board), **other})
    assert check(copy.deepcopy(board))["additions"].queue == "passo.options.rotary.control"
