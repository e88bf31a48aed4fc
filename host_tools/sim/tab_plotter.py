"""A plotter as the page sees it: orders in, one state out, in the plotter's language. For a browser's tab, whose line loses nothing.

    machine = PlotterMachine(write, tell, board)
    machine.feed(data, now_ms)      # bytes from the board
    machine.poll(now_ms)
    machine.job.run("square.txt", [(1, b"MOVE 200 150"), (2, b"LINE 200 550"), (3, b"END")], 1, False)

It offers what passo.web.grbl_machine does, as far as the language has words for it. A job is in the words of `passo send`: MOVE
and LINE with a place in steps, and END, which draws what has been sent.
"""

from passo import errors
from passo.protocols.plotter.host import ANSWERS, COMMANDS, STATUS_LENGTH, packet, status_from

_ASK_MS = 100
_SILENT_MS = 1500
_MOST_LOG = 100
_STATES = {"idle": "Idle", "run": "Run", "home": "Home", "jog": "Jog", "alarm": "Alarm", "hold": "Hold"}
_ANSWER_TO = {"LINE": "NEXT", "MOVE": "NEXT", "END": "DONE", "SPEED": "SPEED_OK"}
_MOST_PLACE = 65535


def read_line(line):
    """(name, packet) of a line of a job, or None: no words of the language."""
    words = line.decode().upper().split()
    wanted = {"END": 0, "SPEED": 1, "LINE": 2, "MOVE": 2}.get(words[0])
    if wanted is None or len(words) != 1 + wanted or [word for word in words[1:] if not word.isdigit()]:
        return None
    values = [int(word) for word in words[1:]]
    if [value for value in values if value > _MOST_PLACE]:
        return None
    return words[0], packet(COMMANDS[words[0]], *values)


class PlotterJob:
    """Lines to the board, each as the one before has been answered."""

    def __init__(self, machine):
        self._machine = machine
        self._lines = None

    def running(self):
        return self._lines is not None

    def run(self, name, lines, passes, checked, single=False):
        """Begin; `checked`: the lines are only read; `single`: always, as each waits for the answer before. Returns 0 or an error."""
        self._name, self._lines, self._passes, self._checked = name, lines, passes, checked
        self._pass = 1
        self._at = 0
        for at, (_, line) in enumerate(lines):
            if read_line(line) is None:
                self._at = at + 1
                self._end("failed", errors.UNKNOWN_COMMAND)
                return errors.UNKNOWN_COMMAND
        if checked or not lines:
            self._at = len(lines)
            self._end("done", 0)
        else:
            self._send()
        return 0

    def _send(self):
        self._sent, data = read_line(self._lines[self._at][1])
        self._machine.write(data)
        self._tell("run", 0)

    def answered(self, answer):
        """A byte of the board, by its name."""
        if self._lines is None or answer != _ANSWER_TO[self._sent]:
            return
        self._at += 1
        if self._at < len(self._lines):
            self._send()
        elif self._pass < self._passes:
            self._pass += 1
            self._at = 0
            self._send()
        else:
            self._end("done", 0)

    def abort(self):
        return self._machine.stop()

    def fail(self, error):
        if self._lines is not None:
            self._end("failed", error)

    def _end(self, how, error):
        self._tell(how, error)
        self._lines = None

    def _tell(self, how, error):
        at = self._at
        self._machine.state["job"] = {
            "name": self._name, "how": how, "error": error, "line": self._lines[at - 1][0] if at else 0, "lines": len(self._lines),
            "done": at, "pass": self._pass, "passes": self._passes, "checked": self._checked,
        }  # fmt: skip


class PlotterMachine:
    language = "plotter"
    can = ("home", "jobs", "log")
    orders = {}

    def __init__(self, write, tell, board):
        """`write(bytes)`: to the board; `tell(dict)`: to the page."""
        self.write = write
        self._tell = tell
        self.axes = "".join([axis["name"] for axis in board["axes"]])
        self._scale = [axis["steps_per_m"] / 1000 for axis in board["axes"]]
        self.settings = {}
        self.job = PlotterJob(self)
        self._buffer = b""
        self._asked_ms = self._heard_ms = self._now_ms = 0
        self._log = []
        self.state = {"link": False, "state": "", "owner": "page", "alarm": 0, "job": None, "m": [], "w": []}

    def feed(self, data, now_ms):
        self._now_ms = now_ms
        self._buffer += bytes(data)
        while self._buffer:
            if self._buffer[0] == COMMANDS["STATUS"]:
                if len(self._buffer) < STATUS_LENGTH:
                    return
                self._status(status_from(self._buffer[:STATUS_LENGTH]))
                self._buffer = self._buffer[STATUS_LENGTH:]
            else:
                answer = ANSWERS.get(self._buffer[0])
                self._buffer = self._buffer[1:]
                self.job.answered(answer)

    def _status(self, status):
        state = self.state
        self._heard_ms = self._now_ms
        state["link"] = True
        state["state"] = _STATES[status["state"]]
        state["m"] = state["w"] = [status["xy"[axis]] / self._scale[axis] for axis in range(2)]
        number = status["error"]
        state["alarm"] = number if state["state"] == "Alarm" else 0
        if number:
            self.job.fail(number)
            self._note(number)

    def poll(self, now_ms):
        self._now_ms = now_ms
        if (now_ms - self._asked_ms) % (1 << 29) >= _ASK_MS:
            self._asked_ms = now_ms
            self.write(packet(COMMANDS["STATUS"]))
        if (now_ms - self._heard_ms) % (1 << 29) > _SILENT_MS:
            self.state["link"] = False

    def beat(self, number):
        """There is no jog here that lasts from report to report."""

    def shown(self):
        return self.state

    def _note(self, number):
        self._log = (self._log + [number])[-_MOST_LOG:]
        self._tell({"t": "log", "log": [number]})

    def log(self):
        return self._log

    def refusal(self):
        return 0 if self.state["link"] else errors.NO_ANSWER

    def still(self):
        return errors.BUSY if self.job.running() or self.state["state"] not in ("Idle", "Alarm") else 0

    def absent(self):
        """Who has the tab is at the machine."""
        return 0

    def stop(self):
        self.write(packet(COMMANDS["STOP"]))
        self.job.fail(errors.STOPPED)
        return 0

    def home(self):
        self.write(packet(COMMANDS["ORIGIN"]))
        return 0

    def end_jog(self):
        pass

    def _wordless(self, *_):
        """The language has no word for it."""
        return errors.UNKNOWN_COMMAND

    hold = resume = unlock = zero = go = step = begin_jog = override = output = set = line = give = play = _wordless

    def renew(self, number, beat):
        return False
