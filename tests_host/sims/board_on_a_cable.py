"""A board behind one pty, as `passo panel` and mpremote both see it: the machine of its board.py, or MicroPython's prompt.

    with BoardOnACable(folder) as board:        # folder: its file system, with a board.py
        board.port                              # what to open
        board.starts                            # how often a machine has started

mpremote's first byte, Ctrl-C, stops the machine, as it does on a board at rest; its reset starts the machine of board.py. Needs
unix MicroPython for the prompt (fake_board.py).
"""

import os
import pty
import select
import subprocess
import sys
import threading
import tty
from pathlib import Path

from host_tools import interpreter

FAKE_BOARD = Path(__file__).with_name("fake_board.py")
MICROPYTHON = Path(sys.executable).parent / "micropython"
CTRL_C = b"\x03"


class BoardOnACable:
    def __init__(self, folder):
        self.folder = folder
        self.starts = 0
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)
        self._child = None
        self._start()
        self._ended, self._end = os.pipe()
        self._thread = threading.Thread(target=self._carry, daemon=True)
        self._thread.start()

    def _start(self):
        """The machine of board.py, as after a reset."""
        (self.folder / ".reset").unlink(missing_ok=True)
        words = [*interpreter.passo(), "board", "--board", str(self.folder / "board.py")]
        self._child = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        line = self._child.stdout.readline()
        assert line.startswith("port: "), line
        self._in = self._out = os.open(line[6:].strip(), os.O_RDWR | os.O_NOCTTY)
        self._prompts = False
        self.starts += 1

    def _stop(self):
        for end in {self._in, self._out}:
            os.close(end)
        self._child.terminate()
        self._child.wait()
        if self._child.stdout:
            self._child.stdout.close()

    def _ask(self):
        """MicroPython's prompt."""
        self._stop()
        (self._in, its_out), (its_in, self._out) = os.pipe(), os.pipe()
        self._child = subprocess.Popen([MICROPYTHON, FAKE_BOARD, self.folder], stdin=its_in, stdout=its_out)
        os.close(its_in)
        os.close(its_out)
        self._prompts = True

    def _carry(self):
        while True:
            ready = select.select([self._master, self._in, self._ended], [], [], 0.1)[0]
            if self._ended in ready:
                return
            if self._in in ready:
                os.write(self._master, os.read(self._in, 4096))
            if self._prompts and (self.folder / ".reset").exists():
                self._stop()
                self._start()
            if self._master in ready:
                data = os.read(self._master, 4096)
                if not self._prompts and CTRL_C in data:
                    self._ask()
                os.write(self._out, data)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.write(self._end, b"x")
        self._thread.join()
        self._stop()
        for end in (self._master, self._slave, self._ended, self._end):
            os.close(end)
