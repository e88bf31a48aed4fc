"""The functions of checkpoints_plain.py as machine code of the board. See there; they give the same bits."""
# ruff: noqa: F821

import micropython


@micropython.viper
def room(state: ptr32, marks: ptr32, lead_ticks: int) -> int:
    oldest = state[14]
    if ((state[15] - oldest) & 0x1FFFFFFF) >= 63:
        return 0
    at = (oldest & 63) * (5 + state[6])
    if ((state[13] - marks[at]) & 0x1FFFFFFF) > state[8]:
        return 0
    if ((state[12] - marks[at + 1]) & 0x1FFFFFFF) < lead_ticks:
        return 1
    return 0


@micropython.viper
def begin(state: ptr32, words: ptr32, moving: int, negative: int, steps: int, ticks: int) -> int:
    axes = state[6]
    bits = state[5]
    levels = (state[10] & ~(moving << axes)) | ((moving & ~negative) << axes)
    if levels != state[10]:
        state[10] = levels
        setup = state[9]
        if setup:
            words[state[13] & state[7]] = (setup << bits) | levels
            state[13] = (state[13] + 1) & 0x1FFFFFFF
            state[11] += setup
            state[12] = (state[12] + setup) & 0x1FFFFFFF
    if steps:
        state[16] += steps
        each = ticks // steps
        state[0] = (each << bits) | levels
        state[1] = 1 << bits
        state[2] = ticks - each * steps
        state[3] = steps
        state[4] = 0
    return state[13] & state[7]


@micropython.viper
def end(state: ptr32, marks: ptr32, made: ptr32, count: int, ticks: int, ends: int) -> int:
    head = (state[13] + count) & 0x1FFFFFFF
    state[13] = head
    ticks = (state[12] + ticks) & 0x1FFFFFFF
    state[12] = ticks
    number = (state[15] + 1) & 0x1FFFFFFF
    axes = state[6]
    at = (number & 63) * (5 + axes)
    marks[at] = head
    marks[at + 1] = ticks
    marks[at + 2] = state[16]
    marks[at + 3] = ends
    marks[at + 4] = state[17]
    at += 5
    axis = 0
    while axis < axes:
        place = ((state[19 + axis] + made[axis] + 0x10000000) & 0x1FFFFFFF) - 0x10000000
        state[19 + axis] = place
        marks[at + axis] = place
        made[axis] = 0
        axis += 1
    state[15] = number
    return head


@micropython.viper
def retire(state: ptr32, marks: ptr32, played: int) -> int:
    ended = 0
    oldest = state[14]
    stride = 5 + state[6]
    state[18] = played
    while oldest != state[15]:
        number = (oldest + 1) & 0x1FFFFFFF
        at = (number & 63) * stride
        if ((played - marks[at]) & 0x1FFFFFFF) >= 0x10000000:
            break
        oldest = number
        ended += marks[at + 3]
    state[14] = oldest
    return ended


@micropython.viper
def find(state: ptr32, marks: ptr32, played: int, place: ptr32) -> int:
    number = state[14]
    stride = 5 + state[6]
    while number != state[15]:
        after = (number + 1) & 0x1FFFFFFF
        if ((played - marks[(after & 63) * stride]) & 0x1FFFFFFF) >= 0x10000000:
            break
        number = after
    at = (number & 63) * stride
    axis = stride - 5
    while axis:
        axis -= 1
        place[axis] = marks[at + 5 + axis]
    return at
