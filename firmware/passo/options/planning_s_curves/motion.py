"""Ramps with limited jerk (S-curves), for the ramp to use where Limits are given a jerk; else nobody loads this.

    limit(ramp, limits, stride, size)       # of the planner's rows
    ramp.accelerated(…)                     # is the one here from now on, for lines and arcs alike

The planner's speeds at the ends of blocks stay those of trapezoids. Along with the speed, the acceleration goes from segment to segment, on
into the next block; it changes by jerk × time at most. It is kept as b, the square root of the speed that would come on top while it fades:
b² = a² / 2J, which grows evenly in time, and v + b² is where a speeding up ends that begins to fade now. A segment ends with the largest b
that

    - neither exceeds the acceleration nor leads above the block's speed, or the override's, or, in a hold, 0
    - leaves room to slow down to the block's planned exit u, by an S-curve: with w = A² / J and V = v + b², the way is
      that to the top of the curve, ±(V − b²/3) · b · √(2w) / A, and (V + u) · T / 2A from there, T = V − u + w, or
      2 · √(w · (V − u)) where the whole of A is never asked for

These hold: acceleration always within the limits, ends and planned speeds as exact as without. Jerk within the limit where a ramp lies
inside a block, in holds, and in speeding up over any number of blocks. If slowing down takes several blocks it goes on from one to the next
at full acceleration, but sets in, and fades at the stand, only as gently as the first and the last of them have room for; there, and if
motion sets out again before it has stood, the acceleration's limit alone counts. A jerk that is reached within a step or so makes no
difference to none.

All but limit() may run in an interrupt: no allocation, no integer of 2³⁰. There a level of calls costs some 250 bytes of stack, which the
main loop's way to an arc's plan leaves little of: cut_s_curve() calls the functions of a segment one after the other, and one leaves its
results for the next in `state`.
"""

from array import array

import micropython

from passo.motion.integers import divide, isqrt
from passo.motion.ramp_viper import cut
from passo.options.planning_s_curves.motion_block import at_end, b_change, half_ramp, load, mean, need, ratio, step_from_rest
from passo.motion.speed_viper import q_change, q_of, root_of, step_ticks
from passo.options.planning_s_curves.records import *
from passo.records import *


def limit(ramp, limits, stride, size):
    """Have `ramp` keep to the jerk of `limits`, nm/s³ along the path (0: any); `stride` and `size`: of a row of the planner's,
    and all. With a jerk the ramp's `state` is longer from now on, and cut_s_curve() cuts accelerated blocks."""
    if not limits.jerk:
        ramp.accelerated = cut
        ramp.s_curve = None
        return
    state = ramp.state = array("i", bytearray(4 * S_CURVE_FIELDS))
    shift = root = 0
    while root < 1 << 14:
        shift += 1
        root = isqrt((limits.jerk << 27 + 2 * shift) // limits.fastest) // TICKS_PER_S
    state[S_CURVE_ROOT] = root
    state[S_CURVE_SHIFT] = shift
    state[S_CURVE_STRIDE] = stride
    state[S_CURVE_ROWS] = size
    state[S_CURVE_RATE] = 1
    ramp.accelerated = cut_s_curve
    ramp.s_curve = load


@micropython.native
def cut_s_curve(rows, at, state, walker, left, percent, hold):  # ISR: no allocation
    """Cut the next segment: as ramp_viper.cut(), but for the speed at its end."""
    cut(rows, at, state, walker, left, percent, hold)
    if state[RAMP_S_CURVE] and state[RAMP_STEPS]:  # one after the other: inside each other they would take more stack
        look(rows, at, state)
        if not state[RAMP_V]:
            step_from_rest(rows, at, state)
            set_out(state)
        elif set_pace(rows, at, state):
            choose(state)
        end(rows, at, state)
        finish(rows, at, state)
        if not state[RAMP_TICKS]:
            step_from_rest(rows, at, state)
            stop(state)


def look(rows, at, state):  # ISR: no allocation
    """Find the speeds wanted ahead of the segment, and the room for them."""
    q = state[RAMP_Q] = state[RAMP_BEGIN]
    speed = state[RAMP_V]
    start = state[RAMP_START]
    cap = state[RAMP_CAP]
    togo = state[RAMP_TO_GO]
    if togo < 0:
        togo = state[RAMP_TO_GO] = state[RAMP_PART] = 0
    part = state[RAMP_PART]
    behind = state[S_CURVE_BEHIND]
    leave = max(q_of(rows[at + ROW_EXIT], rows, at, rows[at + ROW_LIMIT]), start)
    until = root_of(leave + (leave >> 8), speed)  # units of blocks differ by as much
    fast = speed if cap == q else root_of(cap, speed)
    room = INT_MOST
    scale = state[S_CURVE_SCALE]
    if togo < INT_MOST // scale:
        room = q_change(scale, togo, part)
        room -= room >> 10
    state[S_CURVE_LEAVE] = leave
    state[S_CURVE_ON] = leave > start and rows[behind + ROW_EXIT] + rows[behind + ROW_REACH] <= rows[at + ROW_EXIT]
    state[S_CURVE_UNTIL] = until
    state[S_CURVE_FAST] = fast
    state[S_CURVE_ROOM] = room
    if state[S_CURVE_SLOW]:
        path = state[RAMP_PATH]
        state[S_CURVE_FORCE] = q_change(state[S_CURVE_PUSH], path >> 17, path & 0x1FFFF)
    if q <= start:
        state[S_CURVE_B] = 0
    state[S_CURVE_GROW] = state[RAMP_TICKS] = 0
    state[S_CURVE_SPEED] = -1
    state[S_CURVE_BRAKES] = 1


def set_pace(rows, at, state):  # ISR: no allocation
    """How much b may change in a segment that does not begin at rest, and a speed to end with if it stays. False if the speed
    stays: then its end is known."""
    q = state[RAMP_Q]
    speed = state[RAMP_V]
    b = state[S_CURVE_B]
    if not b and speed == state[S_CURVE_FAST]:
        room = state[S_CURVE_ROOM]
        until = state[S_CURVE_UNTIL]
        if state[S_CURVE_CRUISE] != speed or state[S_CURVE_CRUISE_UNTIL] != until or state[S_CURVE_ON]:
            state[S_CURVE_CRUISE] = speed
            state[S_CURVE_CRUISE_UNTIL] = until
            state[S_CURVE_ROOM] = INT_MOST
            state[S_CURVE_CRUISE_NEED] = need(state, speed, 0)
            state[S_CURVE_ROOM] = room
        if state[S_CURVE_CRUISE_NEED] <= room:
            state[S_CURVE_AIM] = q
            state[S_CURVE_SPEED] = speed
            state[S_CURVE_BRAKES] = 0
            return False
    steps = state[RAMP_STEPS]
    guess = speed
    after = at_end(state, q, 2 * b)
    if steps > 3 and abs(after - q) < q >> 5:
        grow = b_change(state, (state[RAMP_PATH] >> 12) * step_ticks(state[S_CURVE_SPAN], speed) >> 5)
    else:  # it lasts less than at the speed of its beginning, by a third near rest, or more if it slows down
        then = root_of(after, speed)
        grow = b_change(state, mean(state, speed + then >> 1))
        if steps <= 3:
            guess = then
        if steps == 1:
            step_from_rest(rows, at, state)
            grow = min(grow, state[S_CURVE_FIRST])
    state[S_CURVE_GROW] = grow
    state[S_CURVE_GUESS] = guess
    return True


def choose(state):  # ISR: no allocation
    """The largest b, and q, that the segment may end with."""
    b = state[S_CURVE_B]
    grow = state[S_CURVE_GROW]
    high = min(state[S_CURVE_LIMIT], b + grow)
    low = max(-state[S_CURVE_LIMIT], b - grow)
    if low < 0:  # but only as much as can fade till the block's end, or till a stand, in a hold too
        most = state[S_CURVE_GUESS] if state[S_CURVE_ON] or not state[RAMP_CAP] else state[S_CURVE_GUESS] - state[S_CURVE_UNTIL]
        most = -(root_of(most << 7, abs(b) << 7) >> 7) if most > 0 else 0
        low = max(low, min(most, high))
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
    """Return the largest b, were the excesses linear from `low`, just tried, where `lack` is what is short, to `high`."""
    share = ratio(-state[S_CURVE_ABOVE], above) if above > 0 else 0x4000
    if short > 0:
        share = min(share, ratio(-lack, short))
    return low + ((high - low) * share >> 14)


def set_out(state):  # ISR: no allocation
    """The first step from rest, and its ticks."""
    if state[S_CURVE_LEAVE] == state[RAMP_START] and not state[RAMP_TO_GO] and not state[RAMP_PART]:
        state[S_CURVE_AIM] = state[S_CURVE_LEAVE]
        state[RAMP_TICKS] = rest_to_rest(state)
        return
    fast = state[S_CURVE_FAST]
    room = state[S_CURVE_ROOM]
    b = state[S_CURVE_FIRST]
    half = state[S_CURVE_HALF]
    aim = min(state[S_CURVE_REST], state[RAMP_CHANGE])
    speed = root_of(aim, 0)
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
        half = 0x6000
        tries += 1
    state[S_CURVE_AIM] = aim
    state[S_CURVE_B] = b
    state[RAMP_TICKS] = mean(state, divide(speed, half, 13))


def rest_to_rest(state):  # ISR: no allocation
    """Return the ticks of a path from rest to rest."""
    even = divide(root_of(min(state[S_CURVE_REST], state[RAMP_CHANGE]), 0), state[S_CURVE_HALF], 13)
    ticks = mean(state, even)
    ticks += (ticks >> 2) * 3
    fast = state[S_CURVE_FAST] or root_of(state[RAMP_HIGH], 0)
    if fast < even + (even >> 3):
        ticks = mean(state, fast) + 2 * half_ramp(state, fast)
    return ticks


def end(rows, at, state):  # ISR: no allocation
    """End the segment with choose()'s speed, or with the one that comes before it: the block's planned end, a stand, the speed wanted."""
    q = state[RAMP_Q]
    cap = state[RAMP_CAP]
    high = state[RAMP_HIGH]
    change = state[RAMP_CHANGE]
    togo = state[RAMP_TO_GO]
    part = state[RAMP_PART]
    leave = state[S_CURVE_LEAVE]
    aim = state[S_CURVE_AIM]
    b = state[S_CURVE_B]
    ticks = state[RAMP_TICKS]
    stands = leave == state[RAMP_START]
    gain = rows[at + ROW_GAIN]
    if aim > leave and togo <= INT_MOST // gain:  # the block's planned end can be reached, whatever the jerk
        room = togo * gain
        more = q_change(gain, 0, part)
        if more < aim - leave - room:
            aim = leave + room + more
            if q - aim >= change:
                b = -state[S_CURVE_LIMIT]
            elif b > 0:
                b = 0
            ticks = 0
    if stands and not togo and not part:
        aim = leave
        b = 0
    elif togo < 8 and aim < q and stands:
        step_from_rest(rows, at, state)
        least = state[S_CURVE_REST] if togo else q_change(state[S_CURVE_REST], 0, part)
        if aim < least:  # slower than it would set out the other way round: that is not worth while
            aim = min(least, q)
            b = -state[S_CURVE_FIRST] if aim < q else 0
    elif not cap and aim <= q >> 4 and q <= change:
        aim = b = 0
    elif not aim:
        aim = (q >> 4) or 1
    elif aim > q and aim > (high if q <= high else rows[at + ROW_LIMIT] * rows[at + ROW_LIMIT]):
        aim = high if q <= high else q
        b = 0
    elif not state[S_CURVE_BRAKES] and abs(b) <= state[S_CURVE_GROW] and abs(aim - cap) <= cap >> 10 and abs(cap - q) <= change:
        aim = cap
        b = 0
    if aim != state[S_CURVE_AIM]:
        state[S_CURVE_AIM] = aim
        state[S_CURVE_SPEED] = -1
    state[S_CURVE_B] = b
    state[RAMP_TICKS] = ticks


def finish(rows, at, state):  # ISR: no allocation
    """The segment ends with S_CURVE_AIM and S_CURVE_B: its speed there, and its ticks unless they are known; 0 at a stand: call stop()."""
    q = state[RAMP_Q]
    speed = state[RAMP_V]
    aim = state[S_CURVE_AIM]
    b = state[S_CURVE_B]
    ticks = state[RAMP_TICKS]
    after = state[S_CURVE_SPEED]
    if after < 0:
        after = root_of(aim, speed)
    if b < 0 and (b * b >> 7) > after:
        b = -(root_of(after << 7, -b << 7) >> 7)
    if aim and not ticks:
        if q == aim == state[RAMP_CAP] and rows[at + ROW_KIND] == KIND_LINE and q == rows[at + ROW_TOP] * rows[at + ROW_TOP]:
            steps = state[RAMP_STEPS]
            rest = state[RAMP_CARRY] + steps * rows[at + ROW_TICKS_REST]
            state[RAMP_CARRY] = rest % state[RAMP_TOTAL]
            ticks = steps * rows[at + ROW_TICKS] + rest // state[RAMP_TOTAL]
        else:
            ticks = mean(state, speed + after >> 1)
    state[RAMP_TICKS] = ticks
    state[RAMP_PACE] = speed + after >> 8
    state[S_CURVE_SPEED] = speed
    state[RAMP_Q] = aim
    state[RAMP_V] = after
    state[S_CURVE_B] = b


def stop(state):  # ISR: no allocation
    """The ticks of a segment that ends at rest; finish() has left the speed before it in S_CURVE_SPEED."""
    q = state[RAMP_BEGIN]
    speed = state[S_CURVE_SPEED]
    change = state[RAMP_CHANGE]
    half = 0x4000
    if q < change:
        part = divide(q >> 8, (change >> 8) + 1, 14)
        half = 0x6000 if part <= 0x3000 else 0x6000 - 2 * (part - 0x3000)
    ticks = min(mean(state, divide(speed, half, 13)), mean(state, speed) + half_ramp(state, speed))
    state[RAMP_TICKS] = min(ticks, rest_to_rest(state))
