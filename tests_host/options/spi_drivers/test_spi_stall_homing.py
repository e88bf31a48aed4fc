"""Homing by stallGuard2 of TMC5160 and TMC2130 drivers on SPI, with a CS each and in a chain, on a plant whose signal trembles.

SG_RESULT is new each full step only, as the datasheets say, so where in a full step the end stands decides how far the field runs ahead of a rotor
before the driver tells: up to almost two full steps, at which it slips. Hence the ends stand at each sixteenth of a full step in turn.
"""

import random

import pytest
import test_stall_homing
from asked import Asked
from passo.config.board_error import BoardError
from passo.config.boardfile import check
from passo.options.drivers.errors import ALARM_DRIVER_DIFFERS, ALARM_DRIVER_POWER, ALARM_DRIVER_SILENT
from test_stall_homing import FULL, tried

from host_tools import boards
from host_tools.build import tree
from host_tools.sim.tmc_spi import SpiDriver
from host_tools.wiring.parts import parts_of

STALL = -2  # SG_RESULT is 0 half a full step behind the field, about
WAYS = {"tmc5160": ("a CS each", (21, 22, 28)), "tmc2130": ("a chain", (21, 21, 21))}


def router(chip="tmc5160", phase=0, **changes):
    """X and Y feel their ends, which stand `phase` steps from a full step; Z has a switch."""
    board = test_stall_homing.router()
    del board["drivers"]
    motors = [{"axis": axis, "cs": cs, "current_ma": 800, "stall": STALL, "stall_ma": 400, **changes} for axis, cs in zip("xyz", WAYS[chip][1])]
    del motors[2]["stall"]
    motors[1]["stealth"] = False
    board["spi_drivers"] = {"chip": chip, "sck": 18, "tx": 19, "rx": 20, "sense_mohm": 75 if chip == "tmc5160" else 110, "motors": motors}
    board["homing"]["each"] = {axis: {"seek_steps_s": 2000, "pull_off_steps": 400 + phase} for axis in "xy"}
    return board


def ready(board, **options):
    machine = Asked(board, **options)
    machine.do("$X")
    machine.machine.run_ms(100)
    return machine


def homed(chip, phases, count, often, pause=0.0):
    """(places, alarms, poles slipped) of `count` homings of X at each phase; the main loop stands for 8 ms in `pause` of its cycles."""
    places, alarms, slips = [], [], 0
    for phase in phases:
        machine = ready(router(chip, phase), stalls=phase + 1, seed=phase)
        machine.plant.slipping.set_spike_share(often)
        rng = random.Random(phase)
        found = tried(machine, "x", count, lambda: rng.random() < pause and machine.machine.port.advance(8 * 12_500))
        places += found[0]
        alarms += found[1]
        slips += machine.plant.slipping.slips
    return places, alarms, slips


def shown(show, what, places, alarms, slips):
    show(f"homing by stall on SPI, {what}", f"{len(places)} of {len(places) + len(alarms)} right, range {max(places) - min(places)} steps of 1/{FULL}; poles slipped: {slips}")
    assert all(abs(place) <= 2 * FULL for place in places), places
    assert all("ALARM:8" in said for said in alarms), alarms


@pytest.mark.parametrize("chip", WAYS)
@pytest.mark.parametrize("often", (0.0, 0.001), ids=("trembling", "with false stalls"))
def test_homing_repeats_within_two_full_steps(chip, often, show):
    machine = ready(router(chip), stalls=1, seed=1)
    machine.plant.slipping.set_spike_share(often)
    places = []
    for number in range(6):
        machine.do("$H")
        places.append(list(machine.plant.position[:2]))
        machine.do(f"G90G0X{number * 7919 % 97 + 1}Y{number * 104_729 % 89 + 1}")
        machine.stand()
    ranges = [max(each) - min(each) for each in zip(*places)]
    show(f"homing by stall, {chip}, {WAYS[chip][0]}", f"range of {len(places)} homings: {ranges} steps of 1/{FULL}; poles slipped: {machine.plant.slipping.slips}")
    assert max(ranges) <= 2 * FULL and all(abs(each) <= 2 * FULL for place in places for each in place), places


def test_wherever_the_end_stands_the_axis_stops_before_its_rotor_slips(show):
    """The DIAG pin's interrupt stops it: the main loop would, half a full step later, at a third of the phases not once come to five places."""
    places, alarms, slips = homed("tmc5160", (2, 5, 8, 11, 14), 4, 0.0)
    shown(show, "at any phase", places, alarms, slips)
    assert not alarms and slips <= 2


@pytest.mark.slow
@pytest.mark.parametrize("chip", WAYS)
@pytest.mark.parametrize("often", (0.0, 0.002), ids=("trembling", "with false stalls"))
def test_a_hundred_homings(chip, often, show):
    places, alarms, slips = homed(chip, range(16), 7, often, 0.02)
    shown(show, f"{chip}, 112 homings, {often:.1%} false stalls", places, alarms, slips)
    assert len(alarms) <= (0 if not often else 5)


@pytest.mark.slow
@pytest.mark.parametrize("often", (0.01, 0.03, 0.1))
def test_false_stalls_never_make_a_wrong_origin_in_hundreds(often, show):
    places, alarms, slips = homed("tmc2130", range(0, 16, 2), 13, often, 0.02)
    shown(show, f"{often:.0%} of full steps seem to stall", places or [0], alarms, slips)


def set_up(machine, axis):
    """(GCONF, SGT and filter, TCOOLTHRS, mA) of a driver."""
    driver = machine.machine.drivers[axis]
    registers = driver.registers
    scaled = (registers[0x10] >> 8 & 31) + 1
    if driver.chip == "tmc5160":
        current = (registers.get(0x0B, 0) or 256) / 256 * scaled / 32 * 325 / 75
    else:
        current = scaled / 32 * (180 if registers[0x6C] >> 17 & 1 else 320) / 130
    return registers[0x00], registers.get(0x6D, 0), registers.get(0x14, 0), round(current / 2**0.5 * 1000, -1)


@pytest.mark.parametrize("chip", WAYS)
def test_only_homing_has_less_current_and_feels(chip):
    """Both before the first step and behind the last one, also of homing that is stopped. DIAG0 and DIAG1 push and pull from the start on."""
    machine = ready(router(chip))
    more = 8 if chip == "tmc5160" else 0x4000
    mine = {axis: set_up(machine, axis) for axis in "xyz"}
    assert [mine[axis][:3] for axis in "xyz"] == [(0x3004 | more, 0, 0), (0x3000 | more, 0, 0), (4 | more, 0, 0)]
    assert all(760 <= each[3] <= 800 for each in mine.values()), mine
    while_moving = set()
    position = list(machine.plant.position)
    machine.machine.send(b"$H\n")
    for _ in range(4000):
        machine.machine.cycle()
        if machine.plant.position != position and machine.machine.app.controller.state == "home":
            while_moving.add(tuple(set_up(machine, axis) for axis in "xyz"))
            position = list(machine.plant.position)
    assert len(while_moving) == 1
    x, y, z = while_moving.pop()
    assert x == y and z == mine["z"]
    assert x[:3] == (0x3180 | more, (STALL & 0x7F) << 16, 0xFFFFF) and 380 <= x[3] <= 400, x
    machine.machine.send(b"\x18")
    machine.machine.run_ms(300)
    assert {axis: set_up(machine, axis) for axis in "xyz"} == mine
    machine.do("$X", "$H")
    machine.machine.send(b"G90G1X20F3000\n")
    position = list(machine.plant.position)
    while machine.plant.position == position:
        machine.machine.cycle()
    assert {axis: set_up(machine, axis) for axis in "xyz"} == mine, "set up as usual before anything moves"


def test_stallguard2_is_the_datasheet_s():
    """SG_RESULT falls with the load, more of it with a lower SGT; 0 is a stall, in bit 24 of DRV_STATUS and, asked for and in spreadCycle only, on the pin."""
    driver = SpiDriver("tmc5160")
    driver.registers.update({0x00: 0x3180, 0x14: 0xFFFFF, 0x6D: (-10 & 0x7F) << 16})
    assert not driver.diag_level(200) and driver.registers[0x6F] == 0x80000000 | 60
    assert driver.diag_level(140) and driver.registers[0x6F] == 0x81000000
    driver.diag = 0
    assert driver.diag_level(140)
    driver.registers[0x6D] = 10 << 16
    assert not driver.diag_level(140) and driver.registers[0x6F] & 1023 == 80
    driver.registers[0x6D] = 0
    for register, silent in ((0x00, 0x3184), (0x00, 0x3100), (0x00, 0x2180), (0x14, 0)):
        before = driver.registers[register]
        driver.registers[register] = silent
        assert not driver.diag_level(0), (register, silent)
        driver.registers[register] = before
    assert driver.diag_level(0)


def test_either_diag_pin_may_be_wired():
    machine = ready(router())
    for axis in "xy":
        machine.machine.drivers[axis].diag = 0
    machine.do("$H")
    assert all(abs(each) <= 2 * FULL for each in machine.plant.position[:2])


def fails(machine, alarm, words="", line="$HX"):
    """Homing ends in an alarm; behind it the drivers are set up as usual."""
    before = set_up(machine, "x")
    said = machine.ask(line, 600_000)
    assert f"ALARM:{alarm}" in said and not machine.machine.app.controller.machine.homed, said
    log = [str(entry) for entry in machine.machine.app.controller.machine.log.entries]
    assert any(words in entry for entry in log), log
    machine.machine.run_ms(300)
    assert set_up(machine, "x") == before


@pytest.mark.parametrize("chip", WAYS)
def test_a_diag_wire_that_is_off_is_an_alarm_behind_the_travel(chip):
    machine = ready(router(chip), start=(20_000, 20_000, -1000))
    machine.plant.slipping.sensors = {}
    fails(machine, 9)


def test_a_diag_pin_that_is_active_is_an_alarm_before_anything_moves():
    machine = ready(router())
    machine.plant.slipping.sensors = {}
    machine.plant.set_input(0, "limit_x", True)
    before = list(machine.plant.position)
    fails(machine, 8, "driver of x: DIAG is active")
    assert machine.plant.position == before
    machine.plant.set_input(0, "limit_x", False)
    machine.do("$X", "G91G0X1")


def test_a_dead_wire_of_direction_is_an_alarm():
    machine = ready(router())
    pull = machine.plant.slipping.turn_motor
    machine.plant.slipping.turn_motor = lambda tick, motor, steps: pull(tick, motor, -abs(steps) if motor == 0 else steps)
    fails(machine, 8)


def test_a_head_that_is_jammed_is_an_alarm():
    machine = ready(router(), start=(20_000, 20_000, -1000))
    carriage = machine.plant.carriages[0]
    carriage.low, carriage.high = carriage.position - 40, carriage.position + 40
    fails(machine, 8)


@pytest.mark.parametrize("chip", WAYS)
def test_a_silent_driver_is_an_alarm_before_anything_moves(chip):
    machine = ready(router(chip))
    machine.machine.drivers["y"].dead = True
    before = list(machine.plant.position)
    assert "ALARM" in machine.ask("$HX") and machine.plant.position == before
    assert machine.machine.app.controller.machine.alarm == ALARM_DRIVER_SILENT


def test_a_wrong_cs_is_an_alarm_before_anything_moves():
    """Two drivers hear one CS, and none the other: one that was right at the start."""
    machine = ready(router())
    chains = machine.machine.drivers.chains
    chains[21], chains[22] = chains[21] + chains[22], []
    before = list(machine.plant.position)
    assert "ALARM" in machine.ask("$H") and machine.plant.position == before
    assert machine.machine.app.controller.machine.alarm in (ALARM_DRIVER_SILENT, ALARM_DRIVER_DIFFERS)


@pytest.mark.parametrize("chip", WAYS)
def test_power_that_fails_at_any_moment_of_homing_is_an_alarm(chip):
    """Nothing is homed then, and the motors have no current."""
    machine = ready(router(chip))
    for delay_ms in (*range(0, 60, 13), *range(60, 5000, 909)):
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


@pytest.mark.parametrize("chip", WAYS)
def test_power_that_fails_as_homing_ends_is_not_overlooked(chip):
    """The set-up behind homing does not clear what a driver remembers of it; a TMC2130 forgets it as it is read."""
    machine = ready(router(chip))
    machine.machine.send(b"$H\n")
    machine.machine.run_until(lambda: b"ok" in machine.machine.replies_so_far(), 300_000)
    machine.machine.drivers["y"].registers[0x01] |= 4
    machine.machine.run_ms(400)
    assert machine.machine.app.controller.machine.alarm == ALARM_DRIVER_POWER


@pytest.mark.parametrize("change, words", [
    (lambda board: board["homing"]["each"]["x"].update(pull_off_steps=200), "spi_drivers.motors, x: stall: its pull_off_steps are 256 at least"),
    (lambda board: board["homing"].update(order="z xy"), "homing.order: it homes alone, not with xy"),
    (lambda board: board["homing"].update(sensors={"y": "limit_y", "z": "limit_z"}, order="zy", each={}), "homing.sensors must name the input"),
    (lambda board: board["spi_drivers"]["motors"][0].update(stall=-65), "stall: -65 is not within -64 … 64"),
    (lambda board: board["spi_drivers"]["motors"][0].update(stall_ma=4000), "spi_drivers.motors, x: 4000 mA are too much for 75 mΩ"),
])  # fmt: skip
def test_what_a_board_file_cannot_ask_for(change, words):
    board = router()
    change(board)
    with pytest.raises(BoardError, match=words):
        check(board)


def test_a_threshold_of_zero_is_one():
    """SGT 0 is where the datasheet has people begin."""
    assert check(router(stall=0))["additions"].stalls == "xy" and check(router(stall=64))["additions"].stalls == ""


def test_a_board_is_built_with_the_folders_of_its_drivers():
    names = {path.as_posix() for path in tree.select_modules(router(stall=0))}
    assert "passo/options/spi_drivers/control_stall.py" in names and "passo/options/drivers/control_stall_homing.py" in names
    assert {name.split("/")[2] for name in names if "/options/" in name and name.count("/") > 2} == {"drivers", "spi_drivers", "journal", "planning_s_curves"}


def test_the_shipped_board_homes():
    """router_tmc5160, and its picture has DIAG where others have a switch."""
    machine = ready("router_tmc5160", stalls=2)
    machine.do("$H")
    assert all(abs(each) <= 2 * FULL for each in machine.plant.position[:2]) and machine.plant.position[2] == 0
    titles = {part.name: part.title for part in parts_of(check(boards.load("router_tmc5160")))}
    assert titles["in_limit_x"] == "limit_x: DIAG of the X driver" and titles["in_limit_z"] == "limit_z: limit Z"


def test_nor_may_a_driver_on_a_uart_feel_with_more_than_its_resistors_bear():
    board = test_stall_homing.router(stall_ma=1900)
    with pytest.raises(BoardError, match="drivers.motors, x: 1900 mA are too much for 110 mΩ"):
        check(board)
