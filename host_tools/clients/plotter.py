"""A client of the plotter's language: sends packets, waits for their answers, repeats packets that the line damaged.

    with PlotterClient("/dev/ttyACM0") as client:
        client.request()
        client.origin()
        client.point(False, 644, 314)       # MOVE
        client.point(True, 644, 454)        # LINE
        client.end(2)

If an answer is not the expected one, the client asks STATUS. Its answer comes after all older ones, so both sides are in step
again; and it tells a refusal, which has no answer in this language, from a lost packet. Only then the packet is sent again. A
repeated point adds a line of no length, which draws nothing. A jog is repeated only if the position shows that it did not
happen.
"""

import math
import time

from host_tools.clients import refusal
from host_tools.clients.serial_port import LinkError
from host_tools.clients.wire import ANSWER, RESEND, Wire, packet_name
from host_tools.language import error_text
from passo import errors
from passo.protocols.plotter import host as plotter

ATTEMPTS = 8  # of one packet
POLL_S = 1.0  # between two STATUS while something is drawn or homed
_STOP_S = 10.0  # the longest that a machine may take to come to rest

_WORDS_ATTEMPTS = 3
_REFUSE_NOTHING = (errors.CHECKSUM, errors.BYTES_DROPPED, errors.WORDS_LATE)  # logged, but no command was refused
_JOG_NAMES = ("UP", "LEFT", "DOWN", "RIGHT")


class Refused(LinkError):
    """The controller refused a packet, or is in alarm; `number` is that of the errors table."""

    def __init__(self, what, number, alarm):
        self.number = number
        if alarm:
            super().__init__("{} was refused: alarm {}, {}", what, number, error_text(number))
        else:
            super().__init__("{} was refused: error {}, {}", what, number, error_text(number))


class Cancelled(Exception):
    """`cancel()` was called while the client waited."""


class PlotterClient:
    """`timeout_s`: how long to wait for an answer before asking STATUS; more than the 2 s after which the controller drops a
    torn packet. Slow (emulated) boards need more."""

    def __init__(self, port, baud=57600, timeout_s=3.0, log=None):
        self.timeout_s = timeout_s
        self.packets = 0  # sent, repeats not counted
        self.resends = 0  # packets sent again, for whatever reason
        self.repeated_points = 0  # points sent again since the last END or STOP: some may be stored twice
        self._cancelled = False
        self._wire = Wire(port, baud, log)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._wire.close()

    def cancel(self):
        """Make the call that is waiting, or the next one, raise Cancelled. May be called from a signal handler."""
        self._cancelled = True

    def hello(self):
        """Raise LinkError if no controller answers, or something else does."""
        self._deliver_packet("REQUEST", "REQUEST_OK")

    def request(self):
        """hello(), then read the status, which clears an old error."""
        self.hello()
        return self.status()

    def speed(self, value):
        """Set the drawing speed, 1 … 65535 in the unit of the board file."""
        self._deliver_packet("SPEED", "SPEED_OK", value)

    def hand_over(self, number=0):
        """Hand the command to link `number` of the board file; 0: this one. Raises Refused while the machine moves."""
        self._deliver_packet("LINK", "LINK_OK", number)

    def point(self, pen_down, x, y):
        """Append a point (steps, 0 … 65535) to the object: LINE if the pen goes there down, else MOVE."""
        self._deliver_packet("LINE" if pen_down else "MOVE", "NEXT", x, y)

    def end(self, points=None, progress=None):
        """Draw the object and wait until it is drawn. `points`: their number; a lost answer is recognised by it. Calls
        `progress(status)` about once a second."""

        def has_drawn(status):
            return points is not None and status["drawn"] >= points

        self._perform_packet("END", "DONE", has_drawn, progress)

    def origin(self, progress=None):
        """Home the machine and wait until it stands at 0;0."""
        self._perform_packet("ORIGIN", "ORIGIN_OK", lambda status: False, progress)

    home = origin  # as the clients of all languages have it

    def jog(self, name):
        """Make one jog; `name`: UP, LEFT, DOWN or RIGHT. Raises Refused, LinkError, or ValueError for another name."""
        if name not in _JOG_NAMES:
            raise ValueError(name)
        before = self.status()
        for attempt in range(ATTEMPTS):
            self._send_named(name, repeat=attempt > 0)
            answer = self._await_answer(self.timeout_s)
            if answer == ANSWER["NEXT"]:
                return
            status, seen = self._ask_status(name)
            moved = status["state"] == "jog" or (status["x"], status["y"]) != (before["x"], before["y"])
            if ANSWER["NEXT"] in seen or moved:
                return
            self._check_status(status, name)
            if answer != RESEND:
                raise LinkError("{} was not answered and has not moved the machine; it is not sent twice", name)
        raise LinkError("{} was asked for again {} times: the line is too noisy", name, ATTEMPTS)

    def ask(self, line, timeout_s=None):
        """Send a line about settings, stored jobs or the journal, `$100`, `$F` or `$JR`; returns the lines before its ok. Raises Refused of
        refusal.py, also if the controller has no such lines."""
        packets = plotter.words_packets(line)
        last = len(packets) - 1
        for number, words in enumerate(packets):
            said = None
            for attempt in range(_WORDS_ATTEMPTS):
                self._send_packet(words, repeat=attempt > 0)
                said = self._wire.next_text((timeout_s if number == last else None) or self.timeout_s)
                if said is not None and said[:1] != bytes((RESEND,)):
                    break
            else:
                self._ask_status("WORDS")  # which clears the error
                raise refusal.Refused("{}: the controller does not understand it", line, number=errors.STATEMENT)
            if number < last and said[:1] != bytes((ANSWER["REQUEST_OK"],)):
                raise LinkError("{} was cut off: the line is too noisy", line)
        *told, answer = said.decode("ascii", "replace").splitlines()
        if answer != "ok":
            number = int(answer[6:] or 0) if answer[:6] == "error:" else None
            self.status()  # clears the error, else the next packet would seem to be refused
            raise refusal.Refused("{}: {}", line, refusal.explain_error(answer), number=number)
        return told

    def status(self):
        """Ask STATUS, and return its fields, a dict. Reading clears the controller's error. Raises LinkError."""
        return self._ask_status("STATUS")[0]

    def stop(self):
        """Stop the machine: pen up, object dropped. Returns the status once it stands still. Never raises Cancelled."""
        self._cancelled = False
        deadline = time.monotonic() + _STOP_S + self.timeout_s
        repeat = False
        while time.monotonic() < deadline:
            self._send_named("STOP", repeat=repeat)
            repeat = True
            answer = self._await_answer(self.timeout_s)
            while answer not in (None, RESEND, ANSWER["DONE"]):
                answer = self._await_answer(self.timeout_s)
            status, seen = self._ask_status("STOP", answer)
            if ANSWER["DONE"] in [answer] + seen and status["state"] in ("idle", "alarm"):
                return status
        raise LinkError("the machine does not stop: switch it off")

    def send_raw(self, data):
        """Send `data` as it is; returns the events received until the line is quiet. If the data end with a packet that takes
        time (END, ORIGIN), waits for its answer without limit."""
        self.packets += 1
        self._wire.send(data)
        patient = packet_name(data[-plotter.PACKET :]) in ("END", "ORIGIN")
        events = [self._next_event(math.inf if patient else self.timeout_s)]
        while events[-1][0]:
            events.append(self._next_event(0.3))
        return events[:-1]

    def _deliver_packet(self, name, expected_name, x=0, y=0):
        """Send a packet that is answered at once; repeat it until it is answered."""
        expected = ANSWER[expected_name]
        self._send_named(name, x, y)
        answer = self._await_answer(self.timeout_s)
        for attempt in range(ATTEMPTS):
            if answer == expected:
                if attempt:
                    self._ask_status(name)
                return
            status, seen = self._ask_status(name, answer)
            while expected not in seen and self._holds_back(name, status):
                answer = self._await_answer(POLL_S)
                status, seen = self._ask_status(name, answer)
                seen.append(answer)
            if expected in seen:
                return
            if name != "REQUEST":
                self._check_status(status, name)
            self._send_named(name, x, y, repeat=True)
            answer = self._await_answer(self.timeout_s)
        raise LinkError("{} was not understood in {} attempts: the line is too noisy", name, ATTEMPTS)

    def _holds_back(self, name, status):
        """True while the controller holds NEXT back because its memory is full: it draws, and will have room again."""
        return name in ("LINE", "MOVE") and status["free"] == 0 and status["state"] != "alarm"

    def _perform_packet(self, name, expected_name, finished, progress):
        """Send a packet that is answered once it has been carried out, and wait for the answer. `finished(status)`: True if it has been carried out,
        though its answer got lost. Raises Refused or LinkError."""
        expected = ANSWER[expected_name]
        self._send_named(name)
        idle = attempts = 0
        while True:
            answer = self._await_answer(POLL_S)
            if answer == expected:
                return
            status, seen = self._ask_status(name, answer)
            if expected in seen:
                return
            self._check_status(status, name)
            if progress:
                progress(status)
            idle = idle + 1 if status["state"] == "idle" else 0
            if idle > 1 and finished(status):
                return
            if idle > 1 or (idle and answer == RESEND):
                attempts += 1
                if attempts == ATTEMPTS:
                    raise LinkError("{} was not carried out in {} attempts: the line is too noisy", name, ATTEMPTS)
                self._send_named(name, repeat=True)
                idle = 0

    def _check_status(self, status, what):
        """Raise Refused if the status tells of an alarm or of a refusal."""
        number = status["error"]
        alarm = status["state"] == "alarm"
        if alarm or (number and number not in _REFUSE_NOTHING):
            raise Refused(what, number, alarm)

    def _send_named(self, name, x=0, y=0, repeat=False):
        """Send the packet of command `name` with its two numbers, 0 … 65535."""
        self.repeated_points += repeat and name in ("LINE", "MOVE")
        self._send_packet(plotter.packet(plotter.COMMANDS[name], x, y), repeat)

    def _send_packet(self, data, repeat):
        """Send a packet, and count it in `resends` if it is a repeat, else in `packets`."""
        if repeat:
            self.resends += 1
        else:
            self.packets += 1
        self._wire.send(data)

    def _await_answer(self, timeout_s):
        """The next one-byte answer, or None after `timeout_s`. Skips a late STATUS."""
        deadline = time.monotonic() + timeout_s
        while True:
            kind, value = self._next_event(max(0.0, deadline - time.monotonic()))
            if kind is None:
                return None
            if kind == "answer":
                return value

    def _ask_status(self, name, heard=None):
        """Ask STATUS until it is answered. Returns it and the one-byte answers that came before it."""
        seen = []
        for _ in range(ATTEMPTS // 2):
            self._wire.send(plotter.packet(plotter.COMMANDS["STATUS"]))
            deadline = time.monotonic() + self.timeout_s
            while True:
                kind, value = self._next_event(max(0.0, deadline - time.monotonic()))
                if kind == "status":
                    return value, seen
                if kind == "answer":
                    heard = value
                    seen.append(value)
                if kind != "answer" or value == RESEND or value not in plotter.ANSWERS:
                    break
        if heard is None:
            raise LinkError("no answer to {} on {}: is the controller on, and the baud right?", name, self._wire.port)
        if heard not in plotter.ANSWERS:
            raise LinkError("{} answers, but not in the plotter's language (byte {:#04x})", self._wire.port, heard)
        raise LinkError("the controller on {} answers {} but not STATUS", self._wire.port, plotter.ANSWERS[heard])

    def _next_event(self, timeout_s):
        """The next event of the wire, waited for in slices of 0.2 s so that cancel() is noticed. Raises Cancelled."""
        deadline = time.monotonic() + timeout_s
        while True:
            if self._cancelled:
                self._cancelled = False
                raise Cancelled
            left = deadline - time.monotonic()
            event = self._wire.next_event(max(0.0, min(left, 0.2)))
            if event[0] or left <= 0.2:
                return event
