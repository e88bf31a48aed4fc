"""The system clock that a board file asks for, and the core voltage that it wants.

    clock.hurry()           # while the firmware is loaded
    clock.set_mhz(200)      # before players, PWM and serial lines are made; RuntimeError if the chip does not follow

Above 133 MHz an RP2040 wants a core voltage of 1.15 V: first the voltage, then the clock. MicroPython's machine.freq() also
divides the flash's clock so that it stays within 62.5 MHz, and leaves UARTs and USB on the 48 MHz of the other PLL; timers
and watchdog count the crystal's microseconds. That it has said yes is not enough: the chip's own frequency counter has
to find the clock.
"""

from time import sleep_us

import machine
from machine import mem32
from micropython import const

from passo.ports.rp2 import chip

_FASTEST_MHZ = const(200)  # of an RP2040, by its data sheet
_PLAIN_MHZ = const(133)  # to here the voltage after a reset, 1.10 V, is enough
_RAISED = const(0b1100)  # VSEL: 1.15 V
_VSEL = const(0xF0)
_IN_REGULATION = const(1 << 12)
_TRIES = const(100)
_LOOK_US = const(100)
_SETTLE_US = const(1000)  # as the pico-sdk waits
_CRYSTAL_KHZ = const(12_000)
_CLK_SYS = const(9)
_INTERVAL = const(10)  # a millisecond's count, within 2 kHz
_DONE = const(1 << 4)
_OFF_KHZ = const(50)


def hurry():
    """Run an RP2040 at 200 MHz until the board file's clock is set: loading takes 1.4 s less. If it does not follow, it stays
    at what it was."""
    if not chip.RP2350:
        try:
            set_mhz(_FASTEST_MHZ)
        except RuntimeError:
            pass  # loading is slower; set_mhz() raises again if the board file's clock needs it


def set_mhz(mhz):
    """Also after a soft reset, which leaves clock and voltage as they were. The voltage is never lowered."""
    if mhz > _PLAIN_MHZ and not chip.RP2350:
        _raise_voltage()
    if machine.freq() != mhz * 1_000_000:
        try:
            machine.freq(mhz * 1_000_000)
        except ValueError:
            pass  # the check below raises with the clock that there is
    said = machine.freq()
    found = measure_khz()
    if found < 0:
        raise RuntimeError("clock_mhz: the chip's frequency counter does not answer")
    if said != mhz * 1_000_000 or abs(found - mhz * 1000) > _OFF_KHZ:
        raise RuntimeError("clock_mhz: the clock is %d kHz, not %d MHz" % (found, mhz))


def _raise_voltage():
    """Raise the core voltage to 1.15 V and wait until the regulator is steady. Raises RuntimeError if it is not after _TRIES looks."""
    before = mem32[chip.REGULATOR]
    if before & _VSEL < _RAISED << 4:
        mem32[chip.REGULATOR] = before & ~_VSEL | _RAISED << 4
        sleep_us(_SETTLE_US)
    for _ in range(_TRIES):
        found = mem32[chip.REGULATOR]
        if found & _VSEL >= _RAISED << 4 and found & _IN_REGULATION:
            return
        sleep_us(_LOOK_US)
    raise RuntimeError("clock_mhz: the core voltage does not rise to 1.15 V")


def measure_khz():
    """Return the system clock in kHz by the chip's frequency counter, against the crystal (RP2040 datasheet, 2.15, "Frequency Counter"). -1 if it
    does not answer."""
    at = chip.COUNTER
    for offset, value in ((0, _CRYSTAL_KHZ), (4, 0), (8, 0x1FFFFFF), (16, _INTERVAL), (20, _CLK_SYS)):
        mem32[at + offset] = value  # the last one sets it going
    for _ in range(_TRIES):
        sleep_us(_LOOK_US)
        if mem32[at + 24] & _DONE:
            return mem32[at + 28] >> 5
    return -1
