"""Splits the time of a G-code line on the emulated Pico, for `bench`: by parts of the interpreter, to the cycle.

    PASSO_FLASH_MISS=50 python -m host_tools.bench.where [FILE.elf [count]]     # the dearest functions and kernels

FILE.elf belongs to the UF2 that runs: PASSO_ELF, or the file beside that UF2, unless named.
"""

import os
import sys
from functools import lru_cache
from pathlib import Path

from host_tools.emulator import gcode
from host_tools.emulator.binary import Unavailable, find_uf2
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.cycles import CYCLES_PER_US
from host_tools.emulator.profile import IN_RAM, OTHERS, PARTS as _PARTS, ROM, UNNAMED, Cost, part_of, read_symbols

LINES, LENGTH_MM, FEED_MM_S = 300, 0.2, 200
DOTS_MM, DOTS_MM_S = 0.1, 100
ORDER = (IN_RAM, *(name for name, _ in _PARTS), OTHERS, ROM, UNNAMED)


def load_symbols():
    """Read the symbols of the ELF file that PASSO_ELF names, or that lies beside the UF2. Raises Unavailable."""
    path = Path(os.environ.get("PASSO_ELF") or find_uf2().with_suffix(".elf"))
    if not path.is_file():
        raise Unavailable(f"there is no {path}: PASSO_ELF names the ELF file of the UF2 that runs")
    return read_symbols(path)


@lru_cache
def measure_parts():
    """Measure lines and dots, as many as the processor takes; return (what, lines, Spent) of both."""
    machine = gcode.fast_router((LENGTH_MM,))
    lines = on_a_copy(lambda: gcode.run_lines(machine, LENGTH_MM, FEED_MM_S, LINES, profiled=True))
    laser = gcode.fast_router((DOTS_MM,), laser=True)
    dots = on_a_copy(lambda: gcode.run_raster(laser, DOTS_MM, DOTS_MM_S, LINES, profiled=True))
    return [(what, run["lines"], run["spent"]) for what, run in (("line", lines), ("dot", dots))]


def measure_where():
    """Measure the microseconds of a line of 0.2 mm and of a picture's dot, of the main loop and of interrupts. Returns (header, rows)."""
    names = load_symbols()
    rows = [[part] for part in (*ORDER, "all")]
    header = ["µs of"]
    for what, count, spent in measure_parts():
        costs = spent.parts(names)
        total = costs["all"] = spent.total()
        assert set(costs) <= {*ORDER, "all"}
        header += [f"a {what}: main loop", "interrupts", "share", "waits for flash"]
        for row in rows:
            cost = costs.get(row[0], Cost())
            main, interrupts, waits = (
                f"{cycles / CYCLES_PER_US / count:.0f}" for cycles in (cost.main, cost.interrupts, cost.waits)
            )
            row += [main, interrupts, f"{cost.cycles / total.cycles:.1%}", waits]
    return header, rows


def main(elf="", count="40"):
    """Print the µs of a line and of a dot by functions, and by kernels in RAM: the `count` dearest of each. `elf`: path of the ELF file, by default
    that of PASSO_ELF."""
    os.environ["PASSO_ELF"] = elf or os.environ.get("PASSO_ELF", "")
    names = load_symbols()
    for what, lines, spent in measure_parts():
        print(f"\n{'µs of a ' + what:40} {'part':20} {'main':>8} {'interr.':>8} {'flash':>8}")
        for name, cost in [*spent.functions(names)[: int(count)], ("all", spent.total())]:
            figures = [value / CYCLES_PER_US / lines for value in (cost.main, cost.interrupts, cost.waits)]
            print(f"{name:40} {part_of(name):20} {figures[0]:8.1f} {figures[1]:8.1f} {figures[2]:8.1f}")
        print(f"\n{'machine code in RAM, µs of a ' + what:40} {'calls':>20} {'main':>8} {'interr.':>8}")
        for name, calls, cost in spent.kernels(names)[: int(count)]:
            main, interrupts = (value / CYCLES_PER_US / lines for value in (cost.main, cost.interrupts))
            print(f"{name:40} {calls / lines:20.2f} {main:8.1f} {interrupts:8.1f}")


PARTS = {"where": measure_where}

if __name__ == "__main__":
    main(*sys.argv[1:])
