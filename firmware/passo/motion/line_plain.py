"""How a line is walked; the fields of `state` are line.py's."""

from passo.records import LINE_AXES, LINE_DOMINANT, LINE_FALL, LINE_MOVING, LINE_NEGATIVE, LINE_RISE


def begin(rows, at, state):  # ISR: no allocation
    """Make ready for the vector rows[at : at + axes]; its dominant steps."""
    axes = state[LINE_AXES]
    total = dominant = moving = negative = 0
    for axis in range(axes):
        steps = rows[at + axis]
        if steps:
            moving |= 1 << axis
        if steps < 0:
            negative |= 1 << axis
            steps = -steps
        if steps > total:
            total = steps
            dominant = axis
        state[LINE_RISE + axis] = 2 * steps
    state[LINE_DOMINANT] = dominant
    state[LINE_FALL] = 2 * total
    state[LINE_NEGATIVE] = negative
    state[LINE_MOVING] = moving
    for axis in range(axes):
        state[LINE_RISE + axes + axis] = state[LINE_RISE + axis] + total
    return total


def walk(out, at, count, state):  # ISR: no allocation
    """Write the masks of the next `count` ≥ 1 dominant steps to out[at:], and add each axis's signed steps to `made`."""
    axes = state[LINE_AXES]
    dominant = state[LINE_DOMINANT]
    fall = state[LINE_FALL]
    for i in range(at, at + count):
        out[i] = 1 << dominant
    for axis in range(axes):
        rise = state[LINE_RISE + axis]
        steps = 0
        if axis == dominant:
            steps = count
        elif rise:
            bit = 1 << axis
            decision = state[LINE_RISE + axes + axis]
            for i in range(at, at + count):
                if decision > fall:
                    out[i] |= bit
                    decision -= fall
                    steps += 1
                decision += rise
            state[LINE_RISE + axes + axis] = decision
        state[LINE_RISE + 2 * axes + axis] += -steps if state[LINE_NEGATIVE] >> axis & 1 else steps
