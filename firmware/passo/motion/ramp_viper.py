"""How the ramp takes up an accelerated line and cuts it: what it costs most often, in short.

    begin(rows, at, state, start)                   # the block whose row begins at rows[at]
    cut(rows, at, state, left, percent, hold)       # state[0]: steps, state[1]: ticks, state[2]: pace

What it reckons, and why, stands in ramp.py and ramp_ticks.py; the numbers of `state` do in steady.py, those of `rows` in
block.py. One text for all interpreters: a board compiles it to machine code, elsewhere it is ordinary Python; see
measure_viper.py for what that asks of integers. None reaches 2³⁰.
"""
# ruff: noqa: F821

import micropython

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows


@micropython.viper
def begin(rows: ptr32, at: int, state: ptr32, start: int):  # ISR: no allocation
    """The speed it begins with in its own units, and `start`, a square of 2²⁸, in them."""
    limit = rows[at + 8]
    most = limit << 7
    speed = state[4]
    shift = rows[at + 14]
    if shift >> 30 & 1:
        shift = 0 - ((0 - shift) & 0x3FFFFFFF)
    while speed >= 0x8000:
        speed >>= 1
        shift -= 1
    speed *= rows[at + 13]  # 15 bits by 14
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
    state[4] = speed
    whole = speed >> 7
    state[3] = whole * whole + (2 * whole * (speed & 127) >> 7)
    state[6] = 0
    state[5] = start


@micropython.viper
def cut(rows: ptr32, at: int, state: ptr32, left: int, percent: int, hold: int):  # ISR: no allocation
    """The next segment of a line that has `left` ≥ 1 dominant steps to come; see Ramp.cut()."""
    top = rows[at + 7]
    limit = rows[at + 8]
    gain = rows[at + 9]
    span = rows[at + 10]
    q = state[3]
    speed = state[4]
    start = state[5]
    cap = top * percent // 100
    if cap > limit:
        cap = limit
    cap *= cap
    high = cap
    state[0] = 0
    stage = 1
    value = 0
    if hold:
        cap = 0
        if q <= start:
            return
    elif q < start and q < cap or q > cap and q - (q >> 6) < start:  # no ramp is needed here
        q = start if start < cap else cap
        value = q
        stage = 0
    # --- the planned end, in the block's units
    unit = rows[at + 15]
    shift = rows[at + 23]
    if shift >> 30 & 1:
        shift = 0 - ((0 - shift) & 0x3FFFFFFF)
    shift -= 14
    leave = rows[at + 22]
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
    # --- stage 0: the speed without a ramp; 1: how many steps, and how fast at their end; 2: at the peak in between
    steps = 1
    aim = 0
    peak = 0
    after = 0
    fast = 0
    while True:
        if stage == 1:
            most = 0x1FFFFFFF // gain
            if most > 255:
                most = 255
            if most > left:
                most = left
            if q:
                each = span // speed
                rest = (span - each * speed) << 6
                each = (each << 6 if each < 0x800000 else 0x1FFFFFFF) + rest // speed
                steps = 12500 // each
                if steps > most:
                    steps = most
                if hold and steps > q // gain:
                    steps = q // gain + 1  # it stands after these
            if steps == 0:
                steps = 1
            change = steps * gain
            if q < cap:
                aim = cap if cap - q <= change else q + change
            else:
                aim = cap if q - cap <= change else q - change
            if aim > leave:
                rest = left - steps
                if rest <= 0x3FFFFFFF // gain:
                    rest *= gain
                    if rest < aim - leave:
                        aim = leave + rest
            peak = q if q > high else high
            rest = (change + (aim - q)) >> 1
            if rest <= peak - q:
                peak = q + rest
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
            rest = (root + value // root) >> 1
            while rest > root + 1 or rest < root - 1:
                root = rest
                rest = (root + value // root) >> 1
            root = rest
            while root * root > value:
                root -= 1
            root = (root << 7) + ((value - root * root) << 6) // root
        if stage == 0:
            speed = root
        elif stage == 1:
            after = root
            if q == aim and q == peak and percent == 100 and q == top * top:
                break
            value = peak
        else:
            fast = root
            break
        stage += 1
    if stage == 1:  # at programmed speed
        rest = state[6] + steps * rows[at + 3]
        most = state[7]
        ticks = rest // most
        state[6] = rest - ticks * most
        ticks += steps * rows[at + 2]
    else:
        each = span // fast
        rest = (span - each * fast) << 6
        each = each << 6 if each < 0x800000 else 0x1FFFFFFF
        most = rest // fast
        rest = ((rest - most * fast) << 7) // fast
        each += most
        ticks = steps * each
        if each < 0x80000:
            ticks += steps * rest >> 7
        if ticks == 0:
            ticks = 1
        # --- what getting from speed to fast, and on to after, costs more
        most = speed
        while stage:
            change = fast - most
            if change:
                ratio = change // fast
                rest = (change - ratio * fast) << 8
                ratio = (ratio << 8) + rest // fast
                rest = (rest % fast) << 6
                ratio = (ratio << 6) + rest // fast
                shift = rows[at + 12]
                if shift >> 30 & 1:
                    shift = 0 - ((0 - shift) & 0x3FFFFFFF)
                shift += 7
                while change >= 0x8000:
                    change >>= 1
                    shift -= 1
                change *= rows[at + 11]  # 15 bits by 15
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
    state[0] = steps
    state[1] = ticks
    state[2] = (speed + after) >> 8
    state[3] = aim
    state[4] = after
