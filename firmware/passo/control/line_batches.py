"""The half of a program's motion that takes lines in batches (batch.Lines)."""
# ruff: noqa: F821

from array import array

import micropython

from passo import errors
from passo.batch import LINES
from passo.records import (
    BATCH_FIELDS, BATCH_FLAGS, BATCH_POWER, BATCH_STEPS, BIAS, FARTHEST, TRACE_AXES, TRACE_FIELDS, TRACE_HIGH,
    TRACE_LOW,
)  # fmt: skip


try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows


@micropython.viper
def trace(rows: ptr32, count: int, at: ptr32, travel: ptr32) -> int:
    """Go along `count` rows from the position `at`, within `travel` (TRACE_…). Returns how many of them stay within it: `at`
    is the end of the last of these."""
    axes = travel[TRACE_AXES]
    line = 0
    row = BATCH_STEPS
    while line < count:
        axis = 0
        while axis < axes:
            place = (at[axis] + rows[row + axis] + 0x20000000) & 0x3FFFFFFF
            if place < travel[TRACE_LOW + axis] or place > travel[TRACE_HIGH + axis]:
                return line
            axis += 1
        axis = 0
        while axis < axes:
            at[axis] = at[axis] + rows[row + axis]
            axis += 1
        row += BATCH_FIELDS
        line += 1
    return line


class LineBatches:
    def __init__(self, axes):
        self._trace = array("i", [0] * TRACE_FIELDS)
        self._trace[TRACE_AXES] = axes
        self._reached = self  # the travel that `_trace` is of: not yet any

    def batches(self):
        return {LINES: (self.open, self.accept, self.close)}

    @property
    def rows(self):
        """The array of batches: one for all, each is taken before the next is filled."""
        return self._planner.batch

    def slow_tool(self):
        return self._queue.slow_tool()

    @micropython.native
    def open(self, batch):
        machine = self._machine
        if (
            machine.commander != batch.link or machine.command is not None or machine.alarm or machine.sleeping or machine.checking
            or machine.detached or machine.jogging or machine.drawing or machine.dropping or machine.occupied()
            or not self._planner.accelerates or machine.interlock is not None and machine.interlock.denied
        ):  # fmt: skip
            return False
        queue = self._queue
        planner = self._planner
        reach = self.reach()
        if self._reached is not reach:
            self._take_over(reach)
        batch.target = queue.target
        batch.reach = reach
        batch.tool = queue.tool
        batch.power = planner.power
        batch.dynamic = planner.dynamic
        batch.room = queue.room() - 1
        return True

    def _take_over(self, reach):
        """The positions that a batch may lead to."""
        self._reached = reach
        at = self._trace
        for axis in range(at[TRACE_AXES]):
            low, high = (-FARTHEST, FARTHEST) if reach is None else (reach[0][axis], reach[1][axis])
            at[TRACE_LOW + axis] = max(low, -FARTHEST) + BIAS
            at[TRACE_HIGH + axis] = min(high, FARTHEST) + BIAS

    @micropython.native
    def accept(self, batch):
        """Queue the rows, as far as they stay within the travel."""
        count = trace(batch.rows, batch.count, batch.target, self._trace)
        if count:
            self._planner.lines(count)
            batch.taken = count
            batch.room -= count  # what is played meanwhile counts from the next open() on
        if count < batch.count:
            self.close(batch)
            self._machine.raise_alarm(errors.ALARM_SOFT_LIMIT)
        return count

    @micropython.native
    def close(self, batch):
        """The queue's end is as the last row taken says."""
        if batch.taken:
            rows = batch.rows
            row = (batch.taken - 1) * BATCH_FIELDS
            batch.taken = 0
            queue = self._queue
            machine = self._machine
            flags = rows[row + BATCH_FLAGS]
            queue.tool = flags & 1 > 0
            self._planner.set_power(rows[row + BATCH_POWER], flags & 4 > 0)
            queue.waiting = True
            machine.active = machine.fresh = True
