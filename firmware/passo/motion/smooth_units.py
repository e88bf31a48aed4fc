"""The units of a block in which smooth.py reckons: what jerk and acceleration do to b, from one block to the next.

    load(rows, at, state)       # the block whose row begins at rows[at]; b goes over into its units

b is the square root of the speed, in the block's units, that would come on top while the acceleration fades. In time it
changes by `rate` a tick, at the given jerk; along the path q changes by b · `push` a step.

`rows` are block.py's, `state` is as smooth.py has it. All may run in an interrupt: no allocation, no integer of 2³⁰.
"""

import micropython
from micropython import const

from passo.motion.integers import divide
from passo.motion.smooth_way import root_of

_MOST_B = const(22_900)  # the square root of the fastest
_LEAST_B = const(64)  # of b at the highest acceleration: a higher jerk than that needs is not made use of

# Of a row, as block.py has them.
_TOP = const(7)
_GAIN = const(9)
_ROW_SPAN = const(10)
_SPEED = const(18)
# Of the state, as smooth.py has them.
_B = const(17)
_RATE = const(18)
_RATE_SHIFT = const(19)
_PUSH = const(20)
_MOST = const(21)
_LIMIT = const(22)
_W = const(23)
_SLOW = const(24)
_SCALE = const(25)
_FIRST = const(26)
_REST = const(27)
_HALF = const(28)
_CRUISE = const(30)
_SPAN = const(34)
_BEHIND = const(33)
_ROOT = const(48)
_SHIFT = const(49)
_STRIDE = const(50)
_SIZE = const(51)


def load(rows, at, state):  # ISR: no allocation
    """Take up the block; b goes over into its units."""
    behind = at + state[_STRIDE]
    state[_BEHIND] = behind if behind < state[_SIZE] else 0
    gain = rows[at + _GAIN]
    speed = rows[at + _SPEED]
    shift = state[_SHIFT] + 5
    while speed < 0x4000000:
        speed <<= 2
        shift -= 1
    root = root_of(divide(rows[at + _TOP], speed >> 6, 34), 0)
    while root >= 0x8000:
        root >>= 1
        shift -= 1
    rate = state[_ROOT] * root >> 15
    span = rows[at + _ROW_SPAN]
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
    state[_MOST] = most
    limit = most if most < _MOST_B else _MOST_B
    state[_LIMIT] = limit
    b = state[_B]
    if b:
        size = scaled(abs(b) * rate // state[_RATE], state[_RATE_SHIFT] - shift)  # 15 bits by 15
        if size > limit:
            size = limit
        state[_B] = (size if b > 0 else -size)
    state[_RATE] = rate
    state[_RATE_SHIFT] = shift
    state[_PUSH] = push
    if most > 16190:
        state[_SLOW] = 1
        state[_SCALE] = push
    else:
        state[_SLOW] = 0
        state[_W] = (most * most >> 13) or 1
        state[_SCALE] = (gain >> 2) or 1
    state[_FIRST] = 0  # found out where it is wanted
    state[_CRUISE] = 0x3FFFFFFF
    state[_SPAN] = rows[at + _ROW_SPAN]


@micropython.viper
def scaled(value: int, shift: int) -> int:  # ISR: no allocation
    """value · 2ˢʰⁱᶠᵗ, 2³⁰ − 1 at most."""
    if shift <= 0:
        return value >> (0 - shift) if shift > -31 else 0
    return value << shift if shift < 30 and value <= 0x3FFFFFFF >> shift else 0x3FFFFFFF


def step_from_rest(gain, state):  # ISR: no allocation
    """How fast the first step from rest can end."""
    push = state[_PUSH]
    limit = state[_LIMIT]
    b = cube_root(push)
    half = 0x6000  # the acceleration grows all along
    if b <= limit:
        rest = (push >> 12) * b + ((push & 0xFFF) * b >> 12)
        rest += rest >> 1
    else:
        b = limit
        w = state[_W]
        rest = gain - (gain >> 2)
        if not state[_SLOW] and gain // w > w // 3:
            rest = gain - w * w // 12
            fast = root_of(rest, 0) >> 7
            while fast >= 0x2000:
                fast >>= 1
                w >>= 1
            half = divide(fast * (fast + w // 2) >> 6, fast * fast + w * w // 12 >> 6, 14)
    state[_FIRST] = b
    state[_REST] = rest
    state[_HALF] = half


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
