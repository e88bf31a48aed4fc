"""A router with a rotary table on the emulated Pico: its pins make the steps that the virtual board makes, at the same ticks."""

import copy

import pytest
from emulated import make_machine, uf2  # noqa: F401

from host_tools import boards
from host_tools.sim.machine import VirtualMachine

LINES = ("$X", "G21G91G1X2A90F600", "A-45F3600", "G1X-1Y1A7.5F300", "$J=G91A12F7200", "G90G1X0Y0A0F6000")


def turned(machine):
    """The places of the path, in steps from its end."""
    machine.run_until(lambda: b"unlock" in machine.replies_so_far(), 10_000)
    for line in LINES:
        machine.take()
        machine.send(line.encode() + b"\n")
        machine.run_until(lambda: b"ok" in machine.replies_so_far() or b"error" in machine.replies_so_far(), 60_000)
        assert b"error" not in machine.replies_so_far(), line
        machine.settle()
    rows = machine.trace.rows()
    assert not machine.plant.errors, machine.plant.errors
    return [tuple(row[1 + axis] - rows[-1][1 + axis] for axis in range(4)) for row in rows]


@pytest.mark.slow
def test_the_pins_turn_the_table_as_the_virtual_board_does(make_machine, show):  # noqa: F811
    board = copy.deepcopy(boards.load("router_4axis"))
    for link in board["links"]:
        link.pop("lost")
    wanted = turned(VirtualMachine(copy.deepcopy(board)))
    found = turned(make_machine(board))
    assert found == wanted and max(place[3] for place in found) == 4800
    show("a rotary table on the pins of a Pico", f"{len(found)} steps, as on the virtual board")
