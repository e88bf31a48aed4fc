"""How a step program comes to the machine: stored whole, or played as it comes; its items are those of passo/commands.py."""

from array import array
from micropython import const

from passo import commands, errors
from passo.commands import SPOT_AXES, SPOT_BACK, SPOT_INDEX, SPOT_TIMES
from passo.config import setting_numbers as table
from passo.control.feature import Feature
from passo.errors import LATER
from passo.motion import step_program as marks
from passo.motion.integers import isqrt
from passo.motion.step_program import StepProgram
from passo.motion.step_program_walker import StepProgramWalker
from passo.records import COUNT_MASK

_GATHER_MS = const(50)  # how long a stream is waited for, so that it sets out with some of it in hand

# STATION's values.
DRIVES_OFF = const(0)
DRIVES_ON = const(1)
ASK = const(2)  # the operator sets the speed

# What is walked.
IDLE = const(0)
RUN = const(1)
HAND = const(2)  # manual moves
RETURN = const(3)  # the way back of the manual moves

_KINDS = {
    commands.STEPS_WAIT: marks.DWELL,
    commands.STEPS_TOOL: marks.TOOL,
    commands.STEPS_SPEED: marks.SPEED,
}


def lengths_of(axes):
    """For each mask of `axes` (of the board file) how far a step of them goes, nm × 60."""
    lengths = array("i", [0] * (1 << len(axes)))
    for mask in range(1, len(lengths)):
        total = 0
        for axis in range(len(axes)):
            if mask >> axis & 1:
                total += (60_000_000_000 * 1024 // axes[axis]["steps_per_m"]) ** 2
        lengths[mask] = (isqrt(total) + 512) >> 10
    return lengths


class StepProgramIntake(Feature):
    """The part of the feature that takes a step program in."""

    def __init__(self, board, machine, queue):
        config = board["step_program"]
        axes = board["axes"]
        self._queue = queue
        self._machine = machine
        self._dry_run = config["dry_run"]
        self._default = config["default_mm_min"]
        self._lengths = lengths = lengths_of(axes)
        self.fastest = min([lengths[1 << axis] for axis in range(len(axes))]) // config["interval_us"] or 1
        self.program = StepProgram(len(axes), config["cells"])
        self._tool_ticks = array("i", [queue.tool_ticks(False), queue.tool_ticks(True)])
        self._walker = StepProgramWalker(self.program, lengths, self._tool_ticks)
        self._loading = False
        self._streaming = False
        self._powers = False  # the program switches the drives on somewhere
        self._origin = [0] * len(axes)  # where the program begins
        self._command = None  # to be told when the program's end, or its start, is reached
        self._mode = IDLE
        self._start_ms = None  # when what is streamed is to set out at the latest
        self._midway = False  # has set out, and has not come to an end
        self._backward = False
        self._pass = self._passes = 1
        self._left_at = self._origin  # where it left the program, for moves by hand

    def _clamp(self, mm_min):
        return min(mm_min or self._default, self.fastest)

    def _add(self, command):
        """STEP_PROGRAM_ADD."""
        return (self._open, self._items, self._close, self._abort)[command.value](command)

    def _open(self, command):
        machine = self._machine
        if self._streaming and self.active() and not self.program.open:
            return LATER
        refusal = machine.unready()
        if refusal:
            return refusal
        if machine.state != "idle" or not self._queue.still():
            return errors.BUSY
        job = machine.job
        job.counting = job.announced  # else it is not the program that the journal knows
        job.announced = False
        self._reset()
        self._streaming = command.tool
        self._loading = not command.tool
        self.program.clear(self._clamp(self._default), command.tool)
        self.program.expect(True)
        self._walker.rewind()
        self._origin = self._queue.target[:]
        self._command = command
        return machine.accepted(command)

    def _items(self, command):
        program = self.program
        if not program.open:
            return errors.NO_STEP_PROGRAM
        if self._streaming and self._room() < 2 * len(command.target) + 2:
            return LATER
        items = command.target
        at = program.extend(items, 0)
        while at < len(items):
            if not self._append(items[at]):
                self._reset()
                return errors.STEP_PROGRAM_FULL
            at = program.extend(items, at + 1)
        if self._streaming:
            if not self._reachable():
                self._fail()
                return errors.TRAVEL
            if not self.active():
                self._start_ms = self._machine.port.machine_ms() + _GATHER_MS
        return self._machine.accepted(command)

    def _append(self, item):
        """Add an item of the shared vocabulary (commands.STEPS_…) to the program; of runs only where there is no room."""
        if item & 15:
            return False
        kind = item >> 4 & 15
        value = item >> 8
        if kind in _KINDS:
            if kind == commands.STEPS_TOOL and self._dry_run:
                value = 0
            if kind == commands.STEPS_SPEED:
                value = min(value, self.fastest)
            return self.program.append(marks.mark(_KINDS[kind], value))
        if kind == commands.STEPS_FASTEST:
            return self.program.append(marks.mark(marks.SPEED, self.fastest))
        if kind == commands.STEPS_DEFAULT:
            return self.program.append(marks.mark(marks.SPEED, self._clamp(self._default)))
        station = ASK if kind == commands.STEPS_ASK else value
        self._powers = self._powers or station == DRIVES_ON
        return self.program.append(marks.mark(marks.STATION, station))

    def progress(self, spot):
        """For the journal: see job_journal.py. False if nothing of the program has been played."""
        walker = self._walker
        index = walker.index
        at = self._left_at
        if self._mode == RUN:
            found, at = self._queue.spot()
            if found is not None:
                index = found
        elif not self._midway and not (index and walker.at_end()):
            return False
        spot[SPOT_INDEX] = index
        spot[SPOT_TIMES] = self._passes - self._pass + 1
        spot[SPOT_BACK] = self._backward
        for axis in range(len(at)):
            spot[SPOT_AXES + axis] = at[axis]
        return True

    def _room(self):
        """Cells that may be filled: the other half of the window is kept for the way back."""
        ahead = (self.program.end - self._walker.cell) & COUNT_MASK
        return self.program.size // 2 - ahead

    def _reachable(self):
        machine = self._machine
        if not machine.homed or not machine.settings.value(table.SOFT_LIMITS):
            return True
        program = self.program
        again = self._passes - 1
        for reach in (program.low, program.high):
            for times in (0, again):
                position = [self._origin[axis] + times * program.at[axis] + reach[axis] for axis in range(program.axes)]
                if not self._queue.inside(position):
                    return False
        return True

    def _close(self, command):
        if not self.program.open:
            return errors.NO_STEP_PROGRAM
        self.program.expect(False)
        self._loading = False
        if self._streaming and not self.active():
            self._streaming = False
            self._tell("end")
        return self._machine.accepted(command, self.program.total)

    def _abort(self, command):
        """The rest makes no sense: what was stored is forgotten, what was played as it came stops."""
        self._fail()
        return command.error
