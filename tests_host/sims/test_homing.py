"""Homing on a whole virtual router: the same place every time, each axis alone or several at once, a gantry square; and every
failure ends, within its distance, in the alarm that grbl has for it."""

import random
import re

import pytest
from gantry import START, Router, board

from host_tools.sim.machine import VirtualMachine
from passo import errors
from passo.config.board_error import BoardError
from passo.config.boardfile import check

PULL_OFF = 640
RACK = 200


def machine(gantry=True, encoders=(), start=(3000, 2500, -1800), homing=None, options=None, axes=None, **changes):
    """A Router with `homing` keys changed, and with `axes`, if there are any, for its own."""
    made = board(encoders, **changes)
    made["axes"] = axes or made["axes"]
    if not gantry:
        made["gantry"] = None
        del made["gantry"]
        made["axes"] = [dict(axis, pins=[number + 2, number + 6]) for number, axis in enumerate(made["axes"])]
        made["player"] = "timer"
        made["drive"] = dict(made["drive"], pulse_us=20)
        made["speed"] = dict(made["speed"], max=8000)
    made["homing"] = {**made["homing"], "latch": True, **(homing or {})}
    return Router(made, start=start, **(options or {}))


@pytest.mark.parametrize("runs", (9, pytest.param(94, marks=pytest.mark.slow)))
def test_from_anywhere_on_barriers_that_bounce(runs):
    """Zero is the same place, to the step, on each axis and each side of the gantry: a hundred times."""
    chance = random.Random(3)
    places = set()
    for turn in range(6):
        start = (chance.randint(-600, 3000), chance.randint(-600, 3000), -chance.randint(-600, 3000))
        router = machine(start=start, options={"bounce_ms": 3, "seed": turn, "racked": chance.randint(-20, 20)}, homing={"order": "xyz ", "locate_steps_s": 2000})
        assert "ok" in router.go("$H") and router.controller.machine.homed
        places.add((*router.plant.position, router.plant.skew_steps()))
    assert all(abs(place) <= 1 for found in places for place in found), places
    said = router.ask(f"$HR={runs}")
    found = re.findall(r"\[HOM:(\w+),(\d+),(\d+),(\d+\.\d+),(.*?)\]", said)
    assert [line[:2] for line in found] == [(name, str(runs)) for name in ("x", "x2", "y", "z")]
    assert all(int(line[2]) <= 1 and float(line[3]) <= 0.5 and line[4] == "good" for line in found), found
    assert (*router.plant.position, router.plant.skew_steps()) in places


@pytest.mark.parametrize("name", ("laser_xy", "corexy_plotter"))
def test_a_step_between_the_position_and_the_look_is_counted(name, monkeypatch):
    """A slow chip reads its sensor 1.5 ms after the position: zero is to the step all the same, from whatever moment the axes begin."""
    for turn in range(6):
        slow = VirtualMachine(name, start=(40 + turn, 30 + 2 * turn))
        queue, port = slow.app.controller.queue, slow.port

        def axis(number, edge=None, real=queue.axis, port=port):
            found = real(number, edge)
            port.advance(18_750)
            return found

        monkeypatch.setattr(queue, "axis", axis)
        slow.run_ms(100 + turn)
        slow.take()
        slow.send(b"$H\n")
        slow.run_until(lambda slow=slow: b"ok" in slow.replies_so_far(), 60_000)
        slow.settle()
        assert slow.plant.position == [0, 0] and not slow.plant.errors, turn


@pytest.mark.parametrize("racked", (-20, -7, -1, 0, 1, 12, 20))
@pytest.mark.parametrize("offset", (0, 15, -9))
def test_a_racked_gantry_comes_out_square(racked, offset):
    from passo.options.gantry.errors import SQUARED

    router = machine(("x", "x2", "y"), options={"bounce_ms": 2, "racked": racked}, offset_steps=offset)
    assert router.plant.skew_steps() == racked
    router.go("$H")
    assert router.plant.skew_steps() == 0 and router.plant.position == [0, 0, 0] == router.controller.position()
    assert not router.noted(SQUARED), "counts of before the homing must not matter"
    router.go("G90")
    router.go("G1X10F2000")
    assert router.plant.skew_steps() == 0 and router.plant.position[0] == 3200


def test_axes_at_once_are_as_exact_and_sooner():
    times = []
    for order in ("zxy", "z xy"):
        router = machine(homing={"order": order}, options={"bounce_ms": 2})
        begun = router.machine.now_ms()
        router.go("$H")
        times.append(router.machine.now_ms() - begun)
        assert router.plant.position == [0, 0, 0] and router.controller.machine.homed
    assert times[1] < times[0]


def test_one_axis_alone():
    router = machine(options={"bounce_ms": 2})
    for axis, homed in (("Y", False), ("X", False), ("Z", True)):
        before = list(router.plant.position)
        assert router.go("$H" + axis).endswith("ok\r\n")
        number = "XYZ".find(axis)
        assert [at == was for at, was in zip(router.plant.position, before)] == [each != number for each in range(3)]
        assert router.plant.position[number] == 0 and router.controller.position()[number] == 0
        assert router.controller.machine.homed == homed, "once all of them have been"
    router.go("G90")
    router.go("G1X10Y10Z-5F3000")
    router.go("$HX")
    assert router.controller.machine.homed and router.controller.position() == router.plant.position == [0, 3200, -2000]
    router.machine.send(b"$J=X20F3000\n")
    router.machine.run_ms(300)
    router.machine.send(b"\x18")
    router.machine.run_ms(300)
    router.ask("$X")
    assert not router.controller.machine.homed
    router.go("$HX")
    assert not router.controller.machine.homed, "the other axes' positions are not known"


def test_speeds_pull_off_and_distance_of_an_axis():
    each = {"y": {"pull_off_steps": 100, "seek_steps_s": 1000, "locate_steps_s": 50}, "z": {"distance_steps": 1000}}
    router = machine(homing={"each": each}, start=(3000, 2500, -300))
    router.go("$H")
    assert router.plant.position == [0, 0, 0]
    intervals = []
    last = [0, list(router.plant.position)]

    def watch(tick, levels, changed, edges=router.machine.port._player._edges):
        edges(tick, levels, changed)
        if router.plant.position[1] != last[1][1]:
            intervals.append(tick - last[0])
            last[0], last[1] = tick, list(router.plant.position)

    router.machine.port._player._edges = watch
    router.go("$HY")
    assert sorted(intervals)[6] >= 12_500_000 // 1000 - 1, "but for the first step of each phase, which follows a halt"
    far = machine(homing={"each": each}, start=(3000, 2500, -2500))
    far.machine.send(b"$H\n")
    far.machine.run_ms(3000)
    assert far.controller.machine.alarm == errors.ALARM_SENSOR_DEAD
    assert abs(far.plant.position[2] + 2500) <= 1001 and far.plant.position[:2] == [3000, 2500]


def test_an_edge_is_caught_at_its_step_not_at_a_cycle_of_the_loop():
    """Located so fast that there are several steps from one look to the next."""
    ranges = []
    for latched in (True, False):
        router = machine(homing={"locate_steps_s": 7000}, options={"bounce_ms": 1})
        if not latched:
            router.machine.port.watch_limit = lambda name: None  # as if the sensors had no interrupts
        found = []
        for turn in range(6):
            router.go("$H")
            found.append(router.plant.position[1])
            router.go("G90")
            router.go(f"G1Y{turn + 1}.{turn}3F900")
        ranges.append(max(found) - min(found))
    assert ranges[0] == 0 < ranges[1], ranges


FAULTS = [
    ({"limit_x": "dead", "limit_x2": "dead"}, 9),
    ({"limit_x": "stuck"}, 8),
    ({"limit_x2": "stuck"}, 8),
    ({"limit_x2": "dead"}, 10),
    ({"limit_x": "dead"}, 10),
    ({"limit_y": "dead"}, 9),
    ({"limit_y": "stuck"}, 8),
    ({"limit_z": "dead"}, 9),
    ({"limit_z": "stuck@200"}, 8),
]


@pytest.mark.parametrize("faults, alarm", FAULTS, ids=lambda item: str(item))
@pytest.mark.parametrize("order", ("zxy", " zxy"))
def test_every_failure_ends_in_its_alarm_and_within_its_distance(faults, alarm, order):
    axes = [{**axis, "travel_steps": axis["travel_steps"] // 4} for axis in board()["axes"]]
    router = machine(options={"faults": faults, "bounce_ms": 1}, homing={"order": order}, axes=axes)
    start = list(router.plant.position)
    router.machine.send(b"$H\n")
    router.machine.run_until(lambda: b"Grbl 1.1h" in router.machine.replies_so_far(), 60_000)
    said = router.machine.take().decode()
    assert f"ALARM:{alarm}\r\n" in said and "ok\r\n" in said, said
    assert router.controller.machine.alarm == 200 + alarm and not router.controller.machine.homed
    assert abs(router.plant.skew_steps()) <= RACK + 1
    for axis, at, begun in zip(axes, router.plant.position, start):
        assert abs(at - begun) <= axis["travel_steps"] + 2 * max(axis["travel_steps"] // 10, 5 * PULL_OFF)
    router.plant.mend_inputs()
    for motor, at, begun in zip("xyz", router.plant.position, start):
        router.plant.slip_motor(motor, begun - at)  # by hand, off a hard end
    router.plant.slip_motor("x2", -router.plant.skew_steps())
    router.machine.run_ms(100)
    router.machine.send(b"\x18")
    router.machine.run_ms(100)
    router.machine.take()
    assert router.go("$H").startswith("ok") and router.controller.machine.homed, "once it is repaired"
    assert router.plant.position == [0, 0, 0] and router.plant.skew_steps() == 0


@pytest.mark.parametrize("after_ms", (100, 700, 1500, 2500, 3500, 4200))
def test_a_reset_and_the_door_end_it_at_any_moment(after_ms):
    for what, alarm in ((b"\x18", 6), (b"\x84", 7)):
        router = machine(options={"racked": 20})
        router.machine.send(b"$H\n")
        router.machine.run_ms(after_ms)
        if router.controller.state != "home":
            continue
        router.machine.send(what)
        router.machine.run_ms(200)
        assert f"ALARM:{alarm}" in router.machine.take().decode()
        at = list(router.plant.position), router.plant.skew_steps()
        router.machine.run_ms(500)
        assert at == (router.plant.position, router.plant.skew_steps()) and abs(at[1]) <= RACK + 20
        router.ask("$X")
        router.go("$H")
        assert router.plant.position == [0, 0, 0] and router.plant.skew_steps() == 0


def test_what_cannot_be_asked_is_refused():
    router = machine()
    assert [router.ask(line)[:8] for line in ("$HA", "$HR=0", "$HR=101", "$HR=x", "$HXY")] == ["error:3\r"[:8]] * 5
    plain = Router(board(()), start=START)
    assert plain.ask("$HR=5").startswith("error:106"), "without homing.latch nothing is judged"


@pytest.mark.parametrize(
    "keys, said",
    [
        ({"order": "zz"}, "every axis with a sensor once"),
        ({"order": "z x"}, "every axis with a sensor once"),
        ({"each": {"a": {}}}, "homing.each: 'a'"),
        ({"each": {"x": {"order": 1}}}, "unknown key 'order'"),
        ({"each": {"x": {"pull_off_steps": 0}}}, "homing.each.x.pull_off_steps: 0 is not within"),
    ],
)
def test_what_cannot_be_is_refused(keys, said):
    wrong = board()
    wrong["homing"] = {**wrong["homing"], **keys}
    with pytest.raises(BoardError) as refused:
        check(wrong)
    assert said in str(refused.value)
