"""How a line is walked; the fields of `state` are line.py's."""

from micropython import const

_AXES = const(0)
_DOMINANT = const(1)
_FALL = const(2)
_NEGATIVE = const(3)
_MOVING = const(4)
_RISE = const(5)


def begin(rows, at, state):  # ISR: no allocation
    """Make ready for the vector rows[at : at + axes]; its dominant steps."""
    axes = state[_AXES]
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
        state[_RISE + axis] = 2 * steps
    state[_DOMINANT] = dominant
    state[_FALL] = 2 * total
    state[_NEGATIVE] = negative
    state[_MOVING] = moving
    for axis in range(axes):
        state[_RISE + axes + axis] = state[_RISE + axis] + total
    return total


def walk(out, at, count, state):  # ISR: no allocation
    """Write the masks of the next `count` ≥ 1 dominant steps to out[at:], and add each axis's signed steps to `made`."""
    axes = state[_AXES]
    dominant = state[_DOMINANT]
    fall = state[_FALL]
    for i in range(at, at + count):
        out[i] = 1 << dominant
    for axis in range(axes):
        rise = state[_RISE + axis]
        steps = 0
        if axis == dominant:
            steps = count
        elif rise:
            bit = 1 << axis
            decision = state[_RISE + axes + axis]
            for i in range(at, at + count):
                if decision > fall:
                    out[i] |= bit
                    decision -= fall
                    steps += 1
                decision += rise
            state[_RISE + axes + axis] = decision
        state[_RISE + 2 * axes + axis] += -steps if state[_NEGATIVE] >> axis & 1 else steps
