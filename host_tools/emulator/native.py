"""Runs an emulated Pico with core.c beside rp2040py's processor, if there is a C compiler.

    loop = NativeLoop(chip, cache)      # of `flash_cache.FlashCache`
    loop.run()                          # until loop.ended is set

core.c executes most instructions, about twenty-five times as fast as rp2040py. Peripherals, exceptions and sleep are left to
rp2040py, on the same registers and memories, at the same cycles. core.c is compiled once, into ~/.cache/passo.
Without a compiler, or with PASSO_NATIVE=0, `loop.Loop` does the same at rp2040py's pace.

An access that is not aligned raises Unaligned, a branch to an even address NotThumb, and erased flash Undefined, where silicon has a HardFault.
"""

import ctypes
import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from functools import lru_cache
from pathlib import Path

from host_tools.emulator import system_clock
from host_tools.emulator.binary import CACHE
from host_tools.emulator.flash_cache import Core, NotThumb, Unaligned, Undefined

_SOURCE = Path(__file__).with_name("core.c")
_OPTIONS = ("-O2", "-std=gnu11", "-fno-strict-aliasing", "-shared", "-fPIC")
_EARLY_NS = 1e-3  # rounding of a float at the end of a cycle
_NOT_MINE, _UNALIGNED, _NOT_THUMB, _UNDEFINED = 1, 2, 3, 4


@lru_cache(maxsize=1)
def load_library():
    """Return core.c as a library, compiled on the first call; None if there is no C compiler."""
    if os.environ.get("PASSO_NATIVE") == "0" or sys.byteorder != "little":
        return None
    source = _SOURCE.read_bytes() + repr((_OPTIONS, platform.machine())).encode()
    path = CACHE / f"core-{hashlib.sha256(source).hexdigest()[:16]}.so"
    try:
        if not path.exists():
            _compile_core(path)
        found = ctypes.CDLL(str(path))
    except (OSError, subprocess.CalledProcessError):
        return None
    found.core_run.argtypes = (ctypes.c_void_p, ctypes.c_int64, ctypes.c_uint32)
    found.core_run.restype = ctypes.c_uint32
    assert found.core_size() == ctypes.sizeof(Core)
    return found


def _compile_core(path):
    """Compile core.c to the library `path`, which appears only when whole. Raises FileNotFoundError without a compiler, CalledProcessError if it
    fails."""
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if not compiler:
        raise FileNotFoundError("no C compiler")
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        made = Path(folder) / path.name
        command = [*compiler.split(), *_OPTIONS, "-o", str(made), str(_SOURCE)]
        subprocess.run(command, check=True, capture_output=True)
        made.replace(path)


def _address_of(buffer):
    """Return the address of a buffer's bytes, which stay there as long as the chip lives."""
    return ctypes.addressof(ctypes.c_char.from_buffer(buffer))


class NativeLoop:
    def __init__(self, chip, cache):
        self._chip = chip
        self.clock = chip.clock
        self._system = system_clock.clock_of(chip)
        self.ended = False
        self.spent = None  # called with (pc, whether in an interrupt, cycles) of each instruction of rp2040py
        state = self._state = cache.state
        state.r, state.ram = _address_of(chip.core.registers), _address_of(chip.sram)
        state.flash, state.rom = _address_of(chip.flash), _address_of(chip.bootrom)
        self._pointer = ctypes.addressof(state)
        self._run = load_library().core_run
        reset = chip.sio.reset

        def restart():
            reset()
            ctypes.memset(state.sio, 0, ctypes.sizeof(state.sio))

        chip.sio.reset = restart

    def run(self):
        """Run until `ended` is set or the RUN pin is low: core.c up to the next alarm or an instruction it leaves to Python. Raises Unaligned,
        NotThumb, Undefined, or the clock's fault."""
        chip, core, clock, state, pointer, run = (
            self._chip, self._chip.core, self.clock, self._state, self._pointer, self._run
        )
        system, timer = self._system, chip.timer
        self.ended = False
        if chip.run_pin_low:
            return
        while not self.ended:
            if core.waiting:
                clock.tick(clock.nanos_to_next_alarm)
                if not core.waiting:
                    system.align()
                continue
            cycle_ns = system.cycle_ns
            budget = -((_EARLY_NS - clock.nanos_to_next_alarm) // cycle_ns)
            if core.interrupts_updated:
                if core.check_for_interrupts():
                    core.waiting = False
                if core.interrupts_updated:
                    budget = 1  # rp2040py looks again after the first instruction of the handler
            masked = core.pm
            state.timer_ns, state.cycle_ns = clock.nanos - timer._epoch_nanos, cycle_ns
            said = run(pointer, int(budget), core.apsr | core.ipsr << 8 | core.current_mode << 1 | masked)
            core.apsr = said
            if said & 1 != masked:
                core.pm = said & 1
            if state.event:
                core.event_registered, state.event = True, 0
            spent = state.cycles
            if spent:
                clock.tick(spent * cycle_ns)
            why = said >> 2 & 7
            if why:
                if why == _NOT_MINE:
                    if not core.interrupts_updated and not self.ended:
                        pc, handler = core.pc, core.ipsr != 0
                        spent = core.execute_instruction()
                        clock.tick(spent * cycle_ns)
                        if system.fault:
                            raise system.fault
                        if self.spent:
                            self.spent(pc, handler, spent)
                elif why == _UNALIGNED:
                    raise Unaligned(core.pc, state.fault)
                else:
                    raise (NotThumb if why == _NOT_THUMB else Undefined)(core.pc, state.fault)
