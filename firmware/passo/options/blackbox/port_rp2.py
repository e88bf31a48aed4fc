"""A black box (control.py) in memory after a reset: watchdog and reset button leave it, a power cut does not."""

import sys
from struct import pack

import uctypes

_MEMORY = 0x80000 if "RP2350" in sys.implementation._machine else 0x40000


def save_left_box(write, first, second, size, text_bytes, added, written):
    """Call write("reset", numbers, text) for a box that is not in flash yet. Only at the start, once.

    `first`, `second`: the beginning of the numbers, before the text's bytes; behind the text eight parts of the second. `size`,
    `text_bytes`: of both in bytes. `added`, `written`: where in the numbers stand two that are the same if all is in flash."""
    memory = uctypes.bytearray_at(0x20000000, _MEMORY)
    at = _find_box(memory, pack("<ii", second, text_bytes), pack("<i", first))
    end = _find_box(memory, bytes([second >> shift & 0xFF for shift in range(1, 8)]), bytes([second & 0xFF]))
    if at < 0 or end < text_bytes:
        return
    memory[at] = memory[end] = 0
    numbers = uctypes.bytearray_at(0x20000000 + at, size)
    if numbers[added : added + 4] != numbers[written : written + 4]:
        write("reset", numbers, uctypes.bytearray_at(0x20000000 + end - text_bytes, text_bytes))


def _find_box(memory, tail, front):
    """Return the offset of `front` followed by `tail`, a sequence that memory has once; -1 if it has none."""
    at = memory.find(tail)
    while at >= 0 and memory[at - len(front) : at] != front:
        at = memory.find(tail, at + 1)
    return at - len(front) if at >= 0 else -1
