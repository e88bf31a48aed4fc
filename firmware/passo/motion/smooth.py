"""Ramps with limited jerk (S-curves), for the ramp to use where Limits are given a jerk; else nobody loads this.

    smooth = Smooth(limits)
    smooth.load(rows, at, behind)                         # the block whose row begins at rows[at], and the one behind it
    smooth.cut(ramp, q, steps, path, togo, part, change, cap, high)    # instead of the trapezoid's segment

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

All but the constructor may run in an interrupt: no allocation, no integer of 2³⁰.
"""

from micropython import const

from passo.motion.block import EXIT, REACH
from passo.motion.integers import divide
from passo.motion.ramp_ticks import gained, path_ticks, root_of
from passo.motion.smooth_units import ratio
from passo.motion.smooth_way import Way
from passo.motion.steady import CUT_PACE, CUT_STEPS, CUT_TICKS, Q, V

_V_BITS = const(7)  # ramp_ticks.V_BITS, known to the compiler
_HIGHEST = const(0x3FFFFFFF)


class Smooth(Way):
    def cut(self, ramp, q, steps, path, togo, part, change, cap, high):  # ISR: no allocation
        """End the ramp's segment of `steps` (`path`, 2⁻¹⁷ steps), which begins at q: with `togo` and `part` steps behind it,
        a `change` of q at most and `cap` the q wanted, in a hold 0, else `high`. All is as in Ramp._cut_ramp()."""
        block = ramp._block
        leave = block.leave
        state = ramp.state
        speed = state[V]
        ends = togo < 0 or not togo and not part
        stands = ends and leave <= block.start
        self._look(speed, q, cap, leave, block.start, togo, part)
        if self._slow:
            self._force = gained(self._push, path >> 17, path & 0x1FFFF)
        self._change = change
        self._high = high
        if q <= block.start:
            self.b = 0
        self._ticks = 0
        if speed:
            self._choose(ramp, q, self.b, steps, path)
        else:
            self._set_out(ramp, path, stands)
        self._keep(q, leave, block.gain, togo, part, ends)
        aim = self._aim
        b = self._b
        if stands:
            aim = leave
            b = 0
        elif leave <= block.start and togo < 8 and aim < q:
            least = self._rest if togo else gained(self._rest, 0, part)
            if aim < least:  # slower than it would set out the other way round: that is not worth while
                aim = least if least < q else q
                b = -self._first if aim < q else 0
        elif not cap and aim <= q >> 4 and q <= change:
            aim = b = 0
        elif not aim:
            aim = (q >> 4) or 1
        elif aim > q and aim > (high if q <= high else block.limit * block.limit):
            aim = high if q <= high else q
            b = 0
        elif not self._brakes and abs(b) <= self._grow and abs(aim - cap) <= cap >> 10 and abs(cap - q) <= change:
            aim = cap
            b = 0
        after = self._speed if aim == self._tried else root_of(aim, speed)
        if b < 0 and (b * b >> _V_BITS) > after:
            b = -self._fading(after)
        ticks = self._ticks
        if not ticks:
            if not aim:
                ticks = self._last(ramp, q, path, change)
            elif q == aim == cap and q == block.top * block.top and not ramp._arc:
                ticks = ramp._nominal(steps)
            else:
                ticks = self._mean(ramp, path, speed + after >> 1)
        state[CUT_TICKS] = ticks
        state[Q] = aim
        state[CUT_PACE] = speed + after >> _V_BITS + 1
        state[V] = after
        state[CUT_STEPS] = steps
        self.b = b

    def _look(self, speed, q, cap, leave, start, togo, part):  # ISR: no allocation
        """What lies ahead: the speeds wanted, and the room."""
        self._wanted = cap
        self._cap = root_of(cap, speed) if cap != q else speed
        self._until = root_of(leave + (leave >> 8), speed)  # units of blocks differ by as much
        rows = self._rows
        behind = self._behind
        self._on = leave > start and rows[behind + EXIT] + rows[behind + REACH] <= rows[self._at + EXIT]
        self._room = 0
        if togo >= 0:
            self._room = _HIGHEST
            if togo < _HIGHEST // self._scale:
                room = gained(self._scale, togo, part)
                self._room = room - (room >> 10)

    def _keep(self, q, leave, gain, togo, part, ends):  # ISR: no allocation
        """The block's planned end can be reached, whatever the jerk."""
        aim = self._aim
        if aim <= leave:
            return
        most = leave
        if not ends:
            if togo > _HIGHEST // gain:
                return
            room = togo * gain
            more = gained(gain, 0, part)
            if more >= aim - leave - room:
                return
            most = leave + room + more
        if q - most >= self._change:
            self._b = -self._limit
        elif self._b > 0:
            self._b = 0
        self._aim = most
        self._ticks = 0

    def _choose(self, ramp, q, b, steps, path):  # ISR: no allocation
        """The largest b, and q, that a segment may end with."""
        speed = ramp.state[V]
        self._tried = -1
        if not b and speed == self._cap:
            if self._cruise != speed or self._cruise_until != self._until or self._on:
                self._cruise = speed
                self._cruise_until = self._until
                self._cruise_need = self._need(speed, 0)
            self._brakes = self._cruise_need > self._room
            if not self._brakes:
                self._aim = self._tried = q
                self._speed = speed
                self._b = 0
                return
        guess = speed
        each = ramp._step_ticks(ramp._block.span, speed)
        if steps > 3:
            grow = self._grown((path >> 12) * each >> 5)
        else:
            guess = root_of(self._at_end(q, 2 * b), speed)
            grow = self._grown(self._mean(ramp, path, speed + guess >> 1))
            if steps == 1 and grow > self._first:
                grow = self._first
        self._grow = grow
        limit = self._limit
        high = b + grow if b + grow < limit else limit
        low = b - grow if b - grow > -limit else -limit
        if low < 0:  # but what can fade till the block's end, or till a stand
            most = guess if self._on else guess - self._until
            most = -self._fading(most) if most > 0 else 0
            if low < most:
                low = most if most < high else high
        self._try(q, b, high, speed)
        above = self._above
        short = self._short
        self._brakes = short > 0
        if above <= 0 and short <= 0:
            return
        self._try(q, b, low, speed)
        if self._above > 0 or self._short > 0:
            return
        self._b = self._between(low, high, above, short)
        if high - low > 500:  # far apart: once more
            self._try(q, b, self._b, speed)
            if self._above <= 0 and self._short <= 0:
                self._b = self._between(self._b, high, above, short)
        self._aim = self._at_end(q, b + self._b)

    def _between(self, low, high, above, short):  # ISR: no allocation
        """The largest b, were the excesses linear from `low`, just tried, to `high`, where they are `above` and `short`."""
        share = 0x4000
        if above > 0:
            share = ratio(-self._above, above)
        if short > 0:
            less = ratio(-self._short, short)
            if less < share:
                share = less
        return low + ((high - low) * share >> 14)

    def _try(self, q, before, b, near):  # ISR: no allocation
        """End with b. How much speed is `_above`, and way `_short`, then?"""
        q = self._aim = self._tried = self._at_end(q, before + b)
        self._b = b
        self._speed = root_of(q, near)
        self._judge(self._speed, b)

    def _judge(self, speed, b):  # ISR: no allocation
        fade = b * b >> _V_BITS
        above = speed + (fade if b > 0 else -fade)
        if not self._room:  # the block ends here
            self._above = above - (self._until if self._until < self._cap else self._cap)
            self._short = 0
            return
        self._above = above - self._cap
        self._short = self._need(speed + fade, b) - self._room

    def _mean(self, ramp, path, speed):  # ISR: no allocation
        """Ticks of `path` at a mean `speed`."""
        each = ramp._step_ticks(ramp._block.span, speed or 1)
        return path_ticks(path, each, ramp._part)

    def _set_out(self, ramp, path, stands):  # ISR: no allocation
        """The first step from rest; `stands`: to rest, too."""
        aim = self._rest if self._rest < self._change else self._change
        b = self._first
        speed = root_of(aim, 0)
        mean = divide(speed, self._half, 13)
        cap = self._cap
        self._brakes = True
        self._tried = -1
        if stands:
            ticks = self._mean(ramp, path, mean)
            ticks += (ticks >> 2) * 3
            cap = cap or root_of(self._high, 0)
            if cap < mean + (mean >> 3):
                ticks = self._mean(ramp, path, cap) + 2 * self._half_ramp(cap)
            self._ticks = ticks
            return
        if speed > cap:
            self._judge(cap, 0)
            if self._short <= 0:
                self._b = 0
                self._aim = self._wanted
                self._ticks = self._mean(ramp, path, cap) + self._half_ramp(cap)
                return
        self._judge(speed, b)
        tries = 0
        while tries < 12 and (self._above > 0 or self._short > 0):
            aim = (aim >> 6) * 41 or 1
            b = b * 41 >> 6
            speed = root_of(aim, 0)
            mean = divide(speed, 0x6000, 13)
            self._judge(speed, b)
            tries += 1
        self._ticks = self._mean(ramp, path, mean or 1)
        self._aim = aim
        self._b = b

    def _last(self, ramp, q, path, change):  # ISR: no allocation
        """Ticks of a path that ends at rest, none of them slower than need be."""
        speed = ramp.state[V]
        half = 0x4000
        if q < change:
            part = divide(q >> 8, (change >> 8) + 1, 14)
            half = 0x6000 if part <= 0x3000 else 0x6000 - 2 * (part - 0x3000)
        ticks = self._mean(ramp, path, divide(speed, half, 13))
        least = self._mean(ramp, path, speed) + self._half_ramp(speed)
        if least < ticks:
            ticks = least
        self._set_out(ramp, path, True)
        return ticks if ticks < self._ticks else self._ticks
