"""A gantry's two motors, kept abreast by their encoders.

    "gantry": {"axis": "x", "pins": [28, 29], "wait_steps": 4, "limit_steps": 20}

The lag is what the second motor has turned beyond the first. By the rule of 2004 the leading motor waits until the lag is gone:

- in a move, from wait_steps on, the machine comes to a stand on its path; the motor that is behind is stepped alone, one
  step every three cycles of the main loop; then the move goes on;
- at the end of a move, and at the stand of a hold, each step of lag is taken away the same way;
- a lag beyond limit_steps halts the player in the interrupt that checks encoders: alarm 231, with both counts. So the two are never
  further apart than limit_steps and what is played until the next check, 3 ms;
- lags that have been taken away in one direction since the axis homed add up, and with the next one they reach limit_steps at most: a motor
  that loses steps looks like an encoder that loses counts, by which the gantry would be racked. Beyond it: alarm 231, with the figure.

These single steps are no words: the position does not change by them. Without encoders the feature does nothing.
"""

from micropython import const

from passo import commands
from passo.control.feature import WORK_GONE, Feature
from passo.control.motors import RELEASED
from passo.errors import ALARMS, KEEPS_CURRENT
from passo.options.gantry.control_squaring import Squaring
from passo.options.gantry.errors import ALARM_GANTRY, NOTICE_GANTRY, SQUARED
from passo.records import COUNT_MASK

_SQUARINGS = const(4)  # at one stand
_LEAST_MS = const(20)  # at rest: some checks of the encoders
_TURN = const(1)  # DIR shows
_RISE = const(2)  # STEP rises
_FALL = const(3)  # and falls


class GantryWatch(Feature):
    event_mask = WORK_GONE

    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        ALARMS[ALARM_GANTRY] = KEEPS_CURRENT
        self._feeder, self._player = queue.lend()
        self._encoders = getattr(machine.port, "encoders", None)  # of the port, if the board file has any
        section = board["gantry"]
        self._axis = [axis["name"] for axis in board["axes"]].index(section["axis"])
        self._motors = section["axis"], section["axis"] + "2"
        self._pair = self._encoders.gantry if self._encoders else ()
        self._wait_steps = section["wait_steps"]
        self._limit_steps = section["limit_steps"]
        self._settle_ms = max([item["settle_ms"] for item in board.get("encoders", ())] + [_LEAST_MS])
        self._waiting = False  # the move stands, or is coming to its stand, for the lag
        self._phase = 0  # of the step under way
        self._motor = self._forward = self._left = 0
        self._tries = 0
        self._taken = 0  # lag that has been taken away since homing, steps, signed
        self._stood_ms = 0
        self._checks = 0

        self._squaring = machine.squaring = Squaring(board, queue) if section["sensor"] else None

    def on_events(self, what):
        """Let both motors step again, after a homing that ended early."""
        if self._squaring:
            self._squaring.use_both()

    def ready(self):
        """Return whether words may be played: no single step is under way."""
        return not self._phase

    def busy(self):
        """Return whether a move waits for the lag, or a single step is under way."""
        return self._waiting or self._phase > 0

    def halt(self):
        """Forget the wait and the step under way."""
        self._waiting = False
        self._phase = self._tries = 0

    def claim_stop(self, name):
        """Raise alarm 231 if the encoders have stopped the player for the lag."""
        if not self._pair or name != self._encoders.name or not self._encoders.lagging:
            return False
        self._raise_alarm()
        return True

    def _raise_alarm(self):
        """Raise alarm 231: the log has both counts, the lag and the lags taken away since homing, in steps."""
        encoders = self._encoders
        counts = ["%s %d" % (name, encoders.count_of(number)) for name, number in zip(self._motors, self._pair)]
        who = "%s counts lag %+d steps" % (" ".join(counts), encoders.lag_steps())
        if self._taken:
            who += ", %+d taken away since homing" % self._taken
        self._machine.raise_alarm(ALARM_GANTRY, who)
        self._machine.notice(NOTICE_GANTRY, who)

    def look(self, now_ms):
        """Hold a move whose lag has reached wait_steps; at a stand take the lag away, step by step. See above."""
        if not self._pair:
            return
        machine = self._machine
        queue = self._queue
        if machine.alarm or machine.busy_with(commands.HOME) or machine.motors.detached or machine.motors.state == RELEASED:
            self.halt()
            self._note_stand(now_ms)
            if machine.busy_with(commands.HOME) and (not machine.command.value or machine.command.value >> self._axis & 1):
                self._taken = 0
            return
        if self._phase:
            machine.awake = True
            self._step_alone(now_ms)
            return
        if not (queue.still() or queue.standing()):
            self._note_stand(now_ms)
            if self._wait_steps and not self._waiting and abs(self._encoders.lag_steps()) >= self._wait_steps:
                self._waiting = True
                queue.hold(True)
            return
        if self._encoders.checks == self._checks or (now_ms - self._stood_ms) & COUNT_MASK < self._settle_ms:
            return
        lag = self._encoders.lag_steps()
        if lag:
            self._begin_squaring(lag)
        else:
            self._tries = 0
            if self._waiting:
                self._waiting = False
                if not machine.hold:
                    queue.hold(False)

    def _note_stand(self, now_ms):
        """Note when, and at which check of the encoders, the machine may have come to rest."""
        self._stood_ms = now_ms
        self._checks = self._encoders.checks

    def _begin_squaring(self, lag):
        """Begin to step the motor that is further off, alone, `lag` steps. Raises alarm 231 beyond limit_steps, or if the interlock forbids it."""
        self._tries += 1
        if self._tries > _SQUARINGS or abs(self._taken + lag) > self._limit_steps or abs(lag) > self._limit_steps:
            self._raise_alarm()
            return
        first, second = [self._encoders.steps_beyond(number) for number in self._pair]
        self._motor = 1 if abs(second) >= abs(first) else 0
        self._forward = lag < 0 if self._motor else lag > 0
        self._left = abs(lag)
        steps = [0] * (self._axis + 1)
        steps[self._axis] = 1 if self._forward else -1
        if self._machine.interlock_error(steps):
            self._raise_alarm()
            return
        self._machine.note(SQUARED, "%s %+d" % (self._motors[self._motor], self._left if self._forward else -self._left))
        self._taken += lag
        self._phase = _TURN

    def _step_alone(self, now_ms):
        """Write the next level of a single step, one a cycle: DIR, STEP high, STEP low."""
        phase = self._phase
        step, direction = self._feeder.drive.pin_masks(self._motor)
        levels = self._queue.pins(self._queue.lit()) & ~direction
        self._player.rest(levels | (direction if self._forward else 0) | (step if phase == _RISE else 0))
        self._phase = phase + 1 if phase < _FALL else _RISE
        if phase == _FALL:
            self._left -= 1
            if not self._left:
                self._player.rest(self._queue.pins(self._queue.lit()))
                self._phase = 0
                self._note_stand(now_ms)
