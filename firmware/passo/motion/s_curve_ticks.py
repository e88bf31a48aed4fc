"""How long a segment of an S-curve lasts, and what b may change by in that time. The method stands in s_curve.py.

All may run in an interrupt: no allocation, no integer of 2³⁰.
"""

from passo.motion.s_curve_block import scaled
from passo.motion.speed_viper import path_ticks, root_of
from passo.records import *


def mean(state, speed):  # ISR: no allocation
    """Ticks of the segment's path at a mean `speed`."""
    return path_ticks(state[RAMP_PATH], state[S_CURVE_SPAN], speed or 1)


def grown(state, ticks):  # ISR: no allocation
    """How much b may change in `ticks`."""
    shift = state[S_CURVE_RATE_SHIFT] - 1
    while ticks >= 0x8000:
        ticks >>= 1
        shift -= 1
    size = ticks * (state[S_CURVE_RATE] >> 1)
    if 0 < shift < 29:  # what is less than one counts later
        size += state[S_CURVE_SPARE] & (1 << shift) - 1
        state[S_CURVE_SPARE] = size
    return scaled(size, -shift) or 1


def half_ramp(state, speed):  # ISR: no allocation
    """Half the ticks that it takes from rest to `speed`."""
    speed >>= 1
    b = root_of(speed << 7, abs(state[S_CURVE_B]) << 7) >> 7
    limit = state[S_CURVE_LIMIT]
    if b > limit:
        b = limit + (speed - (limit * limit >> 7)) * 64 // limit
    shift = state[S_CURVE_RATE_SHIFT] - 14
    while b >= 0x8000:
        b >>= 1
        shift += 1
    return scaled((b << 14) // state[S_CURVE_RATE], shift)
