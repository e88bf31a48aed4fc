"""Weaving on or off, and the seams made of the lines and arcs of a program. Board file: section `weaving`.

WEAVE, `value`: a spec (options/weaving/motion.py) or None, holds for the lines and arcs at a feed behind it, until the next one or a reset.
program.py asks `machine.weave` at each of these.
"""

from passo import commands, errors
from passo.control.feature import ANEW, Feature
from passo.options.weaving import motion as weave


class Weaving(Feature):
    heeds = ANEW

    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        self._steps_per_m = [axis["steps_per_m"] for axis in board["axes"]]
        self._spec = None
        machine.steady_mm_min = board["weaving"]["steady_mm_min"]

    def handlers(self):
        return {commands.WEAVE: self._set, commands.SEAM: self._seam}

    def _set(self, command):
        machine = self._machine
        if machine.alarm or machine.sleeping:
            return errors.LOCKED
        if machine.command is not None:
            return errors.LATER
        if command.value is not None and weave.wrong(command.value):
            return errors.NUMBER_RANGE
        self._spec = command.value
        machine.weave = None if command.value is None else self
        return machine.accepted(command)

    def _seam(self, command):
        """One seam, from rest."""
        machine = self._machine
        if machine.alarm or machine.sleeping:
            return errors.LOCKED
        if not self._queue.still() or machine.command is not None or machine.occupied():
            return errors.BUSY
        if weave.wrong(command.value):
            return errors.NUMBER_RANGE
        kept = machine.weave, self._spec
        machine.weave, self._spec = self, command.value
        command.kind = commands.ARC if any(command.centre) else commands.LINE
        command.target = [at + by for at, by in zip(self._queue.target, command.target)]
        result = machine.handlers[command.kind](command)
        machine.weave, self._spec = kept
        return result

    def woven(self, command):
        """The Woven of a line or an arc. Raises ValueError."""
        plane, circle = (0, 1), None
        if command.kind == commands.ARC:
            plane = command.first, command.second
            circle = command.centre, command.clockwise, command.turns - 1, command.over_half
        deltas = list(self._queue.deltas(command.target))
        return weave.Woven(deltas, plane, circle, self._spec, command.feed, command.tool, command.number, self._steps_per_m)

    def inside(self, command, inside):
        """True if all edges of the seam are inside(position)."""
        start = self._queue.target
        try:
            seam = self.woven(command)
        except ValueError:
            return True  # its motion will be refused for that
        for corner in seam.corners():
            if not inside([at + by for at, by in zip(start, corner)]):
                return False
        return True

    def heed(self, _):
        self._spec = self._machine.weave = None
