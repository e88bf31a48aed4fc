"""Cuts lines at constant speed into segments of about a millisecond: how many dominant steps, and how many ticks they last.

    ramp.begin(block)
    ramp.cut(rows, at, ramp.state, line.state, left, percent, hold)     # RAMP_STEPS, RAMP_TICKS, RAMP_PACE of ramp.state

A segment is never cut inside a dominant interval: below 1000 steps/s it is one step long. A line's total is exact: the ticks
that do not divide by its steps are spread over all of it. Overrides do not count. ramp.py accelerates. All may run in an
interrupt: no allocation, no integer of 2³⁰.
"""

from array import array

import micropython
from micropython import const

from passo.motion.line import MAX_RUN, MAX_STEPS
from passo.records import *


LONGEST_TICKS = const(0x1FFFFFFF)  # of one wait, or of one dominant step: 43 s


def refuse(result):
    """Raise ValueError for a result of block_viper.plan_block() below 0."""
    if result == -1:
        raise ValueError("steps more than 43 s apart")
    raise ValueError("a line of more than %d steps" % MAX_STEPS)


def dominant(deltas, ticks):
    """Return a line's dominant steps. Raises ValueError if there are too many, or too far apart at constant speed."""
    total = max([abs(delta) for delta in deltas])
    if total > MAX_STEPS:
        refuse(-2)
    if total and ticks // total > LONGEST_TICKS:
        refuse(-1)
    return total


@micropython.native
def cut(rows, at, state, walker, left, percent, hold):  # ISR: no allocation
    """The next segment of the line whose row begins at rows[at], with `left` ≥ 1 dominant steps to come. With `hold` its steps
    are 0: the machine stands."""
    state[RAMP_STEPS] = 0
    state[RAMP_PACE] = -1
    if hold:
        return
    each = rows[at + ROW_TICKS]
    steps = TICKS_PER_MS // each or 1
    if steps > left:
        steps = left
    if steps > MAX_RUN:
        steps = MAX_RUN
    carry = state[RAMP_CARRY] + steps * rows[at + ROW_TICKS_REST]
    state[RAMP_CARRY] = carry % state[RAMP_TOTAL]
    state[RAMP_TICKS] = steps * each + carry // state[RAMP_TOTAL]
    state[RAMP_STEPS] = steps


class Steady:
    """Lines at programmed speed. After cut() the first fields of `state` tell of the segment."""

    def __init__(self):
        self.state = array("i", [0] * STEADY_FIELDS)
        self.cut = cut  # of the block under way: cut(rows, at, state, walker.state, left, percent, hold)
        self.even = cut  # cuts lines at constant speed
        self.take_up = None  # begins an accelerated line: ramp_viper.begin()

    def stall(self):  # ISR: no allocation
        """The machine stands: the next block begins at rest."""
        self.state[RAMP_Q] = self.state[RAMP_V] = 0

    def moving(self):  # ISR: no allocation
        """Return True when the next segment begins at a speed that was reached by acceleration: it could not stand here."""
        return self.state[RAMP_Q] > self.state[RAMP_START]

    def begin(self, block):  # ISR: no allocation
        """Take up `block`, a line."""
        state = self.state
        state[RAMP_Q] = state[RAMP_V] = state[RAMP_CARRY] = 0
        state[RAMP_TOTAL] = block.walker.total
        self.cut = self.even
