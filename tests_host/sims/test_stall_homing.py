"""Homing by StallGuard: motors feel the ends of their axes, on a plant whose signal trembles, with a motor an axis and on one belt."""

import copy

import pytest
from asked import Asked

from host_tools import boards
from passo import errors
from passo.config.board_error import BoardError
from passo.config.boardfile import check

FULL = 16  # steps of a full step
STALL = 40  # of SG_RESULT 200 in the plant


def router(**changes):
    """X and Y feel their ends, Z has a switch."""
    board = {**copy.deepcopy(boards.load("router_tmc2209")), "idle_release_ms": 0, "journal": None}
    for motor in board["drivers"]["motors"][:2]:
        motor.update({"stall": STALL, "stall_ma": 400, **changes})
    board["drivers"]["motors"][1]["stealth"] = False
    for item in board["inputs"][:2]:
        item.update(active=1, pull="down", pin=item["pin"])
    board["homing"] = {**board["homing"], "debounce_ms": 2, "each": {axis: {"seek_steps_s": 4000, "pull_off_steps": 400} for axis in "xy"}}
    return board


def plotter():
    """A belt of two motors, both of which feel."""
    board = {**copy.deepcopy(boards.load("corexy_plotter")), "idle_release_ms": 0}
    motors = [{"axis": axis, "address": number, "current_ma": 700, "stall": STALL, "stall_ma": 400} for number, axis in enumerate("xy")]
    board["drivers"] = {"port": "uart1", "tx": 20, "rx": 21, "motors": motors}
    board["homing"] = {**board["homing"], "debounce_ms": 2, "seek_steps_s": 4000, "pull_off_steps": 400}
    return board


MACHINES = {"router": (router, "xy"), "belt": (plotter, "xy")}


def homed(make, count, often=0.0, seed=1):
    """(where X and Y stand after each of `count` homings from anywhere, the machine)."""
    machine = Asked(make(), stalls=seed, seed=seed)
    slipping = machine.plant.slipping
    slipping.spike(often)
    places = []
    machine.do("$X")
    for number in range(count):
        machine.do("$H")
        places.append(list(machine.plant.position[:2]))
        assert not machine.plant.errors, machine.plant.errors[:3]
        away = [(number * 7919) % 97 + 1, (number * 104_729) % 89 + 1]
        machine.do(f"G90G0X{away[0]}Y{away[1]}")
        machine.stand()
    return places, machine


@pytest.mark.parametrize("often", (0.0, 0.001), ids=("trembling", "with false stalls"))
@pytest.mark.parametrize("which", MACHINES)
def test_homing_repeats_within_two_full_steps(which, often, show):
    make, _ = MACHINES[which]
    places, machine = homed(make, 25, often)
    ranges = [max(each) - min(each) for each in zip(*places)]
    show(f"homing by stall, {which}", f"range of {len(places)} homings: {ranges} steps of 1/{FULL}; poles slipped: {machine.plant.slipping.slips}")
    assert max(ranges) <= 2 * FULL, places
    assert all(abs(each) <= 2 * FULL for place in places for each in place), places


def set_up(machine, axis):
    """(threshold, slowest, current scale, spreadCycle) of a driver."""
    registers = machine.machine.drivers[axis].registers
    return registers.get(0x40, 0), registers.get(0x14, 0), registers[0x10] >> 8 & 31, registers[0x00] >> 2 & 1


def test_only_homing_has_less_current_and_feels():
    """Both before the first step and behind the last one, also of homing that is stopped."""
    machine = Asked(router())
    machine.do("$X")
    before = set_up(machine, "y")
    assert before == (0, 0, 25, 1)
    while_moving = set()
    position = list(machine.plant.position)
    machine.machine.send(b"$H\n")
    for _ in range(4000):
        machine.machine.cycle()
        if machine.plant.position != position and machine.machine.app.controller.state == "home":
            while_moving.add(set_up(machine, "y"))
            position = list(machine.plant.position)
    assert while_moving == {(STALL, 0xFFFFF, 12, 0)}
    machine.machine.send(b"\x18")
    machine.machine.run_ms(300)
    assert set_up(machine, "y") == before
    machine.do("$X")
    machine.do("$H")
    machine.machine.send(b"G90G1X20F3000\n")
    position = list(machine.plant.position)
    while machine.plant.position == position:
        machine.machine.cycle()
    assert set_up(machine, "y") == before, "set up as usual before anything moves"


def test_a_motor_that_feels_nothing_is_an_alarm():
    """Its DIAG wire is off: the way ends at last, as behind a dead switch."""
    machine = Asked(router())
    machine.do("$X")
    machine.plant.slipping.sensors = {}
    said = machine.ask("$HX", 300_000)
    assert "ALARM:9" in said and machine.machine.app.controller.machine.alarm == errors.ALARM_SENSOR_DEAD


def test_places_that_never_agree_are_an_alarm():
    machine = Asked(router())
    machine.do("$X")
    machine.plant.slipping.spike(0.2)
    said = machine.ask("$HX", 300_000)
    assert "ALARM:8" in said


def test_a_driver_that_fails_while_it_homes_stops_the_machine():
    machine = Asked(router())
    machine.do("$X")
    machine.machine.send(b"$H\n")
    machine.machine.run_ms(400)
    machine.machine.drivers["x"].power_cycle()
    machine.machine.run_until(lambda: b"ALARM" in machine.machine.received(), 1000)
    log = [str(entry) for entry in machine.machine.app.controller.machine.log.entries]
    assert any("driver of x: reset" in entry for entry in log), log
    machine.machine.run_ms(50)
    assert not machine.plant.enabled


def test_power_that_fails_as_homing_ends_is_not_overlooked():
    """The set-up behind homing does not clear what a driver remembers of it."""
    machine = Asked(router())
    machine.do("$X")
    drivers = machine.machine.drivers
    machine.machine.send(b"$H\n")
    machine.machine.run_until(lambda: b"ok" in machine.machine.received(), 300_000)
    drivers["y"].registers[0x01] |= 4
    machine.machine.run_ms(400)
    assert machine.machine.app.controller.machine.alarm == errors.ALARM_DRIVER_POWER


@pytest.mark.parametrize("change, words", [
    (lambda board: board["homing"]["each"]["x"].update(pull_off_steps=100), "x: stall: its pull_off_steps are 128 at least"),
    (lambda board: board["homing"].update(order="z xy"), "homing.order: it homes alone, not with xy"),
    (lambda board: board["homing"].update(sensors={"y": "limit_y", "z": "limit_z"}, order="zy", each={}), "homing.sensors must name the input"),
    (lambda board: board["drivers"]["motors"][0].update(stall=300), "stall: 300 is not within 0 … 255"),
])  # fmt: skip
def test_what_a_board_file_cannot_ask_for(change, words):
    board = router()
    change(board)
    with pytest.raises(BoardError, match=words):
        check(board)


def test_both_motors_of_a_belt_feel_or_none():
    board = plotter()
    board["drivers"]["motors"][1]["stall"] = 0
    with pytest.raises(BoardError, match="both stall, or none"):
        check(board)


@pytest.mark.slow
@pytest.mark.parametrize("which", MACHINES)
def test_a_hundred_homings(which, show):
    make, _ = MACHINES[which]
    places, machine = homed(make, 100, 0.001, seed=7)
    ranges = [max(each) - min(each) for each in zip(*places)]
    show(f"homing by stall, {which}", f"range of 100 homings: {ranges} steps of 1/{FULL}; poles slipped: {machine.plant.slipping.slips}")
    assert max(ranges) <= 2 * FULL, places


def test_a_board_with_an_enable_for_each_driver_homes():
    """The SKR Pico: all of its drivers have current while it moves, and none behind an alarm."""
    machine = Asked("router_skr_pico", stalls=5)
    levels = {}
    told = machine.plant.output

    def output(tick, name, level):
        levels[name] = level
        told(tick, name, level)

    machine.machine.port.world.output = output
    machine.do("$X", "$H", "G90G1X20Y20F3000")
    machine.stand()
    enables = [levels.get(name) for name in ("enable", "enable_y", "enable_z")]
    assert enables == [0, 0, 0] and machine.plant.enabled
    machine.machine.drivers["z"].dead = True
    machine.machine.run_ms(400)
    enables = [levels.get(name) for name in ("enable", "enable_y", "enable_z")]
    assert enables == [1, 1, 1] and not machine.plant.enabled
