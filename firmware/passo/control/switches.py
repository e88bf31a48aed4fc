"""The switches that act by themselves, beside homing's work: hard limits, safety door, buttons.

A limit whose pin has an interrupt stops the player there; the look once a cycle finds the reason, and when the player may run again.
"""

from passo import commands, errors
from passo.config import setting_numbers as table
from passo.config.board_error import inputs_of
from passo.control.feature import Feature
from passo.control.sensor import Sensor

_LIMIT_FILTER_US = 50  # if the board file gives none


class Switches(Feature):
    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        self._settings = settings = machine.settings
        self._inputs = inputs = machine.inputs
        self._levels = inputs.levels
        self._sensors = []
        self._settings_of = settings.version  # that the sensors are of
        names = [item["name"] for item in board["inputs"]]
        self._limits = [(name, self._make_sensor(name)) for _, name in inputs.limits if name in inputs.names]
        self._buttons = [(name, kind, self._make_sensor(name)) for name, _, kind, _ in inputs_of(board) if kind and name in names]
        self._watches = self._limit_watches(board, machine.port)
        self._turned = -1  # 1: the settings turn limits round; 0: they do not; −1: not yet known
        self._armed = None  # True, False: the interrupts of limits are; None: some may be other
        self._apply_invert()
        self._seen = -1  # the inputs' levels at the last cycle
        self._calm = False  # they are as the sensors have them: until one changes there is nothing to do

    def _limit_watches(self, board, port):
        """Return [(watch of the pin's interrupt, sensor, the board file's active level)] of the limits."""
        watches = []
        items = {item["name"]: item for item in board["inputs"]}
        for name, sensor in self._limits:
            watch = port.watch_limit(name, items[name]["filter_us"] or _LIMIT_FILTER_US)
            if watch is not None:
                watches.append((watch, sensor, items[name]["active"]))
        return watches

    def _apply_invert(self):
        """Apply $21 and $5 to the limits: whether they are watched, and the level at which they are active."""
        self._hard = bool(self._settings.value(table.HARD_LIMITS))
        turned = 1 if self._settings.mask_change(table.LIMIT_INVERT) else 0
        if turned != self._turned:
            self._turned = turned
            for watch, _, level in self._watches:
                watch.turn(level ^ turned)

    def _arm_limits(self, armed):
        """Let the interrupts of limits stop the player, or not. A limit that is active already does not."""
        self._armed = armed
        for watch, sensor, _ in self._watches:
            watch.arm(armed and not sensor.active)

    def _make_sensor(self, name):
        """Make a Sensor of an input, debounced by $26."""
        read = self._inputs.read
        sensor = Sensor(lambda: read(name), self._settings.value(table.HOMING_DEBOUNCE))
        self._sensors.append(sensor)
        return sensor

    def look(self, now_ms):
        """Sample the sensors if an input or a setting has changed, and arm the limits' interrupts."""
        seen = self._levels()
        if seen != self._seen or not self._calm or self._settings_of != self._settings.version:
            self._seen = seen
            self._sample_all(now_ms)
        if self._watches:
            machine = self._machine
            command = machine.command
            armed = self._hard and machine.alarm in errors.WATCHED and (command is None or command.kind != commands.HOME)
            if armed != self._armed:
                self._arm_limits(armed)

    def _sample_all(self, now_ms):
        """Sample buttons, and limits if watched; carry out the command of a button pressed."""
        machine = self._machine
        for sensor in self._sensors:
            if not sensor.pending:
                sensor.last_ms = now_ms  # a change lasts from here on: a spike that is met by luck has not lasted a cycle
        if self._settings_of != self._settings.version:
            self._settings_of = self._settings.version
            for sensor in self._sensors:
                sensor.debounce_ms = self._settings.value(table.HOMING_DEBOUNCE)
            for _, sensor in self._limits:
                sensor.restart(now_ms)  # one that was hit before it was watched is no news
            self._apply_invert()
        for _, kind, sensor in self._buttons:
            before = sensor.active
            sensor.sample(now_ms, 0)
            if sensor.active and not before:
                machine.carry_out(kind)
        if self._hard:
            self._poll_limits(now_ms)
        self._calm = not any([sensor.pending for sensor in self._sensors])
        self._armed = None

    def _poll_limits(self, now_ms):
        """Raise ALARM_HARD_LIMIT if a limit has become active, except while homing."""
        machine = self._machine
        command = machine.command
        watching = machine.alarm in errors.WATCHED and (command is None or command.kind != commands.HOME)
        hit = None
        for name, sensor in self._limits:
            before = sensor.active
            sensor.sample(now_ms, 0)
            if watching and sensor.active and not before and hit is None:
                hit = name
        if hit is not None:
            machine.raise_alarm(errors.ALARM_HARD_LIMIT, hit)
