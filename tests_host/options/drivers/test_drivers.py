"""TMC2209 drivers on one wire: set up and read back at the start, watched, every fault told with its axis, and safe."""

import copy

import pytest
from passo import errors
from passo.config.board_error import BoardError
from passo.config.boardfile import check
from passo.options.drivers import config as tmc2209
from passo.options.drivers.errors import ALARM_DRIVER_DIFFERS, ALARM_DRIVER_FAULT, ALARM_DRIVER_POWER, ALARM_DRIVER_SILENT

from host_tools import boards
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.tmc import crc8

CONFIG = {"port": "uart1", "tx": 20, "rx": 21, "motors": [
    {"axis": "x", "address": 0, "current_ma": 800},
    {"axis": "y", "address": 1, "current_ma": 800, "stealth": False, "microsteps": 8},
    {"axis": "z", "address": 3, "current_ma": 1200, "hold_percent": 80},
]}  # fmt: skip


def router(**changes):
    return {**copy.deepcopy(boards.load("router_3axis")), "idle_release_ms": 0, "journal": None, "drivers": {**copy.deepcopy(CONFIG), **changes}}


class Router:
    board = staticmethod(router)

    def __init__(self, prepare=None, run_ms=300, **changes):
        self.machine = VirtualMachine(self.board(**changes), start=(3000, 2000, -4000))
        self.drivers, self.plant = self.machine.drivers, self.machine.plant
        if prepare:
            prepare(self.drivers)
        self.machine.run_ms(run_ms)

    @property
    def alarm(self):
        return self.machine.app.controller.machine.alarm

    def log(self):
        return [str(entry) for entry in self.machine.app.controller.machine.log.entries]

    def ask(self, line, limit_ms=60_000):
        self.machine.take()
        self.machine.send(line.encode() + b"\n")
        self.machine.run_until(lambda: any(word in self.machine.replies_so_far() for word in (b"ok", b"error", b"ALARM")), limit_ms)
        return self.machine.take().decode().strip()

    def reports(self):
        """Status reports until one has told all."""
        said = ""
        for _ in range(25):
            self.machine.take()
            self.machine.send(b"?")
            self.machine.run_until(lambda: b">" in self.machine.replies_so_far(), 1000)
            said += self.machine.take().decode()
        return said

    def until_alarm(self, limit_ms=2000):
        """ms until an alarm is raised."""
        begun = self.machine.now_ms()
        self.machine.run_until(lambda: self.alarm not in (0, errors.ALARM_LOCKED), limit_ms)
        return self.machine.now_ms() - begun


def test_the_crc_is_the_datasheet_s():
    """Both ways to reckon it agree, on the datasheet's own polynomial; a telegram ends with it."""
    for data in (b"\x05\x00\x06", b"\x05\x03\x80\x00\x00\x01\xc0", bytes(range(7)), b"\xff" * 7):
        assert tmc2209.telegram_crc(data) == crc8(data)
    assert tmc2209.make_telegram(0, 0x06) == bytes((5, 0, 6, crc8(b"\x05\x00\x06")))
    assert tmc2209.reply_value(b"\x05\xff\x06\x21\x00\x00\x00" + bytes((crc8(b"\x05\xff\x06\x21\x00\x00\x00"),)), 6) == 0x21000000
    assert tmc2209.reply_value(b"\x05\xff\x06\x21\x00\x00\x00\x00", 6) is None and tmc2209.reply_value(b"\x05\xff", 6) is None


@pytest.mark.parametrize("current_ma, sense_mohm, wanted", [(800, 110, (1, 25)), (1200, 110, (0, 20)), (977, 110, (1, 30)), (1770, 110, (0, 31)), (50, 110, (1, 0)), (1900, 110, None)])
def test_the_current_scale_is_the_datasheet_s(current_ma, sense_mohm, wanted):
    """I = (CS + 1) / 32 · V / (R + 20 mΩ) / √2: never above what is asked, but for the least."""
    found = tmc2209.current_scale(current_ma, sense_mohm)
    assert found == wanted
    if found and found[1]:
        volts = 0.18 if found[0] else 0.325
        steps = [(cs + 1) / 32 * volts / (sense_mohm + 20) * 1e6 / 2**0.5 for cs in (found[1], found[1] + 1)]
        assert steps[0] <= current_ma * 1.0001 < steps[1] * 1.001


@pytest.mark.parametrize("echo", [True, False])
def test_all_drivers_are_set_up_before_anything_moves(echo):
    router = Router(lambda drivers: setattr(drivers, "echo", echo))
    assert router.alarm in (0, errors.ALARM_LOCKED)
    x, y, z = (router.drivers[axis].registers for axis in "xyz")
    assert (x[0x00], y[0x00], z[0x00]) == (0x1C0, 0x1C4, 0x1C0)
    assert (x[0x6C] >> 24 & 15, y[0x6C] >> 24 & 15) == (4, 5)  # 16 and 8 microsteps
    assert (x[0x6C] >> 17 & 1, z[0x6C] >> 17 & 1) == (1, 0)
    assert (x[0x10] >> 8 & 31, x[0x10] & 31, z[0x10] >> 8 & 31, z[0x10] & 31) == (25, 12, 20, 16)
    assert all(each[0x01] == 0 for each in (x, y, z))
    assert "ok" in router.ask("$X") and "ok" in router.ask("$H")
    assert "|Dr:" not in router.reports()


def test_motion_waits_for_the_drivers():
    router = Router(run_ms=0)
    router.machine.send(b"$X\nG91G1X5F600\n")
    while router.machine.plant.position[0] == 3000:
        ready = all(each.registers[0x6C] != 0x10000053 for each in (router.drivers[axis] for axis in "xyz"))
        router.machine.cycle()
        assert ready or router.machine.plant.position[0] == 3000
    assert router.machine.now_ms() < 400


@pytest.mark.parametrize("fault, alarm, said", [
    (lambda drivers: setattr(drivers["y"], "dead", True), ALARM_DRIVER_SILENT, "driver of y: no answer"),
    (lambda drivers: setattr(drivers["z"], "address", 2), ALARM_DRIVER_SILENT, "driver of z: no answer"),
    (lambda drivers: setattr(drivers["z"], "address", 1), ALARM_DRIVER_DIFFERS, "driver of y: 14 of 7 registers taken"),
    (lambda drivers: drivers["x"].registers.update({0x06: 0x20000000}), ALARM_DRIVER_DIFFERS, "driver of x: version 20"),
    (lambda drivers: setattr(drivers["x"], "frozen", (0x6C,)), ALARM_DRIVER_DIFFERS, "driver of x: register 6c is 10000053"),
    (lambda drivers: setattr(drivers, "garbles", 1000), ALARM_DRIVER_SILENT, "driver of x: no answer"),
])  # fmt: skip
def test_a_fault_at_the_start_is_an_alarm_that_names_the_axis(fault, alarm, said):
    """Nothing moves, also if somebody unlocks: the drivers are asked anew, and the alarm comes again."""
    router = Router(fault, run_ms=600)
    if alarm == ALARM_DRIVER_DIFFERS and "of 7" in said:
        assert router.alarm in (alarm, ALARM_DRIVER_SILENT)
    else:
        assert router.alarm == alarm and any(said in entry for entry in router.log()), router.log()
    router.machine.send(b"$X\nG91G1X5F600\n")
    router.machine.run_ms(1000)
    assert router.alarm in (alarm, ALARM_DRIVER_SILENT) and list(router.plant.position) == [3000, 2000, -4000]


def test_two_garbled_replies_are_asked_for_again():
    router = Router(lambda drivers: setattr(drivers, "garbles", 2))
    assert router.alarm in (0, errors.ALARM_LOCKED)


@pytest.mark.parametrize("fault, alarm, said, within_ms", [
    (lambda driver: setattr(driver, "dead", True), ALARM_DRIVER_SILENT, "driver of y: no answer", 250),
    (lambda driver: driver.power_cycle(), ALARM_DRIVER_POWER, "driver of y: reset", 150),
    (lambda driver: driver.registers.update({0x01: 4}), ALARM_DRIVER_POWER, "driver of y: undervoltage", 150),
    (lambda driver: setattr(driver, "status", 0x80000003), ALARM_DRIVER_FAULT, "driver of y: overheated", 150),
    (lambda driver: setattr(driver, "status", 0x80000010), ALARM_DRIVER_FAULT, "driver of y: short", 150),
])  # fmt: skip
def test_a_fault_while_it_moves_stops_the_machine_and_takes_the_current_off(fault, alarm, said, within_ms):
    router = Router()
    router.ask("$X")
    router.ask("$H")
    router.machine.send(b"G90G1X100Y50F1500\n")
    router.machine.run_ms(500)
    fault(router.drivers["y"])
    assert router.until_alarm() < within_ms
    assert router.alarm == alarm and any(said in entry for entry in router.log()), router.log()
    router.machine.run_ms(50)
    stood = list(router.plant.position)
    assert not router.plant.enabled and 0 < stood[0] < 32000
    router.machine.run_ms(500)
    assert list(router.plant.position) == stood
    if router.drivers["y"].dead:
        return
    router.drivers["y"].status = 0x80000000
    router.drivers["y"].registers[0x01] = 0
    assert "ok" in router.ask("$X")
    router.machine.run_ms(300)
    assert router.alarm == 0 and router.drivers["y"].registers[0x00] == 0x1C4, "set up anew"
    assert "ok" in router.ask("$H")


def test_heat_and_open_coils_are_told():
    router = Router()
    router.ask("$X")
    router.drivers["x"].status = 0x80000001
    router.drivers["z"].status = 0x80000080
    router.machine.run_ms(300)
    assert "|Dr:x-hot,z-open" in router.reports() and router.alarm == 0
    router.drivers["x"].status = router.drivers["z"].status = 0x80000000
    router.machine.run_ms(300)
    assert "|Dr:" not in router.reports()


@pytest.mark.parametrize("changes, words", [
    ({"port": "uart0"}, "drivers: uart0 belongs to link"),
    ({"motors": [{"axis": "a", "address": 0, "current_ma": 500}]}, "drivers.motors, a: there is no such axis"),
    ({"motors": [{"axis": "x", "address": 4, "current_ma": 500}]}, "address: 4 is not within 0 … 3"),
    ({"motors": [{"axis": "x", "address": 0, "current_ma": 500, "microsteps": 12}]}, "microsteps are 1, 2, 4 … 256, not 12"),
    ({"motors": [{"axis": "x", "address": 0, "current_ma": 1900}]}, "1900 mA are too much for 110 mΩ"),
    ({"motors": [{"axis": "x", "address": 0, "current_ma": 500}, {"axis": "y", "address": 0, "current_ma": 500}]}, "every address once"),
    ({"tx": 2}, "pin 2 is claimed by axis x and by drivers tx"),
    ({"tx": 18, "rx": 19}, "link drivers: tx of uart1 is on pin"),
])  # fmt: skip
def test_what_a_board_file_cannot_ask_for(changes, words):
    with pytest.raises(BoardError, match=words):
        check(router(**changes))
