"""The stored drawing: points are kept as they come, drawn at DRAW, or while they arrive if the buffer is full."""

from micropython import const

from passo import commands, errors
from passo.batch import POINT_BYTES, POINTS
from passo.config import setting_numbers as table
from passo.control.feature import HOMING, WORK_GONE, Feature
from passo.control.point_buffer import PointBuffer
from passo.errors import LATER
from passo.motion.integers import length_nm
from passo.records import NM_PER_M, ROW_TAG, TICKS_PER_MS, TICKS_PER_S

_BLOCKS_A_POINT = const(2)  # a change of the tool, and the line


class Drawing(Feature):
    event_mask = WORK_GONE | HOMING

    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        self._board = board
        self._steps_per_m = machine.steps_per_m
        self.points = PointBuffer(board["store_points"])
        self._speed = 0  # as the host has set it; 0: as the settings have it
        self.drawn = 0  # points of the object drawn so far
        self._travel_of = self._travel = None  # the settings' version that the farthest x and y are of
        self._taken = 0  # points taken from the buffer for this object
        machine.job = self
        self.kept = False  # the position has been counted without a break since a job was announced
        self.counting = False  # commands queued now are of the job that the journal knows
        self.announced = False  # a job is to begin
        self.counted = 0  # points of the job before those that are drawn
        self.write_progress = None  # write_progress(spot) puts where the job is into an array; None: blocks tell it

    @property
    def speed(self):
        """The drawing speed in the board file's unit of speed: steps/s, or half a step period in µs."""
        return self._speed or self._machine.settings.value(table.DRAWING_SPEED)

    def handlers(self):
        """Return {kind of command: method} of this feature."""
        return {
            commands.SPEED: self._set_speed,
            commands.POINT: self._store_point,
            commands.DRAW: self._draw_object,
            commands.JOG: self._queue_jog,
        }

    def on_events(self, what):
        """Homing forgets the object, which refers to the old origin. After WORK_GONE the next work is of no job."""
        self.points.clear()
        if what & WORK_GONE:
            self.counting = False

    def halt(self):
        self.drawn = self.count_drawn()

    def busy(self):
        """Return True while points of the object are still to be queued."""
        machine = self._machine
        return machine.drawing and (self.points.count > 0 or machine.command is not None)

    # --- commands

    def _set_speed(self, command):
        """Set the drawing speed. Returns 0, SPEED_RANGE, or LATER until the machine is idle."""
        limits = self._board["speed"]
        if not limits["min"] <= command.value <= limits["max"]:
            return errors.SPEED_RANGE
        if self._machine.state != "idle":
            return self._machine.unready() or LATER
        self._speed = command.value
        return self._machine.confirm_command(command)

    def _store_point(self, command):
        """Store a point, x and y in steps. Returns 0, TRAVEL, or LATER; a full buffer begins to draw."""
        machine = self._machine
        refusal = machine.unready()
        if refusal:
            return refusal
        if not self._queue.inside(command.target):
            return errors.TRAVEL
        if machine.command is not None or machine.active:
            return LATER
        if not self.points.free():
            machine.drawing = not machine.jogging
            return LATER
        self._begin_object()
        x, y = command.target
        self.points.put(x, y, command.tool)
        return machine.confirm_command(command)

    def _begin_object(self):
        """Begin an object if no point is stored or drawn; it belongs to the job that has been announced."""
        machine = self._machine
        if not self.points.count and not machine.drawing:
            self._taken = self.drawn = 0
            if self.announced:
                self.counting = True
                self.announced = False

    # --- batches

    def batches(self):
        return {POINTS: (self.open, self.accept, self.close)}

    def open(self, batch):
        """Give `batch` the buffer's next free bytes and the travel in steps. Returns False if points have to come as commands."""
        machine = self._machine
        if machine.command is not None or machine.active or machine.commander != batch.link or machine.unready():
            return False
        rows = self.points.free_rows()
        if rows is None:
            return False
        batch.data, batch.offset, batch.room = rows
        if self._travel_of != machine.settings.version:
            self._travel_of = machine.settings.version
            self._travel = self._queue.reach(0)[1], self._queue.reach(1)[1]
        batch.most_x, batch.most_y = self._travel
        batch.begun = True
        return True

    def accept(self, batch):
        """Count the points that the batch has written into the buffer as stored. Returns how many."""
        count = batch.count
        points = self.points
        if not points.count:
            self._begin_object()
        points.count += count
        batch.offset += POINT_BYTES * count
        batch.room -= count
        if not batch.room:  # of this piece of memory
            self.open(batch)
        return count

    def close(self, batch):
        batch.begun = False  # nothing moves by a point

    def _draw_object(self, command):
        """Begin to draw the stored points. Returns 0, an error, or LATER."""
        machine = self._machine
        refusal = machine.unready()
        if refusal:
            return refusal
        if machine.command is not None or machine.active or machine.jogging:
            return LATER
        machine.drawing = True
        return machine.begin(command)

    def _queue_jog(self, command):
        """Queue a jog: `target` holds the jogs of each axis, signed. LATER if more than jog.ahead_ms of motion is queued; JOG_TRAVEL if it
        leads out of the travel."""
        machine = self._machine
        refusal = machine.unready()
        if refusal:
            return refusal
        if machine.drawing or machine.command is not None or machine.axes_are_owned():
            return errors.BUSY
        queue = self._queue
        if machine.jogging:
            ahead = self._line_ticks([to - at for to, at in zip(queue.target, queue.position())])  # jogs make one line, nearly
            if ahead > self._board["jog"]["ahead_ms"] * TICKS_PER_MS:
                return LATER
        steps = machine.settings.jog_steps
        target = [queue.target[axis] + steps(axis) * command.target[axis] for axis in range(len(command.target))]
        for axis in range(len(target)):  # back from outside the travel is allowed: before homing the machine may be anywhere
            low, high = queue.reach(axis)
            at = queue.target[axis]
            if not min(low, at) <= target[axis] <= max(high, at):
                return errors.JOG_TRAVEL
        refusal = machine.interlock_error(command.target)
        if refusal:
            return refusal
        if not queue.room():
            return LATER
        machine.jogging = True
        queue.line(target, self._line_ticks, queue.tool, 0)
        queue.flush()
        return machine.confirm_command(command)

    # --- drawing

    def poll(self, now_ms):
        """Queue stored points while the planner has room for two blocks."""
        queue = self._queue
        machine = self._machine
        if not machine.drawing:
            return
        while self.points.count and queue.room() >= _BLOCKS_A_POINT:
            x, y, tool = self.points.take()
            self._taken += 1
            queue.line((x, y), self._line_ticks, tool, self.counted + self._taken)
        if not self.points.count:
            if machine.command is not None and queue.room():
                queue.lift()
            queue.flush()

    def poll_end(self, still):
        """Finish DRAW once all points of the object are drawn."""
        machine = self._machine
        if still and not self.points.count and machine.busy_with(commands.DRAW):
            self.drawn = self._taken
            self.counted += self._taken
            machine.drawing = False
            machine.finish(machine.report())

    def report(self, report):
        """Add the points stored and drawn to the status report."""
        report["drawn"] = self.count_drawn() & 0xFFFF
        report["free"] = self.points.free()

    def count_drawn(self):
        """Return how many points of the object are drawn, that under way not counted."""
        if not self._machine.drawing:
            return self.drawn
        planner = self._queue.planner
        row = planner.row()
        if row < 0:
            return self._taken if self._queue.empty() else self.drawn
        tag = planner.rows[row + ROW_TAG]
        if not tag:  # the pen goes up behind the last
            return self._taken
        return max(tag - 1 - self.counted, self.drawn)

    def _line_ticks(self, deltas):
        """Return the duration of a line of `deltas` (steps) in ticks, at `speed`."""
        speed = self._board["speed"]
        if speed["unit"] == "half_period_us":
            each_us = 2 * self.speed + speed["overhead_us"]
            return max([abs(delta) for delta in deltas]) * each_us * TICKS_PER_MS // 1000
        return length_nm(deltas, self._steps_per_m) * TICKS_PER_S * self._steps_per_m[0] // (self.speed * NM_PER_M)
