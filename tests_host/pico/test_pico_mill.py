"""The whole mill on one emulated Pico: four motors, four encoders, shift registers, inverter, interlock, from its board file."""

from functools import lru_cache

import pytest
from emulated import READY, RUN, uf2  # noqa: F401

from host_tools.emulator.heap import Heap
from host_tools.emulator.load import Load
from host_tools.emulator.machine import EmulatedMachine, firmware_files

pytestmark = [pytest.mark.slow, pytest.mark.on_a_copy, pytest.mark.xdist_group("mill")]
STEPS_MM = 80
ENABLE, TOOL = 0, 4  # bits of the 74HC595


class Mill:
    def __init__(self, machine):
        self.machine = machine
        self.plant = machine.plant
        self.outputs = machine.wiring.chains.outputs
        machine.run_until(lambda: b"unlock" in machine.replies_so_far(), 12_000)
        machine.run_ms(60)

    def ask(self, line, limit_ms=20_000):
        """A line's answers up to ok, error or alarm."""
        self.machine.take()
        self.machine.send(line.encode() + b"\n")
        ends = (b"ok\r\n", b"error", b"ALARM")
        self.machine.run_until(lambda: any(end in self.machine.replies_so_far() for end in ends), limit_ms)
        return self.machine.take().decode()

    def settle(self):
        self.machine.run_until(lambda: self.state().startswith("Idle"), 20_000, 50_000)

    def state(self):
        self.machine.take()
        self.machine.send(b"?")
        self.machine.run_until(lambda: b">" in self.machine.replies_so_far(), 1000)
        return self.machine.take().decode().partition("<")[2]


@lru_cache
def _mill(uf2):
    mill = Mill(EmulatedMachine("mill_2004", uf2=uf2, trace=None, start=(800, 1000, -400)).boot())
    assert "ok" in mill.ask("$X")
    assert "ok" in mill.ask("G91")
    return mill


@pytest.fixture(scope="session")
def mill(uf2):  # noqa: F811
    return _mill(uf2)


def test_room_on_the_heap(uf2, show):  # noqa: F811
    """The free bytes after the machine is built, before the first cycle."""
    files = dict(firmware_files("mill_2004"))
    tell = READY.replace(b"print('ready')", b"import gc; print('FREE', gc.mem_free())")
    assert RUN in files["main.py"]
    files["main.py"] = files["main.py"].replace(RUN, tell + RUN)
    machine = EmulatedMachine("mill_2004", files, uf2=uf2, trace=None).boot()
    machine.pico.console.expect(b"FREE ", 12_000_000)
    heap = Heap(machine.pico)
    free = int(machine.pico.console.expect(b"\r\n"))
    assert free >= 34_000 and heap.largest >= 1_000
    show("heap free on the Pico, the whole mill loaded", f"{free} bytes, largest piece {heap.largest}")


def test_it_boots_with_room_and_cuts_with_the_spindle_at_speed(mill, show):
    mill.machine.send(b"M3S9000\n")
    mill.machine.run_ms(300)
    model = mill.machine.inverter.model
    assert b"ok" not in mill.machine.replies_so_far() and 0 < model.hz < 140, "it waits for the spindle"
    assert mill.outputs[TOOL] == 1
    mill.machine.run_until(lambda: b"ok" in mill.machine.replies_so_far(), 5000)
    assert model.hz == pytest.approx(150, abs=8) and model.way == 3
    position = list(mill.plant.position)
    assert "ok" in mill.ask("G1X20Y12Z-2F2400")
    mill.machine.run_ms(120)
    load = Load(mill.machine.pico)
    mill.machine.run_ms(150)
    shares = load.end()
    mill.settle()
    assert mill.plant.position == [position[0] + 1600, position[1] + 960, position[2] - 160]
    assert mill.plant.second.position == mill.plant.position[0]
    counts = [int(line.split(",")[1]) for line in mill.ask("$ENC").splitlines() if line.startswith("[ENC:")]
    assert counts == [5 * 1600, 5 * 1600, 5 * 960, -10 * 160]
    assert mill.plant.errors == []
    left = shares["main"] + shares.get("asleep", 0)
    assert left > 0.4
    show("the whole mill on the emulated Pico", f"at 3200 steps/s its interrupts leave {left:.0%} of the processor: {shares}")


def test_a_limit_behind_the_register_stops_it_at_once(mill, show):
    limit = mill.plant.barriers["bxa"].last
    mill.machine.send(b"G1X-40F2400\n")
    mill.machine.run_until(lambda: b"ALARM:1" in mill.machine.replies_so_far(), 5000)
    assert ",201,bxa]" in mill.ask("$LOG")
    over = limit - mill.plant.position[0]
    assert 0 <= over <= 4, "3200 steps/s: 100 µs of filter, two readings of the registers, the interrupts"
    assert mill.plant.second.position == mill.plant.position[0]
    mill.machine.send(b"\x18")
    mill.machine.run_ms(100)
    assert "ok" in mill.ask("$X")
    assert "error:131" in mill.ask("G91G1X-1F600")
    assert "ok" in mill.ask("G91G1X3F2400")
    mill.settle()
    show("a limit behind the register", f"stands {over} steps behind its edge")


def test_the_emergency_stop_ends_steps_and_spindle(mill, show):
    assert "ok" in mill.ask("M3S9000")
    assert mill.outputs[TOOL] == mill.outputs[ENABLE] == 1
    mill.machine.send(b"G1Y10F2400\n")
    mill.machine.run_ms(200)
    mill.plant.set_input(mill.machine.wiring.tick, "stop", True)
    at = list(mill.plant.position)
    since = mill.machine.pico.now_us
    mill.machine.run_until(lambda: mill.outputs[TOOL] == 0, 5, 10)
    spindle_us = mill.machine.pico.now_us - since
    mill.machine.run_until(lambda: mill.outputs[ENABLE] == 0, 5, 10)
    show("emergency stop of the mill", f"spindle's output off after {spindle_us:.0f} µs, enable after {mill.machine.pico.now_us - since:.0f} µs")
    mill.machine.run_ms(1)
    assert abs(mill.plant.position[1] - at[1]) <= 1
    mill.machine.run_until(lambda: mill.machine.inverter.model.way == 0, 1000)
    mill.plant.set_input(mill.machine.wiring.tick, "stop", False)
    mill.machine.run_ms(50)
    mill.machine.send(b"\x18")
    mill.machine.run_ms(100)
    assert "ok" in mill.ask("$X")


def test_a_drive_fault_behind_the_register(mill):
    """Refused while it stands, halted while it moves; M8 switches its own output and no other."""
    before = list(mill.outputs)
    assert "ok" in mill.ask("M8") and [now != was for now, was in zip(mill.outputs, before)].index(True) == 2
    mill.plant.set_input(mill.machine.wiring.tick, "dy", False)
    mill.machine.run_ms(20)
    assert "error:131" in mill.ask("G1Y1F600") and ",131,dy]" in mill.ask("$LOG")
    mill.plant.set_input(mill.machine.wiring.tick, "dy", True)
    mill.machine.run_ms(60)
    mill.machine.send(b"G1Y20F2400\n")
    mill.machine.run_ms(200)
    mill.plant.set_input(mill.machine.wiring.tick, "dy", False)
    begun = mill.plant.position[1]
    mill.machine.run_ms(30)
    assert 0 < mill.plant.position[1] - begun <= 22, "3200 steps/s, seen by two readings, 3 ms apart"


def test_a_motor_of_the_gantry_that_lags_is_waited_for(mill):
    racked = mill.plant.skew_steps()
    mill.plant.stall_motor("x2", 7)
    mill.ask("G1X5F1500")
    mill.machine.run_ms(800)
    assert mill.plant.skew_steps() == racked
    assert "142,x2 +7]" in mill.ask("$LOG")


def test_a_silent_inverter_ends_safe(mill):
    assert "ok" in mill.ask("M3S6000")
    mill.machine.inverter.model.silent = True
    mill.machine.run_until(lambda: b"ALARM" in mill.machine.replies_so_far(), 3000)
    mill.machine.run_ms(5)
    assert mill.outputs[TOOL] == 0
    mill.machine.inverter.model.silent = False
    mill.machine.send(b"\x18")
    mill.machine.run_until(lambda: mill.machine.inverter.model.way == 0, 5000)
