"""Programs begun at any line, or amid one: the virtual router cuts the same as if nothing had happened."""

import collections
import pytest

from host_tools.failure import Failure
from host_tools.programs import gcode_file, resume_line, replay, replay_machine
from router import LASER, Machine, World, answers, home

slow = pytest.mark.slow
PROGRAM = b"""G21 G90 G17
G0 Z-1
M3 S1000
M8
G0 X10 Y8
G1 Z-3 F300
G1 X14 F900
G91
G1 Y3
X-2 Y1
G90
G2 X10 Y10 I0 J-2
G20
G1 X0.5 Y0.4 F40
G21
G10 L2 P2 X2 Y1
G55
G1 X9 Y6 F800
G54
G92 X0 Y0
G1 X2 Y1
G92.1
G18 G3 X9 Z-4 I-1.5 K-2.5
G17
G93 G1 X12 F40
G94
G1 X12 Y9 F700
G0 Z-1
M5 M9
M30
"""


def cut(world):
    """Places passed with the spindle on and the tool down, from rapid moves apart."""
    return {row[1:4] for row in world.path if row[4] and row[3] < -400}


def ready(**changes):
    machine = home(Machine(World((3000, 2500, -1800)), **changes).ready())
    machine.world.path = []
    return machine


def run(machine, lines):
    for line in lines:
        said = machine.ask(line if isinstance(line, str) else line.decode())
        assert answers(said) == ["ok"], (line, said)
    machine.settle()


def lines_of(text, tmp_path):
    path = tmp_path / "job.nc"
    path.write_bytes(text)
    return gcode_file.read(path)


def facts(machine):
    return replay_machine.Machine.of_answers(machine.ask("$$"), machine.ask("$#"))


def modes(machine):
    """Of `$G`, without the mode of motion: no line that does not move sets G2, nor G1 without a feed."""
    return machine.do("$G")[0].partition(" ")[2]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    machine = ready()
    run(machine, [line for _, line in lines_of(PROGRAM, tmp_path_factory.mktemp("whole"))])
    return machine


def strays(places, others, most=1):
    """Places that lie more than `most` steps of an axis from all others."""
    steps = range(-most, most + 1)
    return [
        place for place in places - others
        if not any((place[0] + x, place[1] + y, place[2] + z) in others for x in steps for y in steps for z in steps)
    ]  # fmt: skip


@pytest.mark.parametrize("number", [pytest.param(line, marks=slow) for line in (2, 9, 14, 21)] + [18, 27])
def test_from_line(tmp_path, whole, number):
    lines = lines_of(PROGRAM, tmp_path)
    first = ready()
    run(first, [line for known, line in lines if known < number])
    machine = ready()
    for system in ("G54", "G55"):
        assert system in facts(first).systems
    stages, rest = replay.Replay(facts(machine), lines).from_line(number)
    for _, sent in stages:
        run(machine, sent)
    assert machine.controller.position() == first.controller.position()
    assert modes(machine) == modes(first)
    begun = len(machine.world.path)
    run(machine, [line for _, line in rest])
    assert machine.controller.position() == whole.controller.position()
    missing = [place for place in cut(whole.world) - cut(first.world) - cut(machine.world)]
    assert not missing, missing[:3]
    extra = strays({row[1:4] for row in machine.world.path[begun:] if row[4] and row[3] < -400}, cut(whole.world))
    assert not extra, extra[:3]


HOLES = b"""G21 G90 G17
G10 L1 P1 Z0.5
M3 S1000
G43 H1
G0 Z-1
F900
G99 G83 X10 Y8 Z-3 R-1.5 Q0.8
X12
G98 Y10
G80
G20 G91
G82 X0.1 Z-0.05 R-0.01 P0.02
Y0.1
G21 G90 G80
G0 Z-1
M30
"""


@pytest.mark.parametrize("number", [pytest.param(8, marks=slow), 9, 13])
def test_amid_the_holes_of_a_cycle(tmp_path, number):
    """The line says what its cycle has from the lines before it, and the series begins where G98 goes back to; the tool's length comes
    from the board's table."""
    lines = lines_of(HOLES, tmp_path)
    first, all_of = ready(), ready()
    run(first, [line for known, line in lines if known < number])
    run(all_of, [line for _, line in lines])
    machine = ready()
    run(machine, [b"G10L1P1Z0.5"])
    assert facts(machine).tools == {"T1": 0.5}
    stages, rest = replay.Replay(facts(machine), lines).from_line(number)
    for _, sent in stages:
        run(machine, sent)
    before = ready()
    run(before, [line for known, line in lines if known < (7 if number < 10 else 12)])
    assert machine.controller.position() == first.controller.position()[:2] + before.controller.position()[2:]
    begun = len(machine.world.path)
    run(machine, [line for _, line in rest])
    assert machine.controller.position() == all_of.controller.position()
    assert max(row[3] for row in machine.world.path[begun:]) == max(row[3] for row in all_of.world.path[len(first.world.path) :])
    ends = collections.Counter(row[1:3] for row in all_of.world.path)
    holes = {place for place in cut(all_of.world) - cut(first.world) if ends[place[:2]] > 30}  # not the way from one to the next
    assert len(holes) > 30 and holes <= {row[1:4] for row in machine.world.path[begun:]}


@pytest.mark.parametrize("number", [pytest.param(line, marks=slow) for line in (7, 12, 21, 23, 25)] + [10])
def test_amid_a_line(tmp_path, whole, number):
    lines = lines_of(PROGRAM, tmp_path)
    first = ready()
    run(first, [line for known, line in lines if known < number])
    begun = len(first.world.path)
    run(first, [line for known, line in lines if known == number])
    way = first.world.path[begun:]
    origin = [at - zero for at, zero in zip(first.world.place, first.controller.position())]
    for part in (6,):
        place = [at - zero for at, zero in zip(way[len(way) * part // 10][1:4], origin)]
        machine = ready()
        stages, rest = replay.Replay(facts(machine), lines).from_place(number, place)
        done = {row[1:4] for row in first.world.path[: begun + len(way) * part // 10 + 1] if row[4] and row[3] < -400}
        for what, sent in stages:
            run(machine, sent)
            if what == replay.DOWN:
                assert machine.controller.position() == place
        run(machine, [line for _, line in rest])
        assert machine.controller.position() == whole.controller.position()
        again = cut(machine.world)
        # An arc is drawn about its centre anew from a place that is rounded to steps.
        missing = strays(cut(whole.world) - done, again, 2)
        assert not missing, (number, part, missing[:3])
        at = way[len(way) * part // 10][1:3]
        extra = {point for point in strays(again, cut(whole.world), 2) if point[:2] != at}
        assert not extra, (number, part, list(extra)[:3])


@pytest.mark.parametrize("mode, share", [("M3", 0.3), ("M3", 0.55), ("M3", 0.999), ("M4", 0.4)])
def test_amid_a_row_of_dots(tmp_path, mode, share):
    """From the very step on, each dot with its power: nothing is burnt twice, and nothing left out."""
    powers = [10, 700, 1000, 1000, 0, 20.5, 300, 400, 500, 600, 700, 800, 900, 1000, 50, 999]
    text = f"G21G91\n{mode}S0\nG1X2F1200S0\nX3.3S{':'.join(map(str, powers))}\nX1\nX-1S500:0\nM5\nM2\n".encode()
    lines = lines_of(text, tmp_path)
    whole, part = ready(spindle=LASER), ready(spindle=LASER)
    made = []
    for machine, count in ((whole, 5), (part, 3)):
        machine.world.burnt = []
        run(machine, [line for _, line in lines[:count]])
        made.append(machine.world.burnt)
    total = 1056  # of X
    way = [row[1:] for row in made[0][len(made[1]) : len(made[1]) + total]]
    steps = round(share * total) if share < 0.99 else total - 1
    x, y = way[steps - 1][:2] if steps else made[1][-1][1:3]
    at = part.controller.position()
    place = [at[0] + x - part.world.place[0], at[1] + y - part.world.place[1], at[2]]
    resumed = ready(spindle=LASER)
    resumed.world.burnt = []
    state = replay.Replay(facts(resumed), lines)
    stages, rest = state.from_place(4, place)
    assert state.dot == (steps * 16 // total + 1, 16)
    for what, sent in stages:
        if what == replay.GO:
            assert resumed.controller.position() == place and not [row for row in resumed.world.burnt if row[3]]
            resumed.world.burnt = []
        run(resumed, sent)
    again = [row[1:] for row in resumed.world.burnt]
    run(resumed, [line for _, line in rest])
    run(whole, [line for _, line in lines[5:]])
    assert resumed.controller.position() == whole.controller.position()
    assert [row[:2] for row in again] == [row[:2] for row in way[steps:]]
    if mode == "M4":
        way, again = ([(*row[:2], row[2] > 0) for row in rows] for rows in (way, again))
    apart = [index for index, (was, now) in enumerate(zip(way[steps:], again)) if was != now]
    assert len(apart) <= 16 and not any(two - one == 1 for one, two in zip(apart, apart[1:])), apart
    end = [row[3] for row in resumed.world.burnt[len(again) : len(again) + 320]]
    assert set(end) == {10} if mode == "M3" else 0 < max(end) <= 10, "behind the row S is its first"


def test_a_row_is_interrupted_a_second_time(tmp_path):
    """The rest of a row goes as several lines of its number; the journal says that it was done where one of them ended."""
    lines = lines_of(b"G21G90\nM3S0\nG1X2F1200S0\nX3.6S10:20:30:40:50:60:70:80\nX5S0\nM2\n", tmp_path)
    machine = facts(ready(spindle=LASER))
    target, row = (round(mm * machine.steps_per_mm[0]) for mm in (2, 3.6))
    _, _, dot = resume_line.plan_stages(machine, lines, 5, None, [(target + row) // 2, 0, 0])
    assert dot == (5, 8)
    _, rest, dot = resume_line.plan_stages(machine, lines, 5, None, [row, 0, 0])
    assert dot is None and [number for number, _ in rest] == [5, 6]
    with pytest.raises(Failure, match="before line 5 the machine was at"):
        resume_line.plan_stages(machine, lines, 5, None, [row + 100, 0, 0])


def test_what_cannot_be_replayed(tmp_path):
    machine = facts(ready())
    with pytest.raises(Failure, match="ends before line 9"):
        replay.Replay(machine, lines_of(b"G21\nG1X1F100\n", tmp_path)).from_line(9)
    with pytest.raises(Failure, match="line 1.*error 20"):
        replay.Replay(machine, lines_of(b"G21G7\nG1X1F100\n", tmp_path)).from_line(2)
    with pytest.raises(Failure, match="line 1 probes"):
        replay.Replay(machine, lines_of(b"G38.2X1F100\nG1X1F100\n", tmp_path)).from_line(2)
    with pytest.raises(Failure, match="cannot be replayed"):
        replay.Replay(machine, lines_of(b"$H\nG1X1F100\n", tmp_path)).from_line(2)
    with pytest.raises(Failure, match="not on its path"):
        replay.Replay(machine, lines_of(b"G21\nG1X1F100\n", tmp_path)).from_place(2, [100, 100, 0])
