"""Axes that run on their own: each a number of steps, or for ever, at its own rate, from the moment it is asked.

A RUN that may only begin at a stand is refused as BUSY while anything moves; one marked as a jog also extends a jog of
the same axes in the same directions, without a gap, but only up to the board file's jog.ahead_ms of steps ahead of the pins:
a button that is let go stops the axis within that time, or at the end of the one jog it asked for at least. One marked as
live changes what moves: axes named set out, turn or take another rate, the others run on undisturbed. If the board file asks for it
(planning.independent_ramps), each axis keeps its own limits of speed and acceleration; otherwise the rate is
constant from the first step to the last.

If soft limits hold, an endless run and a turn on the way are refused: their end is not known.
"""

import micropython
from micropython import const

from passo import errors
from passo.commands import FINISHED, RUN, STILL, Event
from passo.config import setting_numbers as table
from passo.control.feature import WORK_GONE, Feature
from passo.control.links import HARMLESS, RIGHTS
from passo.errors import LATER
from passo.options.independent.commands import AS_JOG, FOREVER, LIVE, REST, ZERO
from passo.options.independent.errors import ZERO_IS_HOMED
from passo.options.independent.motion import IndependentAxes
from passo.options.independent.motion_viper import MOST_STEPS
from passo.records import COUNT_HALF, COUNT_MASK, ENDLESS, TICKS_PER_MS

_SETTLE_MS = const(50)  # from the last step until the rotor is at rest: its coils hold it for this time
_STANDING = ("idle", "alarm", "check", "sleep")


class Independent(Feature):
    event_mask = WORK_GONE

    def __init__(self, board, machine, queue):
        self._axes = board["axes"]
        Feature.__init__(self, board, machine, queue)
        self._ramps = board["planning"]["independent_ramps"]
        self._ahead_ms = board["jog"]["ahead_ms"]
        self._limits_of = None  # the settings' version that the walker knows
        feeder = queue.lend()[0]
        self.walker = IndependentAxes(len(board["axes"]), feeder.min_word_ticks, feeder.setup_ticks)
        queue.take_walker(self.walker)
        self._command = None  # the last RUN accepted, until the stand behind it, of which its link hears
        self._jog = None  # directions of the jog under way
        self._all = (1 << len(self._axes)) - 1
        self._off = self._unpowered = 0  # masks of the axes that shall have no current, and of those that have none
        self._moved_ms = [-_SETTLE_MS] * len(self._axes)  # when words were last made that turn each
        self._ended_ms = 0  # when the last word was found under way
        self._fastest = [0] * len(self._axes)  # steps/s of each axis
        self._from = self._queue.position()

    def handlers(self):
        """Return {kind of command: method} of this feature."""
        RIGHTS[REST] = HARMLESS
        return {
            RUN: self._begin_run,
            REST: self._stop_axes,
            ZERO: self._set_zero,
            STILL: self._keep_jogs,
        }

    def owns_axes(self):
        """Return "run" from a RUN to the stand behind it, else ""."""
        return "" if self._command is None else "run"

    def steps_made(self):
        """Return the signed steps of each axis since the last RUN that began at a stand, exact at this moment."""
        return [((now - then + COUNT_HALF) & COUNT_MASK) - COUNT_HALF for now, then in zip(self._queue.position(), self._from)]

    def on_events(self, _=WORK_GONE):
        """Forget the RUN and the jog: all motion has ended, or has been dropped. All motors get their current back."""
        self._command = self._jog = None
        self._off = 0
        self._switch_off()

    def report(self, report):
        report["made"] = self.steps_made()

    def poll(self, now_ms):
        """Notice the end of all motion, and report it to the link of the last RUN. An axis that is to have no current keeps it for _SETTLE_MS behind
        its last step."""
        if self._command is None:
            return
        self._machine.awake = True
        self._switch_off()
        if self.walker.running or not self._queue.still():
            self._ended_ms = now_ms
            return
        if self._off and (now_ms - self._ended_ms) & COUNT_MASK < _SETTLE_MS:
            return
        command = self._command
        if self._off == self._all:
            self._machine.motors.drives(False)
        self.on_events()
        self._queue.settle()
        self._machine.tell(Event(FINISHED, command))

    def _switch_off(self):
        """Take the current from the axes of _off at rest, and give it back to the others."""
        now_ms = self._machine.port.machine_ms()
        unpowered = 0
        for axis in range(len(self._axes)):
            if not self.walker.is_at_rest(axis):
                self._moved_ms[axis] = now_ms
            elif self._off >> axis & 1 and (now_ms - self._moved_ms[axis]) & COUNT_MASK >= _SETTLE_MS:
                unpowered |= 1 << axis
        if unpowered != self._unpowered:
            self._unpowered = unpowered
            self._machine.motors.cut_current(unpowered)

    def is_turning(self, axis):
        """Return True while steps of an axis are to come."""
        return self.walker.steps_to_go(axis) != 0

    # --- commands

    @micropython.native
    def _begin_run(self, command):
        """Do RUN: check it as a whole, then start its axes. Returns an error, LATER, or 0."""
        machine = self._machine
        error = machine.unready()
        if error:
            return error
        if self._command:
            if not self._may_join(command):
                return errors.BUSY
        elif machine.state not in ("idle", "check") or not self._queue.still():
            return errors.BUSY
        else:
            self._set_limits()
        error = machine.interlock_error(command.steps)
        if error:
            return error
        limited = machine.homed and machine.settings.value(table.SOFT_LIMITS)
        intervals = [None] * len(command.steps)
        for axis in range(len(intervals)):
            steps = command.steps[axis]
            if steps is None:
                continue
            intervals[axis] = self._step_interval(axis, command.rates[axis])
            if not intervals[axis]:
                return errors.SPEED_RANGE
            if steps and not self._is_reachable(axis, steps, limited):
                return errors.TRAVEL
        if machine.checking:
            return machine.confirm_command(command)
        if not self._queue.room():
            return LATER
        self._start_axes(command, intervals)
        return machine.confirm_command(command)

    def _may_join(self, command):
        """Return True if `command` may come while a RUN is under way."""
        machine = self._machine
        if machine.hold or machine.dropping:
            return False
        if command.when == LIVE:
            return True
        return command.when == AS_JOG and self._jog == self._directions_of(command)

    def _directions_of(self, command):
        """Return each axis's direction: True forward, False back, None for an axis that the command does not name."""
        return [steps > 0 if steps else None for steps in command.steps]

    def _steps_to_add(self, axis, command):
        """Return the signed steps that a jog adds to the one under way: no more than jog.ahead_ms ahead of the pins."""
        steps = command.steps[axis]
        ahead = abs(self._queue.target[axis] - self._queue.position_view()[axis])
        if not ahead:
            return steps
        over, ms = command.rates[axis]
        more = min(max(over * self._ahead_ms // ms - ahead, 0), abs(steps))
        return more if steps > 0 else -more

    @micropython.native
    def _step_interval(self, axis, rate):
        """Return the whole ticks between two steps at `rate`, (steps, milliseconds); 0 if that is faster than the axis may go, or too slow."""
        steps, ms = rate
        if steps < 1 or ms < 1 or steps * 1000 > self._fastest[axis] * ms:
            return 0
        each = ms * TICKS_PER_MS // steps
        return each if 2 * self.walker.least <= each < COUNT_MASK else 0

    @micropython.native
    def _is_reachable(self, axis, steps, limited):
        """Return False if soft limits (`limited`) forbid the steps, or they are too many to be counted."""
        endless = abs(steps) == FOREVER
        if not endless and abs(steps) > MOST_STEPS - (max(self.walker.steps_to_go(axis), 0) if self._command else 0):
            return False
        if not limited:
            return True
        if endless or self._command and self._turns_round(axis, steps):
            return False
        low, high = self._queue.reach(axis)
        return low <= self._queue.target[axis] + steps <= high

    @micropython.native
    def _turns_round(self, axis, steps):
        """Return True if the steps lead against those to come."""
        return self.walker.steps_to_go(axis) and self.walker.counts_down(axis) != (steps < 0)

    @micropython.native
    def _start_axes(self, command, intervals):
        """Set each axis of a RUN going, `intervals` ticks a step (None: it runs on), and queue the walker if it is not."""
        machine = self._machine
        walker = self.walker
        target = self._queue.target
        if self._command is None:
            self._from = target[:]  # the position at its start
            self._jog = None
        if command.when == AS_JOG:
            self._jog = self._directions_of(command)
            machine.jogging = True
        if self._off or command.unpowered:
            self._off = command.unpowered
            self._switch_off()
        for axis in range(len(intervals)):
            each = intervals[axis]
            if each is None:
                continue
            steps = command.steps[axis]
            if steps and self._command and command.when == AS_JOG:
                steps = self._steps_to_add(axis, command)
                if not steps:
                    continue
            over, ms = command.rates[axis]
            rest = ms * TICKS_PER_MS % over
            if not steps:
                walker.run_axis(axis, 0, each, rest, over, walker.counts_down(axis), True)
            elif abs(steps) == FOREVER:
                walker.run_axis(axis, ENDLESS, each, rest, over, steps < 0)
            else:
                add = self._command is not None and not self._turns_round(axis, steps)
                walker.run_axis(axis, abs(steps), each, rest, over, steps < 0, add)
                target[axis] += steps
        self._command = command
        if not walker.running and walker.active():
            self._queue.run(walker)

    def _set_limits(self):
        """Take the axes' highest speeds and accelerations from the settings, if these have changed."""
        settings = self._machine.settings
        if self._limits_of == settings.version:
            return
        self._limits_of = settings.version
        for axis in range(len(self._axes)):
            steps_per_m = settings.value(table.STEPS + axis)
            self._fastest[axis] = fastest = max(settings.value(table.SPEED + axis) * steps_per_m // 60_000_000, 1)
            if self._ramps:
                acceleration = settings.value(table.ACCELERATION + axis) * steps_per_m // 1_000_000
                self.walker.set_limits(axis, fastest, max(acceleration, 1))

    def _stop_axes(self, command):
        """Do REST: stop the axes of the mask; those of `unpowered` lose their current at rest."""
        for axis in range(len(self._axes)):
            if command.value >> axis & 1 and not self.walker.is_at_rest(axis):
                self.walker.stop(axis)
        self._off = command.unpowered
        if self._command is None and self._off == self._all and self._queue.still():
            self._machine.motors.drives(False)
        return self._machine.confirm_command(command)

    def _keep_jogs(self, command):
        """Do STILL: keep the jogs in the settings; only at a stand."""
        machine = self._machine
        if machine.state not in _STANDING or not self._queue.still():
            return errors.BUSY
        if command.value:
            machine.settings.keep_jogs(*command.value)
        return machine.confirm_command(command)

    def _set_zero(self, command):
        """Do ZERO: the position becomes 0; only at a stand of a machine that is not homed."""
        machine = self._machine
        if machine.alarm or machine.sleeping:
            return errors.LOCKED
        if machine.state not in _STANDING or not self._queue.still():
            return errors.BUSY
        if machine.homed:
            return ZERO_IS_HOMED
        made = self.steps_made()
        self._queue.set_origin()
        self._from = [-steps for steps in made]
        return machine.confirm_command(command)
