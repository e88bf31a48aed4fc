"""timed.walk_plain as machine code of the board. See there for the numbers of `state`; the two give the same bits.

Requests and ramps, which are rare beside plain steps, are left to the functions of timed.py.
"""
# ruff: noqa: F821

import micropython

from passo.steps.timed import interval, take


@micropython.viper
def walk(words: ptr32, at: int, room: int, bits: int, numbers, made: ptr32) -> int:
    state = ptr32(numbers)
    axes = state[0]
    least = state[1]
    count = 0
    ticks = 0
    while count < room and ticks < 12500:
        mask = 0
        last = 0
        soonest = 0x1FFFFFFF
        axis = 0
        a = 6
        while axis < axes:
            if state[a + 15] or state[a + 14] != state[a + 2]:
                take(numbers, a)
            due = state[a + 3]
            togo = state[a]
            if togo == 0 or (state[5] and state[a + 9] == 0):
                if due > last:
                    last = due
            else:
                negative = state[a + 8]
                if ((state[3] >> (axes + axis)) & 1) == negative:
                    state[3] = state[3] ^ (1 << (axes + axis))
                    if due < state[2]:
                        due = state[2]
                if due <= least:
                    mask |= 1 << axis
                    if negative:
                        made[axis] = made[axis] - 1
                    else:
                        made[axis] = made[axis] + 1
                    if state[a + 1] == 0:
                        togo -= 1
                        state[a] = togo
                    if state[a + 11]:
                        due += int(interval(numbers, a, togo))
                    else:
                        due += state[a + 4]
                        carry = state[a + 7] + state[a + 5]
                        if carry >= state[a + 6]:
                            carry -= state[a + 6]
                            due += 1
                        state[a + 7] = carry
                state[a + 3] = due
                if togo == 0:
                    if due > last:
                        last = due
                elif due < soonest:
                    soonest = due
            axis += 1
            a += 23
        gap = soonest
        if soonest == 0x1FFFFFFF:
            gap = last
        if gap > 125000:
            gap = 125000
        elif gap < least:
            if gap == 0:
                break
            gap = least
        words[at + count] = (gap << bits) | state[3] | mask
        count += 1
        ticks += gap
        axis = 0
        a = 9
        while axis < axes:
            if state[a] > gap:
                state[a] = state[a] - gap
            else:
                state[a] = 0
            axis += 1
            a += 23
    state[4] = ticks
    return count
