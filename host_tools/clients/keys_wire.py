"""The kit's keys as the page's machine speaks them: keys out, refusals in.

    wire = KeysWire(write, machine)     # machine.report(dict), machine.take_answer(event)
    wire.open = True                    # the port is: a kit that does not answer is taken to be there

A board of Passo answers `?` by that byte and the number of the last refusal, and lines about settings by lines. Another kit does not know either, and is asked
a few times only.
"""

from host_tools.clients.answers import answer_of, is_complete, setting_line
from passo import errors
from passo.commands import ACCEPTED, REFUSED, Event
from passo.protocols.keys.protocol import WHY
from passo.protocols.typed_words import line_of

_TIMES = 3
_OVERTAKEN = 5  # answers to `?` that come before that to a line


class KeysWire:
    def __init__(self, write, machine):
        self.write = write
        self._machine = machine
        self._buffer = b""
        self._unheard = 0  # times that it has been asked without an answer
        self._answers = False
        self.open = False
        self._line = None  # the command of a line that is not answered
        self._text = ""  # of its answer so far
        self._overtaken = 0

    def can_take(self, command):
        return self._line is None and self._answers

    def send_command(self, command):
        """Send a line about settings; its event follows at the machine. Keys are written as they are."""
        self._line, self._text, self._overtaken = command, "", 0
        self.write(line_of(setting_line(command)))

    def feed(self, data, now_ms):
        """Take bytes of the board: WHY and the number of its last refusal, or letters of the answer to a line."""
        self._buffer += bytes(data)
        while self._buffer:
            first = self._buffer[0]
            if first == WHY and len(self._buffer) < 2:
                return
            error = self._buffer[1:2]
            self._buffer = self._buffer[2 if first == WHY else 1 :]
            if first == WHY:
                self._answers = True
                self._report_error(error[0])
                self._overtaken += 1
                if self._overtaken > _OVERTAKEN:
                    self._end_line(errors.NO_ANSWER)
            elif self._line:
                self._text += chr(first)
                if is_complete(self._text):
                    self._end_line(*answer_of(self._text))

    def _end_line(self, error, told=None):
        """End the line under way with an event: REFUSED if `error`, else ACCEPTED with the lines `told`."""
        line, self._line = self._line, None
        if line:
            self._machine.take_answer(Event(REFUSED if error else ACCEPTED, line, error, told))

    def _report_error(self, error):
        self._machine.report({"state": "alarm" if error >= errors.ALARM_HARD_LIMIT else "idle", "error": error})

    def ask_report(self):
        """Ask for the last refusal. A kit that never answers is asked _TIMES times only."""
        if not self.open:
            return
        if self._answers or self._unheard < _TIMES:
            self._unheard += 1
            self.write(bytes((WHY,)))
        if not self._answers:
            self._report_error(0)

    def drop(self):
        """Forget whether the board answers, because it has begun anew."""
        self._answers = False
        self._unheard = 0
        self._buffer = b""
        self._end_line(errors.NO_ANSWER)

    note_silence = drop
