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

All but limit() may run in an interrupt: no allocation, no integer of 2³⁰. On a chip's they would take more stack than there
is beside a main loop that plans an arc: Program.curves keeps them out there.
"""

from array import array

from micropython import const

from passo.motion.block import q_of
from passo.motion.integers import divide, isqrt
from passo.motion.profile import TICKS_PER_S
from passo.motion.ramp_viper import cut
from passo.motion.smooth_units import load, scaled, step_from_rest
from passo.motion.smooth_way import at_end, attempt, judge, need, ratio, root_of, step_ticks

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
# Of the machine: √(jerk / 2) a tick, of a unit of speed of fastest / 2²⁸, root / 2 ** shift; the planner's rows.
_ROOT = const(43)
_SHIFT = const(44)
_STRIDE = const(45)
_SIZE = const(46)
_STATE = const(47)


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


def cut_short(rows, at, state, walker, left, percent, hold):  # ISR: no allocation
    """The next segment: what ramp_viper.cut() does up to how fast it ends."""
    cut(rows, at, state, walker, left, percent, hold)
    if state[_SMOOTH] and state[_CUT_STEPS]:
        end(rows, at, state)


def end(rows, at, state):  # ISR: no allocation
    """How fast the segment ends, and how long it takes."""
    q = state[_Q] = state[_BEGIN]
    speed = state[_V]
    start = state[_START]
    cap = state[_CAP]
    high = state[_HIGH]
    change = state[_CHANGE]
    steps = state[_CUT_STEPS]
    togo = state[_TO_GO]
    part = state[_PART]
    if togo < 0:
        togo = part = 0
    ends = not togo and not part
    leave = q_of(rows[at + _EXIT], rows, at, rows[at + _ROW_LIMIT])
    on = False
    if leave > start:
        behind = state[_BEHIND]
        on = rows[behind + _EXIT] + rows[behind + _REACH] <= rows[at + _EXIT]
    else:
        leave = start
    stands = ends and leave == start
    # What lies ahead: the speeds wanted, and the room.
    until = root_of(leave + (leave >> 8), speed)  # units of blocks differ by as much
    fast = speed if cap == q else root_of(cap, speed)
    room = _HIGHEST
    scale = state[_SCALE]
    if togo < _HIGHEST // scale:
        room = gained(scale, togo, part)
        room -= room >> 10
    state[_ON] = on
    state[_UNTIL] = until
    state[_FAST] = fast
    state[_ROOM] = room
    if state[_SLOW]:
        path = state[_PATH]
        state[_FORCE] = gained(state[_PUSH], path >> 17, path & 0x1FFFF)
    b = 0 if q <= start else state[_B]
    state[_B] = b
    ticks = grow = 0
    after = -1
    brakes = True
    if not speed:
        ticks = set_out(rows[at + _GAIN], state, leave, stands)
        aim = state[_AIM]
        b = state[_B]
    else:
        aim = q
        if not b and speed == fast:
            if state[_CRUISE] != speed or state[_CRUISE_UNTIL] != until or on:
                state[_CRUISE] = speed
                state[_CRUISE_UNTIL] = until
                state[_CRUISE_NEED] = need(state, speed, 0)
            brakes = state[_CRUISE_NEED] > room
        if brakes:
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
            brakes = choose(state, b, grow, guess)
            aim = state[_AIM]
            after = state[_SPEED]
            b = state[_B]
        else:
            after = speed
    found = aim
    if aim > leave:  # the block's planned end can be reached, whatever the jerk
        most = leave
        if not ends:
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
    if stands:
        aim = leave
        b = 0
    elif togo < 8 and aim < q and leave == start:
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
    elif not brakes and abs(b) <= grow and abs(aim - cap) <= cap >> 10 and abs(cap - q) <= change:
        aim = cap
        b = 0
    if aim != found or after < 0:
        after = root_of(aim, speed)
    if b < 0 and (b * b >> 7) > after:
        b = -fading(state, after)
    if not ticks:
        if not aim:
            ticks = last(rows[at + _GAIN], state, leave)
        elif q == aim == cap and rows[at] == _LINE and q == rows[at + _TOP] * rows[at + _TOP]:
            rest = state[_CARRY] + steps * rows[at + _TICKS_REST]
            state[_CARRY] = rest % state[_TOTAL]
            ticks = steps * rows[at + _TICKS] + rest // state[_TOTAL]
        else:
            ticks = mean(state, speed + after >> 1)
    state[_CUT_TICKS] = ticks
    state[_CUT_PACE] = speed + after >> 8
    state[_Q] = aim
    state[_V] = after
    state[_B] = b


def choose(state, b, grow, guess):  # ISR: no allocation
    """The largest b, and q, that a segment may end with, from b; `guess`: a speed to end with if that stays. True where it
    has to brake."""
    high = state[_LIMIT]
    low = -high
    if b + grow < high:
        high = b + grow
    if b - grow > low:
        low = b - grow
    if low < 0:  # but what can fade till the block's end, or till a stand
        most = guess if state[_ON] else guess - state[_UNTIL]
        most = -fading(state, most) if most > 0 else 0
        if low < most:
            low = most if most < high else high
    short = attempt(state, b, high)
    above = state[_ABOVE]
    new = high
    if above > 0 or short > 0:
        lack = attempt(state, b, low)
        new = low
        if state[_ABOVE] <= 0 and lack <= 0:
            new = between(state, low, high, above, lack, short)
            if high - low > 500:  # far apart: once more
                lack = attempt(state, b, new)
                if state[_ABOVE] <= 0 and lack <= 0:
                    new = between(state, new, high, above, lack, short)
            state[_AIM] = at_end(state, state[_Q], b + new)
            state[_SPEED] = -1
    state[_B] = new
    return short > 0


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


def fading(state, speed):  # ISR: no allocation
    """b that fades in just `speed`."""
    return root_of(speed << 7, abs(state[_B]) << 7) >> 7


def half_ramp(state, speed):  # ISR: no allocation
    """Half the ticks that it takes from rest to `speed`."""
    speed >>= 1
    b = fading(state, speed)
    limit = state[_LIMIT]
    if b > limit:
        b = limit + (speed - (limit * limit >> 7)) * 64 // limit
    shift = state[_RATE_SHIFT] - 14
    while b >= 0x8000:
        b >>= 1
        shift += 1
    return scaled((b << 14) // state[_RATE], shift)


def set_out(gain, state, leave, stands):  # ISR: no allocation
    """Ticks of the first step from rest; `stands`: to rest, too."""
    if not state[_FIRST]:
        step_from_rest(gain, state)
    fast = state[_FAST]
    aim = state[_REST]
    if aim > state[_CHANGE]:
        aim = state[_CHANGE]
    b = state[_FIRST]
    speed = root_of(aim, 0)
    even = divide(speed, state[_HALF], 13)
    if stands:
        state[_AIM] = leave
        ticks = mean(state, even)
        ticks += (ticks >> 2) * 3
        fast = fast or root_of(state[_HIGH], 0)
        if fast < even + (even >> 3):
            ticks = mean(state, fast) + 2 * half_ramp(state, fast)
        return ticks
    if speed > fast and judge(state, fast, 0) <= 0:
        state[_AIM] = state[_CAP]
        state[_B] = 0
        return mean(state, fast) + half_ramp(state, fast)
    tries = 0
    while tries < 12 and (judge(state, speed, b) > 0 or state[_ABOVE] > 0):
        aim = (aim >> 6) * 41 or 1
        b = b * 41 >> 6
        speed = root_of(aim, 0)
        even = divide(speed, 0x6000, 13)
        tries += 1
    state[_AIM] = aim
    state[_B] = b
    return mean(state, even)


def last(gain, state, leave):  # ISR: no allocation
    """Ticks of a path that ends at rest, none of them slower than need be."""
    q = state[_Q]
    speed = state[_V]
    change = state[_CHANGE]
    half = 0x4000
    if q < change:
        part = divide(q >> 8, (change >> 8) + 1, 14)
        half = 0x6000 if part <= 0x3000 else 0x6000 - 2 * (part - 0x3000)
    ticks = mean(state, divide(speed, half, 13))
    least = mean(state, speed) + half_ramp(state, speed)
    if least < ticks:
        ticks = least
    least = set_out(gain, state, leave, True)
    return ticks if ticks < least else least
