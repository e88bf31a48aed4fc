"""M6 on the mill's plant: gantry, encoders and interlock as they are, a tool sensor that the tool's tip presses, to the step."""

import random

import pytest

from host_tools import boards
from host_tools.sim.machine import VirtualMachine

STEPS_MM = 80
AT, SENSOR = (100, 50), (300, 200)  # mm
FLOOR = -4000  # the Z of the contact of a tool without length, in steps


class Tip:
    """Presses the sensor while the spindle stands over it and the tool reaches down to it."""

    def __init__(self, machine):
        self.plant = machine.plant
        self.length = 0  # steps
        self.pressed = False
        self.lowest = 0
        self.plant.trace = self

    def add_row(self, tick, position, tool):
        over = all(abs(at - place * STEPS_MM) <= 80 for at, place in zip(position, SENSOR))
        pressed = over and position[2] <= FLOOR + self.length
        if over:
            self.lowest = min(self.lowest, position[2] - FLOOR - self.length)
        if pressed != self.pressed:
            self.pressed = pressed
            self.plant.set_input(tick, "probe", pressed)


@pytest.fixture
def mill():
    board = boards.load("mill_2004")
    board["tool_change"] = {"at": list(AT), "sensor": list(SENSOR), "distance_mm": 100, "seek_mm_min": 600, "locate_mm_min": 60}
    machine = VirtualMachine(board, start=(3000, 2500, -1800), trace=None)
    machine.run_ms(30)
    ask(machine, "$H", 120_000)
    return machine


def ask(machine, line, limit_ms=60_000):
    machine.take()
    machine.send(line.encode() + b"\n")
    machine.run_until(lambda: any(end in machine.replies_so_far() for end in (b"ok\r\n", b"error", b"ALARM")), limit_ms)
    return machine.take().decode()


def change(machine, tip, tool, length):
    """M6: the tool is put in at the pause."""
    machine.take()
    machine.send(b"M6T%d\n" % tool)
    machine.run_until(lambda: b"~ to continue" in machine.replies_so_far(), 60_000)
    machine.run_until(lambda: machine.app.controller.state == "hold" and machine.app.controller.machine.stood, 60_000)
    assert machine.plant.position[:2] == [place * STEPS_MM for place in AT] and machine.plant.position[2] == 0
    tip.length = length
    machine.send(b"~")
    machine.run_until(lambda: any(end in machine.replies_so_far() for end in (b"ok\r\n", b"error", b"ALARM")), 120_000)
    machine.settle()
    return machine.take().decode()


def length_of(machine):
    (line,) = [line for line in ask(machine, "$#").splitlines() if line.startswith("[TLO:")]
    return round(float(line[5:-1]) * STEPS_MM)


def test_the_difference_of_two_tools_is_found_to_the_step(mill):
    tip = Tip(mill)
    rng = random.Random(4)
    first = rng.randint(-500, 500)
    assert change(mill, tip, 1, first).endswith("ok\r\n") and length_of(mill) == 0
    for tool in range(2, 4):
        length = rng.randint(-1500, 1500)
        assert change(mill, tip, tool, length).endswith("ok\r\n")
        assert abs(length_of(mill) - (length - first)) <= 1, (tool, length, first)
    assert -100 < tip.lowest < 0, "not much deeper than where it touches: seek stops in time"
    assert mill.plant.errors == [] and mill.plant.second.position == mill.plant.position[0]
    before = mill.plant.position[2]
    assert "ok" in ask(mill, "G0Z-60")
    mill.settle()
    assert abs(mill.plant.position[2] - (-60 * STEPS_MM + length - first)) <= 1 and before == 0


def test_without_a_sensor_under_it_the_alarm_names_it_and_the_way_out_is_free(mill):
    tip = Tip(mill)
    assert "ok" in change(mill, tip, 1, 0)
    assert "ALARM:5" in change(mill, tip, 2, -20_000)
    mill.send(b"\x18")
    mill.run_ms(50)
    assert "ok" in ask(mill, "$X") and "ok" in ask(mill, "G91G0Z1")
    assert mill.plant.errors == []
