"""The queue of a machine whose last axis turns: F is the speed of the linear axes, and degrees a minute if no other axis moves.

RS274/NGC and LinuxCNC define F this way. If the axis homes at no sensor, it has no travel limit.
"""

from passo.control.stream_queue import StreamQueue
from passo.motion.integers import length_nm
from passo.records import FARTHEST


class Queue(StreamQueue):
    turns = True

    def __init__(self, board, planner, feeder, player, port):
        StreamQueue.__init__(self, board, planner, feeder, player, port)
        self._last = len(self._axes) - 1
        homing = board["homing"]
        self._endless = not homing or self._axes[-1]["name"] not in homing["sensors"]

    def reach(self, axis):
        if axis == self._last and self._endless:
            return -FARTHEST, FARTHEST
        return StreamQueue.reach(self, axis)

    def set_origin(self, axes=-1):
        """An axis that homes at no sensor keeps its zero."""
        StreamQueue.set_origin(self, axes & ~(1 << self._last) if axes < 0 and self._endless else axes)

    def go(self, target, nm_s, ticks, tool, tag):
        StreamQueue.go(self, target, self._along(self.deltas(target), nm_s), ticks, tool, tag)

    def fits(self, deltas, nm_s, ticks):
        StreamQueue.fits(self, deltas, self._along(deltas, nm_s), ticks)

    def _along(self, deltas, nm_s):
        """The speed along all axes at which the linear ones go at `nm_s`; it counts 10⁻⁶ degrees a second where none of them moves."""
        steps_per_m = [axis["steps_per_m"] for axis in self._axes]
        linear = length_nm(deltas[: self._last], steps_per_m)
        return nm_s * length_nm(deltas, steps_per_m) // linear if nm_s and linear else nm_s
