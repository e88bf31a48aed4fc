"""The cost of every word of independent axes: the axes that step in it, and the time of the next one.

    count = walk(words, at, room, bits, state, made)

The method stands in motion.py, the fields of `state` in records.py. One text for all interpreters; see block_viper.py. No integer
reaches 2³⁰.
"""

import micropython
from micropython import const

from passo.options.independent.records import *
from passo.records import *

MOST_STEPS = const(0xFFFFFFF)  # that may be to come: 2²⁸ − 1
FAR = const(0x1FFFFFFF)  # ticks: no step is due as late as this


@micropython.viper
def square_root(q: int, near: int) -> int:  # ISR: no allocation
    """Return √q, rounded down, by Newton's method; `near`: a guess above 0."""
    if q < 1:
        return 0
    better = (near + q // near) >> 1
    while better > near + 1 or better < near - 1:
        near = better
        better = (near + q // near) >> 1
    while better * better > q:
        better -= 1
    return better


@micropython.viper
def take_request(state: ptr32, at: int):  # ISR: no allocation
    """Take over the request for the axis whose numbers begin at state[at]. If it turns round at speed, let it stand first."""
    q = state[at + AXIS_Q]
    gain = state[at + AXIS_GAIN]
    if state[at + AXIS_NEW]:
        if q and state[at + AXIS_NEW_NEGATIVE] != state[at + AXIS_NEGATIVE]:
            togo = (q + gain - 1) // gain + 1  # come to a stand first: q is the speed at the next step
            if state[at + AXIS_ENDLESS] or state[at + AXIS_TO_GO] > togo:
                state[at + AXIS_TO_GO] = togo
            state[at + AXIS_ENDLESS] = 0
            return
        each = state[at + AXIS_NEW_EACH]
        state[at + AXIS_EACH] = each
        state[at + AXIS_REST] = state[at + AXIS_NEW_REST]
        state[at + AXIS_OVER] = state[at + AXIS_NEW_OVER]
        if state[at + AXIS_CARRY] >= state[at + AXIS_OVER]:
            state[at + AXIS_CARRY] = 0
        if state[at + AXIS_DUE] > each and gain == 0:
            state[at + AXIS_DUE] = each
        state[at + AXIS_NEGATIVE] = state[at + AXIS_NEW_NEGATIVE]
        state[at + AXIS_ENDLESS] = state[at + AXIS_NEW_ENDLESS]
        state[at + AXIS_AIM] = state[at + AXIS_NEW_AIM]
        base = state[at + AXIS_NEW_BASE]
        if base >> 30 & 1 == 0:
            state[at + AXIS_TAKEN] = base
            state[at + AXIS_TO_GO] = (q + gain - 1) // gain + 1 if q else 0
            state[at + AXIS_NEW_BASE] = -1
        state[at + AXIS_NEW] = 0
    asked = state[at + AXIS_ASKED]
    more = (asked - state[at + AXIS_TAKEN]) & COUNT_MASK
    if more:
        state[at + AXIS_TAKEN] = asked
        state[at + AXIS_TO_GO] += more
    if state[at + AXIS_ENDLESS]:
        state[at + AXIS_TO_GO] = MOST_STEPS


@micropython.viper
def steady_ticks(state: ptr32, at: int) -> int:  # ISR: no allocation
    """Return the ticks from the step just made to the next one, of an axis that does not accelerate."""
    carry = state[at + AXIS_CARRY] + state[at + AXIS_REST]
    ticks = state[at + AXIS_EACH]
    if carry >= state[at + AXIS_OVER]:
        carry -= state[at + AXIS_OVER]
        ticks += 1
    state[at + AXIS_CARRY] = carry
    return ticks


@micropython.viper
def step_ticks(state: ptr32, at: int, togo: int) -> int:  # ISR: no allocation
    """Return the ticks from the step just made to the next one, with `togo` steps left, on the ramp or beside it. The method stands in motion.py."""
    gain = state[at + AXIS_GAIN]
    if gain:
        q = state[at + AXIS_Q]
        aim = 0 if state[INDEPENDENT_HOLD] else state[at + AXIS_AIM]
        after = q
        if q < aim:
            after = aim if aim - q < gain else q + gain
        elif q > aim:
            after = aim if q - aim < gain else q - gain
        if togo == 0:
            after = 0
        elif togo <= state[at + AXIS_NEAR] and gain * (togo - 1) < after:
            after = gain * (togo - 1)
        state[at + AXIS_Q] = after
        if q != after or q != aim:
            middle = (q + after) >> 1
            if middle < (gain + 1) >> 1:
                middle = (gain + 1) >> 1
            span = state[at + AXIS_SPAN]
            if middle < 0x100000:
                speed = square_root(middle << 8, 0x2000)
                ticks = (span // speed << 4) + (span % speed << 4) // speed
            else:
                speed = square_root(middle, 0x2000)
                ticks = span // speed
            return state[at + AXIS_EACH] if ticks < state[at + AXIS_EACH] and q <= aim else ticks
    return int(steady_ticks(state, at))


@micropython.viper
def advance_axis(state: ptr32, at: int, axis: int, made: ptr32) -> int:  # ISR: no allocation
    """Let the axis whose numbers begin at state[at] step if it is due. Returns 0: it stands; 1: it waits for its next step; 2: it steps."""
    if state[at + AXIS_NEW] or state[at + AXIS_ASKED] != state[at + AXIS_TAKEN]:
        take_request(state, at)
    due = state[at + AXIS_DUE]
    togo = state[at + AXIS_TO_GO]
    if togo == 0 or (state[INDEPENDENT_HOLD] and state[at + AXIS_Q] == 0):
        return 0
    negative = state[at + AXIS_NEGATIVE]
    turn = state[INDEPENDENT_AXES] + axis
    if ((state[INDEPENDENT_LEVELS] >> turn) & 1) == negative:
        state[INDEPENDENT_LEVELS] = state[INDEPENDENT_LEVELS] ^ (1 << turn)
        if due < state[INDEPENDENT_SETUP]:
            due = state[INDEPENDENT_SETUP]
    steps = 1
    if due <= state[INDEPENDENT_LEAST]:
        steps = 2
        made[axis] = made[axis] + 1 - 2 * negative
        if state[at + AXIS_ENDLESS] == 0:
            togo -= 1
            state[at + AXIS_TO_GO] = togo
        if state[at + AXIS_GAIN]:
            due += int(step_ticks(state, at, togo))
        else:
            due += int(steady_ticks(state, at))
    state[at + AXIS_DUE] = due
    return steps


@micropython.viper
def let_elapse(state: ptr32, ticks: int):  # ISR: no allocation
    """Let `ticks` pass for all axes."""
    axis = 0
    at = INDEPENDENT_AXIS + AXIS_DUE
    while axis < state[INDEPENDENT_AXES]:
        if state[at] > ticks:
            state[at] = state[at] - ticks
        else:
            state[at] = 0
        axis += 1
        at += AXIS_FIELDS


@micropython.viper
def walk(words: ptr32, at: int, room: int, bits: int, state: ptr32, made: ptr32) -> int:  # ISR: no allocation
    """Write at most `room` words, about a millisecond, to words[at:]; add each axis's signed steps to `made`.

    Returns how many: 0 if nothing moves and no interval runs."""
    count = 0
    ticks = 0
    while count < room and ticks < TICKS_PER_MS:
        mask = 0
        last = 0
        soonest = FAR
        axis = 0
        a = INDEPENDENT_AXIS
        while axis < state[INDEPENDENT_AXES]:
            steps = int(advance_axis(state, a, axis, made))
            due = state[a + AXIS_DUE]
            if steps == 2:
                mask |= 1 << axis
            if steps == 0 or state[a + AXIS_TO_GO] == 0:
                if due > last:
                    last = due
            elif due < soonest:
                soonest = due
            axis += 1
            a += AXIS_FIELDS
        gap = last if soonest == FAR else soonest
        if gap > HOLD_TICKS:
            gap = HOLD_TICKS
        elif gap < state[INDEPENDENT_LEAST]:
            if gap == 0:
                break
            gap = state[INDEPENDENT_LEAST]
        words[at + count] = (gap << bits) | state[INDEPENDENT_LEVELS] | mask
        count += 1
        ticks += gap
        let_elapse(state, gap)
    state[INDEPENDENT_TICKS] = ticks
    return count
