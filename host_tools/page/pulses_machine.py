"""The page of a machine of pulse codes on a cable.

    machine = PulsesMachine(write, tell, board)     # a checked board file: steps/mm, the port's bits
    machine.play("back")                            # 0, or a number of errors

The PC adds jobs and teach-in. Teach-in records the steps that moves by hand have made once the machine stands.
"""

from micropython import const

from host_tools.clients.pulses_wire import PulsesWire
from host_tools.page.cable_settings import with_settings
from host_tools.page.cable_page import on_cable
from host_tools.page.jobs import with_jobs
from host_tools.page.pulses_job import PulsesJob
from host_tools.page.pulses_teach import PulsesTeach
from passo import errors
from passo.protocols.page.pulses import PulsesPage, can_of

_MOST_RUNS = const(200)  # moves by hand that are kept until the machine stands
_Cabled = with_settings(with_jobs(on_cable(PulsesPage)))


class PulsesMachine(_Cabled):
    again_ms = 1000

    def __init__(self, write, tell, board):
        self.job = PulsesJob(self, board)
        _Cabled.__init__(self, tell, PulsesWire(write, "xyz", self), board)
        self.teach = PulsesTeach(self.axes)
        self._runs = []  # lists of (axis, steps): moves by hand since the machine stood at _from
        self._from = None
        self.can = can_of(board, ("jobs", "teach", "single")) + self.tells

    # --- what the board says

    def take_line(self, line):
        """Take a line of the board that answers no command: an alarm, a stop, an error in the file, the end of a job."""
        if line[:6] == "alarm:" and line[6:].isdigit():
            self.raise_alarm(int(line[6:]))
        elif line == "stopped" or line == "ready":
            self.end_jog()
            self.job.fail(errors.STOPPED)
        elif line[:6] == "error:":
            words = line[6:].split(" ")  # 120 line 3 column 7
            if words[0].isdigit():
                self.job.note_file_error(int(words[0]), int(words[2]) if len(words) > 4 else 0, int(words[4]) if len(words) > 4 else 0)
        else:
            self.job.take_line(line)

    def _show_fields(self, report):
        """Show the report; pass it to the job and to teach-in."""
        PulsesPage._show_fields(self, report)
        state, name = self.state, report["state"]
        self.job.report(name, report["fields"])
        if name in ("idle", "hold", "alarm"):
            self._record_moves()
        self.teach.note_tool(state["tool"], state["drives"])
        state["teaching"] = self.teach.count_moves()

    def _file_moves(self, name):
        return self.job.playing and not self.job.paused

    def _port_image(self, program):
        return program["port"]

    def _take_play_answer(self, error):
        self.job.take_play_answer(error)

    # --- moves by hand

    def _record_moves(self):
        """Add the moves by hand since the machine last stood to the teach-in, with the steps that they really made, if it stands now."""
        if self._from is not None and not self.said and not self.wire.waits_for("jog") and not self.jog.waiting:
            made = [self._steps[axis] - self._from[axis] for axis in range(len(self._steps))]
            self.teach.add_moves([run for runs in self._runs for run in runs], made, self.state["feed"])
            self._runs = []
            self._from = None

    def _move_by_hand(self, steps, answered):
        """Move each axis by its `steps`, and keep them for teach-in until the machine stands. Returns 0 or an error."""
        runs = [(axis, steps[axis]) for axis in range(len(steps)) if steps[axis]]
        if len(self._runs) > _MOST_RUNS:
            return errors.TOO_MANY_WAITING

        def take_answer(error):
            if error and runs in self._runs:
                self._runs.remove(runs)
            (answered or self.note_result)(error)

        self._from = self._from or self._steps
        self._runs.append(runs)
        error = PulsesPage._move_by_hand(self, steps, take_answer)
        if error:
            self._runs.remove(runs)
        return error

    def _move_steps(self, steps):
        return errors.BUSY if self.job.is_sending() else PulsesPage._move_steps(self, steps)

    def _may_jog(self, direction):
        """True if the page may jog in this direction, and no file is on its way to the board."""
        return PulsesPage._may_jog(self, direction) and not self.job.is_sending()

    # --- orders

    def busy_error(self):
        return errors.BUSY if self.job.is_sending() else PulsesPage.busy_error(self)

    def hold(self):
        return self.stop() if self.job.is_sending() else _Cabled.hold(self)

    def play(self, what):
        """Go on with the file, see PulsesPage.play(), if the board has one. Returns 0 or an error."""
        return self.job.replay_refusal() or PulsesPage.play(self, what)
