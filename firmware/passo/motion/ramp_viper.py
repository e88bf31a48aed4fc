"""How the ramp takes up an accelerated line or arc and cuts it.

    begin(rows, at, state, start, total, s_curve)    # the block whose row begins at rows[at]
    cut(rows, at, state, walker, left, percent, hold)   # its next segment: RAMP_STEPS, RAMP_TICKS and RAMP_PACE of `state`

What it computes, and why, stands in ramp.py, the fields of the arrays in records.py; `walker` is Line.state or Circle.state.
One text for all interpreters: a board compiles it to machine code, elsewhere it is ordinary Python; block_viper.py says
what that asks of integers. None reaches 2³⁰.
"""
# ruff: noqa: F821

import micropython

from passo.motion.block import ARC
from passo.records import (
    ARC_PATH, ARC_PATH_FINE, ARC_STEPS, ARC_TAIL_A, ARC_TAIL_B, ARC_TAIL_Z, CIRCLE_PATH, CIRCLE_WORDS, RAMP_BEGIN,
    RAMP_CAP, RAMP_CARRY, RAMP_CHANGE, RAMP_HIGH, RAMP_LENGTH, RAMP_PACE, RAMP_PART, RAMP_PATH, RAMP_Q, RAMP_START,
    RAMP_STEPS, RAMP_S_CURVE, RAMP_TICKS, RAMP_TOTAL, RAMP_TO_GO, RAMP_V, ROW_EXIT, ROW_GAIN, ROW_KIND, ROW_LIMIT,
    ROW_RATIO, ROW_RATIO_SHIFT, ROW_SPAN, ROW_TICKS, ROW_TICKS_REST, ROW_TIME, ROW_TIME_SHIFT, ROW_TOP, ROW_UNIT,
    ROW_UNIT_SHIFT,
)  # fmt: skip

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows


@micropython.viper
def begin(rows: ptr32, at: int, state: ptr32, start: int, total: int, s_curve: int):  # ISR: no allocation
    """The speed it begins with in its own units, and how long a segment should last: 1 ms, but of an arc 6, because what
    every run of a tight one costs a board is up to half a millisecond, and `s_curve`, with limited jerk, 3, because the
    pace is even in a segment, off the curve by acceleration · t² / 8. `start`: the q that takes no ramp."""
    state[RAMP_TOTAL] = total
    state[RAMP_LENGTH] = 37500 if s_curve else 75000 if rows[at + ROW_KIND] == ARC else 12500
    state[RAMP_S_CURVE] = s_curve
    if rows[at + ROW_GAIN] == 0:
        state[RAMP_Q] = 0
        state[RAMP_V] = 0
        return
    limit = rows[at + ROW_LIMIT]
    most = limit << 7
    speed = state[RAMP_V]
    shift = rows[at + ROW_RATIO_SHIFT]
    if shift >> 30 & 1:
        shift = 0 - ((0 - shift) & 0x3FFFFFFF)
    while speed >= 0x8000:
        speed >>= 1
        shift -= 1
    speed *= rows[at + ROW_RATIO]  # 15 bits by 14
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
    arc = 0
    if rows[at + ROW_KIND] == ARC:
        arc = 1
    top = rows[at + ROW_TOP]
    limit = rows[at + ROW_LIMIT]
    gain = rows[at + ROW_GAIN]
    span = rows[at + ROW_SPAN]
    q = state[RAMP_Q]
    speed = state[RAMP_V]
    start = state[RAMP_START]
    cap = top * percent // 100
    if cap > limit:
        cap = limit
    cap *= cap
    high = cap
    state[RAMP_STEPS] = 0
    # --- stage 0: the speed without a ramp; 1: how many steps, and how fast at their end; 2: at the peak in between; 3: how
    # many steps of an arc that keeps its speed
    stage = 1
    value = 0
    if gain == 0:
        if hold:
            return
        stage = 3
    elif hold:
        cap = 0
        if q <= start:
            return
    elif q < start and q < cap or q > cap and q - (q >> 6) < start:  # no ramp is needed here
        q = start if start < cap else cap
        value = q
        stage = 0
    steps = 1
    whole = 1
    fraction = 0
    rest = 0
    aim = 0
    peak = 0
    after = 0
    fast = 0
    while True:
        if stage & 1:
            # --- about as many steps as a segment lasts, one of a line from rest
            length = state[RAMP_LENGTH]
            each = length
            far = 0x1FFFFFFF
            if gain == 0:
                each = rows[at + ROW_TICKS]
                rest = rows[at + ROW_TICKS_REST]
            else:
                far = far // gain
                if q:
                    each = span // speed
                    part = (span - each * speed) << 6
                    each = (each << 6 if each < 0x800000 else 0x1FFFFFFF) + part // speed
            most = far if far < 255 else 255
            steps = length // each
            if arc:
                words = walker[CIRCLE_WORDS]
                path = walker[CIRCLE_PATH]
                steps <<= 13
                value = path if path else 1
                if steps >= value:
                    steps = left
                else:
                    steps = steps * words // value
                if gain and steps * value > (most << 13) * words:
                    steps = (most << 13) * words // value
                most = 500
            elif hold and steps > q // gain:
                steps = q // gain + 1  # it stands after these
            if steps > most:
                steps = most
            if steps > left:
                steps = left
            if steps == 0:
                steps = 1
            # --- their path, as whole steps and 2⁻¹⁷, and what is to go after them
            whole = steps
            togo = left - steps
            part = 0
            if arc:
                value = path * steps
                whole = value // words
                value = (value - whole * words) << 4
                fraction = (whole << 4) + value // words
                whole = fraction >> 17
                fraction &= 0x1FFFF
                if stage == 3:
                    break
                value = path * (words - togo)
                part = value // words
                value = (value - part * words) << 4
                part = (part << 4) + value // words + (walker[ARC_PATH_FINE] >> 3)
                value = togo
                togo = ((walker[ARC_PATH] + 0x20000000) & 0x3FFFFFFF) - 0x20000000 - (part >> 17)
                part = (0 - part) & 0x1FFFF
                if part:
                    togo -= 1
                if value == 0 and walker[ARC_STEPS] == 0 and (walker[ARC_TAIL_A] | walker[ARC_TAIL_B] | walker[ARC_TAIL_Z]) == 0:
                    togo = 0  # the arc's end
                    part = 0
            # --- how fast at their end
            change = 0x1FFFFFFF
            if whole <= far:
                value = whole * gain + (gain >> 17) * fraction + (((gain & 0x1FFFF) >> 5) * fraction >> 12)
                if value < change:
                    change = value
            if state[RAMP_S_CURVE]:  # it is s_curve.py that goes on
                state[RAMP_STEPS] = steps
                state[RAMP_V] = speed
                state[RAMP_PATH] = (whole << 17) + fraction
                state[RAMP_TO_GO] = togo
                state[RAMP_PART] = part
                state[RAMP_CHANGE] = change
                state[RAMP_CAP] = cap
                state[RAMP_HIGH] = high
                state[RAMP_BEGIN] = q
                return
            if q < cap:
                aim = cap if cap - q <= change else q + change
            else:
                aim = cap if q - cap <= change else q - change
            # the planned end, in the block's units
            unit = rows[at + ROW_UNIT]
            shift = rows[at + ROW_UNIT_SHIFT]
            if shift >> 30 & 1:
                shift = 0 - ((0 - shift) & 0x3FFFFFFF)
            shift -= 14
            leave = rows[at + ROW_EXIT]
            leave = (leave >> 14) * unit + ((leave & 0x3FFF) * unit >> 14)
            most = limit * limit
            if shift >= 0:
                leave >>= shift
                if leave > most:
                    leave = most
            elif leave >= most >> (0 - shift):
                leave = most
            else:
                leave <<= 0 - shift
            if leave < start:
                leave = start
            if aim > leave:
                if togo < 0:
                    aim = leave
                elif togo <= 0x3FFFFFFF // gain:
                    value = togo * gain
                    if value < aim - leave:
                        leave += value
                        value = (gain >> 17) * part + (((gain & 0x1FFFF) >> 5) * part >> 12)
                        if value < aim - leave:
                            aim = leave + value
            peak = q if q > high else high
            value = (change + (aim - q)) >> 1
            if value <= peak - q:
                peak = q + value
            if peak < aim:
                peak = aim
            if peak < q:
                peak = q
            if peak < 1:
                peak = 1
            value = aim
        root = 0
        if value:
            root = speed >> 7
            if root == 0:
                root = 0x2000
            part = (root + value // root) >> 1
            while part > root + 1 or part < root - 1:
                root = part
                part = (root + value // root) >> 1
            root = part
            while root * root > value:
                root -= 1
            root = (root << 7) + ((value - root * root) << 6) // root
        if stage == 0:
            speed = root
        elif stage == 1:
            after = root
            if q == aim and q == peak and percent == 100 and q == top * top and arc == 0:
                break
            value = peak
        else:
            fast = root
            each = span // fast
            part = (span - each * fast) << 6
            each = each << 6 if each < 0x800000 else 0x1FFFFFFF
            most = part // fast
            rest = ((part - most * fast) << 7) // fast
            each += most
            break
        stage += 1
    if stage == 1:  # a line at programmed speed
        rest = state[RAMP_CARRY] + steps * rows[at + ROW_TICKS_REST]
        most = state[RAMP_TOTAL]
        ticks = rest // most
        state[RAMP_CARRY] = rest - ticks * most
        ticks += steps * rows[at + ROW_TICKS]
    else:
        ticks = 0
        if each < 0x80000:
            ticks = (whole * rest >> 7) + (fraction * rest >> 24)
            ticks += ((fraction >> 7) * each >> 10) + ((fraction & 127) * each >> 17)
        elif each < 0x800000:
            ticks = fraction * (each >> 10) >> 7
        else:
            ticks = (fraction >> 7) * (each >> 10)
        ticks += whole * each
        if ticks == 0:
            ticks = 1
        # --- what getting from speed to fast, and on to after, costs more
        most = speed
        if stage == 3:
            stage = 0
        while stage:
            change = fast - most
            if change:
                ratio = change // fast
                rest = (change - ratio * fast) << 8
                ratio = (ratio << 8) + rest // fast
                rest = (rest % fast) << 6
                ratio = (ratio << 6) + rest // fast
                shift = rows[at + ROW_TIME_SHIFT]
                if shift >> 30 & 1:
                    shift = 0 - ((0 - shift) & 0x3FFFFFFF)
                shift += 7
                while change >= 0x8000:
                    change >>= 1
                    shift -= 1
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
                    ticks += (change * ratio >> 15) + 1
                else:
                    ticks += (change >> 15) * ratio + ((change & 0x7FFF) * ratio >> 15) + 1
            most = after
            stage -= 1
    state[RAMP_STEPS] = steps
    state[RAMP_TICKS] = ticks
    if gain == 0:
        state[RAMP_PACE] = -1
        return
    state[RAMP_PACE] = (speed + after) >> 8
    state[RAMP_Q] = aim
    state[RAMP_V] = after
