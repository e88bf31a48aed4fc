"""After a halt the set-up time of DIR counts from the levels at the pins, not from words that were never played."""

import pytest

from host_tools import boards
from host_tools.sim.machine import VirtualMachine

pytestmark = pytest.mark.quick


@pytest.mark.parametrize("gantry", [False, True])
@pytest.mark.parametrize("before_ms", range(2, 26, 4))
def test_a_turn_that_was_made_and_not_played(before_ms, gantry):
    board = boards.load("router_3axis")
    if gantry:
        board["gantry"] = {"axis": "x", "pins": [18, 19]}
        board["player"] = "timer"
    machine = VirtualMachine(board, start=(9000, 2500, -1800), trace=True)
    machine.send(b"$X\nG91\nG1X1F1200\nX-1\n")
    machine.run_until(lambda: machine.plant.position[0] >= 9320 - before_ms, 2000)
    machine.send(b"\x18")
    machine.run_ms(30)
    stood = machine.plant.position[0]
    machine.send(b"$X\nG91\nG1X-0.1F1200\n")
    machine.settle()
    assert machine.plant.position[0] == stood - 32 and machine.plant.errors == []
