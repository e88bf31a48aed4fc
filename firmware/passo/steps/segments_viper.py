"""The feeder's kernel: has the geometry of the block under way make segment after segment, writes their words to the ring,
and goes on with the lines behind it.

    what = make(state, marks, words, planner.rows, planner.scratch, planner.indices, ramp.state, line.state, power, cut, take_up,
                settle, geometry)

For each segment: room, how many steps and how long (`cut`, the ramp's), directions, which axes step (line.walk, or the
geometry's), when (pace_viper.pace), a checkpoint; and behind an accelerated line's last one the next line, if it is accelerated and
released.

    words   . . a a a a b b b c c c c c d d d . . .     a … d: segments; c is being played
    marks             |a    |b        |c    |d          one at each segment's end: words, ticks and position so far
                            ^FEED_OLDEST    ^FEED_NEWEST, FEED_HEAD

A segment is made if fewer than FEED_LEAD ticks, FEED_LIMIT words and MARKS segments lie behind the oldest mark; or if fewer
than FEED_LEAST ticks lie before the last word, which may last nearly as long as FEED_LEAD: a call later there is still one ahead.

A call of machine code by name costs some 15 µs, so all that a segment needs stands here between the calls: a segment of a
line costs three of them, a line three more. In all a line of 0.2 mm takes an RP2040's feeding interrupt 0.36 ms (`make bench`).
One text for all interpreters; see motion/block_viper.py. Fields: records.py.

`geometry` is None for a wait. An arc has `left`, `moving`, `negative`, `made` and walk(), as Circle has them; independent axes
and step programs make whole words, as IndependentAxes does. `settle` is Feeder.settle(), called only if something is owed or
a drive turns steps into levels. Returns why it ended:

    FULL    as much is made as may be now, or there is no room
    STANDS  a hold has come to its stand
    LATER   there will be more, and is none now
    ENDED   no block is under way, and there is room for one
"""
# ruff: noqa: F821

import micropython
from micropython import const

from passo.motion import line
from passo.motion.block import ARC, INDEPENDENT, LINE, STEP_PROGRAM, WAIT
from passo.motion.line import MAX_RUN
from passo.motion.row_viper import take
from passo.records import (
    COUNT_HALF, COUNT_MASK, FEED_AXES, FEED_BEGINS, FEED_BITS, FEED_DEBT, FEED_DRIVE, FEED_DRY, FEED_FAST, FEED_HEAD,
    FEED_HOLD, FEED_INDEX, FEED_KIND, FEED_LEAD, FEED_LEAST, FEED_LEFT, FEED_LEVELS, FEED_LIMIT, FEED_MASK, FEED_NEWEST,
    FEED_OLDEST, FEED_PACE, FEED_PLACE, FEED_PLAYED, FEED_POWER, FEED_ROW, FEED_SETUP, FEED_TICKS, FEED_TOOL,
    FEED_WAIT, HOLD_TICKS, LINE_MOVING, LINE_NEGATIVE, LINE_RISE, MARKS, MARK_ENDS, MARK_FIELDS, MARK_INDEX,
    MARK_PACE, MARK_TICKS, MARK_WORD, PACE_CARRY, PACE_OVER, PACE_REST, PACE_SHORT, PACE_TICK, POWER_FIELDS,
    POWER_HEAD, POWER_LEVEL, POWER_MARKS, POWER_MOST, POWER_SIZE, POWER_UNKNOWN, POWER_WORD, QUEUE_RETIRED, RAMP_PACE,
    RAMP_Q, RAMP_START, RAMP_STEPS, RAMP_S_CURVE, RAMP_TICKS, ROW_DYNAMIC, ROW_FIRST, ROW_POWER, ROW_RAPID, ROW_STEPS,
    ROW_TOOL, ROW_TOP, SCRATCH_PERCENT, SCRATCH_START,
)  # fmt: skip
from passo.steps import pace_viper

try:
    ptr32
except NameError:

    def ptr32(array):  # a name that only viper's compiler knows
        return array


FULL = const(0)
STANDS = const(1)
LATER = const(2)
ENDED = const(3)


@micropython.viper
def make(
    state: ptr32, marks: ptr32, ring, queue, scratch: ptr32, indices: ptr32, cuts, line_state, power: ptr32, cut, take_up, settle,
    geometry,
) -> int:  # ISR: no allocation
    words = ptr32(ring)
    rows = ptr32(queue)  # `cut` wants the arrays themselves
    ramp = ptr32(cuts)
    path = ptr32(line_state)
    walk = line.walk
    write = pace_viper.pace
    axes = state[FEED_AXES]
    bits = state[FEED_BITS]
    hold = state[FEED_HOLD]
    kind = state[FEED_KIND]
    row = state[FEED_ROW]
    left = state[FEED_LEFT]
    stride = MARK_FIELDS + axes
    result = FULL
    # --- give back what has been played
    oldest = state[FEED_OLDEST]
    while oldest != state[FEED_NEWEST]:
        mark = ((oldest + 1) & (MARKS - 1)) * stride
        if (state[FEED_PLAYED] - marks[mark + MARK_WORD]) & COUNT_MASK >= COUNT_HALF:
            break
        oldest = (oldest + 1) & COUNT_MASK
        indices[QUEUE_RETIRED] = (indices[QUEUE_RETIRED] + marks[mark + MARK_ENDS]) & COUNT_MASK
    state[FEED_OLDEST] = oldest
    if oldest == state[FEED_NEWEST]:
        state[FEED_DRY] = 1
    while True:
        # --- room
        newest = state[FEED_NEWEST]
        head = state[FEED_HEAD]
        mark = (oldest & (MARKS - 1)) * stride
        if (
            (newest - oldest) & COUNT_MASK >= MARKS - 1
            or (head - marks[mark + MARK_WORD]) & COUNT_MASK > state[FEED_LIMIT]
        ):
            break
        ahead = (state[FEED_TICKS] - marks[mark + MARK_TICKS]) & COUNT_MASK
        least = state[FEED_LEAD]
        if ahead >= least:
            if least > FEED_LEAST:
                least = FEED_LEAST
            if least == 0 or ahead - (words[(head - 1) & state[FEED_MASK]] >> bits) >= least:
                break
        wait = state[FEED_WAIT]
        if left == 0 and wait == 0:
            # --- the next line
            result = ENDED
            if hold or state[FEED_FAST] == 0 or scratch[SCRATCH_START] or ramp[RAMP_S_CURVE]:
                break
            each = int(take(rows, scratch, indices, 1 if ramp[RAMP_Q] else 0, 1))
            if each >> 30 & 1:
                break
            result = FULL
            row = each
            left = int(line.begin(rows, row + ROW_STEPS, path))
            take_up(rows, row, ramp, 0, left, 0)
            state[FEED_BEGINS] = 1
        if hold and ramp[RAMP_Q] <= ramp[RAMP_START]:
            if kind != INDEPENDENT or int(geometry.rolling()) == 0:
                result = STANDS
                break
        if state[FEED_BEGINS]:
            # --- a block begins: where its index does, and its tool
            state[FEED_BEGINS] = 0
            state[FEED_INDEX] = rows[row + ROW_FIRST]
            levels = state[FEED_LEVELS] & ~state[FEED_TOOL]
            if rows[row + ROW_TOOL]:
                levels |= state[FEED_TOOL]
            state[FEED_LEVELS] = levels
            if rows[row + ROW_POWER] != state[FEED_POWER]:
                state[FEED_POWER] = POWER_UNKNOWN
        # --- how many steps, and how long
        moving = path[LINE_MOVING]
        negative = path[LINE_NEGATIVE]
        made = path
        made_at = LINE_RISE + 2 * axes
        steps = 0
        ticks = 0
        speed = 0 - 1
        if wait:
            ticks = wait if wait < HOLD_TICKS else HOLD_TICKS
            state[FEED_WAIT] = wait - ticks
            moving = 0
            speed = state[FEED_PACE]
            if kind == WAIT:
                speed = 0
        elif kind == LINE or kind == ARC:
            shape = line_state
            if kind == ARC:
                shape = geometry.state
                moving = int(geometry.moving)
                negative = int(geometry.negative)
                made = ptr32(geometry.made)
                made_at = 0
            cut(queue, row, cuts, shape, left, scratch[SCRATCH_PERCENT + rows[row + ROW_RAPID]], hold)
            steps = ramp[RAMP_STEPS]
            if steps == 0:
                result = STANDS
                break
            ticks = ramp[RAMP_TICKS]
            if steps == 1 and ticks > HOLD_TICKS:
                state[FEED_WAIT] = ticks - HOLD_TICKS
                ticks = HOLD_TICKS
            speed = ramp[RAMP_PACE]
        else:
            if int(geometry.ready()) == 0:
                result = LATER
                break
            moving = int(geometry.moving)
            negative = int(geometry.negative)
            made = ptr32(geometry.made)
            made_at = 0
            if kind == STEP_PROGRAM:
                levels = state[FEED_LEVELS] & ~state[FEED_TOOL]
                if int(geometry.tool):
                    levels |= state[FEED_TOOL]
                state[FEED_LEVELS] = levels
        # --- power
        state[FEED_PACE] = speed
        if (rows[row + ROW_DYNAMIC] or state[FEED_POWER] > POWER_MOST) and (wait == 0 or kind == WAIT):
            level = rows[row + ROW_POWER]
            if rows[row + ROW_DYNAMIC] and speed >> 30 & 1 == 0:
                level = level * speed // rows[row + ROW_TOP] if speed else 0
            if level != state[FEED_POWER]:
                state[FEED_POWER] = level
                mark = POWER_MARKS + POWER_FIELDS * (power[POWER_HEAD] & (POWER_SIZE - 1))
                power[mark + POWER_WORD] = head
                power[mark + POWER_LEVEL] = level
                power[POWER_HEAD] = (power[POWER_HEAD] + 1) & COUNT_MASK
        # --- directions: where they change a word without a step, owed by those that follow
        levels = (state[FEED_LEVELS] & ~(moving << axes)) | ((moving & ~negative) << axes)
        if levels != state[FEED_LEVELS]:
            state[FEED_LEVELS] = levels
            setup = state[FEED_SETUP]
            if setup:
                words[head & state[FEED_MASK]] = (setup << bits) | levels
                owed = state[FEED_DEBT]
                if state[FEED_DRIVE]:
                    state[FEED_DEBT] = 0  # a set-up time is never shortened
                    settle(head & state[FEED_MASK], 1)
                head = (head + 1) & COUNT_MASK
                state[FEED_DEBT] = owed + setup
                state[FEED_TICKS] = (state[FEED_TICKS] + setup) & COUNT_MASK
        at = head & state[FEED_MASK]
        ends = 0
        run = 1
        if steps:
            # --- words of masks that share the time evenly, in two parts if they run over the ring's end
            state[FEED_INDEX] += steps
            each = ticks // steps
            state[PACE_SHORT] = (each << bits) | levels
            state[PACE_TICK] = 1 << bits
            state[PACE_REST] = ticks - each * steps
            state[PACE_OVER] = steps
            state[PACE_CARRY] = 0
            run = steps
            while run:
                part = run
                if at + run > state[FEED_MASK]:
                    part = state[FEED_MASK] + 1 - at
                if kind == LINE:
                    walk(words, at, part, path)
                else:
                    geometry.walk(ring, at, part)
                write(words, at, part, state)
                if state[FEED_DEBT] or state[FEED_DRIVE]:
                    settle(at, part)
                at = 0
                run -= part
            left -= steps
            if kind == ARC:
                left = int(geometry.left)
        else:
            if wait:
                words[at] = (ticks << bits) | levels
                steps = 1
            else:
                # --- whole words
                run = state[FEED_MASK] + 1 - at
                if run > MAX_RUN:
                    run = MAX_RUN
                state[FEED_HEAD] = head
                steps = int(geometry.walk(ring, at, run, levels, bits, hold))
                ends = int(geometry.ends())
                if steps == 0 and ends == 0:
                    result = STANDS
                    break
                ticks = int(geometry.ticks)
                state[FEED_LEVELS] = int(geometry.levels)
                state[FEED_INDEX] = int(geometry.place)
                if ends:
                    left = 0
            if steps and (state[FEED_DEBT] or state[FEED_DRIVE]):
                settle(at, steps)
        # --- checkpoint
        head = (head + steps) & COUNT_MASK
        ticks = (state[FEED_TICKS] + ticks) & COUNT_MASK
        state[FEED_TICKS] = ticks
        state[FEED_HEAD] = head
        newest = (newest + 1) & COUNT_MASK
        mark = (newest & (MARKS - 1)) * stride
        marks[mark + MARK_WORD] = head
        marks[mark + MARK_TICKS] = ticks
        marks[mark + MARK_INDEX] = state[FEED_INDEX]
        marks[mark + MARK_ENDS] = 1 if left == 0 and state[FEED_WAIT] == 0 else 0
        marks[mark + MARK_PACE] = speed
        mark += MARK_FIELDS
        axis = 0
        while axis < axes:
            place = ((state[FEED_PLACE + axis] + made[made_at] + COUNT_HALF) & COUNT_MASK) - COUNT_HALF
            state[FEED_PLACE + axis] = place
            marks[mark + axis] = place
            made[made_at] = 0
            made_at += 1
            axis += 1
        state[FEED_NEWEST] = newest
    state[FEED_ROW] = row
    state[FEED_LEFT] = left
    return result
