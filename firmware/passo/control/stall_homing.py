"""Homing by motors that feel the end of their way: the sensor of an axis is the DIAG pin of its driver (StallGuard). In phases:

    1 back off  away from the end: a rotor that already stands against it tells nothing
    2 seek      to the end, at the one speed that the driver's threshold was found for
    3 pull off  from where it stalled
    4 locate    to the end again, at the same speed. 3 and 4 again, until enough places in a row lie within a full step
    5 pull off  to the origin

Five places are enough, and one more for each that did not agree with those before it. If false stalls come at random, however often, five
agree by chance less than twice in 100 000 homings: the way to a place is 25 full steps, half of which count, and a place is two wide. Alarm 8 is
raised as soon as twenty attempts cannot bring enough. A way's first half pull-off does not count: a rotor that sets out trembles. A place
behind which the axis ran on for more than 1.25 full steps does not agree: two full steps behind its field a rotor slips to another pole.

Axes with switches home as elsewhere. X and Y of CoreXY cannot home by stall: if a motor slips while Y homes, X is wrong and nothing tells.
"""

from micropython import const

from passo import errors
from passo.control import homing
from passo.control.sensor import Sensor

_MOST = const(20)  # times that an end is located
_ENOUGH = const(5)
_LAST = const(4)  # the phase of the last pull-off


class StallSensor(Sensor):
    """A DIAG pin. What it says before the axis is `blind` steps from `start` does not count."""

    start = blind = 0

    def sample(self, now_ms, position):
        if abs(position - self.start) < self.blind:
            self.restart(now_ms, False)
        else:
            Sensor.sample(self, now_ms, position)


class Homing(homing.Homing):
    def __init__(self, board, machine, queue):
        names = [axis["name"] for axis in board["axes"]]
        self._full = {}  # steps of a full step, by the number of an axis whose end is felt
        for motor in board["drives"]["motors"]:
            if motor["stall"]:
                self._full[names.index(motor["axis"])] = motor["microsteps"]
        # Of the axis that homes, for it does so alone: how often its end has been located, how many of the last agree, with what, and
        # how many have to.
        self._located = self._agree = self._edge = self._enough = 0
        homing.Homing.__init__(self, board, machine, queue)

    def _seeker(self, number):
        seeker = homing.Homing._seeker(self, number)
        if number in self._full:
            read = self._machine.inputs.read
            watch = self._machine.port.watch_limit
            sensor = self._config["sensors"][self._axes[number]["name"]]
            seeker.sensors = [StallSensor(lambda: read(sensor), self._config["debounce_ms"], watch(sensor), self._queue, number)]
        return seeker

    def _go_on(self, now_ms):
        if self._located + self._enough - self._agree > _MOST:
            return errors.ALARM_SENSOR_STUCK
        return homing.Homing._go_on(self, now_ms)

    def _blind(self, seeker, steps):
        """`steps` of the way that begins do not count."""
        for sensor in seeker.sensors:
            sensor.start = self._queue.axis(seeker.axis)
            sensor.blind = steps
            sensor.restart(self._now_ms, False)

    def _leave(self, seeker):
        if seeker.axis not in self._full:
            homing.Homing._leave(self, seeker)
            return
        self._located = self._agree = 0
        self._enough = _ENOUGH
        self.end_of_way()
        self._back(seeker, seeker.pull_off_steps)

    def _back(self, seeker, steps):
        """Away from the end, whatever the driver says meanwhile."""
        self.way(seeker, steps, seeker.seek_steps_s)
        self._blind(seeker, abs(steps) + 1)

    def _seek(self, seeker):
        homing.Homing._seek(self, seeker)
        if seeker.axis in self._full:
            self._blind(seeker, seeker.pull_off_steps // 2)

    def _pull_off(self, seeker):
        homing.Homing._pull_off(self, seeker)
        if seeker.axis not in self._full:
            return
        edge = seeker.edges[seeker.tripped]
        full = self._full[seeker.axis]
        beyond = -self.gone(seeker, seeker.tripped)
        slipped = 4 * beyond > 5 * full
        if not self._agree:
            self._edge = edge
        if slipped or abs(edge - self._edge) > full:
            self._enough += 1
            self._edge = edge
            self._agree = 0
        if not slipped:
            self._agree += 1
        if self._stage % len(self._phases) == _LAST and self._agree < self._enough:
            self._stage -= 2
        self._back(seeker, seeker.pull_off_steps + beyond)

    def _locate(self, seeker):
        if seeker.axis not in self._full:
            homing.Homing._locate(self, seeker)
            return
        self._located += 1
        self._seek(seeker)
