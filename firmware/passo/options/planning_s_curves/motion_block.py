"""An S-curve's figures of a block: its units, in which s_curve.py (whose docstring has the method) reckons; how far it is to slow down, and
how long a segment lasts.

    load(rows, at, state)       # the block whose row begins at rows[at]; b goes over into its units

b is the square root of the speed, in the block's units, that would come on top while the acceleration fades. In time it
changes by `rate` a tick, at the given jerk; along the path q changes by b · `push` a step.

The fields of `rows` and `state` stand in records.py. All may run in an interrupt: no allocation, no integer of 2³⁰. Functions called many
times a segment are machine code on a board; see block_viper.py for its rules.
"""

import micropython
from micropython import const

from passo.motion.integers import divide
from passo.motion.speed_viper import path_ticks, root_of
from passo.options.planning_s_curves.records import *
from passo.records import *

_MOST_B = const(22_900)  # the square root of the fastest
_LEAST_B = const(64)  # of b at the highest acceleration: a higher jerk than that needs is not made use of


def load(rows, at, state):  # ISR: no allocation
    """Take up the block; b goes over into its units."""
    behind = at + state[S_CURVE_STRIDE]
    state[S_CURVE_BEHIND] = behind if behind < state[S_CURVE_ROWS] else 0
    gain = rows[at + ROW_GAIN]
    speed = rows[at + ROW_SPEED]
    shift = state[S_CURVE_SHIFT] + 5
    while speed < 0x4000000:
        speed <<= 2
        shift -= 1
    root = root_of(divide(rows[at + ROW_TOP], speed >> 6, 34), 0)
    while root >= 0x8000:
        root >>= 1
        shift -= 1
    rate = state[S_CURVE_ROOT] * root >> 15
    span = rows[at + ROW_SPAN]
    by = shift + 2
    while span >= 0x8000:
        span >>= 1
        by -= 1
    push = scale(span * rate, -by) or 1
    most = quotient(gain, push, 11)
    if most < _LEAST_B:
        most = _LEAST_B
        push = quotient(gain, most, 11)
        rate = quotient(gain, span, 12)
        shift += 7 - by
    while rate >= 0x8000:
        rate >>= 1
        shift -= 1
    while rate < 0x2000:
        rate <<= 1
        shift += 1
    state[S_CURVE_MOST] = most
    limit = state[S_CURVE_LIMIT] = min(most, _MOST_B)
    b = state[S_CURVE_B]
    if b:
        size = min(scale(abs(b) * rate // state[S_CURVE_RATE], state[S_CURVE_RATE_SHIFT] - shift), limit)  # 15 bits by 15
        state[S_CURVE_B] = size if b > 0 else -size
    state[S_CURVE_RATE] = rate
    state[S_CURVE_RATE_SHIFT] = shift
    state[S_CURVE_PUSH] = push
    if most > 16190:
        state[S_CURVE_SLOW] = 1
        state[S_CURVE_SCALE] = push
    else:
        state[S_CURVE_SLOW] = 0
        state[S_CURVE_W] = (most * most >> 13) or 1
        state[S_CURVE_SCALE] = (gain >> 2) or 1
    state[S_CURVE_FIRST] = 0  # found out where it is wanted
    state[S_CURVE_CRUISE] = 0x3FFFFFFF
    state[S_CURVE_SPAN] = rows[at + ROW_SPAN]


def step_from_rest(rows, at, state):  # ISR: no allocation
    """Find out, once a block, how fast its first step from rest can end."""
    if state[S_CURVE_FIRST]:
        return
    gain = rows[at + ROW_GAIN]
    push = state[S_CURVE_PUSH]
    limit = state[S_CURVE_LIMIT]
    b = cube_root(push)
    half = 0x6000  # the acceleration grows all along
    if b <= limit:
        rest = (push >> 12) * b + ((push & 0xFFF) * b >> 12)
        rest += rest >> 1
    else:
        b = limit
        w = state[S_CURVE_W]
        rest = gain - (gain >> 2)
        if not state[S_CURVE_SLOW] and gain // w > w // 3:
            rest = gain - w * w // 12
            fast = root_of(rest, 0) >> 7
            while fast >= 0x2000:
                fast >>= 1
                w >>= 1
            half = divide(fast * (fast + w // 2) >> 6, fast * fast + w * w // 12 >> 6, 14)
    state[S_CURVE_FIRST] = b
    state[S_CURVE_REST] = rest
    state[S_CURVE_HALF] = half


def need(state, fast, b):  # ISR: no allocation
    """Room, as S_CURVE_ROOM, to slow down to the block's end from the speed `fast` with b. S_CURVE_ABOVE: the speed above the wanted one."""
    until = state[S_CURVE_UNTIL]
    above = b * b >> 7
    if not state[S_CURVE_ROOM]:  # the block ends here
        wanted = state[S_CURVE_FAST]
        state[S_CURVE_ABOVE] = fast + (above if b > 0 else -above) - (until if until < wanted else wanted)
        return 0
    state[S_CURVE_ABOVE] = fast + (above if b > 0 else -above) - state[S_CURVE_FAST]
    fast += above  # the top of the curve
    most = state[S_CURVE_MOST]
    slow = state[S_CURVE_SLOW]
    on = state[S_CURVE_ON]
    size = abs(b)
    fine = fast < 0x40000  # below 2048: two bits more of the speeds, one of their roots
    if fine:
        fast >>= 5
        until >>= 5
        size <<= 1
        most <<= 1
    else:
        fast = fast >> 7 if fast < 4194176 else 32767
        until >>= 7
    drop = fast - until
    if drop <= 0:
        return 0
    square = size * size >> 14
    if b < 0:
        left = drop - square
        if left <= 0:
            return 0
        if left < square and not on:  # more than can fade till then: it is on the last part of the curve
            square = left
            size = root_of(left, size)
            drop = 2 * left
            fast = until + drop
    near = size * (fast - square // 3)
    near = near >> 1 if slow else (near >> 14) * most + ((near & 0x3FFF) * most >> 14)
    if on:  # from the top of the curve to `until`, the acceleration being at its highest there, or `last`
        last = root_of(drop, 0)
        rest = 0
        if last > most:
            last = most
            rest = fast - (last * last >> 14)
            rest = (rest - until) * (rest + until)
            rest = divide(rest, last, 11) if slow else rest >> 2
        far = last * (fast - (last * last >> 14) // 3)
        far = (far >> 1 if slow else (far >> 14) * most + ((far & 0x3FFF) * most >> 14)) + rest
    elif slow:
        far = (fast + until) * (root_of(drop, 0) * 23170 >> 16)
    else:
        w = state[S_CURVE_W]
        if fine:
            w <<= 2
        far = (drop + w) >> 1 if drop >= w else root_of(w * drop, 0) >> 7
        far = ((fast + until) >> 1) * far + (far >> 1 if (fast + until) & 1 else 0)
    far += near if b > 0 else -near
    if fine:
        far >>= 3 if slow else 4
    return far


def at_end(state, q, double):  # ISR: no allocation
    """Return q after the segment in which b is `double` / 2 on the average, 0 … INT_MOST."""
    size = abs(double)
    most = state[RAMP_CHANGE]
    if state[S_CURVE_SLOW]:
        force = state[S_CURVE_FORCE]
        change = (force >> 12) * size + ((force & 0xFFF) * size >> 12)
    else:
        by = 2 * state[S_CURVE_MOST]
        change = most // by * size + most % by * size // by
    if change > most:
        change = most
    if double < 0:
        return q - change if q > change else 0
    return q + change if change < INT_MOST - q else INT_MOST


def mean(state, speed):  # ISR: no allocation
    """Return the ticks of the segment's path at a mean `speed`, in units of the block."""
    return path_ticks(state[RAMP_PATH], state[S_CURVE_SPAN], speed or 1)


def b_change(state, ticks):  # ISR: no allocation
    """Return how much b may change in `ticks`, 1 at least. The remainder of the rounding counts in a later call."""
    shift = state[S_CURVE_RATE_SHIFT] - 1
    while ticks >= 0x8000:
        ticks >>= 1
        shift -= 1
    size = ticks * (state[S_CURVE_RATE] >> 1)
    if 0 < shift < 29:  # parts below one count later
        size += state[S_CURVE_SPARE] & (1 << shift) - 1
        state[S_CURVE_SPARE] = size
    return scale(size, -shift) or 1


def half_ramp(state, speed):  # ISR: no allocation
    """Return half the ticks that it takes from rest to `speed`, in units of the block."""
    speed >>= 1
    b = root_of(speed << 7, abs(state[S_CURVE_B]) << 7) >> 7
    limit = state[S_CURVE_LIMIT]
    if b > limit:
        b = limit + (speed - (limit * limit >> 7)) * 64 // limit
    shift = state[S_CURVE_RATE_SHIFT] - 14
    while b >= 0x8000:
        b >>= 1
        shift += 1
    return scale((b << 14) // state[S_CURVE_RATE], shift)


def quotient(value, by, bits):  # ISR: no allocation
    """Return value · 2ᵇⁱᵗˢ / by to 2⁻¹⁰ or so, 2³⁰ − 1 at most."""
    while by >= 0x200000:
        by >>= 1
        value >>= 1
    return divide(value, by, bits) if value // by < 0x3FFFFFFF >> bits else 0x3FFFFFFF


@micropython.viper
def scale(value: int, shift: int) -> int:  # ISR: no allocation
    """Return value · 2ˢʰⁱᶠᵗ, rounded down, 2³⁰ − 1 at most; value ≥ 0."""
    if shift <= 0:
        return value >> (0 - shift) if shift > -31 else 0
    return value << shift if shift < 30 and value <= 0x3FFFFFFF >> shift else 0x3FFFFFFF


@micropython.viper
def cube_root(push: int) -> int:  # ISR: no allocation
    """Return (¾ q a step and b)^⅓: b after a step from rest; `push` is q a step and b · 2⁴."""
    shift = 5
    value = push
    while value >= 0x800000:
        value >>= 3
        shift += 1
    value *= 3
    while value < 0x1000000:
        value <<= 3
        shift -= 1
    root = 512
    better = (2 * root + value // (root * root)) // 3
    while better < root:
        root = better
        better = (2 * root + value // (root * root)) // 3
    return root << shift if shift > 0 else root >> (0 - shift)


@micropython.viper
def ratio(part: int, other: int) -> int:  # ISR: no allocation
    """Return part / (part + other), of 2¹⁴; both ≥ 0."""
    while part >= 0x4000 or other >= 0x4000:
        part >>= 1
        other >>= 1
    other += part
    return (part << 14) // (other if other else 1)
