"""A file of pulse codes under way: stored on the board and played from there, or played as it comes if the board cannot keep it.

    job = PulsesJob(machine, board)
    error = job.run("square.txt", data, 1, False)       # bytes, passes, only checked
    job.replay_refusal()                                # 0: it may be played back, and a code at a time
    job.poll()                                          # sends what there is room for
"""

from micropython import const

from host_tools.clients.pulses_wire import END, brace_in
from host_tools.clients.grbl_wire import LOST
from passo import errors
from passo.options.step_program.commands import STEPS_ABORT
from passo.options.step_program.errors import NO_STEP_PROGRAM, STEP_PROGRAM_FULL
from passo.protocols.pulses.errors import NO_CODE
from passo.protocols.pulses.protocol import Pulses, frame

_PIECE = const(256)  # bytes of a file in one call
_CHECK_PIECE = const(4096)
_LOST_END = const(4)  # reports of an idle machine after which its "end" has got lost

# The phases of a file on its way to the board.
_NO_FILE = const(0)
_OPENING = const(1)
_SENDING = const(2)
_CLOSING = const(3)
_CHECKING = const(4)  # here: it is too long for the board to keep


class PulsesJob:
    def __init__(self, machine, board):
        self._machine = machine
        self._axes = "".join([axis["name"] for axis in board["axes"]])
        self._config = board["step_program"]
        self._phase = _NO_FILE
        self.playing = False  # on its way, or paused in it
        self.paused = False
        self._stream = False
        self.name = ""
        self._at = self._of = self._row = self._column = 0
        self._pass = self._passes = 1
        self._back = self._checked = self._single = False
        self._idle = 0

    def is_sending(self):
        """True while a file goes to the board and the machine does not play it yet."""
        return self._phase != _NO_FILE and not self._stream

    def is_running(self):
        return self._phase != _NO_FILE or self.playing

    def run(self, name, data, passes, checked, single=False):
        """Send the file `data`, bytes, and play it `passes` times. `checked`: only check it; `single`: wait for the page at each code.
        Returns 0 or an error."""
        if self._machine.busy_error() or self.is_running() or self._machine.state["state"] != "Idle":
            return errors.BUSY
        if not data:
            return NO_STEP_PROGRAM
        if brace_in(data):
            return NO_CODE
        self.name = name
        self._data = data
        self._passes = passes
        self._checked = checked
        self._single = single
        self._at = self._of = self._row = self._column = 0
        self._pass = 1
        self._back = self.paused = False
        return self._open_file(False)

    def _open_file(self, stream):
        """Send {load} or, if `stream`, {stream} with the number of bytes. Returns 0, or TOO_MANY_WAITING."""
        self._stream = stream
        self._sent = 0
        self._size = len(self._data) * (self._passes if stream else 1)
        if not self._machine.wire.send_control(("stream" if stream else "load", self._size), self._begin_sending):
            return errors.TOO_MANY_WAITING
        self._phase = _OPENING
        self._show_state("load", 0)
        return 0

    def _begin_sending(self, error):
        """Take the answer to {load} or {stream}: send the file's bytes, or end the job with `error`."""
        if error:
            self.fail(error)
        elif self._phase == _OPENING:
            self._phase = _SENDING
            self.playing = self._stream
            self._machine.wire.begin_file()

    def poll(self):
        """Send bytes of the file while the board gives credit, then "end"; check a piece of a file that it cannot keep."""
        if self._phase == _CHECKING:
            self._check_piece()
        if self._phase != _SENDING:
            return
        wire = self._machine.wire
        data = self._data
        while wire.credit > 0 and self._sent < self._size:
            at = self._sent % len(data)
            piece = data[at : at + min(wire.credit, _PIECE)]
            wire.send(piece)
            self._sent += len(piece)
        if self._sent == self._size and wire.send_control(END, self._take_end):
            self._phase = _CLOSING

    def _take_end(self, error):
        """Take the answer to {end}: run the stored file, wait for the page, or end a checked job."""
        if self._phase != _CLOSING:
            return
        self._phase = _NO_FILE
        if error and error != LOST:
            self._end_job("failed", error)
        elif self._stream:
            return  # "end" follows
        elif self._checked:
            self._end_job("done", 0)
        elif self._single:
            self.playing = self.paused = True
        elif not self._machine.wire.send_control(("run", self._passes), self.take_play_answer):
            self._end_job("failed", errors.TOO_MANY_WAITING)

    def take_play_answer(self, error):
        """Take the answer to {run}, {step}, {back} and the like: the file plays, or the job ends with `error`."""
        if error and error != LOST:
            self._machine.note_result(error)
            if not self.playing:
                self._end_job("failed", error)
        elif not error:
            self.playing = True
            self.paused = False
            self._idle = 0

    def note_file_error(self, error, row, column):
        """Take an error in the file at row, column, from 1. If the board only lacks room, check or stream the file instead of storing it."""
        if self._phase == _NO_FILE:
            self._machine.note_result(error)
            return
        self._row, self._column = row, column
        if error != STEP_PROGRAM_FULL or self._stream:
            self.fail(error)
        elif self._checked:
            self._phase = _CHECKING
            self._sent = 0
            self._reader = Pulses(self._axes, self._config)
            self._reader.feed(frame("load", self._size) + b"\n", 0)
        elif self._open_file(True):
            self.fail(error)

    def _check_piece(self):
        """Parse the next piece of the file on this PC with the firmware's reader, and end the job at an error or behind the last piece."""
        piece = self._data[self._sent : self._sent + _CHECK_PIECE]
        self._sent += len(piece)
        found = self._reader.feed(piece, 0)
        if self._sent == self._size:
            found += self._reader.feed(frame("end"), 0)
        for command in found:
            if command.value == STEPS_ABORT:
                self._row, self._column = command.target
                self.fail(command.error)
                return
        if self._sent == self._size:
            self._phase = _NO_FILE
            self._end_job("done", 0)

    def take_line(self, line):
        """Take a line that the board sends unasked while it plays a file: "end", "start" or "oldest" ends the job."""
        if line == "end" and self.playing:
            self._at = self._of
            self._end_job("done", 0)
        elif line == "start":
            self._at = 0
            self._end_job("start", 0)
        elif line == "oldest":
            self._end_job("oldest", 0)

    def replay_refusal(self):
        """0, or why the board's file may not be played now."""
        return errors.BUSY if self.is_sending() else 0 if self.name else NO_STEP_PROGRAM

    def report(self, state, fields):
        """Take position, pass and direction of the file from a report. `state`: the board's word, `fields`: {name: text} of the report."""
        if not self.playing:
            return
        self._at = int(fields["at"])
        self._of = int(fields["of"])
        if not self._stream:
            self._pass, self._passes = [int(part) for part in fields["pass"].split("/")]
        self._back = fields["going"] == "-"
        if state == "hold":
            self.paused = True
        self._idle = self._idle + 1 if state == "idle" and not self.paused and self._phase == _NO_FILE else 0
        if self._idle >= _LOST_END:
            self._end_job("done", 0)

    def abort(self):
        """Stop at the next step; the file starts from its beginning next time. Returns 0 or an error."""
        return self._machine.stop() if self.is_running() else 0

    def fail(self, error):
        """End the job as failed with an error from outside: a stop, an alarm, a lost board."""
        if self.is_running():
            self._phase = _NO_FILE
            self._end_job("failed", error)

    def _end_job(self, how, error):
        self.playing = self.paused = self._stream = False
        self._show_state(how, error)

    def _show_state(self, how, error):
        """Show the job on all pages: `how` is "load", "run", "done", "start", "oldest" or "failed"."""
        sending = how == "load"
        self._machine.state["job"] = {
            "name": self.name, "how": how, "error": error, "line": 0 if sending else self._at,
            "lines": self._size if sending else self._of, "done": self._sent if sending else self._at,
            "pass": self._pass, "passes": self._passes, "checked": self._checked, "single": self.paused, "back": self._back,
            "row": self._row, "column": self._column,
        }  # fmt: skip

    def refresh_state(self):
        """Bring the state's "job" up to date for the pages."""
        if self.playing:
            self._show_state("run", 0)
        elif self._phase != _NO_FILE:
            self._show_state("load", 0)
