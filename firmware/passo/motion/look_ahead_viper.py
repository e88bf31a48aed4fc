"""The look-ahead: at which speed each of the queued blocks may be left.

    done = plan_lines(batch, count, rows, scratch, indices, limits)  # lines: planned and queued, and the look-ahead raised
    corner(rows, at, work, limits)               # behind plan_block(): the speed of the corner before this block
    raised = look_back(rows, scratch, indices)      # behind row_viper.close()

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
    ROW_FASTEST, ROW_GAIN, ROW_RAPID, ROW_REACH, ROW_SQUARE, ROW_STEPS, SCRATCH_ALL, SCRATCH_ASKED, SCRATCH_BEFORE, SCRATCH_CHANGE,
    SCRATCH_FACTOR, SCRATCH_FEED, SCRATCH_GIVEN, SCRATCH_GIVEN_SHIFT, SCRATCH_HEADING, SCRATCH_IS_ARC, SCRATCH_SIZE, SCRATCH_STRIDE, SCRATCH_THROUGH,
)  # fmt: skip

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows


@micropython.viper
def corner(rows: ptr32, at: int, scratch: ptr32, limits: ptr32):
    """Set the speed, ROW_CORNER, at which motion may go through from the block before to this one, whose row is planned, by
    junction deviation. Remembers this one's direction for the next corner; a block too slow for a ramp ends at a stand."""
    if rows[at + ROW_GAIN] == 0:
        return
    axes = limits[LIMIT_AXES]
    if scratch[SCRATCH_THROUGH]:
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
                along = scratch[SCRATCH_HEADING + i] - scratch[SCRATCH_BEFORE + i] if sign else scratch[SCRATCH_HEADING + i] + scratch[SCRATCH_BEFORE + i]
                if along >> 30 & 1:
                    along = 0 - along
                along &= 0x3FFFFFFF
                scratch[SCRATCH_CHANGE + i] = along
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
                    along = scratch[SCRATCH_CHANGE + i]
                    if shift < 0:
                        along <<= 0 - shift
                    else:
                        along >>= shift
                    scratch[SCRATCH_CHANGE + i] = along
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
                along = scratch[SCRATCH_CHANGE + i]
                if along:
                    bit = (along << 15) // root + 1
                    rest = limits[LIMIT_STRONGEST + i] // bit
                    high = limits[LIMIT_STRONGEST_SHIFT + i] - 1000
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
            high = high * limits[LIMIT_CORNER] >> 15
            high = (high << 15) // ((root * root >> 13) + 1)
            shift = strong_shift + limits[LIMIT_CORNER_SHIFT] - 968 + sine_shift - 2 * shift
            while shift < 0 and high:
                high >>= 1
                shift += 1
            while shift > 0 and high < 0x10000000:
                high <<= 1
                shift -= 1
            if shift > 0 or high > 0x1FFFFFFF:
                high = 0x1FFFFFFF
        rows[at + ROW_CORNER] = high
    scratch[SCRATCH_THROUGH] = 1
    i = 0
    while i < axes:
        scratch[SCRATCH_BEFORE + i] = scratch[SCRATCH_HEADING + i]
        i += 1


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
        square = 0
        if rows[behind + ROW_GAIN] and rows[at + ROW_GAIN]:
            factor = scratch[SCRATCH_FACTOR + rows[behind + ROW_RAPID]]
            square = rows[behind + ROW_SQUARE]
            square = ((square >> 14) * factor << 2) + ((square & 0x3FFF) * factor >> 12)
            if rows[behind + ROW_FASTEST] < square:
                square = rows[behind + ROW_FASTEST]
            factor = scratch[SCRATCH_FACTOR + rows[at + ROW_RAPID]]
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
        elif scratch[SCRATCH_ALL] == 0:
            return depth
        behind = at
        count -= 1
    return depth


@micropython.viper
def plan_lines(batch: ptr32, count: int, rows: ptr32, scratch: ptr32, indices: ptr32, limits: ptr32) -> int:
    """Queue the lines in the first `count` rows of `batch`, for which there is room; one of no steps is no block. Returns how
    many were taken: fewer if the next one's feed is for Planner._ask() to work out; -1 or -2 if plan_block() refuses the next."""
    axes = scratch[SCRATCH_STRIDE] - ROW_STEPS
    done = 0
    line = 0
    while done < count:
        at = indices[QUEUE_ADDED] % scratch[SCRATCH_SIZE] * scratch[SCRATCH_STRIDE]
        feed = batch[line + BATCH_FEED]
        if feed != scratch[SCRATCH_ASKED]:
            fastest = limits[LIMIT_WHOLE]
            if feed and fastest == 0:
                return done
            scratch[SCRATCH_ASKED] = feed
            scratch[SCRATCH_GIVEN] = 0
            scratch[SCRATCH_GIVEN_SHIFT] = 0
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
            scratch[SCRATCH_FEED] = speed
        scratch[SCRATCH_IS_ARC] = 0
        axis = 0
        while axis < axes:
            rows[at + ROW_STEPS + axis] = batch[line + BATCH_STEPS + axis]
            axis += 1
        planned = int(plan_block(rows, at, scratch, limits))
        if planned >> 30 & 1:
            return planned
        if planned:
            corner(rows, at, scratch, limits)
            through = int(
                close(
                    rows, at, scratch, indices, 0, batch[line + BATCH_FLAGS], batch[line + BATCH_TAG], batch[line + BATCH_POWER],
                    batch[line + BATCH_FIRST],
                )
            )
            if through:
                look_back(rows, scratch, indices)
        line += BATCH_FIELDS
        done += 1
    return done
