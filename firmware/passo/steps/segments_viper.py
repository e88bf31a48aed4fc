"""The feeder's kernel: has the geometry of the block under way make segment after segment, writes their words to the ring,
and goes on with the lines behind it.

    what = make(state, marks, words, planner.rows, planner.scratch, planner.indices, ramp.state, line.state, power, cut, take_up,
                settle, burn, geometry, played, lead_ticks)

For each segment: room, how many steps and how long (`cut`, the ramp's), directions, which axes step (line_viper.walk, or the
geometry's), when (pace_viper.pace), a checkpoint; behind an accelerated line the next one released, if it is accelerated too.

    words   . . a a a a b b b c c c c c d d d . . .     a … d: segments; c is being played
    marks             |a    |b        |c    |d          one at each segment's end: words, ticks and position so far
                            ^FEED_OLDEST    ^FEED_NEWEST, FEED_HEAD

A segment is made if fewer than FEED_LEAD ticks, FEED_LIMIT words and MARKS segments lie behind the oldest mark; or if fewer
than FEED_LEAST ticks lie before the last word, which may last nearly as long as FEED_LEAD: a call later there is still one ahead.
One text for all interpreters; see motion/block_viper.py. Fields: records.py, FEED_… of `state`.

`geometry` is None for a wait. An arc has `left`, `moving`, `negative`, `made` and walk(), as Circle has them; independent axes
and step programs make whole words, as IndependentAxes does. `settle` is Feeder.settle(), called only if something is owed or
a drive turns steps into levels; `burn` is an option's, called for a row of dots. Returns why it ended:

    FULL    as much is made as may be now, or there is no room
    STANDS  a hold has come to its stand
    LATER   there will be more, and is none now
    ENDED   no block is under way, and there is room for one
"""
# Shared with interrupts: state, marks, indices, power
# `cut` is usually passo.motion.ramp_viper.cut
# `take_up` is usually passo.motion.ramp_viper.begin

import micropython
from micropython import const

from passo.motion import line_viper
from passo.motion.line import MAX_RUN
from passo.motion.row_viper import take
from passo.records import *
from passo.steps import pace_viper

FULL = const(0)
STANDS = const(1)
LATER = const(2)
ENDED = const(3)
FEED_LEAST = const(50_000)  # 4 ms: more than two calls of a feeder are apart
MANY_LINES = const(48)  # with this many lines in the queue, half of its room, they are played at full speed, however short
SLOWEST = const(10)  # percent of the programmed speed, where lines hardly come


@micropython.viper
def make(
    state: ptr32, marks: ptr32, ring, queue, scratch: ptr32, indices: ptr32, cuts, line_state, power: ptr32, cut, take_up, settle,
    burn, geometry, played: int, lead_ticks: int,
) -> int:  # ISR: no allocation
    """See above."""
    words = ptr32(ring)
    rows = ptr32(queue)  # `cut` wants the arrays themselves
    state[FEED_PLAYED] = played
    state[FEED_LEAD] = lead_ticks
    retire(state, marks, indices)
    while int(has_room(state, marks, words, power)):
        if state[FEED_LEFT] == 0 and state[FEED_WAIT] == 0:
            if int(next_line(state, queue, scratch, indices, cuts, line_state, take_up)) == 0:
                return ENDED
        if state[FEED_HOLD] and int(stands(state, cuts, geometry)):
            return STANDS
        if state[FEED_BEGINS]:
            begin_block(state, rows)
        what = int(measure(state, queue, scratch, indices, cuts, line_state, cut, geometry))
        if what != FULL:
            return what
        mark_power(state, rows, power)
        turn(state, words, settle)
        if state[FEED_WAITS]:
            write_wait(state, words, settle)
        elif state[FEED_STEPS]:
            write_steps(state, rows, ring, line_state, power, settle, burn, geometry)
            if rows[state[FEED_ROW] + ROW_POWER] > POWER_MOST and state[FEED_LEFT] == 0 and int(stands(state, cuts, geometry)):
                burn(state, rows, power, ptr32(line_state), words, 0, 0, 0)
        elif int(write_words(state, ring, settle, geometry)) == 0:
            return STANDS
        made = ptr32(line_state)
        first = LINE_RISE + 2 * state[FEED_AXES]
        if state[FEED_WAITS] == 0 and state[FEED_KIND] != KIND_LINE:
            made = ptr32(geometry.made)
            first = 0
        checkpoint(state, marks, made, first)
    return FULL


@micropython.viper
def retire(state: ptr32, marks: ptr32, indices: ptr32):  # ISR: no allocation
    """Give back the marks, and the blocks, of segments that have been played."""
    stride = MARK_FIELDS + state[FEED_AXES]
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


@micropython.viper
def has_room(state: ptr32, marks: ptr32, words: ptr32, power: ptr32) -> int:  # ISR: no allocation
    """1 if one more segment may be made: there are marks, there are words, and too few ticks lie ahead."""
    oldest = state[FEED_OLDEST]
    head = state[FEED_HEAD]
    mark = (oldest & (MARKS - 1)) * (MARK_FIELDS + state[FEED_AXES])
    if (state[FEED_NEWEST] - oldest) & COUNT_MASK >= MARKS - 1 or (power[POWER_HEAD] - power[POWER_TAIL]) & COUNT_MASK > power[POWER_WAIT]:
        return 0
    if (head - marks[mark + MARK_WORD]) & COUNT_MASK > state[FEED_LIMIT]:
        return 0
    ahead = (state[FEED_TICKS] - marks[mark + MARK_TICKS]) & COUNT_MASK
    least = state[FEED_LEAD]
    if least > FEED_LEAST and state[FEED_KIND] == KIND_LINE:
        least -= state[FEED_SHORT]
    if ahead < least:
        return 1
    if least > FEED_LEAST:
        least = FEED_LEAST
    if least == 0 or ahead - (words[(head - 1) & state[FEED_MASK]] >> state[FEED_BITS]) >= least:
        return 0
    return 1


@micropython.viper
def next_line(state: ptr32, queue, scratch: ptr32, indices: ptr32, cuts, line_state, take_up) -> int:  # ISR: no allocation
    """Take up the line behind, if it is accelerated and released, and so was the one before. Returns 0 if the feeder has to."""
    ramp = ptr32(cuts)
    rows = ptr32(queue)
    if state[FEED_HOLD] or state[FEED_FAST] == 0 or scratch[SCRATCH_START] or ramp[RAMP_S_CURVE]:
        return 0
    row = int(take(rows, scratch, indices, 1 if ramp[RAMP_Q] else 0, 1))
    if row >> 30 & 1:
        return 0
    left = int(line_viper.begin(rows, row + ROW_STEPS, ptr32(line_state)))
    take_up(rows, row, ramp, 0, left, 0)
    state[FEED_ROW] = row
    state[FEED_LEFT] = left
    state[FEED_BEGINS] = 1
    return 1


@micropython.viper
def stands(state: ptr32, cuts, geometry) -> int:  # ISR: no allocation
    """1 if a hold has come to its stand."""
    ramp = ptr32(cuts)
    if ramp[RAMP_Q] > ramp[RAMP_START]:
        return 0
    if state[FEED_KIND] == KIND_INDEPENDENT and int(geometry.rolling()):
        return 0
    return 1


@micropython.viper
def begin_block(state: ptr32, rows: ptr32):  # ISR: no allocation
    """A block begins: where its index does, with its tool."""
    row = state[FEED_ROW]
    state[FEED_BEGINS] = 0
    state[FEED_INDEX] = rows[row + ROW_FIRST]
    set_tool(state, rows[row + ROW_TOOL])
    if rows[row + ROW_POWER] << POWER_FINE != state[FEED_POWER]:
        state[FEED_POWER] = POWER_UNKNOWN


@micropython.viper
def set_tool(state: ptr32, on: int):  # ISR: no allocation
    """The tool's bit of the words to come."""
    levels = state[FEED_LEVELS] & ~state[FEED_TOOL]
    if on:
        levels |= state[FEED_TOOL]
    state[FEED_LEVELS] = levels


@micropython.viper
def measure(state: ptr32, queue, scratch: ptr32, indices: ptr32, cuts, line_state, cut, geometry) -> int:  # ISR: no allocation
    """Work out how many steps the segment has, how long it lasts, and which axes move; no steps if the geometry makes words itself.
    Returns FULL; STANDS or LATER if there is none now."""
    path = ptr32(line_state)
    kind = state[FEED_KIND]
    state[FEED_STEPS] = 0
    state[FEED_LASTS] = 0
    state[FEED_WAITS] = 0
    if state[FEED_WAIT]:
        take_wait(state)
        return FULL
    shape = line_state
    if kind == KIND_LINE:
        state[FEED_MOVING] = path[LINE_MOVING]
        state[FEED_NEGATIVE] = path[LINE_NEGATIVE]
    else:
        if kind != KIND_ARC and int(geometry.ready()) == 0:
            return LATER
        state[FEED_MOVING] = int(geometry.moving)
        state[FEED_NEGATIVE] = int(geometry.negative)
        if kind == KIND_ARC:
            shape = geometry.state
    if kind == KIND_LINE or kind == KIND_ARC:
        return int(cut_segment(state, queue, scratch, indices, cuts, shape, cut))
    state[FEED_PACE] = -1
    if kind == KIND_STEP_PROGRAM:
        set_tool(state, int(geometry.tool))
    return FULL


@micropython.viper
def take_wait(state: ptr32):  # ISR: no allocation
    """The next word of a wait, which moves no axis; of a WAIT the pace is 0, of a long step that of the step."""
    ticks = state[FEED_WAIT]
    if ticks > HOLD_TICKS:
        ticks = HOLD_TICKS
    state[FEED_WAIT] = state[FEED_WAIT] - ticks
    state[FEED_LASTS] = ticks
    state[FEED_WAITS] = 1
    state[FEED_MOVING] = 0
    if state[FEED_KIND] == KIND_WAIT:
        state[FEED_PACE] = 0


@micropython.viper
def percent(state: ptr32, rows: ptr32, scratch: ptr32, indices: ptr32, ramp: ptr32) -> int:  # ISR: no allocation
    """Return the override; less while a stream brings fewer than MANY_LINES, more slowly than they are played, so that they last."""
    row = state[FEED_ROW]
    asked = scratch[SCRATCH_PERCENT + rows[row + ROW_RAPID]]
    each = rows[row + ROW_TICKS]
    left = state[FEED_LEFT]
    if scratch[SCRATCH_EAGER] < 2 or state[FEED_KIND] != KIND_LINE or ramp[RAMP_S_CURVE] or left >= 0x4000 or each >= 0x4000:
        return asked
    lasts = left * each + ((scratch[SCRATCH_LASTS] - scratch[SCRATCH_TAKEN]) & COUNT_MASK)
    count = (indices[QUEUE_ADDED] - indices[QUEUE_FETCHED]) & COUNT_MASK
    if lasts >= LONG_TICKS or count >= MANY_LINES:
        return asked
    slow = asked * (lasts >> 8) // (LONG_TICKS >> 8)
    count = asked * count // MANY_LINES
    if count > slow:
        slow = count
    return slow if slow > SLOWEST else SLOWEST


@micropython.viper
def cut_segment(state: ptr32, queue, scratch: ptr32, indices: ptr32, cuts, shape, cut) -> int:  # ISR: no allocation
    """Cut the next segment of a line or arc, whose walker's state is `shape`. A word longer than HOLD_TICKS leaves a wait behind."""
    ramp = ptr32(cuts)
    rows = ptr32(queue)
    row = state[FEED_ROW]
    cut(queue, row, cuts, shape, state[FEED_LEFT], int(percent(state, rows, scratch, indices, ramp)), state[FEED_HOLD])
    steps = ramp[RAMP_STEPS]
    if steps == 0:
        return STANDS
    ticks = ramp[RAMP_TICKS]
    if steps == 1 and ticks > HOLD_TICKS:
        state[FEED_WAIT] = ticks - HOLD_TICKS
        ticks = HOLD_TICKS
    state[FEED_STEPS] = steps
    state[FEED_LASTS] = ticks
    state[FEED_PACE] = ramp[RAMP_PACE]
    return FULL


@micropython.viper
def mark_power(state: ptr32, rows: ptr32, power: ptr32):  # ISR: no allocation
    """Put a mark where the tool's power changes: as the row says, in proportion to the speed if it is dynamic; not for dots."""
    row = state[FEED_ROW]
    speed = state[FEED_PACE]
    level = rows[row + ROW_POWER]
    if state[FEED_WAITS] and state[FEED_KIND] != KIND_WAIT or rows[row + ROW_DYNAMIC] == 0 and state[FEED_POWER] != POWER_UNKNOWN:
        return
    if level > POWER_MOST:
        return
    level <<= POWER_FINE
    if rows[row + ROW_DYNAMIC] and speed >> 30 & 1 == 0:
        level = level * speed // rows[row + ROW_TOP] if speed else 0
    put_mark(state, power, state[FEED_HEAD], level)


@micropython.viper
def put_mark(state: ptr32, power: ptr32, word: int, level: int):  # ISR: no allocation
    """The power is `level` from `word` on, if it is another one."""
    if level != state[FEED_POWER]:
        state[FEED_POWER] = level
        power[POWER_MARKS + (power[POWER_HEAD] & power[POWER_MASK])] = (word & POWER_WORDS) << POWER_WORD | level
        power[POWER_HEAD] = (power[POWER_HEAD] + 1) & COUNT_MASK


@micropython.viper
def turn(state: ptr32, words: ptr32, settle):  # ISR: no allocation
    """If directions change: a word without a step, which lasts the set-up time, owed by the words that follow."""
    axes = state[FEED_AXES]
    moving = state[FEED_MOVING]
    levels = (state[FEED_LEVELS] & ~(moving << axes)) | ((moving & ~state[FEED_NEGATIVE]) << axes)
    if levels == state[FEED_LEVELS]:
        return
    state[FEED_LEVELS] = levels
    setup = state[FEED_SETUP]
    if setup:
        at = state[FEED_HEAD] & state[FEED_MASK]
        words[at] = (setup << state[FEED_BITS]) | levels
        owed = state[FEED_DEBT]
        if state[FEED_DRIVE]:
            state[FEED_DEBT] = 0  # a set-up time is never shortened
            settle(at, 1)
        state[FEED_HEAD] = (state[FEED_HEAD] + 1) & COUNT_MASK
        state[FEED_DEBT] = owed + setup
        state[FEED_TICKS] = (state[FEED_TICKS] + setup) & COUNT_MASK


@micropython.viper
def write_wait(state: ptr32, words: ptr32, settle):  # ISR: no allocation
    """One word without a step."""
    at = state[FEED_HEAD] & state[FEED_MASK]
    words[at] = (state[FEED_LASTS] << state[FEED_BITS]) | state[FEED_LEVELS]
    state[FEED_STEPS] = 1
    if state[FEED_DEBT] or state[FEED_DRIVE]:
        settle(at, 1)


@micropython.viper
def write_steps(state: ptr32, rows: ptr32, ring, line_state, power: ptr32, settle, burn, geometry):  # ISR: no allocation
    """Words of masks that share the time evenly, in two parts if they run over the ring's end."""
    words = ptr32(ring)
    path = ptr32(line_state)
    steps = state[FEED_STEPS]
    state[FEED_INDEX] = state[FEED_INDEX] + steps
    each = state[FEED_LASTS] // steps
    state[PACE_SHORT] = (each << state[FEED_BITS]) | state[FEED_LEVELS]
    state[PACE_TICK] = 1 << state[FEED_BITS]
    state[PACE_REST] = state[FEED_LASTS] - each * steps
    state[PACE_OVER] = steps
    state[PACE_CARRY] = 0
    at = state[FEED_HEAD] & state[FEED_MASK]
    run = steps
    while run:
        part = run
        if at + run > state[FEED_MASK]:
            part = state[FEED_MASK] + 1 - at
        if state[FEED_KIND] == KIND_LINE:
            line_viper.walk(words, at, part, path)
        else:
            geometry.walk(ring, at, part)
        if rows[state[FEED_ROW] + ROW_POWER] > POWER_MOST:
            burn(state, rows, power, path, words, at, part, run)
        pace_viper.pace(words, at, part, state)
        if state[FEED_DEBT] or state[FEED_DRIVE]:
            settle(at, part)
        at = 0
        run -= part
    state[FEED_LEFT] = state[FEED_LEFT] - steps
    if state[FEED_KIND] == KIND_ARC:
        state[FEED_LEFT] = int(geometry.left)


@micropython.viper
def write_words(state: ptr32, ring, settle, geometry) -> int:  # ISR: no allocation
    """As many whole words as the geometry makes. Returns 0 if it stands and makes none, else 1."""
    at = state[FEED_HEAD] & state[FEED_MASK]
    run = state[FEED_MASK] + 1 - at
    if run > MAX_RUN:
        run = MAX_RUN
    steps = int(geometry.walk(ring, at, run, state[FEED_LEVELS], state[FEED_BITS], state[FEED_HOLD]))
    ends = int(geometry.ends())
    if steps == 0 and ends == 0:
        return 0
    state[FEED_STEPS] = steps
    state[FEED_LASTS] = int(geometry.ticks)
    state[FEED_LEVELS] = int(geometry.levels)
    state[FEED_INDEX] = int(geometry.index)
    if ends:
        state[FEED_LEFT] = 0
    if steps and (state[FEED_DEBT] or state[FEED_DRIVE]):
        settle(at, steps)
    return 1


@micropython.viper
def checkpoint(state: ptr32, marks: ptr32, made: ptr32, made_at: int):  # ISR: no allocation
    """Mark the segment's end: words, ticks and position so far. made[made_at:] are the steps of each axis, which are cleared."""
    axes = state[FEED_AXES]
    state[FEED_HEAD] = (state[FEED_HEAD] + state[FEED_STEPS]) & COUNT_MASK
    state[FEED_TICKS] = (state[FEED_TICKS] + state[FEED_LASTS]) & COUNT_MASK
    newest = (state[FEED_NEWEST] + 1) & COUNT_MASK
    mark = (newest & (MARKS - 1)) * (MARK_FIELDS + axes)
    marks[mark + MARK_WORD] = state[FEED_HEAD]
    marks[mark + MARK_TICKS] = state[FEED_TICKS]
    marks[mark + MARK_INDEX] = state[FEED_INDEX]
    marks[mark + MARK_ENDS] = 1 if state[FEED_LEFT] == 0 and state[FEED_WAIT] == 0 else 0
    marks[mark + MARK_PACE] = state[FEED_PACE]
    mark += MARK_FIELDS
    axis = 0
    while axis < axes:
        position = ((state[FEED_POSITION + axis] + made[made_at + axis] + COUNT_HALF) & COUNT_MASK) - COUNT_HALF
        state[FEED_POSITION + axis] = position
        marks[mark + axis] = position
        made[made_at + axis] = 0
        axis += 1
    state[FEED_NEWEST] = newest
