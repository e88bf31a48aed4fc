"""The control commands of the pulses language under way on one wire, and the flow of a file beside them.

    wire = PulsesWire(write, heard)
    wire.say(("jog", "x", 100), answered)       # True if it was sent; answered(error) follows, 0: ok
    wire.feed(data)                             # heard(line): of each line that answers none of them, and of each status

A board answers control commands in order. Errors of a file come between them, with their line and column or without a command that
waits: those are heard, and never take the place of an answer. {end} is the exception: of a file that has failed there may be an
answer to it or not; the next status tells.
"""

from micropython import const

from host_tools.page.wire import LOST, whole_lines
from passo.protocols.pulses.protocol import ACK, CREDIT, WINDOW, frame

END = ("end",)
_ASK = ("?",)
_MOST = const(8)  # commands under way


class PulsesWire:
    def __init__(self, write, heard):
        self._write = write
        self._heard = heard
        self._under_way = []  # (words, answered)
        self._buffer = b""
        self._failed = False  # the file that is being sent has
        self.room = 0  # bytes of a file that may be sent

    def waits_for(self, verb):
        """True if a command of that verb is not answered."""
        return bool([1 for words, _ in self._under_way if words[0] == verb])

    def say(self, words, answered):
        """Send a control command, if few are under way."""
        return len(self._under_way) < _MOST and self.say_always(words, answered)

    def say_always(self, words, answered):
        self._under_way.append((words, answered))
        self._write(frame(*words))
        return True

    # --- a file

    def begin_file(self):
        """{load} or {stream} has been answered: bytes of a file may follow."""
        self.room = WINDOW
        self._failed = False
        self._write(b"\n")

    def send(self, data):
        """Bytes of the file, `room` at most."""
        self.room -= len(data)
        self._write(data)

    # --- what is heard

    def drop(self):
        """Nothing that is under way will be answered."""
        lost = self._under_way
        self._under_way = []
        self._buffer = b""
        for _, answered in lost:
            if answered:
                answered(LOST)

    def feed(self, data):
        data = bytes(data)
        acks = data.count(ACK)
        if acks:
            self.room += acks * CREDIT
            data = data.replace(ACK, b"")
        lines, self._buffer = whole_lines(self._buffer + data)
        for line in lines:
            self._line(line)

    def _line(self, line):
        if line[:1] == "<":
            if self._failed and self._first() == END:
                self._under_way.pop(0)  # it was answered by the file's error
            if self._first() == _ASK:
                self._under_way.pop(0)
            self._heard(line)
        elif line == "ok" or line[:3] == "ok ":
            self._answer(0, line)
        elif line[:6] == "error:" and line[6:].isdigit() and not self._of_the_file():
            self._answer(int(line[6:]), line)
        else:
            if line[:6] == "error:":
                self._failed = True
            self._heard(line)

    def _first(self):
        return self._under_way[0][0] if self._under_way else None

    def _of_the_file(self):
        """True if no command waits that an error may be about."""
        return not [1 for words, _ in self._under_way if words != _ASK]

    def _answer(self, error, line):
        while True:
            waiting = [each for each in self._under_way if each[0] != _ASK]
            if not waiting:
                return
            words, answered = waiting[0]
            self._under_way.remove(waiting[0])
            if not (self._failed and words == END):
                if answered:
                    answered(error)
                return
            if line != "ok":
                return
