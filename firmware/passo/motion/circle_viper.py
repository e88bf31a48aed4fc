"""The kernels of an arc: the length of a run, its time, and the masks of its words.

    load(plans, first, state)           # stand before the arc whose plan begins at plans[first]
    words = run(state)                  # set up the next run; 0: the circle has come to its end
    walk(out, at, count, state)         # the masks of `count` words of it

The method stands in circle.py, the fields of `plan` and `state` in records.py. One text for all interpreters: a board
compiles it to machine code, elsewhere it is ordinary Python; block_viper.py says what that asks of integers. None reaches
2³⁰. A number that may be negative, within ±2²⁹, is read out of an array as ((number + INT_HALF) & INT_MOST) − INT_HALF.
"""
# ruff: noqa: F821

import micropython
from micropython import const

from passo.records import (
    ARC_ACROSS, ARC_AXIS_A, ARC_AXIS_B, ARC_AXIS_Z, ARC_DIAGONAL, ARC_FIELDS, ARC_INSIDE, ARC_MIRROR, ARC_PATH,
    ARC_PATH_FINE, ARC_RADIUS, ARC_REGION, ARC_SHIFT, ARC_STEPS, ARC_U, ARC_W, ARC_Z_HIGH, ARC_Z_LOW, ARC_Z_STEPS,
    CIRCLE_DECISION, CIRCLE_ERROR, CIRCLE_FALL, CIRCLE_LINE, CIRCLE_MOVING, CIRCLE_NEGATIVE, CIRCLE_NEXT, CIRCLE_PATH,
    CIRCLE_REST, CIRCLE_RISE, CIRCLE_USED, CIRCLE_U_AXIS, CIRCLE_WORDS, CIRCLE_W_AXIS, CIRCLE_Z_BETWEEN,
    CIRCLE_Z_LEFT, CIRCLE_Z_OVER, CIRCLE_Z_RISE, CIRCLE_Z_SUM, INT_HALF, INT_MOST, LINE_AXES, LINE_RISE,
)  # fmt: skip

LEADS = const(22_938)  # ARC_Z_HIGH from which the third axis dominates somewhere: 0.7 steps a step

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows

_Z_ONE = const(0x200000)  # 21 fraction bits
_LONGEST = const(255)  # most words of a run, so that no product here reaches 2³⁰


@micropython.viper
def load(plans: ptr32, first: int, state: ptr32):  # ISR: no allocation
    i = 0
    while i < ARC_FIELDS:
        state[i] = plans[first + i]
        i += 1
    rise = ((plans[first + ARC_Z_STEPS] + INT_HALF) & INT_MOST) - INT_HALF
    state[CIRCLE_Z_LEFT] = rise if rise > 0 else 0 - rise
    state[CIRCLE_Z_SUM] = _Z_ONE >> 1
    state[CIRCLE_Z_OVER] = state[CIRCLE_REST] = state[CIRCLE_ERROR] = state[CIRCLE_USED] = 0
    state[CIRCLE_NEXT] = -1  # not known yet
    state[ARC_PATH] = plans[first + ARC_PATH] + 1
    state[ARC_PATH_FINE] = 0x100000 - plans[first + ARC_PATH_FINE]


@micropython.viper
def run(state: ptr32) -> int:  # ISR: no allocation
    part = state[ARC_PATH_FINE] + ((state[CIRCLE_USED] + INT_HALF) & INT_MOST) - INT_HALF
    state[ARC_PATH] = state[ARC_PATH] - (part >> 20)
    state[ARC_PATH_FINE] = part & 0xFFFFF
    state[CIRCLE_USED] = 0
    left = state[ARC_STEPS]
    if left == 0:
        return 0
    u = ((state[ARC_U] + INT_HALF) & INT_MOST) - INT_HALF
    w = state[ARC_W]
    region = state[ARC_REGION]
    inside = state[ARC_INSIDE]
    if u >= inside:  # over the diagonal: the axes change their parts
        region = (region + 1) & 3
        part = u
        u = 0 - w
        w = part
        state[ARC_REGION] = region
        state[ARC_U] = u
        state[ARC_W] = w
    # --- how many steps may be one run
    across = state[ARC_ACROSS]
    steep = state[ARC_Z_HIGH]
    ends = 0 - u
    slope = ends
    if u >= 0:
        ends = inside - u - 1  # the step onto the diagonal is a run of its own
        slope = u
    count = 1
    if ends > 1 and u > 0 - across:
        count = _LONGEST
        part = (w << 6) // (slope + 1)
        if part < 1024:
            count = 3 * (part * w >> 14)  # w² / 85u
        if count > w >> 3:
            count = w >> 3
        part = (steep >> 15) + 1  # whole steps of the third axis a step, and one
        if part > 1 and count * part > 320:
            count = 320 // part
        if count > _LONGEST:
            count = _LONGEST
        if u >= 0 and count > 1:  # the slope grows on the way
            if w < 8192:
                part = w * w // (85 * u + 43 * count)
                if count > part:
                    count = part
            else:
                count -= count >> 4
        if count > ends:
            count = ends
        if count < 1:
            count = 1
    if count > left:
        count = left
    # --- √(R² − u²), here or one step on, from w and the error: w − error / 2w, less the square of that over 2w
    radius = state[ARC_RADIUS]
    shift = state[ARC_SHIFT]
    error = ((state[CIRCLE_ERROR] + INT_HALF) & INT_MOST) - INT_HALF
    before = ((state[CIRCLE_NEXT] + INT_HALF) & INT_MOST) - INT_HALF
    long = state[ARC_DIAGONAL]
    near = w
    stage = 1
    if u <= 0 - across:
        stage = 2
        if before < 0:
            before = long
        error += 2 * u + 1
        if error + w < 0:
            error += 2 * w + 1
            near += 1
    elif before < 0:
        stage = 0
    if near > 0:
        twice = 2 * near
        part = (error << (shift - 1)) // near
        near = (near << shift) - part
        if shift > 14:
            part >>= shift - 14
            near -= (part * part // twice) >> (28 - shift)
        if near > radius:
            near = radius
    if near < 0:
        near = 0
    # --- lengths, of 2⁻²⁰ steps, on the true circle from √(R² − u²), which is `near`, on. 0: of the step before the run, if
    # that is not known; 1: of the run; 2: of the step after it
    after = long
    scale = shift - 8  # what makes R a number of 21 bits
    while stage < 3:
        some = 1
        ends = u
        if stage == 1:
            some = count
        elif stage == 2:
            ends += count
            if ends >= inside:
                break  # over the diagonal
        # w₁ + w₂ is the root of its own equation sum = 2w₁ − count·(2u + count) / sum, which two rounds solve to 2·10⁻⁶.
        slope = some * (2 * ends + some) << scale
        ends = shift
        total = 2 * near
        phase = 0
        while phase < 4:
            if phase and total > 2 * radius:
                total = 2 * radius
            if total < 256:
                total = 256
            by = total >> 8
            if phase == 2:  # R / mean w − 1
                slope = (radius - (total >> 1)) >> 7
                ends = 20
            elif phase == 3:  # the chord's part of R
                slope = some << scale
                ends = 12
            found = slope // by  # slope · 2ᵉⁿᵈˢ // by
            part = slope - found * by
            bits = ends
            while bits > 0:
                digits = 8 if bits > 8 else bits
                part <<= digits
                digit = part // by
                found = (found << digits) + digit
                part -= digit * by
                bits -= digits
            if phase < 2:
                total = 2 * near - found
            elif phase == 2:
                after = (some << 20) + some * found
            phase += 1
        after -= (after >> 16) * (found * found) // 3 >> 8
        if stage == 0:
            before = after
        elif stage == 1:
            long = after
            near = total - near
        stage += 1
        if stage < 3:
            after = state[ARC_DIAGONAL]
    state[CIRCLE_NEXT] = after
    left -= count
    state[ARC_STEPS] = left
    # A word's time passes after its step: a run lasts from its first step to the first one of the next. Where the third
    # axis leads, time is its own.
    used = long
    if steep < LEADS:
        used += after - before
    state[CIRCLE_USED] = used
    # --- the third axis's steps: the ratio has 30 fraction bits, nothing is lost. Over a diagonal a step of the circle may
    # be two long: the third axis makes up for it later, so that it costs no word of its own
    words = count
    rise = ((state[ARC_Z_STEPS] + INT_HALF) & INT_MOST) - INT_HALF
    state[CIRCLE_Z_RISE] = 0
    if rise:
        long += state[CIRCLE_Z_OVER]
        part = long >> 14
        state[CIRCLE_Z_OVER] = long & 0x3FFF
        climb = part * steep + (part * state[ARC_Z_LOW] >> 15)
        place = state[CIRCLE_Z_SUM]
        total = place + climb
        steps = total >> 21
        over = total & (_Z_ONE - 1)
        part = state[CIRCLE_Z_LEFT]
        if steps > part or left == 0:
            climb += (part - steps) << 21  # the end is exact
            steps = part
        elif steps > count and steep < LEADS:
            over = total - (count << 21)
            steps = count
        state[CIRCLE_Z_SUM] = over
        state[CIRCLE_Z_LEFT] = part - steps
        if steps > count:  # it steps in every word, the circle now and then
            words = steps
            climb = _Z_ONE
            place = 0
        elif steps:
            part = climb
            climb = part // count
            place += part - climb * count  # less than 2⁻¹⁰ step: nothing is lost at the end
            if climb == 0:
                climb = 1  # its one step is due
        else:
            climb = 0
        state[CIRCLE_Z_RISE] = climb
        state[CIRCLE_Z_BETWEEN] = place
    # --- its path, and its time's share of it
    used += state[CIRCLE_REST]
    if used < 0:
        used = 0
    state[CIRCLE_PATH] = used >> 7
    state[CIRCLE_REST] = used & 127
    state[CIRCLE_WORDS] = words
    state[CIRCLE_RISE] = 2 * count
    state[CIRCLE_FALL] = 2 * words
    state[CIRCLE_DECISION] = 2 * count - words
    # --- directions. ccw: u points to +y −x −y +x, w to +x +y −x −y; w's steps turn round at u = 0; cw mirrors y
    odd = region & 1
    part = state[ARC_AXIS_B - odd]
    state[CIRCLE_U_AXIS] = part
    along = 1 << part
    part = state[ARC_AXIS_A + odd]
    state[CIRCLE_W_AXIS] = part
    other = 1 << part
    u_back = (region + 1) >> 1 & 1
    w_back = region >> 1
    if u >= 0:
        w_back ^= 1
    if state[ARC_MIRROR]:
        if odd:
            w_back ^= 1
        else:
            u_back ^= 1
    moving = along | other
    negative = 0
    if u_back:
        negative |= along
    if w_back:
        negative |= other
    if rise:
        part = 1 << state[ARC_AXIS_Z]
        moving |= part
        if rise < 0:
            negative |= part
    state[CIRCLE_MOVING] = moving
    state[CIRCLE_NEGATIVE] = negative
    return words


@micropython.viper
def walk(out: ptr32, at: int, count: int, state: ptr32):  # ISR: no allocation
    u = ((state[ARC_U] + INT_HALF) & INT_MOST) - INT_HALF
    w = state[ARC_W]
    error = ((state[CIRCLE_ERROR] + INT_HALF) & INT_MOST) - INT_HALF
    decision = ((state[CIRCLE_DECISION] + INT_HALF) & INT_MOST) - INT_HALF
    rise = state[CIRCLE_RISE]
    fall = state[CIRCLE_FALL]
    climb = state[CIRCLE_Z_RISE]
    place = state[CIRCLE_Z_BETWEEN]
    along = 1 << state[CIRCLE_U_AXIS]
    both = along | 1 << state[CIRCLE_W_AXIS]
    third = 1 << (state[ARC_AXIS_Z] & 3)
    made_u = 0 - u
    made_w = w
    made_z = 0
    end = at + count
    while at < end:
        mask = 0
        if decision > 0:
            decision -= fall
            mask = along
            error += 2 * u + 1
            if u < 0:
                near = error + 2 * w + 1
                if near < 0 - error:
                    error = near
                    w += 1
                    mask = both
            else:
                near = error - 2 * w + 1
                if 0 - near < error:
                    error = near
                    w -= 1
                    mask = both
            u += 1
        decision += rise
        if climb:
            place += climb
            if place >= _Z_ONE:
                place -= _Z_ONE
                mask |= third
                made_z += 1
        out[at] = mask
        at += 1
    state[ARC_U] = u
    state[ARC_W] = w
    state[CIRCLE_ERROR] = error
    state[CIRCLE_DECISION] = decision
    state[CIRCLE_Z_BETWEEN] = place
    made_u += u
    made_w = w - made_w if w > made_w else made_w - w
    negative = state[CIRCLE_NEGATIVE]
    if negative & along:
        made_u = 0 - made_u
    if negative & both & ~along:
        made_w = 0 - made_w
    if negative & third:
        made_z = 0 - made_z
    made = CIRCLE_LINE + LINE_RISE + 2 * state[CIRCLE_LINE + LINE_AXES]
    at = made + state[CIRCLE_U_AXIS]
    state[at] = state[at] + made_u
    at = made + state[CIRCLE_W_AXIS]
    state[at] = state[at] + made_w
    if made_z:
        at = made + state[ARC_AXIS_Z]
        state[at] = state[at] + made_z
