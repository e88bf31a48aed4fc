"""Ramps with limited jerk (S-curves), for the ramp to use where Limits are given a jerk; else nobody loads this.

    limit(ramp, limits, stride, size)       # of the planner's rows
    ramp.accelerated(…)                     # is the one here from now on, for lines and arcs alike

The planner's speeds at the ends of blocks stay those of trapezoids. What goes with the speed from segment to segment, on
into the next block, is the acceleration, which changes by jerk × time at most. It is kept as b, the square root of the
speed that would come on top while it fades: b² = a² / 2J, which grows evenly in time, and v + b² is where a speeding up
ends that begins to fade now. A segment ends with the largest b that

    - neither exceeds the acceleration nor leads above the block's speed, or the override's, or, in a hold, 0
    - leaves room to slow down to the block's planned exit u, by an S-curve: with w = A² / J and V = v + b², the way is
      that to the top of the curve, ±(V − b²/3) · b · √(2w) / A, and (V + u) · T / 2A from there, T = V − u + w, or
      2 · √(w · (V − u)) where the whole of A is never asked for

What holds: acceleration always within the limits, ends and planned speeds as exact as without. Jerk within the limit
where a ramp lies inside a block, in holds, and in speeding up over any number of blocks. Where slowing down takes several
blocks it goes on from one to the next at full acceleration, but sets in, and fades at the stand, only as gently as the
first and the last of them have room for; there, and where motion sets out again before it has stood, the acceleration's
limit alone counts. A jerk that is reached within a step or so makes no difference to none.

All but limit() may run in an interrupt: no allocation, no integer of 2³⁰. There a level of calls costs some 250 bytes of
stack, which the main loop's way to an arc's plan leaves little of: cut_s_curve() calls what a segment needs one after the
other, and what one tells the next is in `state`.
"""

from array import array

import micropython
from micropython import const

from passo.motion.block import LINE
from passo.motion.integers import isqrt
from passo.motion.ramp_viper import cut
from passo.motion.s_curve_block import load, step_from_rest
from passo.motion.s_curve_end import choose, rest_to_rest, set_out, stop
from passo.motion.s_curve_ticks import grown, mean
from passo.motion.s_curve_way import at_end, need
from passo.motion.speed_viper import gained, q_of, root_of, step_ticks
from passo.records import *


# S_CURVE_WAY.
_STAY = const(0)  # its end is known
_GO_ON = const(1)  # it does not begin at rest
_CHOOSE = const(2)
_SET_OUT = const(3)
_REST_TO_REST = const(4)


def limit(ramp, limits, stride, size):
    """Have `ramp` keep to the jerk of `limits`, nm/s³ along the path (0: any); `stride` and `size`: of a row of the planner's,
    and all. With a jerk the ramp's `state` is longer from now on, and what cuts accelerated blocks is the one here."""
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
    state[S_CURVE_B] = 0
    state[S_CURVE_RATE] = 1
    ramp.accelerated = cut_s_curve
    ramp.s_curve = load


@micropython.native
def cut_s_curve(rows, at, state, walker, left, percent, hold):  # ISR: no allocation
    """The next segment: what ramp_viper.cut() does up to how fast it ends."""
    cut(rows, at, state, walker, left, percent, hold)
    if state[RAMP_S_CURVE] and state[RAMP_STEPS]:  # one after the other: inside each other they would take more stack
        look(rows, at, state)
        if state[S_CURVE_WAY] == _GO_ON:
            set_pace(rows, at, state)
        if state[S_CURVE_WAY] == _CHOOSE:
            choose(state)
        elif state[S_CURVE_WAY] == _SET_OUT:
            set_out(state)
        elif state[S_CURVE_WAY] == _REST_TO_REST:
            state[RAMP_TICKS] = rest_to_rest(state)
        end(rows, at, state)
        finish(rows, at, state)
        if not state[RAMP_TICKS]:
            stop(state)


def look(rows, at, state):  # ISR: no allocation
    """What lies ahead of the segment: the speeds wanted, the room; and how much b may change."""
    q = state[RAMP_Q] = state[RAMP_BEGIN]
    speed = state[RAMP_V]
    start = state[RAMP_START]
    cap = state[RAMP_CAP]
    togo = state[RAMP_TO_GO]
    if togo < 0:
        togo = state[RAMP_TO_GO] = state[RAMP_PART] = 0
    part = state[RAMP_PART]
    leave = q_of(rows[at + ROW_EXIT], rows, at, rows[at + ROW_LIMIT])
    on = False
    if leave > start:
        behind = state[S_CURVE_BEHIND]
        on = rows[behind + ROW_EXIT] + rows[behind + ROW_REACH] <= rows[at + ROW_EXIT]
    else:
        leave = start
    until = root_of(leave + (leave >> 8), speed)  # units of blocks differ by as much
    fast = speed if cap == q else root_of(cap, speed)
    room = INT_MOST
    scale = state[S_CURVE_SCALE]
    if togo < INT_MOST // scale:
        room = gained(scale, togo, part)
        room -= room >> 10
    state[S_CURVE_LEAVE] = leave
    state[S_CURVE_ON] = on
    state[S_CURVE_UNTIL] = until
    state[S_CURVE_FAST] = fast
    state[S_CURVE_ROOM] = room
    if state[S_CURVE_SLOW]:
        path = state[RAMP_PATH]
        state[S_CURVE_FORCE] = gained(state[S_CURVE_PUSH], path >> 17, path & 0x1FFFF)
    if q <= start:
        state[S_CURVE_B] = 0
    state[S_CURVE_GROW] = state[RAMP_TICKS] = 0
    state[S_CURVE_SPEED] = -1
    state[S_CURVE_BRAKES] = 1
    state[S_CURVE_WAY] = _GO_ON
    if not speed:
        if not state[S_CURVE_FIRST]:
            step_from_rest(rows[at + ROW_GAIN], state)
        state[S_CURVE_AIM] = leave
        state[S_CURVE_WAY] = _REST_TO_REST if leave == start and not togo and not part else _SET_OUT


def set_pace(rows, at, state):  # ISR: no allocation
    """How much b may change in a segment that does not begin at rest, and a speed to end with if it stays."""
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
            state[S_CURVE_WAY] = _STAY
            return
    steps = state[RAMP_STEPS]
    guess = speed
    if steps > 3:
        grow = grown(state, (state[RAMP_PATH] >> 12) * step_ticks(state[S_CURVE_SPAN], speed) >> 5)
    else:
        guess = root_of(at_end(state, q, 2 * b), speed)
        grow = grown(state, mean(state, speed + guess >> 1))
        if steps == 1:
            if not state[S_CURVE_FIRST]:
                step_from_rest(rows[at + ROW_GAIN], state)
            if grow > state[S_CURVE_FIRST]:
                grow = state[S_CURVE_FIRST]
    state[S_CURVE_GROW] = grow
    state[S_CURVE_GUESS] = guess
    state[S_CURVE_WAY] = _CHOOSE


def end(rows, at, state):  # ISR: no allocation
    """What choose() has found, or what comes before it: the block's planned end, a stand, the speed wanted."""
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
    if aim > leave:  # the block's planned end can be reached, whatever the jerk
        most = leave
        if togo or part:
            gain = rows[at + ROW_GAIN]
            most = aim
            if togo <= INT_MOST // gain:
                room = togo * gain
                more = gained(gain, 0, part)
                if more < aim - leave - room:
                    most = leave + room + more
        if most < aim:
            if q - most >= change:
                b = -state[S_CURVE_LIMIT]
            elif b > 0:
                b = 0
            aim = most
            ticks = 0
    if stands and not togo and not part:
        aim = leave
        b = 0
    elif togo < 8 and aim < q and stands:
        if not state[S_CURVE_FIRST]:
            step_from_rest(rows[at + ROW_GAIN], state)
        least = state[S_CURVE_REST] if togo else gained(state[S_CURVE_REST], 0, part)
        if aim < least:  # slower than it would set out the other way round: that is not worth while
            aim = least if least < q else q
            b = -state[S_CURVE_FIRST] if aim < q else 0
    elif not cap and aim <= q >> 4 and q <= change:
        aim = b = 0
    elif not aim:
        aim = (q >> 4) or 1
    elif aim > q and aim > (high if q <= high else rows[at + ROW_LIMIT] * rows[at + ROW_LIMIT]):
        aim = high if q <= high else q
        b = 0
    elif not state[S_CURVE_BRAKES] and abs(b) <= state[S_CURVE_GROW]:
        if abs(aim - cap) <= cap >> 10 and abs(cap - q) <= change:
            aim = cap
            b = 0
    if aim != state[S_CURVE_AIM]:
        state[S_CURVE_AIM] = aim
        state[S_CURVE_SPEED] = -1
    state[S_CURVE_B] = b
    state[RAMP_TICKS] = ticks


def finish(rows, at, state):  # ISR: no allocation
    """The segment ends with S_CURVE_AIM and S_CURVE_B: its speed there, and its ticks unless they are known; 0: stop() is to say."""
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
    if not ticks:
        if not aim:
            if not state[S_CURVE_FIRST]:
                step_from_rest(rows[at + ROW_GAIN], state)  # stop() is next
        elif q == aim == state[RAMP_CAP] and rows[at + ROW_KIND] == LINE and q == rows[at + ROW_TOP] * rows[at + ROW_TOP]:
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
