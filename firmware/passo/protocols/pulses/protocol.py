"""The language of LPTControl (2009): files of one-letter pulse codes (codes.py), and the control commands around them.

Control commands stand in braces, which are no codes, and may come at any moment, between the bytes of a file too:

    {load} {load 1234}     a file follows, of so many bytes: it is checked and kept, nothing moves
    {stream} {stream 1234} a file follows and is played as it comes
    {end}                  that was the file
    {run} {run 5} {back} {pause} {stop} {step} {step back}
    {return} {return back} {continue} {continue back}    after manual moves: the way they came, or from here
    {repeat 5} {speed 1200} {jog x 100 y -50} {tool on} {drives off} {home} {unlock} {link} {?} {log}
    {$F} {$JR} …           lines that options add, such as stored jobs and the journal: see protocols/words.py
    {motors on}            where relays choose between this board and another controller

With the drives off the steps of a file go out all the same, as from a parallel port, and no motor has current: a dry run,
after which the machine has to be homed again. Backward, a file that has a [ runs with the drives on. A move by hand switches
them on, unless the operator has switched them off.

Codes outside a file are streamed, too, until the line is quiet. Answers are lines:

    ok                     done, or begun; after {end} `ok N`: so many commands
    error:120              refused; of a file `error:120 line 3 column 7`, and nothing of it is left
    end   start   speed    the file has been played, or played back to its start; the operator's speed is wanted
    oldest                 played back as far as is remembered of what was streamed, which is not its start
    <…>                    to {?}: see report.py
    log:12345,101,pc       to {log}: an event's milliseconds, number and origin, a line each; then ok
    ready   alarm:201   stopped     by another link, for one

Flow control: a host has at most WINDOW bytes of a file under way. For every CREDIT of them that the board has taken in
it sends one byte ACK, which is in no line. Bytes of control commands count for nothing.

    pulses = Pulses("xyz", board["step_program"])
    for command in pulses.feed(serial.read(), now_ms): …
    frame("speed", 1200)        # b"{speed 1200}"
"""

import micropython
from micropython import const

from passo import errors
from passo.commands import ACCEPTED, ALARM, BAD, DROPPED, FINISHED, NOTICE, RESTARTED, STATUS, STOP, Command
from passo.options.step_program.commands import (
    STEPS_ABORT, STEPS_ASK, STEPS_CLOSE, STEPS_ITEMS, STEPS_OPEN, STEPS_SPEED, STEPS_WAIT, STEP_PROGRAM, STEP_PROGRAM_ADD,
)  # fmt: skip
from passo.options.step_program.errors import NO_STEP_PROGRAM
from passo.protocols.pulses.codes import CODES, MARKS, SPEED_MM_MIN, WAIT_MS
from passo.protocols.pulses.control import whole_number, parse_control
from passo.protocols.pulses.errors import CUT_OFF, NO_CODE, NO_CONTROL, NUMBER_MISSING
from passo.protocols.pulses.report import log_lines, status
from passo.records import COUNT_MASK

WINDOW = const(512)
CREDIT = const(64)
ACK = b"\x06"
QUIET_MS = const(1000)  # ends what was typed without {stream}
CUT_MS = const(5000)  # a file that stops coming is cut off
_LONGEST_COMMAND = const(80)  # of a control command

_BLANKS = b" \t\r\n"

# The modes for the bytes of files.
_TYPED = const(0)  # no {load} or {stream} has come
_LOAD = const(1)
_STREAM = const(2)
_DROP = const(3)  # after an error, until the next control command or a quiet line
_SHUT = const(4)  # the same of a file that {load} or {stream} has begun: until its {end}, or {stop}, however long the line is quiet


def frame(*words):
    """Return the bytes of a control command."""
    return ("{" + " ".join([str(word) for word in words]) + "}").encode()


class Pulses:
    stored = None  # as Grbl's

    def __init__(self, axes, config):
        """`axes`: their names, at most three count; `config`: the section `step_program` of the board file."""
        self.words = None  # Words, if options add some
        self._axes = axes[:3]
        self._config = config
        self._known = (1 << len(self._axes)) - 1
        self._mode = _TYPED
        self._frame = None  # the bytes of a control command so far
        self._latest = 0
        self._open = False  # STEPS_OPEN has gone out, STEPS_CLOSE not yet
        self._begin_file(0)

    def _begin_file(self, size, fresh=False):
        """Begin a new file, of `size` bytes (0: not known). `fresh`: no byte of it has come."""
        self._size = size
        self._fresh = fresh  # no byte of it has come
        self._count = 0  # bytes of it so far
        self._line = self._column = 1
        self._items = []
        self._taken = 0  # bytes since the last STEPS_ITEMS
        self._under_way = 0  # bytes handed on and not answered
        self._credit = 0
        self._sign = 0  # the * or + whose number is coming
        self._number = -1
        self._sign_at = (1, 1)

    # --- bytes to commands

    def feed(self, data, now_ms):
        """Return the commands in `data`, which may be empty: time alone ends what was typed, and finds files cut off."""
        found = []
        if data:
            self._latest = now_ms
            at = 0
            while at < len(data):
                if self._frame is not None:
                    at = self._read_control(data, at, found)
                elif data[at] == 0x7B:
                    self._frame = b""
                    at += 1
                elif data[at] == 0x3F and self._mode == _TYPED and not self._open and not self._items:
                    found.append(Command(STATUS))  # as {?}, but of a host that does not know the language yet
                    at += 1
                else:
                    at = self._read_codes(data, at, found)
            self._hand_on(found)
        else:
            silent_ms = (now_ms - self._latest) & COUNT_MASK
            if silent_ms >= QUIET_MS:
                self._after_silence(silent_ms, found)
        return found

    def _after_silence(self, silent_ms, found):
        """End what was typed, or a file that has been cut off, after a silence."""
        if self._frame is not None:
            self._frame = None
            found.append(Command(BAD, error=NO_CONTROL))
        elif self._mode == _DROP:
            self._mode = _TYPED
        elif self._mode == _TYPED:
            if self._open:
                self._close_file(found)
        elif (self._mode == _LOAD or self._size) and silent_ms >= CUT_MS and not self._under_way:
            self._fail_file(CUT_OFF, found)  # the host may send, and does not

    def _read_codes(self, data, at, found):
        """Read bytes of a file, up to the next control command. Returns where it stopped."""
        if self._fresh:
            at = self._line_end(data, at)
        while at < len(data):
            if not self._sign and self._mode < _DROP:
                at = self._read_plain(data, at)
                if self._taken >= CREDIT:
                    self._hand_on(found)
                    continue
                if at == len(data):
                    break
            byte = data[at]
            if byte == 0x7B:
                return at
            at += 1
            if self._mode >= _DROP:
                continue
            self._count += 1
            self._taken += 1
            self._read_other(byte, found)
            if self._taken >= CREDIT:
                self._hand_on(found)
        return at

    @micropython.native
    def _read_plain(self, data, at):
        """Read codes as far as nothing else comes, until a CREDIT is full. Returns where it stopped."""
        codes = CODES
        unknown = 7 & ~self._known
        items = self._items
        last = items[-1] if items else 0
        begun = at
        end = min(at + CREDIT - self._taken, len(data))
        while at < end:
            code = data[at] - 65
            if code < 0 or code > 25:
                break
            item = codes[code]
            if item & unknown:
                break
            if last & 255 == item:
                last += 256
                items[-1] = last
            else:
                last = item + 256
                items.append(last)
            at += 1
        self._count += at - begun
        self._taken += at - begun
        self._column += at - begun
        return at

    def _line_end(self, data, at):
        """Skip the line end behind {load}, which is none of the file. Returns where the file begins."""
        while at < len(data) and self._fresh and data[at] in b"\r\n":
            self._fresh = data[at] == 13
            at += 1
        self._fresh = self._fresh and at == len(data)
        return at

    def _read_other(self, byte, found):
        """Read a byte that is no code, or stands behind a number."""
        if self._sign:
            if 48 <= byte <= 57:
                self._number = max(self._number, 0) * 10 + byte - 48
                if self._number > (WAIT_MS if self._sign == 0x2A else SPEED_MM_MIN)[1]:
                    self._line, self._column = self._sign_at
                    self._fail_file(errors.NUMBER_RANGE, found)
                self._column += 1
                return
            if not self._end_number(found):
                return
        item = CODES[byte - 65] if 65 <= byte <= 90 else 0
        if item and not item & 7 & ~self._known:
            self._items.append(256 | item)
        elif byte == 0x2A or byte == 0x2B:
            self._sign = byte
            self._number = -1
            self._sign_at = (self._line, self._column)
        elif byte in MARKS:
            self._items.append(MARKS[byte])
        elif byte == 10:
            self._line += 1
            self._column = 0
            if not self._open and not self._items:
                self._begin_file(0)
        elif byte not in _BLANKS:
            self._fail_file(NO_CODE, found)
            return
        self._column += 1

    def _end_number(self, found):
        """End the number behind * or +, if there is a sign. Returns False if the number is missing."""
        if not self._sign:
            return True
        if self._number < 0:
            self._line, self._column = self._sign_at
            self._fail_file(NUMBER_MISSING, found)
            return False
        kind = STEPS_WAIT if self._sign == 0x2A else STEPS_SPEED if self._number else STEPS_ASK
        self._items.append(self._number << 8 | kind << 4)
        self._sign = 0
        return True

    def _hand_on(self, found):
        """Make a command of the items collected so far."""
        if not self._items and self._taken < CREDIT or self._mode >= _DROP:
            return
        self._open_typed(found)
        command = Command(STEP_PROGRAM_ADD, self._items, STEPS_ITEMS)
        command.power = self._taken
        self._under_way += self._taken
        self._items = []
        self._taken = 0
        found.append(command)

    def _open_typed(self, found):
        """Open a step program for codes that were typed without {stream}."""
        if not self._open:
            self._open = True
            found.append(Command(STEP_PROGRAM_ADD, None, STEPS_OPEN, True))

    def _fail_file(self, error, found):
        """Refuse the rest of the file, and have the program forgotten."""
        self._open_typed(found)
        self._drop_file()
        self._items = []
        self._sign = 0
        found.append(Command(STEP_PROGRAM_ADD, (self._line, self._column), STEPS_ABORT, error=error))

    def _drop_file(self):
        """Drop the rest of the file, which is still coming."""
        self._mode = _DROP if self._mode == _TYPED or self._mode == _DROP else _SHUT
        self._open = False
        self._size = 0

    def _close_file(self, found):
        """Close the file, if its last number and its length are right."""
        if not self._end_number(found):
            return
        if self._size and self._count != self._size:
            self._fail_file(CUT_OFF, found)
            return
        self._hand_on(found)
        self._open = False
        command = Command(STEP_PROGRAM_ADD, None, STEPS_CLOSE)
        command.tool = self._mode == _TYPED  # nobody asked: there is no answer
        self._mode = _TYPED
        self._begin_file(0)
        found.append(command)

    # --- control commands

    def _read_control(self, data, at, found):
        """Read a control command up to its brace. Returns where it stopped."""
        text = bytes(data[at:])
        end = text.find(b"}")
        if end < 0:
            self._frame = (self._frame + text)[: _LONGEST_COMMAND + 1]
            return len(data)
        text = self._frame + text[:end]
        self._frame = None
        try:
            words = text.decode().split() if len(text) <= _LONGEST_COMMAND else []
        except UnicodeError:
            words = []
        command = self._control_command(words, found)
        if command is not None:
            found.append(command)
        return at + end + 1

    def _control_command(self, words, found):
        """Return the Command of a control command's words; None if it has been dealt with."""
        verb = words[0] if words else ""
        if verb in ("load", "stream") and len(words) < 3:
            size = whole_number(words[1]) if len(words) == 2 else 0
            if size >= 0:
                return self._open_file(verb == "stream", size, found)
        elif verb == "end" and len(words) == 1:
            if self._mode not in (_LOAD, _STREAM):
                self._mode = min(self._mode, _DROP)
                return Command(BAD, error=NO_STEP_PROGRAM)
            self._close_file(found)
            return None
        command = self.words.line_command(verb) if self.words and verb[:1] == "$" else parse_control(words, self._axes)
        if command.kind == STOP:
            self._mode = _DROP
            self._open = False
            self._begin_file(0)
        return command

    def _open_file(self, stream, size, found):
        """Return the command of {load} or {stream}; a file under way is cut off."""
        if self._open:
            self._fail_file(CUT_OFF, found)
        self._begin_file(size, True)
        self._mode = _STREAM if stream else _LOAD
        self._open = True
        return Command(STEP_PROGRAM_ADD, None, STEPS_OPEN, stream)

    # --- events to bytes

    def reply(self, event):
        """Return the bytes that tell the host of `event`."""
        command = event.command
        said = self.words.event_bytes(event) if self.words else None
        if said is not None:
            return said
        if event.kind == FINISHED:
            return (event.value + "\n").encode() if command.kind in (STEP_PROGRAM, STEP_PROGRAM_ADD) else b"ok\n"
        if command.kind == STEP_PROGRAM_ADD:
            return self._reply_to_file(event, command)
        if event.kind != ACCEPTED:
            return b"error:%d\n" % event.error
        if command.kind == STATUS:
            return (log_lines(event.value["log"]) if command.value else status(event.value, self._config)).encode()
        return b"ok\n"

    def _reply_to_file(self, event, command):
        """Return the answer to a STEP_PROGRAM_ADD."""
        if event.kind == ACCEPTED:
            if command.value == STEPS_ITEMS:
                return self._credit_bytes(command.power)
            if command.value == STEPS_CLOSE:
                return b"" if command.tool else b"ok %d\n" % event.value
            return b"" if self._mode == _TYPED else b"ok\n"
        if command.value == STEPS_ABORT:
            return b"error:%d line %d column %d\n" % (event.error, command.target[0], command.target[1])
        silent = self._mode >= _DROP and command.value != STEPS_OPEN
        self._drop_file()
        return b"" if silent else b"error:%d\n" % event.error

    def _credit_bytes(self, count):
        """Return an ACK for each CREDIT of bytes that has been taken in, `count` more."""
        self._under_way -= count
        acks, self._credit = divmod(self._credit + count, CREDIT)
        return ACK * acks

    def is_amid(self, text):
        """Return True if, behind `text`, a file or control command may have begun and not ended."""
        return bool(text.strip()) or self._mode != _TYPED or self._open or self._frame is not None or bool(self._items)

    def drop_begun(self):
        """Drop a control command that has come in part; a file that was dropped ends here."""
        self._frame = None
        self._mode = min(self._mode, _DROP)

    def drop(self, event):
        """Drop the bytes that have come so far."""
        if self._frame is not None:
            self._frame = b"!"  # makes no sense, however it ends
        if self._open:
            self._drop_file()
        self._begin_file(0)
        return b"stopped\n" if event.kind == DROPPED and event.error == errors.STOPPED else b""

    def push_bytes(self, event):
        """Return the bytes that the board sends unasked."""
        if event.kind == ALARM:
            return b"alarm:%d\n" % event.error
        if event.kind == NOTICE and self.words:
            return self.words.notice_bytes(event)
        return b"ready\n" if event.kind == RESTARTED else b""
