"""Motion as it comes: lines, arcs, jogs, probing, dwell, pauses, spindle and coolant, overrides.

Everything is in steps and nanometres a second; no language's units or modes are known here.
"""

from micropython import const

from passo.control import settings as table
from passo.motion.integers import length_nm
from passo.motion.line import MAX_STEPS
from passo.protocols import commands, errors
from passo.steps.word import TICKS_PER_S

LATER = const(-1)
_BLOCKS_A_MOTION = const(2)  # a change of the tool, and the motion
OFF = const(5)  # spindle
_LOWEST, _HIGHEST = 10, 200  # of feed and spindle override, per cent
_PROBE_AWAY = const(1)
_PROBE_MAY_MISS = const(2)


class Program:
    def __init__(self, board, queue, machine, planner, port):
        self._axes = board["axes"]
        self._queue = queue
        self._machine = machine
        self._planner = planner
        self._port = port
        self._outputs = [item["name"] for item in board["outputs"]]
        self.jogging = False
        self._active = False  # motion has been queued and has not come to its end
        self._fresh = False  # motion was queued since the last turn
        self._limits_of = None  # the settings' version that the planner knows
        self._touch = None  # where the probe changed
        self._command = None  # what _ticks works on
        self._restart()

    def _restart(self):
        self.overrides = [100, 100, 100]  # feed, rapid, spindle
        self.spindle = OFF
        self.power = 0
        self.coolant = 0

    def handlers(self):
        return {
            commands.LINE: self._motion,
            commands.ARC: self._motion,
            commands.JOG_TO: self._jog,
            commands.PROBE: self._probe,
            commands.DWELL: self._dwell,
            commands.SYNC: self._sync,
            commands.PAUSE: self._pause,
            commands.SPINDLE: self._turn_spindle,
            commands.COOLANT: self._cool,
            commands.OVERRIDE: self._override,
        }

    def active(self):
        return self._active

    def clear(self):
        """All motion has been dropped."""
        self.jogging = self._active = self._fresh = False
        self._touch = None

    def restart(self):
        """As after power-up, outputs too."""
        self._restart()
        self.set_coolant(0)
        self.show_outputs(False)

    def laser(self):
        return self._machine.settings.value(table.LASER)

    # --- motion

    def _motion(self, command):
        error = self._unready(command)
        if error:
            return error
        machine = self._machine
        if not self._reachable(command):
            machine.fail(errors.ALARM_SOFT_LIMIT)
            return errors.JOG_TRAVEL
        if machine.checking:
            self._queue.target = command.target[:]
            return machine.accepted(command)
        return self._begin(command)

    def _begin(self, command):
        if self._queue.room() < _BLOCKS_A_MOTION:
            self._queue.flush()
            return LATER
        self._queue_motion(command)
        self._active = self._fresh = True
        return self._machine.accepted(command)

    def _jog(self, command):
        error = self._unready(command)
        if error and error != LATER:
            return error
        if self._machine.state not in ("idle", "jog") or self._machine.pauses.dropping:
            return LATER if self._machine.pauses.dropping else errors.BUSY
        if not self._reachable(command):
            return errors.JOG_TRAVEL
        result = self._begin(command)
        self.jogging = self.jogging or result == 0
        return result

    def _unready(self, command):
        """0, LATER, or why this motion cannot be."""
        machine = self._machine
        if machine.alarm or machine.sleeping:
            return errors.LOCKED
        if machine.command is not None or machine.objects.drawing or machine.pauses.dropping:
            return LATER
        longest = max([abs(by) for by in self._queue.deltas(command.target)])
        return errors.TARGET if longest > MAX_STEPS else 0

    def _reachable(self, command):
        machine = self._machine
        if not machine.settings.value(table.SOFT_LIMITS) or not machine.homed:
            return True
        return self._queue.inside(command.target)

    def _queue_motion(self, command):
        self._command = command
        self._queue.line(command.target, self._ticks, command.tool, (command.number, command.feed))

    def _ticks(self, deltas):
        """How long a line lasts: at its feed, but no axis faster than it may."""
        command = self._command
        settings = self._machine.settings
        least = 1
        for axis in range(len(deltas)):
            steps_m = settings.value(table.STEPS + axis) * settings.value(table.SPEED + axis)  # 10⁻⁶ × steps/min
            least = max(least, abs(deltas[axis]) * 60_000_000 * TICKS_PER_S // steps_m)
        if command.per_min:
            return max(least, 60_000 * TICKS_PER_S // command.per_min)
        if not command.feed:
            return least * 100 // self.overrides[1]
        return max(least, self._queue.ticks_at(deltas, command.feed * self.overrides[0] // 100 or 1))

    # --- probing

    def _probe(self, command):
        machine = self._machine
        error = self._unready(command)
        if error:
            return error
        if not machine.inputs.has_probe:
            return errors.NO_PROBE
        if not self._settled():
            return LATER
        machine.command = command
        if machine.checking:
            machine.finish((self._queue.position(), False))
            return 0
        if not self._reachable(command):
            machine.command = None
            machine.fail(errors.ALARM_SOFT_LIMIT)
            return errors.JOG_TRAVEL
        if machine.inputs.touched() != bool(command.value & _PROBE_AWAY):
            machine.finish((self._queue.position(), False))
            machine.fail(errors.ALARM_PROBE_STATE)
            return 0
        self._touch = None
        self._queue_motion(command)
        self._queue.flush()
        self._active = True
        return 0

    def _poll_probe(self):
        machine = self._machine
        command = machine.command
        queue = self._queue
        if self._touch is None and machine.inputs.touched() != bool(command.value & _PROBE_AWAY):
            self._touch = queue.position()
            machine.pauses.drop()
        elif self._touch is None and queue.still():
            machine.finish((queue.position(), False))
            if not command.value & _PROBE_MAY_MISS:
                machine.fail(errors.ALARM_PROBE_MISSED)

    def dropped(self):
        """A hold has come to its stand, and what was queued behind it is gone."""
        if self._touch is not None and self._machine.busy_with(commands.PROBE):
            self._machine.finish((self._touch, True))
        self.clear()

    # --- what waits for the motion before it

    def _settled(self):
        """True when everything before has ended; asks for it to end."""
        if self._queue.still():
            return True
        self._queue.flush()
        return False

    def _gate(self):
        """0, LATER, or the error of a command that waits for the motion before it."""
        machine = self._machine
        if machine.alarm or machine.sleeping:
            return errors.LOCKED
        if machine.command is not None or machine.objects.drawing or not self._settled():
            return LATER
        return 0

    def _sync(self, command):
        return self._gate() or self._machine.accepted(command)

    def _dwell(self, command):
        machine = self._machine
        result = self._gate()
        if result:
            return result
        if machine.checking or not command.value:
            return machine.accepted(command)
        self._queue.wait((command.value + 999) // 1000, (0, 0))
        self._queue.flush()
        self._active = True
        machine.command = command
        return 0

    def _pause(self, command):
        machine = self._machine
        result = self._gate()
        if result:
            return result
        if machine.checking:
            return machine.accepted(command)
        machine.command = command
        machine.pauses.pause()
        return 0

    # --- spindle, coolant, overrides

    def _turn_spindle(self, command):
        machine = self._machine
        laser = self.laser()
        if machine.alarm or machine.sleeping:
            return errors.LOCKED
        if laser:
            if machine.command is not None or self._queue.room() < _BLOCKS_A_MOTION:
                return LATER
        else:
            result = self._gate()
            if result:
                return result
        if not machine.checking:
            self.spindle = command.value
            self.power = command.power if command.value != OFF else 0
            self._put("reverse", command.value == 4)
            if command.tool != self._queue.tool:
                self._queue.set_tool(command.tool, (0, 0))
                self._active = self._fresh = True
                if not laser:
                    self._queue.flush()
                    machine.command = command
                    return 0
        return machine.accepted(command)

    def _cool(self, command):
        result = self._gate()
        if result:
            return result
        if not self._machine.checking:
            self.set_coolant(command.value)
        return self._machine.accepted(command)

    def set_coolant(self, value):
        self.coolant = value
        self._put("flood", value & 1)
        self._put("mist", value & 2)

    def show_outputs(self, on):
        """The spindle's direction, off while the tool is off in a pause."""
        self._put("reverse", on and self.spindle == 4)

    def _put(self, name, on):
        if name in self._outputs:
            self._port.output(name, bool(on))

    def _override(self, command):
        which = command.value
        if which == commands.ALL:
            self.overrides = [100, 100, 100]
        elif command.power:
            self.overrides[which] = command.power
        else:
            self.overrides[which] = max(_LOWEST, min(_HIGHEST, self.overrides[which] + command.feed))
        return self._machine.accepted(command)

    # --- what goes on over many turns

    def poll(self):
        machine = self._machine
        if machine.busy_with(commands.PROBE):
            self._poll_probe()
        elif (machine.busy_with(commands.DWELL) or machine.busy_with(commands.SPINDLE)) and self._queue.still():
            machine.finish()
        if self._queue.waiting and not self._fresh:
            self._queue.flush()
        self._fresh = False
        if self._active and self._queue.still():
            self._active = False

    def report(self, report):
        """What the status report says of motion and tool."""
        block = self._queue.playing()
        tag = block.tag if block is not None else None
        number, feed = tag if isinstance(tag, tuple) else (0, 0)
        report["number"] = number
        report["feed"] = feed
        report["power"] = min(self.power * self.overrides[2] // 100, 1_000_000)
        report["spindle"] = self.spindle
        report["coolant"] = self.coolant
        report["overrides"] = tuple(self.overrides)
