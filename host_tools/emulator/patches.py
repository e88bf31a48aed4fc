"""Corrects rp2040py 0.3.6 where it differs from the chip; one function for each fault.

    apply_patches(chip, leave_out=("uart",))

Each takes the emulated chip. The larger ones have a module of their own, which also says what is wrong: `uart`, `pio`,
`system_clock`; the pads and the USB port belong to `pico.EmulatedPico`, with switches of the same kind.

The flash cache and the faults of accesses that are not aligned are in `flash_cache`. Not modelled, here or there: the time
of exception entry and exit, bus contention, the second core, and the two-cycle synchroniser of inputs. Timings are therefore a lower
bound. How long flash takes to erase and to program is in `flash_times`.
"""

from host_tools.emulator import pio as pio_patch
from host_tools.emulator import system_clock as clock_patch
from host_tools.emulator.uart import Pl011

_PACING_REGISTERS = {0x3B: "_timer0", 0x3C: "_timer1", 0x3D: "_timer2", 0x3E: "_timer3"}
_DMA_WRITE_ONLY = (0x430, 0x440, 0x444)  # MULTI_CHAN_TRIGGER, FIFO_LEVELS, CHAN_ABORT
_PWM_DREQ = 24


def system_clock(chip):
    """See the module `system_clock`."""
    clock_patch.clock_of(chip).install()


def uart(chip):
    """See the module `uart`."""
    for index, base in enumerate((0x40034, 0x40038)):
        chip.uart[index] = chip.peripherals[base] = Pl011(chip.uart[index])


def pio(chip):
    """See the module `pio`."""
    pio_patch.install(chip)


def dma_pacing(chip):
    """Make X/Y transfers a cycle by a pacing timer; rp2040py has the fraction upside down, and the fourth timer worse."""
    dma = chip.dma

    def microseconds(request):
        value = getattr(dma, _PACING_REGISTERS.get(request, ""), 0)
        x, y = value >> 16, value & 0xFFFF
        return y / x * 1e6 / chip.clk_sys if x and y else 0

    dma.get_timer = microseconds


def dma_write_only(chip):
    """Read write-only registers as 0, so that setting one bit of CHAN_ABORT aborts one channel, not all of them."""
    stock = chip.dma.read_uint32
    chip.dma.read_uint32 = lambda offset: 0 if offset in _DMA_WRITE_ONLY else stock(offset)


def pwm_request(chip):
    """Ask DMA for one transfer at each wrap of a PWM slice; in rp2040py the request stays on after the first."""
    pwm = chip.pwm

    def wrap(index):
        """Raise interrupt and DMA request of PWM slice `index`, whose counter has wrapped; the request lasts one transfer."""
        pwm._int_raw |= 1 << index
        pwm.check_interrupts()
        chip.dma.set_dreq(_PWM_DREQ + index)
        chip.dma.clear_dreq(_PWM_DREQ + index)

    pwm.channel_interrupt = wrap


def timer_alarms(chip):
    """Fire a timer alarm as the count reaches it; rp2040py rounds the wait down, and is up to 1 µs early."""
    timer = chip.timer
    stock = timer.write_uint32

    def write(offset, value):
        """Write a timer register; an alarm (offset 0x10 to 0x1C) is set to its µs exactly, fractions of the present µs included."""
        stock(offset, value)
        if 0x10 <= offset <= 0x1C:
            micros = timer._micros()
            whole = int(micros)
            wait = (value - whole & 0xFFFFFFFF) - (micros - whole)
            timer.alarms[offset - 0x10 >> 2].clock_alarm.schedule(max(0.0, wait * 1000))

    timer.write_uint32 = write


ALL = (system_clock, uart, pio, dma_pacing, dma_write_only, pwm_request, timer_alarms)


def apply_patches(chip, leave_out=()):
    for patch in ALL:
        if patch.__name__ not in leave_out:
            patch(chip)
