"""A drawing by `passo draw` on the emulated Pico: the lines that STEP, DIR and tool pins draw on a laser and on a router."""

import random

import numpy
import pytest
from emulated import make_machine, uf2  # noqa: F401
from test_draw import farthest_mm, page_of, sampled

from host_tools import boards
from host_tools.cli import draw_gcode
from host_tools.cli.draw_options import Said
from host_tools.drawings import drawing, gcode
from host_tools.emulator.cycles import CYCLES_PER_US

WITHIN_MM = 0.2  # of which 0.1 mm are the samples
DEPTH_MM = 0.3


@pytest.mark.slow
@pytest.mark.parametrize("board, tool", [("laser_xy", "laser"), ("router_3axis", "z")])
def test_the_pins_draw_the_drawing(tmp_path, make_machine, show, board, tool):  # noqa: F811
    chance = random.Random(board)
    body = "".join(
        f'<path d="M{chance.uniform(2, 18):.2f} {chance.uniform(2, 18):.2f}q{chance.uniform(-4, 4):.2f} {chance.uniform(-4, 4):.2f} '
        f'{chance.uniform(-4, 4):.2f} {chance.uniform(-4, 4):.2f}"/>' for _ in range(6)
    ) + '<circle cx="10" cy="10" r="3"/>'  # fmt: skip
    loaded = boards.load(board)
    plan = drawing.load(page_of(tmp_path, 20, 20, body), loaded)
    said = Said(tmp_path, tool=tool, feed=1500.0, depth=DEPTH_MM, lift=0.5, plunge=600.0, passes=1)
    lines = gcode.lines_of(plan, draw_gcode.cuts_of_parts(loaded, plan, said))

    machine = make_machine(board)
    machine.run_until(lambda: b"unlock" in machine.replies_so_far() or b"$X" in machine.replies_so_far(), 10_000)
    start = list(machine.plant.position)
    switched = machine.pico.record_edges(loaded["tool"]["pin"])
    for line in ["$X", *lines]:
        machine.take()
        machine.send(line.encode() + b"\n")
        machine.run_until(lambda: b"ok" in machine.replies_so_far() or b"error" in machine.replies_so_far(), 20_000)
        assert b"error" not in machine.replies_so_far(), line
    machine.settle()

    rows = numpy.array(machine.trace.rows())
    places = rows[:, 1:3] / plan.steps_per_mm
    places -= places[0]
    if tool == "z":
        down = (rows[:, 3] - rows[0, 3]) * 1000 / loaded["axes"][2]["steps_per_m"] < 0.01 - DEPTH_MM
    else:
        down = numpy.searchsorted([cycle / CYCLES_PER_US for cycle, _ in switched], rows[:, 0] + 0.5) % 2 == 1
    cuts = numpy.flatnonzero(numpy.diff(down.astype(int)))
    drawn = [places[first + 1 : last + 1] for first, last in zip(cuts[::2], cuts[1::2])]
    wanted = [numpy.array(line) / plan.steps_per_mm for line in plan.lines]
    assert len(drawn) == len(wanted) and [a - b for a, b in zip(machine.plant.position[:2], start)] == [0, 0]
    far = [
        farthest_mm(numpy.concatenate([sampled(line, 0.2) for line in one]), other) for one, other in ((wanted, drawn), (drawn, wanted))
    ]
    show(f"a drawing on {board}", f"{len(rows) - 1} steps at the pins, at most {max(far):.3f} mm off")
    assert max(far) < WITHIN_MM
