"""GPIO registers of the ESP32 family, by which many pins change at once. Technical reference manuals: ESP32 4.10,
S2 5.14, S3 6.14, C3 5.14, C6 7.15."""

import sys

_BASES = (
    ("ESP32S2", 0x3F404000), ("ESP32S3", 0x60004000), ("ESP32C3", 0x60004000), ("ESP32C6", 0x60091000),
    ("ESP32", 0x3FF44000),
)  # fmt: skip


def gpio_base(machine=None):
    """Where the registers begin on this chip. `machine`: as sys.implementation has it."""
    machine = (machine or sys.implementation._machine).replace("-", "").upper()
    for name, base in _BASES:
        if name in machine:
            return base
    raise ValueError("not a chip of the ESP32 family that is known: %s" % machine)


def set_register(base, bank):
    """Writing a one raises the pin. Bank 0: pins 0 … 31, bank 1: from 32 on."""
    return base + (0x14 if bank else 0x08)


def clear_register(base, bank):
    """Writing a one lowers the pin."""
    return base + (0x18 if bank else 0x0C)
