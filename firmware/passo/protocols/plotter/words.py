"""Lines of text in packets, for additions of options: `$`, number, three characters, checksum.

The packets of a line are numbered from 0; a line feed ends it. Each is answered by TAKEN, the last by the lines that answer it, of
which the last is `ok` or `error:120`. One that comes a second time is answered again and not taken. One whose number does not
follow is answered by RESEND: the line is to be sent anew.
"""

from micropython import const

from passo import errors
from passo.commands import BAD, HELLO, Command
from passo.protocols.words import Words

_LONGEST = const(90)  # characters of a line


class PacketWords(Words):
    def __init__(self):
        Words.__init__(self)
        self._text = b""
        self._number = 0  # of the packet that follows

    def take_packet(self, data):
        """Return the Command of a packet of six bytes."""
        number = data[1]
        if number and number + 1 == self._number:
            return Command(HELLO)
        if not number:
            self._text = b""
        elif number != self._number or len(self._text) > _LONGEST:
            return Command(BAD, error=errors.BYTES_DROPPED)
        self._number = number + 1
        self._text += bytes(data[2:5])
        end = self._text.find(b"\n")
        if end < 0:
            return Command(HELLO)
        try:
            line = self._text[:end].decode()
        except UnicodeError:
            line = ""
        return self.line_command(line)
