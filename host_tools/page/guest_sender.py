"""A guest on the page's wire: a sender at the port that `passo panel` offers. It is answered as if it were alone.

Its questions always go through, and so do the bytes that make the machine safe. Lines that move the machine go through while it has
the command, which it takes at rest by `$LINK=0`; else they get error 112.
"""

from micropython import const

from host_tools.clients.grbl_wire import GUEST
from passo import errors
from passo.protocols.grbl.lines import real_time

ALWAYS = (0x18, 0x21, 0x84, 0x85)  # reset, hold, door, jog cancel
_LONGEST = const(256)
_MOST = const(256)  # lines that wait for room
QUESTIONS = (b"$", b"$$", b"$#", b"$G", b"$I", b"$N", b"$LOG", b"$LINK", b"$ENC", b"$MASKS")
_TAKE = (b"$LINK=0", b"$LINK=1")


class GuestSender:
    def __init__(self, machine, write):
        """`write(bytes)`: to the guest; None: there is none."""
        self._machine = machine
        self._write = write
        self.commanded = False  # it has had the command, once
        self._asked = False
        self._buffer = b""
        self._lines = []

    def feed(self, data):
        """Take bytes of the guest: real-time bytes are carried out at once, lines wait for room."""
        plain = bytearray()
        for byte in data:
            if 0x80 <= byte <= 0x9F and real_time(byte) and (plain or self._buffer)[-1:] == b"\xc2":  # a real-time byte as UTF-8, as on the board
                if plain:
                    plain = plain[:-1]
                else:
                    self._buffer = self._buffer[:-1]
            letter = byte >= 0x80 and (real_time(byte) is None or (plain[-1] != 0x0A if plain else bool(self._buffer)))
            if letter:  # it stays in its line: the board tells what it has done
                plain.append(byte)
            if byte == 0x3F:
                self._asked = True
            elif byte in ALWAYS:
                if byte == 0x18:
                    plain = bytearray()
                    self._lines = []
                    self._machine.stop()
                else:
                    self._machine.end_jog()
                    self._machine.wire.write(bytes((byte,)))
            elif byte == 0x7E or byte >= 0x80:
                if not letter and self._has_command():
                    self._machine.wire.write(bytes((byte,)))
            elif byte != 0x0D:
                plain.append(byte)
        lines = (self._buffer + bytes(plain)).split(b"\n")
        self._buffer = lines.pop()[:_LONGEST]
        self._lines += lines
        del self._lines[_MOST:]
        self.poll()

    def poll(self):
        """Send waiting lines, oldest first, until there is no more room."""
        wire = self._machine.wire
        while self._lines:
            line = self._lines[0]
            word = line.strip().upper()
            if word in _TAKE:
                if wire.count_lines(GUEST):
                    return
                self._send_answer(self._machine.hand_over("guest"))
            elif not word or self._has_command() or word in QUESTIONS:
                if not wire.send_line(GUEST, line):
                    return
            elif wire.count_lines(GUEST):
                return  # its answer would overtake theirs
            else:
                self._send_answer(errors.COMMANDED_ELSEWHERE)
            self._lines.pop(0)

    def report(self, line):
        """Send a report to the guest if it has asked for one."""
        if self._asked:
            self._asked = False
            self._send_line(line)

    def pass_line(self, line):
        self._send_line(line)

    def forget_lines(self):
        """Forget its waiting lines: it has closed its port."""
        self._lines = []
        self._buffer = b""

    def _has_command(self):
        return self._machine.state["owner"] == "guest"

    def _send_answer(self, error):
        self._send_line("error:%d" % error if error else "ok")

    def _send_line(self, line):
        if self._write:
            self._write(line.encode() + b"\r\n")
