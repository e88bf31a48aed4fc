"""The PC's end of the plotter's line: cuts bytes into answers, and logs packets and answers.

    wire = Wire("/dev/ttyACM0", 57600, log="wire.log")
    wire.send(plotter.packet(plotter.COMMANDS["REQUEST"]))
    kind, value = wire.next_event(3.0)      # ("answer", 0x6b), ("status", {...}) or (None, None) after 3 s

A STATUS answer is twelve bytes and every other answer one, so a `?` makes the reader wait for eleven more.
"""

import time

from host_tools.clients.serial_port import open_port, port_error
from passo.protocols.plotter import host as plotter

_STATUS_GAP_S = 0.5  # a STATUS answer that stalls this long is torn
_STALE_S = 0.3  # after which a RESEND is meant for the last packet

ANSWER = {name: byte for byte, name in plotter.ANSWERS.items()}
RESEND = ANSWER["RESEND"]
NAMES = {code: name for name, code in plotter.COMMANDS.items()}


def log_text(data):
    """Bytes as the log of 2014 shows them: [109, 2, -124, 1, 58, 46]."""
    return "[" + ", ".join(str(byte - 256 if byte > 127 else byte) for byte in data) + "]"


def packet_name(data):
    """The name of a valid packet's command, else None."""
    if len(data) != plotter.PACKET or sum(data[:-1]) & 255 != data[-1]:
        return None
    return NAMES.get(data[0])


def packet_text(data):
    """A packet as a line of the log: name, signed bytes, hex."""
    text = f"{packet_name(data) or 'BYTES'} {log_text(data)}"
    return f"{text:<35} {data.hex(' ')}"


def answer_text(data):
    """An answer's name and bytes as the log of 2014 shows them."""
    name = "STATUS" if len(data) > 1 else plotter.ANSWERS.get(data[0], "UNKNOWN")
    return f"{name} {log_text(data)}"


class Wire:
    """`log` is the path of a file that gets one line a packet or answer, or None."""

    def __init__(self, port, baud=57600, log=None):
        self.port = port
        self._serial = open_port(port, baud)
        self._buffer = bytearray()
        self._log = open(log, "a", encoding="utf-8", buffering=1) if log else None

    def close(self):
        """Close the port and the log."""
        self._serial.close()
        if self._log:
            self._log.close()
            self._log = None

    def send(self, data):
        """Send `data` as it is, and log it. Raises LinkError."""
        self._log_bytes(">", data, packet_text(data))
        try:
            self._serial.write(data)
        except (OSError, ValueError) as error:
            raise port_error(self.port, error) from error

    def next_event(self, timeout_s):
        """The next answer: ("answer", byte), ("status", fields), ("torn", bytes) or (None, None) after `timeout_s`."""
        deadline = time.monotonic() + timeout_s
        while not self._buffer:
            self._read_bytes()
            if not self._buffer and time.monotonic() >= deadline:
                return None, None
        if self._buffer[0] != plotter.COMMANDS["STATUS"]:
            return "answer", self._take_bytes(1)[0]
        stalled = time.monotonic() + _STATUS_GAP_S
        while len(self._buffer) < plotter.STATUS_LENGTH:
            self._read_bytes()
            if time.monotonic() >= stalled:
                return "torn", self._take_bytes(len(self._buffer))
        data = self._take_bytes(plotter.STATUS_LENGTH)
        try:
            return "status", plotter.status_from(data)
        except (ValueError, IndexError):
            return "torn", data

    def next_text(self, timeout_s):
        """Return the answer to a packet of WORDS: one byte, or lines of which the last is ok or error; None after `timeout_s`. Skips a RESEND with
        bytes behind it, which answers the rest of another program's packet."""
        deadline = time.monotonic() + timeout_s
        while True:
            if self._buffer and self._buffer[0] == RESEND:
                quiet = time.monotonic() + _STALE_S
                while len(self._buffer) == 1 and time.monotonic() < quiet:
                    self._read_bytes()
                told = self._take_bytes(1)
                if not self._buffer:
                    return told
            lines = bytes(self._buffer).split(b"\n")
            if self._buffer and self._buffer[:1] not in (b"[", b"$", b"o", b"e"):
                return self._take_bytes(1)
            if len(lines) > 1 and (lines[-2] == b"ok" or lines[-2].startswith(b"error:")):
                data = bytes(self._buffer)
                self._buffer.clear()
                self._log_bytes("<", data, repr(data))
                return data
            if time.monotonic() >= deadline:
                self._buffer.clear()
                return None
            self._read_bytes()

    def _take_bytes(self, count):
        """Take `count` bytes off the front of the buffer, log them and return them."""
        data = bytes(self._buffer[:count])
        del self._buffer[:count]
        self._log_bytes("<", data, f"{answer_text(data):<35} {data.hex(' ')}")
        return data

    def _read_bytes(self):
        """Add the bytes that the port has received to the buffer. Raises the error of port_error() if the port fails."""
        try:
            self._buffer += self._serial.read(max(1, self._serial.in_waiting))
        except (OSError, TypeError) as error:
            raise port_error(self.port, error) from error

    def _log_bytes(self, arrow, data, text):
        """Write a line to the log, if there is one: the time to the millisecond, `arrow` and `text`."""
        if self._log:
            now = time.time()
            clock = time.strftime("%H:%M:%S", time.localtime(now)) + f".{int(now * 1000) % 1000:03d}"
            self._log.write(f"{clock} {arrow} {text}\n")
