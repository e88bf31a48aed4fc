"""Counts the pulses of an input in its interrupt, and when the last one came.

    pulses = port.make("tachometer", name)          # of an input; edges within 50 µs are noise
    pulses.count_pulses(), pulses.us                # modulo 2²⁹ both; in this order, so that `us` is not older

An edge takes about 20 µs of an RP2040.
"""

from time import ticks_us

import micropython
from machine import Pin
from micropython import const

from passo.records import COUNT_MASK

_LEAST_US = const(50)


def create(port, inputs, name):
    """Return the PinPulses of an input."""
    return PinPulses(inputs[name], port)


class PinPulses:
    def __init__(self, item, port):
        self._count = 0
        self.us = ticks_us() & COUNT_MASK
        port.watch(item.pin, self.on_edge, Pin.IRQ_RISING if item.level else Pin.IRQ_FALLING)

    @micropython.native
    def on_edge(self, pin):  # ISR: no allocation
        """Count a pulse, and keep its time. Called in the pin's interrupt, about 20 µs."""
        now = ticks_us() & COUNT_MASK
        if (now - self.us) & COUNT_MASK >= _LEAST_US:
            self.us = now
            self._count = (self._count + 1) & COUNT_MASK

    def count_pulses(self):
        """Return the number of pulses, modulo 2²⁹."""
        return self._count
