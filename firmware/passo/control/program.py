"""Motion as it comes: lines, arcs, jogs, probing, dwell and pauses.

Everything is in steps and nanometres a second; no language's units or modes are known here.
"""

import micropython
from micropython import const

from passo import commands, errors
from passo.commands import thousandths
from passo.config import setting_numbers as table
from passo.control.feature import BY_HAND, QUEUE_GONE, WORK_GONE
from passo.control.line_batches import LineBatches, queue_lines
from passo.errors import LATER
from passo.motion.limits import Limits
from passo.motion.line import MAX_STEPS
from passo.motion.row_viper import room
from passo.records import *

_BLOCKS_A_MOTION = const(2)  # a change of the tool, and the motion
_DWELL_MS = const(3_600_000)  # of a dwell are queued at a time: the whole queue holds 7680 s
_PROBE_AWAY = const(1)
_PROBE_MAY_MISS = const(2)


def minute_ticks(command):
    """Return the duration of a motion that has `per_min`, in ticks."""
    return 60_000 * TICKS_PER_S // command.per_min


class Program(LineBatches):
    event_mask = QUEUE_GONE | WORK_GONE
    _queue_otherwise = None  # an option's method (command, ticks): it queues the motion and returns True, or leaves it; may raise ValueError
    _steady_mm_min = 0  # an option's: the speed up to which there are no ramps, if $140 has a lower one

    def __init__(self, board, machine, queue):
        self._limits_of = None  # the settings' version whose limits the planner knows
        self._dwell_ms = 0  # the part of the dwell under way that is not queued yet
        self._touch = None  # the probe's position at its change, kept by its pin's interrupt:
        self._latch = machine.port.watch_limit("probe") if machine.inputs.has_probe else None
        LineBatches.__init__(self, board, machine, queue)

    def handlers(self):
        """Return {kind of command: method} of this feature."""
        return {
            commands.LINE: self._accept_motion,
            commands.ARC: self._accept_motion,
            commands.JOG_TO: self._accept_jog,
            commands.PROBE: self._begin_probe,
            commands.DWELL: self._begin_dwell,
            commands.SYNC: self._answer_sync,
        }

    def on_events(self, what):
        """Finish PROBE with the position of the contact, once the hold has come to its stand."""
        if what & QUEUE_GONE and self._touch is not None and self._machine.busy_with(commands.PROBE):
            self._machine.finish((self._touch, True))
        self._touch = None

    # --- motion

    def _accept_motion(self, command):
        """Queue a LINE or ARC, or only check it. Returns 0, LATER, or an error; a target outside the travel is an alarm."""
        error = self._motion_error(command)
        if error:
            return error
        machine = self._machine
        if command.kind == commands.LINE and not machine.checking and self._queue_row(command):
            return machine.confirm_command(command)
        if command.kind != commands.LINE or machine.checking:  # of a line the planner finds out
            error = self._length_error(command)
            if error:
                return error
        if not self._can_reach(command):
            machine.raise_alarm(errors.ALARM_SOFT_LIMIT)
            return errors.JOG_TRAVEL
        if machine.veto is not None and machine.veto.denied:
            if self._forbidden_error(command, False):  # the blocks queued before it may lead out of it
                return self._forbidden_error(command) if machine.settle() else LATER
        if command.dots and not self.dots[DOTS_MASK]:
            return errors.NO_MEMORY
        if command.also:
            error = self._followers_error(command)
            if error:
                return error
        return self._advance_target(command) if machine.checking else self._begin_motion(command)

    def _forbidden_error(self, command, note=True):
        """Return 0, or INTERLOCKED if a motion is forbidden; of an arc's plane it must allow both directions."""
        machine = self._machine
        if machine.checking:
            return 0
        deltas = self._queue.deltas(command.target)
        error = machine.interlock_error(deltas, command.tool, note)
        if command.kind == commands.ARC:
            for axis in (command.first, command.second):
                for sign in (1, -1):
                    deltas[axis] = sign
                    error = error or machine.interlock_error(deltas, False, note)
        for motion in command.also:
            error = error or machine.interlock_error([to - at for to, at in zip(motion.target, command.target)], False, note)
        return error

    def _advance_target(self, command):
        """Move the queue's target as if the motion had been queued: it is only checked."""
        self._queue.lead(command.target)
        return self._machine.confirm_command(command)

    def _followers_error(self, command):
        """Return 0, or the error of one of the lines that follow `command`: then none of them begins."""
        self._set_limits()
        start = command.target
        for motion in command.also:
            if not self._is_within_travel(motion.target):
                self._machine.raise_alarm(errors.ALARM_SOFT_LIMIT)
                return errors.JOG_TRAVEL
            deltas = [to - at for to, at in zip(motion.target, start)]
            try:
                self._queue.fits(deltas, motion.feed, minute_ticks(motion) if motion.per_min else 0)
            except ValueError:
                return errors.TARGET
            start = motion.target
        return 0

    def _begin_motion(self, command):
        """Queue a checked motion. Returns 0, LATER until the planner has room, or an error."""
        if self._queue.room() < _BLOCKS_A_MOTION:
            return LATER
        if command.dots and self._lacks_dots(command.dots):
            return LATER
        error = self._queue_motion(command)
        if error:
            return error
        if self._machine.cautious:
            self._machine.caution()
        self._machine.note_motion()
        return self._machine.confirm_command(command)

    def _accept_jog(self, command):
        """Queue JOG_TO. Returns 0, LATER, BUSY, or JOG_TRAVEL, which is no alarm."""
        machine = self._machine
        if machine.state not in ("idle", "jog") or machine.motors.detached or machine.dropping or machine.actives and machine.axes_are_owned():
            error = self._motion_error(command) or self._length_error(command)
            return error if error and error != LATER else LATER if machine.dropping else errors.BUSY
        if not machine.jogging:
            machine.inform(BY_HAND)
        if self._queue_row(command):
            machine.jogging = True
            return machine.confirm_command(command)
        error = self._length_error(command) or (0 if self._can_reach(command) else errors.JOG_TRAVEL)
        error = error or self._forbidden_error(command) or self._begin_motion(command)
        machine.jogging = machine.jogging or error == 0
        return error

    def _queue_row(self, command):
        """Queue a line or jog as a row of a batch: one kernel checks its travel, makes its block and plans it. Return False if the kernel
        cannot take it: then Planner.line() queues or refuses it."""
        machine, queue, planner = self._machine, self._queue, self._planner
        if (
            not planner.ready or self._limits_of != machine.settings.version or queue.chords
            or command.per_min or command.also or command.dots or command.feed > FASTEST_NM_S or command.tool != queue.tool
            or command.dynamic != planner.dynamic or command.power != 1000 * planner.power
            or machine.veto is not None and machine.veto.denied or room(planner.indices) < _BLOCKS_A_MOTION
            or queue.turns and command.target[-1] != queue.target[-1]  # F counts for the linear axes only, see options/rotary
        ):  # fmt: skip
            return False
        reach = self._travel if machine.homed else None
        if self._reached is not reach:
            self._set_trace_range(reach)
        row, target, trace = planner.batch, queue.target, self._trace
        row[BATCH_FLAGS] = (1 if command.tool else 0) | (0 if command.feed else 2) | (4 if command.dynamic else 0)
        row[BATCH_FEED] = command.feed
        row[BATCH_POWER] = planner.power
        row[BATCH_TAG] = command.number
        for axis in range(len(target)):
            row[BATCH_STEPS + axis] = command.target[axis] - target[axis]
        queue_lines(row, 1, target, trace, *planner.arrays)
        trace[TRACE_MOVED] = 0  # tool and power stay as they are
        if not trace[TRACE_TAKEN]:
            return False
        if machine.cautious:
            machine.caution()
        queue.waiting = machine.active = machine.fresh = machine.awake = True
        return True

    def _motion_error(self, command):
        """Return 0, LATER, or the error that forbids motion now."""
        machine = self._machine
        if machine.alarm or machine.sleeping:
            return errors.LOCKED
        if machine.motors.detached and not machine.checking:
            return errors.NO_MOTORS
        if machine.command is not None or machine.drawing or machine.dropping or machine.actives and machine.axes_are_owned():
            return LATER
        return 0

    def _length_error(self, command):
        """Return JOG_TRAVEL if the motion is longer than the planner counts (MAX_STEPS of an axis), else 0."""
        longest = max([abs(by) for by in self._queue.deltas(command.target)])
        return errors.JOG_TRAVEL if longest > MAX_STEPS else 0

    def _queue_motion(self, command):
        """Return 0, or the error number of the planner's refusal."""
        planner = self._planner
        if self._limits_of != self._machine.settings.version:
            self._set_limits()
        power = after = thousandths(command.power)
        if command.dots and any(self._queue.deltas(command.target)):
            power = self._keep_dots(command.dots, after)
        changes = power != planner.power or command.tool != self._queue.tool
        if changes or command.dynamic != planner.dynamic:
            planner.set_power(power, command.dynamic)
            if changes and not command.dynamic:
                if not any(self._queue.deltas(command.target)) and not self._is_full_circle(command):
                    self._queue.set_tool(command.tool, command.number)  # no step carries the laser's change
        ticks = minute_ticks(command) if command.per_min else 0
        error = 0
        try:
            if self._queue_otherwise is None or not self._queue_otherwise(command, ticks):
                if command.kind == commands.ARC:
                    self._queue.arc(command, ticks)
                else:
                    self._queue.go(command.target, command.feed, ticks, command.tool, command.number)
        except ValueError:
            error = errors.RADIUS if command.kind == commands.ARC else self._length_error(command) or errors.TARGET
        if power > POWER_MOST:
            planner.set_power(after, command.dynamic)
            if error:
                self.dots[DOTS_HEAD] = power >> DOTS_FIRST
        return error

    def _lacks_dots(self, dots):
        """Return True if the queue has no room for these dots yet."""
        ring = self.dots
        return len(dots) > (ring[DOTS_TAIL] - ring[DOTS_HEAD] - 1) & ring[DOTS_MASK]

    def _keep_dots(self, dots, last):
        """Put the dots of a row into the ring that the feeder reads. Returns the power word of its block."""
        ring = self.dots
        first = head = ring[DOTS_HEAD]
        for level in dots:
            at, by = ring[DOTS_AT] + head // 3, head % 3 * DOTS_COUNT
            ring[at] = ring[at] & ~(DOTS_POWER << by) | level << by
            head = head + 1 & ring[DOTS_MASK]
        ring[DOTS_HEAD] = head
        return last | len(dots) << DOTS_COUNT | first << DOTS_FIRST

    def _is_full_circle(self, command):
        """Return True for an arc that comes back to its start."""
        return command.kind == commands.ARC and any(command.centre) and (command.over_half or command.turns > 1)

    def _set_limits(self):
        """Give the planner the limits of the settings. It takes them only while it is empty."""
        settings = self._machine.settings
        if not self._queue.still():
            return
        self._limits_of = settings.version
        reach = self.reach()
        if self._reached is not reach:
            self._set_trace_range(reach)
        axes = range(len(self._axes))
        limits = Limits(
            [settings.value(table.STEPS + axis) for axis in axes],
            [settings.value(table.SPEED + axis) * 50 // 3 or 1 for axis in axes],
            [settings.value(table.ACCELERATION + axis) * 1000 for axis in axes],
            settings.value(table.JUNCTION) * 1000,
            max(settings.value(table.START), self._steady_mm_min * 1000) * 50 // 3,
            settings.value(table.JERK) * 1000 if settings.places(table.JERK) is not None else 0,
        )
        limits = self._planner.limits(limits)
        shift = 0
        while limits.fastest >> shift >= 1 << 30:
            shift += 1
        seen = self._queue.seen
        seen[SEEN_FASTEST], seen[SEEN_SHIFT] = limits.fastest >> shift, shift

    # --- probing

    def _begin_probe(self, command):
        """Begin PROBE at a stand. `value`: _PROBE_AWAY, _PROBE_MAY_MISS. Returns 0, LATER, or an error."""
        machine = self._machine
        error = self._motion_error(command)
        if error:
            return error
        if not machine.inputs.has_probe:
            return errors.NO_PROBE
        if not machine.settle():
            return LATER
        if machine.checking:
            return self._advance_target(command)
        if not self._can_reach(command):
            machine.raise_alarm(errors.ALARM_SOFT_LIMIT)
            return errors.JOG_TRAVEL
        if machine.inputs.read("probe") != bool(command.value & _PROBE_AWAY):
            return self._end_missed_probe(command, errors.ALARM_PROBE_STATE)
        error = self._forbidden_error(command)
        if error:
            return error
        self._touch = None
        if self._latch:
            self._latch.begin(*self._queue.lend())
        error = self._queue_motion(command)
        if error:
            return error
        self._queue.flush()
        machine.active = True
        return machine.begin(command)

    def _poll_probe(self, still):
        """Stop at the probe's contact, or end PROBE without one. `still`: the machine stood before this call."""
        machine = self._machine
        command = machine.command
        queue = self._queue
        if self._touch is not None:
            return
        latch = self._latch
        seen = latch and latch.seen  # read before the pin: an edge that comes between the two is a contact, and begin() would forget it
        if machine.inputs.read("probe") != bool(command.value & _PROBE_AWAY):
            self._touch = queue.position(latch if latch and latch.seen else None)
            machine.drop_at_stand()
        elif still:
            self._end_missed_probe(command, 0 if command.value & _PROBE_MAY_MISS else errors.ALARM_PROBE_MISSED)
        elif seen:  # over by now: noise
            latch.begin(*queue.lend())

    def _end_missed_probe(self, command, alarm):
        """End PROBE without a contact. `alarm`: raised before the answer; 0: none."""
        machine = self._machine
        machine.command = None
        if alarm:
            machine.raise_alarm(alarm)
        machine.command = command
        machine.finish((self._queue.position(), False))
        return 0

    # --- what waits for the motion before it

    def _answer_sync(self, command):
        """Answer SYNC once all motion before it has ended; until then return LATER."""
        return self._machine.gate() or self._machine.confirm_command(command)

    def _begin_dwell(self, command):
        """Begin DWELL, `value` µs, rounded up to ms. Returns 0, LATER until the machine stands, or an error."""
        machine = self._machine
        result = machine.gate()
        if result:
            return result
        if machine.checking or not command.value:
            return machine.confirm_command(command)
        self._dwell_ms = (command.value + 999) // 1000
        self._go_on_dwelling()
        machine.active = True
        return machine.begin(command)

    def _go_on_dwelling(self):
        """Queue the next hour of a dwell, or the rest of it if that is less."""
        ms = min(self._dwell_ms, _DWELL_MS)
        self._dwell_ms -= ms
        self._queue.wait(ms, 0)
        self._queue.flush()

    # --- what goes on over many cycles

    def poll_end(self, still):
        """Go on with arcs, probe, dwell and the stream of lines, and give the planner changed limits at a stand."""
        machine = self._machine
        queue = self._queue
        if queue.chords:
            queue.feed()
        if machine.command is not None:
            kind = machine.command.kind
            if kind == commands.PROBE:
                self._poll_probe(still)
            elif still and self._dwell_ms and kind == commands.DWELL:
                self._go_on_dwelling()
            elif still and (kind == commands.DWELL or kind == commands.SPINDLE and machine.is_at_speed()):
                machine.finish()
        if queue.streams or machine.fresh:
            queue.stream(machine.fresh, machine.port.machine_ms())
        if queue.waiting and (queue.eager or not machine.fresh):
            queue.begin()
        if self._limits_of != machine.settings.version:
            self._set_limits()
        machine.fresh = False
        machine.active = machine.active and not still
        if queue.streams or queue.waiting:
            machine.awake = True
