"""The same lines and questions to stock MicroPython, as flashed, and to Passo's UF2, for `bench`: `make uf2 CHIP=rp2040` first."""

import copy
from statistics import median

from host_tools import boards
from host_tools.bench.moving import _percentile_99, _tiny_lines, time_answers
from host_tools.bench.pico import CLOCKS_MHZ, GCODE_LINES, _time_answers
from host_tools.emulator import gcode
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.frozen import boot_for_lines, find_frozen, frozen_machine
from host_tools.emulator.machine import EmulatedMachine
from host_tools.emulator.queries import Asking


def measure_frozen():
    """Measure stock MicroPython and Passo's UF2, side by side. Returns (header, rows)."""
    uf2 = find_frozen("rp2040")
    rows = []
    for mhz in CLOCKS_MHZ:
        pairs = zip(_measure_figures(mhz, gcode.boot_router, EmulatedMachine), _measure_figures(mhz, *_makers_of(uf2)))
        rows += [(what, mhz, stock, ours) for (what, stock), (_, ours) in pairs]
    return ("router_3axis, flash cache modelled", "MHz", "stock MicroPython", "UF2"), rows


def _makers_of(uf2):
    """Return (function that makes a machine which waits for lines, function that makes one as flashed)."""
    return (lambda board, texts: boot_for_lines(board, uf2, texts)), (lambda board, **options: frozen_machine(board, uf2, **options))


def _measure_figures(mhz, waiting, flashed):
    """Yield (row's text, figure) of one firmware at a clock of `mhz` MHz: lines and dots a second, and the times of answers in ms. `waiting`,
    `flashed`: the functions of _makers_of()."""
    machine = waiting(*gcode.fast_board((0.2,), clock_mhz=mhz, mm_s=500, mm_s2=300_000))
    yield "lines of 0.2 mm a second, from memory", round(on_a_copy(lambda: gcode.run_lines(machine, 0.2, 490, GCODE_LINES))["lines_s"])
    yield "lines of 0.2 mm a second, over USB", round(on_a_copy(lambda: gcode.lines_over(machine, "pc", 0.2, 490, GCODE_LINES)))
    laser = waiting(*gcode.fast_board((0.1,), laser=True, clock_mhz=mhz))
    yield "dots of 0.1 mm a second, M4, over USB", round(on_a_copy(lambda: gcode.dots_over(laser, "pc", 0.1, 200, GCODE_LINES)))
    steps, holds = on_a_copy(lambda: _time_answers(mhz, flashed))
    yield "first step after a command at rest, over USB, ms: median", f"{median(steps):.2f}"
    yield "a feed hold begins to slow at 100 mm/s, over USB, ms: worst", f"{max(holds):.1f}"
    took_ms = on_a_copy(lambda: time_answers(_boot_flashed(mhz, flashed), _tiny_lines()))
    yield "`?` in a stream of lines of 0.2 mm over USB, ms: median", f"{median(took_ms):.2f}"
    yield "`?` in a stream of lines of 0.2 mm over USB, ms: p99", f"{_percentile_99(took_ms):.2f}"


def _boot_flashed(mhz, flashed):
    """Boot the board as flashed, and unlock it; return (machine, Asking)."""
    machine = flashed({**copy.deepcopy(boards.load("router_3axis")), "commands": "pc", "clock_mhz": mhz}, trace=None).boot()
    machine.pico.console.expect(b"Grbl")
    machine.run_ms(100)
    asking = Asking(machine, "pc")
    asking.stream_lines([b"$X\n", b"G21G91G94F3000\n"])
    machine.run_until(lambda: not asking.unanswered, 1000)
    asking.ask_status()
    return machine, asking


PARTS = {"frozen": measure_frozen}
