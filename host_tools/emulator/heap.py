"""The heap of an emulated Pico, from the collector's own table: nothing runs on the chip for it.

    heap = Heap(pico)
    heap.free, heap.largest         # bytes; garbage that has not been collected is not free
"""

RAM, RAM_BYTES = 0x20000000, 0x42000
BLOCK_BYTES = 16


class Heap:
    def __init__(self, pico):
        """Raises ValueError unless there is one heap as MicroPython describes it (py/mpstate.h, mp_state_mem_area_t)."""
        memory = bytes(pico.chip.sram)[:RAM_BYTES]
        words = memoryview(memory).cast("I")
        found = []
        for at in range(len(words) - 6):
            table, length, finalisers = words[at : at + 3]
            if RAM < table < RAM + RAM_BYTES and 0 < length < 0x1080 and finalisers == table + length + 1:
                for pool, end in (words[at + 3 : at + 5], words[at + 4 : at + 6]):  # weak references may be between
                    if end - pool == length * 4 * BLOCK_BYTES:
                        found.append(memory[table - RAM : table - RAM + length])
        if len(found) != 1:
            raise ValueError(f"{len(found)} descriptions of a heap")
        kinds = [byte >> shift & 3 for byte in found[0] for shift in (0, 2, 4, 6)]
        runs = "".join("01"[kind == 0] for kind in kinds).split("0")
        self.total = BLOCK_BYTES * len(kinds)
        self.free = BLOCK_BYTES * kinds.count(0)
        self.largest = BLOCK_BYTES * max(map(len, runs))
