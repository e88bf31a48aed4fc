"""Weaving on or off, and the seams made of the lines and arcs of a program. Board file: section `weaving`.

WEAVE, `value`: a spec (motion.py) or None, holds for the lines and arcs at a feed behind it, until the next one or a reset.
"""

from passo import commands, errors
from passo.control.feature import ANEW
from passo.control.program import Program
from passo.options.weaving.commands import SEAM, WEAVE
from passo.options.weaving import motion as weave


class Weaving(Program):
    """The motion of a program whose lines and arcs may be seams: then each comes as a command."""

    event_mask = Program.event_mask | ANEW

    def __init__(self, board, machine, queue):
        self._steps_per_m = machine.steps_per_m
        self._spec = None  # None: lines and arcs are none
        self._steady_mm_min = board["weaving"]["steady_mm_min"]
        Program.__init__(self, board, machine, queue)

    def handlers(self):
        handlers = Program.handlers(self)
        handlers.update({WEAVE: self._set_spec, SEAM: self._do_seam})
        return handlers

    def _set_spec(self, command):
        """Do WEAVE. Returns the number of an error, LATER, or 0."""
        machine = self._machine
        if machine.alarm or machine.sleeping:
            return errors.LOCKED
        if machine.command is not None:
            return errors.LATER
        if command.value is not None and weave.is_out_of_range(command.value):
            return errors.NUMBER_RANGE
        self._spec = command.value
        return machine.confirm_command(command)

    def _do_seam(self, command):
        """Do SEAM: one seam, from rest. Returns the number of an error, or 0."""
        machine = self._machine
        if machine.alarm or machine.sleeping:
            return errors.LOCKED
        if not self._queue.still() or machine.command is not None or machine.axes_are_owned():
            return errors.BUSY
        if weave.is_out_of_range(command.value):
            return errors.NUMBER_RANGE
        before = self._spec
        self._spec = command.value
        command.kind = commands.ARC if any(command.centre) else commands.LINE
        command.target = [at + by for at, by in zip(self._queue.target, command.target)]
        result = machine.handlers[command.kind](command)
        self._spec = before
        return result

    def on_events(self, what):
        """Weave no more after power-up or a reset; see the base."""
        if what & ANEW:
            self._spec = None
        if what & Program.event_mask:
            Program.on_events(self, what)

    # --- the motion of a program, as seams

    def open(self, batch):
        """Open a batch, unless its lines are seams; see Program."""
        return self._spec is None and Program.open(self, batch)

    def _queue_row(self, command):
        """Take a line as a row of a batch, unless it is a seam; see Program."""
        return self._spec is None and Program._queue_row(self, command)

    def _can_reach(self, command):
        """True if all edges of a seam, too, are within the travel."""
        if not Program._can_reach(self, command):
            return False
        if self._spec is None or not self.reach():
            return True
        start = self._queue.target
        try:
            seam = self._make_woven(command)
        except ValueError:
            return True  # its motion will be refused for that
        for corner in seam.edge_points():
            if not self._is_within_travel([at + by for at, by in zip(start, corner)]):
                return False
        return True

    def _queue_otherwise(self, command, ticks):
        """Return True, and queue the seam, if the command is one."""
        if self._spec is None or not command.feed or ticks or command.kind not in (commands.LINE, commands.ARC):
            return False
        self._queue.follow(self._make_woven(command), command)
        return True

    def _make_woven(self, command):
        """Return the Woven of a line or an arc. Raises ValueError."""
        plane, circle = (0, 1), None
        if command.kind == commands.ARC:
            plane = command.first, command.second
            circle = command.centre, command.clockwise, command.turns - 1, command.over_half
        deltas = list(self._queue.deltas(command.target))
        return weave.Woven(deltas, plane, circle, self._spec, command.feed, command.tool, command.number, self._steps_per_m)
