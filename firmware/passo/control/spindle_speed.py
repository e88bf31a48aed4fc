"""What speed the programme asks of the spindle, and that cuts wait for it: for what knows the speed that it has."""

from micropython import const

from passo.config import setting_numbers as table

PERIOD_MS = const(100)  # between two looks at the speed it has
SLOW = const(3)  # of these below half of what is asked are no accident


class AskedSpeed:
    def __init__(self, machine, queue):
        self._machine = machine
        self._queue = queue
        machine.waits_for_speed = True
        self._of = None  # what `_rpm` was computed of
        self._rpm = 0

    def rpm(self):
        """S with its override, within $31 and $30: thousandths of a turn a minute. Computed anew only when it changes: that
        allocates."""
        machine = self._machine
        percent = machine.overrides[2]
        of = self._of
        if of is None or of != (machine.power, percent, machine.settings.version):
            settings = machine.settings
            self._of = machine.power, percent, settings.version
            most = settings.value(table.MAX_RPM)  # in thousandths, as the others
            rpm = min(machine.power * most * percent // 100_000_000, most)
            if rpm:
                rpm = max(rpm, settings.value(table.MIN_RPM))
            self._rpm = rpm
        return self._rpm

    def ready(self):
        """Nothing sets out with a spindle that is not at speed. What moves already goes on."""
        return self._machine.at_speed or not self._queue.silent() or not self._queue.lit()
