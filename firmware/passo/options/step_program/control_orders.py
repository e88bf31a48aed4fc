"""The way of a step program to the machine, stored whole or played as it comes, and the orders of STEP_PROGRAM.

Its items are those of passo/commands.py. Each order is checked here, and refused or begun; control.py carries it out.
"""

from array import array

from micropython import const

from passo import errors
from passo.commands import SPOT_AXES, SPOT_BACK, SPOT_INDEX, SPOT_TIMES
from passo.config import setting_numbers as table
from passo.control.feature import Feature
from passo.errors import LATER
from passo.motion.integers import isqrt
from passo.options.step_program import motion as marks
from passo.options.step_program.commands import (
    STEPS_ASK, STEPS_CONTINUE, STEPS_DEFAULT, STEPS_FASTEST, STEPS_HAND_DRIVES, STEPS_HAND_TOOL, STEPS_JOG, STEPS_PACE, STEPS_PASSES, STEPS_RETURN,
    STEPS_SPEED, STEPS_STEP, STEPS_TOOL, STEPS_WAIT,
)  # fmt: skip
from passo.options.step_program.errors import DRIVES_OFF as SWITCHED_OFF, NO_STEP_PROGRAM, PASSES, RETURN_OR_CONTINUE, STEP_PROGRAM_FULL
from passo.options.step_program.motion import StepProgram
from passo.options.step_program.motion_walker import StepProgramWalker
from passo.records import COUNT_MASK, ENDLESS
from passo.steps.word import us_to_ticks

MOST_PASSES = const(100)
_MANUAL_CELLS = const(256)
_GATHER_MS = const(50)  # how long a stream is waited for, so that it sets out with some of it in hand

# STATION's values.
DRIVES_OFF = const(0)
DRIVES_ON = const(1)
ASK = const(2)  # the operator sets the speed

# The walks.
IDLE = const(0)
RUN = const(1)
HAND = const(2)  # manual moves
RETURN = const(3)  # the way back of the manual moves

_KINDS = {
    STEPS_WAIT: marks.DWELL,
    STEPS_TOOL: marks.TOOL,
    STEPS_SPEED: marks.SPEED,
}


def lengths_of(steps_per_m):
    """Return how far a step goes for each mask of axes, in nm × 60, an array."""
    lengths = array("i", [0] * (1 << len(steps_per_m)))
    for mask in range(1, len(lengths)):
        total = 0
        for axis in range(len(steps_per_m)):
            if mask >> axis & 1:
                total += (60_000_000_000 * 1024 // steps_per_m[axis]) ** 2
        lengths[mask] = (isqrt(total) + 512) >> 10
    return lengths


class StepProgramOrders(Feature):
    """The part of the feature that takes a step program in, and orders."""

    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        config = board["step_program"]
        axes = len(board["axes"])
        self._dry_run = config["dry_run"]
        self._lengths = lengths = array("i", [0] * (1 << axes))
        self._take_settings()
        tool_ticks = array("i", [queue.tool_ticks(False), queue.tool_ticks(True)])
        self.program = StepProgram(axes, config["cells"])
        self._walker = StepProgramWalker(self.program, lengths, tool_ticks)
        self._manual = StepProgram(axes, _MANUAL_CELLS)
        self._hand = StepProgramWalker(self._manual, lengths, tool_ticks)
        self._origin = [0] * axes  # the position at the program's start
        self._command = None  # to be answered when the program's end, or its start, is reached
        self._barred = False  # the operator wants no current: no move by hand switches the drives on
        self._reset_program()

    def _take_settings(self):
        """Take lengths, least interval and speeds from the settings."""
        settings = self._machine.settings
        self._settings_of = settings.version
        for mask, length in enumerate(lengths_of(settings.steps_per_m)):
            self._lengths[mask] = length
        interval_us = settings.value(table.INTERVAL)
        self._least_ticks = us_to_ticks(interval_us)
        self.fastest = min([self._lengths[1 << axis] for axis in range(len(settings.steps_per_m))]) // interval_us or 1
        self._default = min(settings.value(table.PROGRAM_SPEED), self.fastest)

    def _follow_settings(self):
        """Forget a stored program, whose speeds are wrong now, if steps/mm, interval or speed have changed."""
        if self._settings_of != self._machine.settings.version:
            before = self._lengths[:], self._least_ticks, self._default
            self._take_settings()
            if before != (self._lengths, self._least_ticks, self._default):
                self._reset_program()

    def _reset_program(self, ring=False):
        """Forget the program; `ring`: the next one is streamed."""
        self.program.clear_items(self._default, ring)
        self._walker.go_to_start()
        self._clear_state()
        self._streaming = False
        self._powers = False  # the program switches the drives on somewhere

    def _clear_state(self):
        """Note that nothing is under way, and that there are no manual moves to go back."""
        self._mode = IDLE
        self._start_ms = None  # when what is streamed is to set out at the latest
        self._midway = False  # has set out, and has not come to an end
        self._asked = False  # waits for the operator's speed
        self._hand_tool = self._backward = False
        self._left_at = self._origin  # the position at which it left the program, for moves by hand
        self._next = None  # the work at the stand: a function without arguments
        self._most = ENDLESS
        self._pass = self._passes = 1
        self._forget_moves()

    def _forget_moves(self):
        """Forget the manual moves."""
        self._manual.clear_items(self._default)
        self._hand.go_to_start()

    def _do_add(self, command):
        """Do STEP_PROGRAM_ADD."""
        return (self._open_program, self._add_items, self._close_program, self._abort_program)[command.value](command)

    def _open_program(self, command):
        """Open a program, stored or streamed (`tool`). Returns the number of an error, LATER, or 0."""
        machine = self._machine
        if self._streaming and self.owns_axes() and not self.program.open:
            return LATER
        refusal = machine.unready()
        if refusal:
            return refusal
        if machine.state != "idle" or not self._queue.still():
            return errors.BUSY
        self._follow_settings()
        self.counting = self.announced  # else it is not the program that the journal knows
        self.announced = False
        self._reset_program(command.tool)
        self._streaming = command.tool
        self.program.expect_more(True)
        self._origin = self._queue.target[:]
        self._command = command
        return machine.confirm_command(command)

    def _add_items(self, command):
        """Add the items in `target`. Returns the number of an error, LATER, or 0."""
        program = self.program
        if not program.open:
            return NO_STEP_PROGRAM
        items = command.target
        ahead = (program.end - self._walker.cell) & COUNT_MASK
        if self._streaming and ahead + 2 * len(items) + 2 > program.size // 2:  # the other half of the window is kept for the way back
            return LATER
        at = program.extend(items, 0)
        while at < len(items):
            if not self._append_item(items[at]):
                self._reset_program()
                return STEP_PROGRAM_FULL
            at = program.extend(items, at + 1)
        if self._streaming:
            if not self._is_reachable():
                self._fail_program()
                return errors.TRAVEL
            if not self.owns_axes():
                self._start_ms = self._machine.port.machine_ms() + _GATHER_MS
        return self._machine.confirm_command(command)

    def _append_item(self, item):
        """Add an item of commands.STEPS_… to the program. Returns False for a run, or if there is no room."""
        if item & 15:
            return False
        kind = item >> 4 & 15
        value = item >> 8
        if kind in _KINDS:
            if kind == STEPS_TOOL and self._dry_run:
                value = 0
            if kind == STEPS_SPEED:
                value = min(value, self.fastest)
            return self.program.append(marks.make_mark(_KINDS[kind], value))
        if kind == STEPS_FASTEST:
            return self.program.append(marks.make_mark(marks.SPEED, self.fastest))
        if kind == STEPS_DEFAULT:
            return self.program.append(marks.make_mark(marks.SPEED, self._default))
        station = ASK if kind == STEPS_ASK else value
        self._powers = self._powers or station == DRIVES_ON
        return self.program.append(marks.make_mark(marks.STATION, station))

    def write_progress(self, spot):
        """Write where the program is to `spot`, fields SPOT_…, for the journal. Returns False if nothing of it has been played."""
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

    def _is_reachable(self):
        """Return True if all passes of the program stay within the soft limits, or none hold."""
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

    def _close_program(self, command):
        """Close the program: it is complete. Returns the number of an error, or 0."""
        if not self.program.open:
            return NO_STEP_PROGRAM
        self.program.expect_more(False)
        if self._streaming and not self.owns_axes():
            self._streaming = False
            self._tell_end("end")
        return self._machine.confirm_command(command, self.program.total)

    def _abort_program(self, command):
        """Forget a stored program, stop a streamed one: its rest makes no sense. Returns the error."""
        self._fail_program()
        return command.error

    # --- orders

    def _do_order(self, command):
        """Do STEP_PROGRAM. Returns the number of an error, or 0."""
        verb = command.value
        self._follow_settings()
        if self._mode == IDLE and not self._queue.still():
            return errors.BUSY
        if verb == STEPS_PACE:
            return self._set_pace(command)
        if verb == STEPS_PASSES:
            return self._set_passes(command)
        refusal = self._machine.unready()
        if refusal:
            return refusal
        if verb == STEPS_JOG:
            return self._do_jog(command)
        if verb in (STEPS_HAND_TOOL, STEPS_HAND_DRIVES):
            return self._switch_by_hand(command)
        if self.program.open and not self._streaming or not self.program.total:
            return NO_STEP_PROGRAM
        if verb == STEPS_RETURN:
            return self._do_return(command)
        if verb == STEPS_CONTINUE and self._mode == RUN:
            return errors.BUSY
        return self._do_go(command)

    def _do_go(self, command):
        """Do STEPS_GO, STEPS_STEP or STEPS_CONTINUE: `tool` says backward, `power` how many times (0: as set). Returns the number of an error, or
        0."""
        if self._mode == RETURN:
            return errors.BUSY
        if self._has_moved_by_hand() and command.value != STEPS_CONTINUE:
            return RETURN_OR_CONTINUE
        if (self._streaming or self.program.start) and command.power > 1:
            return NO_STEP_PROGRAM
        if command.power > MOST_PASSES:
            return PASSES
        backward = command.tool
        most = 1 if command.value == STEPS_STEP else ENDLESS
        if self._mode == IDLE and not self._midway and not self._streaming:
            if not backward and self._walker.at_end():
                if self.program.start:
                    return NO_STEP_PROGRAM  # its beginning was streamed and is forgotten
                self._walker.go_to_start()
            if self._walker.at_start() and not self.program.start:
                self._origin = self._queue.target[:]
            self._pass = 1
        if command.power:
            self._passes = command.power
        origin = self._origin
        forgotten = self.program.start and not self._midway
        if self._mode == IDLE and (forgotten or self._has_moved_by_hand()):  # the rest of the program lies elsewhere now
            target = self._queue.target
            self._origin = [at + to - was for at, to, was in zip(origin, target, self._left_at)]
        if (origin is not self._origin or self._walker.at_start()) and not self._is_reachable():
            self._origin = origin
            return errors.TRAVEL
        self._command = command
        if not (self._mode == RUN and backward == self._backward and most == self._most and not self._is_pausing()):
            self._asked = False
            self._at_stand(lambda: self._go_on(backward, most))
        return self._machine.confirm_command(command)

    def _go_on(self, backward, most):
        """Forget the manual moves, and walk the program."""
        self._forget_moves()
        self._start_walk(backward, most)

    def _is_pausing(self):
        """Return True if a walk is held, or is about to be."""
        return self._next is not None or bool(self._machine.hold)

    def _has_moved_by_hand(self):
        """Return True if manual moves lead away from the program."""
        return self._midway and self._hand.index != 0

    def _do_return(self, command):
        """Do STEPS_RETURN: go back the way of the manual moves. Returns the number of an error, or 0."""
        if self._mode in (RUN, RETURN):
            return errors.BUSY
        if not self._midway:
            return NO_STEP_PROGRAM
        if self._barred:
            return SWITCHED_OFF
        backward = command.tool
        self._command = command
        self._at_stand(lambda: self._go_back(backward))
        return self._machine.confirm_command(command)

    def _go_back(self, backward):
        """Walk the manual moves backward."""
        self._backward = backward
        self._most = ENDLESS
        self._hand.tool = False
        self._set_drives(True)
        self._begin_walk(self._hand, RETURN, True)

    def _do_jog(self, command):
        """Do STEPS_JOG: move by `target`, steps of each axis, one axis after the other. Returns the number of an error, or 0."""
        machine = self._machine
        if self._mode not in (IDLE, HAND) or self._is_pausing() and self._mode == HAND or machine.state not in ("idle", "run", "hold"):
            return errors.BUSY
        if self._barred:
            return SWITCHED_OFF
        if self._mode == IDLE and not self._midway:
            self._forget_moves()
        queue = self._queue
        position = [at + by for at, by in zip(queue.target, command.target)]
        if machine.homed and machine.settings.value(table.SOFT_LIMITS) and not queue.inside(position):
            return errors.JOG_TRAVEL
        refusal = machine.interlock_error(command.target)
        if refusal:
            return refusal
        for axis in range(len(command.target)):
            steps = command.target[axis]
            if steps and not self._manual.append(marks.run(1 << axis, (steps < 0) << axis, abs(steps))):
                return STEP_PROGRAM_FULL
        queue.lead(position)
        if self._mode == IDLE:
            self._at_stand(self._walk_by_hand)
        return machine.confirm_command(command)

    def _walk_by_hand(self):
        """Walk the manual moves."""
        self._hand.tool = self._hand_tool
        self._set_drives(True)
        self._begin_walk(self._hand, HAND, False)

    def _switch_by_hand(self, command):
        """Switch the tool or the drives at a stand. Returns the number of an error, or 0."""
        if self._mode != IDLE:
            return errors.BUSY
        if command.value == STEPS_HAND_DRIVES:
            self._set_drives(command.tool)
            self._barred = not command.tool
        else:
            self._hand_tool = command.tool and not self._dry_run
            self._queue.rest(self._hand_tool)
        return self._machine.confirm_command(command)

    def _set_pace(self, command):
        """Do STEPS_PACE: `feed` mm/min, up to the next speed of the program. It ends the wait for the operator's speed."""
        if command.feed < 1:
            return errors.SPEED_RANGE
        speed = min(command.feed, self.fastest)
        self._walker.set_speed(speed)
        if self._asked:
            self._asked = False
            self.program.correct_speed(self._walker.cell, speed)
            if not self._has_moved_by_hand():
                self._at_stand(self._start_walk)
        return self._machine.confirm_command(command)

    def _set_passes(self, command):
        """Do STEPS_PASSES: `power` passes. Returns the number of an error, or 0."""
        if not 1 <= command.power <= MOST_PASSES:
            return PASSES
        if (self._streaming or self.program.start) and command.power > 1:
            return NO_STEP_PROGRAM
        self._passes = command.power
        return self._machine.confirm_command(command)
