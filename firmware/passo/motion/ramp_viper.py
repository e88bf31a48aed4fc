"""How the ramp takes up an accelerated line or arc and cuts it.

    begin(rows, at, state, start, total, s_curve)    # the block whose row begins at rows[at]
    cut(rows, at, state, walker, left, percent, hold)   # its next segment: RAMP_STEPS, RAMP_TICKS and RAMP_PACE of `state`

ramp.py has the method and the reasons, records.py the fields of the arrays; `walker` is Line.state or Circle.state.
One text for all interpreters; see block_viper.py. No integer reaches 2³⁰.
"""

import micropython

from passo.motion.scale_viper import drop, sign_extend
from passo.motion.speed_viper import path_ticks, q_change, q_of, root_of, spread, step_ticks
from passo.records import *


@micropython.viper
def begin(rows: ptr32, at: int, state: ptr32, start: int, total: int, s_curve: int):  # ISR: no allocation
    """The speed it begins with in its own units, and how long a segment should last: 1 ms, but of an arc 6, because every run of a tight
    one costs a board up to half a millisecond, and `s_curve`, with limited jerk, 3, because the pace is even in a segment, off the curve by
    acceleration · t² / 8. `start`: the q that takes no ramp."""
    state[RAMP_TOTAL] = total
    state[RAMP_LENGTH] = 37500 if s_curve else 75000 if rows[at + ROW_KIND] == KIND_ARC else 12500
    state[RAMP_S_CURVE] = s_curve
    if rows[at + ROW_GAIN] == 0:
        state[RAMP_Q] = 0
        state[RAMP_V] = 0
        return
    limit = rows[at + ROW_LIMIT]
    most = limit << 7
    speed = state[RAMP_V]
    less = int(drop(speed, 0x8000))
    shift = int(sign_extend(rows[at + ROW_RATIO_SHIFT])) - less
    speed = (speed >> less) * rows[at + ROW_RATIO]  # 15 bits by 14
    if shift > 30:
        speed = 0
    elif shift >= 0:
        speed >>= shift
    elif shift < -30 or speed >= most >> (0 - shift):
        speed = most
    else:
        speed <<= 0 - shift
    if speed > most:
        speed = most
    state[RAMP_V] = speed
    whole = speed >> 7
    state[RAMP_Q] = whole * whole + (2 * whole * (speed & 127) >> 7)
    state[RAMP_CARRY] = 0
    state[RAMP_START] = start


@micropython.viper
def cut(rows: ptr32, at: int, state: ptr32, walker: ptr32, left: int, percent: int, hold: int):  # ISR: no allocation
    """The next segment of a walker that has `left` ≥ 1 words to come to the line's end, or to that of the arc's run; see
    Ramp.cut()."""
    state[RAMP_STEPS] = 0
    if int(want(rows, at, state, percent, hold)) == 0:
        return
    gain = rows[at + ROW_GAIN]
    steps = int(count_steps(rows, at, state, walker, left, hold))
    path = steps << 17
    togo = left - steps
    state[RAMP_PART] = 0
    if rows[at + ROW_KIND] == KIND_ARC:
        path = int(run_path(walker, steps))
        togo = int(arc_to_go(state, walker, togo))
    state[RAMP_STEPS] = steps
    state[RAMP_PATH] = path
    state[RAMP_TO_GO] = togo
    if gain == 0:
        state[RAMP_TICKS] = int(spread(path, rows[at + ROW_TICKS], rows[at + ROW_TICKS_REST]))
        state[RAMP_PACE] = -1
        return
    change = int(q_change(gain, path >> 17, path & 0x1FFFF))
    state[RAMP_CHANGE] = change if change < 0x1FFFFFFF else 0x1FFFFFFF
    if state[RAMP_S_CURVE] == 0:  # else an option goes on
        finish(rows, at, state, togo, percent)


@micropython.viper
def want(rows: ptr32, at: int, state: ptr32, percent: int, hold: int) -> int:  # ISR: no allocation
    """Set RAMP_CAP, the q wanted, RAMP_HIGH, the same but for a hold, and RAMP_BEGIN, the q to begin with: RAMP_START at once
    if that takes no ramp. Returns 0 if the machine stands now, in a hold, else 1."""
    if rows[at + ROW_GAIN] == 0:
        return 0 if hold else 1
    cap = rows[at + ROW_TOP] * percent // 100
    if cap > rows[at + ROW_LIMIT]:
        cap = rows[at + ROW_LIMIT]
    cap *= cap
    state[RAMP_HIGH] = cap
    q = state[RAMP_Q]
    start = state[RAMP_START]
    if hold:
        cap = 0
        if q <= start:
            return 0
    elif q < start and q < cap or q > cap and q - (q >> 6) < start:  # no ramp is needed here
        q = start if start < cap else cap
        state[RAMP_V] = int(root_of(q, state[RAMP_V]))
    state[RAMP_CAP] = cap
    state[RAMP_BEGIN] = q
    return 1


@micropython.viper
def count_steps(rows: ptr32, at: int, state: ptr32, walker: ptr32, left: int, hold: int) -> int:  # ISR: no allocation
    """About as many steps as a segment lasts, 1 … `left`: one of a line from rest, at most 255 of a line and 500 of an arc; and
    in a hold no more than it takes to stand."""
    gain = rows[at + ROW_GAIN]
    q = state[RAMP_BEGIN]
    length = state[RAMP_LENGTH]
    each = length
    most = 255
    if gain == 0:
        each = rows[at + ROW_TICKS]
    else:
        if q:
            each = int(step_ticks(rows[at + ROW_SPAN], state[RAMP_V]))
        most = 0x1FFFFFFF // gain  # so that q changes by less than 2²⁹
        if most > 255:
            most = 255
    steps = length // each
    if rows[at + ROW_KIND] == KIND_ARC:
        words = walker[CIRCLE_WORDS]
        path = walker[CIRCLE_PATH]
        if path == 0:
            path = 1
        steps <<= 13
        steps = left if steps >= path else steps * words // path
        if gain and steps * path > (most << 13) * words:
            steps = (most << 13) * words // path
        most = 500
    elif hold and steps > q // gain:
        steps = q // gain + 1  # it stands after these
    if steps > most:
        steps = most
    if steps > left:
        steps = left
    return steps if steps else 1


@micropython.viper
def run_path(walker: ptr32, words: int) -> int:  # ISR: no allocation
    """Return the path of `words` words of an arc's run, in steps · 2¹⁷."""
    path = walker[CIRCLE_PATH] * words
    whole = path // walker[CIRCLE_WORDS]
    return (whole << 4) + ((path - whole * walker[CIRCLE_WORDS]) << 4) // walker[CIRCLE_WORDS]


@micropython.viper
def arc_to_go(state: ptr32, walker: ptr32, words: int) -> int:  # ISR: no allocation
    """Return the steps of path of an arc behind this segment, after which `words` of its run are left; RAMP_PART: 2⁻¹⁷ of one."""
    made = int(run_path(walker, walker[CIRCLE_WORDS] - words)) + (walker[ARC_PATH_FINE] >> 3)
    togo = ((walker[ARC_PATH] + 0x20000000) & 0x3FFFFFFF) - 0x20000000 - (made >> 17)
    part = (0 - made) & 0x1FFFF
    if part:
        togo -= 1
    if words == 0 and walker[ARC_STEPS] == 0 and (walker[ARC_TAIL_A] | walker[ARC_TAIL_B] | walker[ARC_TAIL_Z]) == 0:
        togo = 0  # the arc's end
        part = 0
    state[RAMP_PART] = part
    return togo


@micropython.viper
def finish(rows: ptr32, at: int, state: ptr32, togo: int, percent: int):  # ISR: no allocation
    """How fast the segment ends, and how long it lasts: at the speed programmed, or by way of a peak."""
    q = state[RAMP_BEGIN]
    speed = state[RAMP_V]
    aim = int(reachable(rows, at, state, togo))
    peak = int(peak_of(state, aim))
    after = int(root_of(aim, speed))
    top = rows[at + ROW_TOP]
    if q == aim and q == peak and percent == 100 and q == top * top and rows[at + ROW_KIND] != KIND_ARC:
        state[RAMP_TICKS] = int(even_ticks(rows, at, state))
    else:
        fast = after if peak == aim else int(root_of(peak, speed))
        ticks = int(path_ticks(state[RAMP_PATH], rows[at + ROW_SPAN], fast))
        if fast != speed:
            ticks += int(change_ticks(rows, at, fast - speed, fast))
        if fast != after:
            ticks += int(change_ticks(rows, at, fast - after, fast))
        state[RAMP_TICKS] = ticks
    state[RAMP_PACE] = (speed + after) >> 8
    state[RAMP_Q] = aim
    state[RAMP_V] = after


@micropython.viper
def reachable(rows: ptr32, at: int, state: ptr32, togo: int) -> int:  # ISR: no allocation
    """q at the segment's end: toward RAMP_CAP by RAMP_CHANGE at most, and so that the block's exit can still be reached."""
    gain = rows[at + ROW_GAIN]
    q = state[RAMP_BEGIN]
    cap = state[RAMP_CAP]
    change = state[RAMP_CHANGE]
    aim = cap
    if q < cap:
        if cap - q > change:
            aim = q + change
    elif q - cap > change:
        aim = q - change
    leave = int(q_of(rows[at + ROW_EXIT], rows, at, rows[at + ROW_LIMIT]))
    if leave < state[RAMP_START]:
        leave = state[RAMP_START]
    if aim <= leave:
        return aim
    if togo < 0:
        return leave
    if togo > 0x3FFFFFFF // gain or togo * gain >= aim - leave:
        return aim
    leave += int(q_change(gain, togo, state[RAMP_PART]))
    return leave if leave < aim else aim


@micropython.viper
def peak_of(state: ptr32, aim: int) -> int:  # ISR: no allocation
    """Return the largest q within the segment, which begins at RAMP_BEGIN and ends at `aim`; 1 at least."""
    q = state[RAMP_BEGIN]
    peak = state[RAMP_HIGH]
    if peak < q:
        peak = q
    most = (state[RAMP_CHANGE] + (aim - q)) >> 1
    if most <= peak - q:
        peak = q + most
    if peak < aim:
        peak = aim
    if peak < q:
        peak = q
    return peak if peak else 1


@micropython.viper
def even_ticks(rows: ptr32, at: int, state: ptr32) -> int:  # ISR: no allocation
    """Return the ticks of a line's segment at the speed programmed; RAMP_CARRY spreads what does not divide by its steps."""
    rest = state[RAMP_CARRY] + state[RAMP_STEPS] * rows[at + ROW_TICKS_REST]
    ticks = rest // state[RAMP_TOTAL]
    state[RAMP_CARRY] = rest - ticks * state[RAMP_TOTAL]
    return ticks + state[RAMP_STEPS] * rows[at + ROW_TICKS]


@micropython.viper
def change_ticks(rows: ptr32, at: int, change: int, fast: int) -> int:  # ISR: no allocation
    """Return the ticks that a change by `change`, not 0, up to the speed `fast`, or down from it, costs beyond those at that speed: t ·
    change / 2 · fast, with t the time of the change.
    """
    ratio = change // fast
    rest = (change - ratio * fast) << 8
    ratio = (ratio << 8) + rest // fast
    ratio = (ratio << 6) + ((rest % fast) << 6) // fast
    less = int(drop(change, 0x8000))
    shift = int(sign_extend(rows[at + ROW_TIME_SHIFT])) + 7 - less
    change >>= less
    change *= rows[at + ROW_TIME]  # 15 bits by 15
    if shift > 30:
        change = 0
    elif shift >= 0:
        change >>= shift
    elif shift < -29 or change >= 0x1FFFFFFF >> (0 - shift):
        change = 0x1FFFFFFF
    else:
        change <<= 0 - shift
    if change < 0x8000:
        return (change * ratio >> 15) + 1
    return (change >> 15) * ratio + ((change & 0x7FFF) * ratio >> 15) + 1
