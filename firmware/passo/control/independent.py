"""Axes that run on their own: each so many steps, or for ever, at its own rate, from the moment it is asked.

    part = Independent(board, controller)     # registers RUN, REST, ZERO and STILL with the controller
    part.made()                               # steps of each axis since the last RUN from a stand

A RUN that may only begin at a stand is refused as BUSY while anything moves; one marked as a jog also extends a jog of
the same axes in the same directions, without a gap; one marked as live changes what moves: axes named set out, turn or
take another rate, the others run on undisturbed. Where the board file asks for it (planning.independent_ramps), each
axis keeps its own limits of speed and acceleration; otherwise the rate is constant from the first step to the last.

Where soft limits hold, an endless run and a turn on the way are refused: where they end is not known.
"""

from micropython import const

from passo.control import settings as table
from passo.control.part import Part
from passo.protocols import commands, errors
from passo.protocols.commands import FINISHED, FOREVER, Event
from passo.steps.timed import ENDLESS, MOST_STEPS
from passo.steps.word import COUNT_MASK, TICKS_PER_MS

LATER = const(-1)
_HALF = const(0x10000000)
_STANDING = ("idle", "alarm", "check", "sleep")


class Independent(Part):
    def __init__(self, board, machine):
        self._axes = board["axes"]
        self._queue = machine.queue
        self._machine = machine
        self._ramps = board["planning"]["independent_ramps"]
        self._limits_of = None  # the settings' version that the walker knows
        self.walker = self._queue.independent()
        self._command = None  # the last RUN accepted: its link hears of the end
        self._jog = None  # directions of the jog under way
        self._moving = False
        self._all = (1 << len(self._axes)) - 1
        self._off = self._limp = 0  # masks of the axes that shall have no current, and of those that have none
        self._from = self._places()
        machine.add(self)

    def handlers(self):
        return {
            commands.RUN: self._run,
            commands.REST: self._rest,
            commands.ZERO: self._zero,
            commands.STILL: self._still,
        }

    def active(self):
        """True from a RUN to the stand behind it."""
        return self._moving

    def made(self):
        """Signed steps of each axis since the last RUN that began at a stand, exact at this moment."""
        return [((now - then + _HALF) & COUNT_MASK) - _HALF for now, then in zip(self._places(), self._from)]

    def clear(self):
        """All motion has been dropped."""
        self._command = self._jog = None
        self._moving = False
        self._off = 0
        self._switch_off()

    def report(self, report):
        report["made"] = self.made()

    def poll(self):
        """Notices the end, and tells who asked last."""
        if not self._moving:
            return
        self._switch_off()
        if self.walker.running or not self._queue.still():
            return
        command = self._command
        if self._off == self._all:
            self._machine.drives(False)
        self.clear()
        self._queue.settle()
        self._machine.tell(Event(FINISHED, command))

    def _switch_off(self):
        """Take the current from the axes that shall have none and stand, and give it back to the others."""
        limp = 0
        for axis in range(len(self._axes)):
            if self._off >> axis & 1 and self.walker.stands(axis):
                limp |= 1 << axis
        if limp != self._limp:
            self._limp = limp
            self._machine.limp(limp)

    def turning(self, axis):
        """True while steps of an axis are to come."""
        return self.walker.togo(axis) != 0

    def _places(self):
        return [self._machine.place(axis) for axis in range(len(self._axes))]

    # --- commands

    def _run(self, command):
        machine = self._machine
        error = machine.unready()
        if error:
            return error
        if self._moving:
            if not self._may_join(command):
                return errors.BUSY
        elif machine.state not in ("idle", "check") or not self._queue.still():
            return errors.BUSY
        rates = {}
        for axis in range(len(command.steps)):
            steps = command.steps[axis]
            if steps is None:
                continue
            rates[axis] = rate = self._rate(axis, command.rates[axis])
            if not rate or rate[0] < 2 * self.walker.least or rate[0] >= COUNT_MASK:
                return errors.SPEED_RANGE
            if steps and not self._reachable(axis, steps, command):
                return errors.TRAVEL
        if machine.checking:
            return machine.accepted(command)
        if not self._queue.room():
            return LATER
        self._start(command, rates)
        return machine.accepted(command)

    def _may_join(self, command):
        """True if `command` may come while a RUN is under way."""
        machine = self._machine
        if machine.pauses.kind or machine.pauses.dropping:
            return False
        if command.when == commands.LIVE:
            return True
        return command.when == commands.AS_JOG and self._jog == self._directions(command)

    def _directions(self, command):
        return [None if not steps else steps > 0 for steps in command.steps]

    def _rate(self, axis, rate):
        """(each, rest, over) of `rate`, which is (steps, milliseconds); None above the axis's highest speed."""
        steps, ms = rate
        if steps < 1 or ms < 1:
            return None
        settings = self._machine.settings
        fastest = settings.value(table.SPEED + axis) * settings.value(table.STEPS + axis)  # steps in 60 000 s
        if steps * 60_000_000_000 > fastest * ms:
            return None
        ticks = ms * TICKS_PER_MS
        return ticks // steps, ticks % steps, steps

    def _reachable(self, axis, steps, command):
        machine = self._machine
        endless = abs(steps) == FOREVER
        limited = machine.settings.value(table.SOFT_LIMITS) and machine.homed
        if not endless:
            togo = max(self.walker.togo(axis), 0)
            if abs(steps) + togo > MOST_STEPS:
                return False
        if not limited:
            return True
        if endless or self._moving and self._turns(axis, steps):
            return False
        low, high = self._queue.reach(axis)
        return low <= self._queue.target[axis] + steps <= high

    def _turns(self, axis, steps):
        return self.walker.togo(axis) and self.walker.negative(axis) != (steps < 0)

    def _start(self, command, rates):
        machine = self._machine
        walker = self.walker
        if not self._moving:
            self._set_limits()
            self._from = self._places()
            self._moving = True
            self._jog = None
        if command.when == commands.AS_JOG:
            self._jog = self._directions(command)
            machine.program.jogging = True
        self._off = command.limp
        self._switch_off()
        for axis, (each, rest, over) in rates.items():
            steps = command.steps[axis]
            if not steps:
                walker.rate(axis, each, rest, over)
                continue
            count = ENDLESS if abs(steps) == FOREVER else abs(steps)
            add = count != ENDLESS and not self._turns(axis, steps)
            walker.set(axis, count, each, rest, over, steps < 0, add)
            if count != ENDLESS:
                self._queue.target[axis] += steps
        self._command = command
        if not walker.running and walker.active():
            self._queue.run(walker)

    def _set_limits(self):
        settings = self._machine.settings
        if not self._ramps or self._limits_of == settings.version:
            return
        self._limits_of = settings.version
        for axis in range(len(self._axes)):
            steps_per_m = settings.value(table.STEPS + axis)
            fastest = max(settings.value(table.SPEED + axis) * steps_per_m // 60_000_000, 1)
            self.walker.limits(axis, fastest, max(settings.value(table.ACCELERATION + axis) * steps_per_m // 1_000_000, 1))

    def _rest(self, command):
        for axis in range(len(self._axes)):
            if command.value >> axis & 1 and not self.walker.stands(axis):
                self.walker.stop(axis)
        self._off = command.limp
        if not self._moving and self._off == self._all and self._queue.still():
            self._machine.drives(False)
        return self._machine.accepted(command)

    def _still(self, command):
        machine = self._machine
        if machine.state not in _STANDING or not self._queue.still():
            return errors.BUSY
        return machine.accepted(command)

    def _zero(self, command):
        machine = self._machine
        if machine.alarm or machine.sleeping:
            return errors.LOCKED
        if machine.state not in _STANDING or not self._queue.still():
            return errors.BUSY
        if machine.homed:
            return errors.ZERO_IS_HOMED
        self._queue.set_origin()
        return machine.accepted(command)
