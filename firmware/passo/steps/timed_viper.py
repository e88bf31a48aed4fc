"""timed.walk_plain as machine code of the board. See there for the numbers of `state`; the two give the same bits.

Requests and ramps, which are rare beside plain steps, are left to the functions of timed.py.
"""
# ruff: noqa: F821

import micropython

from passo.records import (
    AXIS_ASKED, AXIS_CARRY, AXIS_DUE, AXIS_EACH, AXIS_ENDLESS, AXIS_FIELDS, AXIS_GAIN, AXIS_NEGATIVE, AXIS_NEW,
    AXIS_OVER, AXIS_Q, AXIS_REST, AXIS_TAKEN, AXIS_TO_GO, INDEPENDENT_AXES, INDEPENDENT_AXIS, INDEPENDENT_HOLD,
    INDEPENDENT_LEAST, INDEPENDENT_LEVELS, INDEPENDENT_SETUP, INDEPENDENT_TICKS,
)  # fmt: skip

from passo.steps.timed import interval, take


@micropython.viper
def walk(words: ptr32, at: int, room: int, bits: int, numbers, made: ptr32) -> int:
    state = ptr32(numbers)
    axes = state[INDEPENDENT_AXES]
    least = state[INDEPENDENT_LEAST]
    count = 0
    ticks = 0
    while count < room and ticks < 12500:
        mask = 0
        last = 0
        soonest = 0x1FFFFFFF
        axis = 0
        a = INDEPENDENT_AXIS
        while axis < axes:
            if state[a + AXIS_NEW] or state[a + AXIS_ASKED] != state[a + AXIS_TAKEN]:
                take(numbers, a)
            due = state[a + AXIS_DUE]
            togo = state[a + AXIS_TO_GO]
            if togo == 0 or (state[INDEPENDENT_HOLD] and state[a + AXIS_Q] == 0):
                if due > last:
                    last = due
            else:
                negative = state[a + AXIS_NEGATIVE]
                if ((state[INDEPENDENT_LEVELS] >> (axes + axis)) & 1) == negative:
                    state[INDEPENDENT_LEVELS] = state[INDEPENDENT_LEVELS] ^ (1 << (axes + axis))
                    if due < state[INDEPENDENT_SETUP]:
                        due = state[INDEPENDENT_SETUP]
                if due <= least:
                    mask |= 1 << axis
                    if negative:
                        made[axis] = made[axis] - 1
                    else:
                        made[axis] = made[axis] + 1
                    if state[a + AXIS_ENDLESS] == 0:
                        togo -= 1
                        state[a + AXIS_TO_GO] = togo
                    if state[a + AXIS_GAIN]:
                        due += int(interval(numbers, a, togo))
                    else:
                        due += state[a + AXIS_EACH]
                        carry = state[a + AXIS_CARRY] + state[a + AXIS_REST]
                        if carry >= state[a + AXIS_OVER]:
                            carry -= state[a + AXIS_OVER]
                            due += 1
                        state[a + AXIS_CARRY] = carry
                state[a + AXIS_DUE] = due
                if togo == 0:
                    if due > last:
                        last = due
                elif due < soonest:
                    soonest = due
            axis += 1
            a += AXIS_FIELDS
        gap = soonest
        if soonest == 0x1FFFFFFF:
            gap = last
        if gap > 125000:
            gap = 125000
        elif gap < least:
            if gap == 0:
                break
            gap = least
        words[at + count] = (gap << bits) | state[INDEPENDENT_LEVELS] | mask
        count += 1
        ticks += gap
        axis = 0
        a = INDEPENDENT_AXIS + AXIS_DUE
        while axis < axes:
            if state[a] > gap:
                state[a] = state[a] - gap
            else:
                state[a] = 0
            axis += 1
            a += AXIS_FIELDS
    state[INDEPENDENT_TICKS] = ticks
    return count
