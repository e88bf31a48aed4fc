"""What acceleration makes of a block: the arithmetic that every block costs.

    planned = plan_block(rows, at, scratch, limits)  # the row that begins at rows[at]; a line's steps are in it

One text for all interpreters: a board compiles it to machine code, elsewhere it is ordinary Python. So it keeps to 32-bit
integers, none of which reaches 2³¹, and gives the same bits everywhere. `rows` are block.py's, `limits` limits.Limits',
`scratch` the planner's; records.py names their fields. Where viper is 64 bits wide it reads a negative number as a positive one:
bit 30 tells. Exponents are kept 1000 too large instead.

Numbers come in three kinds:

- fractions of 2²⁸: directions; speeds, of the fastest that the machine can be; accelerations, likewise; and squares of
  speeds, which below a 2000th of the fastest are as good as 0
- long floats, of 27 or 28 bits and an exponent: lengths, and what ticks come from. Two steps of long division give a
  quotient of such numbers to 10⁻⁷
- short floats, m · 2ᵉ with m of 15 bits: everything that only decides how fast a speed may change. Where a value must
  not be exceeded it is rounded so at every step, which costs 10⁻³ at most.

The loops that bring numbers to their length are written out where they are needed, and so the function is long: as a
function each would cost every block 26 µs a call, and there are some thirty of them.
"""
# ruff: noqa: F821

import micropython

from passo.records import (
    LIMIT_AXES, LIMIT_FASTEST, LIMIT_FIELDS, LIMIT_FINEST, LIMIT_GAIN, LIMIT_GAIN_SHIFT, LIMIT_SHIFTS, LIMIT_SPEED,
    LIMIT_SPEED_SHIFT, LIMIT_STEP, LIMIT_STRONGEST, LIMIT_TIME, LIMIT_TIME_SHIFT, ROW_CORNER, ROW_EXIT, ROW_FASTEST, ROW_GAIN,
    ROW_LIMIT, ROW_RATIO, ROW_RATIO_SHIFT, ROW_REACH, ROW_SPAN, ROW_SPEED, ROW_SQUARE, ROW_STEPS, ROW_TICKS, ROW_TICKS_REST,
    ROW_TIME, ROW_TIME_SHIFT, ROW_TOP, ROW_UNIT, ROW_UNIT_SHIFT, SCRATCH_ALONG, SCRATCH_FEED, SCRATCH_FULL, SCRATCH_FULL_SHIFT,
    SCRATCH_GIVEN, SCRATCH_GIVEN_SHIFT, SCRATCH_HEADING, SCRATCH_IS_ARC, SCRATCH_LENGTH, SCRATCH_LENGTH_SHIFT, SCRATCH_LIMITED, SCRATCH_SPEED,
    SCRATCH_STEPS, SCRATCH_STEPS_SHIFT, SCRATCH_STRENGTH, SCRATCH_THROUGH, SCRATCH_TOP, SCRATCH_TOP_SHIFT,
)  # fmt: skip

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows


@micropython.viper
def plan_block(rows: ptr32, at: int, scratch: ptr32, limits: ptr32) -> int:
    """Fill in the row of a line or arc, all but the corner. Returns 1; 0 if it has no steps, -1 if they are more than 43 s apart,
    -2 if there are too many."""
    axes = limits[LIMIT_AXES]
    if scratch[SCRATCH_IS_ARC] == 0:
        # --- a line's dominant steps, length and direction, and what the axes allow along it
        total = 0
        i = 0
        while i < axes:
            steps = rows[at + ROW_STEPS + i]
            if steps >> 30 & 1:
                steps = 0 - steps
            steps &= 0x3FFFFFFF
            if steps > total:
                total = steps
            i += 1
        if total == 0:
            return 0
        if total > 2097151:
            return -2
        shift = 0
        high = total
        while high < 4096:
            high <<= 1
            shift += 1
        while high >= 8192:
            high >>= 1
            shift -= 1
        most = 0
        i = 0
        while i < axes:
            steps = rows[at + ROW_STEPS + i]
            if steps >> 30 & 1:
                steps = 0 - steps
            steps &= 0x3FFFFFFF
            high = limits[LIMIT_STEP + i] >> 14
            if shift >= 0:
                steps <<= shift
                along = steps * high + (steps * (limits[LIMIT_STEP + i] & 0x3FFF) >> 14)
            else:
                along = (steps & ((1 << (0 - shift)) - 1)) * high >> (0 - shift)
                steps >>= 0 - shift
                along += steps * high + (steps * (limits[LIMIT_STEP + i] & 0x3FFF) >> 14)
            scratch[SCRATCH_HEADING + i] = along
            if along > most:
                most = along
            i += 1
        while most < 0x4000000:
            most <<= 1
            shift += 1
            i = 0
            while i < axes:
                scratch[SCRATCH_HEADING + i] = scratch[SCRATCH_HEADING + i] << 1
                i += 1
        # The root of the squares' sum, in digits of 14 bits: a² = aₕ²·2²⁸ + 2aₕaₗ·2¹⁴ + aₗ².
        square = 0
        middle = 0
        low = 0
        i = 0
        while i < axes:
            high = scratch[SCRATCH_HEADING + i] >> 14
            rest = scratch[SCRATCH_HEADING + i] & 0x3FFF
            square += high * high
            middle += high * rest
            low += rest * rest >> 14
            i += 1
        square += middle >> 13
        low += (middle & 0x1FFF) << 1
        root = 0
        bit = 0x4000
        while bit:
            if (root + bit) * (root + bit) <= square:
                root += bit
            bit >>= 1
        length = (root << 14) + (((square - root * root) << 14) + low) // (2 * root)
        length_shift = limits[LIMIT_FINEST] - 1000 + shift  # nanometres are length / 2 ** length_shift
        # Directions, and what the axes allow along them.
        fastest = 0x20000000
        strength = 0x20000000
        high = length >> 14
        low = length & 0x3FFF
        i = 0
        while i < axes:
            along = scratch[SCRATCH_HEADING + i]
            if along:
                bit = along // high
                rest = ((along % high) << 14) - bit * low
                along = (bit << 14) + rest // high
                bit = along
                more = 0
                while bit < 0x8000000 and more < 13:
                    bit <<= 1
                    more += 1
                bit = (bit >> 13) + 1
                limit = LIMIT_FASTEST + i
                while limit < LIMIT_FIELDS:
                    rest = limits[limit] // bit
                    shift = limits[limit + LIMIT_SHIFTS] - 1000 + more
                    if shift < 0:
                        rest >>= 0 - shift
                    elif rest < 0x20000000 >> shift:
                        rest <<= shift
                    else:
                        rest = 0x20000000
                    if limit >= LIMIT_STRONGEST:
                        if rest < strength:
                            strength = rest
                    elif rest < fastest:
                        fastest = rest
                    limit += LIMIT_STRONGEST - LIMIT_FASTEST
                if rows[at + ROW_STEPS + i] >> 30 & 1:
                    along = 0 - along
            scratch[SCRATCH_HEADING + i] = along
            i += 1
        scratch[SCRATCH_STEPS] = total
        scratch[SCRATCH_LENGTH] = length
        scratch[SCRATCH_LENGTH_SHIFT] = length_shift + 1000
        scratch[SCRATCH_ALONG] = fastest
        scratch[SCRATCH_STRENGTH] = strength
    # --- speed and time, and the ramp's units
    total = scratch[SCRATCH_STEPS]
    length = scratch[SCRATCH_LENGTH]
    length_shift = scratch[SCRATCH_LENGTH_SHIFT] - 1000
    fastest = scratch[SCRATCH_ALONG]
    strength = scratch[SCRATCH_STRENGTH]
    if fastest < 1:
        fastest = 1
    if strength < 1:
        strength = 1
    speed = scratch[SCRATCH_FEED]
    if speed == 0:
        speed = fastest
    limited = 0
    if speed > fastest:
        speed = fastest
        limited = 1
    scratch[SCRATCH_LIMITED] = limited
    scratch[SCRATCH_SPEED] = speed
    full = speed
    full_shift = 0
    while full < 0x8000000:
        full <<= 1
        full_shift += 1
    # --- how long it lasts at that speed: `each` ticks a step, `rest` more over all
    if scratch[SCRATCH_IS_ARC] == 0:
        if scratch[SCRATCH_GIVEN] and not limited:
            ticks = scratch[SCRATCH_GIVEN]
            shift = scratch[SCRATCH_GIVEN_SHIFT]
        else:
            high = full >> 14
            bit = length // high
            rest = ((length % high) << 14) - bit * (full & 0x3FFF)
            length_by = (bit << 14) + rest // high
            high = length_by >> 15
            low = length_by & 0x7FFF
            bit = limits[LIMIT_SPEED] >> 14
            ticks = (high * bit << 1) + (high * (limits[LIMIT_SPEED] & 0x3FFF) >> 13) + (low * bit >> 14)
            shift = limits[LIMIT_SPEED_SHIFT] - 1000 + full_shift - length_shift
        while shift < 0 and ticks > 0:
            ticks >>= 1
            shift += 1
        if ticks == 0:
            ticks = 1
            shift = 0
        each = ticks // total
        rest = ticks % total
        while shift > 0:
            if each >= 0x10000000:
                return -1
            each <<= 1
            rest <<= 1
            if rest >= total:
                rest -= total
                each += 1
            shift -= 1
        if each > 0x1FFFFFFF:
            return -1
        rows[at + ROW_TICKS] = each if each > 0 else 1
        rows[at + ROW_TICKS_REST] = rest
        steps = total
        while steps >= 0x8000:
            steps >>= 1
            rest >>= 1
        top = 16000
        if each >= 33553:
            top = 0x1FFFFFFF // (each + 1)
        rows[at + ROW_SPAN] = 2 * top * each + 2 * top * rest // steps
        steps_shift = 0
        steps = total
    else:
        steps = total
        steps_shift = scratch[SCRATCH_STEPS_SHIFT] - 1000
        top = scratch[SCRATCH_GIVEN]
    high = speed >> 14
    rows[at + ROW_SPEED] = speed
    rows[at + ROW_SQUARE] = high * high + (high * (speed & 0x3FFF) >> 13)
    high = fastest >> 14
    rows[at + ROW_FASTEST] = high * high + (high * (fastest & 0x3FFF) >> 13)
    rows[at + ROW_CORNER] = 0
    rows[at + ROW_REACH] = 0
    rows[at + ROW_EXIT] = 0
    rows[at + ROW_TOP] = top
    if top < 64:
        rows[at + ROW_GAIN] = 0
        scratch[SCRATCH_THROUGH] = 0
        return 1
    # --- the ramp's units, in short floats
    while steps < 0x4000:
        steps <<= 1
        steps_shift -= 1
    while steps >= 0x8000:
        steps >>= 1
        steps_shift += 1
    full >>= 13
    full_shift = 13 - full_shift
    topped = top
    top_shift = 0
    while topped < 0x4000:
        topped <<= 1
        top_shift -= 1
    while length >= 0x8000:
        length >>= 1
        length_shift -= 1
    strong = strength
    strong_shift = 0
    while strong < 0x4000:
        strong <<= 1
        strong_shift -= 1
    while strong >= 0x8000:
        strong >>= 1
        strong_shift += 1
    # limit: top · fastest / speed
    most = 2 * top
    if most > 32000:
        most = 32000
    if fastest >> 1 < speed:
        high = fastest
        low = speed
        while high >= 0x8000:
            high >>= 1
            low >>= 1
        high = top * high // (low + 1)
        if high < top:
            high = top
        if high < most:
            most = high
    rows[at + ROW_LIMIT] = most
    speeds = full * full >> 15  # of speed², exponent 2·full_shift + 15
    tops = topped * topped >> 15
    # gain: q a step
    high = strong * length >> 15
    high = high * limits[LIMIT_GAIN] >> 15
    low = (speeds * steps >> 15) + 1
    high = (high << 15) // low
    shift = strong_shift - length_shift + limits[LIMIT_GAIN_SHIFT] - 1000 - 2 * full_shift - steps_shift - 15
    while high >= 0x8000:
        high >>= 1
        shift += 1
    high = high * tops
    shift += 2 * top_shift + 15
    while shift < 0 and high:
        high >>= 1
        shift += 1
    while shift > 0 and high < 0x10000000:
        high <<= 1
        shift -= 1
    if shift > 0 or high > 0x1FFFFFFF:
        high = 0x1FFFFFFF
    if high < 2:
        high = 2
    rows[at + ROW_GAIN] = high
    # reach: what the block can gain or lose, gain · steps · speed² / top²
    shift = 0
    while high < 0x4000:
        high <<= 1
        shift -= 1
    while high >= 0x8000:
        high >>= 1
        shift += 1
    high = high * steps >> 15
    high = high * speeds >> 15
    high = (high << 15) // (tops + 1)
    shift += steps_shift + 2 * full_shift - 2 * top_shift - 28 + 15
    while shift < 0 and high:
        high >>= 1
        shift += 1
    while shift > 0 and high < 0x10000000:
        high <<= 1
        shift -= 1
    if shift > 0 or high > 0x1FFFFFFF:
        high = 0x1FFFFFFF
    rows[at + ROW_REACH] = high
    # unit: q of a square, top² / speed²
    high = (tops << 15) // (speeds + 1)
    shift = 15 + 2 * full_shift - 2 * top_shift - 28
    while high >= 0x8000:
        high >>= 1
        shift -= 1
    rows[at + ROW_UNIT] = high
    rows[at + ROW_UNIT_SHIFT] = shift
    # time: ticks a unit of speed takes
    high = full * limits[LIMIT_TIME] >> 15
    low = topped * strong >> 15
    high = (high << 15) // (low + 1)
    shift = top_shift + strong_shift - full_shift - limits[LIMIT_TIME_SHIFT] + 1015
    while high < 0x4000:
        high <<= 1
        shift += 1
    while high >= 0x8000:
        high >>= 1
        shift -= 1
    rows[at + ROW_TIME] = high
    rows[at + ROW_TIME_SHIFT] = shift
    rows[at + ROW_RATIO] = 0
    rows[at + ROW_RATIO_SHIFT] = 0
    if scratch[SCRATCH_THROUGH]:
        # --- there is a block before, that goes through to this one: the ratio of the units
        high = scratch[SCRATCH_FULL] * topped >> 15
        low = scratch[SCRATCH_TOP] * full >> 15
        high = (high << 15) // low  # exactly 1 if nothing changes
        shift = scratch[SCRATCH_TOP_SHIFT] + full_shift - scratch[SCRATCH_FULL_SHIFT] - top_shift + 15
        while high < 0x2000:
            high <<= 1
            shift += 1
        while high >= 0x4000:
            high >>= 1
            shift -= 1
        rows[at + ROW_RATIO] = high
        rows[at + ROW_RATIO_SHIFT] = shift
    scratch[SCRATCH_FULL] = full
    scratch[SCRATCH_FULL_SHIFT] = full_shift + 1000
    scratch[SCRATCH_TOP] = topped
    scratch[SCRATCH_TOP_SHIFT] = top_shift + 1000
    return 1
