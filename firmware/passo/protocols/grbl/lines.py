"""The lines that a sender has under way: bytes in, and out the oldest line when its turn has come; and the bytes that are in no line.

    lines.take_bytes(b"G1X1\\nG?1")  # False if there are real-time bytes among them, but for `?`:
    lines.fields[LINES_ASKED]       # 1; it is the caller's to clear
    while lines.has_lines():
        line = lines.next_line()    # bytes; None for one that was too long or found no room
    real_time(0x91).kind            # OVERRIDE: the feed, 10 % more; None for a byte that has no such meaning

A line that is to be understood where it lies is text[fields[LINES_AT] : …] up to its line feed; then LINES_AT goes on to the next
one (take_viper.py).

    text   . . . G1X1↵G1X2↵G1      .
                 ^LINES_AT ^_WHOLE ^_END

A line ends with \\n, \\r or \\r\\n. Blanks and comments take room only until there is too little of it, however long they are.
Once a line has found no room none finds it until all that are kept have had their turn.
"""

from array import array

import micropython
from micropython import const

from passo import commands
from passo.commands import Command
from passo.arrays import buffer
from passo.protocols.gcode.parse_records import *
from passo.protocols.gcode.words import LONGEST, bare_line
from passo.records import LINES_BYTES

RX_BYTES = const(512)  # that a sender may have under way
ODD = const(0x7F)  # stands in a line for a byte from 0x80 on that is no real-time byte
REAL_TIME = const(-1)  # of buffer_bytes(): there are real-time bytes but `?`; nothing is kept
SLOWLY = const(-2)  # take_each() has to keep it
LONG = const(-3)  # it is kept; the line that has not ended yet has grown long
ARC = const(-5)  # and this: the oldest line is an arc, which GCode.take_arc() may take; LINES_TAKEN lines were before it
LEFT = const(-4)  # of take_lines() besides: the machine has not taken all rows, `accept` of the batch has the reason
_RAW = const(256)  # bytes of one line: then blanks and comments are left out of it
_TOO_LONG = b"\xff\n"  # stands for such a line

# Bytes taken out of the stream as they come, with the command of each.
_PLAIN = {
    0x18: commands.RESET, 0x21: commands.HOLD, 0x3F: commands.STATUS, 0x7E: commands.RESUME, 0x84: commands.DOOR, 0x85: commands.JOG_CANCEL,
}  # fmt: skip
_TOGGLES = {0x9E: commands.SPINDLE_STOP, 0xA0: 1, 0xA1: 2}
# 100 %, and changes of it, of the feed from 0x90 on, per cent of rapids from 0x95 on; the first five again of the power from 0x99 on.
_AMOUNTS = (100, 10, -10, 1, -1, 100, 50, 25)


@micropython.viper
def buffer_bytes(data: ptr8, count: int, text: ptr8, lines: ptr32) -> int:
    """Put `count` bytes behind the kept ones, but for `?`. Returns 0, REAL_TIME, SLOWLY or LONG."""
    size = lines[LINES_SIZE]
    if lines[LINES_END] + count > size and lines[LINES_AT]:
        move_up(text, lines)
    last = lines[LINES_WHOLE]
    end = lines[LINES_END]
    slowly = lines[LINES_SLOWLY]
    asked = lines[LINES_ASKED]
    at = 0
    while at < count:
        byte = int(data[at])
        at += 1
        if byte == 0x3F:
            asked = 1
            continue
        if byte > 0x7F or byte == 0x7E or byte == 0x21 or byte == 0x18:
            return REAL_TIME
        if end < size:
            text[end] = byte
        end += 1
        if byte == 10:
            last = end
        elif byte == 13:
            slowly = 1
    if slowly or end > size:
        return SLOWLY
    lines[LINES_ASKED] = asked
    lines[LINES_WHOLE] = last
    lines[LINES_END] = end
    return LONG if end - last > _RAW else 0


@micropython.viper
def move_up(text: ptr8, lines: ptr32):
    """Move the bytes that are kept to the start of the buffer, to make room behind them."""
    begin = lines[LINES_AT]
    at = begin
    while at < lines[LINES_END]:
        text[at - begin] = text[at]
        at += 1
    lines[LINES_AT] = 0
    lines[LINES_WHOLE] = lines[LINES_WHOLE] - begin
    lines[LINES_END] = lines[LINES_END] - begin


def real_time(byte):
    """Return the command of a real-time byte; None if it has no such meaning."""
    if byte in _PLAIN:
        return Command(_PLAIN[byte])
    if byte in _TOGGLES:
        return Command(commands.TOGGLE, value=_TOGGLES[byte])
    if not 0x90 <= byte <= 0x9D or byte == 0x98:
        return None
    command = Command(commands.OVERRIDE, value=commands.FEED if byte < 0x95 else commands.RAPID if byte < 0x98 else commands.POWER)
    index = (byte - 0x90) % 9
    if 0 < index < 5:
        command.feed = _AMOUNTS[index]
    else:
        command.power = _AMOUNTS[index]
    return command


def mark_of(command):
    """Return the blank that stands for a real-time byte from 0x80 on within a line: 1 … 8, as what_acted() reads it."""
    if command.kind == commands.OVERRIDE:
        return 1 + command.value
    if command.kind != commands.TOGGLE:
        return 7 if command.kind == commands.DOOR else 8
    return 4 if command.value == commands.SPINDLE_STOP else 4 + command.value


def what_acted(line, machine):
    """Return the changes by real-time bytes within a line, as text: letters beyond ASCII have made them."""
    found = []
    for which, name in enumerate(("feed", "rapids", "spindle")):
        if bytes((which + 1,)) in line:
            found.append("%s %d %%" % (name, machine.overrides[which]))
    for bit, name in ((0, "spindle stop"), (1, "flood"), (2, "mist")):
        if bytes((bit + 4,)) in line:
            found.append(name + (" on" if machine.coolant & bit else " off" if bit else ""))
    for mark, name in ((b"\7", "door"), (b"\x08", "jog cancel")):
        if mark in line:
            found.append(name)
    return ", ".join(found)


def plain_text(line):
    """Return a `$` line as text, capitals, without blanks and comments; bytes beyond ASCII are left out."""
    return bytes(bare_line(line)).decode().upper()


class Lines:
    def __init__(self):
        self.text = b""  # until make_buffer(), or the first byte: many a link never says anything
        self.fields = array("i", [0] * LINES_FIELDS)
        self.fields[LINES_SIZE] = LINES_BYTES
        self.clear_lines()

    def make_buffer(self):
        """Allocate the buffer. Raises MemoryError."""
        if not self.text:
            self.text = buffer(self.fields[LINES_SIZE])

    def clear_lines(self):
        """Forget all lines; the bytes stay, for a black box."""
        fields = self.fields
        fields[LINES_AT] = fields[LINES_WHOLE] = fields[LINES_END]  # the bytes stay, for a black box
        for field in range(LINES_ASKED, LINES_SIZE):
            fields[field] = 0
        self.lost = 0  # lines that found no room
        self._spoilt = False  # the one that has not ended yet is too long, or finds none
        self._after_return = False

    def has_lines(self):
        """Return True if a whole line is kept, or one was lost."""
        fields = self.fields
        return fields[LINES_AT] < fields[LINES_WHOLE] or self.lost

    def count_lines(self):
        """Return the number of lines that are kept."""
        fields = self.fields
        return bytes(self.text[fields[LINES_AT] : fields[LINES_WHOLE]]).count(b"\n")

    def is_amid_line(self):
        """Return True if a line has begun and not ended."""
        return self._spoilt or self.fields[LINES_END] > self.fields[LINES_WHOLE]

    def drop_begun(self):
        """Forget the line that has begun and not ended."""
        self.fields[LINES_END] = self.fields[LINES_WHOLE]
        self._spoilt = self._after_return = False
        self._note_slow()

    def drop_odd(self):
        """Forget the last byte of the line that has begun, if it is ODD."""
        fields = self.fields
        end = fields[LINES_END]
        if end > fields[LINES_WHOLE] and self.text[end - 1] == ODD:
            fields[LINES_END] = end - 1

    def free_bytes(self):
        """Return the number of bytes that can be kept."""
        return self.fields[LINES_SIZE] - self.fields[LINES_END] + self.fields[LINES_AT]

    def take_bytes(self, data):
        """Keep bytes. Returns False, and keeps nothing, if real-time bytes other than `?` are among them."""
        if not data:
            return True
        if not self.text:
            self.make_buffer()
        kept = buffer_bytes(data, len(data), self.text, self.fields)
        if kept == REAL_TIME:
            return False
        if kept:
            self.finish_buffering(kept, data)
        return True

    def finish_buffering(self, kept, data):
        """Finish buffering `data`; `kept`: the return value of buffer_bytes(), SLOWLY or LONG."""
        if kept == SLOWLY:
            self._take_each(data)
        self._check_length()

    def _note_slow(self):
        """Set LINES_SLOWLY: whether the next bytes need _take_each()."""
        self.fields[LINES_SLOWLY] = 1 if self._spoilt or self.lost or self._after_return else 0

    def _take_each(self, data):
        """Keep bytes with carriage returns, or beyond the room, piece by piece."""
        data = bytes(data)
        if b"?" in data:
            self.fields[LINES_ASKED] = 1
            data = data.replace(b"?", b"")
            if not data:
                return
        if self._after_return and data[0] == 10:  # the second byte of \r\n
            data = data[1:]
        self._after_return = data[-1:] == b"\r"
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        pieces = data.split(b"\n")
        last = pieces.pop()
        for piece in pieces:
            self._add_piece(piece)
            self._end_line()
        self._add_piece(last)
        self._note_slow()

    def _add_piece(self, piece):
        """Append a piece of the line that has not ended yet."""
        fields = self.fields
        end = fields[LINES_END] + len(piece)
        if not piece:
            return  # no line has begun behind the last line end
        if self._spoilt or self.lost:
            self._spoil_line()
        elif end > fields[LINES_SIZE] - len(_TOO_LONG):
            self._squeeze_line(piece)
        else:
            self.text[fields[LINES_END] : end] = piece
            fields[LINES_END] = end
            self._check_length()

    def _check_length(self):
        """Squeeze the line that has not ended yet, if it is longer than _RAW bytes."""
        if self.fields[LINES_END] - self.fields[LINES_WHOLE] > _RAW:
            self._squeeze_line(b"")
            self._note_slow()

    def _squeeze_line(self, piece):
        """Keep only what counts of the line that has not ended yet, and of `piece` behind it. An open comment stays open."""
        fields = self.fields
        whole = fields[LINES_WHOLE]
        kept = bare_line(bytes(self.text[whole : fields[LINES_END]]) + piece, True)
        end = whole + len(kept)
        if len(kept) > LONGEST + 1 or end > fields[LINES_SIZE] - len(_TOO_LONG):
            self._spoil_line()
            return
        self.text[whole:end] = kept
        fields[LINES_END] = end

    def _spoil_line(self):
        """Drop the line that has not ended yet; it is too long, or finds no room."""
        self._spoilt = True
        self.fields[LINES_END] = self.fields[LINES_WHOLE]

    def _end_line(self):
        """End the line, or count it as lost."""
        line = _TOO_LONG if self._spoilt else b"\n"
        self._spoilt = False
        fields = self.fields
        end = fields[LINES_END] + len(line)
        if self.lost or end > fields[LINES_SIZE]:
            self.lost += 1
            return
        self.text[fields[LINES_END] : end] = line
        fields[LINES_END] = fields[LINES_WHOLE] = end

    def next_line(self):
        """Return the oldest line, bytes, and take it out; None for one that was too long or found no room; False if there is none."""
        fields = self.fields
        at = fields[LINES_AT]
        if at == fields[LINES_WHOLE]:
            if not self.lost:
                return False
            self.lost -= 1
            self._note_slow()
            return None
        end = self.text.find(b"\n", at)
        line = bytes(self.text[at:end])
        fields[LINES_AT] = end + 1
        if line[-1:] == b"\r":
            line = line[:-1]
        return None if line == _TOO_LONG[:1] else line
