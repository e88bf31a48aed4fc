"""The speed that the programme sets for the spindle, whether it is reached, and the wait of cuts for it: the base of its gauges."""

from micropython import const

from passo import errors
from passo.config import setting_numbers as table
from passo.control.feature import Feature
from passo.records import COUNT_MASK

PERIOD_MS = const(100)  # between two looks at the speed it has
_SLOW = const(3)  # this number in a row below half of S are no accident


class SpindleSpeed(Feature):
    def __init__(self, board, machine, queue, config):
        """`config`: a section of the board file with at_speed_percent and spin_up_ms."""
        Feature.__init__(self, board, machine, queue)
        self._percent = config["at_speed_percent"]
        self._spin_up_ms = config["spin_up_ms"]
        self._since_ms = 0  # since when it is wanted
        self._reached = False
        self._slow = 0
        self.at_speed = True  # or nobody asks for one; measured
        machine.gauge = self
        errors.ALARMS[errors.ALARM_SPINDLE_SPEED] = errors.AT_STAND | errors.OUTPUTS_OFF
        self._rpm_of = None  # the rpm and override from which `_rpm` was computed
        self._rpm = 0

    def target_rpm(self):
        """Return S with its override, within $31 and $30, in thousandths of rpm. Computed anew only when it changes: that
        allocates."""
        machine = self._machine
        settings = machine.settings
        of = machine.power, machine.overrides[2], settings.version
        if of != self._rpm_of:
            self._rpm_of = of
            most = settings.value(table.MAX_RPM)  # in thousandths, as the others
            rpm = min(of[0] * most * of[1] // 100_000_000, most)
            self._rpm = max(rpm, settings.value(table.MIN_RPM)) if rpm else 0
        return self._rpm

    def expect(self, turns):
        """Expect a spindle that `turns` or stands: one that turns is not at speed until that is measured."""
        self.at_speed = not turns

    def begin(self, now_ms):
        """Begin to wait for another speed, for spin_up_ms at most."""
        self._since_ms = now_ms
        self._reached = False
        self._slow = 0

    def falls_behind(self, speed, wanted):
        """Judge a measured speed, in the unit of `wanted` > 0. Returns True if, once reached, it was below half of it three times."""
        if abs(speed - wanted) * 100 <= wanted * self._percent:
            self._reached = True
            self._slow = 0
            self.at_speed = True
        elif self._reached and 2 * speed < wanted:
            self._slow += 1
        return self._slow >= _SLOW

    def late(self, now_ms):
        """Return True if the speed has not been reached within spin_up_ms."""
        return not self._reached and (now_ms - self._since_ms) & COUNT_MASK > self._spin_up_ms

    def ready(self):
        """Return whether motion may set out: not with a spindle that is not at speed. Motion under way goes on."""
        return self.at_speed or not self._queue.silent() or not self._queue.lit()
