"""An emulated Pico behind a pty, as a PC sees one on its USB port: the port is not there while the Pico resets.

    with on_a_port(pico, tmp_path / "port") as board:       # a PortBoard: mpremote's raw REPL over the pty
        board.exec("print(1)")

Its clock is the Pico's own outside, whatever else the PC does: time passes while the board is waited for, and while mpremote talks to it.
"""

import contextlib
import math
import threading
import time

from host_tools.prove.connection import PortBoard
from host_tools.sim.serial_line import PtyLine

SLICE_US = 200
START_S = 60


class PicoPort(PortBoard):
    emulated = True
    answer_s = 60  # by the PC's clock

    def __init__(self, running, name):
        self.running = running
        self.pico = running.pico
        super().__init__(name)

    def now_s(self):
        return self.pico.now_us / 1e6

    def wait_s(self, seconds):
        self.running.until(self.pico.now_us + seconds * 1e6)

    def restart_interpreter(self):
        with self.running.freely():
            super().restart_interpreter()

    def start(self, code):
        with self.running.freely():
            super().start(code)


class Running:
    """The thread that runs the Pico: the only one that touches it."""

    def __init__(self, pico, link):
        self.pico = pico
        self._link, self._line = link, None
        self._turn = threading.Condition()
        self._end_us, self._free, self._stopped, self.error = 0, False, False, None
        self.plugged = True
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def until(self, end_us):
        with self._turn:
            self._end_us = end_us
            self._turn.notify_all()
            self._turn.wait_for(lambda: self.error or self.pico.now_us >= end_us)
        if self.error:
            raise self.error

    @contextlib.contextmanager
    def freely(self):
        """Let the Pico run on by itself, no faster than the PC's clock."""
        with self._turn:
            self._free = True
            self._turn.notify_all()
        try:
            yield
        finally:
            with self._turn:
                self._free = False

    def stop(self):
        with self._turn:
            self._stopped = True
            self._turn.notify_all()
        self._thread.join(60)
        if self._line is not None:
            self._line.close()

    def _work(self):
        try:
            while not self._stopped:
                with self._turn:
                    self._turn.wait_for(lambda: self._stopped or self._free or self.pico.now_us < self._end_us)
                    ends_us = math.inf if self._free else self._end_us
                    begun_s = time.monotonic()
                    self._slice(min(SLICE_US, max(1, ends_us - self.pico.now_us)))
                    self._turn.notify_all()
                    if self._free:
                        self._turn.wait(max(0.0001, SLICE_US / 1e6 - (time.monotonic() - begun_s)))
        except BaseException as error:  # the waiting caller raises it
            with self._turn:
                self.error = error
                self._turn.notify_all()

    def _slice(self, us):
        pico = self.pico
        there = pico.usb.up and self.plugged
        if self._line is None and there:
            self._line = PtyLine(self._link)
        elif self._line is not None and not there:
            self._line.close()
            self._line = None
        if self._line is not None:
            pico.usb.write(self._line.read())
        pico.run(us)
        said = pico.console.take_output()
        if self._line is not None:
            self._line.write(said)


@contextlib.contextmanager
def running(pico, link):
    made = Running(pico, link)
    try:
        made.until(pico.now_us + SLICE_US)
        yield made
    finally:
        made.stop()


@contextlib.contextmanager
def on_a_port(pico, link):
    with running(pico, link) as made, PicoPort(made, str(link)) as board:
        yield board
