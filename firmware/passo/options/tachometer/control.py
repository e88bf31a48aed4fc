"""The spindle's speed by its pulses: no cut begins before it is reached, and a spindle that falls behind is an alarm.

    "tachometer": {"input": "turns", "pulses": 1}

While the tool is on, the speed measured has to come within at_speed_percent of the one asked for, in spin_up_ms, and then must not
fall below half of it: else alarm 244, which brings the axes to a stand, the position kept, and switches the tool off. Asked is
S if `spindle.pwm` sets the speed; a spindle on a relay turns at $30. A lost wire is a spindle at 0: noticed after four turns and
half a second. Override and S may change while it turns; from then on spin_up_ms count anew.
"""

from micropython import const

from passo import errors
from passo.commands import SPINDLE_OFF
from passo.config import setting_numbers as table
from passo.control.spindle_speed import PERIOD_MS, SpindleSpeed
from passo.records import COUNT_MASK

_QUIET_TURNS = const(4)  # without a pulse for this many turns at the speed asked for it stands


class Tachometer(SpindleSpeed):
    def __init__(self, board, machine, queue):
        config = board["tachometer"]
        SpindleSpeed.__init__(self, board, machine, queue, config)
        self._per_turn = config["pulses"]
        self._pulses = machine.port.make("tachometer", config["input"])
        self._by_s = board["spindle"]["pwm"]
        self.rpm = 0  # as measured
        self._wanted = 0  # thousandths of a turn a minute
        self._looked_ms = machine.port.machine_ms()
        self._came_ms = self._looked_ms  # when the last look found a pulse
        self._count = self._pulses.count_pulses()
        self._us = self._pulses.us

    def report(self, report):
        report["rpm"] = self.rpm

    def look(self, now_ms):
        """Measure the speed each PERIOD_MS; raise alarm 244 if it is late or falls behind."""
        machine = self._machine
        if machine.spindle == SPINDLE_OFF or machine.alarm or not self._queue.lit():
            wanted = 0
        else:
            wanted = self.target_rpm() if self._by_s else machine.settings.value(table.MAX_RPM)
            if not wanted:
                self.at_speed = True
        if wanted != self._wanted:
            self._wanted = wanted
            self.begin(now_ms)
        if (now_ms - self._looked_ms) & COUNT_MASK < PERIOD_MS:
            return
        self._looked_ms = now_ms
        self._measure_rpm(now_ms)
        if wanted and (self.falls_behind(1000 * self.rpm, wanted) or self.late(now_ms)):
            machine.raise_alarm(errors.ALARM_SPINDLE_SPEED, "spindle at %d rpm" % self.rpm)

    def _measure_rpm(self, now_ms):
        """Compute the speed from the pulses since the last look; 0 after _QUIET_TURNS without one."""
        count = self._pulses.count_pulses()
        came = (count - self._count) & COUNT_MASK
        if came:
            us = self._pulses.us
            passed_us = (us - self._us) & COUNT_MASK
            if (now_ms - self._came_ms) & COUNT_MASK < 100_000 and passed_us:
                self.rpm = came * 60_000 // self._per_turn * 1000 // passed_us
            self._count = count
            self._us = us
            self._came_ms = now_ms
        elif (now_ms - self._came_ms) & COUNT_MASK > 2 * PERIOD_MS + _QUIET_TURNS * 60_000_000 // max(self._wanted, 60_000):
            self.rpm = 0
