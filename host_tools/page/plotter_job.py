"""A drawing under way in the plotter's packets: each line as the one before has been answered; point by point, and back the same way.

    job = PlotterJob(machine)
    job.run("square.txt", [(1, b"MOVE 200 150"), (2, b"LINE 200 550"), (3, b"END")], 1, False)
    job.play("step")                    # one point more, then it stands; also of a job that runs
    job.play("step_back")               # to the point before it, pen up; "back": to the first one, "run": forward, all the rest

The language has no word for pause: a job that goes point by point sends END behind each of them, so the pen is up where it stands.
Points already sent are drawn before a job that runs comes to its stand.
"""

from micropython import const

from passo import commands, errors
from passo.commands import Command
from passo.protocols.page.plotter import MOST_PLACE

_KINDS = {"MOVE": commands.POINT, "LINE": commands.POINT, "SPEED": commands.SPEED, "END": commands.DRAW}
_WORDS = {"END": 0, "SPEED": 1, "LINE": 2, "MOVE": 2}


def read_line(line):
    """(name, x, y) of a job's line, bytes; x and y in steps, 0 if it has none; None: it is no line of the language."""
    words = line.decode().upper().split()
    wanted = _WORDS.get(words[0]) if words else None
    if wanted is None or len(words) != 1 + wanted or [word for word in words[1:] if not word.isdigit() or len(word) > 5]:
        return None
    values = [int(word) for word in words[1:]] + [0, 0]
    return None if max(values) > MOST_PLACE else (words[0], values[0], values[1])


class PlotterJob:
    def __init__(self, machine):
        self._machine = machine
        self._lines = None
        self._ended = None  # the lines of a job that is done: it may go back from there
        self._backward = False
        self._open = 0

    def is_running(self):
        return self._lines is not None

    def run(self, name, lines, passes, checked, single=False):
        """Begin a job of `lines`, [(number, bytes)], `passes` times. `checked`: only read them; `single`: draw a point at each play("step").
        Returns 0 or an error."""
        if self._machine.busy_error():
            return errors.BUSY
        self._name, self._lines, self._passes, self._checked = name, lines, passes, checked
        self._begin_at(0, single)
        for at in range(len(lines)):
            if read_line(lines[at][1]) is None:
                self._at = at + 1
                self._end_job("failed", errors.UNKNOWN_COMMAND)
                return errors.UNKNOWN_COMMAND
        if checked or not lines:
            self._at = len(lines)
            self._end_job("done", 0)
        else:
            self._send_next()
        return 0

    def _begin_at(self, at, single):
        """Set all counters for a job that begins, or is taken up, at line index `at`."""
        self._pass = 1
        self._at = at  # the line that is sent next, or under way
        self._first = -1  # line of the object's first point
        self._open = 0  # points sent of an object that has no END yet
        self._drawn = 0  # of these
        self._single = single
        self._granted = False  # one line more may go
        self._backward = self._once = False
        self._busy = False  # a packet is not answered

    # --- forward

    def _send_next(self):
        """Send the next packet of the job, forward or backward, if no packet is under way."""
        if self._lines is None or self._busy:
            return
        if self._backward:
            self._go_back()
        elif self._single and self._open:
            self._send_packet("END", 0, 0, self._take_end)
        elif not self._single or self._granted:
            self._granted = False
            self._send_forward()
        if self._lines is not None:
            self._show_state("run", 0)

    def _send_forward(self):
        """Send the packet of the next line; behind the last line begin the next pass, or end the job."""
        while self._single and self._at < len(self._lines) and self._name_at(self._at) == "END":
            self._at += 1  # each point has had its own
        if self._at < len(self._lines):
            name, x, y = read_line(self._lines[self._at][1])
            if name in ("LINE", "MOVE"):
                if not self._open:
                    self._first = self._at
                self._open += 1
            self._send_packet(name, x, y, self._take_answer)
        elif self._pass < self._passes:
            self._pass += 1
            self._at = 0
            self._send_next()
        else:
            self._end_job("done", 0)

    def _send_packet(self, name, x, y, answered):
        self._busy = True
        tool = name == "LINE"
        self._machine.queue_command(Command(_KINDS[name], (x, y) if tool or name == "MOVE" else None, x, tool), answered)

    def _ends_with(self, error):
        """Take the error of an answer, 0: none. Returns True if the job has ended, or ends now because of it."""
        self._busy = False
        if self._lines is not None and error:
            self._end_job("failed", error)
        return self._lines is None

    def _take_answer(self, error):
        """Take the answer to a line's packet, and send the next."""
        if not self._ends_with(error):
            if self._name_at(self._at) == "END":
                self._close_object()
            elif self._open == 1:
                self._drawn = 0  # reports before this answer count the object before
            self._at += 1
            self._send_next()

    def _take_end(self, error):
        if not self._ends_with(error):
            self._close_object()
            self._send_next()

    def _close_object(self):
        """Forget the points of the object: it is drawn."""
        self._open = self._drawn = 0
        self._first = -1

    # --- backward

    def _name_at(self, at):
        return read_line(self._lines[at][1])[0]

    def _point_before(self, at):
        """The last line before `at` that has a point, or -1."""
        while at > 0:
            at -= 1
            if self._name_at(at) in ("LINE", "MOVE"):
                return at
        return -1

    def _back_to(self):
        """The line of the point before the one at which the machine stands, or -1."""
        return self._point_before(self._point_before(self._at))

    def _go_back(self):
        """Send MOVE to the point before the one at which the machine stands; at the first point go forward again."""
        to = self._back_to()
        if to < 0:
            self._backward = False
            return
        _, x, y = read_line(self._lines[to][1])
        self._send_packet("MOVE", x, y, self._end_back)

    def _end_back(self, error):
        if not self._ends_with(error):
            self._send_packet("END", 0, 0, self._arrive_back)

    def _arrive_back(self, error):
        """Note that the machine stands one point further back, and send the next line."""
        if not self._ends_with(error):
            self._at = self._back_to() + 1
            if self._once:
                self._backward = False
            self._send_next()

    # --- orders

    def play(self, what):
        """Go on with the job: `what` is step, step_back, back or run. Returns 0 or an error."""
        if what not in ("step", "step_back", "back", "run"):
            return errors.UNKNOWN_COMMAND
        if self._lines is None and (what in ("step", "run") or not self._at_its_end()):
            return errors.NO_SUCH_JOB
        if what == "run" or what == "step" and (self._backward or not self._single):
            self._backward = False
            self._single = what == "step"  # points already sent are drawn
        elif self._busy or self._backward:
            return errors.BUSY
        else:
            self._granted = what == "step"
            self._backward = not self._granted
            self._once = what == "step_back"
        self._send_next()
        return 0

    def _at_its_end(self):
        """Take up a job that is done, if the pen still stands at its end, so that it can go back. Returns False if not."""
        lines = self._ended
        if lines is None or self._machine.busy_error():
            return False
        self._lines = lines
        if not self._machine.stands_at(read_line(lines[max(0, self._point_before(len(lines)))][1])):
            self._lines = self._ended = None
            return False
        self._begin_at(len(lines), True)
        return True

    def pen_is_down(self):
        """Return whether the pen draws to the point under way; None: the motion is not of this job."""
        if self._lines is None or not self._open:
            return None if self._lines is None or not self._backward else False
        return self._drawn < self._open and self._name_at(self._first + self._drawn) == "LINE"

    def report(self, drawn):
        """Take from a STATUS how many points of the object have been drawn."""
        self._drawn = drawn

    def poll(self):
        """Do nothing: answers make the job go on."""

    def refresh_state(self):
        if self._lines is not None:
            self._show_state("run", 0)

    def abort(self):
        return self._machine.stop() if self.is_running() else 0

    def fail(self, error):
        if self._lines is not None:
            self._end_job("failed", error)

    def _end_job(self, how, error):
        self._show_state(how, error)
        self._ended = self._lines if how == "done" and not self._checked else None
        self._lines = None

    def _show_state(self, how, error):
        """Show the job on all pages. `how`: "run", "done" or "failed"; `error`: its number."""
        at = self._at
        if how == "run" and self._first >= 0:
            at = min(at, self._first + self._drawn)  # of the lines sent, those drawn
        self._machine.state["job"] = {
            "name": self._name, "how": how, "error": error, "line": self._lines[at - 1][0] if at else 0, "lines": len(self._lines),
            "done": at, "pass": self._pass, "passes": self._passes, "checked": self._checked, "single": self._single,
            "back": how == "done" and not self._checked or self._single and not self._busy and self._back_to() >= 0,
        }  # fmt: skip
