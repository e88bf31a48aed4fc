"""The board of a panel: a serial port that may go and come back, or a virtual board of its own."""

import os
import subprocess
import time

from host_tools import boards, interpreter
from host_tools.clients.serial_port import LinkError, open_exclusively
from host_tools.failure import Failure
from host_tools.sim.stock import Stock

END_WITH_STDIN = "PASSO_END_WITH_STDIN"  # set by a program that keeps a virtual board's standard input open as long as it lives

_AGAIN_S = 1.0


class Port:
    """Bytes from and to a board. `changed(fd, open)`: the port has been opened, or is about to be closed."""

    def __init__(self, name, baud, changed):
        self.name = name
        self.baud = baud
        self._changed = changed
        self._serial = None
        self._lent = False
        self._tried = 0.0

    def open(self):
        """Open the port. Raises LinkError."""
        self._tried = time.monotonic()
        self._serial = open_exclusively(self.name, self.baud, 0)
        self._changed(self._serial.fileno(), True)

    def look(self):
        """Try to open a port that went away, once each second."""
        if self._serial is None and not self._lent and time.monotonic() - self._tried >= _AGAIN_S:
            try:
                self.open()
            except LinkError:
                pass

    def read(self):
        """Return the bytes received since the last call; b"": none, or no port."""
        if self._serial is None:
            return b""
        try:
            return self._serial.read(max(1, self._serial.in_waiting))
        except (OSError, TypeError, ValueError):
            self._lose_port()
            return b""

    def write(self, data):
        """Send bytes; lost without a port. A failing port is closed, and look() opens it again."""
        if self._serial is not None:
            try:
                self._serial.write(data)
            except (OSError, ValueError):
                self._lose_port()

    def close(self):
        if self._serial is not None:
            self._lose_port()

    def lend_port(self):
        """Close the port and leave it to another program until take_back()."""
        self._lent = True
        self.close()

    def take_back(self, name, baud):
        """Note that the board is at port `name`, and that it is free again. look() opens it once it is there."""
        self.name, self.baud = name, baud
        self._lent = False

    def _lose_port(self):
        """Close the port and call changed(fd, False)."""
        opened, self._serial = self._serial, None
        try:
            self._changed(opened.fileno(), False)
            opened.close()
        except (OSError, ValueError):
            pass


class Demo:
    """`passo board` as a process of its own; `name` is the port to open."""

    def __init__(self, board, options=()):
        self.board = board
        self._options = list(options)
        self._process = None
        self.name = self._start_board()

    def _start_board(self):
        """Start the virtual board's process; returns its port's name. Raises Failure if it does not start."""
        stock = ["--stock"] if Stock.can_touch(boards.load(self.board)) else []
        words = [*interpreter.passo(), "board", "--board", self.board, *stock, *self._options]
        # The board ends when this pipe does: also if this program is killed.
        environment = {**os.environ, END_WITH_STDIN: "1"}
        self._process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)
        line = self._process.stdout.readline()
        if not line.startswith("port: "):
            self.close()
            raise Failure("the virtual board {} did not start", self.board)
        return line[6:].strip()

    def change_board(self, board):
        """Start the virtual board anew with the board file `board`. Returns the name of its port. Raises Failure."""
        self.close()
        self.board = board
        self.name = self._start_board()
        return self.name

    def close(self):
        """End the process, by force after 5 s."""
        self._process.terminate()
        try:
            self._process.wait(5)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()
        self._process.stdin.close()
