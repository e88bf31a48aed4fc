"""The base of clients of several languages: an open port that may go away, and a log of all bytes.

    class GrblClient(Client): …         # with GrblClient(…) as client: closes port and log at its end
"""

import time

from host_tools.clients.serial_port import port_error


class Client:
    def __init__(self, port, opened, log):
        """`opened`: the pyserial port of the name `port`, or a FramedPort; `log`: path of a file that gets a line each way, or None."""
        self.port = port
        self._serial = opened
        self.framed = hasattr(opened, "urgent")
        self._log = open(log, "a", encoding="utf-8", buffering=1) if log else None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._serial.close()
        if self._log:
            self._log.close()

    def _write_bytes(self, data):
        """Send bytes, and log them. Raises LinkError."""
        self._log_bytes(">", data)
        try:
            self._serial.write(data)
        except (OSError, ValueError) as error:
            raise port_error(self.port, error) from error

    def _write_now(self, data, cut=False):
        """Send real-time bytes; in frames they overtake what is written, or, if they `cut`, end it. Raises LinkError."""
        if not self.framed:
            self._write_bytes(data)
            return
        self._log_bytes(">", data)
        try:
            self._serial.urgent(data, cut)
        except OSError as error:
            raise port_error(self.port, error) from error

    def _read_bytes(self):
        """The bytes received, after a short wait if there are none. Raises LinkError."""
        try:
            return self._serial.read(max(1, self._serial.in_waiting))
        except (OSError, TypeError, ValueError) as error:
            raise port_error(self.port, error) from error

    def _log_bytes(self, arrow, data):
        if self._log:
            self._log.write(f"{time.time():.3f} {arrow} {self._log_text(data)}\n")

    def _log_text(self, data):
        """The text of bytes in the log."""
        return repr(data)
