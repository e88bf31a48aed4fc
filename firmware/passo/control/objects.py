"""Drawing stored objects: points are kept as they come, drawn at END, or while they arrive where there are too many."""

from micropython import const

from passo import commands, errors
from passo.control.store import Store
from passo.motion.integers import NM_PER_M, length_nm
from passo.steps.word import TICKS_PER_MS, TICKS_PER_S

LATER = const(-1)
_BLOCKS_A_POINT = const(2)  # a change of the tool, and the line


class Objects:
    def __init__(self, board, queue, machine):
        """`machine`: the controller; see its face towards its parts."""
        self._board = board
        self._queue = queue
        self._machine = machine
        self._steps_per_m = [axis["steps_per_m"] for axis in board["axes"]]
        self.store = Store(board["store_points"])
        self.speed = board["speed"]["default"]
        self.drawn = 0  # points of the object drawn so far
        self._taken = 0  # points taken from the store for this object
        self.drawing = False

    def handlers(self):
        return {
            commands.SPEED: self._set_speed,
            commands.POINT: self._point,
            commands.DRAW: self._draw,
            commands.JOG: self._jog,
        }

    def clear(self):
        """Forget the object."""
        self.store.clear()
        self.drawing = False

    def busy(self):
        return self.drawing and (self.store.count > 0 or self._machine.command is not None)

    # --- commands

    def _set_speed(self, command):
        limits = self._board["speed"]
        if not limits["min"] <= command.value <= limits["max"]:
            return errors.SPEED_RANGE
        if self._machine.state != "idle":
            return self._machine.unready() or LATER
        self.speed = command.value
        return self._machine.accepted(command)

    def _point(self, command):
        machine = self._machine
        refusal = machine.unready()
        if refusal:
            return refusal
        if not self._queue.inside(command.target):
            return errors.TRAVEL
        if machine.command is not None or machine.program.active():
            return LATER
        if not self.store.free():
            self.drawing = not machine.program.jogging
            return LATER
        self._begin()
        x, y = command.target
        self.store.put(x, y, command.tool)
        return machine.accepted(command)

    def _begin(self):
        """The next point may be the first of an object."""
        if not self.store.count and not self.drawing:
            self._taken = self.drawn = 0

    def piece(self):
        """Where points that come in a run may be put, as Store.piece, and the largest x and y; add() is to follow. None
        where they have to come as commands, to wait or to be told why not."""
        machine = self._machine
        if machine.unready() or not machine.links.listening() or machine.command is not None or machine.program.active():
            return None
        piece = self.store.piece()
        reach = self._queue.reach
        return piece and piece + (reach(0)[1], reach(1)[1])

    def add(self, count):
        """So many points have been put there."""
        self._begin()
        self.store.count += count

    def _draw(self, command):
        machine = self._machine
        refusal = machine.unready()
        if refusal:
            return refusal
        if machine.command is not None or machine.program.active() or machine.program.jogging:
            return LATER
        machine.command = command
        self.drawing = True
        return 0

    def _jog(self, command):
        machine = self._machine
        refusal = machine.unready()
        if refusal:
            return refusal
        if self.drawing or machine.command is not None or machine.occupied():
            return errors.BUSY
        queue = self._queue
        jog = self._board["jog"]
        steps = jog["steps"]
        if machine.program.jogging:
            ahead = self._ticks([to - at for to, at in zip(queue.target, queue.position())])  # jogs make one line, nearly
            if ahead > jog["ahead_ms"] * TICKS_PER_MS:
                return LATER
        target = [queue.target[axis] + steps * command.target[axis] for axis in range(len(command.target))]
        for axis in range(len(target)):  # back from outside the travel is allowed: before homing the machine may be anywhere
            low, high = queue.reach(axis)
            at = queue.target[axis]
            if not min(low, at) <= target[axis] <= max(high, at):
                return errors.JOG_TRAVEL
        if not queue.room():
            return LATER
        machine.program.jogging = True
        queue.line(target, self._ticks, queue.tool, 0)
        queue.flush()
        return machine.accepted(command)

    # --- drawing

    def poll(self):
        queue = self._queue
        while self.store.count and queue.room() >= _BLOCKS_A_POINT:
            x, y, tool = self.store.take()
            self._taken += 1
            queue.line((x, y), self._ticks, tool, self._taken)
        if not self.store.count:
            if self._machine.command is not None and queue.room():
                self.lift()
            queue.flush()

    def end(self):
        """The object is drawn to its end."""
        if self.drawing:
            self.drawn = self._taken
        self.drawing = False

    def lift(self):
        """Tool off at the end of the queue, and time for it to get there."""
        self._queue.lift(self._taken + 1)

    def report(self, report):
        """What the status report says of what is stored and drawn."""
        report["drawn"] = self.count_drawn() & 0xFFFF
        report["free"] = self.store.free()

    def count_drawn(self):
        if not self.drawing:
            return self.drawn
        block = self._queue.playing()
        if block is None and self._queue.empty():
            return self._taken
        return self.drawn if block is None else max(block.tag - 1, self.drawn)

    def _ticks(self, deltas):
        """How long the line lasts at the speed set, in the board file's sense of speed."""
        speed = self._board["speed"]
        if speed["unit"] == "half_period_us":
            each_us = 2 * self.speed + speed["overhead_us"]
            return max([abs(delta) for delta in deltas]) * each_us * TICKS_PER_MS // 1000
        return length_nm(deltas, self._steps_per_m) * TICKS_PER_S * self._steps_per_m[0] // (self.speed * NM_PER_M)
