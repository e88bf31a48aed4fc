"""Watches a link for the answer to homing: then the trace gets its zero.

    watch = HomingWatch("plotter", homed)
    watch.note_sent(bytes to the board); watch.note_answer(byte from the board)
"""


class HomingWatch:
    """Calls `homed()` at the answer to ORIGIN of the plotter's language; knows no other."""

    def __init__(self, protocol, homed):
        self._knows = protocol == "plotter"
        self._homed = homed
        if self._knows:
            from passo.protocols.plotter import host

            self._origin, self._status = (host.packet(host.COMMANDS[name]) for name in ("ORIGIN", "STATUS"))
            self._origin_ok = next(code for code, name in host.ANSWERS.items() if name == "ORIGIN_OK")
            self._status_bytes = host.STATUS_LENGTH
        self._last = b""
        self._homing = False
        self._status_left = 0

    def note_sent(self, data):
        """Note bytes sent to the board: an ORIGIN packet begins homing, a STATUS packet has a long answer to be skipped."""
        if not self._knows:
            return
        for value in data:
            self._last = (self._last + bytes((value,)))[-len(self._origin) :]
            if self._last == self._origin:
                self._homing = True
            elif self._last == self._status:
                self._status_left += self._status_bytes

    def note_answer(self, value):
        """Note a byte from the board; call `homed` if it answers ORIGIN with success."""
        if self._status_left:
            self._status_left -= 1
        elif self._homing and value == self._origin_ok:
            self._homing = False
            self._homed()
