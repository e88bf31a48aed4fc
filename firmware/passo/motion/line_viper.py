"""line_plain.walk as machine code of the board. See there; the two give the same bits."""
# ruff: noqa: F821

import micropython


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
        rise = state[4 + axis]
        steps = 0
        if axis == dominant:
            steps = count
        elif rise:
            bit = 1 << axis
            decision = state[4 + axes + axis]
            i = at
            while i < end:
                if decision > fall:
                    out[i] = out[i] | bit
                    decision -= fall
                    steps += 1
                decision += rise
                i += 1
            state[4 + axes + axis] = decision
        if (state[3] >> axis) & 1:
            steps = 0 - steps
        state[4 + 2 * axes + axis] = state[4 + 2 * axes + axis] + steps
        axis += 1
