"""The functions of checkpoints.py, and what the fields of its arrays are; a board with machine code of its own does
without it."""


from micropython import const

from passo.records import (
    COUNT_HALF, COUNT_MASK, FEED_AXES, FEED_BITS, FEED_DEBT, FEED_HEAD, FEED_INDEX, FEED_LEVELS, FEED_LIMIT,
    FEED_MASK, FEED_NEWEST, FEED_OLDEST, FEED_PACE, FEED_PLACE, FEED_PLAYED, FEED_SETUP, FEED_TICKS, MARK_ENDS,
    MARK_FIELDS, MARK_INDEX, MARK_PACE, MARK_TICKS, MARK_WORD, PACE_FIELDS,
)  # fmt: skip
from passo.steps.pace_plain import set_terms

_LAST = const(63)

# The state. First the terms of the segment under way, as pace.py has them.
assert PACE_FIELDS <= FEED_BITS

# A mark. Then the position, of each axis.


def room(state, marks, lead_ticks):  # ISR: no allocation
    """1 where less than `lead_ticks` lie ahead and there is room for a segment; otherwise 0."""
    oldest = state[FEED_OLDEST]
    if (state[FEED_NEWEST] - oldest) & COUNT_MASK >= _LAST:
        return 0
    at = (oldest & _LAST) * (MARK_FIELDS + state[FEED_AXES])
    if (state[FEED_HEAD] - marks[at + MARK_WORD]) & COUNT_MASK > state[FEED_LIMIT]:
        return 0
    return 1 if (state[FEED_TICKS] - marks[at + MARK_TICKS]) & COUNT_MASK < lead_ticks else 0


def begin(state, words, moving, negative, steps, ticks):  # ISR: no allocation
    """Set the directions of the axes `moving`, where they change by a stepless word of the set-up time, and the terms
    of a segment of `steps` in `ticks` (where steps is 0 it has its own). Returns where in `words` it begins."""
    axes = state[FEED_AXES]
    levels = state[FEED_LEVELS] & ~(moving << axes) | (moving & ~negative) << axes
    if levels != state[FEED_LEVELS]:
        state[FEED_LEVELS] = levels
        setup = state[FEED_SETUP]
        if setup:
            words[state[FEED_HEAD] & state[FEED_MASK]] = setup << state[FEED_BITS] | levels
            state[FEED_HEAD] = (state[FEED_HEAD] + 1) & COUNT_MASK
            state[FEED_DEBT] += setup
            state[FEED_TICKS] = (state[FEED_TICKS] + setup) & COUNT_MASK
    if steps:
        state[FEED_INDEX] += steps
        set_terms(state, steps, ticks, levels, state[FEED_BITS])
    return state[FEED_HEAD] & state[FEED_MASK]


def end(state, marks, made, count, ticks, ends):  # ISR: no allocation
    """Count a segment of `count` words and leave a mark behind it; the steps `made` are added to the position, and
    cleared. Returns the words made so far."""
    state[FEED_HEAD] = (state[FEED_HEAD] + count) & COUNT_MASK
    state[FEED_TICKS] = (state[FEED_TICKS] + ticks) & COUNT_MASK
    number = (state[FEED_NEWEST] + 1) & COUNT_MASK
    axes = state[FEED_AXES]
    at = (number & _LAST) * (MARK_FIELDS + axes)
    marks[at + MARK_WORD] = state[FEED_HEAD]
    marks[at + MARK_TICKS] = state[FEED_TICKS]
    marks[at + MARK_INDEX] = state[FEED_INDEX]
    marks[at + MARK_ENDS] = ends
    marks[at + MARK_PACE] = state[FEED_PACE]
    for axis in range(axes):
        place = ((state[FEED_PLACE + axis] + made[axis] + COUNT_HALF) & COUNT_MASK) - COUNT_HALF
        state[FEED_PLACE + axis] = place
        marks[at + MARK_FIELDS + axis] = place
        made[axis] = 0
    state[FEED_NEWEST] = number
    return state[FEED_HEAD]


def retire(state, marks, played):  # ISR: no allocation
    """Give back the room of all segments played to their end; returns how many of them are their block's last."""
    ended = 0
    oldest = state[FEED_OLDEST]
    stride = MARK_FIELDS + state[FEED_AXES]
    state[FEED_PLAYED] = played
    while oldest != state[FEED_NEWEST]:
        number = (oldest + 1) & COUNT_MASK
        at = (number & _LAST) * stride
        if (played - marks[at + MARK_WORD]) & COUNT_MASK >= COUNT_HALF:
            break
        oldest = number
        ended += marks[at + MARK_ENDS]
    state[FEED_OLDEST] = oldest
    return ended


def find(state, marks, played, place):
    """Where in `marks` the last one played stands; its position goes to `place`."""
    number = state[FEED_OLDEST]
    stride = MARK_FIELDS + state[FEED_AXES]
    while number != state[FEED_NEWEST]:
        after = (number + 1) & COUNT_MASK
        if (played - marks[(after & _LAST) * stride + MARK_WORD]) & COUNT_MASK >= COUNT_HALF:
            break
        number = after
    at = (number & _LAST) * stride
    for axis in range(state[FEED_AXES]):
        place[axis] = marks[at + MARK_FIELDS + axis]
    return at
