"""Homing by StallGuard: motors feel the ends of their axes, on a plant whose signal trembles, with a motor an axis and on CoreXY."""

import copy
import random

import pytest
from asked import Asked

from host_tools import boards
from passo.config.board_error import BoardError
from passo.config.boardfile import check
from passo.options.drivers.errors import ALARM_DRIVER_DIFFERS, ALARM_DRIVER_POWER, ALARM_DRIVER_SILENT

FULL = 16  # steps of a full step
STALL = 45  # of SG_RESULT 200 in the plant


def router(phase=0, **changes):
    """X and Y feel their ends, which stand `phase` steps from a full step, where their drivers measure; Z has a switch."""
    board = {**copy.deepcopy(boards.load("router_tmc2209")), "idle_release_ms": 0, "journal": None}
    for motor in board["drivers"]["motors"][:2]:
        motor.update({"stall": STALL, "stall_ma": 400, **changes})
    board["drivers"]["motors"][1]["stealth"] = False
    for item in board["inputs"][:2]:
        item.update(active=1, pull="down", pin=item["pin"])
    board["homing"] = {**board["homing"], "debounce_ms": 2, "each": {axis: {"seek_steps_s": 2000, "pull_off_steps": 400 + phase} for axis in "xy"}}
    return board


def plotter(phase=0):
    """CoreXY: two motors that both move X and Y, and both feel."""
    board = {**copy.deepcopy(boards.load("corexy_plotter")), "idle_release_ms": 0}
    for axis in board["axes"]:
        axis["travel_steps"] = 6000
    motors = [{"axis": axis, "address": number, "current_ma": 700, "stall": STALL, "stall_ma": 400} for number, axis in enumerate("xy")]
    board["drivers"] = {"port": "uart1", "tx": 20, "rx": 21, "motors": motors}
    board["homing"] = {**board["homing"], "debounce_ms": 5, "seek_steps_s": 1000, "pull_off_steps": 400 + phase}
    return board


MACHINES = {"router": (router, 6), "corexy": (plotter, 3)}  # and how often each homes in a quick test, at each phase


def homed(make, count, often=0.0, seed=1):
    """(where X and Y stand after each of `count` homings from anywhere, the machine)."""
    machine = Asked(make(), stalls=seed, seed=seed)
    slipping = machine.plant.slipping
    slipping.set_spike_share(often)
    places = []
    machine.do("$X")
    for number in range(count):
        machine.do("$H")
        places.append(list(machine.plant.position[:2]))
        assert not machine.plant.errors, machine.plant.errors[:3]
        away = [(number * 7919) % 67 + 1, (number * 104_729) % 59 + 1]
        machine.do(f"G90G0X{away[0]}Y{away[1]}")
        machine.stand()
    return places, machine


@pytest.mark.parametrize("often", (0.0, 0.001), ids=("trembling", "with false stalls"))
@pytest.mark.parametrize("which", MACHINES)
def test_homing_repeats_within_two_full_steps(which, often, show):
    make, count = MACHINES[which]
    repeats(which, make, (0, 5, 11), count, often, show)


def repeats(which, make, phases, count, often, show):
    """`count` homings at each phase lie within two full steps, all taken together."""
    places, slips = [], 0
    for phase in phases:
        found, machine = homed(lambda: make(phase), count, often, seed=phase + 1)
        places += found
        slips += machine.plant.slipping.slips
    ranges = [max(each) - min(each) for each in zip(*places)]
    show(f"homing by stall, {which}", f"range of {len(places)} homings: {ranges} steps of 1/{FULL}; poles slipped: {slips}")
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


def tried(machine, axis, count, pause=lambda: None):
    """(places, alarms) of `count` homings of an axis from anywhere."""
    number = "xyz".index(axis)
    places, alarms = [], []
    cycle = machine.machine.cycle

    def slow():
        cycle()
        pause()

    for attempt in range(count):
        machine.machine.cycle = slow
        said = machine.ask(f"$H{axis.upper()}", 600_000)
        machine.machine.cycle = cycle
        if said.endswith("ok"):
            places.append(machine.plant.position[number])
            machine.do("$X", f"G90G0{axis}{attempt * 7919 % 97 + 1}")  # the others are not homed
        else:
            alarms.append(said)
        machine.machine.run_ms(300)
        machine.do("$X")
        machine.machine.settle()
    return places, alarms


def count_silent(often, count, show):
    """The more often a free motor seems to stall, the more homings end in an alarm; none ends elsewhere and says ok."""
    machine = Asked(router(), stalls=11, seed=11)
    machine.do("$X")
    machine.plant.slipping.set_spike_share(often)
    places, alarms = tried(machine, "x", count)
    show(f"homing by stall, {often:.0%} of full steps seem to stall", f"{len(places)} of {count} homings right, {len(alarms)} alarms")
    assert all(abs(place) <= 2 * FULL for place in places), places
    assert all("ALARM:8" in said for said in alarms), alarms


@pytest.mark.parametrize("often", (0.01, 0.1))
def test_false_stalls_never_make_a_wrong_origin(often, show):
    count_silent(often, 25, show)


@pytest.mark.slow
@pytest.mark.parametrize("often", (0.003, 0.01, 0.03, 0.06, 0.1, 0.2))
def test_false_stalls_never_make_a_wrong_origin_in_hundreds(often, show):
    count_silent(often, 100, show)


def test_homing_that_failed_does_not_spoil_the_next():
    """Z, which has a switch, homes first."""
    machine = Asked(router(), stalls=11, seed=11)
    machine.do("$X")
    machine.plant.slipping.set_spike_share(0.3)
    assert "ALARM:8" in machine.ask("$H", 600_000)
    machine.plant.slipping.set_spike_share(0)
    machine.machine.run_ms(300)
    machine.do("$X", "$H")
    assert all(abs(place) <= 2 * FULL for place in machine.plant.position[:2])


def test_a_slow_main_loop_makes_no_rotor_slip(show):
    """It stands still for 20 ms now and then, as the collector does: two and a half full steps. The pin's interrupt stops the axis."""
    machine = Asked(router(7), stalls=5, seed=5)
    machine.do("$X")
    rng = random.Random(5)
    places, alarms = tried(machine, "x", 25, lambda: rng.random() < 0.01 and machine.machine.port.advance(20 * 12_500))
    slips = machine.plant.slipping.slips
    show("homing by stall, a slow main loop", f"{len(places)} of 25 homings right, poles slipped: {slips}")
    assert not alarms and slips <= 2 and all(abs(place) <= 2 * FULL for place in places), places


def fails(machine, alarm, words=""):
    """`$HX` ends in an alarm; behind it the drivers are set up as usual."""
    before = set_up(machine, "x")
    said = machine.ask("$HX", 600_000)
    assert f"ALARM:{alarm}" in said and not machine.machine.app.controller.machine.homed
    log = [str(entry) for entry in machine.machine.app.controller.machine.log.entries]
    assert any(words in entry for entry in log), log
    machine.machine.run_ms(300)
    assert set_up(machine, "x") == before and before[0] == 0


def test_a_diag_wire_that_is_off_is_an_alarm_behind_the_travel():
    machine = Asked(router(), start=(20_000, 20_000, -1000))
    machine.do("$X")
    machine.plant.slipping.sensors = {}
    fails(machine, 9)


def test_a_diag_pin_that_is_active_is_an_alarm_before_anything_moves():
    machine = Asked(router())
    machine.do("$X")
    machine.plant.slipping.sensors = {}
    machine.plant.set_input(0, "limit_x", True)
    before = list(machine.plant.position)
    fails(machine, 8, "driver of x: DIAG is active")
    assert machine.plant.position == before
    machine.plant.set_input(0, "limit_x", False)
    machine.do("$X", "G91G0X1")


def test_a_diag_pin_that_stays_active_once_it_was_is_an_alarm():
    """The head does not wander far: not more than half a pull-off an attempt."""
    machine = Asked(router(), start=(20_000, 20_000, -1000))
    machine.do("$X")
    machine.machine.send(b"$HX\n")
    machine.machine.run_ms(1500)
    assert machine.machine.app.controller.state == "home"
    at = machine.plant.position[0]
    machine.plant.slipping.sensors = {}
    machine.plant.set_input(0, "limit_x", True)
    machine.machine.run_until(lambda: b"ALARM" in machine.machine.replies_so_far(), 60_000)
    assert b"ALARM:8" in machine.machine.replies_so_far() and abs(machine.plant.position[0] - at) < 4000


def test_a_dead_wire_of_direction_is_an_alarm():
    machine = Asked(router())
    machine.do("$X")
    pull = machine.plant.slipping.turn_motor
    machine.plant.slipping.turn_motor = lambda tick, motor, steps: pull(tick, motor, -abs(steps) if motor == 0 else steps)
    fails(machine, 8)


def test_a_head_that_is_jammed_is_an_alarm():
    machine = Asked(router(), start=(20_000, 20_000, -1000))
    machine.do("$X")
    carriage = machine.plant.carriages[0]
    carriage.low, carriage.high = carriage.position - 40, carriage.position + 40
    fails(machine, 8)


def test_a_silent_driver_is_an_alarm_before_anything_moves():
    machine = Asked(router())
    machine.do("$X")
    machine.machine.drivers["x"].dead = True
    before = list(machine.plant.position)
    assert "ALARM" in machine.ask("$HX") and machine.plant.position == before
    assert machine.machine.app.controller.machine.alarm == ALARM_DRIVER_SILENT


def test_power_that_fails_at_any_moment_of_homing_is_an_alarm():
    """Nothing is homed then, and the motors have no current."""
    machine = Asked(router())
    for delay_ms in range(60, 5000, 389):
        machine.do("$X")
        machine.machine.run_ms(300)
        machine.machine.take()
        machine.machine.send(b"$HX\n")
        machine.machine.run_ms(delay_ms)
        machine.machine.drivers["x"].power_cycle()
        machine.machine.run_ms(250)
        record = machine.machine.app.controller.machine
        assert record.alarm in (ALARM_DRIVER_POWER, ALARM_DRIVER_DIFFERS), (delay_ms, record.alarm)
        assert not record.homed and not machine.plant.enabled, delay_ms


def test_a_driver_that_fails_while_it_homes_stops_the_machine():
    machine = Asked(router())
    machine.do("$X")
    machine.machine.send(b"$H\n")
    machine.machine.run_ms(400)
    machine.machine.drivers["x"].power_cycle()
    machine.machine.run_until(lambda: b"ALARM" in machine.machine.replies_so_far(), 1000)
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
    machine.machine.run_until(lambda: b"ok" in machine.machine.replies_so_far(), 300_000)
    drivers["y"].registers[0x01] |= 4
    machine.machine.run_ms(400)
    assert machine.machine.app.controller.machine.alarm == ALARM_DRIVER_POWER


@pytest.mark.parametrize("change, words", [
    (lambda board: board["homing"]["each"]["x"].update(pull_off_steps=200), "x: stall: its pull_off_steps are 256 at least"),
    (lambda board: board["homing"].update(order="z xy"), "homing.order: it homes alone, not with xy"),
    (lambda board: board["homing"].update(sensors={"y": "limit_y", "z": "limit_z"}, order="zy", each={}), "homing.sensors must name the input"),
    (lambda board: board["drivers"]["motors"][0].update(stall=300), "stall: 300 is not within 0 … 255"),
])  # fmt: skip
def test_what_a_board_file_cannot_ask_for(change, words):
    board = router()
    change(board)
    with pytest.raises(BoardError, match=words):
        check(board)


@pytest.mark.parametrize("feels", ("x", "y"))
def test_of_two_motors_that_share_their_axes_both_feel_or_none(feels):
    board = plotter()
    for motor in board["drivers"]["motors"]:
        motor["stall"] *= motor["axis"] in feels
    with pytest.raises(BoardError, match="x and y share two motors: both or none"):
        check(board)
    for motor in board["drivers"]["motors"]:
        motor["stall"] = 0
    check(board)


@pytest.mark.parametrize("asked, other", [("$HX", 1), ("$HY", 0)])
def test_on_corexy_x_never_homes_without_y(asked, other):
    """Whichever of them moves, a slip shifts the other."""
    machine = Asked(plotter(), stalls=2, seed=2)
    machine.do("$X", "$H", "G90G0X30Y30")
    machine.stand()
    machine.plant.position[other] += 100
    machine.plant.carriages[other].position += 100
    machine.do(asked)
    assert machine.machine.app.controller.machine.homed
    assert all(abs(each) <= 2 * FULL for each in machine.plant.position), machine.plant.position


def test_on_corexy_backing_off_into_the_far_end_does_not_shift_x():
    """There nothing is heeded, and rotors slip. Without X homing again it ended five full steps off."""
    machine = Asked(plotter(), start=(3000, 6700), stalls=7, seed=7)
    machine.do("$X", "$H")
    assert machine.plant.slipping.slips
    assert all(abs(each) <= 2 * FULL for each in machine.plant.position), machine.plant.position


def test_on_corexy_a_slip_while_y_homes_has_x_home_again(show):
    """Interrupts that come 25 ms late now and then, a full step and a half: rotors slip, and shift the other axis. Without the rule
    one of these homings says ok more than two full steps off."""
    machine = Asked(plotter(), stalls=7, seed=7)
    machine.do("$X")
    watches = machine.machine.port._limits._watches.values()
    usual = [watch.filter_ticks for watch in watches]
    assert len(usual) == 2
    rng = random.Random(7)
    begun = machine.machine.cycle

    def late():
        begun()
        if rng.random() < 0.01:
            slow = rng.random() < 0.12
            for watch, ticks in zip(watches, usual):
                watch.filter_ticks = 25 * 12_500 if slow else ticks

    places = []
    for _ in range(8):
        machine.machine.cycle = late
        said = machine.ask("$H", 900_000)
        machine.machine.cycle = begun
        if said.endswith("ok"):
            places.append(list(machine.plant.position))
            machine.do("G90G0X30Y30")
        else:
            assert "ALARM:8" in said
            machine.machine.run_ms(300)
            machine.do("$X")
        machine.machine.settle()
    show("homing by stall on CoreXY, late interrupts", f"{len(places)} of 8 right, poles slipped: {machine.plant.slipping.slips}")
    assert machine.plant.slipping.slips >= 5 and len(places) >= 2
    assert all(abs(each) <= 2 * FULL for place in places for each in place), places


def test_backlash_and_stall():
    """A machine that takes up backlash homes by stall, too."""
    machine = Asked({**router(), "backlash": {"x": 0, "y": 0, "z": 0}}, stalls=3, seed=3)
    machine.do("$X", "$H")
    assert all(abs(each) <= 2 * FULL for each in machine.plant.position[:2]), machine.plant.position


@pytest.mark.slow
@pytest.mark.parametrize("which", MACHINES)
def test_a_hundred_homings(which, show):
    repeats(which, MACHINES[which][0], range(16), 7, 0.0, show)


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
