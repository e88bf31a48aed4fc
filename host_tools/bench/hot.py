"""Which sections of the UF2's image the processor reads most, by the byte: they lie side by side, so that they share the flash cache.

    make uf2 CHIP=rp2040
    .venv/bin/python -m host_tools.bench.hot > host_tools/build/hot.txt     # then make uf2 again

Measured on the emulated Pico: lines and dots over USB, first steps, holds, and `?` while lines are stepped. A name that is not there
any more does no harm, and one that is missing costs time only.
"""

import bisect
import re
from collections import Counter
from pathlib import Path

from host_tools import boards
from host_tools.emulator import gcode
from host_tools.emulator.flash_cache import LINE_BYTES
from host_tools.emulator.frozen import boot_for_lines, find_frozen, frozen_machine
from host_tools.emulator.queries import Asking

LINES = 300
SHARE = 0.999  # of all accesses
_FLASH = 0x10000000
_FLASH_END = 0x11000000
_SECTION = re.compile(r"^ (\.(?:text|rodata)\.\S+)\s+0x([0-9a-f]+)\s+0x([0-9a-f]+) \S", re.MULTILINE)


def sections_of(text):
    """Return [(address, bytes, name)] of a linker's map, those in flash whose names tell them apart."""
    found = [(int(address, 16), int(size, 16), name) for name, address, size in _SECTION.findall(text)]
    return sorted((address, size, name) for address, size, name in found if _FLASH <= address < _FLASH_END and size)


def hottest_names(counts, found):
    """Return the names of sections by their accesses a byte, as many as make SHARE of all. `counts`: accesses of each line of the flash."""
    starts = [address for address, _, _ in found]
    each, sizes = Counter(), Counter()
    for line, count in enumerate(counts):
        if count:
            at = bisect.bisect_right(starts, _FLASH + LINE_BYTES * line + LINE_BYTES - 1) - 1
            if at >= 0 and _FLASH + LINE_BYTES * line < starts[at] + found[at][1]:
                each[found[at][2]] += count
    for _, size, name in found:
        sizes[name] += size
    names, left = [], (1 - SHARE) * sum(each.values())
    for name, count in sorted(each.items(), key=lambda one: one[1] / sizes[one[0]]):
        left -= count
        if left < 0:
            names.append(name)
    return names[::-1]


def count_shares(machine, work):
    """Count the accesses of each line of the flash during `work(machine)`; return them as shares of all."""
    counts = machine.pico.flash_cache.watch_lines()
    work(machine)
    total = sum(counts)
    return [count / total for count in counts]


def ask_while_moving(machine):
    """Ask `?` again and again while lines are stepped."""
    asking = Asking(machine, machine.board["links"][0]["name"])
    asking.stream_lines([b"$X\n", b"G21G91F3000\n", *[b"G1X0.5Y0.4\n", b"G1X-0.5Y-0.4\n"] * 400])
    for _ in range(40):
        machine.run_ms(3)
        asking.ask_status()


def move_and_hold(machine):
    """Do the work of first steps, and of holds while lines are stepped."""
    gcode.talk_to(machine)
    gcode.time_first_steps(machine, 4)
    gcode.time_holds(machine, 2)


def main():
    """Print the names of the hottest sections, one a line. They come from four measurements on the emulated Pico: lines, dots, first steps and holds,
    and `?` in motion."""
    uf2 = find_frozen("rp2040")
    router = gcode.fast_board((0.2,), mm_s=500, mm_s2=300_000)
    laser = gcode.fast_board((0.1,), laser=True)
    shares = [
        count_shares(boot_for_lines(router[0], uf2, router[1]), lambda machine: gcode.lines_over(machine, "pc", 0.2, 490, LINES)),
        count_shares(boot_for_lines(laser[0], uf2, laser[1]), lambda machine: gcode.dots_over(machine, "pc", 0.1, 200, LINES)),
        count_shares(boot_for_lines(router[0], uf2, router[1]), move_and_hold),
        count_shares(_boot_machine(uf2), ask_while_moving),
    ]
    text = Path("build", "uf2-rp2040", "made", "firmware.elf.map").read_text()
    print("\n".join(hottest_names([sum(each) for each in zip(*shares)], sections_of(text))))


def _boot_machine(uf2):
    machine = frozen_machine(boards.load("router_3axis"), uf2, trace=None).boot()
    machine.run_ms(2500)
    return machine


if __name__ == "__main__":
    main()
