"""Homing on switches or optical barriers: axes one after the other, or a group of them at once, in phases:

    1 leave     if the head stands on a sensor, move away until all are free
    2 seek      quickly towards the sensors; each axis goes on until its own trips
    3 pull off  away from where it tripped
    4 locate    slowly towards it: this edge counts
    5 square    of an axis with two motors: the other side alone, until its own sensor trips; see machine.squaring
    6 pull off  to the origin, a fixed distance from that edge

Each phase has a travel limit; reaching it is an alarm. The edge is where the sensor first moved, not where its
debouncing ended, so a bouncing sensor gives the same origin every time. The interrupt of its pin keeps the position of
that step: a cycle of the main loop may last longer than a step.
"""

from micropython import const

from passo import commands, errors
from passo.config import setting_numbers as table
from passo.control.feature import HOMING, Feature
from passo.control.sensor import Sensor
from passo.errors import LATER

_ON_ITS_WAY = const(-1)


class Seeker:
    """An axis on its way to its sensor; one with two motors has two sensors, one at each side."""

    def __init__(self, axis, position, sensors, away, values, distance):
        self.axis = axis
        self.start = position
        self.sensors = sensors
        self.away = away  # the sign of steps away from the sensors' end
        self.seek_steps_s, self.locate_steps_s, self.pull_off_steps = values
        self.distance = distance  # the longest search
        self.ends = [self.pull_off_steps] * len(sensors)  # how far from the edge of each it ends
        self.tripped = 0  # the number of the last sensor that changed
        self.edges = [position] * len(sensors)  # the position of each change: kept, for a sensor that is left shows another edge
        self.goal = 0  # the end of this phase's way
        self.steps_s = 1
        self.done = False

    def note(self, number):
        """Note the position at which sensor `number` changed."""
        self.edges[number] = self.sensors[number].edge

    def has_reached(self, active):
        """Return True if one sensor is active (`active` True), or all are free (False). Notes which one is active."""
        for number in range(len(self.sensors)):
            if self.sensors[number].active:
                if active:
                    self.tripped = number
                return active
        return not active


class Homing(Feature):
    def __init__(self, board, machine, queue):
        self._config = board["homing"]
        self._axes = board["axes"]
        Feature.__init__(self, board, machine, queue)
        self._lifting = False  # homing waits for the tool
        names = [axis["name"] for axis in self._axes]
        self._all = sum([1 << names.index(name) for name in names if name in self._config["sensors"]])  # of those that can be homed
        self._unhomed = None  # letters of the axes that are not homed, and the mask that they are of
        self._unhomed_of = -1
        self._groups = []  # of seekers; those of a group home at once
        self._phases = (self._leave_sensor, self._seek_sensor, self._pull_off, self._locate_edge, self._pull_off)
        self._stage = 0

    def handlers(self):
        return {commands.HOME: self._begin_homing}

    def report(self, report):
        machine = self._machine
        if machine.known != self._unhomed_of:
            self._unhomed_of = machine.known
            self._unhomed = self._letters_to_home() or None
        report["unhomed"] = self._unhomed if machine.known or machine.settings.value(table.HOMING) else None

    def _letters_to_home(self):
        """Return the letters of the axes that have a sensor and are not homed."""
        left = self._all & ~self._machine.known
        return "".join([self._axes[axis]["name"].upper() for axis in range(len(self._axes)) if left >> axis & 1])

    def _begin_homing(self, command):
        """Begin HOME: lift the tool first. `value`: mask of axes, 0: all; `power`: runs that measure quality. Returns 0, LATER, or an error."""
        machine = self._machine
        if machine.needs_reset():
            return errors.LOCKED
        if machine.inputs.door_open():
            return errors.DOOR_OPEN
        if machine.motors.detached:
            return errors.NO_MOTORS
        if command.value & ~self._all or command.power and not machine.quality:
            return errors.NO_HOMING
        if machine.state not in ("idle", "alarm") or not self._queue.still():
            return LATER
        if machine.homed:
            machine.known = self._all
        machine.inform(HOMING)
        machine.unlock()
        machine.homed = False
        machine.known &= ~(command.value or self._all)
        machine.begin(command, self._go_on_homing)
        self._queue.lift()
        self._queue.flush()
        self._lifting = True
        if machine.quality:
            machine.quality.begin(command.power)
        return 0

    def _go_on_homing(self, now_ms):
        """Carry HOME on: lift the tool first, then search, and end with success or the number of an error."""
        if self._lifting:
            self._lifting = not self._queue.still()
            if not self._lifting:
                self._begin_search(now_ms)
            return
        result = self._go_on(now_ms)
        if result == 0:
            self._end_run(now_ms)
        elif result != _ON_ITS_WAY:
            self._machine.homing_failed(result)

    def _end_run(self, now_ms):
        """End a run: all axes asked for stand at their origin. Begin the next if quality is measured, else finish HOME."""
        machine = self._machine
        homed = machine.command.value
        if machine.squaring:
            machine.squaring.use_both()
        again = machine.quality and machine.quality.again(self._groups)
        self._queue.set_origin(homed or -1)
        if again:
            self._begin_search(now_ms)
            return
        machine.known |= homed or self._all
        machine.homed = machine.known == self._all
        if not machine.homed:
            machine.require_homing(" ".join(self._letters_to_home()))
        machine.finish(machine.quality and machine.quality.rows())

    def _make_sensors(self, number):
        """Make the Sensors of an axis: one, or one a side if both its motors are squared."""
        names = [self._config["sensors"][self._axes[number]["name"]]]
        squaring = self._machine.squaring
        if squaring and squaring.axis == number:
            names.append(squaring.sensor)
        return [self._make_sensor(name, number) for name in names]

    def _make_sensor(self, name, axis, kind=Sensor):
        """Make the Sensor of an input, whose pin's interrupt keeps the position of the edge."""
        read = self._machine.inputs.read
        return kind(lambda: read(name), self._config["debounce_ms"], self._machine.port.watch_limit(name), self._queue, axis)

    def _begin_search(self, now_ms):
        """Make the seekers of all groups from the settings as they are now, and enter the first phase."""
        squaring = self._machine.squaring
        if squaring:
            self._phases = self._phases[:4] + squaring.make_phases(self)
        names = [axis["name"] for axis in self._axes]
        order = self._config["order"] or [name for name in names if name in self._config["sensors"]]
        mask = self._machine.command.value or self._all
        groups = order.split() if " " in order else [[name] for name in order]
        groups = [[names.index(name) for name in group if mask >> names.index(name) & 1] for group in groups]
        self._groups = [[self._make_seeker(number) for number in group] for group in groups if group]
        self._stage = 0
        self._now_ms = now_ms
        self._enter_phase()

    def _make_seeker(self, number):
        """Make the Seeker of an axis. It searches its travel and twice the longest way off the sensor, or `distance_steps`."""
        axis = self._axes[number]
        name = axis["name"]
        away = -1 if name in self._config["high_end"] else 1
        values = self._machine.settings.homing(number)
        distance = axis["travel_steps"] + 2 * max(axis["travel_steps"] // 10, 5 * values[2])
        distance = self._config["each"].get(name, {}).get("distance_steps", distance)
        return Seeker(number, self._queue.axis(number), self._make_sensors(number), away, values, distance)

    def _go_on(self, now_ms):
        """Sample the sensors and go on with the phase. Returns _ON_ITS_WAY, 0 at the end of the last one, or the alarm that ended it."""
        self._now_ms = now_ms
        group = self._groups[self._stage // len(self._phases)]
        still = self._queue.still()
        ended = pending = False
        for seeker in group:
            position = self._queue.axis(seeker.axis)
            for sensor in seeker.sensors:
                sensor.sample(now_ms, position)
                pending = pending or sensor.pending
            if not seeker.done and self._until is not None and (self._side.active if self._side else seeker.has_reached(self._until)):
                seeker.done = ended = True
        left = [seeker for seeker in group if not seeker.done]
        if ended and not still:
            self._machine.abort()
        if ended and left:
            self._move_seekers(left)  # the others go on
            return _ON_ITS_WAY
        if not ended and left:
            if not still or pending:
                return _ON_ITS_WAY
            for seeker in left:
                if self._until is not None or not seeker.has_reached(False):
                    return self._alarm
        self._stage += 1
        if self._stage == len(self._groups) * len(self._phases):
            return 0
        self._enter_phase()
        return _ON_ITS_WAY

    def _enter_phase(self):
        """Give each seeker of the group its way in the phase, and queue them."""
        group = self._groups[self._stage // len(self._phases)]
        phase = self._stage % len(self._phases)
        if phase == 0:
            for seeker in group:
                for sensor in seeker.sensors:
                    sensor.restart(self._now_ms)
        for seeker in group:
            seeker.done = False
            self._phases[phase](seeker)
        self._move_seekers([seeker for seeker in group if not seeker.done])

    def until(self, active, alarm=errors.ALARM_SENSOR_STUCK, sensor=None):
        """Set the end of the phase: it ends as any sensor, or `sensor`, is `active` (None: only at the way's end, with the sensors free); `alarm` is
        raised if the way ends otherwise."""
        self._until = active
        self._side = sensor
        self._alarm = alarm

    # A phase gives a seeker its longest way, and the event that ends it.

    def _leave_sensor(self, seeker):
        """Phase 1: move away until all sensors are free, at most a tenth of the travel, or 5 pull-offs if that is more."""
        self.until(False)
        limit = max(self._axes[seeker.axis]["travel_steps"] // 10, 5 * seeker.pull_off_steps)
        self.way(seeker, 0 if seeker.has_reached(False) else limit, seeker.seek_steps_s)

    def _seek_sensor(self, seeker):
        """Phase 2: move towards the sensor at the seek speed."""
        self.until(True, errors.ALARM_SENSOR_DEAD)
        self.way(seeker, -seeker.distance, seeker.seek_steps_s)

    def _pull_off(self, seeker):
        """Phases 3 and 6: go to one pull-off from the edge found last, at the seek speed."""
        self.until(None)
        seeker.note(seeker.tripped)
        self.way(seeker, seeker.pull_off_steps - self.steps_from_edge(seeker, seeker.tripped), seeker.seek_steps_s)

    def _locate_edge(self, seeker):
        """Phase 4: move towards the sensor at the locate speed, 3 pull-offs at most."""
        self.until(True, errors.ALARM_SENSOR_DEAD)
        self.way(seeker, -3 * seeker.pull_off_steps, seeker.locate_steps_s)

    def steps_from_edge(self, seeker, number):
        """Return the axis's steps from the edge of its sensor `number`, positive away from the sensor."""
        return (self._queue.axis(seeker.axis) - seeker.edges[number]) * seeker.away

    def way(self, seeker, steps, steps_s):
        """Set the goal of a phase: `steps` from here, positive away from the sensor's end, at `steps_s` steps/s."""
        seeker.goal = self._queue.axis(seeker.axis) + steps * seeker.away
        seeker.steps_s = steps_s

    def _move_seekers(self, seekers):
        """Queue what is left of the seekers' ways, as one line."""
        self._queue.travel([(seeker.axis, seeker.goal - self._queue.axis(seeker.axis), seeker.steps_s) for seeker in seekers])
