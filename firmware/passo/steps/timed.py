"""Axes that run independently: each has its own rate, its own count (or none: endless) and its own next-due tick.

Steps that fall due within `least` ticks of each other share a word. An axis's due times are counted from its own
nominal ones, so what sharing moves never accumulates: the mean rate is exact.

    axes = Timed(2, least=50, setup=63)
    axes.set(0, 100, 12_500, 0, 1)            # 100 steps of x, 1 ms apart
    axes.set(1, ENDLESS, 4_166, 2, 3)         # y for ever, 4166 ⅔ ticks apart
    planner.free(axes, tool=False)
    axes.set(0, 50, 12_500, add=True)         # x goes 50 further, without a gap
    axes.stop(1)

All of it may be asked for while they run: set() and stop() leave a request that the next word takes up, whole or not at
all. Who writes what: the main loop `asked` (all steps ever asked for) and the request, only while it is marked as not
there; the feeder's interrupt all else.

With limits() an axis speeds up and slows down along q, the square of its speed, which grows by `gain` a step: the unit
of speed is the axis's fastest / top, the interval between two steps is span / √q in their middle. A stop, a turn or
the last step is then reached by slowing down; without limits the rate is constant from the first step to the last.

A change of direction is written with whatever word comes next; the axis's own next step waits for the set-up time, the
other axes' do not.
"""

from array import array

import micropython
from micropython import const

from passo.motion.line import MAX_RUN
from passo.records import FEED_BITS, FEED_HEAD, FEED_LEVELS
from passo.steps.word import HOLD_TICKS, TICKS_PER_S

ENDLESS = const(-1)
MOST_STEPS = const(0xFFFFFFF)  # that may be to come: 2²⁸ − 1
_COUNT = const(0x1FFFFFFF)
_FAR = const(0x1FFFFFFF)
_TOP = const(16_000)  # so that q, and the sum of two, stay below 2³⁰
_SEGMENT_TICKS = const(12_500)

# One array, for the sake of a twin in machine code: these, then _FIELDS numbers an axis.
_AXES = const(0)
_LEAST = const(1)
_SETUP = const(2)  # ticks from a change of direction to the axis's next step, sharing allowed for
_LEVELS = const(3)  # directions and tool, step form
_TICKS = const(4)  # length of what walk() wrote
_HOLD = const(5)  # come to a stand, and keep what is to come
_HEAD = const(6)

# In the feeder's array, as checkpoints_plain.py has them.

_TOGO = const(0)  # steps to come; endless: at least 1
_ENDLESS = const(1)
_TAKEN = const(2)  # how far `asked` has been taken up
_DUE = const(3)  # ticks to the next step
_EACH = const(4)  # an interval is each + rest / over
_REST = const(5)
_OVER = const(6)
_CARRY = const(7)
_NEGATIVE = const(8)
_Q = const(9)
_AIM = const(10)  # q of the rate asked for
_GAIN = const(11)  # 0: constant rate
_SPAN = const(12)
_NEAR = const(13)  # steps from which on gain · steps may be below any q
_ASKED = const(14)
_NEW = const(15)  # 1: there is a request
_NEW_EACH = const(16)
_NEW_REST = const(17)
_NEW_OVER = const(18)
_NEW_NEGATIVE = const(19)
_NEW_ENDLESS = const(20)
_NEW_AIM = const(21)
_NEW_BASE = const(22)  # what was asked for up to here is dropped; −1: nothing is
_FIELDS = const(23)


@micropython.native
def root(q, near):  # ISR: no allocation
    """√q, rounded down; `near`: a guess above 0."""
    if q < 1:
        return 0
    better = (near + q // near) >> 1 or 1
    while better > near + 1 or better < near - 1:
        near = better
        better = (near + q // near) >> 1 or 1
    while better * better > q:
        better -= 1
    return better


@micropython.native
def take(state, at):  # ISR: no allocation
    """Take up what has been asked of the axis whose numbers begin at state[at]."""
    q = state[at + _Q]
    gain = state[at + _GAIN]
    if state[at + _NEW]:
        if q and state[at + _NEW_NEGATIVE] != state[at + _NEGATIVE]:
            togo = (q + gain - 1) // gain + 1  # come to a stand first: q is the speed at the next step
            if state[at + _ENDLESS] or state[at + _TOGO] > togo:
                state[at + _TOGO] = togo
            state[at + _ENDLESS] = 0
            return
        each = state[at + _NEW_EACH]
        state[at + _EACH] = each
        state[at + _REST] = state[at + _NEW_REST]
        state[at + _OVER] = state[at + _NEW_OVER]
        if state[at + _CARRY] >= state[at + _OVER]:
            state[at + _CARRY] = 0
        if state[at + _DUE] > each and not gain:
            state[at + _DUE] = each
        state[at + _NEGATIVE] = state[at + _NEW_NEGATIVE]
        state[at + _ENDLESS] = state[at + _NEW_ENDLESS]
        state[at + _AIM] = state[at + _NEW_AIM]
        base = state[at + _NEW_BASE]
        if base >= 0:
            state[at + _TAKEN] = base
            state[at + _TOGO] = (q + gain - 1) // gain + 1 if q else 0
            state[at + _NEW_BASE] = -1
        state[at + _NEW] = 0
    asked = state[at + _ASKED]
    more = (asked - state[at + _TAKEN]) & _COUNT
    if more:
        state[at + _TAKEN] = asked
        state[at + _TOGO] += more
    if state[at + _ENDLESS]:
        state[at + _TOGO] = MOST_STEPS


@micropython.native
def interval(state, at, togo):  # ISR: no allocation
    """Ticks from the step just made to the next one, `togo` being left."""
    gain = state[at + _GAIN]
    if gain:
        q = state[at + _Q]
        aim = 0 if state[_HOLD] else state[at + _AIM]
        after = q
        if q < aim:
            after = aim if aim - q < gain else q + gain
        elif q > aim:
            after = aim if q - aim < gain else q - gain
        if not togo:
            after = 0
        elif togo <= state[at + _NEAR] and gain * (togo - 1) < after:
            after = gain * (togo - 1)
        state[at + _Q] = after
        if q != after or q != aim:
            middle = (q + after) >> 1
            if middle < (gain + 1) >> 1:
                middle = (gain + 1) >> 1
            span = state[at + _SPAN]
            if middle < 0x100000:
                speed = root(middle << 8, 0x2000)
                ticks = (span // speed << 4) + (span % speed << 4) // speed
            else:
                speed = root(middle, 0x2000)
                ticks = span // speed
            return state[at + _EACH] if ticks < state[at + _EACH] and q <= aim else ticks
    carry = state[at + _CARRY] + state[at + _REST]
    ticks = state[at + _EACH]
    if carry >= state[at + _OVER]:
        carry -= state[at + _OVER]
        ticks += 1
    state[at + _CARRY] = carry
    return ticks


def walk_plain(words, at, room, bits, state, made):  # ISR: no allocation
    """Write at most `room` words, about a millisecond, to words[at:]; add each axis's signed steps to `made`.

    Returns how many: 0 where nothing moves and no interval runs."""
    axes = state[_AXES]
    least = state[_LEAST]
    count = ticks = 0
    while count < room and ticks < _SEGMENT_TICKS:
        mask = last = 0
        soonest = _FAR
        for axis in range(axes):
            a = _HEAD + axis * _FIELDS
            if state[a + _NEW] or state[a + _ASKED] != state[a + _TAKEN]:
                take(state, a)
            due = state[a + _DUE]
            togo = state[a + _TOGO]
            if not togo or state[_HOLD] and not state[a + _Q]:
                if due > last:
                    last = due
                continue
            negative = state[a + _NEGATIVE]
            if (state[_LEVELS] >> (axes + axis) & 1) == negative:
                state[_LEVELS] ^= 1 << axes + axis
                if due < state[_SETUP]:
                    due = state[_SETUP]
            if due <= least:
                mask |= 1 << axis
                made[axis] += -1 if negative else 1
                if not state[a + _ENDLESS]:
                    togo -= 1
                    state[a + _TOGO] = togo
                due += interval(state, a, togo)
            state[a + _DUE] = due
            if not togo:
                if due > last:
                    last = due
            elif due < soonest:
                soonest = due
        gap = last if soonest == _FAR else soonest
        if gap > HOLD_TICKS:
            gap = HOLD_TICKS
        elif gap < least:
            if not gap:
                break
            gap = least
        words[at + count] = gap << bits | state[_LEVELS] | mask
        count += 1
        ticks += gap
        for axis in range(axes):
            a = _HEAD + axis * _FIELDS + _DUE
            state[a] = state[a] - gap if state[a] > gap else 0
    state[_TICKS] = ticks
    return count


try:
    from passo.steps.timed_viper import walk
except (ImportError, NameError, ValueError):  # an interpreter that has no machine code of its own
    walk = walk_plain


class Timed:
    """Walker of `axes` axes, no two words nearer than `least` ticks; `setup` as the feeder's."""

    def __init__(self, axes, least, setup=0):
        self.axes = axes
        self.least = least
        self.running = False  # a block plays this walker, or is going to
        self.made = array("i", [0] * axes)  # signed steps since the feeder last cleared them
        self.ticks = self.levels = 0  # of what walk() wrote: its length, and the directions and tool at its end
        self._state = array("i", [axes, least, setup + least if setup else 0, 0, 0, 0] + [0] * (_FIELDS * axes))
        for axis in range(axes):
            self._put(axis, _OVER, 1)
            self._put(axis, _NEW_EACH, 2 * least)
            self._put(axis, _NEW_OVER, 1)
            self._put(axis, _NEW_BASE, -1)

    def _put(self, axis, field, value):
        self._state[_HEAD + axis * _FIELDS + field] = value

    def _get(self, axis, field):
        return self._state[_HEAD + axis * _FIELDS + field]

    # --- asking: main loop only

    def limits(self, axis, fastest, acceleration):
        """From now on the axis takes at most `fastest` steps/s and `acceleration` steps/s² (0: any). Only at a stand."""
        if not acceleration:
            self._put(axis, _GAIN, 0)
            return
        top = max(min(_TOP, _FAR * fastest // TICKS_PER_S), 1)
        gain = max(min(2 * acceleration * top * top // (fastest * fastest), _FAR), 1)
        self._put(axis, _SPAN, top * TICKS_PER_S // fastest)
        self._put(axis, _NEAR, _FAR // gain)
        self._put(axis, _GAIN, gain)

    @micropython.native
    def set(self, axis, steps, each, rest=0, over=1, negative=False, add=False):
        """Run `axis` for `steps` (≥ 0 or ENDLESS), a step every each + rest/over ticks (each ≥ 2 · least, < 2²⁹).

        `add`: on top of those to come, which are of the same direction; else in the place of those. Raises ValueError.
        """
        togo = self.togo(axis) if add else 0
        if togo == ENDLESS and steps:
            add = False
        if steps < ENDLESS or steps > MOST_STEPS - max(togo, 0):
            raise ValueError("%d is not a number of steps" % steps)
        if each < 2 * self.least or each >= _FAR:
            raise ValueError("a step every %d ticks; at least %d" % (each, 2 * self.least))
        if not 0 <= rest < over <= _FAR // 2:
            raise ValueError("rest %d/%d is not below one tick" % (rest, over))
        state = self._state
        at = _HEAD + axis * _FIELDS
        state[at + _NEW] = 0  # from here on the interrupt leaves the request alone
        if not add:
            state[at + _NEW_BASE] = state[at + _ASKED]
        state[at + _NEW_EACH] = each
        state[at + _NEW_REST] = rest
        state[at + _NEW_OVER] = over
        if state[at + _GAIN]:
            speed = max(min(state[at + _SPAN] * over // (each * over + rest), _TOP), 1)
            state[at + _NEW_AIM] = speed * speed
        state[at + _NEW_NEGATIVE] = 1 if negative else 0
        if steps or not add:
            state[at + _NEW_ENDLESS] = 1 if steps == ENDLESS else 0
        state[at + _NEW] = 1
        if steps > 0:
            state[at + _ASKED] = (state[at + _ASKED] + steps) & _COUNT

    def rate(self, axis, each, rest=0, over=1):
        """Another rate from the axis's next step on; how far it goes stays."""
        self.set(axis, 0, each, rest, over, self._get(axis, _NEW_NEGATIVE), add=True)

    def stop(self, axis):
        """No step more than it takes to slow down."""
        self._put(axis, _NEW, 0)
        self._put(axis, _NEW_BASE, self._get(axis, _ASKED))
        self._put(axis, _NEW_ENDLESS, 0)
        self._put(axis, _NEW, 1)

    def clear(self):
        """Forget everything. Only while the feeder is stopped."""
        self.running = False
        for axis in range(self.axes):
            self._put(axis, _TAKEN, self._get(axis, _ASKED))
            self._put(axis, _NEW_BASE, -1)
            for field in (_NEW, _NEW_ENDLESS, _ENDLESS, _TOGO, _DUE, _Q):
                self._put(axis, field, 0)

    @micropython.native
    def togo(self, axis):
        """Steps still to come of an axis; ENDLESS: no end."""
        if self._get(axis, _NEW_ENDLESS):
            return ENDLESS
        base = self._get(axis, _NEW_BASE)
        if base >= 0:
            return (self._get(axis, _ASKED) - base) & _COUNT
        if self._get(axis, _ENDLESS):
            return 0
        return self._get(axis, _TOGO) + ((self._get(axis, _ASKED) - self._get(axis, _TAKEN)) & _COUNT)

    def negative(self, axis):
        """True where the axis was last asked to count down."""
        return bool(self._get(axis, _NEW_NEGATIVE))

    def stands(self, axis):
        """True if no step of the axis is to come, nor has been asked for."""
        togo, asked = self._get(axis, _TOGO), self._get(axis, _ASKED)
        return not togo and not self._get(axis, _NEW) and asked == self._get(axis, _TAKEN)

    # --- the feeder's side

    def active(self):  # ISR: no allocation
        """True while an axis has steps to come, or its last step's interval still runs."""
        state = self._state
        for axis in range(self.axes):
            at = _HEAD + axis * _FIELDS
            if state[at + _TOGO] or state[at + _DUE] or state[at + _NEW] or state[at + _ASKED] != state[at + _TAKEN]:
                return True
        return False

    def ends(self):  # ISR: no allocation
        """True, once, when nothing is active: whatever is asked from then on needs a new block."""
        if self.active():
            return False
        self.running = False
        return True

    def rolling(self):  # ISR: no allocation
        """True while an axis would have to slow down before it can stand."""
        for axis in range(self.axes):
            if self._state[_HEAD + axis * _FIELDS + _Q]:
                return True
        return False

    @micropython.native
    def feed(self, feeder, held):  # ISR: no allocation
        """Have the feeder's ring take what comes next. False where that is nothing now."""
        ring = feeder.ring
        state = feeder.state
        at = state[FEED_HEAD] & ring.mask
        most = ring.size - at
        count = self.walk(ring.words, at, MAX_RUN if most > MAX_RUN else most, state[FEED_LEVELS], state[FEED_BITS], held)
        ends = self.ends()
        if not count and not ends:
            return False
        state[FEED_LEVELS] = self.levels
        feeder.settle(at, count)
        feeder.finish(count, self.ticks, ends, self.made)
        return True

    def walk(self, words, at, room, levels, bits, hold=False):  # ISR: no allocation
        """Write at most `room` words, about a millisecond, to words[at:]. Returns how many; see walk_plain()."""
        state = self._state
        state[_LEVELS] = levels
        state[_HOLD] = 1 if hold else 0
        count = walk(words, at, room, bits, state, self.made)
        self.levels = state[_LEVELS]
        self.ticks = state[_TICKS]
        return count
