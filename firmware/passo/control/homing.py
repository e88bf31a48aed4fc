"""Homing on switches or optical barriers, axis by axis, in five phases; homing_groups.py has what only few boards ask for:

    1 leave     if the head stands on the sensor, move away until it is free
    2 seek      quickly towards the sensor, until it trips
    3 pull off  away from the place where it tripped
    4 locate    slowly towards it: this edge counts
    5 pull off  to the origin, a fixed distance from that edge

Each phase has a travel limit; reaching it is an alarm. The edge is where the sensor first moved, not where its
debouncing ended, so a bouncing sensor gives the same origin every time.
"""

from micropython import const

from passo import commands, errors
from passo.control.sensor import Sensor
from passo.errors import LATER

ON_ITS_WAY = const(-1)


class Homing:
    _judges = False  # it can tell how well it repeats

    def __init__(self, board, machine, queue):
        self._config = board["homing"]
        self._axes = board["axes"]
        self._machine = machine
        self._queue = queue
        self._lifting = False  # homing waits for the tool
        self._known = 0  # mask of the axes whose place is known
        self._all = 0  # of those that can be homed
        for number in range(len(self._axes)):
            if self._axes[number]["name"] in self._config["sensors"]:
                self._all |= 1 << number
        self._order = []
        self._phases = (self._leave, self._seek, self._pull_off, self._locate, self._pull_off)
        self._stage = 0

    def handlers(self):
        return {commands.HOME: self._home}

    def release(self):
        self._known = 0

    def _home(self, command):
        machine = self._machine
        if machine.alarm in errors.NEED_RESET:
            return errors.LOCKED
        if machine.inputs.door_open():
            return errors.DOOR_OPEN
        if machine.detached:
            return errors.NO_MOTORS
        if command.value & ~self._all or command.power and not self._judges:
            return errors.NO_HOMING
        if machine.state not in ("idle", "alarm") or not self._queue.still():
            return LATER
        if machine.homed:
            self._known = self._all
        machine.homing()
        machine.unlock()
        machine.homed = False
        machine.command = command
        self._queue.lift()
        self._queue.flush()
        self._lifting = True
        return 0

    def poll_command(self, now_ms):
        machine = self._machine
        if machine.command.kind != commands.HOME:
            return
        if self._lifting:
            self._lifting = not self._queue.still()
            if not self._lifting:
                self._begin(now_ms)
            return
        result = self._go_on(now_ms)
        if result == 0:
            self._end(now_ms)
        elif result != ON_ITS_WAY:
            machine.homing_failed(result)

    def _end(self, now_ms, told=None):
        """Every axis asked for stands at its origin. `told`: what the answer says beside that."""
        machine = self._machine
        homed = machine.command.value
        self._queue.set_origin(homed or -1)
        self._known |= homed or self._all
        machine.homed = self._known == self._all
        machine.finish(told)

    def _axis_order(self):
        """Numbers of the axes to be homed."""
        names = [axis["name"] for axis in self._axes]
        order = self._config["order"].replace(" ", "") or [name for name in names if name in self._config["sensors"]]
        mask = self._machine.command.value or self._all
        return [names.index(name) for name in order if mask >> names.index(name) & 1]

    def _sensor(self, name):
        read = self._machine.inputs.read
        return Sensor(lambda: read(name), self._config["debounce_ms"])

    def _begin(self, now_ms):
        """Begin, with the settings as they are now."""
        self._order = []  # (axis, its travel in steps, its sensor)
        for number in self._axis_order():
            axis = self._axes[number]
            sensor = self._sensor(self._config["sensors"][axis["name"]])
            self._order.append((number, axis["travel_steps"], sensor))
        self._stage = 0
        self._now_ms = now_ms
        self._enter()

    def _go_on(self, now_ms):
        """ON_ITS_WAY, 0 when every axis stands at its origin, or the number of the alarm that ended it."""
        self._now_ms = now_ms
        axis, _, sensor = self._order[self._stage // len(self._phases)]
        sensor.sample(now_ms, self._queue.axis(axis))
        still = self._queue.still()
        if self._until is not None and sensor.active == self._until:
            if not still:
                self._machine.abort()
        elif not still or sensor.pending:
            return ON_ITS_WAY
        elif self._until is not None or sensor.active:
            return self._alarm
        self._stage += 1
        if self._stage == len(self._order) * len(self._phases):
            return 0
        self._enter()
        return ON_ITS_WAY

    def _enter(self):
        axis, travel, sensor = self._order[self._stage // len(self._phases)]
        phase = self._stage % len(self._phases)
        if phase == 0:
            sensor.restart(self._now_ms)
        self._away = -1 if self._axes[axis]["name"] in self._config["high_end"] else 1
        self._seek_steps_s, self._locate_steps_s, self._pull_off_steps = self._machine.settings.homing(axis)
        self._phases[phase](axis, travel, sensor)

    # A phase sets out on its longest way and says what ends it: `_until` is the sensor's state that does (None: only
    # the way's end, with the sensor free), `_alarm` what it means if the way ends otherwise.

    def _leave(self, axis, travel, sensor):
        self._until = False
        self._alarm = errors.ALARM_SENSOR_STUCK
        self._go(axis, self._leave_limit(travel) if sensor.active else 0, self._seek_steps_s)

    def _seek(self, axis, travel, sensor):
        self._until = True
        self._alarm = errors.ALARM_SENSOR_DEAD
        self._go(axis, -(travel + 2 * self._leave_limit(travel)), self._seek_steps_s)

    def _pull_off(self, axis, travel, sensor):
        self._until = None
        self._alarm = errors.ALARM_SENSOR_STUCK
        gone = (self._queue.axis(axis) - sensor.edge) * self._away
        self._go(axis, self._pull_off_steps - gone, self._seek_steps_s)

    def _locate(self, axis, travel, sensor):
        self._until = True
        self._alarm = errors.ALARM_SENSOR_DEAD
        self._go(axis, -3 * self._pull_off_steps, self._locate_steps_s)

    def _leave_limit(self, travel):
        return max(travel // 10, 5 * self._pull_off_steps)

    def _go(self, axis, steps, steps_s):
        """Set out on `steps` away from the sensor's end."""
        self._queue.travel([(axis, steps * self._away, steps_s)])
