"""The other end of an emulated Pico's UART.

    wire = Wire(pico, pico.chip.uart[0])
    wire.feed(b"...", 57600)    # each byte arrives a character's time after the one before
    wire.drain()                # what the Pico has sent since the last drain; each byte counts once its stop bit is out
    wire.overruns               # bytes that came while the Pico's FIFO was full

The baud rate of `feed` is the wire's; it is not compared with the Pico's setting.
"""

from collections import deque

from host_tools.emulator import cycles

BITS_A_BYTE = 10


class Wire:
    def __init__(self, pico, uart):
        self.output = bytearray()  # by the Pico, not yet drained
        self.stamps = []  # cycles at which the bytes of `output` were out
        self.count = 0  # bytes sent in all
        self.listeners = []  # each called with a byte that is out
        self._pico = pico
        self._uart = uart
        self._coming = deque()  # (cycle, byte)
        self._free_at = 0  # cycle at which the last byte fed is over
        uart.on_byte = self._note_byte

    @property
    def overruns(self):
        """Bytes that came while the FIFO of the UART was full."""
        return self._uart.overruns

    @property
    def pending(self):
        """Bytes fed that have not yet arrived."""
        return len(self._coming)

    def feed(self, data, baud):
        """Put bytes on the wire, behind those fed before; returns the cycle at which the last one will have arrived."""
        start = max(self._pico.cycle, self._free_at)
        character = BITS_A_BYTE * 125_000_000
        idle = not self._coming
        for number, value in enumerate(data, 1):
            self._coming.append((start + number * character // baud, value))
        self._free_at = start + len(data) * character // baud
        if idle and self._coming:
            self._plan_arrival()
        return self._free_at

    def drain(self):
        """Return the bytes that the Pico has sent since the last call."""
        data = bytes(self.output)
        self.output.clear()
        self.stamps.clear()
        return data

    def _plan_arrival(self):
        self._pico.call_at(self._coming[0][0], self._deliver_byte)

    def _deliver_byte(self):
        """Give the UART the next byte from the PC, and plan the one behind it."""
        _, value = self._coming.popleft()
        self._uart.feed_byte(value)
        if self._coming:
            self._plan_arrival()

    def _note_byte(self, value):
        """Keep a byte that the Pico has sent, with its cycle, and hand it to the listeners."""
        self.output.append(value)
        self.stamps.append(cycles.now_cycles(self._pico.chip.clock))
        self.count += 1
        for heard in self.listeners:
            heard(value)


class UsbWire:
    """The same for the USB port, whose bytes have no time: they are there as the bus brings them."""

    def __init__(self, pico):
        self._pico = pico
        self._drained = 0

    @property
    def output(self):
        return self._pico.console.text

    @property
    def count(self):
        return self._drained + len(self.output)

    @property
    def pending(self):
        return self._pico.usb.unsent

    def feed(self, data, baud):
        self._pico.usb.write(data)

    def drain(self):
        said = self._pico.console.take_output()
        self._drained += len(said)
        return said
