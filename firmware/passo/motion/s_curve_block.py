"""The units of a block in which s_curve.py reckons: what jerk and acceleration do to b, from one block to the next.

    load(rows, at, state)       # the block whose row begins at rows[at]; b goes over into its units

b is the square root of the speed, in the block's units, that would come on top while the acceleration fades. In time it
changes by `rate` a tick, at the given jerk; along the path q changes by b · `push` a step.

The fields of `rows` and `state` stand in records.py. All may run in an interrupt: no allocation, no integer of 2³⁰.
"""

import micropython
from micropython import const

from passo.motion.integers import divide
from passo.motion.speed_viper import root_of
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
    push = scaled(span * rate, -by) or 1
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
    limit = most if most < _MOST_B else _MOST_B
    state[S_CURVE_LIMIT] = limit
    b = state[S_CURVE_B]
    if b:
        size = scaled(abs(b) * rate // state[S_CURVE_RATE], state[S_CURVE_RATE_SHIFT] - shift)  # 15 bits by 15
        if size > limit:
            size = limit
        state[S_CURVE_B] = (size if b > 0 else -size)
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


@micropython.viper
def scaled(value: int, shift: int) -> int:  # ISR: no allocation
    """value · 2ˢʰⁱᶠᵗ, 2³⁰ − 1 at most."""
    if shift <= 0:
        return value >> (0 - shift) if shift > -31 else 0
    return value << shift if shift < 30 and value <= 0x3FFFFFFF >> shift else 0x3FFFFFFF


def step_from_rest(gain, state):  # ISR: no allocation
    """How fast the first step from rest can end."""
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


def quotient(value, by, bits):  # ISR: no allocation
    """value · 2ᵇⁱᵗˢ / by to 2⁻¹⁰ or so, 2³⁰ − 1 at most."""
    while by >= 0x200000:
        by >>= 1
        value >>= 1
    return divide(value, by, bits) if value // by < 0x3FFFFFFF >> bits else 0x3FFFFFFF


@micropython.viper
def cube_root(push: int) -> int:  # ISR: no allocation
    """(¾ q a step and b)^⅓: what b is after a step from rest; `push` is q a step and b · 2⁴."""
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
