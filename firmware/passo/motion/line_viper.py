"""The cost of every step of a line: the axes that step in it, by Bresenham's method.

    total = begin(rows, at, state)      # make ready for the vector rows[at : at + axes]; its dominant steps
    walk(out, at, count, state)         # the masks of the next `count` of them

The method stands in line.py, the fields of `state` in records.py. One text for all interpreters; see block_viper.py. No integer
reaches 2³⁰.
"""

import micropython

from passo.records import *


@micropython.viper
def begin(rows: ptr32, at: int, state: ptr32) -> int:  # ISR: no allocation
    """Make `state` ready for the vector rows[at : at + axes], for Bresenham's method. Returns its dominant steps."""
    axes = state[LINE_AXES]
    total = 0
    dominant = 0
    moving = 0
    negative = 0
    axis = 0
    while axis < axes:
        steps = rows[at + axis]
        if steps:
            moving |= 1 << axis
        if (steps >> 30) & 1:  # negative, also where it was read into 64 bits
            negative |= 1 << axis
            steps = 0 - steps
        steps &= 0x3FFFFFFF
        if steps > total:
            total = steps
            dominant = axis
        state[LINE_RISE + axis] = 2 * steps
        axis += 1
    state[LINE_DOMINANT] = dominant
    state[LINE_FALL] = 2 * total
    state[LINE_NEGATIVE] = negative
    state[LINE_MOVING] = moving
    while axis:
        axis -= 1
        state[LINE_RISE + axes + axis] = state[LINE_RISE + axis] + total
    return total


@micropython.viper
def walk(out: ptr32, at: int, count: int, state: ptr32):  # ISR: no allocation
    """Write the masks of the next `count` ≥ 1 dominant steps to out[at:], and add each axis's signed steps to `made`."""
    axes = state[LINE_AXES]
    dominant = state[LINE_DOMINANT]
    fall = state[LINE_FALL]
    bit = 1 << dominant
    end = at + count
    i = at
    while i < end:
        out[i] = bit
        i += 1
    axis = 0
    while axis < axes:
        rise = state[LINE_RISE + axis]
        steps = 0
        if axis == dominant:
            steps = count
        elif rise:
            bit = 1 << axis
            i = fall + rise - state[LINE_RISE + axes + axis]
            ahead = i // rise  # dominant steps before the next one of this axis
            over = rise - (i - ahead * rise)  # the decision there, above `fall`
            gap = fall // rise
            rest = fall - gap * rise
            i = at + ahead
            while i < end:
                out[i] = out[i] | bit
                steps += 1
                i += gap
                if over > rest:
                    over -= rest
                else:
                    over += rise - rest
                    i += 1
            state[LINE_RISE + axes + axis] = over + fall - (i - end) * rise
        if (state[LINE_NEGATIVE] >> axis) & 1:
            steps = 0 - steps
        state[LINE_RISE + 2 * axes + axis] = state[LINE_RISE + 2 * axes + axis] + steps
        axis += 1
