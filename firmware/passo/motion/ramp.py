"""Cuts a block into segments of about a millisecond: how many dominant steps, and how many ticks they last.

A segment is never cut inside a dominant interval: where steps are further apart it is one step long. The block's total
is exact: the ticks that do not divide by its steps are spread over all of it.
"""

import micropython
from micropython import const

from passo.motion.line import MAX_RUN

SEGMENT_TICKS = const(12_500)  # 1 ms


class Ramp:
    """Constant speed. After cut(), `steps` and `ticks` hold the segment."""

    def __init__(self):
        self.steps = self.ticks = 0
        self._each = self._rest = self._total = self._carry = 0

    def begin(self, block):  # ISR: no allocation
        self._each = block.ticks
        self._rest = block.ticks_rest
        self._total = block.walker.total
        self._carry = 0

    @micropython.native
    def cut(self, left):  # ISR: no allocation
        """The next segment of a walker that has `left` ≥ 1 dominant steps before its end or its next corner."""
        steps = SEGMENT_TICKS // self._each or 1
        if steps > left:
            steps = left
        if steps > MAX_RUN:
            steps = MAX_RUN
        carry = self._carry + steps * self._rest
        self.steps = steps
        self.ticks = steps * self._each + carry // self._total
        self._carry = carry % self._total
