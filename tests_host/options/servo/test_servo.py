"""A servo that lifts the pen, on the virtual machine: its ramps, its pressure by S, and the words that lift it."""

import itertools

import pytest

from host_tools import boards
from host_tools.sim.machine import VirtualMachine
from passo.config.boardfile import BoardError, check
from passo.protocols.plotter.host import COMMANDS, packet

pytestmark = pytest.mark.quick

SERVO = {"pin": 11, "up_us": 1800, "down_us": 1200, "up_ms": 100, "down_ms": 400}


def plotter(**keys):
    board = boards.load("plotter_2014")
    board["tool"].update(on_ms=420, off_ms=120)
    board["servo"] = {**SERVO, **keys}
    return board


def with_s():
    """A pen plotter that speaks grbl, and presses by S."""
    board = boards.load("laser_xy")
    board["spindle"] = {"max_rpm": 1000}
    board["tool"] = {"pin": 6, "on_ms": 420, "off_ms": 120}
    board["servo"] = {**SERVO, "pin": 7, "by_s": True}
    return board


def heights(machine):
    """[(ms, height)] of the pen."""
    rows = [(row[0] / 1000, row[5]) for row in machine.trace.rows()]
    return [next(group) for _, group in itertools.groupby(rows, key=lambda row: row[1])]


def drawn(machine):
    """Pen heights at which X or Y steps."""
    rows = machine.trace.rows()
    return {after[5] for before, after in zip(rows, rows[1:]) if before[1:3] != after[1:3]}


def test_the_pen_goes_down_slowly_and_up_quickly():
    machine = VirtualMachine(plotter(), start=(20, 20))
    machine.ask(packet(COMMANDS["ORIGIN"]))
    for command, x, y in (("MOVE", 30, 0), ("LINE", 60, 20), ("MOVE", 10, 10)):
        assert machine.ask(packet(COMMANDS[command], x, y)) == b"n"
    assert machine.ask(packet(COMMANDS["END"])) == b"d"
    assert drawn(machine) == {0, 1000}
    found = heights(machine)
    down = [row for row in found if row[1]][0][0], [row for row in found if row[1] == 1000][0][0]
    way_down = [height for _, height in found[: [height for _, height in found].index(1000) + 1]]
    assert way_down == sorted(way_down) and 360 <= down[1] - down[0] <= 400
    assert max(after - before for before, after in itertools.pairwise(way_down)) <= 100, "1 … 1.6 pulses of 20 ms"
    up = [at for at, height in found if height != 1000 and at > down[1]]
    assert 60 <= up[-1] - up[0] <= 100 and found[-1][1] == 0
    assert machine.plant.errors == []


@pytest.mark.parametrize("word", ["STOP", "off"])
def test_a_stop_lifts_the_pen(word):
    machine = VirtualMachine(plotter(), start=(20, 20))
    machine.ask(packet(COMMANDS["ORIGIN"]))
    for x, y in ((300, 200), (0, 0)):
        machine.ask(packet(COMMANDS["LINE"], x, y))
    machine.send(packet(COMMANDS["END"]))
    machine.run_until(lambda: machine.plant.tool == 1000)
    machine.run_ms(100)
    if word == "STOP":
        machine.send(packet(COMMANDS["STOP"]))
    else:
        machine.app.controller.machine.raise_alarm(200, "a test")
    machine.run_ms(200)
    assert machine.plant.tool == 0


def test_s_is_the_pressure():
    machine = VirtualMachine(with_s(), start=(1000, 1000))
    machine.run_ms(30)
    machine.send(b"$X\nG21G91F3000\n")
    machine.run_ms(30)
    machine.take()
    for line in (b"M3S600\n", b"G1X5\n", b"S250\n", b"G4P0.5\n", b"G1X5\n", b"M5\n", b"G0Y3\n"):
        machine.send(line)
        machine.run_until(lambda: b"ok" in machine.replies_so_far())
        answer = machine.take()
        assert answer.replace(b"[MSG:Caution: not homed, soft limits do not hold]\r\n", b"") == b"ok\r\n", line
        assert (b"Caution" in answer) == line.startswith(b"M3"), "said once, before the pen goes down"
    machine.run_until(lambda: not machine.app.controller.machine.awake)
    machine.run_ms(200)
    assert drawn(machine) >= {600, 250, 0} and max(height for _, height in heights(machine)) == 600
    rows = [row for row in machine.trace.rows() if row[5] not in (0, 250, 600)]
    assert len({row[1:3] for row in rows}) <= 3, "the machine waits while the pen is on its way down or up"
    assert machine.plant.tool == 0 and machine.plant.errors == []


@pytest.mark.parametrize("change, words", [
    ({"servo": {"pin": 10}}, "pin 10 is claimed by tool and by servo pin"),
    ({"servo": {"pin": 11, "down_ms": 500}}, "tool.on_ms: the servo takes 520 ms"),
    ({"servo": {"pin": 11, "up_ms": 200}}, "tool.off_ms: the servo takes 220 ms"),
    ({"servo": {"pin": 11, "by_s": True}}, "servo.by_s: only links that speak grbl know S"),
    ({"servo": {"pin": 11, "up_us": 100}}, "servo.up_us: 100 is not within 400 … 2600"),
    ({"servo": {"pin": 11}, "spindle": {"max_rpm": 1000, "pwm": True, "pin": 12}}, "servo: it is the tool; leave out spindle.pwm and spindle.laser"),
])  # fmt: skip
def test_what_cannot_be_is_refused(change, words):
    with pytest.raises(BoardError) as error:
        check({**plotter(), **change})
    assert str(error.value) == words
