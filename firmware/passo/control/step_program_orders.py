"""What STEP_PROGRAM asks of a step program: each order is checked here, and refused or begun.

step_program.py carries it out.
"""

from micropython import const

from passo import commands, errors
from passo.config import setting_numbers as table
from passo.control.step_program_intake import HAND, IDLE, RETURN, RUN, StepProgramIntake
from passo.motion.step_program import StepProgram, run
from passo.motion.step_program_walker import StepProgramWalker
from passo.records import ENDLESS

MOST_PASSES = const(100)
_MANUAL_CELLS = const(256)


class StepProgramOrders(StepProgramIntake):
    """The part of the feature that takes orders."""

    def __init__(self, board, machine, queue):
        StepProgramIntake.__init__(self, board, machine, queue)
        axes = len(board["axes"])
        self._manual = StepProgram(axes, _MANUAL_CELLS)
        self._hand = StepProgramWalker(self._manual, self._lengths, self._tool_ticks)
        self._barred = False  # the operator wants no current: no move by hand switches the drives on
        self._hand_tool = False
        self._asked = False  # waits for the operator's speed
        self._most = ENDLESS
        self._next = None  # what to do at the stand: a function without arguments

    def _do(self, command):
        """STEP_PROGRAM."""
        verb = command.value
        if self._mode == IDLE and not self._queue.still():
            return errors.BUSY
        if verb == commands.STEPS_PACE:
            return self._pace(command)
        if verb == commands.STEPS_PASSES:
            return self._set_passes(command)
        refusal = self._machine.unready()
        if refusal:
            return refusal
        if verb == commands.STEPS_JOG:
            return self._jog(command)
        if verb in (commands.STEPS_HAND_TOOL, commands.STEPS_HAND_DRIVES):
            return self._switch(command)
        if self._loading or not self.program.total:
            return errors.NO_STEP_PROGRAM
        if verb == commands.STEPS_RETURN:
            return self._return(command)
        if verb == commands.STEPS_CONTINUE:
            if self._mode in (RUN, RETURN):
                return errors.BUSY
        return self._go(command)

    def _go(self, command):
        """STEPS_GO, STEPS_STEP, STEPS_CONTINUE: `tool` says backward, `power` how many times (0: as set)."""
        if self._mode == RETURN:
            return errors.BUSY
        if self._moved_by_hand() and command.value != commands.STEPS_CONTINUE:
            return errors.RETURN_OR_CONTINUE
        if (self._streaming or self.program.start) and command.power > 1:
            return errors.NO_STEP_PROGRAM
        if command.power > MOST_PASSES:
            return errors.PASSES
        backward = command.tool
        most = 1 if command.value == commands.STEPS_STEP else ENDLESS
        if self._mode == IDLE and not self._midway and not self._streaming:
            if not backward and self._walker.at_end():
                if self.program.start:
                    return errors.NO_STEP_PROGRAM  # its beginning was streamed and is forgotten
                self._walker.rewind()
            if self._walker.at_start() and not self.program.start:
                self._origin = self._queue.target[:]
            self._pass = 1
        if command.power:
            self._passes = command.power
        origin = self._origin
        forgotten = self.program.start and not self._midway
        if self._mode == IDLE and (forgotten or self._moved_by_hand()):  # the rest of the program lies elsewhere now
            target = self._queue.target
            self._origin = [at + to - was for at, to, was in zip(origin, target, self._left_at)]
        if (origin is not self._origin or self._walker.at_start()) and not self._reachable():
            self._origin = origin
            return errors.TRAVEL
        self._command = command
        if not (self._mode == RUN and backward == self._backward and most == self._most and not self._pausing()):
            self._asked = False
            self._at_stand(lambda: self._go_on(backward, most))
        return self._machine.accepted(command)

    def _go_on(self, backward, most):
        self._forget_moves()
        self._start(backward, most)

    def _pausing(self):
        return self._next is not None or bool(self._machine.hold)

    def _moved_by_hand(self):
        return self._midway and self._hand.index != 0

    def _return(self, command):
        if self._mode in (RUN, RETURN):
            return errors.BUSY
        if not self._midway:
            return errors.NO_STEP_PROGRAM
        if self._barred:
            return errors.DRIVES_OFF
        backward = command.tool
        self._command = command
        self._at_stand(lambda: self._go_back(backward))
        return self._machine.accepted(command)

    def _go_back(self, backward):
        self._backward = backward
        self._most = ENDLESS
        self._hand.tool = False
        self._set_drives(True)
        self._walk(self._hand, RETURN, True)

    def _jog(self, command):
        """`target`: steps of each axis, one axis after the other."""
        if self._mode not in (IDLE, HAND) or self._pausing() and self._mode == HAND:
            return errors.BUSY
        if self._machine.state not in ("idle", "run", "hold"):
            return errors.BUSY
        if self._barred:
            return errors.DRIVES_OFF
        if self._mode == IDLE and not self._midway:
            self._forget_moves()
        queue = self._queue
        machine = self._machine
        position = [at + by for at, by in zip(queue.target, command.target)]
        if machine.homed and machine.settings.value(table.SOFT_LIMITS) and not queue.inside(position):
            return errors.JOG_TRAVEL
        refusal = machine.barred(command.target)
        if refusal:
            return refusal
        for axis in range(len(command.target)):
            steps = command.target[axis]
            if steps and not self._manual.append(run(1 << axis, (steps < 0) << axis, abs(steps))):
                return errors.STEP_PROGRAM_FULL
        queue.lead(position)
        if self._mode == IDLE:
            self._at_stand(self._move)
        return machine.accepted(command)

    def _move(self):
        self._hand.tool = self._hand_tool
        self._set_drives(True)
        self._walk(self._hand, HAND, False)

    def _switch(self, command):
        """The tool or the drives by hand, at a stand."""
        if self._mode != IDLE or not self._queue.still():
            return errors.BUSY
        if command.value == commands.STEPS_HAND_DRIVES:
            self._set_drives(command.tool)
            self._barred = not command.tool
        else:
            self._hand_tool = command.tool and not self._dry_run
            self._queue.rest(self._hand_tool)
        return self._machine.accepted(command)

    def _pace(self, command):
        """`feed` mm/min, from now on to the next speed of the program; it ends the wait for the operator's speed."""
        if command.feed < 1:
            return errors.SPEED_RANGE
        speed = min(command.feed, self.fastest)
        self._walker.set_speed(speed)
        if self._asked:
            self._asked = False
            self.program.correct_speed(self._walker.cell, speed)
            if not self._moved_by_hand():
                self._at_stand(self._start)
        return self._machine.accepted(command)

    def _set_passes(self, command):
        if not 1 <= command.power <= MOST_PASSES:
            return errors.PASSES
        if (self._streaming or self.program.start) and command.power > 1:
            return errors.NO_STEP_PROGRAM
        self._passes = command.power
        return self._machine.accepted(command)
