"""A client of the torch manipulator's frames, and of Passo's own frames if the board knows them.

    with TorchClient("/dev/ttyACM0") as client:
        client.order(torch.move(480, 480, 830, -830))       # raises Refused with the board's reason
        client.wait(show)                                   # until it stands; show(status) as it goes
        client.counts("STOP")                               # (x, y): steps made since the last move or jog

The original language cannot refuse. A Passo board counts what it dropped and tells the reason if asked; any other board tells
only the steps made.
"""

import time

from host_tools.clients import refusal
from host_tools.clients.client import Client
from host_tools.clients.answers import is_complete
from host_tools.clients.refusal import lines_before_ok
from host_tools.clients.torch_wire import Answers
from host_tools.clients.serial_port import LinkError, open_port
from host_tools.failure import Failure
from host_tools.language import error_text
from passo import errors
from passo.protocols.torch import protocol as torch
from passo.protocols.typed_words import line_of

POLL_S = 0.1
_PASSO_S = 0.5  # a board that does not answer a status question by then is not Passo
_IDLE_GAP_S = 0.02  # silence before a frame, so that it is never taken for the rest of a torn one


class Refused(Failure):
    """The board dropped a frame."""


class TorchClient(Client):
    def __init__(self, port, baud=115200, timeout_s=3.0, log=None):
        super().__init__(port, open_port(port, baud), log)
        self.timeout_s = timeout_s
        self._serial.timeout = 0.01
        self._answers = Answers()
        self._said = []
        self.ours = None  # does the board know the words of Passo? None: not asked yet
        time.sleep(_IDLE_GAP_S)

    # --- frames

    def send(self, data):
        """Send bytes as they are. Raises LinkError if the port has gone away."""
        self._write_bytes(data)

    def _log_text(self, data):
        return data.hex(" ")

    def _next_answer(self, name, seconds):
        """The fields of the next answer `name`, a dict; None if it does not come within `seconds`."""
        deadline = time.monotonic() + seconds
        while True:
            for at, (told, fields) in enumerate(self._said):
                if told == name:
                    del self._said[: at + 1]
                    return fields
            data = self._read_bytes()
            if data:
                self._log_bytes("<", data)
            self._answers.put(data, int(time.monotonic() * 1000) & 0x1FFFFFFF)
            while told := self._answers.next_answer():
                self._said.append(told)
            if not self._said and time.monotonic() > deadline:
                return None

    def _ask_board(self, data, name, seconds):
        self._said.clear()
        self.send(data)
        return self._next_answer(name, seconds)

    def counts(self, name="INFO"):
        """(x, y): steps since the last move or jog, from the answer to INFO, or to STOP, which also stops the machine. Raises LinkError."""
        fields = self._ask_board(torch.frame(name), name, self.timeout_s)
        if fields is None:
            raise LinkError("{}: no answer to {}; is it the torch's board, and its speed?", self.port, name)
        return fields["x"], fields["y"]

    def status(self):
        """The status {state, error, ours, x, y, dropped} of a Passo board, x and y in steps; None for any other board. Raises LinkError."""
        if self.ours is False:
            return None
        fields = self._ask_board(torch.passo(torch.STATUS_OF), "PASSO", self.timeout_s if self.ours else _PASSO_S)
        if fields is None and self.ours:
            raise LinkError("{}: no status any more", self.port)
        if fields is None:
            self.counts()
        self.ours = fields is not None
        return fields

    def log(self):
        """[(ms, number, who)] of the board's event log, oldest first; None if the board has no frame for it."""
        entries = []
        while True:
            fields = self._ask_board(torch.passo(torch.LOG_OF, len(entries)), "LOG", self.timeout_s if entries else _PASSO_S)
            if fields is None and entries:
                raise LinkError("{}: the log breaks off", self.port)
            if fields is None:
                return None
            if fields["number"]:
                entries.insert(0, (fields["ms"], fields["number"], fields["who"]))
            if not fields["older"]:
                return entries

    def ask(self, line):
        """Send a line about settings, `$100`; returns the lines before its ok. Raises Refused of refusal.py, also if the board has no such lines."""
        if self.status() is None:
            raise refusal.Refused("{}: this board is none of Passo, or does not answer", self.port)
        text = ""
        fields = self._ask_board(b"".join(torch.passo(torch.LINE_OF, byte) for byte in line_of(line)), "TEXT", self.timeout_s)
        while fields is not None:
            text += fields["text"]
            if is_complete(text):
                return lines_before_ok(line, text)
            fields = self._next_answer("TEXT", self.timeout_s)
        self.status()  # this clears the error of the frame that was not understood
        raise refusal.Refused("{}: the board's firmware is older than its settings' lines: flash it anew", line, number=errors.STATEMENT)

    # --- commands

    def order(self, data):
        """Send a frame that has no answer. Raises Refused if a Passo board dropped it."""
        before = self.status()
        self.send(data)
        after = self.status()
        if before and after["dropped"] != before["dropped"]:
            raise Refused("the board did not do it: error {}, {}", after["error"], error_text(after["error"]))
        return after

    def jog(self, direction, times=1):
        """Make `times` jogs in `direction`, X+ … Y-, as one motion. A Passo board has a frame for that, because it takes only
        a few repeated jogs in advance (a held button); any other board gets them one by one."""
        code = torch.CODES["JOG_" + direction]
        if self.status() is None:
            self.send(torch.frame("JOG_" + direction) * times)
            return
        while times:
            now = min(times, 255)
            self.order(torch.passo(code, now))
            times -= now
            if times:
                self.wait()

    def wait(self, show=None):
        """Wait until the machine stands. Calls `show(status)` each time. Raises Refused in an alarm."""
        last = None
        while True:
            status = self.status() or self._guess_status(last)
            last = status
            if show:
                show(status)
            if status["state"] == "alarm":
                raise Refused("alarm {}, {}", status["error"], error_text(status["error"]))
            if status["state"] not in ("run", "jog"):
                return status
            time.sleep(POLL_S)

    def _guess_status(self, last):
        """A status for a board that has none: it stands if its step counts are those of the `last` status."""
        x, y = self.counts()
        still = last is not None and (x, y) == (last["x"], last["y"])
        return {"state": "idle" if still else "run", "error": 0, "ours": None, "x": x, "y": y, "dropped": 0}
