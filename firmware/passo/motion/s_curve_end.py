"""How a segment of an S-curve ends: the largest b that what lies ahead allows, setting out, and coming to rest. The method
stands in s_curve.py.

All may run in an interrupt: no allocation, no integer of 2³⁰.
"""

from passo.motion.integers import divide
from passo.motion.s_curve_ticks import half_ramp, mean
from passo.motion.s_curve_way import at_end, need, ratio
from passo.motion.speed_viper import root_of
from passo.records import *


def choose(state):  # ISR: no allocation
    """The largest b, and q, that the segment may end with."""
    b = state[S_CURVE_B]
    grow = state[S_CURVE_GROW]
    high = state[S_CURVE_LIMIT]
    low = -high
    if b + grow < high:
        high = b + grow
    if b - grow > low:
        low = b - grow
    if low < 0:  # but what can fade till the block's end, or till a stand, in a hold too
        most = state[S_CURVE_GUESS] if state[S_CURVE_ON] or not state[RAMP_CAP] else state[S_CURVE_GUESS] - state[S_CURVE_UNTIL]
        most = -(root_of(most << 7, abs(b) << 7) >> 7) if most > 0 else 0
        if low < most:
            low = most if most < high else high
    q = state[RAMP_Q]
    near = state[RAMP_V]
    room = state[S_CURVE_ROOM]
    above = short = tries = 0
    new = high
    while True:
        aim = state[S_CURVE_AIM] = at_end(state, q, b + new)
        speed = state[S_CURVE_SPEED] = root_of(aim, near)
        lack = need(state, speed, new) - room
        if not tries:
            above = state[S_CURVE_ABOVE]
            short = lack
            if above <= 0 and short <= 0:
                break
            new = low
        else:
            if state[S_CURVE_ABOVE] <= 0 and lack <= 0:
                new = between(state, new, high, above, lack, short)
            elif tries == 1:
                break
            if tries == 2 or high - low <= 500:  # far apart: once more
                state[S_CURVE_AIM] = at_end(state, q, b + new)
                state[S_CURVE_SPEED] = -1
                break
        tries += 1
    state[S_CURVE_B] = new
    state[S_CURVE_BRAKES] = 1 if short > 0 else 0


def between(state, low, high, above, lack, short):  # ISR: no allocation
    """The largest b, were the excesses linear from `low`, just tried, where `lack` is what is short, to `high`."""
    share = 0x4000
    if above > 0:
        share = ratio(-state[S_CURVE_ABOVE], above)
    if short > 0:
        less = ratio(-lack, short)
        if less < share:
            share = less
    return low + ((high - low) * share >> 14)


def set_out(state):  # ISR: no allocation
    """The first step from rest, and its ticks."""
    fast = state[S_CURVE_FAST]
    room = state[S_CURVE_ROOM]
    b = state[S_CURVE_FIRST]
    aim = state[S_CURVE_REST]
    if aim > state[RAMP_CHANGE]:
        aim = state[RAMP_CHANGE]
    speed = root_of(aim, 0)
    even = divide(speed, state[S_CURVE_HALF], 13)
    if speed > fast and need(state, fast, 0) <= room:
        state[S_CURVE_AIM] = state[RAMP_CAP]
        state[S_CURVE_B] = 0
        state[RAMP_TICKS] = mean(state, fast) + half_ramp(state, fast)
        return
    tries = 0
    while tries < 12 and (need(state, speed, b) > room or state[S_CURVE_ABOVE] > 0):
        aim = (aim >> 6) * 41 or 1
        b = b * 41 >> 6
        speed = root_of(aim, 0)
        even = divide(speed, 0x6000, 13)
        tries += 1
    state[S_CURVE_AIM] = aim
    state[S_CURVE_B] = b
    state[RAMP_TICKS] = mean(state, even)


def rest_to_rest(state):  # ISR: no allocation
    """Ticks of a path from rest to rest."""
    rest = state[S_CURVE_REST]
    change = state[RAMP_CHANGE]
    even = divide(root_of(rest if rest < change else change, 0), state[S_CURVE_HALF], 13)
    ticks = mean(state, even)
    ticks += (ticks >> 2) * 3
    fast = state[S_CURVE_FAST] or root_of(state[RAMP_HIGH], 0)
    if fast < even + (even >> 3):
        ticks = mean(state, fast) + 2 * half_ramp(state, fast)
    return ticks


def stop(state):  # ISR: no allocation
    """The ticks of a segment that ends at rest; end() has left the speed before it in _SPEED."""
    q = state[RAMP_BEGIN]
    speed = state[S_CURVE_SPEED]
    change = state[RAMP_CHANGE]
    half = 0x4000
    if q < change:
        part = divide(q >> 8, (change >> 8) + 1, 14)
        half = 0x6000 if part <= 0x3000 else 0x6000 - 2 * (part - 0x3000)
    ticks = mean(state, divide(speed, half, 13))
    least = mean(state, speed) + half_ramp(state, speed)
    if least < ticks:
        ticks = least
    least = rest_to_rest(state)
    state[RAMP_TICKS] = least if least < ticks else ticks
