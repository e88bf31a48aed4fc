"""A job under way: lines to the board as it has room, until the last one has been carried out.

    job = Job(machine)
    error = job.run("part.gcode", lines, 1, False)      # [(number, bytes)], passes, only checked
    job.poll()                                          # sends what there is room for

At the first refused line it holds the machine on its path, drops what is queued and tells which line it was.
"""

from host_tools.clients.grbl_wire import LOST, PAGE
from host_tools.programs.program_lines import first_job_error
from passo import errors

_HELD = ("Hold", "Idle", "Alarm", "Check", "Door")


class Job:
    def __init__(self, machine):
        self._machine = machine
        self._lines = None
        self._halting = False  # on its way to a stand, then it is dropped
        self._idle = 0  # reports in a row that say that nothing moves
        self._foreign = 0  # answers to nobody, as it began
        self._failed_line = 0
        self.name = ""

    def is_running(self):
        return self._lines is not None

    def run(self, name, lines, passes, checked, single=False):
        """Begin; `checked`: the board only looks at the lines; `single`: step_line() says when a line goes. Returns 0 or an error."""
        machine = self._machine
        error = machine.busy_error()
        if error or machine.state["state"] not in ("Idle", "Check"):
            return error or errors.BUSY
        number, error = first_job_error(lines)
        if error:
            return {"error": error, "line": number}
        self.name = name
        self._lines = lines
        self._passes = passes
        self._pass = 1
        self._at = 0  # the next to be sent
        self._done = 0  # answered
        self._checked = checked
        self._single = single
        self._most = 0 if single else len(lines)  # the number of lines that may be sent so far
        self._failed = 0
        self._failed_line = 0
        self._idle = 0
        self._halting = False
        self._foreign = machine.wire.foreign
        if checked:
            machine.send_line(b"$C")
        self._show_state("run", 0)
        return 0

    def poll(self):
        """Send lines until there is no more room. Ends the job if another program sends lines to the board."""
        if self._lines is None or self._halting:
            return
        wire = self._machine.wire
        if wire.foreign != self._foreign:  # its answers are not all this job's
            self._failed = errors.FOREIGN_ANSWER
            self.abort()
            return
        while self._at < self._most:
            if not wire.send_line(PAGE, self._lines[self._at][1], self._count_answer):
                return
            self._at += 1

    def play(self, what):
        """Go on with a job that goes line by line: "step", one line; "run", all the rest. Returns 0 or an error."""
        return self.step_line() if what == "step" else self.run_rest() if what == "run" else errors.UNKNOWN_COMMAND

    def step_line(self):
        """Send one more line if the lines before it are done; stop a job that runs by itself behind the lines sent. Returns 0 or an error."""
        if self._lines is None or self._halting or self._checked:
            return errors.NO_SUCH_JOB
        if not self._single:
            self._single = True
            self._most = self._at
        elif self._done < self._at or self._machine.state["state"] != "Idle":
            return errors.BUSY
        else:
            self._most = self._at + 1
        return 0

    def run_rest(self):
        """Send the rest of the lines without waiting for step_line(). Returns 0 or an error."""
        if self._lines is None or self._halting:
            return errors.NO_SUCH_JOB
        self._single = False
        self._most = len(self._lines)
        return 0

    def take_line(self, line):
        """Take a line in brackets. Returns True if it is meant for the job alone, so that no page shows it."""
        return False

    def report(self, state):
        """Take a report: ends a pass after two idle reports, drops a job that has come to its stand. `state`: its first word, "" while it brakes."""
        if self._lines is None:
            return
        if self._halting:
            if state in _HELD:
                self._machine.stop()
            return
        if self._done < len(self._lines):
            self._idle = 0
            return
        self._idle = self._idle + 1 if state in ("Idle", "Check") else 0
        if self._idle < 2:
            return
        if self._pass < self._passes and not self._checked:
            self._pass += 1
            self._at = self._done = 0
            self._most = 0 if self._single else len(self._lines)
            self._show_state("run", 0)
        else:
            self._end_job("done", 0)

    def abort(self):
        """Hold the machine on its path; report() drops the rest of the job once it stands. Returns 0."""
        if self._lines is None:
            return 0
        self._halting = True
        self._failed = self._failed or errors.STOPPED
        self._machine.hold()
        return 0

    def fail(self, error):
        """End the job as failed with an error from outside: a stop, an alarm, a lost board."""
        if self._lines is not None:
            if error == errors.ALARM_SOFT_LIMIT and not self._failed and self._done < self._at:
                self._failed_line = self._lines[self._done][0]  # told before the line that it is of is answered
            elif self._failed in (0, errors.STOPPED) and not self._failed_line:
                self._failed_line = self._machine.state.get("line") or 0  # the line being executed; the board has answered later ones
            self._end_job("failed", self._failed or error)

    def line_number(self):
        """The number, in the file, of the refused line, or of the line that the board answered last; 0: none yet."""
        return self._failed_line or self._lines[self._done - 1][0] if self._lines and self._done else 0

    def _count_answer(self, error):
        """Count the answer to a line of the job; at its first error hold the machine, or end a checked job."""
        if error == LOST or self._lines is None:
            return
        self._done += 1
        if error and not self._halting:
            self._failed = error
            self._failed_line = self.line_number()
            if self._checked:
                self._end_job("failed", error)
            else:
                self._machine.note_result(error)
                self.abort()

    def _end_job(self, how, error):
        """End the job, show the result on all pages, and leave check mode."""
        checked = self._checked
        self._show_state(how, error)
        self._lines = None
        if checked:
            self._machine.leave_check()  # $C would be the next line of those under way

    def _show_state(self, how, error):
        """Show the job on all pages: `how` is "run", "done" or "failed"."""
        self._machine.state["job"] = self.job_fields(how, error)

    def job_fields(self, how, error):
        """The job's fields for the state, a dict. `how`: "run", "done" or "failed"; `error`: its number."""
        return {
            "name": self.name, "how": how, "error": error, "line": self.line_number(), "lines": len(self._lines), "done": self._done,
            "pass": self._pass, "passes": self._passes, "checked": self._checked, "single": self._single,
        }  # fmt: skip

    def refresh_state(self):
        """Bring the state's "job" up to date for the pages."""
        if self._lines is not None:
            self._show_state("halting" if self._halting else "run", 0)
