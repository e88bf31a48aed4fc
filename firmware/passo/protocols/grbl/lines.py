"""The lines that a sender has under way: bytes in, and out the oldest line when its turn has come.

    lines.take(b"G1X1\\nG?1")        # False if there are real-time bytes among them, but for `?`:
    lines.asked                     # True; it is the caller's to clear
    while lines.waiting():
        line = lines.next()         # bytes; None for one that was too long or found no room

A line that is to be understood where it lies is text[at : …] up to its line feed; then `at` goes on to the next one.

    text   . . . G1X1↵G1X2↵G1      .
                 ^at       ^whole  ^_end

A line ends with \\n, \\r or \\r\\n. Blanks and comments take room only until there is too little of it, however long they are.
Once a line has found no room none finds it until all that are kept have had their turn.
"""
# ruff: noqa: F821

import micropython
from micropython import const

from passo.memory import buffer
from passo.protocols.gcode.words import LONGEST, bare
from passo.records import LINES_BYTES

try:
    ptr8
except NameError:
    ptr8 = None  # a name that only viper's compiler knows

RX_BYTES = const(128)  # that a sender may have under way
_REAL_TIME = const(-1)
_SLOWLY = const(-2)
_QUESTION = const(4096)
_RAW = const(256)  # of one line: then blanks and comments are left out of it
_TOO_LONG = b"\xff\n"  # stands for such a line


@micropython.viper
def copy(text: ptr8, begin: int, data: ptr8, count: int, room: int) -> int:
    """Put `count` bytes to text[begin:], but for `?`. Where the text behind its last line feed begins, 0: there is none; and
    how many `?` were left out · _QUESTION. Nothing counts of them where that is _REAL_TIME, or _SLOWLY: there is a carriage
    return, or no room."""
    last = 0
    at = 0
    end = begin
    room += begin
    while at < count:
        byte = int(data[at])
        at += 1
        if byte == 0x3F:
            continue
        if end < room:
            text[end] = byte
        end += 1
        if byte == 10:
            last = end
        elif byte > 0x7F or byte == 0x7E or byte == 0x21 or byte == 0x18:
            return -1
        elif byte == 13:
            room = -1
    if end > room:
        return -2
    return last | (begin + count - end) << 12


def plain_text(line):
    """A `$` line as text, capitals, without blanks and comments; what is no ASCII is left out."""
    return bytes(bare(line)).decode().upper()


class Lines:
    def __init__(self):
        self.text = b""  # until make(), or the first byte: many a link never says anything
        self.at = 0  # where the oldest line begins
        self.whole = 0  # behind the last line that has come to its end
        self._end = 0
        self.clear()

    def make(self):
        """Make the buffer. Raises MemoryError."""
        if not self.text:
            self.text = buffer(LINES_BYTES)
            self._view = memoryview(self.text)

    def clear(self):
        self.asked = False  # `?` was among what has come
        self.at = self.whole = self._end = 0
        self.lost = 0  # lines that found no room
        self._spoilt = False  # the one that has not ended yet is too long, or finds none
        self._after_return = False

    def waiting(self):
        return self.at < self.whole or self.lost

    def count(self):
        """Lines that are kept."""
        return bytes(self.text[self.at : self.whole]).count(b"\n")

    def begun(self):
        """True if a line has begun and not ended."""
        return self._spoilt or self._end > self.whole

    def drop_begun(self):
        """Forget the line that has begun and not ended."""
        self._end = self.whole
        self._spoilt = self._after_return = False

    def free(self):
        """Bytes that can be kept."""
        return LINES_BYTES - self._end + self.at

    def room(self):
        """Of the bytes that a sender may have under way, those that are not kept."""
        return max(0, RX_BYTES - self._end + self.at)

    @micropython.native
    def take(self, data):
        """Keep what has come. False, and nothing is kept, where real-time bytes are among it."""
        if not data:
            return True
        if not self.text:
            self.make()
        if self._end + len(data) > LINES_BYTES and self.at:
            self._move_up()
        end = self._end
        last = copy(self.text, end, data, len(data), LINES_BYTES - end)
        if last == _REAL_TIME:
            return False
        if last == _SLOWLY or self._spoilt or self.lost or self._after_return:
            self._take_each(data)
            return True
        end += len(data)
        if last >= _QUESTION:
            self.asked = True
            end -= last // _QUESTION
            last %= _QUESTION
        if last:
            self.whole = last
        self._end = end
        self._check_length()
        return True

    def _move_up(self):
        """Make room behind what is kept."""
        at = self.at
        held = self._end - at
        self.text[:held] = self._view[at : self._end]
        self.at = 0
        self.whole -= at
        self._end = held

    def _take_each(self, data):
        data = bytes(data)
        if b"?" in data:
            self.asked = True
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
            self._add(piece)
            self._end_line()
        self._add(last)

    def _add(self, piece):
        """Append a piece of the line that has not ended yet."""
        if not piece:
            return  # no line has begun behind the last line end
        if self._spoilt or self.lost:
            self._spoil()
            return
        end = self._end + len(piece)
        if end > LINES_BYTES - len(_TOO_LONG):
            self._squeeze(piece)
            return
        self.text[self._end : end] = piece
        self._end = end
        self._check_length()

    def _check_length(self):
        if self._end - self.whole > _RAW:
            self._squeeze(b"")

    def _squeeze(self, piece):
        """Of the line that has not ended yet, and `piece` behind it, keep only what counts. An open comment stays open."""
        kept = bare(bytes(self.text[self.whole : self._end]) + piece, True)
        end = self.whole + len(kept)
        if len(kept) > LONGEST + 1 or end > LINES_BYTES - len(_TOO_LONG):
            self._spoil()
            return
        self.text[self.whole : end] = kept
        self._end = end

    def _spoil(self):
        self._spoilt = True
        self._end = self.whole

    def _end_line(self):
        line = _TOO_LONG if self._spoilt else b"\n"
        self._spoilt = False
        end = self._end + len(line)
        if self.lost or end > LINES_BYTES:
            self.lost += 1
            return
        self.text[self._end : end] = line
        self._end = self.whole = end

    def next(self):
        """The oldest line, which leaves the queue; None for one that was too long, or found no room."""
        if self.at == self.whole:
            self.lost -= 1
            return None
        end = self.text.find(b"\n", self.at)
        line = bytes(self.text[self.at : end])
        self.at = end + 1
        if line[-1:] == b"\r":
            line = line[:-1]
        return None if line == _TOO_LONG[:1] else line
