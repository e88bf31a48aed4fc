"""Cuts a block into segments of about a millisecond: how many dominant steps, and how many ticks they last.

A segment is never cut inside a dominant interval: where steps are further apart it is one step long. At programmed
speed a line's total is exact: the ticks that do not divide by its steps are spread over all of it. With acceleration
ramp.py does this. All may run in an interrupt: no allocation, no integer of 2³⁰.
"""

from array import array

import micropython
from micropython import const

from passo.motion.line import MAX_RUN
from passo.records import RAMP_CARRY, RAMP_PACE, RAMP_Q, RAMP_START, RAMP_STEPS, RAMP_TICKS, RAMP_V, STEADY_FIELDS

SEGMENT_TICKS = const(12_500)  # 1 ms


class Steady:
    """After cut(), the first of `state` tell of the segment."""

    def __init__(self):
        self.state = array("i", [0] * STEADY_FIELDS)
        self.cut_short = None
        self.short = False  # the block is accelerated, or an arc: cut_short() is to be called instead of cut()
        self._each = self._rest = self._total = 0

    def stall(self):  # ISR: no allocation
        """The machine stands: what comes next begins at rest."""
        self.state[RAMP_Q] = self.state[RAMP_V] = 0

    def moving(self):  # ISR: no allocation
        """True when the next segment begins at a speed that was reached by acceleration: it could not stand here."""
        return self.state[RAMP_Q] > self.state[RAMP_START]

    @micropython.native
    def begin(self, block):  # ISR: no allocation
        """Take up `block`."""
        state = self.state
        state[RAMP_Q] = state[RAMP_V] = state[RAMP_CARRY] = 0
        self._each = block.ticks
        self._rest = block.ticks_rest
        self._total = block.walker.total

    @micropython.native
    def cut(self, left, percent=100, hold=False):  # ISR: no allocation
        """The next segment of a walker that has `left` ≥ 1 dominant steps before its end or its next corner. With `hold`
        its steps are 0: the machine stands."""
        state = self.state
        state[RAMP_STEPS] = 0
        state[RAMP_PACE] = -1
        if hold:
            return
        steps = SEGMENT_TICKS // self._each or 1
        if steps > left:
            steps = left
        if steps > MAX_RUN:
            steps = MAX_RUN
        state[RAMP_TICKS] = self._nominal(steps)
        state[RAMP_STEPS] = steps

    @micropython.native
    def _nominal(self, steps):  # ISR: no allocation
        state = self.state
        carry = state[RAMP_CARRY] + steps * self._rest
        state[RAMP_CARRY] = carry % self._total
        return steps * self._each + carry // self._total
