"""Lines of text in languages whose bytes have no answers: each character comes alone, and three digits prove the line.

    words = TypedWords()
    command = words.take_byte(ord("$")) # None until the line ends: then its Command
    line_of("$100=48.5")                # b"$100=48.5*107\\n": the host's end

A line begins with `$` and has digits, `=`, `.` and `-`; behind it stand `*` and the sum of its bytes modulo 256, then a line feed. The
documents have other bytes for orders, so that a controller of a document does nothing.
"""

from micropython import const

from passo import errors
from passo.commands import BAD, Command
from passo.protocols.words import LINE, Words

_LETTERS = b"$0123456789=.-*\n"
_START = const(0x24)
_END = const(10)
_LONGEST = const(40)


def line_of(text):
    """Return the bytes of a line."""
    return ("%s*%03d\n" % (text, sum(text.encode()) & 255)).encode()


class TypedWords(Words):
    def __init__(self):
        Words.__init__(self)
        self._text = b""

    def is_amid_line(self):
        """Return True while a line has begun and not ended."""
        return bool(self._text)

    def takes_byte(self, byte):
        """Return True if `byte` begins a line, or goes on with it."""
        return byte == _START or bool(self._text) and byte in _LETTERS and len(self._text) < _LONGEST

    def forget_line(self):
        """Forget the line that has begun."""
        self._text = b""

    def take_byte(self, byte):
        """Return the Command of the line that `byte` ends; None: it goes on. Ask takes_byte() first."""
        if byte == _START:
            self._text = b""
        if byte != _END:
            self._text += bytes((byte,))
            return None
        text, _, check = self._text.decode().partition("*")
        self._text = b""
        if check != "%03d" % (sum(text.encode()) & 255):
            return Command(BAD, value=LINE, error=errors.GARBLED)
        return self.line_command(text)
