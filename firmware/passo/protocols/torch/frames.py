"""Cuts bytes into frames `code body 0xFF` by the length that each code has; 0xFF may stand in a body.

    cutter = Cutter({0xFE: 18, 0xDD: 2}, gap_ms=5)
    cutter.put_bytes(serial.read(), now_ms)
    frame = cutter.next_frame()     # bytes of a whole frame; b"": something was dropped; None: no more for now

There is no checksum, so a frame is believed only where it must begin: behind another good one, or behind a silence of
`gap_ms`. An unknown code, a wrong terminator or a frame torn by a silence drops everything up to the next silence. A
good frame is there with its last byte, but for two kinds: one that may yet grow longer (`at_idle`) waits for the
silence, and one so short that the rest of a torn frame may begin like it (`short`) waits for another good frame or
for SETTLE_MS without a byte.

The questions of `passo status` in another language are dropped too, but are no fault of the line: QUESTIONS, alone between two silences.
"""

import micropython
from micropython import const

from passo.records import COUNT_MASK

END = const(0xFF)
SETTLE_MS = const(2)  # at 9600 baud the next byte of a torn frame comes within 1.1 ms
_LONG_GAPS = const(20)  # this many gaps between two reads are a silence, even if nobody looked in between


QUESTIONS = b"?", b"\0\0\0\0?"  # of grbl, and with that the packet STATUS of a plotter
_LONE = const(8)  # bytes that are looked at for it


class Cutter:
    def __init__(self, lengths, gap_ms, at_idle=None, short=()):
        """`lengths`: {code: bytes of its frame, code and terminator included}; `at_idle`: {code: a shorter length that
        it may also have, if the line stays silent behind it}; `short`: codes that are not believed at once."""
        self._lengths = lengths
        self._gap_ms = gap_ms
        self._at_idle = at_idle or {}
        self._short = short
        self._bytes = b""
        self._broken = False  # bytes are being dropped until the line is silent
        self._lone = b""  # the first of them
        self._silent_ms = gap_ms  # since the newest byte
        self._latest = 0  # when the newest byte came

    @micropython.native
    def put_bytes(self, data, now_ms):
        """Take bytes, which may be none: time alone ends frames."""
        silent_ms = (now_ms - self._latest) & COUNT_MASK
        if not data:
            self._silent_ms = silent_ms
            return
        if silent_ms >= _LONG_GAPS * self._gap_ms:
            self._broken = False
            self._bytes = b""
        self._silent_ms = 0
        self._latest = now_ms
        if not self._broken:
            self._bytes += data
        elif len(self._lone) < _LONE:
            self._lone += data

    def drop(self):
        """Forget what has come, up to the next silence."""
        if self._bytes:
            self._bytes = self._lone = b""
            self._broken = True

    @micropython.native
    def next_frame(self):
        """Return the next whole frame; b"" if bytes were dropped; None if there is no more for now."""
        quiet = self._silent_ms >= self._gap_ms
        if self._broken:
            if not quiet:
                return None
            self._broken = False
            return None if bytes(self._lone) in QUESTIONS else b""
        data = self._bytes
        if not data:
            return None
        length = self._whole_length(0)
        if not length:
            if not quiet:
                return None
            self._bytes = b""
            return data if len(data) == self._at_idle.get(data[0]) and data[-1] == END else b""
        if length > 0 and data[0] in self._short:
            behind = self._whole_length(length)
            if not behind and (len(data) > length or self._silent_ms < min(SETTLE_MS, self._gap_ms)):
                if not quiet:
                    return None
                self._bytes = b""
                return b""
            if behind < 0:
                length = -1
        if length < 0:
            self._lone = data
            self._bytes = b""
            self._broken = True
            return self.next_frame()
        self._bytes = data[length:]
        return data[:length]

    @micropython.native
    def _whole_length(self, at):
        """Return the length of the frame that begins at byte `at`; 0: not yet whole; −1: it is none."""
        data = self._bytes
        if at == len(data):
            return 0
        length = self._lengths.get(data[at], 0)
        if length and len(data) < at + length:
            return 0
        return length if length and data[at + length - 1] == END else -1
