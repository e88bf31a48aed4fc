"""A servo on the emulated Pico: the pulses on its pin while a pen is set down, draws, and is lifted."""

import pytest
from emulated import uf2  # noqa: F401

from host_tools import boards
from host_tools.emulator.cycles import CYCLES_PER_US
from host_tools.emulator.machine import EmulatedMachine
from passo.protocols.plotter.host import COMMANDS, packet

pytestmark = pytest.mark.slow

PIN = 11


def test_the_pulses_of_a_pen(uf2, show):  # noqa: F811
    board = boards.load("plotter_2014")
    board["tool"].update(on_ms=120, off_ms=80)
    board["servo"] = {"pin": PIN, "up_us": 1800, "down_us": 1200, "up_ms": 60, "down_ms": 100}
    machine = EmulatedMachine(board, trace=None, uf2=uf2).boot()
    edges = machine.pico.edges(PIN)
    machine.run_until(lambda: len(edges) > 4, 5000)
    for command, x, y in (("LINE", 4, 0), ("MOVE", 0, 0)):
        machine.send(packet(COMMANDS[command], x, y))
        machine.run_until(lambda: machine.take() == b"n", 500)
    machine.send(packet(COMMANDS["END"]))
    machine.run_until(lambda: b"d" in machine.received(), 2000)
    machine.run_ms(120)
    rises = [(cycle, fall[0]) for (cycle, state), fall in zip(edges, edges[1:]) if state]
    widths = [round((fall - rise) / CYCLES_PER_US) for rise, fall in rises]
    apart = {round((after[0] - before[0]) / CYCLES_PER_US) for before, after in zip(rises, rises[1:])}
    assert apart == {20_000}
    low = widths.index(min(widths))
    assert widths[0] == widths[-1] == 1800 and min(widths) == 1200
    assert sorted(widths[: low + 1], reverse=True) == widths[: low + 1] and sorted(widths[low:]) == widths[low:]
    assert len(set(widths[:low])) >= 4 and len(set(widths[low:])) >= 3, "ramps"
    show("a servo's pulses", " ".join(map(str, widths)) + " µs")
