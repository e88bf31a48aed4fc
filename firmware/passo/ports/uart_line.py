"""A UART as a serial line. Its bytes are taken off its FIFO by an interrupt, into a buffer that lasts longer than any
garbage collection. Reading never blocks; writing blocks only when the buffer to send is full."""

from machine import UART, Pin
from micropython import const

_RECEIVE_BYTES = const(1024)  # 89 ms at 115 200 baud
_SEND_BYTES = const(256)
_WAIT_MS = const(1000)  # for room there: without it the interpreter drops what does not fit
_MOST = const(128)  # bytes read in one go
_PARITIES = {"none": None, "even": 0, "odd": 1}


class UartLine:
    def __init__(self, link):
        """`link` of the board file; its port is "uart0" or "uart1". An inverter's says parity and stop bits too."""
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
        self._data = bytearray(_MOST)
        self._view = self._said = memoryview(self._data)

    def any(self):
        return self._uart.any()

    def read(self):
        """Bytes that have come, at most 128, good until the next read; b"" if none."""
        count = self._uart.any()
        if not count:
            return b""
        if count > _MOST:
            count = _MOST
        self._uart.readinto(self._data, count)
        if count != len(self._said):
            self._said = self._view[:count]
        return self._said

    def write(self, data):
        self._uart.write(data)

    def close(self):
        self._uart.deinit()
