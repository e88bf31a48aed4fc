"""The cache before the Pico's flash (RP2040 datasheet, 2.6.3): 16 kB, two ways, lines of 8 bytes; a hit costs nothing.

    cache = FlashCache(chip)
    cache.miss_cycles = 50          # what a miss costs while flash runs at half the clock; 0 is rp2040py's own time
    cache.accesses, cache.misses

Each instruction fetch and data read by the processor counts; DMA's do not. The datasheet does not say which of two lines is
replaced: here the one used longer ago, or with `random` either. 0x11… allocates no line; 0x12… and 0x13… do not look up. A
flush empties the cache and takes 1024 cycles; a disabled cache never hits. Not modelled: the processor's prefetch, which also
fetches beyond a branch taken; the shorter transfer of an access that bypasses the cache; two masters at once.

A miss is a transfer of a fixed number of flash clocks. MicroPython keeps the flash clock within 62.5 MHz by even dividers: 2
at 125 MHz, 4 at 150 and at 200 MHz. So the 50 cycles of a miss (400 ns) become 100 cycles there: 667 and 500 ns.

With core.c (see `native`) the model is part of it and costs no time. Otherwise `watch_accesses` puts it into rp2040py's own reads, which
makes everything five times slower; it is done only if a miss is to cost anything.
"""

import ctypes
import os

from host_tools.emulator import system_clock
from host_tools.emulator.bus import Bus

SETS = 1024
LINE_BYTES, LINES = 8, 1 << 21
_VALID = 1 << 31
_FLUSH_CYCLES = 1024
_CONTROL, _FLUSH, _HITS, _ACCESSES = 0x00, 0x04, 0x0C, 0x10
_FLASH_DIVIDER, _LEAST_DIVIDER = 0x14, 2  # SSI's BAUDR
_FLASH, _FLASH_END, _RAM, _OFFSET = 0x10000000, 0x14000000, 0x20000000, 0xFFFFFF
_NO_ALLOCATION, _NO_LOOK_UP = 1 << 24, 1 << 25


class Fault(Exception):
    """A HardFault on silicon."""

    WHAT = ""

    def __init__(self, pc, address):
        super().__init__(f"{self.WHAT} {address:#010x} at pc {pc:#010x}")
        self.pc, self.address = pc, address


class Unaligned(Fault):
    """A Cortex-M0+ reads and writes words and halfwords at multiples of their size only."""

    WHAT = "unaligned access to"


class NotThumb(Fault):
    """A Cortex-M0+ knows Thumb only: bit 0 of a branch's target is set."""

    WHAT = "branch to the even address"


class Undefined(Fault):
    """There is no instruction of 32 bits that begins with 0b11101 or 0b11111; erased flash is full of them."""

    WHAT = "undefined instruction at"


class Core(ctypes.Structure):
    """The state that core.c works on."""

    _fields_ = [
        ("r", ctypes.c_void_p),
        ("ram", ctypes.c_void_p),
        ("flash", ctypes.c_void_p),
        ("rom", ctypes.c_void_p),
        ("profile", ctypes.c_void_p * 2),
        ("touched", ctypes.c_void_p),
        ("cycles", ctypes.c_int64),
        ("accesses", ctypes.c_uint64),
        ("misses", ctypes.c_uint64),
        ("fault", ctypes.c_uint32),
        ("miss_cycles", ctypes.c_uint32),
        ("disabled", ctypes.c_uint32),
        ("random", ctypes.c_uint32),
        ("sio", ctypes.c_uint32 * 6),  # divider and spinlocks
        ("event", ctypes.c_uint32),
        ("timer_ns", ctypes.c_double),
        ("cycle_ns", ctypes.c_double),
        ("tags", ctypes.c_uint32 * (2 * SETS)),
    ]


def _of_the_state(name):
    return property(lambda self: getattr(self.state, name), lambda self, value: setattr(self.state, name, value))


class FlashCache:
    accesses, misses = map(_of_the_state, ("accesses", "misses"))

    def __init__(self, chip, random=False):
        self.state = Core(random=int(random))
        self._chip = chip
        self._system = system_clock.clock_of(chip)
        self._miss_cycles = 0
        self._patch_registers()
        self._watch_divider()

    @property
    def miss_cycles(self):
        return self._miss_cycles

    @miss_cycles.setter
    def miss_cycles(self, cycles):
        self._miss_cycles = cycles
        divider = max(self._chip.ssi.read_uint32(_FLASH_DIVIDER), _LEAST_DIVIDER)
        self.state.miss_cycles = cycles * divider // _LEAST_DIVIDER

    def _watch_divider(self):
        """Patch the flash interface: each write of its divider, and each reset, computes the cost of a miss anew."""
        ssi = self._chip.ssi
        write, reset = ssi.write_uint32, ssi.reset

        def write_uint32(offset, value):
            write(offset, value)
            if offset == _FLASH_DIVIDER:
                self.miss_cycles = self._miss_cycles

        def restart():
            reset()
            self.miss_cycles = self._miss_cycles

        ssi.write_uint32, ssi.reset = write_uint32, restart

    def watch_lines(self):
        """Count accesses of each line of the flash from now on; returns the array, which the caller keeps alive. Only if core.c runs."""
        counts = (ctypes.c_uint32 * LINES)()
        self.state.touched = ctypes.addressof(counts)
        return counts

    def flush(self):
        """Empty the cache."""
        ctypes.memset(self.state.tags, 0, ctypes.sizeof(self.state.tags))

    def _patch_registers(self):
        """Put XIP_CTRL into the chip, with its counters of hits and accesses."""
        control, state, clock, system = self._chip.xip_ctrl, self.state, self._chip.clock, self._system
        read, write, reset = control.read_uint32, control.write_uint32, control.reset
        cleared = [0, 0]  # accesses and hits before the counters were cleared

        def read_counts():
            return state.accesses - cleared[0], state.accesses - state.misses - cleared[1]

        def read_uint32(offset):
            if offset in (_HITS, _ACCESSES):
                return min(read_counts()[offset == _HITS], 0xFFFFFFFF)
            return read(offset)

        def write_uint32(offset, value):
            """Write a register of the cache: switch it on or off, flush it (takes _FLUSH_CYCLES), or clear a counter (hits, accesses)."""
            write(offset, value)
            if offset == _CONTROL:
                state.disabled = not value & 1
            elif offset == _FLUSH and value & 1:
                self.flush()
                if state.miss_cycles:
                    clock.tick(_FLUSH_CYCLES * system.cycle_ns)
            elif offset in (_HITS, _ACCESSES):
                place = offset == _HITS
                cleared[place] += read_counts()[place]

        def restart():
            reset()
            self.flush()
            state.disabled = 0

        control.read_uint32, control.write_uint32, control.reset = read_uint32, write_uint32, restart

    def touch_line(self, address):
        """Note an access by the processor; return the cycles that it waits."""
        state, tags = self.state, self.state.tags
        line = (address & _OFFSET) >> 3
        tag, first = line | _VALID, 2 * (line % SETS)
        state.accesses += 1
        if not (address & _NO_LOOK_UP or state.disabled):
            if tags[first] == tag:
                return 0
            if tags[first + 1] == tag:
                tags[first], tags[first + 1] = tag, tags[first]
                return 0
        state.misses += 1
        if not (address & _NO_ALLOCATION or state.disabled):
            if not state.random:
                tags[first + 1] = tags[first]
            else:
                state.random = state.random * 1664525 + 1013904223 | 1
                first += state.random >> 16 & 1
            tags[first] = tag
        return state.miss_cycles

    def watch_accesses(self):
        """Put the model, and the faults, into rp2040py's reads and writes."""
        chip, core, tick, touch = self._chip, self._chip.core, self._chip.clock.tick, self.touch_line
        bus, system = Bus(chip), self._system
        flash, ram = memoryview(chip.flash), memoryview(chip.sram)

        def make_read(name, width, code):
            """Return a reader of `width` bytes for the bus method `name`; `code`: the type's letter for memoryview.cast()."""
            stock = getattr(bus, name)
            flash_as, ram_as = flash.cast("B").cast(code), ram.cast("B").cast(code)
            ram_end, shift = _RAM + len(ram), width >> 1

            def read(address):
                """Return the value at an address; a miss in flash takes its cycles. Raises Unaligned if the address is no multiple of `width`."""
                if address & width - 1:
                    raise Unaligned(core.pc - 2, address)
                if _RAM <= address < ram_end:
                    return ram_as[address - _RAM >> shift]
                if _FLASH <= address < _FLASH_END:
                    waits = touch(address)
                    if waits:
                        tick(waits * system.cycle_ns)
                    return flash_as[(address & _OFFSET) >> shift]
                return stock(address)

            return read

        def make_write(name, width):
            """Return a writer of `width` bytes for the bus method `name`; it raises Unaligned if the address is no multiple of `width`."""
            stock = getattr(bus, name)

            def write(address, value):
                if address & width - 1:
                    raise Unaligned(core.pc - 2, address)
                stock(address, value)

            return write

        for width, code in ((1, "B"), (2, "H"), (4, "I")):
            name = f"read_uint{8 * width}"
            setattr(chip, name, make_read(name, width, code))
        for width in (2, 4):
            name = f"write_uint{8 * width}"
            setattr(chip, name, make_write(name, width))


def default_miss_cycles():
    """Return the default cost of a miss: PASSO_FLASH_MISS, or 0."""
    return int(os.environ.get("PASSO_FLASH_MISS") or 0)
