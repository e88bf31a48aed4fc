"""The heap of an emulated Pico, from the collector's own table: nothing runs on the chip for it.

    heap = Heap(pico)
    heap.free, heap.largest         # bytes; garbage that has not been collected is not free
    heap = Heap(pico, True)         # as after a collection now: blocks that no word outside of the heap leads to are free
"""

RAM, RAM_BYTES = 0x20000000, 0x42000
BLOCK_BYTES = 16
_FREE, _TAIL = 0, 2


class Heap:
    def __init__(self, pico, collected=False):
        """Raises ValueError unless there is one heap as MicroPython describes it (py/mpstate.h, mp_state_mem_area_t)."""
        memory = bytes(pico.chip.sram)[:RAM_BYTES]
        words = memoryview(memory).cast("I")
        found = []
        for at in range(len(words) - 6):
            table, length, finalisers = words[at : at + 3]
            if RAM < table < RAM + RAM_BYTES and 0 < length < 0x1080 and finalisers == table + length + 1:
                for pool, end in (words[at + 3 : at + 5], words[at + 4 : at + 6]):  # weak references may be between
                    if end - pool == length * 4 * BLOCK_BYTES:
                        found.append((pool, memory[table - RAM : table - RAM + length]))
        if len(found) != 1:
            raise ValueError(f"{len(found)} descriptions of a heap")
        pool, table = found[0]
        kinds = [byte >> shift & 3 for byte in table for shift in (0, 2, 4, 6)]
        if collected:
            kinds = _reachable_blocks(kinds, pool, words)
        runs = "".join("01"[kind == _FREE] for kind in kinds).split("0")
        self.total = BLOCK_BYTES * len(kinds)
        self.free = BLOCK_BYTES * kinds.count(_FREE)
        self.largest = BLOCK_BYTES * max(map(len, runs))


def _reachable_blocks(kinds, pool, words):
    """Return the table without blocks that no pointer leads to. Any word of RAM outside of the heap counts as a pointer, old stack included: every
    block free here is free for the collector, which may free more."""
    pieces = {}  # {address: blocks}
    for number, kind in enumerate(kinds):
        if kind == _TAIL:
            pieces[first] += 1
        elif kind != _FREE:
            first = pool + BLOCK_BYTES * number
            pieces[first] = 1
    begin = (pool - RAM) // 4
    end = begin + len(kinds) * BLOCK_BYTES // 4
    left = [bytes(words[:begin]), bytes(words[end:])]
    kept = [_FREE] * len(kinds)
    while left:
        for word in memoryview(left.pop()).cast("I"):
            blocks = pieces.pop(word, 0)
            if blocks:
                first = (word - pool) // BLOCK_BYTES
                kept[first : first + blocks] = kinds[first : first + blocks]
                at = (word - RAM) // 4
                left.append(bytes(words[at : at + blocks * BLOCK_BYTES // 4]))
    return kept
