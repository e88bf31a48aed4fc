"""The profile of the emulated processor: every cycle is counted once, and names come from the ELF file."""

import struct

import pytest
from emulated import uf2  # noqa: F401

from host_tools.bench import where
from host_tools.emulator import native
from host_tools.emulator.binary import Unavailable
from host_tools.emulator.load import Load
from host_tools.emulator.pico import EmulatedPico
from host_tools.emulator.profile import IN_RAM, OTHERS, ROM, UNNAMED, Profile, part_of, read_symbols
from host_tools.failure import Failure

BUSY = """
from machine import Timer
import micropython
@micropython.viper
def kernel(count: int) -> int:
    total = 0
    while count:
        total ^= count
        count -= 1
    return total
def tick(timer):
    kernel(300)
timer = Timer(freq=2000, callback=tick, hard=True)
while True:
    kernel(100)
"""
MISS, RUN_US = 50, 20_000


@pytest.mark.skipif(native.load_library() is None, reason="NOT TESTED: a profile needs a C compiler")
def test_every_cycle_is_counted_once(uf2):
    pico = EmulatedPico(files={}, uf2=uf2, flash_miss=MISS).boot()
    pico.console.start(BUSY)
    pico.run(500_000)
    begun, missed = pico.cycle, pico.flash_cache.misses
    load, profile = Load(pico), Profile(pico)
    pico.run(RUN_US)
    spent, shares = profile.end(), load.end()
    elapsed, total = pico.cycle - begun, spent.total()
    assert abs(total.cycles - elapsed) < 20
    assert abs(total.waits - MISS * (pico.flash_cache.misses - missed)) <= MISS
    assert total.interrupts / total.cycles == pytest.approx(1 - shares["main"], abs=0.02)
    memories = spent.parts()
    assert set(memories) <= {"flash", "RAM", "ROM"} and memories["RAM"].cycles > 0.3 * total.cycles
    assert memories["RAM"].interrupts > 40 * 300 * 5, "forty ticks of three hundred turns"
    pico.run(RUN_US)
    assert spent.total() == total, "it has ended"


KERNELS = """
import micropython
@micropython.viper
def counted(count: int) -> int:
    total = 0
    while count:
        total ^= count
        count -= 1
    return total
@micropython.asm_thumb
def assembled(r0):
    add(r0, 1)
class Thing:
    @micropython.native
    def method(self):
        return counted(5)
thing = Thing()
def work():
    for _ in range(30):
        thing.method()
        for _ in range(3):
            assembled(1)
"""


@pytest.mark.skipif(native.load_library() is None, reason="NOT TESTED: a profile needs a C compiler")
def test_kernels_are_named_and_their_calls_counted(uf2):
    try:
        names = where.load_symbols()
    except Unavailable as reason:
        pytest.skip(f"NOT TESTED: {reason}")
    pico = EmulatedPico(files={}, uf2=uf2).boot()
    pico.exec(KERNELS)
    profile = Profile(pico)
    pico.exec("work()")
    spent = profile.end()
    found = {name: (calls, cost.cycles) for name, calls, cost in spent.kernels(names)}
    assert {name: calls for name, (calls, _) in found.items()} == {
        "__main__.counted": 30, "__main__.method": 30, "assembled": 90,
    }  # fmt: skip
    assert sum(cycles for _, cycles in found.values()) == spent.parts(names)[IN_RAM].cycles
    assert found["__main__.counted"][1] > 30 * 5 * 4


def elf(functions):
    """A file with nothing but symbols."""
    names, table = b"\0", struct.pack("<IIIBBH", 0, 0, 0, 0, 0, 0)
    for name, address, length in functions:
        table += struct.pack("<IIIBBH", len(names), address, length, 2, 0, 1)
        names += name.encode() + b"\0"
    head = b"\x7fELF\x01\x01".ljust(16, b"\0") + struct.pack("<HHIIIIIHHHHHH", 2, 40, 1, 0, 0, 52, 0, 52, 0, 0, 40, 3, 0)
    at = 52 + 3 * 40
    sections = struct.pack("<10I", *(0,) * 10)
    sections += struct.pack("<10I", 0, 2, 0, 0, at, len(table), 2, 0, 4, 16)
    sections += struct.pack("<10I", 0, 3, 0, 0, at + len(table), len(names), 0, 0, 1, 0)
    return head + sections + table + names


def test_names_come_from_the_elf_file(tmp_path):
    path = tmp_path / "firmware.elf"
    path.write_bytes(elf([("late", 0x10000401, 8), ("in_assembly", 0x10000301, 0), ("fast", 0x20000101, 32),
                          ("early", 0x10000201, 16)]))
    symbols = read_symbols(path)
    named = {0x10000200: "early", 0x1000020E: "early", 0x10000210: UNNAMED, 0x10000300: "in_assembly",
             0x100003FE: "in_assembly", 0x10000406: "late", 0x10000408: UNNAMED, 0x2000011E: "fast", 0x20000120: IN_RAM,
             0x2003FFFE: IN_RAM, 0x1234: ROM}  # fmt: skip
    assert {address: symbols.name_of(address) for address in named} == named
    for wrong in (b"", b"\x7fELF\x02\x01" + bytes(60), elf([])):
        path.write_bytes(wrong)
        with pytest.raises(Failure):
            read_symbols(path)


@pytest.mark.parametrize("part, names", [
    ("lookup", "mp_map_lookup mp_obj_instance_attr find_qstr qstr_hash mp_load_method_maybe mp_load_attr mp_store_attr"
               " mp_load_global mp_obj_class_lookup module_attr"),
    ("calls", "mp_setup_code_state_helper mp_native_from_obj array_get_buffer mp_call_function_n_kw fun_viper_call nlr_push"
              " convert_obj_for_inline_asm mp_arg_check_num_sig mp_obj_is_true mp_cstack_check"),
    ("division", "divmod_s32s32_unsafe mp_small_int_floor_divide __wrap___aeabi_idiv divmod_u32u32 mp_small_int_modulo"),
    ("bytecode", "mp_execute_bytecode"),
    ("collector", "gc_alloc gc_collect_start gc_sweep_run_finalisers m_malloc"),
    ("operators", "mp_binary_op array_subscr mp_obj_equal_not_equal list_subscr"),
    ("interrupts", "alarm_pool_irq_handler mp_irq_dispatch mp_sched_unlock"),
    (OTHERS, "memcmp __gnu_thumb1_case_shi time_ticks_ms"),
    (IN_RAM, IN_RAM),
])  # fmt: skip
def test_functions_belong_to_parts_of_the_interpreter(part, names):
    for name in [names] if part == IN_RAM else names.split():
        assert part_of(name) == part, name
