"""A client of LPTControl's language: files with flow control, control commands, and unasked messages of the board.

    with PulsesClient("/dev/ttyACM0") as client:
        client.send_file(data, stream=False)        # commands in it; Failure with line and column
        client.command("run", 5)
        client.wait(("end",), show)                 # show(status) as it goes
"""

import time

from host_tools.clients.client import Client
from host_tools.clients.refusal import Refused, explain_error
from host_tools.clients.serial_port import LinkError, open_port
from host_tools.failure import Failure
from host_tools.language import _, error_text
from passo.protocols.pulses.protocol import ACK, CREDIT, WINDOW, frame
from passo.protocols.pulses.report import status_from

POLL_S = 0.1
TIMEOUT_S = 5.0
HOME_S = 600.0
_TOLD = ("[", "$")  # how lines begin that answer one about settings, jobs or the journal
_ENDS = ("stopped", "ready")  # everything has been dropped, or the board began anew


class PulsesClient(Client):
    def __init__(self, port, baud=115200, log=None):
        super().__init__(port, open_port(port, baud), log)
        self._serial.timeout = 0.01
        self._part = b""
        self.acks = 0
        self.said = []  # unasked messages

    # --- the wire

    def send(self, data):
        """Send bytes as they are. Raises LinkError if the port has gone away."""
        self._write_bytes(data)

    def read_lines(self):
        """The lines received since the last call; waits a little for one."""
        data = self._read_bytes()
        if data:
            self._log_bytes("<", data)
        self.acks += data.count(ACK)
        *whole, self._part = (self._part + data.replace(ACK, b"")).split(b"\n")
        return [line.decode("ascii", "replace").strip() for line in whole]

    def _await_answer(self, wanted, what, timeout_s=TIMEOUT_S, idle=None, checked=True):
        """The next line for which `wanted(line)`; raises Failure at an error. Keeps other lines, and errors with a line and column
        of the file being sent. Calls `idle()` while waiting, which may send commands itself. `checked`: an error is raised, else returned."""
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            if idle:
                idle()
            found = None
            kept, self.said = (self.said, []) if idle else ([], self.said)
            for line in kept + self.read_lines():
                if line.startswith("taken:"):
                    raise LinkError("{}: the program at {} has taken this connection", self.port, line[6:])
                failed = line.startswith(("error:", "alarm:")) and (idle or " line " not in line) or idle and line in _ENDS
                if found is None and (failed or wanted(line)):
                    found = line
                else:
                    self.said.append(line)
            if found is not None:
                if checked:
                    check(found, what)
                return found
        raise LinkError("no answer on port {} to {}", self.port, what)

    # --- commands

    def command(self, *words):
        """Send a control command; raises Failure if it is refused."""
        self.send(frame(*words))
        return self._await_answer(lambda line: line == "ok", " ".join(map(str, words)))

    def ask(self, line, timeout_s=TIMEOUT_S):
        """Send a line about settings, stored jobs or the journal, `$100`, `$F` or `$JR`; returns the lines before its ok. Raises Refused.
        Ignores errors with a line and column, which are of earlier codes."""
        kept, self.said = self.said, []
        self.send(frame(line))
        answer = self._await_answer(lambda heard: heard == "ok", line, timeout_s, None, False)
        if answer != "ok":
            raise Refused("{}: {}", line, explain_error(answer), number=int(answer[6:]))
        told = [heard for heard in self.said if heard.startswith(_TOLD)]
        self.said = kept + [heard for heard in self.said if not heard.startswith(_TOLD)]
        return told

    def home(self):
        """Home the machine and wait until it is done, HOME_S at most. Raises Failure."""
        self.send(frame("home"))
        self._await_answer(lambda line: line == "ok", "home", HOME_S)

    def status(self):
        """Ask for the status, and return its fields, {name: text}. Raises Failure."""
        self.send(frame("?"))
        return status_from(self._await_answer(lambda line: line.startswith("<"), "?"))

    def log(self):
        """[(ms, number, who)] of the board's event log, oldest first."""
        self.command("log")
        lines = [line[4:].split(",", 2) for line in self.said if line.startswith("log:")]
        self.said = [line for line in self.said if not line.startswith("log:")]
        return [(int(ms), int(number), who) for ms, number, who in lines]

    def send_file(self, data, stream=False, show=None, idle=None):
        """Send a file to be stored, or to be played as it comes; returns its number of commands. `data`: its bytes, or, for a stream,
        an iterable of pieces of them. Calls `show(part)`, 0…1, and `idle()` while waiting, which may send commands."""
        whole = isinstance(data, bytes)
        pieces = iter([data] if whole else data)
        self.command("stream" if stream else "load", *([len(data)] if whole else []))
        self.said = [line for line in self.said if " line " not in line]  # of a byte that came before
        self.send(b"\n")
        self.acks = 0
        sent = 0
        piece, at = b"", 0  # the piece under way, and its bytes sent
        latest = time.monotonic()
        while True:
            if at == len(piece):
                piece, at = next(pieces, None), 0
                if piece is None:
                    break
            room = WINDOW + self.acks * CREDIT - sent
            if room > 0:
                part = piece[at : at + room]
                self.send(part)
                at += len(part)
                sent += len(part)
                latest = time.monotonic()
                if show:
                    show(sent / len(data))
            if idle:
                idle()
            kept, self.said = self.said, []
            for line in kept + self.read_lines():
                check(line, "the file")
                self.said.append(line)
            if time.monotonic() - latest > TIMEOUT_S:
                if not stream:
                    raise LinkError("port {} takes no more of the file", self.port)
                latest = time.monotonic()
                self._check_plays()
        self.send(frame("end"))  # behind all that is still to be played of a stream
        limit_s = float("inf") if stream else TIMEOUT_S
        return int(self._await_answer(lambda line: line.startswith("ok "), "end", limit_s, self._watch_board(idle)).split()[1])

    def _watch_board(self, idle):
        """A function that calls `idle`, and asks the board each TIMEOUT_S whether it still answers: a stream may take hours. It raises LinkError."""
        latest = [time.monotonic()]

        def check_board():
            """Call `idle`, and ask the board for its status each TIMEOUT_S seconds."""
            if idle:
                idle()
            if time.monotonic() - latest[0] > TIMEOUT_S:
                self.status()
                latest[0] = time.monotonic()

        return check_board

    def _check_plays(self):
        """Raise Failure if the machine is idle or in alarm: it plays no more of the stream. A stream that stands may only be paused."""
        state = self.status()["state"]
        if state in ("idle", "alarm"):
            raise Failure("the board plays no more of the file: its state is {}", state)

    def wait(self, words, show=None):
        """Wait until the board says one of `words`; returns it. Calls `show(status)` every 0.1 s."""
        asked = 0.0
        while True:
            for line in self.said + self.read_lines():
                if line in words:
                    self.said = []
                    return line
                check(line, "the run")
            self.said = []
            if show and time.monotonic() - asked > POLL_S:
                show(self.status())
                asked = time.monotonic()


def check(line, what):
    """Raise Failure if `line` is an error or an alarm, or says that everything has been dropped."""
    if line == "stopped":
        raise Failure("{}: stopped by another program", what)
    if line == "ready":
        raise Failure("{}: the board has been reset", what)
    kind, colon, rest = line.partition(":")
    if kind in ("error", "alarm") and rest:
        number, blank, where = rest.partition(" ")
        text = error_text(int(number)) if number.isdigit() else rest
        place = f"{what}: {where.replace('line', _('line')).replace('column', _('column'))}" if where else what
        if kind == "alarm":
            raise Failure("{}: alarm {}: {}", place, number, text)
        raise Failure("{}: error {}: {}", place, number, text)
