"""Cuts a block into segments of about a millisecond, with acceleration: how many dominant steps, how many ticks they last.

The ramp carries q, the square of the speed, in units of the block's own (see profile.py), because along the path q is
linear: it gains at most `gain` a step. Each segment's end takes the largest q that

    - the block's speed and the override allow, or, in a hold, the least that can be reached
    - still leaves room to slow down to the block's planned exit, `leave`

      q ^      _________            A segment's time is exact for the trapezoid inside it: its steps at peak
        |     /         \\           speed, and what getting from v₁ to the peak and on to v₂ costs more,
        |    /           \\          t·(peak − v) / 2·peak each, t being the time that change of speed takes.
        |___/_____________\\___ path

    v₁                     v₂

The peak may be above both ends: so the steps in which a hold comes to its stand never take longer than from rest, however
slow the machine is before them.

What is accelerated, and every arc, is cut by ramp_viper.py; where jerk is limited smooth.py goes on from there. A step of
path is along a line one of its dominant axis, along an arc the length of one. The ramp takes a part of a board's memory
that not every machine has to spare: Planner.load() makes it. All may run in an interrupt: no allocation, no integer of
2³⁰.
"""

from array import array

import micropython
from micropython import const

from passo.motion.block import ARC, GAIN
from passo.motion.ramp_viper import begin, cut
from passo.motion.steady import CUT_STEPS, SEGMENT_TICKS, TOTAL, Steady

_ARC_TICKS = const(75_000)  # what every run of a tight arc costs a board is up to half a millisecond
_SMOOTH_TICKS = const(37_500)  # with limited jerk: the pace is even in a segment, off the curve by acceleration · t² / 8
_FAR = const(0x1FFFFFFF)
_V_BITS = const(7)
# In `state`, behind what steady.py has there:
_LENGTH = const(8)  # ticks a segment should last
_SMOOTH = const(9)  # 1: cut() leaves off where smooth.py goes on, for which the rest is
_PATH = const(10)  # of the segment
_TO_GO = const(11)  # steps of path behind it
_PART = const(12)  # and 2⁻¹⁷ of one
_CHANGE = const(13)  # of q, at most
_CAP = const(14)  # q wanted, in a hold 0
_HIGH = const(15)  # but for the hold
_BEGIN = const(16)  # q that it begins with


class Ramp(Steady):
    """Steady, and with acceleration: a block begins at the speed that the one before ended with."""

    def __init__(self):
        Steady.__init__(self)
        self.state = array("i", [0] * (_BEGIN + 1))
        self.cut_short = cut  # cut_short(block.rows, block.at, state, walker.state, left, percent, hold)
        self._block = None
        self._arc = False
        self._part = 0

    @micropython.native
    def begin(self, block):  # ISR: no allocation
        rows = block.rows
        at = block.at
        gain = rows[at + GAIN]
        arc = self._arc = block.kind == ARC
        smooth = gain and block.smooth
        self.short = (gain or arc) and not smooth
        state = self.state
        state[_SMOOTH] = 1 if smooth else 0
        state[_LENGTH] = _SMOOTH_TICKS if smooth else _ARC_TICKS if arc else SEGMENT_TICKS
        if not arc:
            state[TOTAL] = block.walker.total
        if smooth:
            self._block = block
            self._each = block.ticks
            self._rest = block.ticks_rest
            self._total = state[TOTAL]
        if gain:
            begin(rows, at, state, block.start)
        elif arc:
            self.stall()
        else:
            Steady.begin(self, block)

    @micropython.native
    def cut(self, left, percent=100, hold=False):  # ISR: no allocation
        """The next segment: `percent` of the programmed speed is wanted; with `hold` none at all. Its steps are 0 where the
        machine stands."""
        if self.state[_SMOOTH]:
            self._cut_smooth(left, percent, hold)
        else:
            Steady.cut(self, left, percent, hold)

    def _cut_smooth(self, left, percent, hold):  # ISR: no allocation
        state = self.state
        block = self._block
        cut(block.rows, block.at, state, block.walker.state, left, percent, hold)
        steps = state[CUT_STEPS]
        if steps:
            path, togo, part, change = state[_PATH], state[_TO_GO], state[_PART], state[_CHANGE]
            block.smooth.cut(self, state[_BEGIN], steps, path, togo, part, change, state[_CAP], state[_HIGH])

    def _step_ticks(self, span, speed):  # ISR: no allocation
        """span·64 / speed: the ticks of a step at `speed`; what is left over, in 128ths, goes to `_part`."""
        whole = span // speed
        rest = (span % speed) << 6
        part = rest % speed
        self._part = (part << _V_BITS) // speed
        whole = whole << 6 if whole < 0x800000 else _FAR
        return whole + rest // speed
