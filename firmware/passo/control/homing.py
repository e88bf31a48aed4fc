"""Homing on optical barriers, axis by axis, in five phases:

    1 leave     if the head stands on the sensor, move away until it is free
    2 seek      quickly towards the sensor, until it trips
    3 pull off  away from the place where it tripped
    4 locate    slowly towards it: this edge counts
    5 pull off  to the origin, a fixed distance from that edge

Each phase has a travel limit; reaching it is an alarm. The edge is where the sensor first moved, not where its
debouncing ended, so a bouncing sensor gives the same origin every time.
"""

from passo.control.sensor import Sensor
from passo.protocols import errors

RUNNING = -1


class Homing:
    def __init__(self, config, axes, mover, read):
        """`config`: the board file's homing; `axes`: its axes; `mover`: travel(axis, steps, steps_s), arrest(),
        still() and place(axis); `read(name)`: an input's active state."""
        self._config = config
        self._mover = mover
        self._order = []
        for number in range(len(axes)):
            name = axes[number]["name"]
            if name in config["sensors"]:
                sensor = config["sensors"][name]
                self._order.append((number, axes[number]["travel_steps"], self._sensor(sensor, read)))
        self._phases = (self._leave, self._seek, self._pull_off, self._locate, self._pull_off)
        self._stage = 0

    def _sensor(self, name, read):
        return Sensor(lambda: read(name), self._config["debounce_ms"])

    def start(self, now_ms):
        self._stage = 0
        self._now_ms = now_ms
        self._enter()

    def poll(self, now_ms):
        """RUNNING, 0 when every axis stands at its origin, or the number of the alarm that ended it."""
        self._now_ms = now_ms
        axis, _, sensor = self._order[self._stage // len(self._phases)]
        sensor.sample(now_ms, self._mover.place(axis))
        still = self._mover.still()
        if self._until is not None and sensor.active == self._until:
            if not still:
                self._mover.arrest()
        elif not still or sensor.pending:
            return RUNNING
        elif self._until is not None or sensor.active:
            return self._alarm
        self._stage += 1
        if self._stage == len(self._order) * len(self._phases):
            return 0
        self._enter()
        return RUNNING

    def _enter(self):
        axis, travel, sensor = self._order[self._stage // len(self._phases)]
        phase = self._stage % len(self._phases)
        if phase == 0:
            sensor.restart(self._now_ms)
        self._phases[phase](axis, travel, sensor)

    # A phase sets out on its longest way and says what ends it: `_until` is the sensor's state that does (None: only
    # the way's end, with the sensor free), `_alarm` what it means if the way ends otherwise.

    def _leave(self, axis, travel, sensor):
        self._until = False
        self._alarm = errors.ALARM_SENSOR_STUCK
        self._mover.travel(axis, self._leave_limit(travel) if sensor.active else 0, self._config["seek_steps_s"])

    def _seek(self, axis, travel, sensor):
        self._until = True
        self._alarm = errors.ALARM_SENSOR_DEAD
        self._mover.travel(axis, -(travel + 2 * self._leave_limit(travel)), self._config["seek_steps_s"])

    def _pull_off(self, axis, travel, sensor):
        self._until = None
        self._alarm = errors.ALARM_SENSOR_STUCK
        origin = sensor.edge + self._config["pull_off_steps"]
        self._mover.travel(axis, origin - self._mover.place(axis), self._config["seek_steps_s"])

    def _locate(self, axis, travel, sensor):
        self._until = True
        self._alarm = errors.ALARM_SENSOR_DEAD
        self._mover.travel(axis, -3 * self._config["pull_off_steps"], self._config["locate_steps_s"])

    def _leave_limit(self, travel):
        return max(travel // 10, 5 * self._config["pull_off_steps"])
