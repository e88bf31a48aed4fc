"""The switches beside homing's work: limits, probe, safety door and buttons, by the names of the board file's inputs.

    limit_x …  or whatever homing.sensors names for the axis     probe     door     hold  resume  reset
"""

from passo import commands, errors
from passo.control import settings as table
from passo.control.sensor import Sensor

_BUTTONS = ("reset", "hold", "resume")


class Inputs:
    def __init__(self, board, settings, machine, port):
        self._settings = settings
        self._machine = machine
        self._input = port.input
        self.levels = getattr(port, "levels", None)  # of all inputs at once
        self._sensors = []
        self._settings_of = settings.version  # that the sensors are of
        names = [item["name"] for item in board["inputs"]]
        self.has_probe = "probe" in names
        self._has_door = "door" in names
        homing = board["homing"]
        found = []
        for axis in board["axes"]:
            name = homing["sensors"].get(axis["name"]) if homing else None
            name = name or "limit_" + axis["name"]
            if name in names:
                found.append((axis["name"].upper(), name))
        self._limit_names = [name for _, name in found]
        self.limits = [(letter, name, self._sensor(name)) for letter, name in found]
        self._buttons = [(name, self._sensor(name)) for name in _BUTTONS if name in names]
        self._door = self._sensor("door") if self._has_door else None
        self._watched = self._to_watch()
        self._seen = -1  # their states at the last turn, a bit each
        self._calm = False  # they are as the sensors have them: until one changes there is nothing to do
        self._polled_ms = 0
        self.hit = ""  # the limit that raised the last alarm

    def _sensor(self, name):
        sensor = Sensor(lambda: self.read(name), self._settings.value(table.HOMING_DEBOUNCE))
        self._sensors.append(sensor)
        return sensor

    def _to_watch(self):
        """Names of the inputs that a turn has to look at."""
        names = [name for name, _ in self._buttons]
        if self._has_door:
            names.append("door")
        if self._settings.value(table.HARD_LIMITS):
            names += self._limit_names
        return names

    def read(self, name):
        """True while the input is active; the settings can turn limits and probe round."""
        active = self._input(name)
        if name == "probe":
            return active != bool(self._settings.turned(table.PROBE_INVERT))
        if name in self._limit_names:
            return active != bool(self._settings.turned(table.LIMIT_INVERT))
        return active

    def limits_hit(self):
        """True where hard limits are watched and one is active."""
        return bool(self._settings.value(table.HARD_LIMITS)) and any([self.read(name) for name in self._limit_names])

    def touched(self):
        return self.has_probe and self.read("probe")

    def door_open(self):
        return self._has_door and self.read("door")

    def poll(self, now_ms):
        seen = self.levels() if self.levels else self._look()
        if seen != self._seen or not self._calm or self._settings_of != self._settings.version:
            self._seen = seen
            self._sample(now_ms)
        self._polled_ms = now_ms

    def _look(self):
        seen = 0
        for name in self._watched:
            seen = seen << 1 | (1 if self._input(name) else 0)
        return seen

    def _sample(self, now_ms):
        machine = self._machine
        if self._calm:
            for sensor in self._sensors:
                sensor.pass_by(self._polled_ms)
        if self._settings_of != self._settings.version:
            self._settings_of = self._settings.version
            self._watched = self._to_watch()
            for sensor in self._sensors:
                sensor.debounce_ms = self._settings.value(table.HOMING_DEBOUNCE)
            for _, _, sensor in self.limits:
                sensor.restart(now_ms)  # one that was hit before it was watched is no news
        if self._door is not None:
            before = self._door.active
            self._door.sample(now_ms, 0)
            if self._door.active and not before:
                machine.pauses.open_door()
        for name, sensor in self._buttons:
            before = sensor.active
            sensor.sample(now_ms, 0)
            if sensor.active and not before:
                machine.press(name)
        self._poll_limits(now_ms)
        self._calm = not any([sensor.pending for sensor in self._sensors])

    def _poll_limits(self, now_ms):
        if not self._settings.value(table.HARD_LIMITS):
            return
        machine = self._machine
        watching = not machine.alarm and not machine.busy_with(commands.HOME)
        hit = None
        for letter, name, sensor in self.limits:
            before = sensor.active
            sensor.sample(now_ms, 0)
            if watching and sensor.active and not before and hit is None:
                hit = name
                self.hit = letter
        if hit is not None:
            machine.fail(errors.ALARM_HARD_LIMIT, hit)
