"""Segments of accelerated lines, one after the other: the work that a stream of short lines costs the feeder.

    what = make(state, marks, words, planner.rows, planner.work, planner.counts, ramp.state, line.state, power, cut, settle)

For each segment: how many steps and how long (`cut`, the ramp's), directions, which axes step (line.walk), when (pace.pace), a
checkpoint; and behind a line's last one the next line, if it is accelerated and released. A call of machine code by name
costs some 15 µs, so that what checkpoints.py has as functions for the other walkers stands here between the calls: a segment
costs three of them, a line three more. One text for all interpreters; see motion/measure_viper.py. Fields: records.py.

`settle` is Feeder.settle(), called only if something is owed or a drive turns steps into levels. Returns why it ended:
FULL    as much is made as may be now, or there is no room
STANDS  a hold has come to its stand
WAITS   the last segment's word lasts longer than a word may: FEED_WAIT ticks are to be added
ENDED   the line has ended, and what comes next is not for this
"""
# ruff: noqa: F821

import micropython
from micropython import const

from passo.motion import line
from passo.motion.ramp_viper import begin as take_up
from passo.motion.row_viper import take
from passo.records import (
    FEED_AXES, FEED_BITS, FEED_DEBT, FEED_DRIVE, FEED_DRY, FEED_HEAD, FEED_HOLD, FEED_INDEX, FEED_LEAD, FEED_LEFT,
    FEED_LEVELS, FEED_LIMIT, FEED_MASK, FEED_NEWEST, FEED_OLDEST, FEED_PACE, FEED_PLACE, FEED_PLAYED, FEED_POWER,
    FEED_ROW, FEED_SETUP, FEED_TICKS, FEED_TOOL, FEED_WAIT, LINE_MOVING, LINE_NEGATIVE, LINE_RISE, MARK_ENDS,
    MARK_FIELDS, MARK_INDEX, MARK_PACE, MARK_TICKS, MARK_WORD, PACE_CARRY, PACE_OVER, PACE_REST, PACE_SHORT,
    PACE_TICK, POWER_FIELDS, POWER_HEAD, POWER_LEVEL, POWER_MARKS, POWER_SIZE, POWER_WORD, QUEUE_RETIRED, RAMP_PACE,
    RAMP_Q, RAMP_STEPS, RAMP_S_CURVE, RAMP_TICKS, ROW_DYNAMIC, ROW_FIRST, ROW_POWER, ROW_RAPID, ROW_STEPS, ROW_TOOL,
    ROW_TOP, WORK_PERCENT, WORK_START,
)  # fmt: skip
from passo.steps import pace

try:
    ptr32
except NameError:

    def ptr32(array):  # a name that only viper's compiler knows
        return array

FULL = const(0)
STANDS = const(1)
WAITS = const(2)
ENDED = const(3)


@micropython.viper
def make(
    state: ptr32, marks: ptr32, words: ptr32, queue, work: ptr32, counts: ptr32, cuts, line_state, power: ptr32, cut, settle
) -> int:  # ISR: no allocation
    rows = ptr32(queue)  # `cut` wants the arrays themselves
    ramp = ptr32(cuts)
    path = ptr32(line_state)
    walk = line.walk
    write = pace.pace
    axes = state[FEED_AXES]
    bits = state[FEED_BITS]
    hold = state[FEED_HOLD]
    drive = state[FEED_DRIVE]
    row = state[FEED_ROW]
    left = state[FEED_LEFT]
    stride = MARK_FIELDS + axes
    made = LINE_RISE + 2 * axes
    result = FULL
    # --- give back what has been played, as checkpoints.retire()
    oldest = state[FEED_OLDEST]
    while oldest != state[FEED_NEWEST]:
        mark = ((oldest + 1) & 63) * stride
        if (state[FEED_PLAYED] - marks[mark + MARK_WORD]) & 0x1FFFFFFF >= 0x10000000:
            break
        oldest = (oldest + 1) & 0x1FFFFFFF
        counts[QUEUE_RETIRED] = (counts[QUEUE_RETIRED] + marks[mark + MARK_ENDS]) & 0x1FFFFFFF
    state[FEED_OLDEST] = oldest
    if oldest == state[FEED_NEWEST]:
        state[FEED_DRY] = 1
    while True:
        # --- room
        newest = state[FEED_NEWEST]
        head = state[FEED_HEAD]
        mark = (oldest & 63) * stride
        if (
            (newest - oldest) & 0x1FFFFFFF >= 63
            or (head - marks[mark + MARK_WORD]) & 0x1FFFFFFF > state[FEED_LIMIT]
            or (state[FEED_TICKS] - marks[mark + MARK_TICKS]) & 0x1FFFFFFF >= state[FEED_LEAD]
        ):
            break
        if left == 0:
            # --- the next line
            result = ENDED
            if hold or work[WORK_START] or ramp[RAMP_S_CURVE]:
                break
            each = int(take(rows, work, counts, 1 if ramp[RAMP_Q] else 0, 1))
            if each >> 30 & 1:
                break
            result = FULL
            row = each
            left = int(line.begin(rows, row + ROW_STEPS, path))
            take_up(rows, row, ramp, 0, left, 0)
            state[FEED_INDEX] = rows[row + ROW_FIRST]
            levels = state[FEED_LEVELS] & ~state[FEED_TOOL]
            if rows[row + ROW_TOOL]:
                levels |= state[FEED_TOOL]
            state[FEED_LEVELS] = levels
            if rows[row + ROW_POWER] != state[FEED_POWER]:
                state[FEED_POWER] = 2000
        # --- how many steps, and how long
        cut(queue, row, cuts, line_state, left, work[WORK_PERCENT + rows[row + ROW_RAPID]], hold)
        steps = ramp[RAMP_STEPS]
        if steps == 0:
            result = STANDS
            break
        ticks = ramp[RAMP_TICKS]
        if steps == 1 and ticks > 125000:
            state[FEED_WAIT] = ticks - 125000
            ticks = 125000
            result = WAITS
        # --- power
        speed = ramp[RAMP_PACE]
        state[FEED_PACE] = speed
        if rows[row + ROW_DYNAMIC] or state[FEED_POWER] > 1000:
            level = rows[row + ROW_POWER]
            if rows[row + ROW_DYNAMIC]:
                level = level * speed // rows[row + ROW_TOP]
            if level != state[FEED_POWER]:
                state[FEED_POWER] = level
                mark = POWER_MARKS + POWER_FIELDS * (power[POWER_HEAD] & POWER_SIZE - 1)
                power[mark + POWER_WORD] = head
                power[mark + POWER_LEVEL] = level
                power[POWER_HEAD] = (power[POWER_HEAD] + 1) & 0x1FFFFFFF
        # --- directions, and the terms of its words
        moving = path[LINE_MOVING]
        levels = (state[FEED_LEVELS] & ~(moving << axes)) | ((moving & ~path[LINE_NEGATIVE]) << axes)
        if levels != state[FEED_LEVELS]:
            state[FEED_LEVELS] = levels
            setup = state[FEED_SETUP]
            if setup:
                words[head & state[FEED_MASK]] = (setup << bits) | levels
                head = (head + 1) & 0x1FFFFFFF
                state[FEED_DEBT] += setup
                state[FEED_TICKS] = (state[FEED_TICKS] + setup) & 0x1FFFFFFF
        state[FEED_INDEX] += steps
        each = ticks // steps
        state[PACE_SHORT] = (each << bits) | levels
        state[PACE_TICK] = 1 << bits
        state[PACE_REST] = ticks - each * steps
        state[PACE_OVER] = steps
        state[PACE_CARRY] = 0
        # --- words, in two parts if they run over the ring's end
        at = head & state[FEED_MASK]
        run = steps
        while run:
            part = run
            if at + run > state[FEED_MASK]:
                part = state[FEED_MASK] + 1 - at
            walk(words, at, part, path)
            write(words, at, part, state)
            if state[FEED_DEBT] or drive:
                settle(at, part)
            at = 0
            run -= part
        left -= steps
        # --- checkpoint
        head = (head + steps) & 0x1FFFFFFF
        ticks = (state[FEED_TICKS] + ticks) & 0x1FFFFFFF
        state[FEED_TICKS] = ticks
        state[FEED_HEAD] = head
        newest = (newest + 1) & 0x1FFFFFFF
        mark = (newest & 63) * stride
        marks[mark + MARK_WORD] = head
        marks[mark + MARK_TICKS] = ticks
        marks[mark + MARK_INDEX] = state[FEED_INDEX]
        marks[mark + MARK_ENDS] = 1 if left == 0 and result != WAITS else 0
        marks[mark + MARK_PACE] = speed
        mark += MARK_FIELDS
        axis = 0
        while axis < axes:
            place = ((state[FEED_PLACE + axis] + path[made + axis] + 0x10000000) & 0x1FFFFFFF) - 0x10000000
            state[FEED_PLACE + axis] = place
            marks[mark + axis] = place
            path[made + axis] = 0
            axis += 1
        state[FEED_NEWEST] = newest
        if result == WAITS:
            break
    if left == 0 and result == FULL:
        result = ENDED
    state[FEED_ROW] = row
    state[FEED_LEFT] = left
    return result
