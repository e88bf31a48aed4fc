"""Axes that run independently: each has its own rate, its own count (or none: endless) and its own next-due tick.

Steps that fall due within `least` ticks of each other share a word. An axis's due times are counted from its own
nominal ones, so what sharing moves never accumulates: the mean rate is exact.

    axes = IndependentAxes(2, least=50, setup=63)
    axes.run_axis(0, 100, 12_500, 0, 1)       # 100 steps of x, 1 ms apart
    axes.run_axis(1, ENDLESS, 4_166, 2, 3)    # y for ever, 4166 ⅔ ticks apart
    planner.walk(axes, tool=False)
    axes.run_axis(0, 50, 12_500, add=True)    # x goes 50 further, without a gap
    axes.stop(1)

All of it may be asked for while they run: run_axis() and stop() leave a request that the next word takes up, whole or not at all. The main loop
writes `asked` (all steps ever asked for) and the request, only while it is marked as not there; the feeder's interrupt writes all else.

With set_limits() an axis speeds up and slows down along q, the square of its speed, which grows by `gain` a step: the unit
of speed is the axis's fastest / top, the interval between two steps is span / √q in their middle. A stop, a turn or
the last step is then reached by slowing down; without limits the rate is constant from the first step to the last.

A change of direction is written with whatever word comes next; the axis's own next step waits for the set-up time, the
other axes' do not.
"""

from array import array

import micropython

from passo.motion.limits import TOP  # of speed units, so that q, and the sum of two, stay below 2³⁰
from passo.options.independent.motion_viper import FAR, MOST_STEPS, walk
from passo.options.independent.records import *
from passo.records import *


class IndependentAxes:
    """A geometry that makes whole words, of `axes` axes, no two words nearer than `least` ticks; `setup` as the feeder's."""

    kind = KIND_INDEPENDENT

    def __init__(self, axes, least, setup=0):
        self.axes = axes
        self.least = least
        self.running = False  # a block plays this walker, or is going to
        self.made = array("i", [0] * axes)  # signed steps since the feeder last cleared them
        self.moving = self.negative = 0  # masks of axes whose directions have to change before the words: its words do that
        self.tool = -1  # as its block says
        self.index = 0  # there is none
        self.backward = False
        self.ticks = self.levels = 0  # of walk()'s words: their length, and the directions and tool at their end
        self._state = array("i", [axes, least, setup + least if setup else 0, 0, 0, 0] + [0] * (AXIS_FIELDS * axes))
        for axis in range(axes):
            self._put_field(axis, AXIS_OVER, 1)
            self._put_field(axis, AXIS_NEW_EACH, 2 * least)
            self._put_field(axis, AXIS_NEW_OVER, 1)
            self._put_field(axis, AXIS_NEW_BASE, -1)

    def _put_field(self, axis, field, value):
        """Set a field AXIS_… of an axis."""
        self._state[INDEPENDENT_AXIS + axis * AXIS_FIELDS + field] = value

    def _get_field(self, axis, field):
        """Return a field AXIS_… of an axis."""
        return self._state[INDEPENDENT_AXIS + axis * AXIS_FIELDS + field]

    # --- asking: main loop only

    def set_limits(self, axis, fastest, acceleration):
        """Limit the axis to `fastest` steps/s and `acceleration` steps/s² from now on (0: no ramps). Only at a stand."""
        if not acceleration:
            self._put_field(axis, AXIS_GAIN, 0)
            return
        top = max(min(TOP, FAR * fastest // TICKS_PER_S), 1)
        gain = max(min(2 * acceleration * top * top // (fastest * fastest), FAR), 1)
        self._put_field(axis, AXIS_SPAN, top * TICKS_PER_S // fastest)
        self._put_field(axis, AXIS_NEAR, FAR // gain)
        self._put_field(axis, AXIS_GAIN, gain)

    @micropython.native
    def run_axis(self, axis, steps, each, rest=0, over=1, negative=False, add=False):
        """Run `axis` for `steps` (≥ 0 or ENDLESS), a step every each + rest/over ticks (each ≥ 2 · least, < 2²⁹).

        `add`: on top of the steps to come, which have the same direction; else in place of them. To add 0 changes the rate from the next step on.
        Raises ValueError."""
        togo = self.steps_to_go(axis) if add else 0
        if togo == ENDLESS and steps:
            add = False
        if steps < ENDLESS or steps > MOST_STEPS - max(togo, 0):
            raise ValueError("%d is not a number of steps" % steps)
        if each < 2 * self.least or each >= FAR:
            raise ValueError("a step every %d ticks; at least %d" % (each, 2 * self.least))
        if not 0 <= rest < over <= FAR // 2:
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
            speed = max(min(state[at + AXIS_SPAN] * over // (each * over + rest), TOP), 1)
            state[at + AXIS_NEW_AIM] = speed * speed
        state[at + AXIS_NEW_NEGATIVE] = 1 if negative else 0
        if steps or not add:
            state[at + AXIS_NEW_ENDLESS] = 1 if steps == ENDLESS else 0
        state[at + AXIS_NEW] = 1
        if steps > 0:
            state[at + AXIS_ASKED] = (state[at + AXIS_ASKED] + steps) & COUNT_MASK

    def stop(self, axis):
        """Stop the axis, with no more steps than it takes to slow down."""
        self._put_field(axis, AXIS_NEW, 0)
        self._put_field(axis, AXIS_NEW_BASE, self._get_field(axis, AXIS_ASKED))
        self._put_field(axis, AXIS_NEW_ENDLESS, 0)
        self._put_field(axis, AXIS_NEW, 1)

    def start(self):
        """Note that a block with this walker is about to be queued."""
        self.running = True

    def clear(self):
        """Forget everything. Only while the feeder is stopped."""
        self.running = False
        for axis in range(self.axes):
            self._put_field(axis, AXIS_TAKEN, self._get_field(axis, AXIS_ASKED))
            self._put_field(axis, AXIS_NEW_BASE, -1)
            for field in (AXIS_NEW, AXIS_NEW_ENDLESS, AXIS_ENDLESS, AXIS_TO_GO, AXIS_DUE, AXIS_Q):
                self._put_field(axis, field, 0)

    @micropython.native
    def steps_to_go(self, axis):
        """Return the steps still to come of an axis; ENDLESS if there is no end."""
        if self._get_field(axis, AXIS_NEW_ENDLESS):
            return ENDLESS
        base = self._get_field(axis, AXIS_NEW_BASE)
        if base >= 0:
            return (self._get_field(axis, AXIS_ASKED) - base) & COUNT_MASK
        if self._get_field(axis, AXIS_ENDLESS):
            return 0
        return self._get_field(axis, AXIS_TO_GO) + ((self._get_field(axis, AXIS_ASKED) - self._get_field(axis, AXIS_TAKEN)) & COUNT_MASK)

    def counts_down(self, axis):
        """Return True if the axis was last asked to count down."""
        return bool(self._get_field(axis, AXIS_NEW_NEGATIVE))

    def is_at_rest(self, axis):
        """Return True if no step of the axis is to come, nor has been asked for."""
        togo, asked = self._get_field(axis, AXIS_TO_GO), self._get_field(axis, AXIS_ASKED)
        return not togo and not self._get_field(axis, AXIS_NEW) and asked == self._get_field(axis, AXIS_TAKEN)

    # --- the next segment: may run in an interrupt

    def ready(self):  # ISR: no allocation
        """Return True: this walker never waits for more."""
        return True

    def active(self):  # ISR: no allocation
        """Return True while an axis has steps to come, or its last step's interval still runs."""
        state = self._state
        for axis in range(self.axes):
            at = INDEPENDENT_AXIS + axis * AXIS_FIELDS
            if state[at + AXIS_TO_GO] or state[at + AXIS_DUE] or state[at + AXIS_NEW]:
                return True
            if state[at + AXIS_ASKED] != state[at + AXIS_TAKEN]:
                return True
        return False

    def ends(self):  # ISR: no allocation
        """Return True, once, when nothing is active any more; a later request needs a new block."""
        if self.active():
            return False
        self.running = False
        return True

    def rolling(self):  # ISR: no allocation
        """Return True while an axis would have to slow down before it can stand."""
        for axis in range(self.axes):
            if self._state[INDEPENDENT_AXIS + axis * AXIS_FIELDS + AXIS_Q]:
                return True
        return False

    def walk(self, words, at, room, levels, bits, hold=False):  # ISR: no allocation
        """Write at most `room` words, about a millisecond, to words[at:]. Returns how many."""
        state = self._state
        state[INDEPENDENT_LEVELS] = levels
        state[INDEPENDENT_HOLD] = 1 if hold else 0
        count = walk(words, at, room, bits, state, self.made)
        self.levels = state[INDEPENDENT_LEVELS]
        self.ticks = state[INDEPENDENT_TICKS]
        return count
