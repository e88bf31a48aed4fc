"""Cuts a block into segments of about a millisecond, with acceleration: how many dominant steps, how many ticks they last.

The ramp carries q, the square of the speed, in units of the block's own (see profile.py), because along the path q is
linear: it gains at most `gain` a step. Each segment's end takes the largest q that

    - the block's speed and the override allow, or, in a hold, the least that can be reached
    - still leaves room to slow down to the block's planned exit, `leave`

      q ^      _________            A segment's time is exact for the trapezoid inside it: its steps at peak
        |     /         \\           speed, and what getting from v₁ to the peak and on to v₂ costs more,
        |    /           \\          t·(peak − v) / 2·peak each, t being the time that change of speed takes.
        |___/_____________\\___ path

    v₁                     v₂

The peak may be above both ends: so the steps in which a hold comes to its stand never take longer than from rest, however
slow the machine is before them.

Lines with acceleration are taken up and cut by ramp_viper.py, where jerk is not limited; the rest here is for arcs. It
takes a part of a board's memory that not every machine has to spare: Planner.load() makes it. All may run in an
interrupt: no allocation, no integer of 2³⁰.
"""

import micropython
from micropython import const

from passo.motion.block import COARSE, GAIN, LINE
from passo.motion.integers import divide
from passo.motion.line import MAX_RUN
from passo.motion.ramp_ticks import gained, loss, path_ticks, root_of
from passo.motion.ramp_viper import begin, cut
from passo.motion.steady import CUT_PACE, CUT_STEPS, CUT_TICKS, SEGMENT_TICKS, START, TOTAL, Q, Steady, V

_ARC_TICKS = const(75_000)  # its arithmetic takes a board 2 ms a segment
_SMOOTH_TICKS = const(37_500)  # with limited jerk: the pace is even in a segment, off the curve by acceleration · t² / 8
_MAX_RAMP = const(255)  # most steps of a segment whose speed may change, so that no product here reaches 2³⁰
_FAR = const(0x1FFFFFFF)  # FAR and V_BITS of ramp_ticks, known to the compiler
HIGHEST = const(0x3FFFFFFF)
_V_BITS = const(7)


class Ramp(Steady):
    """Steady, and with acceleration: a block begins at the speed that the one before ended with."""

    def __init__(self):
        Steady.__init__(self)
        self.cut_line = cut  # cut_line(block.rows, block.at, state, left, percent, hold)
        self._block = None
        self._walker = None
        self._steady = True
        self._length = SEGMENT_TICKS
        self._arc = False
        self._done = 0  # words of the arc's run cut so far
        self._part = 0

    @micropython.native
    def begin(self, block):  # ISR: no allocation
        line = block.kind == LINE
        short = self.short = line and not block.smooth and block.rows[block.at + GAIN]
        if not short:
            gain = block.gain
            self._block = block
            self._walker = block.walker
            self._arc = not line
            self._done = 0
            self._steady = not gain
            self._length = _SMOOTH_TICKS if block.smooth else SEGMENT_TICKS if line else _ARC_TICKS
            if not gain:
                Steady.begin(self, block)
                return
            self._each = block.ticks
            self._rest = block.ticks_rest
            self._total = block.walker.total
        state = self.state
        if line:
            state[TOTAL] = block.walker.total
        begin(block.rows, block.at, state, block.start)

    @micropython.native
    def cut(self, left, percent=100, hold=False):  # ISR: no allocation
        """The next segment: `percent` of the programmed speed is wanted; with `hold` none at all. Its steps are 0 where the
        machine stands."""
        if not self._steady:
            self._cut_ramp(left, percent, hold)
        elif not self._arc or hold:
            Steady.cut(self, left, percent, hold)
        else:
            walker = self._walker
            state = self.state
            state[CUT_PACE] = -1
            state[CUT_STEPS] = self._arc_steps(left, walker, self._each, 0)
            state[CUT_TICKS] = path_ticks(self._arc_path(state[CUT_STEPS], walker), self._each, self._rest)

    def _arc_steps(self, left, walker, each, most):  # ISR: no allocation
        """How many words of the arc's run last about as long as a segment at `each` ticks a step of path."""
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

    def _cut_ramp(self, left, percent, hold):  # ISR: no allocation
        block = self._block
        state = self.state
        q = state[Q]
        speed = state[V]
        start = state[START]
        cap = block.top * percent // 100
        if cap > block.limit:
            cap = block.limit
        cap *= cap
        high = cap
        state[CUT_STEPS] = 0
        if hold:
            cap = 0
            if q <= start:
                return
        elif q < start and q < cap or q > cap and q - (q >> 6) < start:  # no ramp is needed here
            q = start if start < cap else cap
            speed = state[V] = root_of(q, speed)
        gain = block.gain
        most = _FAR // gain or 1
        if most > _MAX_RAMP:
            most = _MAX_RAMP
        # How many steps: a millisecond of them at this speed, one from rest.
        each = 0
        steps = 1
        if q:
            each = self._step_ticks(block.span, speed)
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
        after = root_of(aim, speed)
        top = block.top
        if q == aim == peak and percent == 100 and q == top * top and not self._arc:
            state[CUT_TICKS] = self._nominal(steps)
        else:
            fast = root_of(peak, speed)
            each = self._step_ticks(block.span, fast)
            ticks = path_ticks(path, each, self._part)
            if fast != speed:
                ticks += loss(block, fast, fast - speed)
            if fast != after:
                ticks += loss(block, fast, fast - after)
            state[CUT_TICKS] = ticks
        state[Q] = aim
        state[CUT_PACE] = speed + after >> _V_BITS + 1
        state[V] = after
        state[CUT_STEPS] = steps

    def _step_ticks(self, span, speed):  # ISR: no allocation
        """span·64 / speed: the ticks of a step at `speed`; what is left over, in 128ths, goes to `_part`."""
        whole = span // speed
        rest = (span % speed) << 6
        part = rest % speed
        self._part = (part << _V_BITS) // speed
        whole = whole << 6 if whole < 0x800000 else _FAR
        return whole + rest // speed
