"""Homing on the emulated Pico ends on the same step, from wherever it begins: a cycle of the main loop may last longer than a step."""

import copy
import random

import pytest
from emulated import make_machine, uf2  # noqa: F401

from host_tools import boards
from passo.protocols.plotter.host import COMMANDS, packet

RUNS = 10
PULL_OFF = 80


def quick_to_home(name):
    """The board file with a short pull-off, so that it is located in a fraction of a second."""
    board = copy.deepcopy(boards.load(name))
    board["homing"]["pull_off_steps"] = PULL_OFF
    return board


def spread(machine, ask):
    """Home RUNS times, each from elsewhere, the head moved by hand (two steps at a time: on one belt a step needs both motors): all the
    places where it ended."""
    chance = random.Random(36)
    found = []
    for _ in range(RUNS):
        for axis, number in zip(machine.board["axes"], range(3)):
            away = -1 if axis["name"] in machine.board["homing"]["high_end"] else 1
            machine.plant.slip_motor(axis["name"], away * 2 * chance.randint(-PULL_OFF // 3, 150) - machine.plant.position[number])
        ask(machine)
        machine.settle()
        assert not machine.plant.errors, machine.plant.errors
        found.append(tuple(machine.plant.position))
    return found


def by_line(machine):
    machine.take()
    machine.send(b"$H\n")
    machine.run_until(lambda: b"ok" in machine.replies_so_far() or b"ALARM" in machine.replies_so_far(), 60_000)
    assert b"ALARM" not in machine.replies_so_far()


def by_packet(machine):
    assert machine.ask(packet(COMMANDS["ORIGIN"])) == b"o"


@pytest.mark.parametrize("name", ("router_3axis", *(pytest.param(name, marks=pytest.mark.slow) for name in ("router_ballscrew", "corexy_plotter"))))
def test_a_machine_that_speaks_grbl_ends_on_the_same_step(name, make_machine, show):  # noqa: F811
    machine = make_machine(quick_to_home(name))
    machine.run_until(lambda: b"$H" in machine.replies_so_far() or b"$X" in machine.replies_so_far(), 10_000)
    found = spread(machine, by_line)
    show(f"homing of {name}", f"{RUNS} times, ended at {set(found)}")
    assert len(set(found)) == 1, found


@pytest.mark.slow
def test_a_plotter_ends_on_the_same_step(make_machine, show):  # noqa: F811
    machine = make_machine(quick_to_home("plotter_2014"))
    machine.run_ms(3000)
    found = spread(machine, by_packet)
    show("homing of plotter_2014", f"{RUNS} times, ended at {set(found)}")
    assert set(found) == {(0, 0)}, found
