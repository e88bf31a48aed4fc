"""A program's travel, and its lines in batches (batch.Lines); program.py has the rest of its motion."""
# Shared with interrupts: indices

from array import array

import micropython

from passo import commands, errors
from passo.batch import LINES
from passo.config import setting_numbers as table
from passo.control.arcs import farthest
from passo.control.feature import Feature
from passo.motion.look_ahead_viper import plan_lines
from passo.motion.row_viper import room
from passo.records import *


@micropython.viper
def queue_lines(
    rows: ptr32, count: int, target: ptr32, travel: ptr32, blocks: ptr32, scratch: ptr32, indices: ptr32, limits: ptr32
):
    """Queue `count` rows from the position `target` on, as far as they stay within `travel` (TRACE_…) and plan_lines() takes them:
    TRACE_TAKEN of them. `target` is the end of the last of these."""
    line = 0
    while line < count:
        row = line * BATCH_FIELDS
        if int(inside(rows, row, target, travel)) == 0:
            break
        if int(plan_lines(rows, line, line + 1, blocks, scratch, indices, limits)) <= line:
            break
        go_along(rows, row, target, travel)
        line += 1
    travel[TRACE_TAKEN] = line
    travel[TRACE_ROOM] = travel[TRACE_ROOM] - line


@micropython.viper
def inside(rows: ptr32, row: int, at: ptr32, travel: ptr32) -> int:
    """Return 1 if the line at rows[row] leads from the position `at` to one within the travel."""
    axis = 0
    while axis < travel[TRACE_AXES]:
        position = (at[axis] + rows[row + BATCH_STEPS + axis] + 0x20000000) & 0x3FFFFFFF
        if position < travel[TRACE_LOW + axis] or position > travel[TRACE_HIGH + axis]:
            return 0
        axis += 1
    return 1


@micropython.viper
def go_along(rows: ptr32, row: int, at: ptr32, travel: ptr32):
    """Move the position `at` to the end of the line at rows[row], which is queued, and keep its flags and power in `travel`."""
    axis = 0
    while axis < travel[TRACE_AXES]:
        at[axis] = at[axis] + rows[row + BATCH_STEPS + axis]
        axis += 1
    travel[TRACE_MOVED] = 1
    travel[TRACE_FLAGS] = rows[row + BATCH_FLAGS]
    travel[TRACE_POWER] = rows[row + BATCH_POWER] & DOTS_POWER


class LineBatches(Feature):
    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        self._axes = board["axes"]
        self._travel_of = None  # the settings' version that `_travel` is of
        self._planner = queue.planner
        self._trace = array("i", [0] * TRACE_FIELDS)
        self._trace[TRACE_AXES] = len(board["axes"])
        self._reached = self  # the travel that `_trace` is of: not yet any
        self._arrays = self._taker = None  # the planner's, and the kernel's arguments made of them

    def batches(self):
        return {LINES: (self.open, self.accept, self.close, self.arc)}

    # --- the travel

    def reach(self):
        """Return (lowest, highest) positions of the axes in steps, or None if no travel limits hold now. The same object until that changes."""
        machine = self._machine
        settings = machine.settings
        if self._travel_of != settings.version:
            self._travel_of = settings.version
            self._travel = None
            if settings.value(table.SOFT_LIMITS):
                ends = [self._queue.reach(axis) for axis in range(len(self._axes))]
                self._travel = [low for low, _ in ends], [high for _, high in ends]
        return self._travel if machine.homed else None

    def _is_within_travel(self, target):
        """Return True if `target` (steps) is within the travel, or no travel limits hold."""
        reach = self.reach()
        if reach:
            for axis in range(len(target)):
                if not reach[0][axis] <= target[axis] <= reach[1][axis]:
                    return False
        return True

    def _can_reach(self, command):
        """Return True if the motion stays within the travel; of an arc its farthest points too."""
        if not self._is_within_travel(command.target):
            return False
        if command.kind != commands.ARC or not self.reach():
            return True
        for position in farthest(self._queue.target, command, [axis["steps_per_m"] for axis in self._axes]):
            if not self._is_within_travel(position):
                return False
        return True

    # --- batches

    @property
    def rows(self):
        """The array of batches: one for all, each is taken before the next is filled."""
        return self._planner.batch

    @property
    def dots(self):
        """Power.marks, where the dots of rows go."""
        return self._queue.analogue.marks

    def slow_tool(self):
        """Return True if a change of the tool takes time: see Queue."""
        return self._queue.slow_tool()

    @micropython.native
    def open(self, batch):
        """Open a batch of lines: give it the planner's arrays, travel, tool and room. Returns False if lines have to come as commands."""
        machine = self._machine
        if (
            machine.commander != batch.link or machine.command is not None or machine.alarm or machine.sleeping or machine.checking
            or machine.motors.detached or machine.cautious and not machine.homed or machine.jogging or machine.drawing or machine.dropping or machine.actives and machine.axes_are_owned()
            or not self._planner.ready or machine.veto is not None and machine.veto.denied
        ):  # fmt: skip
            return False
        queue = self._queue
        planner = self._planner
        # as reach() says, without the call: each cycle with lines opens a batch, and `?` waits for it
        reach = self.reach() if self._travel_of != machine.settings.version else self._travel if machine.homed else None
        if self._reached is not reach:
            self._set_trace_range(reach)
        if self._arrays is not planner.arrays:
            self._arrays = planner.arrays
            self._taker = (self._trace, queue_lines, queue.target) + self._arrays
        batch.taker = self._taker
        batch.target = queue.target
        batch.reach = reach
        batch.tool = queue.tool
        batch.power = planner.power
        batch.dynamic = planner.dynamic
        batch.room = (0 if queue.chords else room(planner.indices)) - 1  # blocks played meanwhile count from the next open() on
        self._trace[TRACE_ROOM] = batch.room
        self._trace[TRACE_TAKEN] = 0
        batch.begun = True
        return True

    def _set_trace_range(self, reach):
        """Set the positions that a batch may lead to; `reach` None: as far as the planner counts."""
        self._reached = reach
        at = self._trace
        for axis in range(at[TRACE_AXES]):
            low, high = (-FARTHEST, FARTHEST) if reach is None else (reach[0][axis], reach[1][axis])
            at[TRACE_LOW + axis] = max(low, -FARTHEST) + BIAS
            at[TRACE_HIGH + axis] = min(high, FARTHEST) + BIAS

    def accept(self, batch):
        """Queue what queue_lines() has left of the rows, as far as they stay within the travel."""
        travel = self._trace
        done = count = travel[TRACE_TAKEN]
        while count < batch.count and inside(batch.rows, count * BATCH_FIELDS, batch.target, travel):
            go_along(batch.rows, count * BATCH_FIELDS, batch.target, travel)
            count += 1
        self._planner.lines(done, count)
        travel[TRACE_TAKEN] = count
        travel[TRACE_ROOM] -= count - done
        if count < batch.count:
            self.close(batch)
            self._machine.raise_alarm(errors.ALARM_SOFT_LIMIT)
        return count

    def arc(self, batch, command, power):
        """Queue an arc behind the rows that have been taken; see Controller.batches()."""
        self.close(batch)
        batch.begun = True
        machine = self._machine
        queue = self._queue
        planner = self._planner
        if not room(planner.indices) or batch.reach is not None and not self._can_reach(command):
            return False
        if planner.power != power or planner.dynamic != command.dynamic:
            planner.set_power(power, command.dynamic)
        try:
            queue.arc(command, 0)
        except ValueError:
            return False
        machine.active = machine.fresh = machine.awake = True
        self._trace[TRACE_ROOM] = (0 if queue.chords else room(planner.indices)) - 1
        return True

    @micropython.native
    def close(self, batch):
        """Set tool and power of the queue's end as the last row taken says."""
        batch.begun = False
        travel = self._trace
        if travel[TRACE_MOVED]:
            travel[TRACE_MOVED] = 0
            queue = self._queue
            machine = self._machine
            flags = travel[TRACE_FLAGS]
            queue.tool = flags & 1 > 0
            planner = self._planner
            if planner.power != travel[TRACE_POWER] or planner.dynamic != (flags & 4 > 0):
                planner.set_power(travel[TRACE_POWER], flags & 4 > 0)
            queue.waiting = True
            machine.active = machine.fresh = machine.awake = True
