"""Cuts a block into segments of about a millisecond: how many dominant steps, and how many ticks they last.

A segment is never cut inside a dominant interval: where steps are further apart it is one step long. At programmed
speed a line's total is exact: the ticks that do not divide by its steps are spread over all of it.

With acceleration the ramp carries q, the square of the speed, in units of the block's own (see profile.py), because
along the path q is linear: it gains at most `gain` a step. Each segment's end takes the largest q that

    - the block's speed and the override allow, or, in a hold, the least that can be reached
    - still leaves room to slow down to the block's planned exit, `leave`

      q ^      _________            A segment's time is exact for the trapezoid inside it: its steps at peak
        |     /         \\           speed, and what getting from v₁ to the peak and on to v₂ costs more,
        |    /           \\          t·(peak − v) / 2·peak each, t being the time that change of speed takes.
        |___/_____________\\___ path

    v₁                     v₂

The peak may be above both ends: so the steps in which a hold comes to its stand never take longer than from rest, however
slow the machine is before them.

Lines with acceleration are taken up and cut by ramp_viper.py, where jerk is not limited; the rest here is for arcs. All but
load() may run in an interrupt: no allocation, no integer of 2³⁰.
"""

from array import array

import micropython
from micropython import const

from passo.motion.block import ARC, COARSE
from passo.motion.integers import divide
from passo.motion.line import MAX_RUN
from passo.motion.ramp_ticks import gained, loss, path_ticks, root_of

SEGMENT_TICKS = const(12_500)  # 1 ms
_SMOOTH_TICKS = const(37_500)  # with limited jerk: the pace is even in a segment, off the curve by acceleration · t² / 8
_MAX_RAMP = const(255)  # most steps of a segment whose speed may change, so that no product here reaches 2³⁰
_FAR = const(0x1FFFFFFF)  # FAR and V_BITS of ramp_ticks, known to the compiler
HIGHEST = const(0x3FFFFFFF)
_V_BITS = const(7)


# The state that is shared with ramp_viper.py. The last segment cut:
_STEPS = const(0)
_TICKS = const(1)
_PACE = const(2)
_Q = const(3)  # where the next one begins, in the block's units
_V = const(4)  # its root, _V_BITS fraction bits; 5 is q that takes no ramp, 6 the carry of ticks
_TOTAL = const(7)  # dominant steps of the line

_begin = _cut = None


def load():
    """Make ready for acceleration. It takes a part of a board's memory that not every machine has to spare."""
    global _begin, _cut
    from passo.motion.ramp_viper import begin as _begin
    from passo.motion.ramp_viper import cut as _cut


class Ramp:
    """After cut(), `steps` and `ticks` hold the segment."""

    def __init__(self):
        self.steps = self.ticks = 0
        self.pace = 0  # the segment's mean speed in the block's units; -1: the programmed one
        self._block = None
        self._walker = None
        self._q = 0  # where the next segment begins, in the block's units
        self._each = self._rest = self._total = self._carry = 0
        self._state = array("i", [0] * 8)
        self._steady = True
        self._short = False
        self._length = SEGMENT_TICKS
        self._arc = False
        self._done = 0  # words of the arc's run cut so far
        self._part = 0
        self._start = 0  # q that takes no ramp, in the block's units
        self._speed = 0  # v of _q, _V_BITS fraction bits

    def stall(self):  # ISR: no allocation
        """The machine stands: what comes next begins at rest."""
        self._q = self._speed = 0

    def moving(self):  # ISR: no allocation
        """True when the next segment begins at a speed that was reached by acceleration: it could not stand here."""
        return self._q > self._start

    @micropython.native
    def begin(self, block):  # ISR: no allocation
        """Take up `block` at the speed the last one ended with."""
        self._block = block
        self._walker = block.walker
        self._each = block.ticks
        self._rest = block.ticks_rest
        self._total = block.walker.total
        self._carry = 0
        self._arc = block.kind == ARC
        self._done = 0
        self._steady = not block.gain
        self._length = _SMOOTH_TICKS if block.smooth else SEGMENT_TICKS
        self._start = block.start
        self._short = not self._arc and not block.smooth
        if self._steady:
            self._q = self._speed = 0
            return
        state = self._state
        state[_TOTAL] = self._total
        state[_V] = self._speed
        _begin(block.rows, block.at, state, block.start)
        self._q = state[_Q]
        self._speed = state[_V]

    @micropython.native
    def cut(self, left, percent=100, hold=False):  # ISR: no allocation
        """The next segment of a walker that has `left` ≥ 1 dominant steps before its end or its next corner.

        `percent` of the programmed speed is wanted; with `hold` none at all. `steps` is 0 where the machine stands.
        """
        if self._steady:
            self._cut_steady(left, hold)
        elif self._short:
            state = self._state
            block = self._block
            state[_Q] = self._q
            state[_V] = self._speed
            _cut(block.rows, block.at, state, left, percent, hold)
            self.steps = state[_STEPS]
            if state[_STEPS]:
                self.ticks = state[_TICKS]
                self.pace = state[_PACE]
                self._q = state[_Q]
                self._speed = state[_V]
        else:
            self._cut_ramp(left, percent, hold)

    @micropython.native
    def _cut_steady(self, left, hold):  # ISR: no allocation
        self.steps = 0
        self.pace = -1
        if hold:
            return
        if self._arc:
            walker = self._walker
            steps = self._arc_steps(left, walker, self._each, 0)
            self.ticks = path_ticks(self._arc_path(steps, walker), self._each, self._rest)
        else:
            steps = SEGMENT_TICKS // self._each or 1
            if steps > left:
                steps = left
            if steps > MAX_RUN:
                steps = MAX_RUN
            self.ticks = self._nominal(steps)
        self.steps = steps

    @micropython.native
    def _nominal(self, steps):  # ISR: no allocation
        carry = self._carry + steps * self._rest
        self._carry = carry % self._total
        return steps * self._each + carry // self._total

    def _arc_steps(self, left, walker, each, most):  # ISR: no allocation
        """How many words of the arc's run last about a millisecond at `each` ticks a step of path."""
        if walker.left == walker.words:
            self._done = 0
        path = walker.path or 1
        steps = self._length // each << COARSE
        if steps >= path:
            steps = left
        else:
            steps = steps * walker.words // path
        if most and steps * path > (most << COARSE) * walker.words:
            steps = (most << COARSE) * walker.words // path
        if steps > left:
            steps = left
        if steps > MAX_RUN:
            steps = MAX_RUN
        return steps or 1

    def _arc_path(self, steps, walker):  # ISR: no allocation
        """Path of the next `steps` words, in 2⁻¹⁷ steps; counts them as done."""
        self._done += steps
        return divide(walker.path * steps, walker.words, 17 - COARSE)

    # --- with acceleration

    def _cut_ramp(self, left, percent, hold):  # ISR: no allocation
        block = self._block
        q = self._q
        cap = block.top * percent // 100
        if cap > block.limit:
            cap = block.limit
        cap *= cap
        high = cap
        self.steps = 0
        if hold:
            cap = 0
            if q <= self._start:
                return
        elif q < self._start and q < cap or q > cap and q - (q >> 6) < self._start:  # no ramp is needed here
            q = self._start if self._start < cap else cap
            self._speed = root_of(q, self._speed)
        gain = block.gain
        most = _FAR // gain or 1
        if most > _MAX_RAMP:
            most = _MAX_RAMP
        # How many steps: a millisecond of them at this speed, one from rest.
        each = 0
        steps = 1
        if q:
            each = self._step_ticks(block.span, self._speed)
            if self._arc:
                steps = self._arc_steps(left, self._walker, each, most)
            else:
                steps = self._length // each or 1
                if steps > most:
                    steps = most
                if steps > left:
                    steps = left
                if steps > _MAX_RAMP:
                    steps = _MAX_RAMP
                if hold and steps > q // gain:
                    steps = q // gain + 1  # it stands after these
        elif self._arc:
            steps = self._arc_steps(left, self._walker, self._length, most)
        # How fast at its end.
        if self._arc:
            walker = self._walker
            path = self._arc_path(steps, walker)
            change = _FAR
            if path >> 17 <= _FAR // gain:
                change = gained(gain, path >> 17, path & 0x1FFFF)
            done = divide(walker.path * self._done, walker.words, 17 - COARSE) + (walker.fine >> 3)
            togo = walker.to_go - (done >> 17)
            part = -done & 0x1FFFF
            if part:
                togo -= 1
            if steps == walker.left and walker.last():
                togo = part = 0
        else:
            path = steps << 17
            change = steps * gain
            togo = left - steps
            part = 0
        if change > _FAR:
            change = _FAR
        if block.smooth:
            block.smooth.cut(self, q, steps, path, togo, part, change, cap, high)
            return
        if q < cap:
            aim = cap if cap - q <= change else q + change
        else:
            aim = cap if q - cap <= change else q - change
        leave = block.leave
        if aim > leave:
            if togo < 0:
                aim = leave
            elif togo <= HIGHEST // gain:
                room = togo * gain
                more = gained(gain, 0, part)
                if more < aim - leave - room:
                    aim = leave + room + more
        # The peak in between, and the time.
        if q > high:
            high = q
        half = change + (aim - q) >> 1
        peak = high if half > high - q else q + half
        if peak < aim:
            peak = aim
        if peak < q:
            peak = q
        if peak < 1:
            peak = 1
        after = root_of(aim, self._speed)
        top = block.top
        if q == aim == peak and percent == 100 and q == top * top and not self._arc:
            self.ticks = self._nominal(steps)
        else:
            fast = root_of(peak, self._speed)
            each = self._step_ticks(block.span, fast)
            ticks = path_ticks(path, each, self._part)
            if fast != self._speed:
                ticks += loss(block, fast, fast - self._speed)
            if fast != after:
                ticks += loss(block, fast, fast - after)
            self.ticks = ticks
        self._q = aim
        self.pace = self._speed + after >> _V_BITS + 1
        self._speed = after
        self.steps = steps

    def _step_ticks(self, span, speed):  # ISR: no allocation
        """span·64 / speed: the ticks of a step at `speed`; what is left over, in 128ths, goes to `_part`."""
        whole = span // speed
        rest = (span % speed) << 6
        part = rest % speed
        self._part = (part << _V_BITS) // speed
        whole = whole << 6 if whole < 0x800000 else _FAR
        return whole + rest // speed
