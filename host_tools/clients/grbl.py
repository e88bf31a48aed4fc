"""A client of the grbl language: lines with either flow control, real-time bytes, status.

    with GrblClient("/dev/ttyACM0") as client:
        client.command("$X")                        # lines said before its ok; raises Refused
        client.real_time(b"!")
        for number in client.stream(lines, count=True): …    # the line of the file that was answered last
"""

import re
import time

from host_tools.clients.client import Client
from host_tools.clients.refusal import Refused, explain_error
from host_tools.clients.serial_port import LinkError, open_link
from host_tools.language import _, error_text, line_text
from host_tools.clients.grbl_wire import fields_of, number_line

RX_BYTES = 128  # that a grbl keeps; more if its $I says so
_OPTIONS = re.compile(r"\[OPT:[^,\]]*,(\d+),(\d+)\]")
_FRAMED_BYTES = 900  # the same of a framed link, whose credit sees to the rest
_SLICE_S = 0.02
HOME_S = 600
_SIGN_S = 0.3  # between two signs of life while an answer is awaited
_REPORTS = 40  # until one has said what each says only now and then
_STANDING = "Idle", "Alarm", "Check", "Sleep"
RESET = b"\x18"


class GrblClient(Client):
    def __init__(self, port, baud=115200, timeout_s=5.0, log=None, opened=None):
        """`opened`: a port that is open already; `port` is only its name then."""
        super().__init__(port, opened or open_link(port, baud, _SLICE_S, True), log)
        self.timeout_s = timeout_s
        self.status = {}  # fields of the last report; "state" is its first
        self.window = RX_BYTES  # bytes that may be under way
        self.blocks = 0  # that the board queues; 0: unknown
        self.full = None  # part of them that is queued, if reports have Bf:
        self.rest = []  # lines that came behind the last ok of command(), and with it
        self.alarm = None
        self.answered = self.answered_then = 0  # lines of stream(): so far, and as the last report came
        self.sent = None  # lines of stream() so far; None: others have been sent since
        self.banners = 0
        self._buffer = b""
        self._heard = time.monotonic()  # time of the last byte received

    # --- bytes

    def real_time(self, data):
        """Send real-time bytes at once."""
        self._write_now(data, RESET in data)

    def report(self, every_ms):
        """Have the board report its status by itself every `every_ms` ms; 0: stop that. False if it cannot."""
        if self.framed:
            self._serial.report(every_ms, b"?")
        return self.framed

    def read_lines(self):
        """Return the whole lines received since the last call; waits a little for bytes. Notes status, alarms and banners."""
        self._buffer += self._read_bytes()
        *whole, self._buffer = self._buffer.split(b"\n")
        if whole:
            self._heard = time.monotonic()
        said = [line.strip().decode("ascii", "replace") for line in whole]
        for line in said:
            self._log_bytes("<", line.encode())
            self._notice_line(line)
        return [line for line in said if line]

    def is_silent(self):
        """True if nothing has come for longer than an answer may take."""
        return time.monotonic() - self._heard > self.timeout_s

    def _notice_line(self, line):
        """Take status, buffer sizes, ok, alarm or banner from a line."""
        if line.startswith("<") and line.endswith(">"):
            self.status = fields_of(line)
            self.answered_then = self.answered
            if re.fullmatch(r"\d+,\d+", buffers := self.status.get("Bf", "")):
                free = int(buffers.partition(",")[0])
                self.full = 1 - free / self.blocks if self.blocks >= max(free, 1) else None
        elif found := _OPTIONS.fullmatch(line):
            self.blocks, self.window = int(found[1]), max(RX_BYTES, int(found[2]))
        elif line == "ok":
            self.answered += 1
        elif line.startswith("ALARM:"):
            self.alarm = int(line[6:])
        elif line.startswith("Grbl "):
            self.banners += 1

    def _log_bytes(self, arrow, data):
        """Write a line to the log, if there is one: the time to the millisecond, `arrow` and the bytes as Python shows them."""
        if self._log:
            now = time.time()
            clock = time.strftime("%H:%M:%S", time.localtime(now)) + f".{int(now * 1000) % 1000:03d}"
            self._log.write(f"{clock} {arrow} {data!r}\n")

    # --- lines

    def connect(self):
        """Reset the controller, if its machine stands, and wait for its banner. Raises LinkError if the answer is missing or not grbl's; Refused if
        the machine is at work."""
        self.be_sure_it_stands()
        self.reset()
        return self

    def be_sure_it_stands(self):
        """Ask for the state, and change nothing. Raises LinkError, and Refused if the machine moves, holds or runs a job."""
        fields = {}
        for _again in range(_REPORTS):
            fields = {**fields, **self._first_status()}
            if "Ov" in fields:  # which comes now and then; the report that has it names a stored job
                break
        job = fields.get("SD")
        state = fields["state"]
        if job:
            share, _comma, name = job.partition(",")
            raise Refused("{}: the stored job {} is running, {} % of it read. Let it end, or stop it first", self.port, name.rstrip("?"), share)
        if state.partition(":")[0] not in _STANDING:
            raise Refused("{}: the machine is at work ({}) for somebody else. Let it end, or stop it first", self.port, state)

    def _first_status(self):
        """Ask for a report until one comes, and return its fields. The board may just be starting, or hold the beginning of another program's line.
        Raises LinkError after `timeout_s`."""
        self.status = {}
        said = []
        deadline = time.monotonic() + self.timeout_s
        asked = 0.0
        while not self.status:
            now = time.monotonic()
            if now > deadline:
                if said:
                    raise LinkError("{}: no grbl answers there, but {!r}", self.port, said[0])
                raise LinkError("{}: no grbl answers there", self.port)
            if now - asked >= _SIGN_S:
                asked = now
                self.real_time(b"?")
            said += self.read_lines()
        return self.status

    def reset(self):
        """Send Ctrl-X and wait for the banner. Raises LinkError if none comes within `timeout_s`."""
        before = self.banners
        self.real_time(RESET)
        deadline = time.monotonic() + self.timeout_s
        said = []
        while self.banners == before:
            said += self.read_lines()
            if time.monotonic() > deadline:
                if said:
                    raise LinkError("{}: no grbl answers there, but {!r}", self.port, said[0])
                raise LinkError("{}: no grbl answers there", self.port)
        deadline = time.monotonic() + 0.2
        while time.monotonic() < deadline:
            self.read_lines()
        self.alarm = None

    def command(self, line, timeout_s=None):
        """Send one line; returns the lines before its ok. Raises Refused, also if an alarm comes before the ok, or LinkError
        after `timeout_s`. A board that minds its host hears `?` as long as it takes."""
        self.alarm = None
        self.sent = None
        self._send_line(line.encode())
        asked = time.monotonic()
        deadline = asked + (timeout_s or self.timeout_s)
        said = []
        while (now := time.monotonic()) < deadline:
            if now - asked >= _SIGN_S:
                asked = now
                self.real_time(b"?")
            heard = [answer for answer in self.read_lines() if not answer.startswith("<")]
            for at, answer in enumerate(heard):
                if answer == "ok" and self.alarm is None:
                    self.rest = heard[at + 1 :]
                    return said
                if answer == "ok" or answer.startswith("error:"):
                    if self.alarm is not None:
                        raise Refused("{}: alarm {}: {}", line, self.alarm, alarm_text(self.alarm))
                    raise Refused("{}: {}", line, explain_error(answer, line.encode()), number=int(answer.partition(":")[2] or 0))
                said.append(answer)
        raise LinkError("{}: no answer to {!r}", self.port, line)

    def _send_line(self, line):
        """Send a line. Raises Refused: bytes beyond ASCII are real-time commands to the board."""
        if not line.isascii():
            raise Refused("{}: only ASCII can be sent", line.decode("utf-8", "backslashreplace"))
        self._write_bytes(line + b"\n")

    ask = command  # as the clients of all languages have it

    def home(self):
        """Home the machine and wait until it is done, HOME_S at most. Raises Refused or LinkError."""
        self.command("$H", HOME_S)

    def ask_status(self):
        """Ask for a report, and return its fields. Raises LinkError after `timeout_s`."""
        self.status = {}
        self.real_time(b"?")
        deadline = time.monotonic() + self.timeout_s
        while not self.status:
            self.read_lines()
            if time.monotonic() > deadline:
                raise LinkError("{}: no status report", self.port)
        return self.status

    def stream(self, lines, count=True, idle=None, numbered=False, origin=line_text):
        """Send [(number, bytes)]; yields each number as its line is answered.

        `count`: keep as many bytes under way as the board takes, 900 in frames; otherwise each line waits for the answer to the previous
        one. Calls `idle()` while waiting. `numbered`: add N words, so that `Ln` of a status report names the line being executed. At the first
        error holds the machine, drops what is under way and raises Refused; `origin(number)` is what it calls a line.
        """
        waiting = [(number, line, number_line(number, line) if numbered else line) for number, line in reversed(lines)]
        under_way = []
        self.alarm = None
        self.answered = self.answered_then = 0
        self.sent = 0
        while waiting or under_way:
            while waiting and self._has_room(under_way, waiting[-1][-1], count):
                under_way.append(waiting.pop())
                self._send_line(under_way[-1][-1])
                self.sent += 1
            for answer in self.read_lines():
                number, line = under_way[0][:2] if under_way else (None, b"")
                where = f"{origin(number)}, {line.decode('ascii', 'replace')}" if under_way else _("after the last line")
                if answer.startswith("ALARM:"):
                    raise Refused("{}: alarm {}: {}", where, self.alarm, alarm_text(self.alarm), number=number)
                if answer.startswith("error:") and under_way:
                    self.halt()
                    raise Refused("{}: {}", where, explain_error(answer, line), number=number)
                if answer.startswith("Grbl "):
                    raise LinkError("{}: the controller was reset", where)
                if answer == "ok" and under_way:
                    yield under_way.pop(0)[0]
            if self.foreign_ok():
                self._end_foreign(origin(under_way[0][0]) if under_way else _("after the last line"))
            if idle:
                idle()

    def foreign_ok(self):
        """True if more lines of stream() have been answered than sent: another program speaks to the board by the same port."""
        return self.sent is not None and self.answered > self.sent

    def _end_foreign(self, where):
        self.halt()
        raise Refused("{}: one ok too many: another program sends lines to {}, too; the job has been stopped. Close that program", where, self.port)

    def _has_room(self, under_way, line, count):
        """Return True if `line` may go beside the lines under way: with `count` while their bytes fit the board's buffer, else only when all are
        answered."""
        if not count:
            return not under_way
        known = sum(len(sent) + 1 for _, _, sent in under_way)
        return not known or known + len(line) + 1 <= (_FRAMED_BYTES if self.framed else self.window)

    def halt(self):
        """Hold the machine on its path, wait until it stands, and reset the controller, which drops all queued lines and keeps the position."""
        self.real_time(b"!")
        deadline = time.monotonic() + self.timeout_s
        while time.monotonic() < deadline and self.ask_status()["state"] not in ("Hold:0", "Idle", "Alarm", "Check"):
            time.sleep(0.05)
        self.reset()

    def wait_idle(self, idle=None):
        """Wait until the machine stands; calls `idle()` meanwhile. Raises Refused in an alarm, or if another program speaks on the port."""
        while self.ask_status()["state"] not in ("Idle", "Check", "Sleep"):
            if self.alarm is not None or self.status["state"] == "Alarm":
                raise Refused("alarm {}: {}", self.alarm, alarm_text(self.alarm or 0))
            if idle:
                idle()
            if self.foreign_ok():
                self._end_foreign(_("after the last line"))
            time.sleep(0.1)
        if self.foreign_ok():
            self._end_foreign(_("after the last line"))


def alarm_text(number):
    """The meaning of grbl's ALARM:`number`, in one line."""
    return error_text(200 + number)
