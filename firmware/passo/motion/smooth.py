"""Ramps with limited jerk (S-curves), for the ramp to use where Limits are given a jerk; else nobody loads this.

    limit(ramp, limits, stride, size)       # of the planner's rows
    ramp.cut_short(…)                       # is the one here from now on, for lines and arcs alike

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
stack, which the main loop's way to an arc's plan leaves little of: cut_short() calls what a segment needs one after the
other, and what one tells the next is in `state`.
"""

from array import array

import micropython
from micropython import const

from passo.motion.block import q_of
from passo.motion.integers import divide, isqrt
from passo.motion.profile import TICKS_PER_S
from passo.motion.ramp_viper import cut
from passo.motion.smooth_units import load, scaled, step_from_rest
from passo.motion.smooth_way import at_end, need, ratio, root_of, step_ticks

_LINE = const(0)  # block.py's, known to the compiler
_HIGHEST = const(0x3FFFFFFF)

# Of a row, as block.py has them.
_TICKS = const(2)
_TICKS_REST = const(3)
_TOP = const(7)
_ROW_LIMIT = const(8)
_GAIN = const(9)
_REACH = const(21)
_EXIT = const(22)
# Of the state. As steady.py and ramp.py have them:
_CUT_STEPS = const(0)
_CUT_TICKS = const(1)
_CUT_PACE = const(2)
_Q = const(3)
_V = const(4)
_START = const(5)
_CARRY = const(6)
_TOTAL = const(7)
_SMOOTH = const(9)
_PATH = const(10)
_TO_GO = const(11)
_PART = const(12)
_CHANGE = const(13)
_CAP = const(14)
_HIGH = const(15)
_BEGIN = const(16)
# Of the block, by load():
_B = const(17)
_RATE = const(18)  # what b grows in a tick: rate / 2 ** rate_shift
_RATE_SHIFT = const(19)
_PUSH = const(20)  # what b does to q in a step: b · push / 2 ** 11
_MOST = const(21)  # b at the highest acceleration
_LIMIT = const(22)  # no b is larger
_W = const(23)  # the speed that acceleration takes to come and go
_SLOW = const(24)  # w is above any speed; then need() is measured otherwise
_SCALE = const(25)  # of need(), a step
_FIRST = const(26)  # b and q after one step from rest; 0: step_from_rest() has not been asked yet
_REST = const(27)
_HALF = const(28)  # of the speed there to its mean one, · 2¹³
_SPARE = const(29)  # what b has grown by less than one
_CRUISE = const(30)  # a steady speed that need() has been asked for, and for which end, and what it has found
_CRUISE_UNTIL = const(31)
_CRUISE_NEED = const(32)
_BEHIND = const(33)  # where the row of the block behind begins
_SPAN = const(34)
# Of the segment:
_UNTIL = const(35)  # speed at the block's end
_ON = const(36)  # slowing down goes on in the block behind
_ROOM = const(37)  # as need() measures it
_FORCE = const(38)
_FAST = const(39)  # the speed wanted
_AIM = const(40)  # q last tried to end with
_SPEED = const(41)  # its root
_ABOVE = const(42)  # how much speed is above the one wanted then
_LEAVE = const(43)  # the block's planned exit, in its units
_WAY = const(44)
_GROW = const(45)  # what b may change by
_GUESS = const(46)  # speed at its end if b stays
_BRAKES = const(47)
# Of the machine: √(jerk / 2) a tick, of a unit of speed of fastest / 2²⁸, root / 2 ** shift; the planner's rows.
_ROOT = const(48)
_SHIFT = const(49)
_STRIDE = const(50)
_SIZE = const(51)
_STATE = const(52)
# Of _WAY.
_STAY = const(0)  # its end is known
_GO_ON = const(1)  # it does not begin at rest
_CHOOSE = const(2)
_SET_OUT = const(3)
_REST_TO_REST = const(4)


def limit(ramp, limits, stride, size):
    """Have `ramp` keep to the jerk of `limits`, nm/s³ along the path (0: any); `stride` and `size`: of a row of the planner's,
    and all. With a jerk the ramp's `state` is longer from now on, and its cut_short() the one here."""
    if not limits.jerk:
        ramp.cut_short = cut
        ramp.smooth = None
        return
    state = ramp.state = array("i", bytearray(4 * _STATE))
    shift = root = 0
    while root < 1 << 14:
        shift += 1
        root = isqrt((limits.jerk << 27 + 2 * shift) // limits.fastest) // TICKS_PER_S
    state[_ROOT] = root
    state[_SHIFT] = shift
    state[_STRIDE] = stride
    state[_SIZE] = size
    state[_B] = 0
    state[_RATE] = 1
    ramp.cut_short = cut_short
    ramp.smooth = load


@micropython.native
def cut_short(rows, at, state, walker, left, percent, hold):  # ISR: no allocation
    """The next segment: what ramp_viper.cut() does up to how fast it ends."""
    cut(rows, at, state, walker, left, percent, hold)
    if state[_SMOOTH] and state[_CUT_STEPS]:  # one after the other: inside each other they would take more stack
        look(rows, at, state)
        if state[_WAY] == _GO_ON:
            set_pace(rows, at, state)
        if state[_WAY] == _CHOOSE:
            choose(state)
        elif state[_WAY] == _SET_OUT:
            set_out(state)
        elif state[_WAY] == _REST_TO_REST:
            state[_CUT_TICKS] = rest_to_rest(state)
        end(rows, at, state)
        if not state[_CUT_TICKS]:
            stop(state)


def look(rows, at, state):  # ISR: no allocation
    """What lies ahead of the segment: the speeds wanted, the room; and how much b may change."""
    q = state[_Q] = state[_BEGIN]
    speed = state[_V]
    start = state[_START]
    cap = state[_CAP]
    togo = state[_TO_GO]
    if togo < 0:
        togo = state[_TO_GO] = state[_PART] = 0
    part = state[_PART]
    leave = q_of(rows[at + _EXIT], rows, at, rows[at + _ROW_LIMIT])
    on = False
    if leave > start:
        behind = state[_BEHIND]
        on = rows[behind + _EXIT] + rows[behind + _REACH] <= rows[at + _EXIT]
    else:
        leave = start
    until = root_of(leave + (leave >> 8), speed)  # units of blocks differ by as much
    fast = speed if cap == q else root_of(cap, speed)
    room = _HIGHEST
    scale = state[_SCALE]
    if togo < _HIGHEST // scale:
        room = gained(scale, togo, part)
        room -= room >> 10
    state[_LEAVE] = leave
    state[_ON] = on
    state[_UNTIL] = until
    state[_FAST] = fast
    state[_ROOM] = room
    if state[_SLOW]:
        path = state[_PATH]
        state[_FORCE] = gained(state[_PUSH], path >> 17, path & 0x1FFFF)
    if q <= start:
        state[_B] = 0
    state[_GROW] = state[_CUT_TICKS] = 0
    state[_SPEED] = -1
    state[_BRAKES] = 1
    state[_WAY] = _GO_ON
    if not speed:
        if not state[_FIRST]:
            step_from_rest(rows[at + _GAIN], state)
        state[_AIM] = leave
        state[_WAY] = _REST_TO_REST if leave == start and not togo and not part else _SET_OUT


def set_pace(rows, at, state):  # ISR: no allocation
    """How much b may change in a segment that does not begin at rest, and a speed to end with if it stays."""
    q = state[_Q]
    speed = state[_V]
    b = state[_B]
    if not b and speed == state[_FAST]:
        room = state[_ROOM]
        until = state[_UNTIL]
        if state[_CRUISE] != speed or state[_CRUISE_UNTIL] != until or state[_ON]:
            state[_CRUISE] = speed
            state[_CRUISE_UNTIL] = until
            state[_ROOM] = _HIGHEST
            state[_CRUISE_NEED] = need(state, speed, 0)
            state[_ROOM] = room
        if state[_CRUISE_NEED] <= room:
            state[_AIM] = q
            state[_SPEED] = speed
            state[_BRAKES] = 0
            state[_WAY] = _STAY
            return
    steps = state[_CUT_STEPS]
    guess = speed
    if steps > 3:
        grow = grown(state, (state[_PATH] >> 12) * step_ticks(state[_SPAN], speed) >> 5)
    else:
        guess = root_of(at_end(state, q, 2 * b), speed)
        grow = grown(state, mean(state, speed + guess >> 1))
        if steps == 1:
            if not state[_FIRST]:
                step_from_rest(rows[at + _GAIN], state)
            if grow > state[_FIRST]:
                grow = state[_FIRST]
    state[_GROW] = grow
    state[_GUESS] = guess
    state[_WAY] = _CHOOSE


def end(rows, at, state):  # ISR: no allocation
    """How fast the segment ends, and how long it takes; 0: stop() has to say."""
    q = state[_Q]
    speed = state[_V]
    cap = state[_CAP]
    high = state[_HIGH]
    change = state[_CHANGE]
    togo = state[_TO_GO]
    part = state[_PART]
    leave = state[_LEAVE]
    aim = state[_AIM]
    b = state[_B]
    ticks = state[_CUT_TICKS]
    stands = leave == state[_START]
    if aim > leave:  # the block's planned end can be reached, whatever the jerk
        most = leave
        if togo or part:
            gain = rows[at + _GAIN]
            most = aim
            if togo <= _HIGHEST // gain:
                room = togo * gain
                more = gained(gain, 0, part)
                if more < aim - leave - room:
                    most = leave + room + more
        if most < aim:
            if q - most >= change:
                b = -state[_LIMIT]
            elif b > 0:
                b = 0
            aim = most
            ticks = 0
    if stands and not togo and not part:
        aim = leave
        b = 0
    elif togo < 8 and aim < q and stands:
        if not state[_FIRST]:
            step_from_rest(rows[at + _GAIN], state)
        least = state[_REST] if togo else gained(state[_REST], 0, part)
        if aim < least:  # slower than it would set out the other way round: that is not worth while
            aim = least if least < q else q
            b = -state[_FIRST] if aim < q else 0
    elif not cap and aim <= q >> 4 and q <= change:
        aim = b = 0
    elif not aim:
        aim = (q >> 4) or 1
    elif aim > q and aim > (high if q <= high else rows[at + _ROW_LIMIT] * rows[at + _ROW_LIMIT]):
        aim = high if q <= high else q
        b = 0
    elif not state[_BRAKES] and abs(b) <= state[_GROW] and abs(aim - cap) <= cap >> 10 and abs(cap - q) <= change:
        aim = cap
        b = 0
    after = state[_SPEED]
    if aim != state[_AIM] or after < 0:
        after = root_of(aim, speed)
    if b < 0 and (b * b >> 7) > after:
        b = -(root_of(after << 7, abs(state[_B]) << 7) >> 7)
    if not ticks:
        if not aim:
            if not state[_FIRST]:
                step_from_rest(rows[at + _GAIN], state)  # stop() is next
        elif q == aim == cap and rows[at] == _LINE and q == rows[at + _TOP] * rows[at + _TOP]:
            steps = state[_CUT_STEPS]
            rest = state[_CARRY] + steps * rows[at + _TICKS_REST]
            state[_CARRY] = rest % state[_TOTAL]
            ticks = steps * rows[at + _TICKS] + rest // state[_TOTAL]
        else:
            ticks = mean(state, speed + after >> 1)
    state[_CUT_TICKS] = ticks
    state[_CUT_PACE] = speed + after >> 8
    state[_SPEED] = speed
    state[_Q] = aim
    state[_V] = after
    state[_B] = b


def choose(state):  # ISR: no allocation
    """The largest b, and q, that the segment may end with."""
    b = state[_B]
    grow = state[_GROW]
    high = state[_LIMIT]
    low = -high
    if b + grow < high:
        high = b + grow
    if b - grow > low:
        low = b - grow
    if low < 0:  # but what can fade till the block's end, or till a stand
        most = state[_GUESS] if state[_ON] else state[_GUESS] - state[_UNTIL]
        most = -(root_of(most << 7, abs(b) << 7) >> 7) if most > 0 else 0
        if low < most:
            low = most if most < high else high
    q = state[_Q]
    near = state[_V]
    room = state[_ROOM]
    above = short = tries = 0
    new = high
    while True:
        aim = state[_AIM] = at_end(state, q, b + new)
        speed = state[_SPEED] = root_of(aim, near)
        lack = need(state, speed, new) - room
        if not tries:
            above = state[_ABOVE]
            short = lack
            if above <= 0 and short <= 0:
                break
            new = low
        else:
            if state[_ABOVE] <= 0 and lack <= 0:
                new = between(state, new, high, above, lack, short)
            elif tries == 1:
                break
            if tries == 2 or high - low <= 500:  # far apart: once more
                state[_AIM] = at_end(state, q, b + new)
                state[_SPEED] = -1
                break
        tries += 1
    state[_B] = new
    state[_BRAKES] = 1 if short > 0 else 0


def between(state, low, high, above, lack, short):  # ISR: no allocation
    """The largest b, were the excesses linear from `low`, just tried, where `lack` is what is short, to `high`."""
    share = 0x4000
    if above > 0:
        share = ratio(-state[_ABOVE], above)
    if short > 0:
        less = ratio(-lack, short)
        if less < share:
            share = less
    return low + ((high - low) * share >> 14)


def mean(state, speed):  # ISR: no allocation
    """Ticks of the segment's path at a mean `speed`."""
    span = state[_SPAN]
    path = state[_PATH]
    speed = speed or 1
    each = step_ticks(span, speed)
    whole = path >> 17
    ticks = whole * each
    if each < 0x80000:
        part = (((span % speed << 6) % speed) << 7) // speed
        ticks += whole * part >> 7
    path &= 0x1FFFF
    if path:
        if each < 0x80000:
            ticks += (path * part >> 24) + ((path >> 7) * each >> 10) + ((path & 127) * each >> 17)
        elif each < 0x800000:
            ticks += path * (each >> 10) >> 7
        else:
            ticks += (path >> 7) * (each >> 10)
    return ticks or 1


def grown(state, ticks):  # ISR: no allocation
    """How much b may change in `ticks`."""
    shift = state[_RATE_SHIFT] - 1
    while ticks >= 0x8000:
        ticks >>= 1
        shift -= 1
    size = ticks * (state[_RATE] >> 1)
    if 0 < shift < 29:  # what is less than one counts later
        size += state[_SPARE] & (1 << shift) - 1
        state[_SPARE] = size
    return scaled(size, -shift) or 1


def gained(gain, steps, part):  # ISR: no allocation
    """gain · (steps + part / 2¹⁷)."""
    if not part:
        return steps * gain
    return steps * gain + (gain >> 17) * part + (((gain & 0x1FFFF) >> 5) * part >> 12)


def half_ramp(state, speed):  # ISR: no allocation
    """Half the ticks that it takes from rest to `speed`."""
    speed >>= 1
    b = root_of(speed << 7, abs(state[_B]) << 7) >> 7
    limit = state[_LIMIT]
    if b > limit:
        b = limit + (speed - (limit * limit >> 7)) * 64 // limit
    shift = state[_RATE_SHIFT] - 14
    while b >= 0x8000:
        b >>= 1
        shift += 1
    return scaled((b << 14) // state[_RATE], shift)


def rest_to_rest(state):  # ISR: no allocation
    """Ticks of a path from rest to rest."""
    rest = state[_REST]
    change = state[_CHANGE]
    even = divide(root_of(rest if rest < change else change, 0), state[_HALF], 13)
    ticks = mean(state, even)
    ticks += (ticks >> 2) * 3
    fast = state[_FAST] or root_of(state[_HIGH], 0)
    if fast < even + (even >> 3):
        ticks = mean(state, fast) + 2 * half_ramp(state, fast)
    return ticks


def set_out(state):  # ISR: no allocation
    """The first step from rest, and its ticks."""
    fast = state[_FAST]
    room = state[_ROOM]
    b = state[_FIRST]
    aim = state[_REST]
    if aim > state[_CHANGE]:
        aim = state[_CHANGE]
    speed = root_of(aim, 0)
    even = divide(speed, state[_HALF], 13)
    if speed > fast and need(state, fast, 0) <= room:
        state[_AIM] = state[_CAP]
        state[_B] = 0
        state[_CUT_TICKS] = mean(state, fast) + half_ramp(state, fast)
        return
    tries = 0
    while tries < 12 and (need(state, speed, b) > room or state[_ABOVE] > 0):
        aim = (aim >> 6) * 41 or 1
        b = b * 41 >> 6
        speed = root_of(aim, 0)
        even = divide(speed, 0x6000, 13)
        tries += 1
    state[_AIM] = aim
    state[_B] = b
    state[_CUT_TICKS] = mean(state, even)


def stop(state):  # ISR: no allocation
    """The ticks of a segment that ends at rest; end() has left the speed before it in _SPEED."""
    q = state[_BEGIN]
    speed = state[_SPEED]
    change = state[_CHANGE]
    half = 0x4000
    if q < change:
        part = divide(q >> 8, (change >> 8) + 1, 14)
        half = 0x6000 if part <= 0x3000 else 0x6000 - 2 * (part - 0x3000)
    ticks = mean(state, divide(speed, half, 13))
    least = mean(state, speed) + half_ramp(state, speed)
    if least < ticks:
        ticks = least
    least = rest_to_rest(state)
    state[_CUT_TICKS] = least if least < ticks else ticks
