"""A machine that speaks the language of pulse codes, as the page sees it: orders in, one state out.

    machine = PulsesMachine(write, tell, board)     # a checked board file: steps/mm, the port's bits
    machine.feed(data, now_ms)
    machine.poll(now_ms)
    machine.play("back")                            # 0, or a number of errors

Moves by hand are steps of one axis after the other, at the speed in force. A jog ends at the next step by {pause}; the hold that is
left behind it is taken off by a jog of no steps. What was moved by hand at a pause of the file, {return} undoes.
"""

from micropython import const

from host_tools.page.cable_machine import CableMachine
from host_tools.page.pulses_job import PulsesJob
from host_tools.page.pulses_teach import PulsesTeach
from host_tools.page.pulses_wire import PulsesWire
from passo import errors
from passo.protocols.page.jog import Limits
from passo.protocols.page.orders import number
from passo.protocols.page.pulses import can_of
from passo.protocols.page.steps import steps_by, steps_to
from passo.protocols.pulses.report import status_from

_MOST_STEPS = const(999_999)  # of one axis in one jog
_MOST_WORDS = const(9)  # in one command
_MOST_RUNS = const(200)  # moves by hand that are kept until the machine stands
_PLAYS = {
    "run": ("run",), "back": ("back",), "step": ("step",), "step_back": ("step", "back"), "return": ("return",),
    "return_back": ("return", "back"), "continue": ("continue",), "continue_back": ("continue", "back"),
}  # fmt: skip
_OUTPUTS = ("tool", "drives", "motors")


class PulsesMachine(CableMachine):
    language = "pulses"
    again_ms = 1000
    jogs_from = ("Idle", "Jog", "Hold")

    def __init__(self, write, tell, board):
        CableMachine.__init__(self, tell, PulsesJob(self, board), board)
        self.wire = PulsesWire(write, self._heard)
        self.axes = self.axes[:3]
        self.teach = PulsesTeach(self.axes)
        self._steps = None  # the last place that was told
        self._runs = []  # lists of (axis, steps): moves by hand since the machine stood at _from
        self._from = None
        self._cut = False  # a jog was cut: its hold is to be taken off
        self._said = None  # steps up to which the jog is said
        self.orders = {"pace": self._pace}
        self.can = can_of(board, ("jobs", "teach", "single"))

    # --- bytes

    def feed(self, data, now_ms):
        self._now_ms = now_ms
        self.wire.feed(data)

    def _ask(self):
        self.wire.say(("?",), None)

    def _lose(self):
        self.wire.drop()
        CableMachine._lose(self)

    def _go_on(self):
        if self._cut and self.state["state"] == "Hold" and not self.jog.waiting:
            self._cut = not self._say(("jog", self.axes[0], 0))

    def _heard(self, line):
        """A line that answers nothing, or a status."""
        if line[:1] == "<":
            try:
                self._report(status_from(line))
            except (ValueError, KeyError):
                pass
        elif line[:6] == "alarm:" and line[6:].isdigit():
            self.end_jog()
            self.job.fail(int(line[6:]))
            self.note(int(line[6:]))
        elif line == "stopped" or line == "ready":
            self.end_jog()
            self.job.fail(errors.STOPPED)
        elif line[:6] == "error:":
            words = line[6:].split(" ")  # 120 line 3 column 7
            if words[0].isdigit():
                self.job.wrong(int(words[0]), int(words[2]) if len(words) > 4 else 0, int(words[4]) if len(words) > 4 else 0)
        else:
            self.job.heard(line)

    def _report(self, fields):
        state = self.state
        place = [int(part) for part in fields["place"].split(",")]
        self._reported()
        name = fields["state"]
        playing = self.job.playing
        moving_by_hand = name == "run" and (not playing or self.job.paused)
        state["state"] = "Jog" if moving_by_hand else name[:1].upper() + name[1:]
        state["alarm"] = int(fields["error"]) if name == "alarm" else 0
        self._steps = place
        self.place = state["m"] = state["w"] = [round(place[axis] / self.scale[axis], 4) for axis in range(len(place))]
        state["feed"] = float(fields["speed"])
        state["wait"] = int(fields["wait"]) / 1000
        state["tool"] = fields["tool"] == "1"
        state["drives"] = fields["drives"] == "1"
        state["ours"] = fields.get("ours", "1") == "1"
        state["port"] = int(fields["port"], 16)
        state["manual"] = int(fields["manual"])
        state["asked"] = fields["ask"] == "1"
        self.job.report(name, fields)
        if name in ("idle", "hold", "alarm"):
            self._stood(place)
        if self.jog.active:
            self.jog.report(self.place)
        self.teach.on(state["tool"], state["drives"])
        state["teaching"] = self.teach.places()
        if self.watcher:
            self.watcher(state)

    # --- moves by hand

    def _stood(self, place):
        """The machine stands: what was moved by hand since it last did is known now."""
        if self._from is not None and not self.wire.waits_for("jog") and not self.jog.waiting:
            self.teach.moved([run for runs in self._runs for run in runs], [place[axis] - self._from[axis] for axis in range(len(place))], self.state["feed"])
            self._runs = []
            self._from = None

    def _by_hand(self, steps, answered):
        """Move so many steps of each axis, one axis after the other; False if it cannot be said now."""
        words = ["jog"]
        runs = []
        for axis in range(len(steps)):
            left = steps[axis]
            while left:
                part = max(-_MOST_STEPS, min(_MOST_STEPS, left))
                words += [self.axes[axis], part]
                runs.append((axis, part))
                left -= part
        if len(words) > _MOST_WORDS or len(self._runs) > _MOST_RUNS:
            return False

        def done(error):
            if error and runs in self._runs:
                self._runs.remove(runs)
            answered(error)

        if not self.wire.say(words, done):
            return False
        self._cut = False
        if self._from is None:
            self._from = self._steps
        self._runs.append(runs)
        return True

    def _move(self, steps):
        if self.state["state"] not in ("Idle", "Hold") or self.jog.active or self.job.sending():
            return errors.BUSY
        if not [part for part in steps if part]:
            return 0
        return 0 if self._by_hand(steps, self.finished) else errors.TOO_MANY_WAITING

    def step(self, way, speed):
        """{axis: mm} from here."""
        return self._move(steps_by(way, self.axes, self.scale))

    def go(self, place, speed):
        """{axis: mm}, one axis after the other."""
        if self._steps is None:
            return errors.BUSY
        wanted = steps_to(place, self.axes, self.scale, self._steps)
        return self._move([to - at for to, at in zip(wanted, self._steps)])

    def _may_jog(self, direction):
        one = len([part for part in direction if part]) == 1
        return one and len(direction) == len(self.axes) and self._steps is not None and not self.job.sending()

    def _start_jog(self, direction, speed):
        self._said = list(self._steps)
        CableMachine._start_jog(self, direction, self.state["feed"])

    def _limits(self):
        axes = [self.state["feed"]] * len(self.place)
        return Limits(axes, [1e9] * len(axes))

    def _say_jog(self, place, speed):
        steps = [round(place[axis] * self.scale[axis]) - self._said[axis] for axis in range(len(place))]
        if not self._by_hand(steps, self.jog_answered):
            return False
        self._ahead = steps
        return True

    def jog_answered(self, error):
        if not error:
            self._said = [self._said[axis] + self._ahead[axis] for axis in range(len(self._said))]
        CableMachine.jog_answered(self, error)

    def _brake(self):
        self._cut = True
        self._say(("pause",))

    # --- orders

    def _say(self, words):
        """Say it; True if there was room."""
        return self.wire.say(words, self.finished)

    def _order(self, *words):
        return 0 if self._say(words) else errors.TOO_MANY_WAITING

    def still(self):
        if self.job.sending() or self.jog.active or not self.stands():
            return errors.BUSY
        return 0

    def stop(self):
        """Stop at once: the file is at its start then, the tool off."""
        self.drop_jog()
        self.job.fail(errors.STOPPED)
        self._cut = False
        self.wire.say_always(("stop",), self.finished)
        return 0

    def hold(self):
        self.end_jog()
        return self.stop() if self.job.sending() else self._order("pause")

    def resume(self):
        return self.play("run")

    def home(self):
        return self._order("home")

    def unlock(self):
        return self._order("unlock")

    def play(self, what):
        """Go on with the file: run, back, step, step_back; after moves by hand return or continue, each also _back."""
        words = _PLAYS.get(what)
        if words is None:
            return errors.UNKNOWN_COMMAND
        return self.job.play(words)

    def _pace(self, order):
        """mm/min from now on, up to the file's next speed."""
        return self.refusal() or self._order("speed", int(number(order, "speed", 1, 900_000)))

    def output(self, name, rpm):
        what, _, on = name.partition("_")
        if what not in _OUTPUTS or on not in ("on", "off"):
            return errors.NUMBER
        return self.still() or self._order(what, on)

    def give(self, owner):
        """Take the command from another link; the page gives it to none."""
        return self._order("link") if owner == "page" else errors.UNKNOWN_COMMAND
