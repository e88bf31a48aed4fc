"""The torch's frames as the page's machine speaks them: commands out, reports in.

    wire = TorchWire(write, machine)        # machine.take_answer(event), machine.report(dict)

The board answers lines about settings only: other commands count as done once sent. The board counts those it drops, and its reports say why.
"""

import struct

from host_tools.clients.answers import answer_of, is_complete, setting_line
from passo import commands, errors
from passo.commands import ACCEPTED, REFUSED, RUN, STILL, Event
from passo.options.independent.commands import AS_JOG, ZERO
from passo.protocols.torch import protocol as torch
from passo.protocols.typed_words import line_of

_OVERTAKEN = 5  # reports
_JOGS = {(0, 1): "JOG_X+", (0, -1): "JOG_X-", (1, 1): "JOG_Y+", (1, -1): "JOG_Y-"}
_FRAMES = {commands.STOP: torch.frame("STOP"), ZERO: torch.frame("ORIGIN"), commands.HAND_OVER: torch.passo(torch.LINK_OF, 0),
           commands.RESET: torch.passo(torch.UNLOCK_OF, 1), commands.UNLOCK: torch.passo(torch.UNLOCK_OF, 0)}  # fmt: skip


def _run_frame(command):
    """The frame of a RUN command: a jog, or a move with a speed of each axis."""
    steps = [part or 0 for part in command.steps]
    if command.when == AS_JOG:
        axis = 0 if steps[0] else 1
        return torch.frame(_JOGS[axis, 1 if steps[axis] > 0 else -1])
    speeds = [rate[0] if part >= 0 else -rate[0] for part, rate in zip(steps, command.rates)]
    return torch.move(abs(steps[0]), speeds[0], abs(steps[1]), speeds[1])


def frame_of(command):
    """The frame, bytes, of a command (passo.commands)."""
    kind = command.kind
    if kind == RUN:
        return _run_frame(command)
    if kind == commands.CONNECT:
        return torch.frame("CONNECT" if command.value else "DISCONNECT")
    if kind == STILL:  # preferences: (steps of a jog, default steps/s)
        jogs, speeds = command.value
        return torch.configure(jogs[0], jogs[1], speeds[0], speeds[1])
    if kind in _FRAMES:
        return _FRAMES[kind]
    from passo.options.weaving.language_torch import weave  # here: the other kinds need no option

    return weave(command.value, command.target[0], command.target[1], command.feed // 1000, command.centre, command.clockwise)


class Answers:
    """Cuts the bytes of a board into answers."""

    def __init__(self):
        self._cutter = torch.answer_cutter()

    def put(self, data, now_ms):
        """Take bytes of the board; `now_ms` tells a torn frame from the next one."""
        self._cutter.put_bytes(bytes(data), now_ms)

    def next_answer(self):
        """The next whole answer, (name, {field: value}), or None. Skips frames that are not understood."""
        while True:
            found = self._cutter.next_frame()
            if found is None:
                return None
            try:
                if found:
                    return torch.answer_from(found)
            except (KeyError, IndexError, ValueError, struct.error):
                pass


class TorchWire:
    def __init__(self, write, machine):
        self._write = write
        self._machine = machine
        self._answers = Answers()
        self._line = None  # the command of a line that is not answered
        self._text = ""  # of its answer so far
        self._reports = 0  # since it was sent

    def can_take(self, command):
        """True: commands need no answer, so any number may be under way."""
        return True

    def send_command(self, command):
        """Send a command. Its event ACCEPTED comes at once; that of a setting comes with the board's answer."""
        if command.kind == commands.SETTING:
            self._drop_line()
            self._line = command
            self._reports = 0
            self._write(b"".join([torch.passo(torch.LINE_OF, byte) for byte in line_of(setting_line(command))]))
            return
        self._write(frame_of(command))
        self._machine.take_answer(Event(ACCEPTED, command))

    def ask_report(self):
        """Ask for a report."""
        self._write(torch.passo(torch.STATUS_OF))

    def drop(self):
        """Give up the line about a setting; other commands wait for no answer."""
        self._drop_line()

    def _drop_line(self, error=errors.NO_ANSWER, told=None):
        line, self._line, self._text = self._line, None, ""
        if line:
            self._machine.take_answer(Event(REFUSED if error else ACCEPTED, line, error, told))

    def _late_line(self):
        """Give up a line that several reports have overtaken: a board answers in order, so it does not know the line."""
        self._reports += 1
        if self._line and self._reports > _OVERTAKEN:
            self._drop_line()

    def _hear_line(self, text):
        self._text += text
        if is_complete(self._text):
            self._drop_line(*answer_of(self._text))

    note_silence = drop

    def feed(self, data, now_ms):
        """Take bytes of the board: reports go to the machine, texts end the setting under way."""
        self._answers.put(data, now_ms)
        told = self._answers.next_answer()
        while told:
            if told[0] == "PASSO":
                fields = told[1]
                fields["position"] = [fields["x"], fields["y"]]
                self._machine.report(fields)
                self._late_line()
            elif told[0] == "TEXT":
                self._hear_line(told[1]["text"])
            told = self._answers.next_answer()
