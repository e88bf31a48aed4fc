"""Programs of four axes that are begun at any line, or amid one, and boards that have started anew since they were interrupted."""

import copy

import pytest
from asked import Asked

from host_tools import boards
from host_tools.failure import Failure
from host_tools.programs import gcode_file, replay
from host_tools.programs.resume_line import number_of, plan_stages, resume_point
from host_tools.programs.replay_machine import ENDLESS, Machine
from host_tools.sim.pages import Pages

PROGRAM = b"""G21 G90 G17
G0 Z-5 A30
G1 X10 Y8 A90 F3000
G1 A-45 F3600
G91
G1 X3 A400
G90
G20
G1 X0.5 A20 F60
G21
G10 L2 P2 X2 Y1 A15
G55
G1 X9 Y6 A10 F1200
G54
G93 G1 X12 A100 F40
G94
G92 A0
G1 X10 A50 F900
G92.1
G2 X14 Y7 I2 J0 F800
G1 Y5 A33
M30
"""
START = (2000, 2000, -2000, 0)


def table(rotary=True, pages=None, **more):
    board = {**copy.deepcopy(boards.load("router_4axis")), **more}
    for link in board["links"]:
        link.pop("lost")
    if not rotary:
        del board["rotary"]
        board["axes"][3].update(steps_per_m=53_333, travel_steps=60_000, max_mm_min=6000, accel_mm_s2=400)
        board["homing"] = {**board["homing"], "high_end": board["homing"].get("high_end", "")}
    machine = Asked(board, start=START, pages=pages)
    machine.do("$X", "$H")
    return machine


def facts(machine):
    return Machine.of_answers(*(machine.ask(f"${what}").splitlines() for what in "$#I"))


def at(machine):
    machine.stand()
    return list(machine.plant.position)


@pytest.fixture
def lines(tmp_path):
    path = tmp_path / "job.nc"
    path.write_bytes(PROGRAM)
    return gcode_file.read(path)


@pytest.fixture(scope="module")
def ends(tmp_path_factory):
    """{line: where it ends} of the whole program, by a board that turns."""
    path = tmp_path_factory.mktemp("whole") / "job.nc"
    path.write_bytes(PROGRAM)
    machine = table()
    found = {}
    for number, line in gcode_file.read(path):
        machine.do(line.decode())
        found[number] = at(machine)
    assert found[6][3] > 15_000 and len({tuple(place) for place in found.values()}) > 9
    return found


def goes_on(machine, stages, rest, ends, most=1):
    for _, sent in stages:
        machine.do(*sent)
    for number, line in rest:
        machine.do(line.decode())
        assert all(abs(one - other) <= most for one, other in zip(at(machine), ends[number])), (number, at(machine), ends[number])


@pytest.mark.parametrize("number", (3, 4, 6, 7, 9, 10, 13, 15, 18, 20, 21))
def test_from_a_line(lines, ends, number):
    machine = table()
    assert facts(machine).turns == 1 | ENDLESS
    stages, rest = replay.Replay(facts(machine), lines).from_line(number)
    goes_on(machine, stages, rest, ends)


@pytest.mark.parametrize("number, delay_ms", [(3, 150), (4, 700), (6, 700), (9, 150), (13, 60), (15, 400), (18, 80), (20, 150), (21, 60)])
def test_amid_a_line(lines, ends, number, delay_ms):
    """The machine is stopped on the way of that line, and goes on from there to the step."""
    machine = table()
    for known, line in lines:
        if known == number:
            break
        machine.do(line.decode())
    machine.stand()
    machine.machine.send(lines[number - 1][1] + b"\n")
    machine.machine.run_ms(delay_ms)
    machine.machine.send(b"!")
    machine.machine.run_ms(2000)
    place = list(machine.plant.position)
    assert place != ends[number] and place != ends[number - 1], "it is amid the line"
    machine.machine.send(b"\x18")
    machine.machine.run_ms(300)
    machine.do("$X")
    fresh = Machine.of_answers(machine.ask("$$").splitlines(), [], machine.ask("$I").splitlines())
    stages, rest = replay.Replay(fresh, lines).from_place(number, place)
    goes_on(machine, stages, rest, ends)


def test_a_linear_fourth_axis(lines):
    """A counts millimetres then: it goes to its place with X and Y, and G20 scales it."""
    machine = table(rotary=False)
    known = facts(machine)
    assert known.turns == 0 and len(known.steps_per_mm) == 4
    inches = [(1, b"G20 G90"), (2, b"G0 Z-0.2 A2"), (3, b"G1 X1 Y1 A3 F60"), (4, b"G1 A1")]
    for _, line in inches[:3]:
        machine.do(line.decode())
    wanted = at(machine)
    other = table(rotary=False)
    stages, rest = replay.Replay(facts(other), inches).from_line(4)
    for _, sent in stages:
        other.do(*sent)
    assert all(abs(one - two) <= 1 for one, two in zip(at(other), wanted)) and rest == inches[3:]


def test_the_short_way_is_replayed():
    short = {"short_way": True}
    machine = table(**short)
    assert ",SHORT" in machine.ask("$I") and facts(machine).turns == 7
    lines = [(1, b"G21 G90"), (2, b"G1 A170 F3600"), (3, b"G1 A-170"), (4, b"G1 A10")]
    for _, line in lines[:3]:
        machine.do(line.decode())
    wanted = at(machine)
    assert wanted[3] > 9000, "forth, to 190 degrees"
    other = table(**short)
    stages, _ = replay.Replay(facts(other), lines).from_line(4)
    for _, sent in stages:
        other.do(*sent)
    assert (at(other)[3] - wanted[3]) % 19200 in (0, 1, 19199), "the same angle"


def test_a_board_that_has_started_anew_does_not_know_its_table(lines):
    """Homing brings X, Y and Z back. A counts from where it stood then: the job is not gone on with unless the operator says so."""
    pages = Pages()
    machine = table(pages=pages)
    machine.do(f"$JR={number_of(lines):08x}")
    for number, line in lines[:4]:
        machine.do(f"N{number}" + line.decode())
    machine.stand()
    machine.machine.run_ms(3000)
    said = machine.ask("$JR").splitlines()
    assert resume_point(said, lines)[2], "known while it is on"
    machine.do("$H")
    assert resume_point(machine.ask("$JR").splitlines(), lines)[2], "and as long as it stays on"

    again = table(pages=pages)
    said = again.ask("$JR").splitlines()
    number, place, known = resume_point(said, lines)
    assert (number, place, known) == (5, None, False)
    end = [int(each) for each in said[0].split("|")[3].rstrip("]").split(",")]
    with pytest.raises(Failure, match=r"A homes at no sensor .* left it at -45\.\d+ degrees"):
        plan_stages(facts(again), lines, number, place, end, known)
    stages, rest, _ = plan_stages(facts(again), lines, number, place, end, True)
    assert stages and rest[0][0] == 5
    again.do("$JR=12345678")
    assert "[JOURNAL:12345678|0|2|" in again.ask("$JR"), "the next job's is known"


def test_three_axes_are_known_once_they_have_homed(lines):
    pages = Pages()
    board = copy.deepcopy(boards.load("router_3axis"))
    for link in board["links"]:
        link.pop("lost", None)
    job = [(1, b"G21G90"), (2, b"G1X10F3000"), (3, b"G1X20")]
    for count in (2, 0):
        machine = Asked(board, start=START[:3], pages=pages)
        machine.do("$X", "$H")
        if count:
            machine.do(f"$JR={number_of(job):08x}", *(f"N{number}" + line.decode() for number, line in job[:count]))
            machine.stand()
            machine.machine.run_ms(3000)
    assert resume_point(machine.ask("$JR").splitlines(), job)[2]
