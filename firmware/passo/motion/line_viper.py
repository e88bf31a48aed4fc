"""line_plain.begin and walk as machine code of the board. See there; they give the same bits."""
# ruff: noqa: F821

import micropython

from passo.records import (
    LINE_AXES, LINE_DOMINANT, LINE_FALL, LINE_MOVING, LINE_NEGATIVE, LINE_RISE,
)  # fmt: skip


@micropython.viper
def begin(rows: ptr32, at: int, state: ptr32) -> int:
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
def walk(out: ptr32, at: int, count: int, state: ptr32):
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
            decision = state[LINE_RISE + axes + axis]
            i = at
            while i < end:
                if decision > fall:
                    out[i] = out[i] | bit
                    decision -= fall
                    steps += 1
                decision += rise
                i += 1
            state[LINE_RISE + axes + axis] = decision
        if (state[LINE_NEGATIVE] >> axis) & 1:
            steps = 0 - steps
        state[LINE_RISE + 2 * axes + axis] = state[LINE_RISE + 2 * axes + axis] + steps
        axis += 1
