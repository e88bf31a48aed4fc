"""The effect of acceleration on a block: the arithmetic that every block costs.

    planned = plan_block(rows, at, scratch, limits)  # the row that begins at rows[at]; a line's steps are in it

One text for all interpreters: a board compiles it to machine code, elsewhere it is ordinary Python. So it keeps to 32-bit integers, none of
which reaches 2³¹, and gives the same bits everywhere. `rows` and `scratch` are the planner's, `limits` limits.Limits'; records.py names
their fields. If viper is 64 bits wide it reads a negative number as a positive one: bit 30 tells. Exponents are kept 1000 too large
instead.

Numbers come in three kinds:

- fractions of 2²⁸: directions; speeds, of the fastest that the machine can be; accelerations, likewise; and squares of
  speeds, which below a 2000th of the fastest are as good as 0
- long floats, of 27 or 28 bits and an exponent: lengths, and the numbers that give ticks. Two steps of long division give a
  quotient of such numbers to 10⁻⁷
- short floats, m · 2ᵉ with m of 15 bits: everything that only decides how fast a speed may change. If a value must not be exceeded, each step rounds it down,
  which costs 10⁻³ at most.

The ramp's units (see ramp.py): a block's speed is counted in ROW_TOP parts of the programmed speed v, and q is the square of
that count. Below, s are its steps, l its length, a the acceleration that the axes allow along it, T its ROW_TOP.
"""

import micropython

from passo.motion.scale_viper import drop, lift, quotient, scale, scale_clamped
from passo.motion.vector_viper import measure, most_steps
from passo.records import *


@micropython.viper
def plan_block(rows: ptr32, at: int, scratch: ptr32, limits: ptr32) -> int:
    """Fill in the row of a line or arc, all but the corner. Returns 1; 0 if it has no steps, -1 if they are more than 43 s apart,
    -2 if there are too many."""
    top = scratch[SCRATCH_ARC_TOP]
    if scratch[SCRATCH_IS_ARC]:
        choose_speed(scratch)
    else:
        total = int(most_steps(rows, at + ROW_STEPS, limits[LIMIT_AXES]))
        if total == 0:
            return 0
        if total > 2097151:
            return -2
        scratch[SCRATCH_STEPS] = total
        measure(rows, at + ROW_STEPS, scratch, limits)
        choose_speed(scratch)
        if int(share_ticks(rows, at, scratch, limits)) == 0:
            return -1
        top = int(set_span(rows, at, total))
    speed = scratch[SCRATCH_SPEED]
    rows[at + ROW_SPEED] = speed
    rows[at + ROW_SQUARE] = int(square_of(speed))
    rows[at + ROW_FASTEST] = int(square_of(scratch[SCRATCH_ALONG]))
    rows[at + ROW_CORNER] = 0
    rows[at + ROW_REACH] = 0
    rows[at + ROW_EXIT] = 0
    rows[at + ROW_TOP] = top
    if top < 64:
        rows[at + ROW_GAIN] = 0
        scratch[SCRATCH_THROUGH] = 0
    else:
        set_ramp(rows, at, scratch, limits)
    return 1


@micropython.viper
def choose_speed(scratch: ptr32):
    """SCRATCH_SPEED: SCRATCH_FEED, if the axes allow it; SCRATCH_LIMITED: 1 if they do not."""
    if scratch[SCRATCH_ALONG] < 1:
        scratch[SCRATCH_ALONG] = 1
    if scratch[SCRATCH_STRENGTH] < 1:
        scratch[SCRATCH_STRENGTH] = 1
    fastest = scratch[SCRATCH_ALONG]
    speed = scratch[SCRATCH_FEED]
    if speed == 0:
        speed = fastest
    scratch[SCRATCH_LIMITED] = 0
    if speed > fastest:
        speed = fastest
        scratch[SCRATCH_LIMITED] = 1
    scratch[SCRATCH_SPEED] = speed


@micropython.viper
def square_of(speed: int) -> int:
    """speed², both of 2²⁸."""
    high = speed >> 14
    return high * high + (high * (speed & 0x3FFF) >> 13)


@micropython.viper
def share_ticks(rows: ptr32, at: int, scratch: ptr32, limits: ptr32) -> int:
    """How long a line lasts at its speed: ROW_TICKS a step, and ROW_TICKS_REST more over all. Returns 0 if it is 2²⁹ ticks a
    step or more, else 1."""
    ticks = scratch[SCRATCH_GIVEN]
    shift = scratch[SCRATCH_GIVEN_SHIFT]
    if ticks == 0 or scratch[SCRATCH_LIMITED]:
        speed = scratch[SCRATCH_SPEED]
        lifted = int(lift(speed, 0x8000000))
        ticks = int(time_of(int(quotient(scratch[SCRATCH_LENGTH], speed << lifted)), limits[LIMIT_SPEED]))
        shift = limits[LIMIT_SPEED_SHIFT] + lifted - scratch[SCRATCH_LENGTH_SHIFT]
    if shift < 0:
        ticks = int(scale(ticks, shift))
        shift = 0
    if ticks == 0:
        ticks = 1
        shift = 0
    total = scratch[SCRATCH_STEPS]
    each = ticks // total
    rest = ticks % total
    while shift > 0 and each < 0x10000000:
        each <<= 1
        rest <<= 1
        if rest >= total:
            rest -= total
            each += 1
        shift -= 1
    if shift > 0 or each > 0x1FFFFFFF:
        return 0
    rows[at + ROW_TICKS] = each
    rows[at + ROW_TICKS_REST] = rest
    return 1


@micropython.viper
def time_of(length: int, speed: int) -> int:
    """length · speed / 2²⁸, of 28 bits each, the lower digits' product left out: LIMIT_SPEED is ticks a nanometre."""
    high = length >> 15
    low = length & 0x7FFF
    first = speed >> 14
    return (high * first << 1) + (high * (speed & 0x3FFF) >> 13) + (low * first >> 14)


@micropython.viper
def set_span(rows: ptr32, at: int, total: int) -> int:
    """ROW_SPAN of a line of `total` steps, whose ticks are known. Returns its ROW_TOP: 16 000, and less if the span would otherwise reach 2³⁰."""
    each = rows[at + ROW_TICKS]
    top = 16000
    if each >= 33553:
        top = 0x1FFFFFFF // (each + 1)
    shift = int(drop(total, 0x8000))
    rows[at + ROW_SPAN] = 2 * top * each + 2 * top * (rows[at + ROW_TICKS_REST] >> shift) // (total >> shift)
    if each == 0:
        rows[at + ROW_TICKS] = 1
    return top


@micropython.viper
def set_ramp(rows: ptr32, at: int, scratch: ptr32, limits: ptr32):
    """Set the ramp's fields, in short floats: ROW_LIMIT, _RATIO, _GAIN, _REACH, _UNIT and _TIME."""
    top = rows[at + ROW_TOP]
    speed = rows[at + ROW_SPEED]
    rows[at + ROW_LIMIT] = int(fastest_units(top, scratch[SCRATCH_ALONG], speed))
    lifted = int(lift(speed, 0x8000000))
    raised = int(lift(top, 0x4000))
    set_ratio(rows, at, scratch, speed << lifted >> 13, 1013 - lifted, top << raised, 1000 - raised)
    shift = scratch[SCRATCH_STEPS_SHIFT] if scratch[SCRATCH_IS_ARC] else 1000
    shorten(scratch, SHORT_STEPS, scratch[SCRATCH_STEPS], shift)
    shift = int(drop(scratch[SCRATCH_LENGTH], 0x8000))
    scratch[SHORT_LENGTH] = scratch[SCRATCH_LENGTH] >> shift
    scratch[SHORT_LENGTH + SHORT_EXPONENT] = scratch[SCRATCH_LENGTH_SHIFT] - shift
    shorten(scratch, SHORT_STRENGTH, scratch[SCRATCH_STRENGTH], 1000)
    gain = int(gain_of(scratch, limits))
    rows[at + ROW_GAIN] = gain
    rows[at + ROW_REACH] = int(reach_of(scratch, gain))
    set_unit(rows, at, scratch)
    set_time(rows, at, scratch, limits)


@micropython.viper
def shorten(scratch: ptr32, at: int, value: int, shift: int):
    """Write value · 2^(shift − 1000) > 0 to scratch[at] as a short float: 15 bits, and the exponent behind them."""
    more = int(lift(value, 0x4000)) - int(drop(value, 0x8000))
    scratch[at] = int(scale(value, more))
    scratch[at + SHORT_EXPONENT] = shift - more


@micropython.viper
def fastest_units(top: int, fastest: int, speed: int) -> int:
    """Return the speed that the axes allow, in units: T · fastest / v; at most 2 · T and 32 000, at least T."""
    most = 2 * top
    if most > 32000:
        most = 32000
    if fastest >> 1 < speed:
        shift = int(drop(fastest, 0x8000))
        allowed = top * (fastest >> shift) // ((speed >> shift) + 1)
        if allowed < top:
            allowed = top
        if allowed < most:
            most = allowed
    return most


@micropython.viper
def set_ratio(rows: ptr32, at: int, scratch: ptr32, full: int, full_shift: int, top: int, top_shift: int):
    """The ratio of this block's unit of speed, v / T, to that of the block before, if motion goes through; remember this one's."""
    ratio = 0
    shift = 0
    if scratch[SCRATCH_THROUGH]:
        ratio = ((scratch[SCRATCH_FULL] * top >> 15) << 15) // (scratch[SCRATCH_TOP] * full >> 15)  # exactly 1 if nothing changes
        more = int(lift(ratio, 0x2000)) - int(drop(ratio, 0x4000))
        ratio = int(scale(ratio, more))
        shift = scratch[SCRATCH_TOP_SHIFT] + full_shift - scratch[SCRATCH_FULL_SHIFT] - top_shift + 15 + more
    rows[at + ROW_RATIO] = ratio
    rows[at + ROW_RATIO_SHIFT] = shift
    scratch[SCRATCH_FULL] = full
    scratch[SCRATCH_FULL_SHIFT] = full_shift
    scratch[SCRATCH_TOP] = top
    scratch[SCRATCH_TOP_SHIFT] = top_shift


@micropython.viper
def gain_of(scratch: ptr32, limits: ptr32) -> int:
    """q a step: 2 · a · l · T² / (v² · s), rounded down, 2 … 2²⁹ − 1."""
    square = scratch[SCRATCH_FULL] * scratch[SCRATCH_FULL] >> 15
    gain = scratch[SHORT_STRENGTH] * scratch[SHORT_LENGTH] >> 15
    gain = gain * limits[LIMIT_GAIN] >> 15
    gain = (gain << 15) // ((square * scratch[SHORT_STEPS] >> 15) + 1)
    shift = scratch[SHORT_STRENGTH + SHORT_EXPONENT] - scratch[SHORT_LENGTH + SHORT_EXPONENT] + limits[LIMIT_GAIN_SHIFT] - scratch[SHORT_STEPS + SHORT_EXPONENT]
    shift += 2 * (scratch[SCRATCH_TOP_SHIFT] - scratch[SCRATCH_FULL_SHIFT])
    less = int(drop(gain, 0x8000))
    gain = int(scale_clamped((gain >> less) * (scratch[SCRATCH_TOP] * scratch[SCRATCH_TOP] >> 15), shift + less))
    return gain if gain > 2 else 2


@micropython.viper
def reach_of(scratch: ptr32, gain: int) -> int:
    """Return the square of speed, of 2²⁸, that the block can gain or lose: gain · s · v² / T², rounded down."""
    more = int(lift(gain, 0x4000)) - int(drop(gain, 0x8000))
    reach = int(scale(gain, more)) * scratch[SHORT_STEPS] >> 15
    reach = reach * (scratch[SCRATCH_FULL] * scratch[SCRATCH_FULL] >> 15) >> 15
    reach = (reach << 15) // ((scratch[SCRATCH_TOP] * scratch[SCRATCH_TOP] >> 15) + 1)
    shift = scratch[SHORT_STEPS + SHORT_EXPONENT] - 1013 - more + 2 * (scratch[SCRATCH_FULL_SHIFT] - scratch[SCRATCH_TOP_SHIFT])
    return int(scale_clamped(reach, shift))


@micropython.viper
def set_unit(rows: ptr32, at: int, scratch: ptr32):
    """q of a square of speed of 2²⁸: T² / v², rounded down."""
    unit = (scratch[SCRATCH_TOP] * scratch[SCRATCH_TOP] >> 15) << 15
    unit = unit // ((scratch[SCRATCH_FULL] * scratch[SCRATCH_FULL] >> 15) + 1)
    less = int(drop(unit, 0x8000))
    rows[at + ROW_UNIT] = unit >> less
    rows[at + ROW_UNIT_SHIFT] = 2 * (scratch[SCRATCH_FULL_SHIFT] - scratch[SCRATCH_TOP_SHIFT]) - 13 - less


@micropython.viper
def set_time(rows: ptr32, at: int, scratch: ptr32, limits: ptr32):
    """Ticks that a change of speed by one unit takes: v / (T · a)."""
    ticks = scratch[SCRATCH_FULL] * limits[LIMIT_TIME] >> 15
    ticks = (ticks << 15) // ((scratch[SCRATCH_TOP] * scratch[SHORT_STRENGTH] >> 15) + 1)
    more = int(lift(ticks, 0x4000)) - int(drop(ticks, 0x8000))
    shift = scratch[SCRATCH_TOP_SHIFT] + scratch[SHORT_STRENGTH + SHORT_EXPONENT] - scratch[SCRATCH_FULL_SHIFT] - limits[LIMIT_TIME_SHIFT]
    rows[at + ROW_TIME] = int(scale(ticks, more))
    rows[at + ROW_TIME_SHIFT] = shift + 15 + more
