"""The functions of checkpoints.py, and what the fields of its arrays are; a board with machine code of its own does
without it."""


from micropython import const

from passo.steps.pace_plain import TERMS, set_terms

COUNT = const(0x1FFFFFFF)  # word.COUNT_MASK
_HALF = const(0x10000000)
MARKS = const(64)  # most segments made and not yet played, a power of two
_LAST = const(63)

# The state. First the terms of the segment under way, as pace.py has them.
BITS = const(5)  # of a word's levels
AXES = const(6)
MASK = const(7)  # the ring's size − 1
LIMIT = const(8)  # words that may lie between the oldest mark and the next segment
SETUP = const(9)  # ticks between a change of direction and the next step
LEVELS = const(10)  # step form of the levels now: directions and tool
DEBT = const(11)  # ticks of set-up that the intervals to come still owe
TICKS = const(12)  # of all segments made, modulo 2²⁹, as the next three are
HEAD = const(13)  # words made
OLDEST = const(14)
NEWEST = const(15)
INDEX = const(16)  # dominant steps of its block made so far; of a track, the place
PACE = const(17)  # mean speed of the segment under way, as ramp.pace; 0 at a stand
PLAYED = const(18)  # words played when segments were last retired
PLACE = const(19)  # position after the last word made, of each axis, between −2²⁸ and 2²⁸ − 1
assert TERMS <= BITS

# A mark. Then the position, of each axis.
WORD = const(0)
MARK_TICKS = const(1)
MARK_INDEX = const(2)
ENDS = const(3)  # 1 where the segment is its block's last
MARK_PACE = const(4)
FIELDS = const(5)


def room(state, marks, lead_ticks):  # ISR: no allocation
    """1 where less than `lead_ticks` lie ahead and there is room for a segment; otherwise 0."""
    oldest = state[OLDEST]
    if (state[NEWEST] - oldest) & COUNT >= _LAST:
        return 0
    at = (oldest & _LAST) * (FIELDS + state[AXES])
    if (state[HEAD] - marks[at + WORD]) & COUNT > state[LIMIT]:
        return 0
    return 1 if (state[TICKS] - marks[at + MARK_TICKS]) & COUNT < lead_ticks else 0


def begin(state, words, moving, negative, steps, ticks):  # ISR: no allocation
    """Set the directions of the axes `moving`, where they change by a stepless word of the set-up time, and the terms
    of a segment of `steps` in `ticks` (where steps is 0 it has its own). Returns where in `words` it begins."""
    axes = state[AXES]
    levels = state[LEVELS] & ~(moving << axes) | (moving & ~negative) << axes
    if levels != state[LEVELS]:
        state[LEVELS] = levels
        setup = state[SETUP]
        if setup:
            words[state[HEAD] & state[MASK]] = setup << state[BITS] | levels
            state[HEAD] = (state[HEAD] + 1) & COUNT
            state[DEBT] += setup
            state[TICKS] = (state[TICKS] + setup) & COUNT
    if steps:
        state[INDEX] += steps
        set_terms(state, steps, ticks, levels, state[BITS])
    return state[HEAD] & state[MASK]


def end(state, marks, made, count, ticks, ends):  # ISR: no allocation
    """Count a segment of `count` words and leave a mark behind it; the steps `made` are added to the position, and
    cleared. Returns the words made so far."""
    state[HEAD] = (state[HEAD] + count) & COUNT
    state[TICKS] = (state[TICKS] + ticks) & COUNT
    number = (state[NEWEST] + 1) & COUNT
    axes = state[AXES]
    at = (number & _LAST) * (FIELDS + axes)
    marks[at + WORD] = state[HEAD]
    marks[at + MARK_TICKS] = state[TICKS]
    marks[at + MARK_INDEX] = state[INDEX]
    marks[at + ENDS] = ends
    marks[at + MARK_PACE] = state[PACE]
    for axis in range(axes):
        place = ((state[PLACE + axis] + made[axis] + _HALF) & COUNT) - _HALF
        state[PLACE + axis] = place
        marks[at + FIELDS + axis] = place
        made[axis] = 0
    state[NEWEST] = number
    return state[HEAD]


def retire(state, marks, played):  # ISR: no allocation
    """Give back the room of all segments played to their end; returns how many of them are their block's last."""
    ended = 0
    oldest = state[OLDEST]
    stride = FIELDS + state[AXES]
    state[PLAYED] = played
    while oldest != state[NEWEST]:
        number = (oldest + 1) & COUNT
        at = (number & _LAST) * stride
        if (played - marks[at + WORD]) & COUNT >= _HALF:
            break
        oldest = number
        ended += marks[at + ENDS]
    state[OLDEST] = oldest
    return ended


def find(state, marks, played, place):
    """Where in `marks` the last one played stands; its position goes to `place`."""
    number = state[OLDEST]
    stride = FIELDS + state[AXES]
    while number != state[NEWEST]:
        after = (number + 1) & COUNT
        if (played - marks[(after & _LAST) * stride + WORD]) & COUNT >= _HALF:
            break
        number = after
    at = (number & _LAST) * stride
    for axis in range(state[AXES]):
        place[axis] = marks[at + FIELDS + axis]
    return at
