"""Addresses that differ between the RP2040 and the RP2350, and register writes at start-up. Datasheets: 2.19.6 (GPIO),
3.7 (PIO), 2.5.7 (DMA), 2.4.8 (NVIC, SysTick), 4.5.3 (PWM), 2.10 (regulator), 2.15 (frequency counter) of the RP2040's; 9.11, 11.7,
12.6.10, 3.7, 12.5.3, 8.1 of the RP2350's.

All as in the headers of the pico-sdk, src/{rp2040,rp2350}/hardware_regs/include/hardware/regs: addressmap.h, clocks.h,
dma.h, dreq.h, intctrl.h, io_bank0.h, pio.h, pwm.h, sio.h, vreg_and_chip_reset.h, watchdog.h. By these the same on both:
PIO blocks, their registers and their requests to DMA; the registers of DMA channels and PWM slices; GPIO_IN and GPIO_OUT;
TIMER_IRQ_3.
"""

import sys

import machine
from machine import Pin, mem32

from passo.ports.rp2.registers import ALIAS_CLEAR
from passo.records import TICKS_PER_S

RP2350 = "RP2350" in sys.implementation._machine
IO_BANK0 = 0x40028000 if RP2350 else 0x40014000
PWM = 0x400A8000 if RP2350 else 0x40050000
UART0 = 0x40070000 if RP2350 else 0x40034000  # its data register
UART1 = 0x40078000 if RP2350 else 0x40038000
UART0_REQUEST = 29 if RP2350 else 21  # to DMA, of a byte that has come; UART1's is two more
_WATCHDOG_LOAD = 4
WATCHDOG = 0x400D8000 if RP2350 else 0x40058000
ABORT = 0x50000464 if RP2350 else 0x50000444  # DMA's CHAN_ABORT
TOGGLE = 0xD0000028 if RP2350 else 0xD000001C  # SIO's GPIO_OUT_XOR
REGULATOR = 0x40064000  # VREG; the RP2350's own voltage is enough for all that is asked of it
COUNTER = 0x4001008C if RP2350 else 0x40008080  # the frequency counter's first register, FC0_REF_KHZ
BUSY = 1 << (26 if RP2350 else 24)  # of a DMA channel's control register
_OUT_OVER = 12 if RP2350 else 8
_IN_OVER = 16
_INVERT = 1
_LOW = 2
_NVIC_PRIORITY = 0xE000E400
_SYSTICK = 0xE000E010
_TIMER_IRQ_3 = 3  # the interrupt of machine.Timer

# SysTick counts the processor's cycles down, modulo 2²⁴. No function: one name more and a plotter's table of names would double.
mem32[_SYSTICK + 4] = 0xFFFFFF
mem32[_SYSTICK] = 5


def cycles_per_tick():
    """System clocks of one tick. Raises ValueError where the clock is no multiple of the tick's."""
    clock = machine.freq()
    if clock % TICKS_PER_S or not 6 <= clock // TICKS_PER_S <= 32:
        raise ValueError("the system clock must be a multiple of 12.5 MHz up to 400 MHz, not %d Hz" % clock)
    return clock // TICKS_PER_S


def give_to_pio(pin, invert):
    """Connect `pin` to PIO block 0, its output inverted if asked, in one write: it sees no level in between."""
    Pin(pin, Pin.IN)
    mem32[IO_BANK0 + 8 * pin + 4] = 6 | (_INVERT << _OUT_OVER if invert else 0)


def mute(pin):
    """Hold an output low from here on, whatever drives it."""
    mem32[IO_BANK0 + 8 * pin + 4] = mem32[IO_BANK0 + 8 * pin + 4] & ~(3 << _OUT_OVER) | _LOW << _OUT_OVER


def invert_input(pin):
    """Let everything on the chip but its edge interrupts see the opposite of the pin."""
    mem32[IO_BANK0 + 8 * pin + 4] = mem32[IO_BANK0 + 8 * pin + 4] | _INVERT << _IN_OVER


def yield_timers():
    """Timer interrupts give way to all others: to halting pins, to the serial ports, to USB."""
    mem32[_NVIC_PRIORITY + (_TIMER_IRQ_3 & ~3)] = mem32[_NVIC_PRIORITY + (_TIMER_IRQ_3 & ~3)] & 0xFFFFFF | 0xC0 << 24


def long_watchdog():
    """The watchdog waits as long as it can, 8.3 s and on an RP2350 16.7, until it is fed."""
    mem32[WATCHDOG + _WATCHDOG_LOAD] = 0xFFFFFF


def stop_watchdog():
    mem32[WATCHDOG + ALIAS_CLEAR] = 1 << 30
