"""Cuts accelerated lines, and arcs, into segments: how many steps, and how many ticks they last.

    ramp.begin(block)
    ramp.cut(rows, at, ramp.state, walker.state, left, percent, hold)   # RAMP_STEPS, RAMP_TICKS, RAMP_PACE of ramp.state

The ramp carries q, the square of the speed, in units of the block's own (see limits.py), because along the path q is
linear: it gains at most `gain` a step. Each segment's end takes the largest q that

    - the block's speed and the override allow, or, in a hold, the least that can be reached
    - still leaves room to slow down to the block's planned exit, `leave`

      q ^      _________            A segment's time is exact for the trapezoid inside it: its steps at peak
        |     /         \\           speed, and what getting from v₁ to the peak and on to v₂ costs more,
        |    /           \\          t·(peak − v) / 2·peak each, t being the time that change of speed takes.
        |___/_____________\\___ path

    v₁                     v₂

The peak may be above both ends, so that the last steps of a hold never take longer than from rest, however slow the
machine was before them.

ramp_viper.py has the kernels; if jerk is limited an option takes over from there. A step of path is a step of a line's
dominant axis, and the same length along an arc. Costs a board 7 kB of machine code: only Planner.load() makes
a ramp. All may run in an interrupt: no allocation, no integer of 2³⁰.
"""

from array import array

import micropython

from passo.motion.line import Steady
from passo.motion.ramp_viper import begin, cut
from passo.records import KIND_LINE, RAMP_FIELDS, ROW_GAIN


class Ramp(Steady):
    """Steady, and with acceleration: a block begins at the speed that the one before ended with."""

    def __init__(self):
        Steady.__init__(self)
        self.state = array("i", [0] * RAMP_FIELDS)
        self.take_up = begin
        self.accelerated = cut  # cuts accelerated lines, and arcs
        self.s_curve = None  # takes up a block where jerk is limited: an option's

    @micropython.native
    def begin(self, block):  # ISR: no allocation
        """Begin a block: choose the cut (steady without acceleration, S-curve, else linear) and write its start into `state`."""
        rows = block.rows
        at = block.at
        gain = rows[at + ROW_GAIN]
        total = block.walker.total if block.kind == KIND_LINE else 0
        if total and not gain:
            Steady.begin(self, block)
            return
        self.cut = self.accelerated
        s_curve = gain and self.s_curve
        begin(rows, at, self.state, block.start, total, 1 if s_curve else 0)
        if s_curve:
            s_curve(rows, at, self.state)
