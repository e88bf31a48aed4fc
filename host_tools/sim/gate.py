"""Keeps browsers out of a TCP port that takes a machine's orders: any page can make a browser send bytes to any port of the PC.

    gate = Gate()                           # of one connection
    data = gate.filter_bytes(received, now)         # bytes for the board; None: hang up
    gate.note_answer(said)                  # bytes from the board

The gate hangs up on a connection, before it reads more, if the connection begins with a request of HTTP, with TLS or with STUN (a page's
WebRTC sends that to a TURN server by TCP), if its first line is longer than a request may be, and if its first five lines are all refused:
a request's body is lines to a board. Until one line has been accepted
the next waits for an answer, or for WAIT_S: so the board executes none behind the fifth. Real-time bytes, and all bytes after an accepted line,
pass at once.
"""

import re

WAIT_S = 0.05  # a language need not answer
_REFUSALS = 5
_TLS = b"\x16\x03"
_STUN = re.compile(rb".{4,6}\x21\x12\xa4\x42", re.DOTALL)  # with a length before it, or without
_REQUEST = re.compile(rb"[A-Z]{3,16} [^\r\n]* HTTP/\d")
_MAY_BE = re.compile(rb"[A-Z]{0,16}(?: [^\r\n]*)?")  # of which a request may still come
_LONGEST = 8000  # bytes of a first line that may be a request
_PUSHED = b"<[GA\r\n"  # first bytes of lines that a grbl sends unasked


class Gate:
    def __init__(self):
        self._open = False  # an answer was no refusal
        self._first = True  # the first line has not ended yet
        self._held = b""
        self._refused = 0
        self._waits_since = None  # time at which a line was let through that has no answer yet

    def filter_bytes(self, data, now):
        """Return the bytes that may go on, perhaps some of those held back before; None: hang up on this connection."""
        if self._refused >= _REFUSALS:
            return None
        self._held += data
        if self._open:
            data, self._held = self._held, b""
            return data
        if self._first:
            if self._held[:2] == _TLS or _STUN.match(self._held) or _REQUEST.match(self._held):
                return None
            if self._held[:1] == _TLS[:1] and len(self._held) == 1 or self._held and _MAY_BE.fullmatch(self._held):
                # The next bytes, or the line's end, show whether it is a request.
                return b"" if len(self._held) <= _LONGEST else None
            self._first = False
        if self._waits_since is not None and now - self._waits_since < WAIT_S:
            return b""
        end = min((at for at in (self._held.find(b"\n"), self._held.find(b"\r")) if at >= 0), default=-1) + 1 or len(self._held)
        data, self._held = self._held[:end], self._held[end:]
        self._waits_since = now if data[-1:] in (b"\n", b"\r") and data.strip() else None
        return data

    def has_bytes(self):
        """True if filter_bytes(b"", now) may return bytes that wait."""
        return bool(self._held)

    def note_answer(self, said):
        """Note the board's answer: an "ok", or any other answer asked for that is no error, opens the gate for good; each "error:" counts as
        refusal."""
        if self._open or not said:
            return
        refused = said.count(b"error:")
        self._refused += refused
        if b"ok\r\n" in said or b"ok\n" in said or not refused and said[:1] not in _PUSHED:
            self._open = True
        self._waits_since = None
