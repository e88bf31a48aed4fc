"""A servo on the emulated Pico: the pulses on its pin while a pen is set down, draws, and is lifted, and how hard it presses."""

import collections
import itertools

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
    edges = machine.pico.record_edges(PIN)
    machine.run_until(lambda: len(edges) > 4, 5000)
    for command, x, y in (("LINE", 4, 0), ("MOVE", 0, 0)):
        machine.send(packet(COMMANDS[command], x, y))
        machine.run_until(lambda: machine.take() == b"n", 500)
    machine.send(packet(COMMANDS["END"]))
    machine.run_until(lambda: b"d" in machine.replies_so_far(), 2000)
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


def test_each_line_has_its_pressure(uf2):  # noqa: F811
    """By S, on motors in eighth steps: 1600 positions a turn and 40 mm of belt, so 40 steps a mm."""
    motors = {"steps_per_m": 40_000, "travel_steps": 12_000, "max_mm_min": 3000, "accel_mm_s2": 300}
    board = boards.load("plotter_2014")
    board.update(
        drive={"kind": "pbl3770a", "mode": "eighth"}, axes=[{"name": "x", "pins": [2, 3, 4, 5, 6, 7], **motors}, {"name": "y", "pins": [8, 9, 10, 11, 12, 13], **motors}],
        inputs=[], tool={"pin": 14, "on_ms": 120, "off_ms": 80}, servo={"pin": 15, "up_us": 1800, "down_us": 1200, "up_ms": 60, "down_ms": 100, "by_s": True},
        spindle={"max_rpm": 1000, "min_rpm": 0}, speed={"unit": "steps_per_s", "default": 1000, "min": 10, "max": 2000},
        links=[{"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "grbl"}],
    )  # fmt: skip
    del board["homing"]
    machine = EmulatedMachine(board, uf2=uf2).boot()
    machine.run_until(machine.is_listening, 10_000)
    for line in (b"$X", b"G21 G91 F3000", b"M3 S600", b"G1 X6", b"M5", b"G0 Y3", b"M3 S300", b"G1 X-6", b"M5", b"G4 P0"):
        machine.take()
        machine.send(line + b"\n")
        machine.run_until(lambda: b"ok" in machine.replies_so_far(), 5000)
    rows = machine.trace.rows()
    drawn = collections.Counter((row[2], row[-1]) for before, row in itertools.pairwise(rows) if row[1] != before[1])
    assert drawn == {(0, 600): 240, (120, 300): 240} and rows[-1][-1] == 0 and not machine.plant.errors
