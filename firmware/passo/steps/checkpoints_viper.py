"""The functions of checkpoints_plain.py as machine code of the board. See there; they give the same bits."""
# ruff: noqa: F821

import micropython

from passo.records import (
    FEED_AXES, FEED_BITS, FEED_DEBT, FEED_HEAD, FEED_INDEX, FEED_LEVELS, FEED_LIMIT, FEED_MASK, FEED_NEWEST,
    FEED_OLDEST, FEED_PACE, FEED_PLACE, FEED_PLAYED, FEED_SETUP, FEED_TICKS, MARK_ENDS, MARK_FIELDS, MARK_INDEX, MARK_PACE, MARK_TICKS, MARK_WORD, PACE_CARRY, PACE_OVER, PACE_REST,
    PACE_SHORT, PACE_TICK,
)  # fmt: skip


@micropython.viper
def room(state: ptr32, marks: ptr32, lead_ticks: int) -> int:
    oldest = state[FEED_OLDEST]
    if ((state[FEED_NEWEST] - oldest) & 0x1FFFFFFF) >= 63:
        return 0
    at = (oldest & 63) * (MARK_FIELDS + state[FEED_AXES])
    if ((state[FEED_HEAD] - marks[at + MARK_WORD]) & 0x1FFFFFFF) > state[FEED_LIMIT]:
        return 0
    if ((state[FEED_TICKS] - marks[at + MARK_TICKS]) & 0x1FFFFFFF) < lead_ticks:
        return 1
    return 0


@micropython.viper
def begin(state: ptr32, words: ptr32, moving: int, negative: int, steps: int, ticks: int) -> int:
    axes = state[FEED_AXES]
    bits = state[FEED_BITS]
    levels = (state[FEED_LEVELS] & ~(moving << axes)) | ((moving & ~negative) << axes)
    if levels != state[FEED_LEVELS]:
        state[FEED_LEVELS] = levels
        setup = state[FEED_SETUP]
        if setup:
            words[state[FEED_HEAD] & state[FEED_MASK]] = (setup << bits) | levels
            state[FEED_HEAD] = (state[FEED_HEAD] + 1) & 0x1FFFFFFF
            state[FEED_DEBT] += setup
            state[FEED_TICKS] = (state[FEED_TICKS] + setup) & 0x1FFFFFFF
    if steps:
        state[FEED_INDEX] += steps
        each = ticks // steps
        state[PACE_SHORT] = (each << bits) | levels
        state[PACE_TICK] = 1 << bits
        state[PACE_REST] = ticks - each * steps
        state[PACE_OVER] = steps
        state[PACE_CARRY] = 0
    return state[FEED_HEAD] & state[FEED_MASK]


@micropython.viper
def end(state: ptr32, marks: ptr32, made: ptr32, count: int, ticks: int, ends: int) -> int:
    head = (state[FEED_HEAD] + count) & 0x1FFFFFFF
    state[FEED_HEAD] = head
    ticks = (state[FEED_TICKS] + ticks) & 0x1FFFFFFF
    state[FEED_TICKS] = ticks
    number = (state[FEED_NEWEST] + 1) & 0x1FFFFFFF
    axes = state[FEED_AXES]
    at = (number & 63) * (MARK_FIELDS + axes)
    marks[at + MARK_WORD] = head
    marks[at + MARK_TICKS] = ticks
    marks[at + MARK_INDEX] = state[FEED_INDEX]
    marks[at + MARK_ENDS] = ends
    marks[at + MARK_PACE] = state[FEED_PACE]
    at += MARK_FIELDS
    axis = 0
    while axis < axes:
        place = ((state[FEED_PLACE + axis] + made[axis] + 0x10000000) & 0x1FFFFFFF) - 0x10000000
        state[FEED_PLACE + axis] = place
        marks[at + axis] = place
        made[axis] = 0
        axis += 1
    state[FEED_NEWEST] = number
    return head


@micropython.viper
def retire(state: ptr32, marks: ptr32, played: int) -> int:
    ended = 0
    oldest = state[FEED_OLDEST]
    stride = MARK_FIELDS + state[FEED_AXES]
    state[FEED_PLAYED] = played
    while oldest != state[FEED_NEWEST]:
        number = (oldest + 1) & 0x1FFFFFFF
        at = (number & 63) * stride
        if ((played - marks[at + MARK_WORD]) & 0x1FFFFFFF) >= 0x10000000:
            break
        oldest = number
        ended += marks[at + MARK_ENDS]
    state[FEED_OLDEST] = oldest
    return ended


@micropython.viper
def find(state: ptr32, marks: ptr32, played: int, place: ptr32) -> int:
    number = state[FEED_OLDEST]
    stride = MARK_FIELDS + state[FEED_AXES]
    while number != state[FEED_NEWEST]:
        after = (number + 1) & 0x1FFFFFFF
        if ((played - marks[(after & 63) * stride + MARK_WORD]) & 0x1FFFFFFF) >= 0x10000000:
            break
        number = after
    at = (number & 63) * stride
    axis = stride - MARK_FIELDS
    while axis:
        axis -= 1
        place[axis] = marks[at + MARK_FIELDS + axis]
    return at
