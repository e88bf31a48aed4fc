"""A UART as a serial line. Its bytes are taken off its FIFO by an interrupt, into a buffer that lasts longer than any
garbage collection. Reading never blocks; writing blocks only when the buffer to send is full."""

from machine import UART, Pin
from micropython import const

_RECEIVE_BYTES = const(1024)  # 89 ms at 115 200 baud
_SEND_BYTES = const(256)
_WAIT_MS = const(1000)  # for room there: without it the interpreter drops what does not fit
_MOST = const(512)  # bytes read in one go: the most that a sender has under way, so that `?` is seen behind it
_PARITIES = {"none": None, "even": 0, "odd": 1}


class UartLine:
    def __init__(self, link):
        """`link` of the board file; its port is "uart0" or "uart1". An inverter's says parity and stop bits too."""
        self._capture = None
        self._before = self._kept = self._given = 0  # bytes in the UART's buffer that come before the captured ones; the captured ones; and those given of them
        self._ahead = b""  # bytes that were captured earlier: they come before all these
        self._waiting = 0  # bytes that are not in the UART's buffer
        self._uart = UART(
            int(link["port"][4:]),
            link["baud"],
            tx=Pin(link["tx"]),
            rx=Pin(link["rx"]),
            rxbuf=_RECEIVE_BYTES,
            txbuf=_SEND_BYTES,
            timeout=_WAIT_MS,
            timeout_char=_WAIT_MS,
        )
        if "parity" in link:
            self._uart.init(parity=_PARITIES[link["parity"]], stop=link["stop_bits"])
        self.write = self._uart.write  # itself, see usb_line.py
        self.count = self._uart.any  # returns how many bytes have come; rp2/port.py wraps it at high rates
        self._data = bytearray(_MOST)
        self._view = self._said = memoryview(self._data)

    def join(self, capture):
        """Let `capture` take what comes while flash is written."""
        self._capture = capture

    def writing(self, on):
        """Flash is about to be written, or has been: no interrupt takes bytes off the FIFO meanwhile."""
        if self._capture is None:
            return
        if on:
            if self._kept:  # nobody has read yet what was captured last: copy it, because begin() overwrites it
                first = self._uart.read(self._before) if self._before else b""
                self._ahead += first + bytes(self._capture.view[self._given : self._kept])
            self._before = self._capture.begin(self._uart)
        else:
            self._kept = self._capture.end()
            self._given = 0
            self._waiting = len(self._ahead) + self._kept

    def any(self):
        return self.count() + self._waiting

    def read(self):
        """Return the bytes that have come, at most 512, good until the next read; b"" if none."""
        if self._waiting:
            return self._read_kept()
        count = self.count()
        if not count:
            return b""
        if count > _MOST:
            count = _MOST
        self._uart.readinto(self._data, count)
        if count != len(self._said):
            self._said = self._view[:count]
        return self._said

    def _read_kept(self):
        """Return the next bytes kept around a flash write, at most _MOST, in the order that they came."""
        if self._ahead:
            data = self._ahead[:_MOST]
            self._ahead = self._ahead[_MOST:]
            self._waiting -= len(data)
            return data
        if self._before:
            data = self._uart.read(min(self._before, _MOST))
            self._before -= len(data)
            return data
        first = self._given
        self._given = min(first + _MOST, self._kept)
        data = self._capture.view[first : self._given]
        self._waiting -= len(data)
        if self._given == self._kept:
            self._kept = self._given = 0
        return data

    def close(self):
        self._uart.deinit()
        if self._capture is not None:
            self._capture.close()
