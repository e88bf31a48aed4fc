"""TMC2130 and TMC5160 drivers on SPI, with a CS each and in chains: set up and read back at the start, watched, every fault told with its axis, and safe."""

import copy

import pytest
import test_drivers
from passo import errors
from passo.config.board_error import BoardError
from passo.config.boardfile import check
from passo.options.drivers.errors import ALARM_DRIVER_DIFFERS, ALARM_DRIVER_FAULT, ALARM_DRIVER_POWER, ALARM_DRIVER_SILENT
from passo.options.spi_drivers import config as tmc_spi

from host_tools import boards
from host_tools.sim.tmc_spi import SpiDriver, SpiDrivers

PINS = {"sck": 18, "tx": 19, "rx": 20, "sense_mohm": 75}
MOTORS = [
    {"axis": "x", "cs": 21, "current_ma": 1500},
    {"axis": "y", "cs": 22, "current_ma": 1500, "stealth": False, "microsteps": 8},
    {"axis": "z", "cs": 28, "current_ma": 800, "hold_percent": 80},
]
WAYS = {"a CS each": (21, 22, 28), "a chain": (21, 21, 21), "a chain of two": (21, 22, 21)}


def router(way="a CS each", chip="tmc5160", **changes):
    motors = [{**motor, "cs": cs} for motor, cs in zip(MOTORS, WAYS[way])]
    config = {**PINS, "chip": chip, "motors": motors, **({"sense_mohm": 110} if chip == "tmc2130" else {}), **changes}
    if chip == "tmc2130" and "motors" not in changes:
        for motor in motors:
            motor["current_ma"] //= 2
    return {**copy.deepcopy(boards.load("router_3axis")), "idle_release_ms": 0, "journal": None, "spi_drivers": config}


class Router(test_drivers.Router):
    board = staticmethod(router)


def words(number):
    return number.to_bytes(4, "big")


def test_an_answer_comes_a_datagram_late():
    """The datasheet's example: the reply to a datagram answers the one before; a status byte ahead of it."""
    drivers = SpiDrivers({"chip": "tmc5160", "motors": MOTORS})
    assert drivers.exchange(21, tmc_spi.make_datagram(0x6F))[1:] == words(0)
    assert drivers.exchange(21, tmc_spi.make_datagram(0x6F)) == bytes((9,)) + words(0x80000000)
    assert drivers.exchange(21, tmc_spi.make_datagram(0x13, 0xABCDEF))[1:] == words(0x80000000)
    assert drivers.exchange(21, tmc_spi.make_datagram(0x13, 0x123456))[1:] == words(0xABCDEF)
    assert drivers.exchange(21, tmc_spi.make_datagram(4))[1:] == words(0x123456)
    assert drivers["x"].registers[0x13] == 0x123456


def test_a_chain_passes_on_what_came_first():
    """Of 80 bits the first 40 are for the driver at the end of the chain, and the first 40 that come back are that driver's."""
    drivers = SpiDrivers({"chip": "tmc2130", "motors": [{"axis": "x", "cs": 1}, {"axis": "y", "cs": 1}]})
    drivers.exchange(1, tmc_spi.make_datagram(0x13, 7) + tmc_spi.make_datagram(0x13, 9))
    assert (drivers["y"].registers[0x13], drivers["x"].registers[0x13]) == (7, 9)
    found = drivers.exchange(1, tmc_spi.make_datagram(4) * 2)
    assert (found[4], found[9]) == (7, 9)


@pytest.mark.parametrize("current_ma, mohm", [(1500, 75), (800, 75), (3000, 50), (4590, 50), (100, 75), (50, 22), (2000, 110)])
def test_the_current_of_a_tmc5160_is_the_datasheet_s(current_ma, mohm):
    """I = GLOBALSCALER / 256 · (CS + 1) / 32 · 0.325 V / R / √2: never above what is asked, and within 4 % below."""
    scaler, cs = tmc_spi.current_scale(current_ma, {"chip": "tmc5160", "sense_mohm": mohm})
    found = (scaler or 256) / 256 * (cs + 1) / 32 * 325 / mohm / 2**0.5 * 1000
    assert 0 == scaler or 32 <= scaler < 256
    assert 0.96 * current_ma <= found <= 1.0001 * current_ma or (scaler, cs) == (32, 0)
    assert tmc_spi.current_scale(4700, {"chip": "tmc5160", "sense_mohm": 50}) is None


@pytest.mark.parametrize("current_ma, wanted", [(800, (1, 25)), (980, (1, 31)), (1200, (0, 21)), (1742, (0, 31)), (1800, None)])
def test_and_that_of_a_tmc2130(current_ma, wanted):
    """I = (CS + 1) / 32 · V / (R + 20 mΩ) / √2, of 0.18 or 0.32 V."""
    found = tmc_spi.current_scale(current_ma, {"chip": "tmc2130", "sense_mohm": 110})
    assert found == wanted
    if found:
        one = (0.18 if found[0] else 0.32) / 32 / 0.13 / 2**0.5 * 1000
        assert (found[1] + 1) * one <= current_ma * 1.0001 < (found[1] + 2) * one


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("chip", ["tmc5160", "tmc2130"])
def test_all_drivers_are_set_up_before_anything_moves(way, chip):
    router = Router(way=way, chip=chip, run_ms=0)
    router.machine.send(b"$X\nG91G1X5F600\n")
    taken = {axis: len(tmc_spi.register_rows(check(globals()["router"](way, chip))["additions"].drives["motors"][0], {"chip": chip, "sense_mohm": 110})) for axis in "xyz"}
    while router.plant.position[0] == 3000:
        ready = all(len(router.drivers[axis].taken) == taken[axis] for axis in "xyz")
        router.machine.cycle()
        assert ready or router.plant.position[0] == 3000
    assert router.machine.now_ms() < 400 and router.alarm == 0
    x, y, z = (router.drivers[axis].registers for axis in "xyz")
    more = 8 if chip == "tmc5160" else 0x4000
    assert (x[0x00], y[0x00], z[0x00]) == (4 | more, more, 4 | more)
    assert (x[0x6C] >> 24 & 15, y[0x6C] >> 24 & 15) == (4, 5)
    assert (z[0x10] & 31) == (z[0x10] >> 8 & 31) * 80 // 100 and all(each[0x01] == 0 for each in (x, y, z))
    router.machine.run_ms(1000)
    assert "ok" in router.ask("$H") and "|Dr:" not in router.reports()
    assert all(len(router.drivers[axis].taken) == taken[axis] for axis in "xyz"), "once"


@pytest.mark.parametrize("way", ["a CS each", "a chain"])
@pytest.mark.parametrize("fault, alarm, said", [
    (lambda drivers: setattr(drivers["z"], "dead", True), ALARM_DRIVER_SILENT, "no answer"),
    (lambda drivers: drivers["x"].registers.update({0x04: 0x11000000}), ALARM_DRIVER_DIFFERS, "driver of x: version 11"),
    (lambda drivers: drivers["y"].registers.update({0x04: 0x30000000}), ALARM_DRIVER_DIFFERS, "driver of y: SD_MODE is low"),
    (lambda drivers: setattr(drivers["y"], "frozen", (0x6C,)), ALARM_DRIVER_DIFFERS, "driver of y: register 6c is 10410150"),
    (lambda drivers: setattr(drivers, "flips", 100_000), ALARM_DRIVER_SILENT, "driver of x: no answer"),
    (lambda drivers: [drivers.chains.pop(cs) for cs in list(drivers.chains)], ALARM_DRIVER_SILENT, "no answer"),
    (lambda drivers: [chain.pop() for chain in drivers.chains.values()], ALARM_DRIVER_SILENT, "driver of x: no answer"),
])  # fmt: skip
def test_a_fault_at_the_start_is_an_alarm_that_names_the_axis(way, fault, alarm, said):
    """Of a chain with one too few, the first of the list. Nothing moves, also if somebody unlocks."""
    router = Router(fault, run_ms=600, way=way)
    assert router.alarm == alarm and any(said in entry for entry in router.log()), router.log()
    router.machine.send(b"$X\nG91G1X5F600\n")
    router.machine.run_ms(1000)
    assert router.alarm == alarm and list(router.plant.position) == [3000, 2000, -4000]


@pytest.mark.parametrize("chip", ["tmc5160", "tmc2130"])
@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("axis", "xyz")
def test_of_a_chain_the_dead_driver_is_named(axis, moving, chip):
    """The log names the dead driver, not the first whose answer has to pass it: at the start, and while it moves."""
    router = Router(None if moving else lambda drivers: setattr(drivers[axis], "dead", True), run_ms=600, way="a chain", chip=chip)
    if moving:
        router.ask("$X")
        for name in "xyz":
            router.drivers[name].registers[0x6F] &= 0x7FFFFFFF  # no standstill
        router.drivers[axis].dead = True
        router.machine.run_until(lambda: router.alarm == ALARM_DRIVER_SILENT, 2000)
    assert router.alarm == ALARM_DRIVER_SILENT and f"driver of {axis}: no answer" in router.log()[-1], router.log()


@pytest.mark.parametrize("level", [0, 1])
def test_a_wire_that_is_off_is_no_answer(level):
    """SDO at either level says nothing, during set-up and later."""
    router = Router()
    router.ask("$X")
    router.drivers.exchange = lambda cs, data: bytearray(bytes((255 * level,)) * len(data))
    router.machine.run_ms(300)
    assert router.alarm == ALARM_DRIVER_SILENT and "driver of" in router.log()[-1]


def test_two_wrong_bits_are_asked_for_again():
    router = Router(lambda drivers: setattr(drivers, "flips", 2))
    assert router.alarm in (0, errors.ALARM_LOCKED)


@pytest.mark.parametrize("chip", ["tmc5160", "tmc2130"])
@pytest.mark.parametrize("fault, alarm, said", [
    (lambda driver: setattr(driver, "dead", True), ALARM_DRIVER_SILENT, "driver of y: no answer"),
    (SpiDriver.power_cycle, ALARM_DRIVER_POWER, "driver of y: reset"),
    (lambda driver: driver.registers.update({0x01: 4}), ALARM_DRIVER_POWER, "driver of y: undervoltage"),
    (lambda driver: driver.registers.update({0x6F: 0x86000000}), ALARM_DRIVER_FAULT, "driver of y: overheated"),
    (lambda driver: driver.registers.update({0x6F: 0x88000000}), ALARM_DRIVER_FAULT, "driver of y: short"),
])  # fmt: skip
def test_a_fault_while_it_moves_stops_the_machine_and_takes_the_current_off(chip, fault, alarm, said):
    router = Router(chip=chip)
    router.ask("$X")
    router.ask("$H")
    router.machine.send(b"G90G1X100Y50F1500\n")
    router.machine.run_ms(500)
    fault(router.drivers["y"])
    begun = router.machine.now_ms()
    router.machine.run_until(lambda: router.alarm == alarm, 2000)
    assert router.machine.now_ms() - begun < 150 and any(said in entry for entry in router.log()), router.log()
    router.machine.run_ms(50)
    stood = list(router.plant.position)
    assert not router.plant.enabled and 0 < stood[0] < 32000
    if router.drivers["y"].dead:
        return
    router.drivers["y"].registers.update({0x6F: 0x80000000, 0x01: 0})
    assert "ok" in router.ask("$X")
    router.machine.run_ms(300)
    assert router.alarm == 0 and router.drivers["y"].registers[0x00] & 4 == 0 and "ok" in router.ask("$H"), "set up anew"


def test_heat_and_open_coils_are_told():
    router = Router(way="a chain")
    router.ask("$X")
    router.drivers["x"].registers[0x6F] = 0x84000000
    router.drivers["z"].registers[0x6F] = 0xC0000000
    router.machine.run_ms(300)
    assert "|Dr:x-hot,z-open" in router.reports() and router.alarm == 0
    router.drivers["x"].registers[0x6F] = router.drivers["z"].registers[0x6F] = 0x80000000
    router.machine.run_ms(300)
    assert "|Dr:" not in router.reports()


@pytest.mark.parametrize("changes, words", [
    ({"motors": [{"axis": "a", "cs": 21, "current_ma": 500}]}, "spi_drivers.motors, a: there is no such axis"),
    ({"motors": [{"axis": "x", "cs": 21, "current_ma": 500}, {"axis": "x", "cs": 22, "current_ma": 500}]}, "every axis once"),
    ({"motors": [{"axis": "x", "cs": 21, "current_ma": 500, "microsteps": 12}]}, "microsteps are 1, 2, 4 … 256, not 12"),
    ({"motors": [{"axis": "x", "cs": 21, "current_ma": 3100}]}, "3100 mA are too much for 75 mΩ"),
    ({"motors": [{"axis": "x", "cs": 2, "current_ma": 500}]}, "pin 2 is claimed by axis x and by spi_drivers cs"),
    ({"sck": 19}, "pin 19 is claimed by spi_drivers sck and by spi_drivers tx"),
    ({"chip": "tmc2209"}, "spi_drivers.chip: 'tmc2209' is none of tmc5160, tmc2130"),
])  # fmt: skip
def test_what_a_board_file_cannot_ask_for(changes, words):
    with pytest.raises(BoardError, match=words):
        check(router(**changes))


def test_not_on_a_uart_too():
    board = router()
    board["drivers"] = {"port": "uart1", "tx": 20, "rx": 21, "motors": [{"axis": "x", "address": 0, "current_ma": 800}]}
    for each in (board, dict(sorted(board.items(), key=lambda item: item[0] != "spi_drivers"))):
        with pytest.raises(BoardError, match="not beside drivers|claimed by"):
            check(each)
