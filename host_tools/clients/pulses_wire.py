"""The control commands of the pulses language under way on one wire, and the flow of a file beside them.

    wire = PulsesWire(write, "xyz", machine)
    wire.send_command(command)                  # machine.take_answer(event) follows
    wire.send_control(("load", 100), answered)       # True if it was sent; answered(error) follows, 0: ok
    wire.feed(data, now_ms)                     # machine.report(dict) of each status, machine.take_line(line) of lines that are no answer

A board answers control commands in order. Errors of a file come between them, with their line and column or without a command that waits: those go
to take_line(), and never take the place of an answer. {end} is the exception: a board may or may not answer it after a file has failed; the next status
shows that.
"""

from micropython import const

from host_tools.clients.grbl_wire import LOST, whole_lines
from host_tools.clients.answers import setting_line
from passo import commands
from passo.commands import ACCEPTED, REFUSED, STATUS_WORDS, Event
from passo.options.step_program.commands import (
    STEPS_CONTINUE, STEPS_GO, STEPS_HAND_DRIVES, STEPS_HAND_TOOL, STEPS_JOG, STEPS_PACE, STEPS_RETURN, STEPS_STEP, STEP_PROGRAM,
)  # fmt: skip
from passo.protocols.pulses.protocol import ACK, CREDIT, WINDOW, frame
from passo.protocols.pulses.report import status_from

END = ("end",)
_ASK = ("?",)
_MOST = const(8)  # commands under way
_WORDS = {commands.STOP: ("stop",), commands.HOLD: ("pause",), commands.HOME: ("home",), commands.UNLOCK: ("unlock",), commands.HAND_OVER: ("link",)}
_VERBS = {STEPS_GO: "run", STEPS_STEP: "step", STEPS_RETURN: "return", STEPS_CONTINUE: "continue"}
_HANDS = {STEPS_HAND_TOOL: "tool", STEPS_HAND_DRIVES: "drives"}


def brace_in(data):
    """(line, column), from 1, of the first brace in a file, or None. A board carries out a control command wherever it comes, amid a file too: a file
    with one would home, unlock or set the machine."""
    at = data.find(b"{")
    if at < 0:
        return None
    return data.count(b"\n", 0, at) + 1, at - data.rfind(b"\n", 0, at)


def words_of(command, axes):
    """The words of LPTControl's control command for a Command, a tuple or list. `axes`: their letters, "xyz"."""
    if command.kind == commands.CONNECT:
        return "motors", "on" if command.value else "off"
    if command.kind == commands.SETTING:
        return (setting_line(command),)
    if command.kind != STEP_PROGRAM:
        return _WORDS[command.kind]
    what = command.value
    if what == STEPS_PACE:
        return "speed", command.feed
    if what in _HANDS:
        return _HANDS[what], "on" if command.tool else "off"
    if what == STEPS_JOG:
        words = ["jog"]
        for axis, steps in zip(axes, command.target):
            words += [axis, steps] * bool(steps)
        return words if len(words) > 1 else ("jog", axes[0], 0)
    if command.tool:
        return ("back",) if what == STEPS_GO else (_VERBS[what], "back")
    return (_VERBS[what],)


def report_of(fields):
    """The machine's report, a dict, of a status line's fields. Raises ValueError or KeyError."""
    report = {
        "state": fields["state"], "error": int(fields["error"]), "position": [int(part) for part in fields["place"].split(",")],
        "ours": fields.get("ours", "1") == "1", "fields": fields, "step_program": {
            "speed": round(float(fields["speed"]) * 10), "wait_ms": int(fields["wait"]), "tool": fields["tool"] == "1",
            "drives": fields["drives"] == "1", "port": int(fields["port"], 16), "manual": int(fields["manual"]), "asked": fields["ask"] == "1",
        },
    }  # fmt: skip
    for key, word in STATUS_WORDS:
        if word in fields:
            report[key] = fields[word]
    return report


class PulsesWire:
    def __init__(self, write, axes, machine):
        self._write = write
        self._axes = axes
        self._machine = machine
        self._under_way = []  # (words, answered)
        self._buffer = b""
        self._failed = False  # the file that is being sent has
        self._told = []  # lines about settings
        self.credit = 0  # bytes of a file that may be sent

    def waits_for(self, verb):
        """True if a command that begins with `verb` is not answered yet."""
        return bool([1 for words, _ in self._under_way if words[0] == verb])

    def can_take(self, command):
        """True if `command` can be sent now: fewer than _MOST are under way, or it is a STOP."""
        return len(self._under_way) < _MOST or command.kind == commands.STOP

    def send_command(self, command):
        """Send a command; the event ACCEPTED or REFUSED follows at the machine."""
        def tell_machine(error):
            told, self._told = self._told, []
            self._machine.take_answer(Event(REFUSED if error else ACCEPTED, command, error, told))

        self._send_words(words_of(command, self._axes), tell_machine)

    def ask_report(self):
        """Ask for the status."""
        self.send_control(_ASK, None)

    def send_control(self, words, answered):
        """Send a control command if fewer than _MOST are under way; answered(error) follows. Returns True if it was sent."""
        return len(self._under_way) < _MOST and self._send_words(words, answered)

    def _send_words(self, words, answered):
        self._under_way.append((words, answered))
        self._write(frame(*words))
        return True

    # --- a file

    def begin_file(self):
        """Begin to send a file, behind the answer to {load} or {stream}: WINDOW bytes may follow."""
        self.credit = WINDOW
        self._failed = False
        self._write(b"\n")

    def send(self, data):
        """Send bytes of the file, `credit` at most."""
        self.credit -= len(data)
        self._write(data)

    # --- answers

    def drop(self):
        """Give up the commands under way: their answer is LOST."""
        lost = self._under_way
        self._under_way = []
        self._buffer = b""
        for _, answered in lost:
            if answered:
                answered(LOST)

    note_silence = drop

    def feed(self, data, now_ms):
        """Take bytes of the board: each ACK gives CREDIT bytes more of a file, all else are lines."""
        data = bytes(data)
        acks = data.count(ACK)
        if acks:
            self.credit += acks * CREDIT
            data = data.replace(ACK, b"")
        lines, self._buffer = whole_lines(self._buffer + data)
        for line in lines:
            self._take_line(line)

    def _take_line(self, line):
        """Take a line of the board: status, setting, answer, or a line for the machine."""
        if line[:1] == "<":
            if self._failed and self._first_words() == END:
                self._under_way.pop(0)  # it was answered by the file's error
            if self._first_words() == _ASK:
                self._under_way.pop(0)
            try:
                report = report_of(status_from(line))
            except (ValueError, KeyError):
                return
            self._machine.report(report)
        elif line[:1] == "$" or line[:3] == "[$:":
            self._told.append(line)
        elif line == "ok" or line[:3] == "ok ":
            self._take_answer(0, line)
        elif line[:6] == "error:" and line[6:].isdigit() and not self._of_the_file():
            self._take_answer(int(line[6:]), line)
        else:
            if line[:6] == "error:":
                self._failed = True
            self._machine.take_line(line)

    def _first_words(self):
        return self._under_way[0][0] if self._under_way else None

    def _of_the_file(self):
        """True if an error is about the file: no command but a question waits for an answer."""
        return not [1 for words, _ in self._under_way if words != _ASK]

    def _take_answer(self, error, line):
        """Take the answer to the oldest command under way. `error` 0: ok; `line`: its text, because {end} behind a failed file answers later."""
        while True:
            waiting = [each for each in self._under_way if each[0] != _ASK]
            if not waiting:
                return
            words, answered = waiting[0]
            self._under_way.remove(waiting[0])
            if not (self._failed and words == END):
                if answered:
                    answered(error)
                return
            if line != "ok":
                return
