"""The page of a machine that plays files of pulse codes: they are played, turned round and stepped; moves by hand go one axis after the other.

    machine = PulsesPage(record, number, board, tell, language)     # which knows the image of the parallel port

Moves by hand are steps of one axis after the other, at the speed in force. A jog ends at the next step by a hold; the hold that is left
behind it is taken off by a jog of no steps. Moves by hand at a pause of the file are undone by "return".
"""

from micropython import const

from passo import commands, errors
from passo.commands import Command
from passo.options.step_program.commands import (
    STEPS_CONTINUE, STEPS_GO, STEPS_HAND_DRIVES, STEPS_HAND_TOOL, STEPS_JOG, STEPS_PACE, STEPS_RETURN, STEPS_STEP, STEP_PROGRAM,
)  # fmt: skip
from passo.protocols.page.orders import number_field
from passo.protocols.page.page_machine import PageMachine

_MOST_STEPS = const(999_999)  # of one axis in one jog
_FASTEST = const(900_000)  # mm/min
_PLAYS = {"run": STEPS_GO, "step": STEPS_STEP, "return": STEPS_RETURN, "continue": STEPS_CONTINUE}
_HANDS = {"tool": STEPS_HAND_TOOL, "drives": STEPS_HAND_DRIVES}


def can_of(board, more=()):
    """The orders of a board's page, a tuple; `more`: those of the server."""
    words = ["place", "jog", "step", "goto", "unlock", "hold", "resume", "log", "program", "pace", "port", "tool", "drives"]
    words += more
    if board["homing"]:
        words.append("home")
    if [output for output in board["outputs"] if output.get("role") == "ours"]:
        words.append("motors")
    return tuple(words)


class PulsesPage(PageMachine):
    language = "pulses"
    jogs_from = ("Idle", "Jog", "Hold")

    def __init__(self, record, number, board, tell, language):
        self.can = can_of(board)
        PageMachine.__init__(self, record, number, board, tell)
        self._image = language and language.port_byte  # None on a PC: the wire has it
        self._config = board["step_program"]
        self.axes = self.axes[:3]
        self._steps = None
        self._begun = None  # steps up to which the jog is queued
        self._ahead = None  # of the piece that is not answered
        self._cut = False  # a jog was cut: its hold is to be taken off
        self._releasing = False  # asked for, and not answered
        self._playing = False  # the motion is that of the file
        self.orders = {"pace": self._set_pace}

    # --- what the machine says

    def _show_fields(self, report):
        """Show position in mm, feed in mm/min, tool and port; take off the hold of a jog that was cut."""
        state = self.state
        program = report["step_program"]
        name = report["state"]
        if not self._file_moves(name) and name == "run":
            state["state"] = "Jog"
        self._steps = list(report["position"])
        self.position = state["m"] = state["w"] = [round(self._steps[axis] / self.scale[axis], 4) for axis in range(len(self._steps))]
        state["feed"] = program["speed"] / 10
        state["wait"] = program["wait_ms"] / 1000
        state["tool"], state["drives"] = bool(program["tool"]), bool(program["drives"])
        state["ours"] = report.get("ours", True)
        state["port"] = self._port_image(program)
        state["manual"] = program["manual"]
        state["asked"] = bool(program["asked"])
        if self._cut and name == "hold" and not self.jog.waiting:
            self._cut = False
            self._releasing = True
            self._move_by_hand([0] * len(self.axes), self._hold_released)
        if self.jog.active:
            self.jog.report(self.position)

    def _file_moves(self, name):
        """True if the motion is the file's. `name`: of the machine's state."""
        if name != "run" and name != "hold":
            self._playing = False
        return self._playing or self.runs_stored()

    def _port_image(self, program):
        return self._image(program["moving"] | program["negative"] << 4, program["tool"], program["drives"], self._config)

    # --- moves by hand

    def _move_by_hand(self, steps, answered):
        """Move each axis by its `steps`, one axis after the other."""
        if max([abs(part) for part in steps]) > _MOST_STEPS:
            return errors.TRAVEL
        if [part for part in steps if part]:
            self._cut = self._releasing = False
        return self.queue_command(Command(STEP_PROGRAM, steps, STEPS_JOG), answered)

    def _hold_released(self, error):
        """A machine says that it holds some steps before it stands, and is busy until then: ask again behind its next report."""
        if error == errors.BUSY and self._releasing:
            self._cut = True
        else:
            self.note_result(error)
        self._releasing = False

    def _move_steps(self, steps):
        if self.state["state"] not in ("Idle", "Hold") or self.jog.active:
            return errors.BUSY
        return self._move_by_hand(steps, None) if [part for part in steps if part] else 0

    def step_by(self, way, speed):
        """Move by `way`, {axis: mm}, one axis after the other, at the speed in force. Returns 0 or an error."""
        return self._move_steps(self._steps_by(way))

    def go_to(self, position, speed):
        """Move to `position`, {axis: mm}, one axis after the other, at the speed in force. Returns 0 or an error."""
        if self._steps is None:
            return errors.BUSY
        wanted = self._steps_to(position, self._steps)
        return self._move_steps([to - at for to, at in zip(wanted, self._steps)])

    def _may_jog(self, direction):
        one = len([part for part in direction if part]) == 1
        return one and len(direction) == len(self.axes) and self._steps is not None

    def _start_jog(self, direction, speed):
        """Begin the jog from the present steps, at the speed in force."""
        self._begun = list(self._steps)
        PageMachine._start_jog(self, direction, self.state["feed"])

    def _limits(self):
        limits = PageMachine._limits(self)
        limits.speeds = [self.state["feed"]] * len(self.position)
        return limits

    def _queue_jog(self, position, speed):
        steps = [round(position[axis] * self.scale[axis]) - self._begun[axis] for axis in range(len(position))]
        self._ahead = steps
        return not self._move_by_hand(steps, self.jog_answered)

    def jog_answered(self, error):
        """Take the answer to a piece of the jog: count its steps if it was accepted."""
        if not error:
            self._begun = [self._begun[axis] + self._ahead[axis] for axis in range(len(self._begun))]
        PageMachine.jog_answered(self, error)

    def _brake(self):
        self._cut = True
        self.queue_command(Command(commands.HOLD))

    # --- orders

    def busy_error(self):
        """0, or BUSY while something moves; commands under way do not count, because a hold may come amid them."""
        return errors.BUSY if self.jog.active or not self.is_at_rest() else 0

    def stop(self):
        """Queue a stop at once: the file goes to its start, the tool off. Returns 0 or an error."""
        self._cut = self._releasing = False
        return PageMachine.stop(self)

    def resume(self):
        return self.play("run")

    def play(self, what):
        """Go on with the file. `what`: run, back, step, step_back; after moves by hand return or continue, each also with _back.
        Returns 0 or an error."""
        verb, _, back = ("run_back" if what == "back" else what).partition("_")
        if verb not in _PLAYS or back not in ("", "back"):
            return errors.UNKNOWN_COMMAND
        return self.queue_command(Command(STEP_PROGRAM, None, _PLAYS[verb], back == "back"), self._take_play_answer)

    def _take_play_answer(self, error):
        self._playing = self._playing or not error
        self.note_result(error)

    def _set_pace(self, order):
        """Set the speed in mm/min, until the file's next speed. Returns 0 or an error. Raises Wrong."""
        command = Command(STEP_PROGRAM, None, STEPS_PACE)
        command.feed = int(number_field(order, "speed", 1, _FASTEST))
        return self.refusal() or self.queue_command(command)

    def set_output(self, name, rpm):
        """Switch motors, tool or drives; `name`: such as "tool_on". Returns 0 or an error."""
        what, _, on = name.partition("_")
        if on not in ("on", "off") or what != "motors" and what not in _HANDS:
            return errors.NUMBER
        if what == "motors":
            return self.busy_error() or self.queue_command(Command(commands.CONNECT, value=1 if on == "on" else 0))
        return self.busy_error() or self.queue_command(Command(STEP_PROGRAM, None, _HANDS[what], on == "on"))
