"""Memory accesses of rp2040py's compiled chip without a detour through Python: twice the speed.

Before each access the compiled code looks up the method by name, in case Python has replaced it. That makes a bound method,
which costs more than the access. With the plain function in the instance's own dictionary nothing is bound; first in the
dictionary and with interned names, it is found at the first try.

    install(chip)

Python itself cannot call chip.read_uint32(…) any more, because such a function has no `self`. In rp2040py only the DMA channels call it; they get a
Bus.
"""

import sys
from functools import partial

NAMES = [sys.intern(f"{verb}_uint{bits}") for bits in (16, 32, 8) for verb in ("read", "write")]


class Bus:
    """The memory of a chip, for callers in Python: bus.read_uint32(address), bus.write_uint8(address, value), …"""

    def __init__(self, chip):
        for name in NAMES:
            setattr(self, name, partial(vars(type(chip))[name], chip))


def install(chip):
    """Put a Bus before the memory of the DMA channels, and the functions NAMES of the chip's class ahead of all other attributes of the chip."""
    bus = Bus(chip)
    for channel in chip.dma.channels:
        channel.rp2040 = bus
    attributes = dict(vars(chip))
    vars(chip).clear()
    vars(chip).update({name: vars(type(chip))[name] for name in NAMES})
    vars(chip).update(attributes)
