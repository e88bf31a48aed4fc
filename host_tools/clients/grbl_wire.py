"""The lines of the grbl language under way on one wire, for two who speak on it: the page, and a guest (a sender at the port that
`passo panel` offers).

    wire = Wire(write, heard, answered)
    wire.send_line(PAGE, b"$J=G91X1F100", answered)    # True if it was sent; answered(error) follows, 0: ok
    wire.send_command(Command(HOLD))             # answered(event) follows: of a reset once the board has begun anew
    wire.feed(data, now_ms)                      # heard(line, owner) of each line that is no answer

A controller answers each line once, in order: a list of the owners of lines leads each answer back.
"""

from micropython import const

from passo import commands
from passo.commands import ACCEPTED, REFUSED, Event
from passo.protocols.gcode.words import longest_line
from passo.protocols.grbl.lines import real_time

# Fields of every grbl's reports; others are words of commands.STATUS_WORDS, or of an option.
FIELDS = ("state", "MPos", "WPos", "WCO", "FS", "F", "Ov", "A", "Pn", "Ln", "Bf")
PAGE = const(0)
GUEST = const(1)
RX_ROOM = const(128)  # bytes of lines under way that every grbl has room for
_NUMBER = const(8)  # characters of an N word
_MOST_NUMBER = const(9_999_999)
_LONGEST = const(1024)  # bytes of a line from the board; more is noise
LOST = const(-1)  # answered(LOST): a reset has dropped the line
_BYTES = {commands.HOLD: 0x21, commands.RESUME: 0x7E, commands.JOG_CANCEL: 0x85, commands.RESET: 0x18}
_OVERRIDES = {}  # the byte of each: (which, percent, change)
for _byte in range(0x90, 0x9E):
    _command = real_time(_byte)
    if _command:
        _OVERRIDES[_command.value, _command.power, _command.feed] = _byte
_LINES = {commands.UNLOCK: b"$X", commands.HAND_OVER: b"$LINK=0"}


class Wire:
    def __init__(self, write, heard, answered=None):
        self.write = write
        self._heard = heard
        self._answered = answered
        self._resets = []  # commands that the banner answers
        self._under_way = []  # (owner, line, answered)
        self._bytes = 0
        self.foreign = 0  # answers to nobody here: another program sends lines by the same port
        self.window = RX_ROOM  # bytes of lines that may be under way
        self._buffer = b""

    def has_room(self, length):
        """True if a line of `length` bytes may be sent now."""
        return not self._under_way or self._bytes + length + 1 <= self.window

    def count_lines(self, owner):
        """The number of lines of `owner` under way."""
        return len([each for each in self._under_way if each[0] == owner])

    def send_line(self, owner, line, answered=None):
        """Send a line without its end, if there is room."""
        if not self.has_room(len(line)):
            return False
        self._under_way.append((owner, line, answered))
        self._bytes += len(line) + 1
        self.write(line + b"\n")
        return True

    # --- commands of a page

    def can_take(self, command):
        """True if `command` can be sent now: a real-time byte always, a line if there is room."""
        return command.kind not in _LINES or self.has_room(len(_LINES[command.kind]))

    def send_command(self, command):
        """Send a command as a line or a real-time byte; the event ACCEPTED or REFUSED follows at `answered`."""
        kind = command.kind
        if kind in _LINES:
            self.send_line(PAGE, _LINES[kind], lambda error: self._answered(Event(REFUSED if error else ACCEPTED, command, error)))
            return
        self.write(bytes((_OVERRIDES[command.value, command.power, command.feed] if kind == commands.OVERRIDE else _BYTES[kind],)))
        if kind == commands.RESET:
            self._resets.append(command)
        else:
            self._answered(Event(ACCEPTED, command))

    def ask_report(self):
        """Ask for a report."""
        self.write(b"?")

    def note_silence(self):
        """Do nothing: the board may still answer the lines under way."""

    def oldest_line(self):
        """The line under way that is answered next, bytes; b"": there is none."""
        return self._under_way[0][1] if self._under_way else b""

    def feed(self, data, now_ms):
        """Take bytes of the board."""
        lines, rest = whole_lines(self._buffer + data)
        self._buffer = b""
        for line in lines:
            if line == "ok":
                self._take_answer(0, line)
            elif line[:6] == "error:" and line[6:].isdigit():
                self._take_answer(int(line[6:]), line)
            else:
                resets = []
                if line[:5] == "Grbl ":
                    resets, self._resets = self._resets, resets
                    self.drop()
                self._heard(line, self._under_way[0][0] if self._under_way else None)
                for command in resets:
                    self._answered(Event(ACCEPTED, command))
        self._buffer = rest

    def drop(self):
        """Give up the lines under way, because the board has begun anew: their answer is LOST."""
        lost = self._under_way
        self._under_way = []
        self._bytes = 0
        self._buffer = b""
        for _, _, answered in lost:
            if answered:
                answered(LOST)
        resets, self._resets = self._resets, []
        for command in resets:
            self._answered(Event(REFUSED, command, LOST))

    def _take_answer(self, error, line):
        """Take the answer to the oldest line under way; count it as foreign if there is none. `error` 0: ok; `line`: its text, for the guest."""
        if not self._under_way:
            self.foreign += 1
            return
        owner, line_said, answered = self._under_way.pop(0)
        self._bytes -= len(line_said) + 1
        if answered:
            answered(error)
        if owner == GUEST:
            self._heard(line, GUEST)


def whole_lines(data):
    """(texts of the lines in `data` that are whole and not empty, bytes of the next line). Leaves out bytes that are not printable."""
    rows = data.split(b"\n")
    rest = rows.pop()
    lines = ["".join([chr(byte) for byte in row if 32 <= byte < 127]) for row in rows]
    return [line for line in lines if line], rest if len(rest) <= _LONGEST else b""


def dwell_ms(line):
    """Milliseconds for which a line of G-code makes the machine wait (G4 P…); 0 if it does not."""
    text = line.decode().upper().replace(" ", "")
    for code in ("G4P", "G04P"):
        _, found, rest = text.partition(code)
        count = 0
        while count < len(rest) and rest[count] in "0123456789.":
            count += 1
        if found and count:
            try:
                return int(float(rest[:count]) * 1000)
            except ValueError:
                return 0
    return 0


def number_line(number, line):
    """Return `line` with its number in the file as N word, which reports then show. A line that does not begin with a letter, or has no room for the
    word, stays as it is."""
    return line if not line[:1].isalpha() or len(line) > longest_line(line) - _NUMBER or number > _MOST_NUMBER else b"N%d%s" % (number, line)


def fields_of(report):
    """The fields of a report line `<…>`, {"state": …, "MPos": …} as texts. Raises ValueError if it is none."""
    fields = report[1:-1].split("|")
    found = {"state": fields[0]}
    for field in fields[1:]:
        name, _, value = field.partition(":")
        found[name] = value
    return found
