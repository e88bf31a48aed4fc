"""Interrupts that the chip itself hands to machine code: MicroPython's way to a handler leads through flash, and behind USB.

    entry = enter(PIO_IRQ_1, kernel, state)     # kernel(state) is called in the interrupt, before all others
    leave(PIO_IRQ_1)                            # before MicroPython starts anew

The kernel works with arrays and registers only: no attributes, no calls of objects. Datasheets: 2.3.2 (interrupts) of
the RP2040's, 3.2 of the RP2350's; Armv6-M's and Armv8-M's manuals have NVIC and VTOR.
"""

from array import array

import uctypes
from machine import mem32

from passo.ports.rp2.chip import RP2350

PIO_IRQ_1 = 16 if RP2350 else 8  # the second one of PIO block 0; MicroPython has the first one
IRQ1_INTE = 0x17C if RP2350 else 0x138  # register of a PIO block: the causes of its second interrupt
_ENABLE = 0xE000E100
_DISABLE = 0xE000E180
_PRIORITY = 0xE000E400
_VTOR = 0xE000ED08  # the vectors lie in memory


def enter(irq, kernel, argument):
    """Have the chip call kernel(argument) in an interrupt. Returns an array: keep it as long as the interrupt may come."""
    entry = array("I", (
        0x4B054804,  # ldr r0, the kernel, which MicroPython gives to machine code; ldr r3, its arguments
        0x220168C1,  # ldr r1, [r0, #12], its code; movs r2, #1
        0x468C4311,  # orrs r1, r2: it is Thumb; mov r12, r1
        0x22002101,  # movs r1, #1: one argument; movs r2, #0: none has a name
        0xBF004760,  # bx r12; nop
        id(kernel), 0, id(argument),
    ))  # fmt: skip
    at = uctypes.addressof(entry)
    entry[6] = at + 28  # the address of the argument
    mem32[mem32[_VTOR] + 4 * (16 + irq)] = at | 1
    four = _PRIORITY + (irq & ~3)
    mem32[four] = mem32[four] & ~(0xFF << 8 * (irq & 3))
    mem32[_ENABLE] = 1 << irq
    return entry


def leave(irq):
    mem32[_DISABLE] = 1 << irq
