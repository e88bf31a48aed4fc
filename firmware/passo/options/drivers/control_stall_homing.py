"""Homing by motors that feel the end of their way: the sensor of an axis is the DIAG pin of its driver (StallGuard). In phases:

    1 back off  away from the end: a rotor that already stands against it tells nothing
    2 seek      to the end, at the one speed that the driver's threshold was found for
    3 pull off  from where it stalled
    4 locate    to the end again, at the same speed. 3 and 4 again, until enough places in a row lie within a full step and an eighth
    5 pull off  to the origin

Five places are enough, and one more for each that did not agree with those before it. If false stalls come at random, however often, five
agree by chance less than four times in 100 000 homings: the way to a place is 25 full steps, half of which count, and a place is 2¼ wide. Alarm 8 is
raised as soon as twenty attempts cannot bring enough. A way's first half pull-off does not count: a rotor that sets out trembles.

Drivers measure once a full step, so a motor may be almost two of them behind its field when its driver tells, and at two its rotor slips to
another pole. So the pin's interrupt stops the axis, and a place behind which it ran on for more than an eighth of a full step does not
agree. As a slip behind the last place would be seen by nobody, that has to lie where the one before it does, within half a full step.

On CoreXY either motor tells that X or Y has ended, and a rotor that slips moves the other axis, too. So X, Y and X home, and an axis homes
again behind each time that the other may have slipped: the head ran on for longer than that, or for a full step behind a change that was
not believed. `$HX` and `$HY` home both. Axes with switches home as elsewhere.
"""

from micropython import const

from passo import commands, errors
from passo.control import homing
from passo.control.sensor import Sensor

_MOST = const(20)  # times that an end is located
_ENOUGH = const(5)
_LAST = const(4)  # the phase of the last pull-off
_AXES = const(3)  # mask of X and Y
_ROUNDS = const(12)  # times that X and Y home at most, taken together


class StallSensor(Sensor):
    """A DIAG pin. Its level before the axis is `blind` steps from `start` does not count. `late` once the axis has gone on for more than
    `full` steps behind a change, believed in the end or not. Its interrupt stops the player."""

    start = blind = full = 0
    late = False

    def sample(self, now_ms, position):
        """Take a sample; see Sensor. Nothing counts within `blind` steps of `start`."""
        if abs(position - self.start) < self.blind:
            self.restart(now_ms, False)
            return
        edge = self.edge if self.pending else position
        self.arm(not self.active)
        Sensor.sample(self, now_ms, position)
        if abs(position - (self.edge if self.pending else edge)) > self.full:
            self.late = True

    def arm(self, on):
        """Let the pin's interrupt stop the player, or not."""
        if self._latch:
            self._latch.arm(on)

    def note_stop(self, queue, axis):
        """Take over the edge, in steps, at which the pin's interrupt has stopped the player."""
        edge = queue.axis(axis, self._latch)
        self.restart(self.last_ms, True)
        self.edge = edge


class Homing(homing.Homing):
    def __init__(self, board, machine, queue):
        names = [axis["name"] for axis in board["axes"]]
        self._full = {}  # steps of a full step, by the number of an axis whose end is felt
        for motor in board["additions"].drives["motors"]:
            if motor["axis"] in board["additions"].stalls:
                self._full[names.index(motor["axis"])] = motor["microsteps"]
        self._shared = board.get("kinematics") == "corexy" and 0 in self._full  # both motors move X, and Y
        # Of the axis that homes, for it homes alone: how often its end has been located, how many of the last agree, the edge of these, the last,
        # how many have to, and whether a rotor may have slipped.
        self._located = self._agree = self._edge = self._last = self._enough = 0
        self._doubt = False
        homing.Homing.__init__(self, board, machine, queue)

    def _make_sensors(self, number):
        """Return the sensors of an axis: of one that is felt its motors' DIAG pins, of CoreXY's X and Y those of both motors."""
        if number not in self._full:
            return homing.Homing._make_sensors(self, number)
        return [self._make_feeler(motor, number) for motor in ((0, 1) if self._shared and number < 2 else (number,))]

    def _make_feeler(self, motor, axis):
        """Return the StallSensor of a motor for homing `axis`."""
        name = self._config["sensors"][self._axes[motor]["name"]]
        feeler = self._make_sensor(name, axis, StallSensor)
        feeler.full = self._full[axis]
        feeler.input = name
        return feeler

    def _begin_homing(self, command):
        """Do HOME; on CoreXY X and Y home together."""
        if self._shared and command.value & _AXES:
            command.value |= _AXES
        return homing.Homing._begin_homing(self, command)

    def _begin_search(self, now_ms):
        """See the base; no place has been located yet."""
        self._located = self._agree = 0  # of a homing that failed
        homing.Homing._begin_search(self, now_ms)

    def _active_feelers(self):
        """Return [(axis, sensor)] of the axes that home now and are felt."""
        found = []
        if self._machine.busy_with(commands.HOME) and not self._lifting:
            at = self._stage // len(self._phases)
            for group in self._groups[at : at + 1]:
                found += [(seeker.axis, sensor) for seeker in group if seeker.axis in self._full for sensor in seeker.sensors]
        return found

    def claim_stop(self, name):
        """Take over a stop by the interrupt of a DIAG pin, if that is of the axis that homes; the rest of its way is dropped."""
        for axis, sensor in self._active_feelers():
            if sensor.input == name:
                sensor.note_stop(self._queue, axis)
                self._machine.abort()
                return True
        return False

    def on_events(self, what):
        """See the base; no interrupt of a DIAG pin stops the player from here on."""
        homing.Homing.on_events(self, what)
        for _, sensor in self._active_feelers():
            sensor.arm(False)

    def _go_on(self, now_ms):
        """Go on to the next phase, see the base. Return ALARM_SENSOR_STUCK once twenty attempts cannot bring enough places that agree."""
        if self._located + self._enough - self._agree > _MOST or len(self._groups) > _ROUNDS:
            return errors.ALARM_SENSOR_STUCK
        return homing.Homing._go_on(self, now_ms)

    def _set_blind(self, seeker, steps):
        """Ignore the DIAG pins for the first `steps` of the way that begins."""
        for sensor in seeker.sensors:
            sensor.start = self._queue.axis(seeker.axis)
            sensor.blind = steps
            sensor.late = False
            sensor.restart(self._now_ms, False)
            sensor.arm(False)

    def _leave_sensor(self, seeker):
        """Phase 1: back off, at least 16 full steps, so that the rotor is free."""
        if seeker.axis not in self._full:
            homing.Homing._leave_sensor(self, seeker)
            return
        self._located = self._agree = 0
        self._enough = _ENOUGH
        # At first it may back off into the far end, unnoticed.
        self._doubt = all([group[0].axis != seeker.axis for group in self._groups[: self._stage // len(self._phases)]])
        self.until(None)
        self._back_away(seeker, seeker.pull_off_steps)

    def _back_away(self, seeker, steps):
        """Move `steps` away from the end, whatever the driver says meanwhile."""
        self.way(seeker, steps, seeker.seek_steps_s)
        self._set_blind(seeker, abs(steps) + 1)

    def _seek_sensor(self, seeker):
        """Phases 2 and 4: to the end, at the speed for which the threshold was found."""
        homing.Homing._seek_sensor(self, seeker)
        if seeker.axis in self._full:
            self._set_blind(seeker, seeker.pull_off_steps // 2)

    def _pull_off(self, seeker):
        """Phases 3 and 5: judge the place where it stalled, then pull off from there. Goes back to phase 3 until enough places agree."""
        homing.Homing._pull_off(self, seeker)
        if seeker.axis not in self._full:
            return
        edge = seeker.edges[seeker.tripped]
        full = self._full[seeker.axis]
        beyond = -self.steps_from_edge(seeker, seeker.tripped)
        slipped = 8 * beyond > full
        for sensor in seeker.sensors:
            self._doubt = self._doubt or slipped or sensor.late
        if not self._agree:
            self._edge = edge
        if slipped or 8 * abs(edge - self._edge) > 9 * full:  # a driver may tell one measurement later, and its edge be an eighth late
            self._enough += 1
            self._edge = edge
            self._agree = 0
        if not slipped:
            self._agree += 1
        if abs(edge - self._last) > full // 2:
            self._agree = min(self._agree, self._enough - 1)
        self._last = edge
        if self._stage % len(self._phases) == _LAST:
            if self._agree < self._enough:
                self._stage -= 2
            elif self._shared and self._doubt and seeker.axis < 2:
                other = 1 - seeker.axis  # homes once more at the end, unless its turn is still to come
                if other not in [group[0].axis for group in self._groups[self._stage // len(self._phases) + 1 :]]:
                    self._groups.append([self._make_seeker(other)])
        self._back_away(seeker, seeker.pull_off_steps + beyond)

    def _locate_edge(self, seeker):
        """Phase 4: to the end again."""
        if seeker.axis not in self._full:
            homing.Homing._locate_edge(self, seeker)
            return
        self._located += 1
        self._seek_sensor(seeker)
