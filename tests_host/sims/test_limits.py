"""Hard limits of a board without an interlock: from the switch's edge to the last step, at its tick."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from host_tools.sim.machine import VirtualMachine
from tiers import examples

TICKS_PER_US = 12.5
FILTER_US = 50
PULSE_US = 3
MM = 320  # steps


class Steps:
    """The trace, and the ticks of steps."""

    def __init__(self):
        self.ticks = []
        self.places = []

    def add_row(self, tick, position, tool):
        if not self.places or self.places[-1] != tuple(position):
            self.ticks.append(tick)
            self.places.append(tuple(position))


def send(made, data, ms=60):
    made.take()
    made.send(data)
    made.run_ms(ms)
    return made.take().decode()


def turn(made, name):
    """The switch changes, from now on."""
    made.plant.inject_noise(name, [made.port.now + 1])
    return made.port.now + 1


def machine(setting=b"$21=1\n"):
    made = VirtualMachine("router_3axis", start=(30_000, 20_000, -8000), trace=None)
    made.plant.trace = Steps()
    made.run_ms(40)
    assert "error" not in send(made, b"$X\nG91\nM3 S1000\n" + setting)
    return made


@settings(max_examples=examples(25), deadline=None)
@given(some.sampled_from(("limit_x", "limit_y", "limit_z")), some.integers(60, 5000), some.integers(40_000, 900_000), some.booleans())
def test_from_the_switch_to_the_last_step(name, speed, wait_us, turned):
    """Of no speed more than the filter's time and one pulse; the tool is off, the alarm is grbl's."""
    made = machine()
    if turned:  # at rest the switches are active then: no news until one closes
        other = b"$5=0\n" if "$5=1" in send(made, b"$$\n") else b"$5=1\n"
        assert "error" not in send(made, b"M5\n" + other + b"M3 S1000\n")
        for axis in "xyz":
            turn(made, "limit_" + axis)
        made.run_ms(100)
        assert "Alarm" not in send(made, b"?")
    made.send(f"G1 X90 Y-50 F{speed}\n".encode())
    hit = made.port.now + int(wait_us * TICKS_PER_US)
    made.plant.inject_noise(name, [hit])
    made.run_ms(1000)
    ticks = made.plant.trace.ticks
    assert [tick for tick in ticks if tick < hit]
    assert (max(ticks) - hit) / TICKS_PER_US <= FILTER_US + PULSE_US
    said = made.take().decode()
    assert "ALARM:1" in said
    assert not made.plant.tool


@settings(max_examples=examples(10), deadline=None)
@given(some.lists(some.integers(1, 45), min_size=1, max_size=6), some.integers(100_000, 500_000))
def test_noise_stops_nothing(widths, wait_us):
    """A change shorter than the filter does not count, on any of the wires."""
    made = machine()
    made.send(b"G1 X30 Y-20 F3000\n")
    at = made.port.now + int(wait_us * TICKS_PER_US)
    for number, width in enumerate(widths):
        made.plant.inject_noise("limit_" + "xyz"[number % 3], [at, at + int(width * TICKS_PER_US)])
        at += int(200 * TICKS_PER_US)
    made.run_ms(1500)
    assert "ALARM" not in made.take().decode()
    assert made.plant.trace.places[-1][:2] == (30_000 + 30 * MM, 20_000 - 20 * MM)


def test_off_the_switch_and_again():
    """After the alarm the axis may leave the switch, which chatters; hit anew, it stops anew. Without $21 nothing does."""
    made = machine()
    made.send(b"G1 X-10 F2000\n")
    made.run_ms(150)
    turn(made, "limit_x")
    assert "ALARM:1" in send(made, b"")
    assert "ok" in send(made, b"\x18\n$X\nG91\n")
    assert "ok" in send(made, b"G1 X5 F1000\n", 100)
    for _ in range(5):
        turn(made, "limit_x")
        made.run_ms(1)
    made.run_ms(600)
    assert "Idle" in send(made, b"?")
    made.send(b"G1 X-5\n")
    made.run_ms(60)
    at = turn(made, "limit_x")
    assert "ALARM:1" in send(made, b"")
    assert (made.plant.trace.ticks[-1] - at) / TICKS_PER_US <= FILTER_US + PULSE_US
    made = machine(b"$21=0\n")
    made.send(b"G1 X-10 F2000\n")
    made.run_ms(100)
    turn(made, "limit_x")
    made.run_ms(600)
    assert "ALARM" not in made.take().decode() and made.plant.trace.places[-1][0] == 30_000 - 10 * MM


@pytest.mark.parametrize("name", ["limit_x", "limit_z"])
def test_homing_and_the_next_job(name):
    """Homing runs into the switches all the same; after it they stop the machine again."""
    made = machine(b"$21=1\n$22=1\n")
    made.send(b"$H\n")
    made.run_ms(60_000)
    assert "ok" in made.take().decode() and "Idle" in send(made, b"?")
    made.send(b"G91 G1 X20 Y20 F1500\n")
    made.run_ms(300)
    at = turn(made, name)
    assert "ALARM:1" in send(made, b"")
    assert (made.plant.trace.ticks[-1] - at) / TICKS_PER_US <= FILTER_US + PULSE_US
