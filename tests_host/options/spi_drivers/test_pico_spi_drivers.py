"""TMC5160 and TMC2130 drivers on SPI pins of the emulated Pico, a chain of two and one alone: set up bit by bit, a fault told and safe."""

import copy

import pytest
from emulated import make_machine, uf2  # noqa: F401

from host_tools import boards


@pytest.mark.parametrize("chip", ["tmc5160", pytest.param("tmc2130", marks=pytest.mark.slow)])
def test_drivers_are_set_up_and_a_fault_stops_the_machine(chip, make_machine, show):  # noqa: F811
    board = {**copy.deepcopy(boards.load("router_3axis")), "journal": None, "idle_release_ms": 0}
    motors = [{"axis": axis, "cs": cs, "current_ma": 900} for axis, cs in zip("xyz", (21, 22, 21))]
    board["spi_drivers"] = {"chip": chip, "sck": 18, "tx": 19, "rx": 20, "sense_mohm": 75, "motors": motors}
    machine = make_machine(board, start=(900, 700, -1200))
    drivers = machine.drivers.model

    def ask(line):
        machine.take()
        machine.send(line + b"\n")
        machine.run_until(lambda: any(word in machine.replies_so_far() for word in (b"ok", b"error", b"ALARM")), 60_000)
        return machine.take()

    machine.run_until(lambda: b"$X" in machine.replies_so_far() or b"$H" in machine.replies_so_far(), 10_000)
    assert b"ok" in ask(b"$X")
    rows = 8 if chip == "tmc5160" else 6
    machine.run_until(lambda: all(len(drivers[axis].taken) == rows for axis in "xyz"), 1000)
    machine.run_ms(100)
    assert [len(drivers[axis].taken) for axis in "xyz"] == [rows] * 3, "once"
    assert [drivers[axis].registers[0x6C] >> 24 & 15 for axis in "xyz"] == [4] * 3
    machine.send(b"G91G1X100F3000\n")
    machine.run_ms(500)
    assert machine.plant.position[0] > 1000
    drivers["z"].registers[0x6F] |= 1 << 25
    begun = machine.now_ms()
    machine.run_until(lambda: b"ALARM" in machine.replies_so_far(), 2000)
    took = machine.now_ms() - begun
    machine.run_ms(100)
    stood = list(machine.plant.position)
    machine.run_ms(200)
    assert took < 150 and list(machine.plant.position) == stood and not machine.plant.enabled
    assert b"driver of z: overheated" in ask(b"$LOG")
    drivers["z"].registers[0x6F] = 0x80000000
    assert b"ok" in ask(b"$X") and b"ok" in ask(b"G91G1X-1F3000")
    machine.settle()
    assert list(machine.plant.position) == [stood[0] - 320, *stood[1:]]
    show(f"an overheated {chip} on a Pico", f"an alarm {took:.0f} ms later")
