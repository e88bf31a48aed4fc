"""G38 on the emulated Pico: the interrupt of the probe's pin keeps the step at which it changed, on the pins."""

import copy

import pytest
from emulated import make_machine, uf2  # noqa: F401
from probing import Wall, said

from host_tools import boards

# Board, axis, the feed in its units a minute: some steps a cycle of the main loop, below the 1000 steps/s up to which an edge is exact.
WAYS = [("router_3axis", "z", -1, 140), pytest.param("router_4axis", "a", 1, 1100, marks=pytest.mark.slow)]


@pytest.mark.parametrize("name, axis, sign, feed", WAYS)
def test_the_place_is_that_of_the_contact(name, axis, sign, feed, make_machine, show):  # noqa: F811
    board = {**copy.deepcopy(boards.load(name)), "idle_release_ms": 0}
    machine = make_machine(board)
    machine.run_until(lambda: b"$H" in machine.replies_so_far() or b"$X" in machine.replies_so_far(), 10_000)

    def do(line):
        machine.take()
        machine.send(line.encode() + b"\n")
        machine.run_until(lambda: b"ok" in machine.replies_so_far() or b"ALARM" in machine.replies_so_far() or b"error" in machine.replies_so_far(), 60_000)
        assert b"ok" in machine.replies_so_far(), machine.replies_so_far()

    for line in ("$X", "G21G90", f"G92{axis}0"):
        do(line)
    number = [each["name"] for each in board["axes"]].index(axis)
    steps_mm = [each["steps_per_m"] / 1000 for each in board["axes"]]
    start = list(machine.plant.position)
    off = []
    wall = None
    for turn in range(20):
        steps = 40 + turn * 37 % 41
        machine.pico.run(turn * 1237 % 5000)  # contacts at any phase of the main loop
        wall = machine.plant.stock = Wall(number, machine.plant.position[number] + sign * steps, sign)
        for code, way in (("G38.2", sign), ("G38.4", -sign)):
            do(f"G91{code}{axis}{way * 2000 / steps_mm[number]:.3f}F{feed}")
            found, touched = said(machine.take(), steps_mm)
            assert touched, wall.met
            off.append(found[number] - (wall.met[-1][number] - start[number]))
            machine.settle()
        assert len(wall.met) == 2, wall.met
        machine.plant.stock = None
    show(f"G38 on {name}", f"steps between contact and the place told: {off}")
    assert set(off) == {0}, off
