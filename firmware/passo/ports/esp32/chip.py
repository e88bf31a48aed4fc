"""GPIO registers of the ESP32 family, by which many pins change at once. Technical reference manuals: ESP32 4.10,
S2 5.14, S3 6.14, C3 5.14, C6 7.15."""

import sys

_BASES = (
    ("ESP32S2", 0x3F404000), ("ESP32S3", 0x60004000), ("ESP32C3", 0x60004000), ("ESP32C6", 0x60091000),
    ("ESP32", 0x3FF44000),
)  # fmt: skip


def gpio_base(machine=None):
    """Return the address at which the registers begin on this chip. `machine`: as sys.implementation has it."""
    machine = (machine or sys.implementation._machine).replace("-", "").upper()
    for name, base in _BASES:
        if name in machine:
            return base
    raise ValueError("not a chip of the ESP32 family that is known: %s" % machine)


# Offsets in the IO_MUX of the ESP32's pins, 0 … 39 (4.13); 0: there is none.
_IO_MUX = (
    0x44, 0x88, 0x40, 0x84, 0x48, 0x6C, 0x60, 0x64, 0x68, 0x54, 0x58, 0x5C, 0x34, 0x38, 0x30, 0x3C, 0x4C, 0x50, 0x70, 0x74,
    0x78, 0x7C, 0x80, 0x8C, 0x90, 0x24, 0x28, 0x2C, 0, 0, 0, 0, 0x1C, 0x20, 0x14, 0x18, 0x04, 0x08, 0x0C, 0x10,
)  # fmt: skip


def input_register(pin):
    """Return the IO_MUX register of a pin, whose bit 9 switches its input on beside an output. ESP32 and S3."""
    if gpio_base() == 0x60004000:
        return 0x60009004 + 4 * pin
    return 0x3FF49000 + _IO_MUX[pin]
