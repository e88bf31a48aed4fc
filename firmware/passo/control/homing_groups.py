"""Homing of axes at once, with values of their own, of gantries, on edges caught in interrupts: what homing.py does for axis after
axis, for groups of them. A board loads it if its `homing` has a blank in `order`, or `each` or `latch`, or its gantry a
`sensor`. The phases of a group:

    1 leave     if the head stands on a sensor, move away until all are free
    2 seek      quickly towards the sensors; each axis goes on until its own trips
    3 pull off  away from where it tripped
    4 locate    slowly towards it: this edge counts
    5 square    of a gantry: the other side alone, until its own sensor trips; see squaring.py
    6 pull off  to the origin, a fixed distance from that edge
"""

from passo import errors
from passo.control.homing import ON_ITS_WAY, Homing
from passo.control.sensor import Sensor


class LatchedSensor(Sensor):
    """A sensor whose edge is caught in its interrupt."""

    def __init__(self, read, debounce_ms, latch, axis):
        self._latch = latch
        self._axis = axis
        Sensor.__init__(self, read, debounce_ms)

    def restart(self, now_ms):
        Sensor.restart(self, now_ms)
        self._latch.arm()

    def sample(self, now_ms, place):
        latch = self._latch
        if latch.caught and not self.active and not self.pending:  # it may be over by now
            self.pending = True
            self.edge = latch.place[self._axis]
            self._against_ms = self._calm_ms = 0
        pending, active = self.pending, self.active
        Sensor.sample(self, now_ms, place)
        if pending and not self.pending and not self.active or active and not self.active:
            latch.arm()  # it was noise, or the sensor is free again


class Seeker:
    """An axis on its way to its sensor; a gantry has two sensors, one at each side."""

    def __init__(self, axis, place, sensors, away, values, distance):
        self.axis = axis
        self.start = place
        self.sensors = sensors
        self.away = away  # the sign of steps away from the sensors' end
        self.seek_steps_s, self.locate_steps_s, self.pull_off_steps = values
        self.distance = distance  # the longest search
        self.ends = [self.pull_off_steps] * len(sensors)  # how far from the edge of each it ends
        self.tripped = 0  # the number of the sensor that did so last
        self.edges = [place] * len(sensors)  # where each did so: kept, for a sensor that is left shows another edge
        self.goal = 0  # where the way of this phase ends
        self.steps_s = 1
        self.done = False

    def keep(self, number):
        self.edges[number] = self.sensors[number].edge

    def met(self, active):
        """True if all sensors are free, or one is active."""
        for number in range(len(self.sensors)):
            if self.sensors[number].active:
                if active:
                    self.tripped = number
                return active
        return not active


class GroupHoming(Homing):
    def __init__(self, board, machine, queue):
        Homing.__init__(self, board, machine, queue)
        self._latches = getattr(machine.port, "latches", {})
        self._groups = []
        self._squaring = self._quality = None
        gantry = board["gantry"]
        if gantry and gantry["sensor"]:
            from passo.control.squaring import Squaring

            self._squaring = Squaring(board, queue, self)
            self._phases = self._phases[:4] + self._squaring.phases()
        if board["homing"]["latch"]:
            from passo.control.quality import Quality

            self._quality = Quality()
            self._judges = True

    def clear(self):
        if self._squaring:
            self._squaring.both()

    def _home(self, command):
        result = Homing._home(self, command)
        if not result and self._quality is not None:
            self._quality.begin(command.power)
        return result

    def _end(self, now_ms, told=None):
        self.clear()
        if self._quality is None:
            Homing._end(self, now_ms)
        elif self._quality.again(self._groups):
            self._queue.set_origin(self._machine.command.value or -1)
            self._begin(now_ms)
        else:
            Homing._end(self, now_ms, self._quality.found())

    def _groups_asked(self):
        """[[number of an axis, …], …]: those of a list home at once."""
        wanted = self._axis_order()
        names = [axis["name"] for axis in self._axes]
        order = self._config["order"]
        if " " not in order:
            return [[number] for number in wanted]
        groups = [[names.index(name) for name in group if names.index(name) in wanted] for group in order.split()]
        return [group for group in groups if group]

    def _sensor_of(self, name, axis):
        read = self._machine.inputs.read
        latch = self._latches.get(name)
        if latch is None:
            return Sensor(lambda: read(name), self._config["debounce_ms"])
        return LatchedSensor(lambda: read(name), self._config["debounce_ms"], latch, axis)

    def _begin(self, now_ms):
        """Begin, with the settings as they are now."""
        self._groups = [[self._seeker(number) for number in group] for group in self._groups_asked()]
        self._stage = 0
        self._now_ms = now_ms
        self._enter()

    def _seeker(self, number):
        axis = self._axes[number]
        name = axis["name"]
        names = [self._config["sensors"][name]]
        if self._squaring and self._squaring.axis == number:
            names.append(self._squaring.sensor)
        away = -1 if name in self._config["high_end"] else 1
        values = self._machine.settings.homing(number)
        distance = axis["travel_steps"] + 2 * max(axis["travel_steps"] // 10, 5 * values[2])
        distance = self._config["each"].get(name, {}).get("distance_steps", distance)
        return Seeker(number, self._queue.axis(number), [self._sensor_of(sensor, number) for sensor in names], away, values, distance)

    def _go_on(self, now_ms):
        """ON_ITS_WAY, 0 when every axis stands at its origin, or the number of the alarm that ended it."""
        self._now_ms = now_ms
        group = self._groups[self._stage // len(self._phases)]
        still = self._queue.still()
        ended = pending = False
        for seeker in group:
            place = self._queue.axis(seeker.axis)
            for sensor in seeker.sensors:
                sensor.sample(now_ms, place)
                pending = pending or sensor.pending
            if not seeker.done and self._until is not None and self._met(seeker, self._until):
                seeker.done = ended = True
        left = [seeker for seeker in group if not seeker.done]
        if ended and not still:
            self._machine.abort()
        if ended and left:
            self._go(left)  # the others go on
            return ON_ITS_WAY
        if not ended and left:
            if not still or pending:
                return ON_ITS_WAY
            for seeker in left:
                if self._until is not None or not seeker.met(False):
                    return self._alarm
        self._stage += 1
        if self._stage == len(self._groups) * len(self._phases):
            return 0
        self._enter()
        return ON_ITS_WAY

    def _met(self, seeker, active):
        return self._side.active if self._side else seeker.met(active)

    def _enter(self):
        group = self._groups[self._stage // len(self._phases)]
        phase = self._stage % len(self._phases)
        if phase == 0:
            for seeker in group:
                for sensor in seeker.sensors:
                    sensor.restart(self._now_ms)
        self._side = None
        for seeker in group:
            seeker.done = False
            self._phases[phase](seeker)
        self._go([seeker for seeker in group if not seeker.done])

    # A phase says of a seeker which way it is to go at most, and what ends it: `_until` is the state of a sensor that does
    # (None: only the way's end, with the sensors free), `_side` the sensor meant if it is not any of them, `_alarm` what it
    # means if the way ends otherwise.

    def _leave(self, seeker):
        self._until = False
        self._alarm = errors.ALARM_SENSOR_STUCK
        limit = max(self._axes[seeker.axis]["travel_steps"] // 10, 5 * seeker.pull_off_steps)
        self.way(seeker, 0 if seeker.met(False) else limit, seeker.seek_steps_s)

    def _seek(self, seeker):
        self._until = True
        self._alarm = errors.ALARM_SENSOR_DEAD
        self.way(seeker, -seeker.distance, seeker.seek_steps_s)

    def _pull_off(self, seeker):
        self.end_of_way()
        seeker.keep(seeker.tripped)
        self.way(seeker, seeker.pull_off_steps - self.gone(seeker, seeker.tripped), seeker.seek_steps_s)

    def _locate(self, seeker):
        self._until = True
        self._alarm = errors.ALARM_SENSOR_DEAD
        self.way(seeker, -3 * seeker.pull_off_steps, seeker.locate_steps_s)

    def gone(self, seeker, number):
        """Steps from the edge of one of its sensors, away from it."""
        return (self._queue.axis(seeker.axis) - seeker.edges[number]) * seeker.away

    def end_of_way(self):
        self._until = None
        self._alarm = errors.ALARM_SENSOR_STUCK

    def until(self, sensor, alarm):
        """The phase ends as `sensor` trips, else in `alarm`."""
        self._until = True
        self._side = sensor
        self._alarm = alarm

    def way(self, seeker, steps, steps_s):
        """`steps` away from the sensor's end."""
        seeker.goal = self._queue.axis(seeker.axis) + steps * seeker.away
        seeker.steps_s = steps_s

    def _go(self, seekers):
        """Set out on what is left of their ways."""
        self._queue.travel([(seeker.axis, seeker.goal - self._queue.axis(seeker.axis), seeker.steps_s) for seeker in seekers])
