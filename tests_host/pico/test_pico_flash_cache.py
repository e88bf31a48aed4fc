"""The emulated processor's flash cache and faults, in both of its makes: core.c, and rp2040py with the model in its reads.

Programs are a few machine words in flash or RAM, run until a breakpoint; flash and RAM are rp2040py's.
"""

from functools import lru_cache

import pytest
from emulated import uf2  # noqa: F401
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from host_tools.emulator import native
from host_tools.emulator.binary import Unavailable, load_emulator
from host_tools.emulator.flash_cache import FlashCache, NotThumb, Unaligned, Undefined
from host_tools.emulator.loop import Loop
from host_tools.emulator.pico import EmulatedPico

try:
    load_emulator()
except Unavailable as reason:
    pytest.skip(f"NOT TESTED: {reason}", allow_module_level=True)

from rp2040py.rp2040 import RP2040  # noqa: E402
from rp2040py.utils.logging import ConsoleLogger, LogLevel  # noqa: E402

MISS = 50
FLASH, RAM = 0x10000000, 0x20000000
UNCACHED, NOT_ALLOCATING, ALWAYS_FILLING = 0x13000000, 0x11000000, 0x12000000
SET_BYTES = 8192  # from a line to the next one of its set
NOP, BREAK = 0xBF00, 0xBE00
SECOND = 1e9


class Program:
    """`code` at an address, halfwords, with registers; the results are in `cycles`, `misses`, `registers`."""

    def __init__(self, make, code, at=FLASH + 0x100, miss=MISS, random=False, **registers):
        self.chip = RP2040()
        self.chip.logger = ConsoleLogger(LogLevel.ERROR)
        self.cache = FlashCache(self.chip, random)
        self.cache.miss_cycles = miss
        self.loop = make(self.chip, self.cache)
        self.chip.on_break = self._stop
        self.chip.clock.create_alarm(self._stop).schedule(SECOND)
        self.load(code, at, registers)

    def load(self, code, at, registers):
        memory, start = (self.chip.flash, FLASH) if at < RAM else (self.chip.sram, RAM)
        data = b"".join(word.to_bytes(2, "little") for word in [*code, BREAK])
        memory[at - start & 0xFFFFFF : (at - start & 0xFFFFFF) + len(data)] = data
        core = self.chip.core
        for name, value in registers.items():
            core.registers[int(name[1:])] = value
        core.pc, core.sp = at, RAM + 0x8000

    def _stop(self, *_):
        self.loop.ended = True

    def run(self):
        while True:  # rp2040py's loop also ends when some time has passed
            self.loop.run()
            if self.loop.ended:
                break
        assert self.chip.clock.nanos < SECOND, "no breakpoint was met"
        self.cycles = round(self.chip.clock.nanos / 8)
        self.misses, self.accesses = self.cache.misses, self.cache.accesses
        self.registers = list(self.chip.core.registers)
        return self


def compiled(chip, cache):
    return native.NativeLoop(chip, cache)


def watched(chip, cache):
    cache.watch_accesses()
    return Loop(chip)


MAKES = [watched, *([compiled] if native.load_library() else [])]


@pytest.fixture(params=MAKES, ids=lambda make: make.__name__)
def program(request):
    return lambda *arguments, **options: Program(request.param, *arguments, **options).run()


def test_there_is_a_compiler():
    if native.load_library() is None:
        pytest.skip("NOT TESTED: no C compiler, or PASSO_NATIVE=0")


def loop_of(body):
    """The body r0 times."""
    size = len(body) + 1
    return [*body, 0x3801, 0xD000 | 1 << 8 | -(size + 2) & 0xFF]  # subs r0, #1; bne


def test_a_loop_within_the_cache_misses_once(program):
    body = [NOP] * 98  # and two for the loop: 200 bytes are 25 lines, and one for the breakpoint
    runs = {count: program(loop_of(body), r0=count) for count in (1, 10)}
    assert runs[1].misses == runs[10].misses == 26
    assert runs[10].cycles - runs[1].cycles == 9 * (98 + 1 + 2)
    free = program(loop_of(body), r0=10, miss=0)
    assert (free.misses, runs[10].cycles - free.cycles) == (26, 26 * MISS)
    assert free.accesses == 10 * 100 + 1


READ = [0x6808]  # ldr r0, [r1]
STRIDES = [0x680A, 0x681A, 0x6822]  # ldr r2, [r1]; ldr r2, [r3]; ldr r2, [r4]
RAM_CODE = RAM + 0x100


def test_two_lines_of_a_set_stay_and_a_third_drives_out_the_one_used_longer_ago(program):
    places = {"r1": FLASH + 0x1000, "r3": FLASH + 0x1000 + SET_BYTES, "r4": FLASH + 0x1000 + 5 * SET_BYTES}
    both = program(loop_of(STRIDES[:2]), at=RAM_CODE, r0=10, **places)
    assert (both.accesses, both.misses) == (20, 2)
    thrashed = program(loop_of(STRIDES), at=RAM_CODE, r0=10, **places)
    assert (thrashed.accesses, thrashed.misses) == (30, 30)
    assert thrashed.cycles == program(loop_of(STRIDES), at=RAM_CODE, miss=0, r0=10, **places).cycles + 30 * MISS
    kept = program([STRIDES[at] for at in (0, 1, 0, 2, 0, 1)], at=RAM_CODE, **places)
    assert kept.misses == 4, "the first line was used last before the third came"


def test_random_replacement_keeps_some_of_three(program):
    places = {"r1": FLASH, "r3": FLASH + SET_BYTES, "r4": FLASH + 2 * SET_BYTES}
    run = program(loop_of(STRIDES), at=RAM_CODE, random=True, r0=200, **places)
    assert 200 < run.misses < 590


def test_neighbouring_words_and_bytes_share_a_line_of_eight_bytes(program):
    reads = [0x6808, 0x6848, 0x7AC8, 0x8988]  # ldr 0 and 4, ldrb 11, ldrh 12
    assert program(reads, at=RAM_CODE, r1=FLASH + 0x40).misses == 2
    assert program([0xC93C], at=RAM_CODE, r1=FLASH + 0x44).misses == 3, "ldmia of four words from the middle of a line"


@pytest.mark.parametrize("alias, misses, later", [(FLASH, 1, 0), (NOT_ALLOCATING, 3, 1), (ALWAYS_FILLING, 3, 0),
                                                   (UNCACHED, 3, 1)])
def test_the_other_addresses_of_flash(program, alias, misses, later):
    """`later`: whether the plain address then misses."""
    run = program(READ * 3, at=RAM_CODE, r1=alias + 0x80)
    assert run.misses == misses
    assert program([*READ * 3, 0x6810], at=RAM_CODE, r1=alias + 0x80, r2=FLASH + 0x80).misses == misses + later


def test_code_runs_from_an_uncached_address_and_pays_for_each_fetch(program):
    run = program([NOP] * 10, at=UNCACHED + 0x100)
    assert run.misses == run.accesses == 11


def test_memory_and_registers_of_the_chip_cost_nothing(program):
    code = [0x6808, 0x6050, 0xB402, 0xBC08, 0x6820]  # ldr, str, push, pop in RAM; ldr of a peripheral
    options = {"at": RAM_CODE, "r1": RAM + 0x40, "r2": RAM + 0x80, "r4": 0x40054028}
    run = program(code, **options)
    assert (run.accesses, run.cycles) == (0, program(code, miss=0, **options).cycles)


XIP_CTRL = 0x14000000


def test_a_flush_empties_the_cache_and_the_counters_count(program):
    options = {"at": RAM_CODE, "r1": FLASH + 0x80, "r2": XIP_CTRL, "r3": 1}
    flushed = program([*READ, *READ, 0x6053, *READ], **options)  # str r3, [r2, #4]
    assert flushed.misses == 2
    counted = program([*READ * 5, 0x6914, 0x68D5], **options)  # ldr r4, [r2, #16]; ldr r5, [r2, #12]
    assert counted.registers[4:6] == [5, 4]
    cleared = program([*READ * 5, 0x6113, *READ, 0x6914, 0x68D5], **options)
    assert cleared.registers[4:6] == [1, 5], "the accesses were cleared, the hits not"
    disabled = program([*READ, 0x6015, *READ * 3], r5=2, **options)  # str r5, [r2]
    assert disabled.misses == 4


@pytest.mark.parametrize("code, offset", [
    (0x6808, 2), (0x6808, 1), (0x8808, 1), (0x6008, 2), (0x8008, 3), (0xC90C, 2), (0xC10C, 1), (0x5A88, 1),
], ids=lambda value: f"{value:#x}")
def test_an_unaligned_access_is_a_fault_that_names_it(program, code, offset):
    for memory in (RAM + 0x200, FLASH + 0x200, 0x40054000, 0xD0000060):
        with pytest.raises(Unaligned, match=f"{memory + offset:#010x} at pc 0x20000102") as fault:
            program([NOP, code], at=RAM_CODE, r1=memory + offset, r2=0)
        assert (fault.value.pc, fault.value.address) == (RAM_CODE + 2, memory + offset)


def test_bytes_have_no_alignment(program):
    assert program([0x7808, 0x7048], at=RAM_CODE, r1=RAM + 0x201).registers[15] > RAM_CODE


@pytest.mark.skipif(compiled not in MAKES, reason="only core.c tells")
@pytest.mark.parametrize("code", [[0x4708], [0x4788], [0xB402, 0xBD00]], ids=["bx", "blx", "pop"])
def test_a_branch_to_an_even_address_is_a_fault(code):
    with pytest.raises(NotThumb, match="0x20000200"):
        Program(compiled, code, at=RAM_CODE, r1=RAM + 0x200).run()


@pytest.mark.skipif(compiled not in MAKES, reason="only core.c tells")
@pytest.mark.parametrize("code", [0xFFFF, 0xF800, 0xE800])
def test_erased_flash_is_a_fault(code):
    with pytest.raises(Undefined, match="undefined instruction at 0x20000102"):
        Program(compiled, [NOP, code], at=RAM_CODE).run()


# --- core.c against rp2040py

VALUES = st.one_of(st.integers(0, 2**32 - 1), st.sampled_from([0, 1, 31, 32, 33, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF]))
PLAIN = [*range(0x00, 0x44), 0x44, 0x45, 0x46, *range(0xA0, 0xB1), 0xB2, 0xBA]  # registers only
STORES = [*range(0x50, 0xA0), 0xB4, 0xBC, *range(0xC0, 0xD0)]


@lru_cache
def reused(make):
    return Program(make, [], at=RAM_CODE, miss=0)


def both(code, registers, flags):
    """Return the results of rp2040py and core.c for a program. If they differ, core.c is the Cortex-M0+:

    - ADCS and SBCS: rp2040py adds the carry to an operand first, and may lose V;
    - a shift by a register that holds 0 leaves C as it is, and LSLS by more than 32 clears it.
    """
    found = []
    for make in (rp2040py_alone, compiled):
        one = reused(make)
        one.load(code, RAM_CODE, {f"r{place}": 0 for place in range(15)} | registers)
        one.chip.core.apsr = flags << 28
        one.chip.sram[0x4000:0x9000] = bytes(range(256)) * 80
        begun = one.chip.clock.nanos
        one.run()
        spent = one.chip.clock.nanos - begun
        found.append((one.registers, one.chip.core.apsr, spent, bytes(one.chip.sram[0x4000:0x9000])))
    return found


def rp2040py_alone(chip, cache):
    return Loop(chip)


@pytest.mark.skipif(compiled not in MAKES, reason="there is no core.c")
@settings(max_examples=400, deadline=None)
@given(st.sampled_from(PLAIN), st.integers(0, 255), st.lists(VALUES, min_size=8, max_size=8), st.integers(0, 15))
def test_instructions_do_what_rp2040py_says(high, low, values, flags):
    opcode = high << 8 | low
    d, m = values[low & 7], values[low >> 3 & 7]
    assume(not (0x44 <= high <= 0x46 and ((low >> 3 & 15) in (13, 15) or (low >> 4 & 8 | low & 7) in (13, 15))))
    assume(not (high in (0x40, 0x41, 0x42) and opcode >> 6 in (0x102, 0x103, 0x104, 0x107) and m & 0xFF == 0))
    assume(opcode >> 6 != 0x102 or m & 0xFF <= 32)
    assume(high != 0xBA or low >> 6 != 2)
    reference, ours = both([opcode], {f"r{place}": value for place, value in enumerate(values)}, flags)
    if opcode >> 6 in (0x105, 0x106) and 0x7FFFFFFF in (d, m):  # ADCS, SBCS: but for V
        reference, ours = [(one[0], one[1] & 0xE0000000, *one[2:]) for one in (reference, ours)]
    assert ours == reference


@pytest.mark.skipif(compiled not in MAKES, reason="there is no core.c")
@settings(max_examples=400, deadline=None)
@given(st.sampled_from(STORES), st.integers(0, 255), st.lists(st.integers(0, 63), min_size=8, max_size=8))
def test_reads_and_writes_of_memory_do_what_rp2040py_says(high, low, places):
    opcode = high << 8 | low
    assume(low or high not in (0xB4, 0xBC, *range(0xC0, 0xD0)))
    offset = 0x50 <= high < 0x60 and opcode >> 6 & 7
    values = [4 * place if place_of == offset and offset is not False else RAM + 0x4000 + 4 * place
              for place_of, place in enumerate(places)]
    if 0x50 <= high < 0x60:
        assume(offset != low >> 3 & 7)
    registers = {f"r{place}": value for place, value in enumerate(values)}
    try:
        reference, ours = both([opcode], registers, 0)
    except Unaligned:  # of an offset that is no multiple
        assume(False)
    assert ours == reference


BRANCHES = [*range(0xD000, 0xDE00, 0x100)]


@pytest.mark.skipif(compiled not in MAKES, reason="there is no core.c")
@pytest.mark.parametrize("flags", range(16))
def test_branches_do_what_rp2040py_says(flags):
    for branch in BRANCHES:
        code = [branch | 1, 0x2001, NOP, 0xF000, 0xF801, BREAK, 0x2102]  # over one; a call over the breakpoint
        reference, ours = both(code, {"r0": 0, "r1": 0}, flags)
        assert ours == reference and ours[0][1] == 2


BUSY = """
import gc, time
from machine import Timer
ticks = 0
def tick(timer):
    global ticks
    ticks += 1
timer = Timer(freq=500, callback=tick, hard=True)
def work(count):
    total = 0
    for i in range(count):
        total += i * 0x12345 // 7 - len(str(i / 3))
        kept = [i] * 10
    gc.collect()
    return total
print(work(40), ticks)
"""


@pytest.mark.parametrize("miss", (0, MISS))
def test_micropython_takes_the_same_cycles_in_both_makes(uf2, miss, monkeypatch):
    found = []
    for make in (None, native.load_library()):
        monkeypatch.setattr(native, "load_library", lambda: make)
        pico = EmulatedPico(files={}, uf2=uf2, flash_miss=miss).boot()
        said = pico.exec(BUSY)
        found.append((said, pico.cycle, pico.flash_cache.misses if miss else 0))
    assert found[0] == found[1]
    assert int(found[0][0].split()[1]) > 1
