"""The router's firmware in a thread of its own, its first link on a pseudo-terminal, for programs that open a port.

    running = Running()
    serial.Serial(running.line.name) …
    running.until(lambda: running.position() == [0, 0, 0])
    running.close()
"""

import threading
import time

from boards.router_3axis import BOARD
from host_tools.sim.pages import Pages
from host_tools.sim.serial_line import PtyLine, wait_for_bytes
from passo.app import App
from passo.config.boardfile import check
from passo.ports.virtual import MemoryLine, VirtualPort
from router import World

LIMIT_S = 120


class Running:
    """`line.name` is the port to open, a pty unless another is given; `mode` is that of the virtual port; `changes` to the
    board file."""

    def __init__(self, mode="real", line=None, **changes):
        self.world = World()
        if mode == "fast":  # its clock leaps over what a sender needs to say its next line
            changes = {"links": [{**link, "lost": "go_on"} for link in BOARD["links"]], **changes}
        board = check({**BOARD, **changes})
        self.line = line or PtyLine()
        lines = {"pc": self.line, "serial": MemoryLine()}
        port = VirtualPort(board, self.world, mode, lines, lambda ms: wait_for_bytes([self.line], ms))
        if board.get("journal"):
            port.pages = Pages()
        self.app = App(board, port)
        self._stop = False
        self.failed = None
        self._thread = threading.Thread(target=self._loop, daemon=True)
        self._thread.start()

    def _loop(self):
        try:
            while not self._stop:
                self.app.cycle()
        except Exception as error:  # shown by the test that waits for it
            self.failed = error

    def until(self, condition, limit_s=LIMIT_S):
        deadline = time.monotonic() + limit_s
        while not condition():
            assert self.failed is None, self.failed
            assert time.monotonic() < deadline, self.app.controller.state
            time.sleep(0.01)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._stop = True
        self._thread.join()
        self.line.close()

    def standing(self):
        """True in a hold that has come to its stand."""
        machine = self.app.controller.machine
        return bool(machine.hold) and machine.stood

    def position(self):
        return list(self.app.controller.position())
