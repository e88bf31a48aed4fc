"""The queue of a machine whose last axis turns: F is the speed of the linear axes, and degrees a minute if no other axis moves.

RS274/NGC and LinuxCNC define F this way. If the axis homes at no sensor, it has no travel limit.
"""

from passo.control.stream_queue import StreamQueue
from passo.motion.integers import length_nm
from passo.records import FARTHEST, KIND_LINE, ROW_KIND, ROW_STEPS, SEEN_MM_S, SEEN_NM_S, SEEN_ROW


class Queue(StreamQueue):
    def __init__(self, board, planner, feeder, player, port):
        StreamQueue.__init__(self, board, planner, feeder, player, port)
        self._last = len(self._axes) - 1
        homing = board["homing"]
        self._endless = not homing or self._axes[-1]["name"] not in homing["sensors"]
        self.turns = 1 | (2 if board["short_way"] else 0) | (4 if self._endless else 0)

    def reach(self, axis):
        """Return the (low, high) end of an axis's travel, in steps; of one that turns for ever ±FARTHEST."""
        if axis == self._last and self._endless:
            return -FARTHEST, FARTHEST
        return StreamQueue.reach(self, axis)

    def set_origin(self, axes=-1):
        """An axis that homes at no sensor keeps its zero."""
        StreamQueue.set_origin(self, axes & ~(1 << self._last) if axes < 0 and self._endless else axes)

    def go(self, target, nm_s, ticks, tool, tag):
        """Queue a line to `target` at F of the linear axes; see the base."""
        StreamQueue.go(self, target, self._speed_along(self.deltas(target), nm_s), ticks, tool, tag)

    def fits(self, deltas, nm_s, ticks):
        """Raise ValueError if the planner would refuse the line."""
        StreamQueue.fits(self, deltas, self._speed_along(deltas, nm_s), ticks)

    def look(self, played=None):
        """See Queue.look(); the speed is the one that F counts for."""
        StreamQueue.look(self, played)
        seen, rows = self.seen, self._planner.rows
        at = seen[SEEN_ROW]
        nm_s = seen[SEEN_MM_S] * 1_000_000 + seen[SEEN_NM_S]
        if nm_s and rows[at + ROW_KIND] == KIND_LINE and rows[at + ROW_STEPS + self._last]:
            nm_s = nm_s * 1_000_000_000 // (self._speed_along(rows[at + ROW_STEPS : at + ROW_STEPS + self._last + 1], 1_000_000_000) or 1)
            seen[SEEN_MM_S] = nm_s // 1_000_000
            seen[SEEN_NM_S] = nm_s % 1_000_000

    def _speed_along(self, deltas, nm_s):
        """Return the speed along all axes at which the linear ones go at `nm_s`. Without a linear axis `nm_s` counts 10⁻⁶ degrees a second."""
        steps_per_m = [axis["steps_per_m"] for axis in self._axes]
        linear = length_nm(deltas[: self._last], steps_per_m)
        return nm_s * length_nm(deltas, steps_per_m) // linear if nm_s and linear else nm_s
