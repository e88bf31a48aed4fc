"""The mill under random trouble on its inputs (mill_inputs.py), and under noise on its limits at speed."""

import random

import pytest
from mill_inputs import Session

from host_tools import boards
from host_tools.sim.machine import VirtualMachine

CHUNK = 5000


def run(seed, count, whole=False):
    session = Session(seed, whole)
    for number in range(count):
        try:
            session.sequence()
        except AssertionError as error:
            raise AssertionError(f"Session({seed}), sequence {number}: {error}") from error
    assert session.trips and session.quiet, "some stop the machine, some do not"
    return session


@pytest.mark.quick
def test_random_inputs():
    run(1, 60)


def test_more_random_inputs(show):
    """With its gantry, encoders and inverter, as the hundred thousand have not."""
    session = run(2, 300, whole=True)
    show("random inputs", f"{session.trips} stops, {session.quiet} undisturbed motions, {session.witness.steps} steps")


@pytest.mark.slow
@pytest.mark.unmeasured
@pytest.mark.parametrize("seed", range(100, 120))
def test_a_hundred_thousand_random_inputs(seed):
    run(seed, CHUNK)


# --- noise at speed


def fast_mill(steps_s):
    """The mill with drivers and an X axis for `steps_s`."""
    board = boards.load("mill_2004")
    board["drive"] = {"kind": "step_dir", "pulse_us": 2, "setup_us": 5}
    fast = {"max_mm_min": steps_s * 60 // 80, "accel_mm_s2": 20_000, "travel_steps": 1_000_000}
    board["axes"] = [{**axis, **fast} for axis in board["axes"]]
    return board


class Fast:
    def __init__(self, steps_s, steps):
        self.machine = VirtualMachine(fast_mill(steps_s), start=(1000, 1000, -1000), trace=True)
        self.machine.run_ms(30)
        self.machine.send(b"$X\nG91\nG1X%.4fF%d\n" % (steps / 80, steps_s * 60 // 80))
        self.steps_s = steps_s
        self.end = 1000 + steps
        start = self.machine.now_ms() + 1000 * steps_s / (20_000 * 80) + 50
        self.machine.run_until(lambda: self.machine.now_ms() > start)

    def interlock(self):
        return self.machine.port.veto


@pytest.mark.parametrize("steps_s", [30_000, 100_000])
@pytest.mark.parametrize("longest_us", [5, 50])
def test_bursts_stop_nothing_and_are_counted(steps_s, longest_us):
    """Bursts of spikes on all limits; each spike lasts at most `longest_us`."""
    rng = random.Random(steps_s + longest_us)
    fast = Fast(steps_s, steps_s // 2)
    machine = fast.machine
    injected = {}
    names = [item["name"] for item in machine.board["inputs"] if item["filter_us"]]
    for name in names:
        for burst in range(20):
            begin = machine.port.now + rng.randint(1000, 200 * 12_500) + burst
            spikes = rng.randint(1, 1 if longest_us == 5 else 8)
            times = rng.sample(range(1, longest_us * 25 // 2), 2 * spikes)
            machine.plant.inject_noise(name, [begin + time for time in times])
    levels = {name: [] for name in names}
    machine.plant.listen(lambda tick, name, level: levels[name].append((tick, level)))
    machine.settle()
    assert machine.app.controller.state == "idle" and machine.plant.position[0] == fast.end
    for name, changes in levels.items():
        rest = changes[-1][1]
        injected[name] = sum(level != rest for _, level in changes)
    found = dict(zip((item["name"] for item in machine.board["inputs"]), fast.interlock().glitches))
    assert {name: found[name] for name in names} == injected and min(injected.values()) >= 10
    assert machine.app.controller.machine.log.counts == {}


@pytest.mark.parametrize("steps_s", [30_000, 100_000])
@pytest.mark.parametrize("name", ["bxb", "dx1", "dx2", "sel", "stop"])
def test_a_true_trip_acts_within_the_filters_time(steps_s, name):
    """Even if it begins with a burst: from its last edge on the filter's time counts."""
    fast = Fast(steps_s, steps_s // 2)
    machine = fast.machine
    filter_us = {item["name"]: item["filter_us"] for item in machine.board["inputs"]}[name]
    at = machine.port.now + 100_003
    machine.plant.inject_noise(name, [at - 1500, at - 1300, at] if filter_us else [at])
    machine.settle()
    rows = machine.trace.rows()
    last_us = max(row[0] for row in rows)
    interval_us = 1e6 / steps_s
    late_us = last_us - at * 0.08 - filter_us
    assert -interval_us - 1 <= late_us <= interval_us + 2
    entry = machine.app.controller.machine.log.entries[0]
    assert entry[2] == name and entry[1] == (201 if name in ("bxb", "stop") else 220)
    assert 1000 + machine.app.controller.position()[0] == machine.plant.position[0] < fast.end
    assert machine.plant.errors == []


@pytest.mark.parametrize("name", ["bxa", "bya", "byb", "bza", "bzb", "dy", "dz", "probe"])
def test_what_forbids_other_directions_lets_it_pass(name):
    fast = Fast(30_000, 15_000)
    fast.machine.plant.inject_noise(name, [fast.machine.port.now + 1000])
    fast.machine.settle()
    assert fast.machine.plant.position[0] == fast.end and fast.machine.app.controller.state == "idle"
