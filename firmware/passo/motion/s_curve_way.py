"""How far it is to slow down from a speed and an acceleration to the end of a block, by an S-curve. The method stands in
s_curve.py, the fields of `state` in records.py.

All may run in an interrupt: no allocation, no integer of 2³⁰. A function that comes many times a segment is machine code
on a board; see block_viper.py for what that asks.
"""

import micropython

from passo.motion.integers import divide
from passo.motion.speed_viper import root_of
from passo.records import *


@micropython.viper
def ratio(part: int, other: int) -> int:  # ISR: no allocation
    """part / (part + other), of 2¹⁴; both ≥ 0."""
    while part >= 0x4000 or other >= 0x4000:
        part >>= 1
        other >>= 1
    other += part
    return (part << 14) // (other if other else 1)


def need(state, fast, b):  # ISR: no allocation
    """Room, as S_CURVE_ROOM, to slow down to the block's end from the speed `fast` with b. S_CURVE_ABOVE: what is too fast."""
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
    """q after the segment in which b is `double` / 2 on the average."""
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
