"""The queue of a machine whose motors are not its axes (motion.py): positions are the axes', what the feeder counts the motors'.

Commands, travel, homing and reports are in steps of the axes, as everywhere. A machine stopped amid a step of an axis is reported at
the step below; the next block makes up for it.
"""

from passo.control.stream_queue import Chords, StreamQueue
from passo.steps.word import TICKS_PER_S


class Pieces:
    """A line as `count` chords of equal length: with the attributes that Chords reads of an ellipse."""

    flat_nm = 0

    def __init__(self, deltas, count):
        self._deltas = list(deltas)
        self._count = self.left = count
        self._gone = [0] * len(self._deltas)

    def chord(self):
        """Return the steps of each axis to the end of the next piece."""
        self.left -= 1
        found = []
        for axis in range(len(self._deltas)):
            there = self._deltas[axis] * (self._count - self.left) // self._count
            found.append(there - self._gone[axis])
            self._gone[axis] = there
        return found


class Queue(StreamQueue):
    def __init__(self, board, planner, feeder, player, port):
        StreamQueue.__init__(self, board, planner, feeder, player, port)
        self._axes_of = planner.kinematics.to_axes
        self._zero = self._origin[:]  # in steps of the axes; `_origin` stays 0
        self._found = self._origin[:]

    def go(self, target, nm_s, ticks, tool, tag):
        """Queue a line to `target`; in pieces if the kinematics bend straight lines. See the base; raises ValueError."""
        planner = self._planner
        if planner.kinematics.STRAIGHT:
            StreamQueue.go(self, target, nm_s, ticks, tool, tag)
            return
        deltas = self.deltas(target)
        position = [here + zero for here, zero in zip(self.target, self._zero)]
        pieces = Pieces(deltas, planner.kinematics.pieces(position, deltas))
        slowest, _ = planner.slowest_limits([])
        if ticks:
            nm_s = planner.own.length(deltas) * TICKS_PER_S // ticks
        chords = Chords(pieces, nm_s or slowest, tool, tag, planner.own.steps_per_m, [], slowest)
        self._change_tool(tool, tag)
        self.chords = chords
        self.feed()
        self.lead(target)
        self.waiting = True

    def look(self):
        StreamQueue.look(self)
        self._turn_to_axes(self.here, self.here)

    def _turn_to_axes(self, motors, into):
        """Turn the positions of `motors`, steps since power-up, into those of the axes, in `into`. Returns it."""
        self._axes_of(motors, into)
        for axis in range(len(into)):
            into[axis] -= self._zero[axis]
        return into

    def _from_origin(self, found):
        """Return the axes' position, in steps from the origin, for the motors' `found`."""
        return self._turn_to_axes(found, self._found)

    def axis(self, axis, edge=None):
        """Return an axis's position in steps since power-up; `edge`: see position_view()."""
        return self.position_view(edge)[axis] + self._zero[axis]

    def set_origin(self, axes=-1):
        """Let the axes of a mask count from here (-1: all)."""
        found = self.position_view()
        for axis in range(len(found)):
            if axes >> axis & 1:
                self._zero[axis] += found[axis]
        self.settle()

    def settle(self):
        """Let the queue end where the motors stand. Only at a stand."""
        self._planner.stand_at(self._feeder.position(self._player.words_played()))
        StreamQueue.settle(self)

    def drop(self):
        """Drop all that is queued, and settle. Only once the player has stopped."""
        StreamQueue.drop(self)
        self.settle()
