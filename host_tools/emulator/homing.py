"""Watches a link for the answer to homing: then the trace gets its zero.

    watch = HomingWatch("plotter", homed)
    watch.note_sent(bytes to the board); watch.note_answer(byte from the board)
"""

from passo.protocols.plotter import host as plotter

_ORIGIN = plotter.packet(plotter.COMMANDS["ORIGIN"])
_STATUS = plotter.packet(plotter.COMMANDS["STATUS"])
_ORIGIN_OK = next(code for code, name in plotter.ANSWERS.items() if name == "ORIGIN_OK")
_STATUS_BYTES = 12


class HomingWatch:
    """Calls `homed()` at the answer to ORIGIN of the plotter's language; knows no other."""

    def __init__(self, protocol, homed):
        self._knows = protocol == "plotter"
        self._homed = homed
        self._last = b""
        self._homing = False
        self._status_left = 0

    def note_sent(self, data):
        """Note bytes sent to the board: an ORIGIN packet begins homing, a STATUS packet has an answer of _STATUS_BYTES to be skipped."""
        if not self._knows:
            return
        for value in data:
            self._last = (self._last + bytes((value,)))[-len(_ORIGIN) :]
            if self._last == _ORIGIN:
                self._homing = True
            elif self._last == _STATUS:
                self._status_left += _STATUS_BYTES

    def note_answer(self, value):
        """Note a byte from the board; call `homed` if it answers ORIGIN with success."""
        if self._status_left:
            self._status_left -= 1
        elif self._homing and value == _ORIGIN_OK:
            self._homing = False
            self._homed()
