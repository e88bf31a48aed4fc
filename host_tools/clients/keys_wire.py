"""The kit's keys as the page's machine speaks them: keys out, and what has been refused in.

    wire = KeysWire(write, machine)     # machine.report(dict)
    wire.open = True                    # the port is: a kit that does not answer is taken to be there

A board of Passo answers `?` by that byte and the number of the last refusal. Another kit does not know it, and is asked a few times only.
"""

from passo import errors
from passo.protocols.keys.protocol import WHY

_TIMES = 3


class KeysWire:
    def __init__(self, write, machine):
        self.write = write
        self._machine = machine
        self._buffer = b""
        self._unheard = 0  # times that it has been asked without an answer
        self._answers = False
        self.open = False

    def feed(self, data, now_ms):
        self._buffer += bytes(data)
        while len(self._buffer) > 1:
            asked, error = self._buffer[:2]
            self._buffer = self._buffer[2 if asked == WHY else 1 :]
            if asked == WHY:
                self._answers = True
                self._tell(error)

    def _tell(self, error):
        self._machine.report({"state": "alarm" if error >= errors.ALARM_HARD_LIMIT else "idle", "error": error})

    def ask(self):
        if not self.open:
            return
        if self._answers or self._unheard < _TIMES:
            self._unheard += 1
            self.write(bytes((WHY,)))
        if not self._answers:
            self._tell(0)

    def drop(self):
        self._answers = False
        self._unheard = 0
        self._buffer = b""

    silent = drop
