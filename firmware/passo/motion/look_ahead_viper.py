"""The look-ahead: at which speed each of the queued blocks may be left.

    done = plan_lines(batch, 0, count, rows, scratch, indices, limits)  # lines: planned and queued, and the look-ahead raised
    corner(rows, at, work, limits)               # behind plan_block(): the speed of the corner before this block
    raised = look_back(rows, scratch, indices)      # behind row_viper.close()

    speed
      │        limit of b2 ─────────
      │   ____                 ╱    ╲
      │  ╱    ╲ corner        ╱      ╲      look_back() goes from the newest block, which ends at rest, to the oldest: what a
      │ ╱ b1   ╲____ b2 _____╱   b3   ╲     block is left with is at most its corner, and what the next one can brake from
      │╱                               ╲
      └────────────────────────────────────► path

One text for all interpreters, by the rules of block_viper.py.
"""
# Shared with interrupts: indices

import micropython

from passo.motion.block_viper import plan_block
from passo.motion.row_viper import close
from passo.motion.scale_viper import drop, lift, root, scale, scale_clamped, size
from passo.motion.vector_viper import limit_along
from passo.records import *


@micropython.viper
def corner(rows: ptr32, at: int, scratch: ptr32, limits: ptr32):
    """Set the speed, ROW_CORNER, at which motion may go through from the block before to this one, whose row is planned, by
    junction deviation. Remembers this one's direction for the next corner; a block too slow for a ramp ends at a stand."""
    if rows[at + ROW_GAIN] == 0:
        return
    axes = limits[LIMIT_AXES]
    if scratch[SCRATCH_THROUGH]:
        set_chord(scratch, SHORT_SINE, axes, 0)
        set_chord(scratch, SHORT_TURN, axes, 1)
        rows[at + ROW_CORNER] = int(corner_square(scratch, limits))
    scratch[SCRATCH_THROUGH] = 1
    i = 0
    while i < axes:
        scratch[SCRATCH_BEFORE + i] = scratch[SCRATCH_HEADING + i]
        i += 1


@micropython.viper
def set_chord(scratch: ptr32, at: int, axes: int, minus: int):
    """Write the length of the sum of the two directions at a corner (`minus` 1: of their difference) to scratch[at], of 14 bits
    with its exponent behind it, and the vector itself in that unit to SCRATCH_CHANGE. The sum is twice the sine of half the
    angle between the lines, the difference twice the sine of half the angle turned through."""
    most = 0
    i = 0
    while i < axes:
        before = scratch[SCRATCH_BEFORE + i]
        along = int(size(scratch[SCRATCH_HEADING + i] - before if minus else scratch[SCRATCH_HEADING + i] + before))
        scratch[SCRATCH_CHANGE + i] = along
        if along > most:
            most = along
        i += 1
    shift = 0
    square = 0
    if most:
        shift = int(lift(most, 0x2000)) - int(drop(most, 0x4000))
        i = 0
        while i < axes:
            along = int(scale(scratch[SCRATCH_CHANGE + i], shift))
            scratch[SCRATCH_CHANGE + i] = along
            square += along * along
            i += 1
    scratch[at] = int(root(square))
    scratch[at + SHORT_EXPONENT] = 1000 - shift


@micropython.viper
def corner_square(scratch: ptr32, limits: ptr32) -> int:
    """Return the square of the speed, of 2²⁸, at which a corner may be passed: v² = a · δ · s · (1 + s) / t², where δ is the junction
    deviation, s and t are the sines of half the angle between the lines and of half the angle turned through, and a is what the
    axes can do along the change of direction. 2³⁰ − 1 if it turns by less than 1.4 mrad."""
    turn = scratch[SHORT_TURN]
    turn_shift = scratch[SHORT_TURN + SHORT_EXPONENT] - 1000
    if turn_shift < 4 or turn_shift < 6 and turn << turn_shift < 379600:
        return 0x3FFFFFFF
    strong = int(strength_across(scratch, limits, turn))
    more = int(lift(strong, 0x4000)) - int(drop(strong, 0x8000))
    sine = scratch[SHORT_SINE]
    sine_shift = scratch[SHORT_SINE + SHORT_EXPONENT] - 1000
    whole = 0x4000
    if sine_shift > 0:
        whole += sine << sine_shift >> 15
    square = int(scale(strong, more)) * sine >> 15
    square = square * whole >> 15
    square = square * limits[LIMIT_CORNER] >> 15
    square = (square << 15) // ((turn * turn >> 13) + 1)
    return int(scale_clamped(square, limits[LIMIT_CORNER_SHIFT] - 968 - more + sine_shift - 2 * turn_shift))


@micropython.viper
def strength_across(scratch: ptr32, limits: ptr32, length: int) -> int:
    """Return the acceleration, of 2²⁸ and 1 at least, that the axes allow along SCRATCH_CHANGE, a vector of this `length`."""
    strong = 0x20000000
    i = 0
    while i < limits[LIMIT_AXES]:
        along = scratch[SCRATCH_CHANGE + i]
        if along:
            most = int(limit_along(limits[LIMIT_STRONGEST + i], (along << 15) // length + 1, limits[LIMIT_STRONGEST_SHIFT + i] - 1000))
            if most < strong:
                strong = most
        i += 1
    return strong if strong > 1 else 1


@micropython.viper
def look_back(rows: ptr32, scratch: ptr32, indices: ptr32) -> int:
    """Raise the exits of blocks, from the newest back, as far as one changes; how many blocks back that was."""
    count = (indices[QUEUE_ADDED] - indices[QUEUE_FROZEN]) & 0x1FFFFFFF
    if count > 64:
        count = 64
    deepest = count + 2
    stride = scratch[SCRATCH_STRIDE]
    behind = (indices[QUEUE_ADDED] - 1) % scratch[SCRATCH_SIZE] * stride
    ends = scratch[SCRATCH_SIZE] * stride
    depth = 0
    while count > 1:
        at = behind - stride
        if at < 0:
            at = ends - stride
        square = int(exit_square(rows, at, behind, scratch))
        if square > rows[at + ROW_EXIT]:
            rows[at + ROW_EXIT] = square
            depth = deepest - count
        elif scratch[SCRATCH_ALL] == 0:
            return depth
        behind = at
        count -= 1
    return depth


@micropython.viper
def exit_square(rows: ptr32, at: int, behind: int, scratch: ptr32) -> int:
    """Return the square of the speed at which the block at rows[at] may be left for the one `behind` it: the least of the speeds of both, the
    corner's limit, and the speed from which the one behind can brake. 0 if one of them has no ramp.
    """
    if rows[behind + ROW_GAIN] == 0 or rows[at + ROW_GAIN] == 0:
        return 0
    square = int(square_with(rows, behind, scratch))
    most = int(square_with(rows, at, scratch))
    if most < square:
        square = most
    most = rows[behind + ROW_EXIT] + rows[behind + ROW_REACH]
    if most < square:
        square = most
    if rows[behind + ROW_CORNER] < square:
        square = rows[behind + ROW_CORNER]
    return square


@micropython.viper
def square_with(rows: ptr32, at: int, scratch: ptr32) -> int:
    """Return the square of a block's speed with its override, at most that of the axes' limits."""
    factor = scratch[SCRATCH_FACTOR + rows[at + ROW_RAPID]]
    square = rows[at + ROW_SQUARE]
    square = ((square >> 14) * factor << 2) + ((square & 0x3FFF) * factor >> 12)
    if rows[at + ROW_FASTEST] < square:
        return rows[at + ROW_FASTEST]
    return square


@micropython.viper
def plan_lines(batch: ptr32, done: int, count: int, rows: ptr32, scratch: ptr32, indices: ptr32, limits: ptr32) -> int:
    """Queue the lines in rows `done` … count − 1 of `batch`, for which there is room; one of no steps is no block. Returns the
    first row not taken: one whose feed is for Planner._ask() to work out; -1 or -2 if plan_block() refuses it."""
    axes = scratch[SCRATCH_STRIDE] - ROW_STEPS
    line = done * BATCH_FIELDS
    while done < count:
        at = indices[QUEUE_ADDED] % scratch[SCRATCH_SIZE] * scratch[SCRATCH_STRIDE]
        if int(ask(scratch, limits, batch[line + BATCH_FEED])) == 0:
            return done
        axis = 0
        while axis < axes:
            rows[at + ROW_STEPS + axis] = batch[line + BATCH_STEPS + axis]
            axis += 1
        planned = int(plan_block(rows, at, scratch, limits))
        if planned >> 30 & 1:
            return planned
        if planned:
            corner(rows, at, scratch, limits)
            flags = batch[line + BATCH_FLAGS]
            tag = batch[line + BATCH_TAG]
            if int(close(rows, at, scratch, indices, KIND_LINE, flags, tag, batch[line + BATCH_POWER], batch[line + BATCH_FIRST])):
                look_back(rows, scratch, indices)
        line += BATCH_FIELDS
        done += 1
    return done


@micropython.viper
def ask(scratch: ptr32, limits: ptr32, feed: int) -> int:
    """Ask for a line at `feed`, in nm/s; 0: as fast as may be. Returns 0 if that is for Planner._ask(), else 1."""
    if feed != scratch[SCRATCH_ASKED]:
        fastest = limits[LIMIT_WHOLE]
        if feed and fastest == 0:
            return 0
        scratch[SCRATCH_ASKED] = feed
        scratch[SCRATCH_GIVEN] = 0
        scratch[SCRATCH_GIVEN_SHIFT] = 0
        scratch[SCRATCH_FEED] = int(part_of(feed, fastest)) if feed else 0
    scratch[SCRATCH_IS_ARC] = 0
    return 1


@micropython.viper
def part_of(feed: int, fastest: int) -> int:
    """feed · 2²⁸ / fastest, 1 … 2²⁹ − 1, bit by bit."""
    part = feed // fastest
    rest = feed - part * fastest
    bit = 0
    while bit < 28 and part < 0x10000000:
        rest <<= 1
        part <<= 1
        if rest >= fastest:
            rest -= fastest
            part += 1
        bit += 1
    if bit < 28:
        return 0x1FFFFFFF
    return part if part else 1
