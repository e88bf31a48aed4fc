"""The torch manipulator's language of 2020: frames `code body 0xFF`, integers of four bytes, high byte first.

    torch = Torch(settings)
    for command in torch.feed(serial.read(), now_ms): …
    serial.write(torch.reply(event))

Each axis of a move runs at its own speed to its own target. Speeds are steps a second, their sign is the direction; counts are unsigned.
Only STOP and INFO are answered, by their own code and the signed steps of X and Y since the last move or jog; the board says FINISHED when
a move has ended, if it is asked to. A jog that is repeated while it runs goes on without a gap, as one jog, but asks for no more than the
board file's jog.ahead_ms in advance. A frame that comes while the machine moves, and is no repeated jog, stop or question, is dropped:
`dropped` counts it, and the event log has the reason.

An option teaches a frame by learn_frame(); OF_OPTIONS has the lengths of such frames, and without the option the board refuses them.
PASSO is an extension of the documents' table, `77 what value check 0xFF`: STATUS, UNLOCK, LINK, LOG, ADMIT, a jog's code for a number of
whole jogs as one, and LINE, a character of a line about settings (setting_lines.py, typed_words.py). Its answer comes in frames `77 24
count text 0xFF` of up to 13 bytes of text. The frames' cutting (frames.py) cannot see a frame that lost bytes and was filled up by those of
the next one, without a silence between them: there is no checksum. Counts and speeds out of reach are refused, which finds most of these.
"""

import struct

import micropython
from micropython import const

from passo import errors
from passo.commands import ACCEPTED, ADMIT, BAD, CONNECT, FINISHED, HAND_OVER, REFUSED, RESET, RUN, STATUS, STILL, STOP, UNLOCK, Command
from passo.options.independent.commands import AS_JOG, AT_REST, FOREVER, ZERO, Run
from passo.protocols.setting_lines import teach_lines
from passo.protocols.torch.frames import END, Cutter
from passo.protocols.typed_words import TypedWords

CODES = {
    "MOVE": 0xFE,
    "CONNECT": 0xEE,
    "STOP": 0xDD,
    "DISCONNECT": 0xCC,
    "INFO": 0xBB,
    "FINISHED": 0xAA,
    "CONFIGURE": 0x99,
    "ORIGIN": 0x88,
    "JOG_X+": 0xF9,
    "JOG_X-": 0xF7,
    "JOG_Y+": 0xF4,
    "JOG_Y-": 0xF1,
    "PASSO": 0x77,
}
_MOVE = const(0xFE)
_STOP = const(0xDD)
_INFO = const(0xBB)
_FINISHED = const(0xAA)
_CONFIGURE = const(0x99)
_PASSO = const(0x77)
_JOGS = {0xF9: (0, 1), 0xF7: (0, -1), 0xF4: (1, 1), 0xF1: (1, -1)}
_LENGTHS = {code: 2 for code in CODES.values()}
_LENGTHS.update({_MOVE: 18, _CONFIGURE: 18, _PASSO: 5})
OF_OPTIONS = {0x66: 41}  # lengths of the frames that options teach
_LENGTHS.update(OF_OPTIONS)
_SHORTER = {_CONFIGURE: 14}  # the length of the document's table: one jog for both axes
_MOVING = (0xF9, 0xF7, 0xF4, 0xF1, 0xEE, 0xCC, 0x88)  # two bytes that may not come about by a torn frame's end
ANSWER_LENGTHS = {_STOP: 10, _INFO: 10, _FINISHED: 2, _PASSO: 17}

STATUS_OF = const(0x3F)  # the question of the frame PASSO: `?`
UNLOCK_OF = const(0x75)  # leave an alarm: `u`
LOG_OF = const(0x6C)  # the event log: its newest entry but `value` of them: `l`
ADMIT_OF = const(0x68)  # for `value` minutes who sends no key may move it over the network: `h`
LINE_OF = const(0x24)  # `value` is the next character of a line about settings: `$`
LINK_OF = const(0x74)  # link `value` commands from now on, 0: this one: `t`
_CHECK = const(0x55)
_TEXT = const(13)  # bytes of text in an answer
_AXES = const(2)
STATES = ("idle", "run", "home", "jog", "alarm", "hold", "door", "check", "sleep")
_MASK = 0xFFFFFFFF


def integers(*values):
    """Return four bytes each, high byte first; negative ones as two's complement."""
    return struct.pack(">%dI" % len(values), *[value & _MASK for value in values])


# --- what a host sends


def frame(name, body=b""):
    """Return the frame of a name in CODES."""
    return bytes((CODES[name],)) + body + bytes((END,))


def move(x_steps, x_speed, y_steps, y_speed):
    """Return the frame of a move: counts 0 … 2³² − 1, speeds in steps/s with the direction as their sign."""
    return frame("MOVE", integers(x_steps, x_speed, y_steps, y_speed))


def configure(x_jog, y_jog, x_speed, y_speed):
    """Return the frame of CONFIGURE: steps of a jog, and default speeds in steps/s."""
    return frame("CONFIGURE", integers(x_jog, y_jog, x_speed, y_speed))


def passo(what, value=0):
    """Return the extension's frame; `what`: STATUS_OF, UNLOCK_OF, LINK_OF, LOG_OF, or the code of a jog; `value`: the number of jogs, 1 … 255."""
    return frame("PASSO", bytes((what, value, what ^ value ^ _CHECK)))


# --- what the board answers


def answer(name, x, y):
    """Return STOP's or INFO's answer."""
    return frame(name, integers(x, y))


def status_bytes(report, error, dropped):
    """Return PASSO STATUS's answer: `77` state error motors-are-ours X Y dropped `FF`; X and Y are signed positions."""
    position = report["position"]
    body = bytes((STATES.index(report["state"]), error, 1 if report["ours"] else 0))
    return frame("PASSO", body + integers(position[0], position[1], dropped))


def log_bytes(entries, back):
    """Return PASSO LOG's answer: `77 6C` number, how many entries are older, ms of the machine's clock, eight letters of its link or input, `FF`;
    zeros if there is none."""
    at = len(entries) - 1 - back
    ms, number, who = entries[at] if at >= 0 else (0, 0, "")
    name = (who or "").encode()[:8]
    return frame("PASSO", bytes((LOG_OF, number, max(at, 0))) + integers(ms) + name + bytes(8 - len(name)))


def text_bytes(text):
    """Return the frames of a text that answers a line."""
    frames = b""
    for at in range(0, len(text), _TEXT):
        part = text[at : at + _TEXT]
        frames += frame("PASSO", bytes((LINE_OF, len(part))) + part + bytes(_TEXT - len(part)))
    return frames


def answer_from(data):
    """Return (name, fields) of a whole answer: STOP and INFO have x and y, PASSO the fields of status_bytes(), TEXT a piece of the answer to a
    line."""
    names = {code: name for name, code in CODES.items()}
    name = names[data[0]]
    if name == "PASSO" and data[1] == LINE_OF:
        return "TEXT", {"text": bytes(data[3 : 3 + data[2]]).decode()}
    if name == "PASSO" and data[1] == LOG_OF:
        ms = struct.unpack_from(">I", data, 4)[0]
        return "LOG", {"number": data[2], "older": data[3], "ms": ms, "who": bytes(data[8:16]).decode().rstrip("\0")}
    if name == "PASSO":
        x, y, dropped = struct.unpack_from(">iiI", data, 4)
        return name, {
            "state": STATES[data[1]], "error": data[2], "ours": bool(data[3]), "x": x, "y": y, "dropped": dropped,
        }  # fmt: skip
    if len(data) < 10:
        return name, {}
    x, y = struct.unpack_from(">ii", data, 1)
    return name, {"x": x, "y": y}


def _one_jog(data):
    """Return the fields of the shorter CONFIGURE: its jog is of both axes."""
    jog, x_speed, y_speed = struct.unpack_from(">Iii", data, 1)
    return jog, jog, x_speed, y_speed


def answer_cutter(gap_ms=200):
    """Return a Cutter of a board's answers."""
    return Cutter(ANSWER_LENGTHS, gap_ms)


class Torch:
    binary = True  # 00 is a byte like others

    def __init__(self, settings, gap_ms=5, tell_end=False):
        """`settings`: of the machine: they have the jogs, which a host may configure; `gap_ms`: the silence that ends
        a torn frame; `tell_end`: say FINISHED when a move has ended."""
        self.dropped = 0  # frames refused and bytes that were no frame, since the start
        self.words = TypedWords()
        teach_lines(self.words)
        self._settings = settings
        self._version = -1  # of the settings that the jogs are of
        self._jogs = self._speeds = ()  # steps and steps/s of X and Y
        self._tell_end = tell_end
        self._cutter = Cutter(_LENGTHS, gap_ms, _SHORTER, _MOVING)
        self._error = 0  # the last number in the log that no STATUS has told
        self._asked = None  # a command whose answer decides what the frames behind it mean
        self._readers = {}  # of options' frames, by code, see learn_frame()

    def learn_frame(self, code, command_of):
        """Take an option's frame, whose code OF_OPTIONS has: command_of(frame) returns its Command."""
        self._readers[code] = command_of

    @micropython.native
    def feed(self, data, now_ms):
        """Return the commands in `data`, which may be empty: time alone ends frames."""
        self._cutter.put_bytes(data, now_ms)
        commands = []
        while self._asked is None:
            found = self._cutter.next_frame()
            if found is None:
                break
            command = self._frame_command(found)
            if command is not None:
                commands.append(command)
        return commands

    @micropython.native
    def _frame_command(self, data):
        """Return the Command of a frame; None if it asks for nothing."""
        if not data:
            return Command(BAD, error=errors.GARBLED)
        code = data[0]
        if code in _JOGS:
            return self._jog_command(*_JOGS[code])
        if code == _MOVE:
            return self._move_command(data)
        if code == _CONFIGURE:
            return self._configure_command(data)
        if code == _PASSO:
            return self._passo_command(data)
        if code in OF_OPTIONS:
            command_of = self._readers.get(code)
            return command_of(data) if command_of else Command(BAD, error=errors.UNKNOWN_COMMAND)
        return self._simple_command(code)

    def _simple_command(self, code):
        """Return the Command of a frame without a body."""
        if code == _STOP:
            return Command(STOP)
        if code == _INFO:
            return Command(STATUS, value=_INFO)
        if code == 0x88:
            return Command(ZERO)
        if code == _FINISHED:
            return None
        return Command(CONNECT, value=1 if code == 0xEE else 0)

    @micropython.native
    def _move_command(self, data):
        """Return the Run of a MOVE."""
        x, x_speed, y, y_speed = struct.unpack_from(">IiIi", data, 1)
        if x >= FOREVER or y >= FOREVER:
            return Command(BAD, error=errors.TRAVEL)
        steps = (x if x_speed > 0 else -x) if x else None, (y if y_speed > 0 else -y) if y else None
        return Run(steps, ((abs(x_speed), 1000), (abs(y_speed), 1000)), AT_REST)

    def _take_settings(self):
        """Take jogs and their speeds from the settings, if these have changed."""
        if self._version != self._settings.version:
            self._version = self._settings.version
            self._jogs = tuple([self._settings.jog_steps(axis) for axis in range(_AXES)])
            self._speeds = tuple([self._settings.jog_steps_s(axis) for axis in range(_AXES)])

    def _jog_command(self, axis, sign, times=1):
        """Return the Run of a jog, `times` jogs long."""
        self._take_settings()
        steps = [None, None]
        steps[axis] = sign * self._jogs[axis] * times or None
        if self._jogs[axis] * times >= FOREVER:
            return Command(BAD, error=errors.TRAVEL)
        return Run(steps, [(speed, 1000) for speed in self._speeds], AS_JOG)

    def _configure_command(self, data):
        """Return the Command that keeps new jogs; its answer comes before the next frame is read."""
        x_jog, y_jog, x_speed, y_speed = struct.unpack_from(">IIii", data, 1) if len(data) == 18 else _one_jog(data)
        jogs = x_jog, y_jog
        if max(jogs) >= FOREVER:
            return Command(BAD, error=errors.TRAVEL)
        self._asked = Command(STILL)
        self._asked.value = jogs, (abs(x_speed), abs(y_speed))
        return self._asked

    def _passo_command(self, data):
        """Return the Command of Passo's own frame."""
        what, value = data[1], data[2]
        if data[3] != what ^ value ^ _CHECK:
            return Command(BAD, error=errors.GARBLED)
        if what == STATUS_OF:
            return Command(STATUS, value=_PASSO)
        if what == UNLOCK_OF:
            return Command(RESET if value else UNLOCK)
        if what == LINK_OF:
            return Command(HAND_OVER, value=value)
        if what == LINE_OF:
            return self.words.take_byte(value) if self.words.takes_byte(value) else Command(BAD, error=errors.GARBLED)
        if what == ADMIT_OF:
            return Command(ADMIT, value=value)
        if what == LOG_OF:
            command = Command(STATUS, value=LOG_OF)
            command.power = value
            return command
        if what in _JOGS:
            return self._jog_command(*_JOGS[what], value)
        return Command(BAD, error=errors.UNKNOWN_COMMAND)

    def reply(self, event):
        """Return the bytes that tell the host of `event`; b"" if the language has no word for it."""
        command = event.command
        if event.kind == REFUSED:
            self.dropped = (self.dropped + 1) & 0x1FFFFFFF
        if command is self._asked:
            self._asked = None
            if event.kind == ACCEPTED:
                self._keep_configured(*command.value)
        said = self.words.event_bytes(event)
        if said is not None:
            return text_bytes(said)
        if event.kind == FINISHED:
            return self._end_bytes(command, event.value)
        if event.kind == ACCEPTED and command.kind == STATUS and command.value == LOG_OF:
            self._error = event.value["error"] or self._error
            return log_bytes(event.value["log"].entries, command.power)
        if event.kind == ACCEPTED and command.kind == STATUS:
            return self._info_bytes(command.value == _PASSO, event.value)
        return b""

    def _keep_configured(self, jogs, speeds):
        """Let these jogs and speeds count, to the step, whatever the settings have kept of them."""
        self._jogs, self._speeds = jogs, speeds
        self._version = self._settings.version

    def _info_bytes(self, all, report):
        """Return the answer to INFO, or with `all` to PASSO STATUS."""
        error = report["error"] or self._error
        self._error = 0 if all else error
        return status_bytes(report, error, self.dropped) if all else answer("INFO", *report["made"][:2])

    def _end_bytes(self, command, value):
        """Return the bytes that tell of the end of a stop or a move."""
        if command.kind == STOP:
            return answer("STOP", *value["made"][:2])
        if command.kind == RUN and command.when == AT_REST and self._tell_end:
            return frame("FINISHED")
        return b""

    def push_bytes(self, event):
        """Return b"": the board says nothing else unasked."""
        return b""

    def drop(self, event):
        """Drop the bytes that have come so far."""
        self._cutter.drop()
        return b""
