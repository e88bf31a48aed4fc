"""Encoders counted by the interrupts of both pins: where there is no PIO.

An interrupt takes about 20 µs, on an ESP32 up to 100: more than 5000 counts a second are not safe. A change of both pins between
two of them counts nothing.
"""

import micropython
from machine import Pin

from passo.options.encoders.port import Encoders
from passo.records import COUNT_MASK

# By the pins before and now, B A each: 0 none, or one was missed; 1 up, 2 down.
_CHANGES = bytes((0, 1, 2, 0, 2, 0, 0, 1, 1, 0, 0, 2, 0, 2, 1, 0))


class PinEncoder:
    def __init__(self, pins, port):
        self._a = Pin(pins[0], Pin.IN, Pin.PULL_UP)
        self._b = Pin(pins[1], Pin.IN, Pin.PULL_UP)
        self._was = self._a.value() | self._b.value() << 1
        self.count = 0  # modulo 2²⁹
        for pin in (self._a, self._b):
            port.watch(pin, self.on_edge, Pin.IRQ_RISING | Pin.IRQ_FALLING)

    @micropython.native
    def on_edge(self, pin):  # ISR: no allocation
        """Count an edge of A or B. Called in their interrupts: 20 µs on an RP2040, up to 100 on an ESP32."""
        now = self._a.value() | self._b.value() << 1
        change = _CHANGES[self._was << 2 | now]
        self._was = now
        if change == 1:
            self.count = (self.count + 1) & COUNT_MASK
        elif change:
            self.count = (self.count - 1) & COUNT_MASK

    def close(self):
        """Switch the interrupts off."""
        self._a.irq(None)
        self._b.irq(None)


class PinEncoders(Encoders):
    def __init__(self, board, port, inputs):
        Encoders.__init__(self, board, port)
        self._each = [PinEncoder(entry["pins"], port) for entry in board["encoders"]]
        self.watch_indexes(board, inputs)

    def read(self, counts):  # ISR: no allocation
        """Write the counts, modulo 2²⁹, to `counts`."""
        for number in range(len(counts)):
            counts[number] = self._each[number].count

    def close(self):
        """Switch all interrupts off."""
        for each in self._each:
            each.close()


def create(board, port, inputs, outputs):
    """Return the port's part."""
    return PinEncoders(board, port, inputs)
