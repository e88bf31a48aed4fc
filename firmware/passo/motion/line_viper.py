"""line_plain.begin and walk as machine code of the board. See there; they give the same bits."""
# ruff: noqa: F821

import micropython


@micropython.viper
def begin(rows: ptr32, at: int, state: ptr32) -> int:
    axes = state[0]
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
        state[5 + axis] = 2 * steps
        axis += 1
    state[1] = dominant
    state[2] = 2 * total
    state[3] = negative
    state[4] = moving
    while axis:
        axis -= 1
        state[5 + axes + axis] = state[5 + axis] + total
    return total


@micropython.viper
def walk(out: ptr32, at: int, count: int, state: ptr32):
    axes = state[0]
    dominant = state[1]
    fall = state[2]
    bit = 1 << dominant
    end = at + count
    i = at
    while i < end:
        out[i] = bit
        i += 1
    axis = 0
    while axis < axes:
        rise = state[5 + axis]
        steps = 0
        if axis == dominant:
            steps = count
        elif rise:
            bit = 1 << axis
            decision = state[5 + axes + axis]
            i = at
            while i < end:
                if decision > fall:
                    out[i] = out[i] | bit
                    decision -= fall
                    steps += 1
                decision += rise
                i += 1
            state[5 + axes + axis] = decision
        if (state[3] >> axis) & 1:
            steps = 0 - steps
        state[5 + 2 * axes + axis] = state[5 + 2 * axes + axis] + steps
        axis += 1
