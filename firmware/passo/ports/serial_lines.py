"""Serial lines: a UART with its own buffers, or the USB port's console made clean for bytes.

A UART's bytes are taken off its FIFO by an interrupt, into a buffer that lasts longer than any garbage collection.
Reading never blocks; writing blocks only when the buffer to send is full.
"""

import sys
from select import POLLIN, poll
from time import ticks_diff, ticks_ms

import micropython
from machine import UART, Pin
from micropython import const

_RECEIVE_BYTES = const(1024)  # 89 ms at 115 200 baud
_SEND_BYTES = const(256)
_MOST = const(64)  # bytes read from USB in one go
_INTERRUPT = const(3)  # Ctrl-C
_ESCAPE = b"\r\x03"  # what mpremote begins with
_SILENCE_MS = const(1000)


class UartLine:
    def __init__(self, link):
        """`link` of the board file; its port is "uart0" or "uart1"."""
        self._uart = UART(
            int(link["port"][4:]),
            link["baud"],
            tx=Pin(link["tx"]),
            rx=Pin(link["rx"]),
            rxbuf=_RECEIVE_BYTES,
            txbuf=_SEND_BYTES,
        )

    def any(self):
        return self._uart.any()

    def read(self):
        """All bytes that have come, b"" if none."""
        count = self._uart.any()  # read() without it takes a buffer of 256 bytes each time
        return self._uart.read(count) or b"" if count else b""

    def write(self, data):
        self._uart.write(data)

    def close(self):
        self._uart.deinit()


class UsbLine:
    """The console's USB port. Ctrl-C is a byte like any other, except as the Enter and Ctrl-C with which tools ask for
    the REPL: these two bytes first after a second's silence end the program by KeyboardInterrupt."""

    def __init__(self):
        self._poll = poll()
        self._poll.register(sys.stdin, POLLIN)
        self._in = sys.stdin.buffer
        self._byte = bytearray(1)
        self._data = bytearray(_MOST)
        self._out = sys.stdout.buffer
        self._heard_ms = ticks_ms()
        micropython.kbd_intr(-1)

    def any(self):
        for _ in self._poll.ipoll(0):
            return True
        return False

    def read(self):
        """Bytes that have come, at most 64, b"" if none. Raises KeyboardInterrupt when the REPL is asked for."""
        # The console gives what it has byte by byte only: asked for more, it waits for them.
        count = 0
        byte = self._byte
        data = self._data
        take = self._in.readinto
        while count < _MOST and self.any():
            take(byte)
            data[count] = byte[0]
            count += 1
        if not count:
            return b""
        data = bytes(memoryview(data)[:count])
        now_ms = ticks_ms()
        silent_ms = ticks_diff(now_ms, self._heard_ms)
        self._heard_ms = now_ms
        if silent_ms >= _SILENCE_MS and data.startswith(_ESCAPE):
            raise KeyboardInterrupt
        return data

    def write(self, data):
        self._out.write(data)

    def close(self):
        micropython.kbd_intr(_INTERRUPT)
