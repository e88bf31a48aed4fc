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
from passo.records import (
    AXIS_AIM, AXIS_ASKED, AXIS_CARRY, AXIS_DUE, AXIS_EACH, AXIS_ENDLESS, AXIS_FIELDS, AXIS_GAIN, AXIS_NEAR,
    AXIS_NEGATIVE, AXIS_NEW, AXIS_NEW_AIM, AXIS_NEW_BASE, AXIS_NEW_EACH, AXIS_NEW_ENDLESS, AXIS_NEW_NEGATIVE,
    AXIS_NEW_OVER, AXIS_NEW_REST, AXIS_OVER, AXIS_Q, AXIS_REST, AXIS_SPAN, AXIS_TAKEN, AXIS_TO_GO, COUNT_MASK,
    FEED_BITS, FEED_HEAD, FEED_LEVELS, HOLD_TICKS, INDEPENDENT_AXES, INDEPENDENT_AXIS, INDEPENDENT_HOLD,
    INDEPENDENT_LEAST, INDEPENDENT_LEVELS, INDEPENDENT_SETUP, INDEPENDENT_TICKS, TICKS_PER_S,
)  # fmt: skip

ENDLESS = const(-1)
MOST_STEPS = const(0xFFFFFFF)  # that may be to come: 2²⁸ − 1
_FAR = const(0x1FFFFFFF)
_TOP = const(16_000)  # so that q, and the sum of two, stay below 2³⁰
_SEGMENT_TICKS = const(12_500)


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
    q = state[at + AXIS_Q]
    gain = state[at + AXIS_GAIN]
    if state[at + AXIS_NEW]:
        if q and state[at + AXIS_NEW_NEGATIVE] != state[at + AXIS_NEGATIVE]:
            togo = (q + gain - 1) // gain + 1  # come to a stand first: q is the speed at the next step
            if state[at + AXIS_ENDLESS] or state[at + AXIS_TO_GO] > togo:
                state[at + AXIS_TO_GO] = togo
            state[at + AXIS_ENDLESS] = 0
            return
        each = state[at + AXIS_NEW_EACH]
        state[at + AXIS_EACH] = each
        state[at + AXIS_REST] = state[at + AXIS_NEW_REST]
        state[at + AXIS_OVER] = state[at + AXIS_NEW_OVER]
        if state[at + AXIS_CARRY] >= state[at + AXIS_OVER]:
            state[at + AXIS_CARRY] = 0
        if state[at + AXIS_DUE] > each and not gain:
            state[at + AXIS_DUE] = each
        state[at + AXIS_NEGATIVE] = state[at + AXIS_NEW_NEGATIVE]
        state[at + AXIS_ENDLESS] = state[at + AXIS_NEW_ENDLESS]
        state[at + AXIS_AIM] = state[at + AXIS_NEW_AIM]
        base = state[at + AXIS_NEW_BASE]
        if base >= 0:
            state[at + AXIS_TAKEN] = base
            state[at + AXIS_TO_GO] = (q + gain - 1) // gain + 1 if q else 0
            state[at + AXIS_NEW_BASE] = -1
        state[at + AXIS_NEW] = 0
    asked = state[at + AXIS_ASKED]
    more = (asked - state[at + AXIS_TAKEN]) & COUNT_MASK
    if more:
        state[at + AXIS_TAKEN] = asked
        state[at + AXIS_TO_GO] += more
    if state[at + AXIS_ENDLESS]:
        state[at + AXIS_TO_GO] = MOST_STEPS


@micropython.native
def interval(state, at, togo):  # ISR: no allocation
    """Ticks from the step just made to the next one, `togo` being left."""
    gain = state[at + AXIS_GAIN]
    if gain:
        q = state[at + AXIS_Q]
        aim = 0 if state[INDEPENDENT_HOLD] else state[at + AXIS_AIM]
        after = q
        if q < aim:
            after = aim if aim - q < gain else q + gain
        elif q > aim:
            after = aim if q - aim < gain else q - gain
        if not togo:
            after = 0
        elif togo <= state[at + AXIS_NEAR] and gain * (togo - 1) < after:
            after = gain * (togo - 1)
        state[at + AXIS_Q] = after
        if q != after or q != aim:
            middle = (q + after) >> 1
            if middle < (gain + 1) >> 1:
                middle = (gain + 1) >> 1
            span = state[at + AXIS_SPAN]
            if middle < 0x100000:
                speed = root(middle << 8, 0x2000)
                ticks = (span // speed << 4) + (span % speed << 4) // speed
            else:
                speed = root(middle, 0x2000)
                ticks = span // speed
            return state[at + AXIS_EACH] if ticks < state[at + AXIS_EACH] and q <= aim else ticks
    carry = state[at + AXIS_CARRY] + state[at + AXIS_REST]
    ticks = state[at + AXIS_EACH]
    if carry >= state[at + AXIS_OVER]:
        carry -= state[at + AXIS_OVER]
        ticks += 1
    state[at + AXIS_CARRY] = carry
    return ticks


def walk_plain(words, at, room, bits, state, made):  # ISR: no allocation
    """Write at most `room` words, about a millisecond, to words[at:]; add each axis's signed steps to `made`.

    Returns how many: 0 where nothing moves and no interval runs."""
    axes = state[INDEPENDENT_AXES]
    least = state[INDEPENDENT_LEAST]
    count = ticks = 0
    while count < room and ticks < _SEGMENT_TICKS:
        mask = last = 0
        soonest = _FAR
        for axis in range(axes):
            a = INDEPENDENT_AXIS + axis * AXIS_FIELDS
            if state[a + AXIS_NEW] or state[a + AXIS_ASKED] != state[a + AXIS_TAKEN]:
                take(state, a)
            due = state[a + AXIS_DUE]
            togo = state[a + AXIS_TO_GO]
            if not togo or state[INDEPENDENT_HOLD] and not state[a + AXIS_Q]:
                if due > last:
                    last = due
                continue
            negative = state[a + AXIS_NEGATIVE]
            if (state[INDEPENDENT_LEVELS] >> (axes + axis) & 1) == negative:
                state[INDEPENDENT_LEVELS] ^= 1 << axes + axis
                if due < state[INDEPENDENT_SETUP]:
                    due = state[INDEPENDENT_SETUP]
            if due <= least:
                mask |= 1 << axis
                made[axis] += -1 if negative else 1
                if not state[a + AXIS_ENDLESS]:
                    togo -= 1
                    state[a + AXIS_TO_GO] = togo
                due += interval(state, a, togo)
            state[a + AXIS_DUE] = due
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
        words[at + count] = gap << bits | state[INDEPENDENT_LEVELS] | mask
        count += 1
        ticks += gap
        for axis in range(axes):
            a = INDEPENDENT_AXIS + axis * AXIS_FIELDS + AXIS_DUE
            state[a] = state[a] - gap if state[a] > gap else 0
    state[INDEPENDENT_TICKS] = ticks
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
        self._state = array("i", [axes, least, setup + least if setup else 0, 0, 0, 0] + [0] * (AXIS_FIELDS * axes))
        for axis in range(axes):
            self._put(axis, AXIS_OVER, 1)
            self._put(axis, AXIS_NEW_EACH, 2 * least)
            self._put(axis, AXIS_NEW_OVER, 1)
            self._put(axis, AXIS_NEW_BASE, -1)

    def _put(self, axis, field, value):
        self._state[INDEPENDENT_AXIS + axis * AXIS_FIELDS + field] = value

    def _get(self, axis, field):
        return self._state[INDEPENDENT_AXIS + axis * AXIS_FIELDS + field]

    # --- asking: main loop only

    def limits(self, axis, fastest, acceleration):
        """From now on the axis takes at most `fastest` steps/s and `acceleration` steps/s² (0: any). Only at a stand."""
        if not acceleration:
            self._put(axis, AXIS_GAIN, 0)
            return
        top = max(min(_TOP, _FAR * fastest // TICKS_PER_S), 1)
        gain = max(min(2 * acceleration * top * top // (fastest * fastest), _FAR), 1)
        self._put(axis, AXIS_SPAN, top * TICKS_PER_S // fastest)
        self._put(axis, AXIS_NEAR, _FAR // gain)
        self._put(axis, AXIS_GAIN, gain)

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
        at = INDEPENDENT_AXIS + axis * AXIS_FIELDS
        state[at + AXIS_NEW] = 0  # from here on the interrupt leaves the request alone
        if not add:
            state[at + AXIS_NEW_BASE] = state[at + AXIS_ASKED]
        state[at + AXIS_NEW_EACH] = each
        state[at + AXIS_NEW_REST] = rest
        state[at + AXIS_NEW_OVER] = over
        if state[at + AXIS_GAIN]:
            speed = max(min(state[at + AXIS_SPAN] * over // (each * over + rest), _TOP), 1)
            state[at + AXIS_NEW_AIM] = speed * speed
        state[at + AXIS_NEW_NEGATIVE] = 1 if negative else 0
        if steps or not add:
            state[at + AXIS_NEW_ENDLESS] = 1 if steps == ENDLESS else 0
        state[at + AXIS_NEW] = 1
        if steps > 0:
            state[at + AXIS_ASKED] = (state[at + AXIS_ASKED] + steps) & COUNT_MASK

    def rate(self, axis, each, rest=0, over=1):
        """Another rate from the axis's next step on; how far it goes stays."""
        self.set(axis, 0, each, rest, over, self._get(axis, AXIS_NEW_NEGATIVE), add=True)

    def stop(self, axis):
        """No step more than it takes to slow down."""
        self._put(axis, AXIS_NEW, 0)
        self._put(axis, AXIS_NEW_BASE, self._get(axis, AXIS_ASKED))
        self._put(axis, AXIS_NEW_ENDLESS, 0)
        self._put(axis, AXIS_NEW, 1)

    def clear(self):
        """Forget everything. Only while the feeder is stopped."""
        self.running = False
        for axis in range(self.axes):
            self._put(axis, AXIS_TAKEN, self._get(axis, AXIS_ASKED))
            self._put(axis, AXIS_NEW_BASE, -1)
            for field in (AXIS_NEW, AXIS_NEW_ENDLESS, AXIS_ENDLESS, AXIS_TO_GO, AXIS_DUE, AXIS_Q):
                self._put(axis, field, 0)

    @micropython.native
    def togo(self, axis):
        """Steps still to come of an axis; ENDLESS: no end."""
        if self._get(axis, AXIS_NEW_ENDLESS):
            return ENDLESS
        base = self._get(axis, AXIS_NEW_BASE)
        if base >= 0:
            return (self._get(axis, AXIS_ASKED) - base) & COUNT_MASK
        if self._get(axis, AXIS_ENDLESS):
            return 0
        return self._get(axis, AXIS_TO_GO) + ((self._get(axis, AXIS_ASKED) - self._get(axis, AXIS_TAKEN)) & COUNT_MASK)

    def negative(self, axis):
        """True where the axis was last asked to count down."""
        return bool(self._get(axis, AXIS_NEW_NEGATIVE))

    def stands(self, axis):
        """True if no step of the axis is to come, nor has been asked for."""
        togo, asked = self._get(axis, AXIS_TO_GO), self._get(axis, AXIS_ASKED)
        return not togo and not self._get(axis, AXIS_NEW) and asked == self._get(axis, AXIS_TAKEN)

    # --- the feeder's side

    def active(self):  # ISR: no allocation
        """True while an axis has steps to come, or its last step's interval still runs."""
        state = self._state
        for axis in range(self.axes):
            at = INDEPENDENT_AXIS + axis * AXIS_FIELDS
            if state[at + AXIS_TO_GO] or state[at + AXIS_DUE] or state[at + AXIS_NEW] or state[at + AXIS_ASKED] != state[at + AXIS_TAKEN]:
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
            if self._state[INDEPENDENT_AXIS + axis * AXIS_FIELDS + AXIS_Q]:
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
        state[INDEPENDENT_LEVELS] = levels
        state[INDEPENDENT_HOLD] = 1 if hold else 0
        count = walk(words, at, room, bits, state, self.made)
        self.levels = state[INDEPENDENT_LEVELS]
        self.ticks = state[INDEPENDENT_TICKS]
        return count
