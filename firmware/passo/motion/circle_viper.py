"""The kernels of an arc: the length of a run, its time, and the masks of its words.

    load(plans, first, state)           # stand before the arc whose plan begins at plans[first]
    words = run(state)                  # set up the next run; 0: the circle has come to its end
    walk(out, at, count, state)         # the masks of `count` words of it

The method stands in circle.py, the fields of `plan` and `state` in records.py; block_viper.py says what kernels ask of
integers. None reaches 2³⁰. A number that may be negative, within ±2²⁹, is read out of an array by sign_extend().
"""

import micropython
from micropython import const

from passo.motion.integers import divide
from passo.motion.scale_viper import sign_extend
from passo.records import *

LEADS = const(22_938)  # ARC_Z_HIGH from which the third axis dominates somewhere: 0.7 steps a step

_Z_ONE = const(0x200000)  # 21 fraction bits
_LONGEST = const(255)  # most words of a run, so that no product here reaches 2³⁰


@micropython.viper
def load(plans: ptr32, first: int, state: ptr32):  # ISR: no allocation
    """Take up the arc whose plan is plans[first : first + ARC_FIELDS]; see Circle.load()."""
    i = 0
    while i < ARC_FIELDS:
        state[i] = plans[first + i]
        i += 1
    rise = int(sign_extend(plans[first + ARC_Z_STEPS]))
    state[CIRCLE_Z_LEFT] = rise if rise > 0 else 0 - rise
    state[CIRCLE_Z_SUM] = _Z_ONE >> 1
    state[CIRCLE_Z_OVER] = state[CIRCLE_REST] = state[CIRCLE_ERROR] = state[CIRCLE_USED] = 0
    state[CIRCLE_NEXT] = -1  # not known yet
    state[ARC_PATH] = plans[first + ARC_PATH] + 1
    state[ARC_PATH_FINE] = 0x100000 - plans[first + ARC_PATH_FINE]


@micropython.viper
def run(state: ptr32) -> int:  # ISR: no allocation
    """Set up the next run of steps with one slope, or the last line; see Circle."""
    part = state[ARC_PATH_FINE] + int(sign_extend(state[CIRCLE_USED]))
    state[ARC_PATH] = state[ARC_PATH] - (part >> 20)
    state[ARC_PATH_FINE] = part & 0xFFFFF
    state[CIRCLE_USED] = 0
    if state[ARC_STEPS] == 0:
        return 0
    u = int(sign_extend(state[ARC_U]))
    w = state[ARC_W]
    if u >= state[ARC_INSIDE]:  # over the diagonal: the axes change their parts
        part = u
        u = 0 - w
        w = part
        state[ARC_REGION] = (state[ARC_REGION] + 1) & 3
        state[ARC_U] = u
        state[ARC_W] = w
    count = int(run_steps(state, u, w))
    state[ARC_STEPS] = state[ARC_STEPS] - count
    words = int(third_axis(state, int(measure_run(state, u, w, count)), count))
    used = int(sign_extend(state[CIRCLE_USED])) + state[CIRCLE_REST]
    if used < 0:
        used = 0
    state[CIRCLE_PATH] = used >> 7
    state[CIRCLE_REST] = used & 127
    state[CIRCLE_WORDS] = words
    state[CIRCLE_RISE] = 2 * count
    state[CIRCLE_FALL] = 2 * words
    state[CIRCLE_DECISION] = 2 * count - words
    set_directions(state, u)
    return words


@micropython.viper
def run_steps(state: ptr32, u: int, w: int) -> int:  # ISR: no allocation
    """Return how many steps may be one run: one over a diagonal; else as many as leave the slope about the same, w² / 85u, and are no
    more than an eighth of w, 255, and 320 with the third axis."""
    left = state[ARC_STEPS]
    slope = u if u >= 0 else 0 - u
    ends = state[ARC_INSIDE] - u - 1 if u >= 0 else slope  # the step onto the diagonal is a run of its own
    if ends <= 1 or u <= 0 - state[ARC_ACROSS]:
        return 1
    count = _LONGEST
    part = (w << 6) // (slope + 1)
    if part < 1024:
        count = 3 * (part * w >> 14)
    if count > w >> 3:
        count = w >> 3
    part = (state[ARC_Z_HIGH] >> 15) + 1  # whole steps of the third axis a step, and one
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
    return count if count < left else left


@micropython.viper
def measure_run(state: ptr32, u: int, w: int, count: int) -> int:  # ISR: no allocation
    """Return the length of a run of `count` steps, of 2⁻²⁰ steps. CIRCLE_NEXT: that of the step behind it; CIRCLE_USED: how long it
    takes, as a length. A word's time passes after its step: a run lasts from its first step to the first one of the next.
    If the third axis leads, time is its own."""
    diagonal = state[ARC_DIAGONAL]
    error = int(sign_extend(state[CIRCLE_ERROR]))
    before = int(sign_extend(state[CIRCLE_NEXT]))
    length = diagonal
    if u <= 0 - state[ARC_ACROSS]:  # over the diagonal: the root is wanted behind this step
        if before < 0:
            before = diagonal
        error += 2 * u + 1
        if error + w < 0:
            error += 2 * w + 1
            w += 1
        near = int(root_near(state, w, error))
    else:
        near = int(root_near(state, w, error))
        if before < 0:
            before = int(true_length(state, near, u, 1))
        length = int(true_length(state, near, u, count))
        near = state[CIRCLE_ROOT]
    after = diagonal
    if u + count < state[ARC_INSIDE]:
        after = int(true_length(state, near, u + count, 1))
    state[CIRCLE_NEXT] = after
    state[CIRCLE_USED] = length + after - before if state[ARC_Z_HIGH] < LEADS else length
    return length


@micropython.viper
def root_near(state: ptr32, w: int, error: int) -> int:  # ISR: no allocation
    """√(R² − u²), of 2^ARC_SHIFT, from w and the error u² + w² − R²: w − error / 2w, less the square of that over 2w."""
    shift = state[ARC_SHIFT]
    near = w
    if w > 0:
        part = (error << (shift - 1)) // w
        near = (w << shift) - part
        if shift > 14:
            part >>= shift - 14
            near -= (part * part // (2 * w)) >> (28 - shift)
        if near > state[ARC_RADIUS]:
            near = state[ARC_RADIUS]
    return near if near > 0 else 0


@micropython.viper
def true_length(state: ptr32, near: int, u: int, steps: int) -> int:  # ISR: no allocation
    """Return the length of `steps` steps from u on, along the true circle from √(R² − u²), which is `near`; of 2⁻²⁰ steps. CIRCLE_ROOT:
    the root behind them. The sum w₁ + w₂ of both is the root of sum = 2w₁ − steps·(2u + steps) / sum, which two rounds solve to
    2·10⁻⁶."""
    shift = state[ARC_SHIFT]
    radius = state[ARC_RADIUS]
    change = steps * (2 * u + steps) << (shift - 8)
    total = 2 * near
    rounds = 0
    while rounds < 2:
        if total < 256:
            total = 256
        total = 2 * near - int(divide(change, total >> 8, shift))
        if total > 2 * radius:
            total = 2 * radius
        rounds += 1
    if total < 256:
        total = 256
    by = total >> 8
    length = (steps << 20) + steps * int(divide((radius - (total >> 1)) >> 7, by, 20))  # R / mean w − 1
    chord = int(divide(steps << (shift - 8), by, 12))  # its part of R
    state[CIRCLE_ROOT] = total - near
    return length - ((length >> 16) * (chord * chord) // 3 >> 8)


@micropython.viper
def third_axis(state: ptr32, length: int, count: int) -> int:  # ISR: no allocation
    """Spread the third axis's steps over a run: the ratio has 30 fraction bits, nothing is lost. Over a diagonal a step of the
    circle may be two long: the third axis makes up for it later, so that it costs no word of its own. Returns the run's words:
    its steps, or those of the third axis if they are more."""
    state[CIRCLE_Z_RISE] = 0
    if state[ARC_Z_STEPS] == 0:
        return count
    steep = state[ARC_Z_HIGH]
    length += state[CIRCLE_Z_OVER]
    state[CIRCLE_Z_OVER] = length & 0x3FFF
    climb = (length >> 14) * steep + ((length >> 14) * state[ARC_Z_LOW] >> 15)
    height = state[CIRCLE_Z_SUM]
    total = height + climb
    steps = total >> 21
    over = total & (_Z_ONE - 1)
    left = state[CIRCLE_Z_LEFT]
    if steps > left or state[ARC_STEPS] == 0:
        climb += (left - steps) << 21  # the end is exact
        steps = left
    elif steps > count and steep < LEADS:
        over = total - (count << 21)
        steps = count
    state[CIRCLE_Z_SUM] = over
    state[CIRCLE_Z_LEFT] = left - steps
    if steps > count:  # it steps in every word, the circle now and then
        state[CIRCLE_Z_RISE] = _Z_ONE
        state[CIRCLE_Z_BETWEEN] = 0
        return steps
    each = 0
    if steps:
        each = climb // count
        height += climb - each * count  # less than 2⁻¹⁰ step: nothing is lost at the end
        if each == 0:
            each = 1  # its one step is due
    state[CIRCLE_Z_RISE] = each
    state[CIRCLE_Z_BETWEEN] = height
    return count


@micropython.viper
def set_directions(state: ptr32, u: int):  # ISR: no allocation
    """Which axes move in the region, and which way. Counter-clockwise u points to +y −x −y +x, w to +x +y −x −y; w's steps turn
    round at u = 0. Clockwise mirrors y."""
    region = state[ARC_REGION]
    odd = region & 1
    state[CIRCLE_U_AXIS] = state[ARC_AXIS_B - odd]
    state[CIRCLE_W_AXIS] = state[ARC_AXIS_A + odd]
    along = 1 << state[CIRCLE_U_AXIS]
    other = 1 << state[CIRCLE_W_AXIS]
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
    rise = int(sign_extend(state[ARC_Z_STEPS]))
    if rise:
        third = 1 << state[ARC_AXIS_Z]
        moving |= third
        if rise < 0:
            negative |= third
    state[CIRCLE_MOVING] = moving
    state[CIRCLE_NEGATIVE] = negative


@micropython.viper
def walk(out: ptr32, at: int, count: int, state: ptr32):  # ISR: no allocation
    """See above. Each step along u goes along w too if that leaves the smaller error."""
    u = int(sign_extend(state[ARC_U]))
    w = state[ARC_W]
    error = int(sign_extend(state[CIRCLE_ERROR]))
    decision = int(sign_extend(state[CIRCLE_DECISION]))
    rise = state[CIRCLE_RISE]
    fall = state[CIRCLE_FALL]
    along = 1 << state[CIRCLE_U_AXIS]
    both = along | 1 << state[CIRCLE_W_AXIS]
    made_u = 0 - u
    i = at
    while i < at + count:
        mask = 0
        if decision > 0:
            decision -= fall
            mask = along
            error += 2 * u + 1
            aside = 1 if u < 0 else -1
            near = error + 2 * aside * w + 1
            if (near + error) * aside < 0:
                error = near
                w += aside
                mask = both
            u += 1
        decision += rise
        out[i] = mask
        i += 1
    made_w = w - state[ARC_W]
    state[ARC_U] = u
    state[ARC_W] = w
    state[CIRCLE_ERROR] = error
    state[CIRCLE_DECISION] = decision
    made = CIRCLE_LINE + LINE_RISE + 2 * state[CIRCLE_LINE + LINE_AXES]
    count_steps(state, made, state[CIRCLE_U_AXIS], made_u + u)
    count_steps(state, made, state[CIRCLE_W_AXIS], made_w if made_w > 0 else 0 - made_w)
    if state[CIRCLE_Z_RISE]:
        count_steps(state, made, state[ARC_AXIS_Z], int(climb(out, at, count, state)))


@micropython.viper
def climb(out: ptr32, at: int, count: int, state: ptr32) -> int:  # ISR: no allocation
    """Add the third axis's steps to the masks out[at : at + count]. Returns how many it takes."""
    rise = state[CIRCLE_Z_RISE]
    height = state[CIRCLE_Z_BETWEEN]
    third = 1 << state[ARC_AXIS_Z]
    steps = 0
    end = at + count
    while at < end:
        height += rise
        if height >= _Z_ONE:
            height -= _Z_ONE
            out[at] = out[at] | third
            steps += 1
        at += 1
    state[CIRCLE_Z_BETWEEN] = height
    return steps


@micropython.viper
def count_steps(state: ptr32, made: int, axis: int, steps: int):  # ISR: no allocation
    """Add an axis's `steps`, in its direction, to those in `made`."""
    if state[CIRCLE_NEGATIVE] >> axis & 1:
        steps = 0 - steps
    state[made + axis] = state[made + axis] + steps
