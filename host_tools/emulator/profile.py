"""Counts the processor's cycles for each address of code, by functions and by parts of the interpreter.

    profile = Profile(pico)                     # from now on; only where core.c runs (see `native`)
    pico.run(100_000)
    spent = profile.end()                       # Spent
    spent.functions(read_symbols("firmware.elf"))   # [(name, Cost)], the dearest first; the rest is machine code in RAM
    spent.parts(read_symbols("firmware.elf"))       # {"lookup": Cost, …}
    spent.kernels(read_symbols("firmware.elf"))     # [(name, calls, Cost)] of the machine code in RAM

`load` samples instead. Both separate the main loop from interrupts. The ELF file must belong to the UF2 that runs; a build of
MicroPython leaves both in one folder. Time asleep is not counted.
"""

import bisect
import ctypes
import re
import struct
from collections import defaultdict
from dataclasses import dataclass

from host_tools.emulator.binary import Unavailable
from host_tools.emulator.kernels import Kernels
from host_tools.failure import Failure

_FLASH, _RAM = 0x10000000, 0x20000000
_FLASH_SLOTS, _RAM_SLOTS, _ROM_SLOTS = 1 << 20, 132 * 1024, 8 * 1024  # halfwords of code, as core.c numbers them
_SLOTS = _FLASH_SLOTS + _RAM_SLOTS + _ROM_SLOTS
_FLASH_BYTES = 1 << 20  # of the interpreter
_OBJECTS, _FUNCTION = (0, 1), 2
_END_OF_CODE = "__bss_start__"  # of the interpreter's own, in RAM
IN_RAM, ROM, UNNAMED = "machine code in RAM", "ROM", "flash without a name"

# Parts of the interpreter by the names of their functions: the first that fits.
PARTS = (
    ("division", r"div(mod)?_[su]|_.?l?div|u?l?idiv|floor_divide|small_int_modulo|udivmod|_[su]divsi|_[su]modsi"),
    ("collector", r"^gc_|^m_(malloc|free|realloc|del)|mutex"),
    ("bytecode", r"mp_execute_bytecode|decode_uint"),
    ("lookup", r"map_lookup|_(load|store)_(name|global|attr|method|build|super)|instance_|lookup|_attr$|qstr|dict|locals|globals"
               r"|member|mp_obj_get_type|is_subclass"),
    ("calls", r"call|code_state|prepare_args|fun_|get_int|int_get|get_buffer|native|convert_obj|nlr|closure|bound_meth|mp_arg"
              r"|new_int|is_true|cstack|mp_get_index"),
    ("operators", r"binary_|unary_|subscr|equal|_(int|list|array|bytes|tuple|len)_|array_|list_|byte|str_|iter|seq_|mpz|mul|len"),
    ("interrupts", r"irq|alarm|sched_|hardware_timer|timer_hw|isr_|exception"),
)
OTHERS = "other C"
_PARTS = [(name, re.compile(pattern)) for name, pattern in PARTS]


@dataclass
class Cost:
    """Cycles of threads and of interrupt handlers, and those of them that waited for flash."""

    main: int = 0
    interrupts: int = 0
    main_waits: int = 0
    interrupts_waits: int = 0

    @property
    def cycles(self):
        """The cycles in main loop and interrupts."""
        return self.main + self.interrupts

    @property
    def waits(self):
        """The cycles, of these, that waited for the flash."""
        return self.main_waits + self.interrupts_waits

    def __iadd__(self, other):
        self.main += other.main
        self.interrupts += other.interrupts
        self.main_waits += other.main_waits
        self.interrupts_waits += other.interrupts_waits
        return self


class Profile:
    def __init__(self, pico):
        self._chip = pico.chip
        self._state, self._loop = pico.flash_cache.state, pico.native_loop
        if self._loop is None:
            raise Unavailable("a profile needs a C compiler")
        self._counts = [(ctypes.c_uint64 * (2 * _SLOTS))() for _ in range(2)]
        for index, counts in enumerate(self._counts):
            self._state.profile[index] = ctypes.addressof(counts)
        self._loop.spent = self._count_python

    def _count_python(self, pc, handler, cycles):
        """Count cycles of an instruction that rp2040py itself executed."""
        self._counts[handler][2 * _slot_of(pc)] += cycles

    def end(self):
        """Stop counting; returns a Spent."""
        self._state.profile[:] = [None, None]
        self._loop.spent = None
        return Spent(self._counts, bytes(self._chip.sram), bytes(self._chip.flash[:_FLASH_BYTES]))


def _slot_of(pc):
    """Return the index in core.c's counters of an address of code: flash first, then RAM, then ROM, a slot each 2 bytes."""
    if pc < _FLASH:
        return _FLASH_SLOTS + _RAM_SLOTS + pc // 2 % _ROM_SLOTS
    if pc < _RAM:
        return (pc & 0xFFFFFF) // 2 % _FLASH_SLOTS
    return _FLASH_SLOTS + (pc - _RAM) // 2 % _RAM_SLOTS


def _address_of(slot):
    """Return the address of code that a slot of core.c's counters stands for; the inverse of _slot_of()."""
    if slot < _FLASH_SLOTS:
        return _FLASH + 2 * slot
    if slot < _FLASH_SLOTS + _RAM_SLOTS:
        return _RAM + 2 * (slot - _FLASH_SLOTS)
    return 2 * (slot - _FLASH_SLOTS - _RAM_SLOTS)


class Spent:
    def __init__(self, counts, ram, flash):
        self._ram, self._flash = ram, flash
        cycles, waits = ([part[first::2] for part in counts] for first in (0, 1))
        self.places = {
            _address_of(slot): Cost(main, interrupts, waits[0][slot], waits[1][slot])
            for slot, (main, interrupts) in enumerate(zip(*cycles))
            if main or interrupts
        }

    def total(self):
        return _sum_costs(self.places.values())

    def functions(self, symbols):
        """Return [(name, Cost)], the dearest first."""
        found = defaultdict(Cost)
        for address, cost in self.places.items():
            found[symbols.name_of(address)] += cost
        return sorted(found.items(), key=lambda one: -one[1].cycles)

    def parts(self, symbols=None):
        """Return {part: Cost}; without symbols only by the memories in which code lies."""
        found = defaultdict(Cost)
        if symbols is None:
            for address, cost in self.places.items():
                found["flash" if _FLASH <= address < _RAM else "RAM" if address >= _RAM else "ROM"] += cost
            return dict(found)
        for name, cost in self.functions(symbols):
            found[part_of(name)] += cost
        return dict(found)

    def kernels(self, symbols):
        """Return [(name, calls, Cost)] of the machine code in RAM, the dearest first; calls are those of its first instruction."""
        kernels = Kernels(symbols, self._ram, self._flash)
        found, calls, first = defaultdict(Cost), {}, {}
        for address, cost in sorted(self.places.items()):
            if symbols.name_of(address) == IN_RAM:
                name = kernels.name_of(address)
                found[name] += cost
                if first.setdefault(name, address) == address:
                    calls[name] = (cost.cycles - cost.waits) // self._cycles_at(address)
        return sorted(((name or "?", calls[name], cost) for name, cost in found.items()), key=lambda one: -one[2].cycles)

    def _cycles_at(self, address):
        """Return the cycles of the instruction with which functions begin, a PUSH or another."""
        opcode = int.from_bytes(self._ram[address - _RAM : address - _RAM + 2], "little")
        return 1 + (opcode & 0xFF).bit_count() if opcode >> 9 == 0x5A else 1


def _sum_costs(costs):
    """Return the sum of an iterable of Costs."""
    total = Cost()
    for cost in costs:
        total += cost
    return total


def part_of(name):
    """Return the part of the interpreter to which a function of this name belongs."""
    if name in (IN_RAM, ROM, UNNAMED):
        return name
    for part, pattern in _PARTS:
        if pattern.search(name):
            return part
    return OTHERS


class Symbols:
    """Functions of an ELF file by address, and where its other objects are."""

    def __init__(self, functions, objects):
        self.objects = objects
        self._starts, self._ends, self._names = map(list, zip(*sorted(functions)))

    def name_of(self, address):
        """Return the name of the function at `address`, or of the region if the ELF file has none there."""
        index = bisect.bisect_right(self._starts, address) - 1
        if index >= 0 and address < self._ends[index]:
            return self._names[index]
        if address < 0x4000:
            return ROM
        if address < _RAM:
            return UNNAMED
        return IN_RAM if address >= self.objects.get(_END_OF_CODE, _RAM) else "interpreter in RAM, without a name"


def read_symbols(path):
    """Read the Symbols of a 32-bit little-endian ELF file. Raises Failure."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:6] != b"\x7fELF\x01\x01":
        raise Failure("{} is no 32-bit ELF file", path)
    offset, = struct.unpack_from("<I", data, 32)
    size, count = struct.unpack_from("<HH", data, 46)
    sections = [struct.unpack_from("<10I", data, offset + index * size) for index in range(count)]
    found, objects = [], {}
    for _, kind, _, _, start, length, link, _, _, each in sections:
        if kind != 2:  # SHT_SYMTAB
            continue
        names = sections[link][4]
        for at in range(start, start + length, each):
            name, value, extent, info = struct.unpack_from("<IIIB", data, at)
            text = data[names + name : data.index(0, names + name)].decode()
            if info & 15 in _OBJECTS:
                objects[text] = value
            elif info & 15 == _FUNCTION:
                found.append((value & ~1, extent, text))
    if not found:
        raise Failure("{} names no functions", path)
    found.sort()
    following = [start for start, *_ in found[1:]] + [found[-1][0]]
    # Functions in assembly have no length: they end where the next one begins.
    return Symbols([(start, start + extent if extent else end, text) for (start, extent, text), end in zip(found, following)], objects)
