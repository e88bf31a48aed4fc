"""The look-ahead: at which speed each of the queued blocks may be left.

    done = plan_lines(batch, count, rows, work, counts, terms)  # lines: planned and queued, and the look-ahead raised
    corner(rows, at, work, terms)               # behind plan_block(): the speed of the corner before this block
    raised = look_back(rows, work, counts)      # behind row_viper.close()

    speed
      │        limit of b2 ─────────
      │   ____                 ╱    ╲
      │  ╱    ╲ corner        ╱      ╲      look_back() goes from the newest block, which ends at rest, to the oldest: what a
      │ ╱ b1   ╲____ b2 _____╱   b3   ╲     block is left with is at most its corner, and what the next one can brake from
      │╱                               ╲
      └────────────────────────────────────► path

One text for all interpreters, by the rules of block_viper.py. A call from one kernel to the next takes 26 µs on a Pico.
"""
# ruff: noqa: F821

import micropython

from passo.motion.block_viper import plan_block
from passo.motion.row_viper import close
from passo.records import (
    BATCH_FEED, BATCH_FIELDS, BATCH_FIRST, BATCH_FLAGS, BATCH_POWER, BATCH_STEPS, BATCH_TAG, LIMIT_AXES, LIMIT_CORNER,
    LIMIT_CORNER_SHIFT, LIMIT_STRONGEST, LIMIT_STRONGEST_SHIFT, LIMIT_WHOLE, QUEUE_ADDED, QUEUE_FROZEN, ROW_CORNER, ROW_EXIT,
    ROW_FASTEST, ROW_GAIN, ROW_RAPID, ROW_REACH, ROW_SQUARE, ROW_STEPS, WORK_ALL, WORK_ASKED, WORK_BEFORE, WORK_CHANGE,
    WORK_FACTOR, WORK_FEED, WORK_GIVEN, WORK_GIVEN_SHIFT, WORK_HEADING, WORK_IS_ARC, WORK_SIZE, WORK_STRIDE, WORK_THROUGH,
)  # fmt: skip

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows


@micropython.viper
def corner(rows: ptr32, at: int, work: ptr32, terms: ptr32):
    """Set the speed, ROW_CORNER, at which motion may go through from the block before to this one, whose row is planned, by
    junction deviation. Remembers this one's direction for the next corner; a block too slow for a ramp ends at a stand."""
    if rows[at + ROW_GAIN] == 0:
        return
    axes = terms[LIMIT_AXES]
    if work[WORK_THROUGH]:
        shift = 0
        # The sum of the two directions and their difference, in 2⁻²⁸: their lengths are twice the sine of half the angle
        # between the lines, `sine`, and of half the angle turned through, `root`; both with exponents.
        sine = 0
        sine_shift = 0
        root = 0
        square = 0
        sign = 0
        while sign < 2:
            most = 0
            i = 0
            while i < axes:
                along = work[WORK_HEADING + i] - work[WORK_BEFORE + i] if sign else work[WORK_HEADING + i] + work[WORK_BEFORE + i]
                if along >> 30 & 1:
                    along = 0 - along
                along &= 0x3FFFFFFF
                work[WORK_CHANGE + i] = along
                if along > most:
                    most = along
                i += 1
            sine = root
            sine_shift = shift
            root = 0
            shift = 0
            if most:
                while most < 0x2000:
                    most <<= 1
                    shift -= 1
                while most >= 0x4000:
                    most >>= 1
                    shift += 1
                square = 0
                i = 0
                while i < axes:
                    along = work[WORK_CHANGE + i]
                    if shift < 0:
                        along <<= 0 - shift
                    else:
                        along >>= shift
                    work[WORK_CHANGE + i] = along
                    square += along * along
                    i += 1
                bit = 0x4000
                while bit:
                    if (root + bit) * (root + bit) <= square:
                        root += bit
                    bit >>= 1
            sign += 1
        high = 0x3FFFFFFF
        if shift > 5 or shift > 3 and root << shift >= 379600:
            # More than 1.4 mrad: a corner. What the axes can do along the change of direction:
            strong = 0x20000000
            i = 0
            while i < axes:
                along = work[WORK_CHANGE + i]
                if along:
                    bit = (along << 15) // root + 1
                    rest = terms[LIMIT_STRONGEST + i] // bit
                    high = terms[LIMIT_STRONGEST_SHIFT + i] - 1000
                    if high < 0:
                        rest >>= 0 - high
                    elif rest < 0x20000000 >> high:
                        rest <<= high
                    else:
                        rest = 0x20000000
                    if rest < strong:
                        strong = rest
                i += 1
            if strong < 1:
                strong = 1
            strong_shift = 0
            while strong < 0x4000:
                strong <<= 1
                strong_shift -= 1
            while strong >= 0x8000:
                strong >>= 1
                strong_shift += 1
            # v² = a · δ · s · (1 + s) / t²
            high = strong * sine >> 15
            low = 0x4000
            if sine_shift > 0:
                low += sine << sine_shift >> 15
            high = high * low >> 15
            high = high * terms[LIMIT_CORNER] >> 15
            high = (high << 15) // ((root * root >> 13) + 1)
            shift = strong_shift + terms[LIMIT_CORNER_SHIFT] - 968 + sine_shift - 2 * shift
            while shift < 0 and high:
                high >>= 1
                shift += 1
            while shift > 0 and high < 0x10000000:
                high <<= 1
                shift -= 1
            if shift > 0 or high > 0x1FFFFFFF:
                high = 0x1FFFFFFF
        rows[at + ROW_CORNER] = high
    work[WORK_THROUGH] = 1
    i = 0
    while i < axes:
        work[WORK_BEFORE + i] = work[WORK_HEADING + i]
        i += 1


@micropython.viper
def look_back(rows: ptr32, work: ptr32, counts: ptr32) -> int:
    """Raise the exits of blocks, from the newest back, as far as one changes; how many blocks back that was."""
    count = (counts[QUEUE_ADDED] - counts[QUEUE_FROZEN]) & 0x1FFFFFFF
    if count > 64:
        count = 64
    deepest = count + 2
    stride = work[WORK_STRIDE]
    behind = (counts[QUEUE_ADDED] - 1) % work[WORK_SIZE] * stride
    ends = work[WORK_SIZE] * stride
    depth = 0
    while count > 1:
        at = behind - stride
        if at < 0:
            at = ends - stride
        square = 0
        if rows[behind + ROW_GAIN] and rows[at + ROW_GAIN]:
            factor = work[WORK_FACTOR + rows[behind + ROW_RAPID]]
            square = rows[behind + ROW_SQUARE]
            square = ((square >> 14) * factor << 2) + ((square & 0x3FFF) * factor >> 12)
            if rows[behind + ROW_FASTEST] < square:
                square = rows[behind + ROW_FASTEST]
            factor = work[WORK_FACTOR + rows[at + ROW_RAPID]]
            most = rows[at + ROW_SQUARE]
            most = ((most >> 14) * factor << 2) + ((most & 0x3FFF) * factor >> 12)
            if rows[at + ROW_FASTEST] < most:
                most = rows[at + ROW_FASTEST]
            if most < square:
                square = most
            most = rows[behind + ROW_EXIT] + rows[behind + ROW_REACH]
            if most < square:
                square = most
            if rows[behind + ROW_CORNER] < square:
                square = rows[behind + ROW_CORNER]
        if square > rows[at + ROW_EXIT]:
            rows[at + ROW_EXIT] = square
            depth = deepest - count
        elif work[WORK_ALL] == 0:
            return depth
        behind = at
        count -= 1
    return depth


@micropython.viper
def plan_lines(batch: ptr32, count: int, rows: ptr32, work: ptr32, counts: ptr32, terms: ptr32) -> int:
    """Queue the lines in the first `count` rows of `batch`, for which there is room; one of no steps is no block. Returns how
    many were taken: fewer if the next one's feed is for Planner._ask() to work out; -1 or -2 if plan_block() refuses the next."""
    axes = work[WORK_STRIDE] - ROW_STEPS
    done = 0
    line = 0
    while done < count:
        at = counts[QUEUE_ADDED] % work[WORK_SIZE] * work[WORK_STRIDE]
        feed = batch[line + BATCH_FEED]
        if feed != work[WORK_ASKED]:
            fastest = terms[LIMIT_WHOLE]
            if feed and fastest == 0:
                return done
            work[WORK_ASKED] = feed
            work[WORK_GIVEN] = 0
            work[WORK_GIVEN_SHIFT] = 0
            speed = 0
            if feed:  # feed · 2²⁸ / fastest
                speed = feed // fastest
                rest = feed - speed * fastest
                bit = 0
                while bit < 28 and speed < 0x10000000:
                    rest <<= 1
                    speed <<= 1
                    if rest >= fastest:
                        rest -= fastest
                        speed += 1
                    bit += 1
                if bit < 28:
                    speed = 0x1FFFFFFF
                if speed == 0:
                    speed = 1
            work[WORK_FEED] = speed
        work[WORK_IS_ARC] = 0
        axis = 0
        while axis < axes:
            rows[at + ROW_STEPS + axis] = batch[line + BATCH_STEPS + axis]
            axis += 1
        planned = int(plan_block(rows, at, work, terms))
        if planned >> 30 & 1:
            return planned
        if planned:
            corner(rows, at, work, terms)
            through = int(
                close(
                    rows, at, work, counts, 0, batch[line + BATCH_FLAGS], batch[line + BATCH_TAG], batch[line + BATCH_POWER],
                    batch[line + BATCH_FIRST],
                )
            )
            if through:
                look_back(rows, work, counts)
        line += BATCH_FIELDS
        done += 1
    return done
