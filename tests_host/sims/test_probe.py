"""G38 on the virtual board: the place it tells is that of the step at which the probe's pin changed, on every kind of machine."""

import copy

import pytest
from asked import Asked
from probing import Wall, said

from host_tools import boards


def router(**changes):
    return {**copy.deepcopy(boards.load("router_3axis")), "idle_release_ms": 0, "journal": None, **changes}


def belt():
    board = copy.deepcopy(boards.load("corexy_plotter"))
    return {**board, "idle_release_ms": 0, "inputs": [*board["inputs"], {"name": "probe", "pin": 22, "active": 0}]}


def table():
    return {**copy.deepcopy(boards.load("router_4axis")), "idle_release_ms": 0}


# Board, plant, axis, from where it probes to where, the feeds in its units a minute.
MACHINES = {
    "router": (router, {}, "z", -5, -20, (60, 900, 1400)),
    "ball screw": (lambda: router(backlash={"x": 50, "y": 75, "z": 25}), {"play": {"x": 16, "y": 24, "z": 10}}, "z", -5, -20, (60, 900, 1400)),
    "belt": (belt, {}, "x", 20, 60, (60, 900, 9000)),
    "table": (table, {}, "a", 10, 100, (60, 2400, 20_000)),
}


@pytest.mark.parametrize("which", MACHINES)
def test_the_place_is_that_of_the_contact(which):
    """To the step, however many steps lie between two looks of the main loop; and so where contact is lost again."""
    make, options, name, start, end, feeds = MACHINES[which]
    board = make()
    machine = Asked(board, **options)
    machine.do("$X", "$H", "G21G90")
    names = [each["name"] for each in board["axes"]]
    axis = names.index(name)
    steps_mm = [each["steps_per_m"] / 1000 for each in board["axes"]]
    sign = 1 if end > start else -1
    for feed in feeds:
        machine.do(f"G0{name}{start}")
        machine.stand()
        steps = round((start + sign * min(feed / 60, 8)) * steps_mm[axis])
        wall = machine.plant.stock = Wall(axis, steps, sign)
        for code, target in (("G38.2", end), ("G38.4", start)):
            machine.machine.take()
            machine.machine.send(f"{code}{name}{target}F{feed}\n".encode())
            machine.machine.run_until(lambda: b"ok" in machine.machine.replies_so_far() or b"ALARM" in machine.machine.replies_so_far(), 60_000)
            found, touched = said(machine.machine.take(), steps_mm)
            assert touched and found == wall.met[-1], (which, feed, code, found, wall.met)
            machine.stand()
        assert len(wall.met) == 2, wall.met
        machine.plant.stock = None


def test_a_spike_is_not_where_the_probe_touched():
    """Noise long before the contact, over before the main loop looks."""
    machine = Asked(router())
    machine.do("$X", "$H", "G21G90", "G0Z-5")
    machine.stand()
    wall = machine.plant.stock = Wall(2, -3600, -1)
    now = machine.machine.port.now
    machine.plant.inject_noise("probe", [tick for ms in (300, 700, 1100) for tick in (now + ms * 12_500, now + ms * 12_500 + 60)])
    machine.machine.send(b"G38.2Z-20F180\n")
    machine.machine.run_until(lambda: b"ok" in machine.machine.replies_so_far(), 60_000)
    found, touched = said(machine.machine.take(), [320, 320, 400])
    assert touched and found == wall.met[-1], (found, wall.met)


def test_a_contact_behind_the_reading_of_the_pin_is_not_lost():
    """Most of each cycle lies between the reading and what comes of it: a contact there is no noise. The place is the same to the step."""
    machine = Asked(router())
    machine.do("$X", "$H", "G21G90")
    inputs = machine.machine.app.controller.machine.inputs
    read = inputs.read

    def read_slowly(name):
        answer = read(name)
        if name == "probe":
            machine.machine.port.advance(12_500)
        return answer

    for turn in range(6):
        machine.do("G0Z-5")
        machine.stand()
        wall = machine.plant.stock = Wall(2, -3600 - 101 * turn, -1)
        inputs.read = read_slowly
        machine.machine.send(b"G38.2Z-20F900\n")
        machine.machine.run_until(lambda: b"ok" in machine.machine.replies_so_far(), 60_000)
        inputs.read = read
        found, contact = said(machine.machine.take(), [320, 320, 400])
        assert contact and found == wall.met[-1], (turn, found, wall.met)
