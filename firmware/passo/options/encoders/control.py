"""The actions on following errors: an alarm, a correction at the end of a move, a position that is verified after a halt.

    [{"motor": "x", "pins": [14, 15], "pulses": 500, "steps": 400, "limit_steps": 8, "correct": True}]

The port compares counts and steps every 3 ms, and halts the player if a motor is further off than its limit_steps
(port.py); that is alarm 230, and the log says how many steps are missing and where. It cannot tell whether the motor has
lost steps or the encoder counts: after this alarm the machine has to be homed. How many are missing is exact once the
motor has settled, settle_ms behind the last step:

- at the end of a move steps that are missing are made up for, if the board file says so, thrice at most; corrections in one direction since the axis homed
count toward limit_steps, for an encoder that loses counts looks the same, and the axis drifts;
- after a halt the position becomes what the encoders say, and a machine that was homed still is, if each of its axes has
  one;
- without current motors may be turned by hand: the position follows.
"""

from micropython import const

from passo import commands, errors
from passo.config import setting_numbers as table
from passo.control.feature import Feature
from passo.control.motors import RELEASED
from passo.options.encoders.commands import ZERO_COUNTS
from passo.options.encoders.errors import ALARM_STEPS_MISSING, COUNTS_LOST, NOTICE_STEPS_MISSING, POSITION_VERIFIED, STEPS_MADE_UP
from passo.records import COUNT_MASK

_TRIES = const(3)


class EncoderWatch(Feature):
    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        errors.ALARMS[ALARM_STEPS_MISSING] = errors.KEEPS_CURRENT
        self._encoders = machine.port.encoders
        self._axes = [axis["name"] for axis in board["axes"]]
        self._correct = [item["correct"] for item in board["encoders"]]
        self._limits = [item["limit_steps"] for item in board["encoders"]]
        self._made_up = [0] * len(self._correct)  # steps of each motor since its axis homed, signed
        self._first, self._second = self._encoders.gantry or (-1, -1)
        self._settle_ms = max([item["settle_ms"] for item in board["encoders"]])
        homing = board["homing"]
        self._all = not [name for name in (homing["sensors"] if homing else self._axes) if name not in self._encoders.names]
        self._still_ms = 0  # since when it stands
        self._checks = 0  # of the encoders as it came to stand, or as an error was last accounted for
        self._settled = False
        self._halted = False  # the position is that of the encoders
        self._homed = False  # it was before the halt
        self._known = 0  # mask of the axes that were
        self._homing = False
        self._mask = 0  # axes that are being homed; 0: all
        self._tries = 0

    def handlers(self):
        return {ZERO_COUNTS: self._zero_counts}

    def _zero_counts(self, command):
        """Do ZERO_COUNTS: the counts shown begin at 0."""
        self._encoders.zero_counts()
        return self._machine.confirm_command(command)

    def report(self, report):
        encoders = self._encoders
        report["counts"] = ",".join([str(encoders.count_of(number)) for number in range(len(encoders.names))])

    def halt(self):
        """Note that the position will be that of the encoders, once the motors have settled."""
        if not self._homing:
            if not self._halted:
                self._homed = self._machine.homed
                self._known = self._machine.known
            self._halted = True
        self._note_move()

    def claim_stop(self, name):
        """Raise alarm 230 if the encoders have stopped the player. A gantry's lag is the gantry's affair."""
        if name != self._encoders.name or self._encoders.lagging:  # a gantry sees to that
            return False
        beyond = self._encoders.beyond
        self._raise_alarm([number for number in range(len(self._correct)) if beyond >> number & 1])
        return True

    def _raise_alarm(self, missing):
        """Raise alarm 230: the log says how many steps each of the motors `missing` has turned too many, and where the machine is."""
        encoders = self._encoders
        said = []
        for number in missing:
            made = self._made_up[number]
            said.append("%s %+d" % (encoders.names[number], encoders.steps_beyond(number)) + (", %+d made up since homing" % made if made else ""))
        positions = ["%s%d" % item for item in zip(self._axes, self._queue.position())]
        who = "%s at %s" % (" ".join(said), " ".join(positions))
        self._machine.raise_alarm(ALARM_STEPS_MISSING, who)
        self._machine.notice(NOTICE_STEPS_MISSING, who)
        self._known = 0

    def _note_move(self):
        """Note that counts are not exact yet: the machine moves, or has just moved."""
        self._settled = False
        self._checks = self._encoders.checks

    def _look_at_indexes(self):
        """Log an index pulse that is more than a 32nd of a turn from whole turns, once. A late interrupt moves it by up to 100 µs of counts."""
        for index in self._encoders.indexes:
            off = index.counts_off()
            if abs(off) > index.turn // 32:
                self._machine.note(COUNTS_LOST, "%s %+d counts" % (self._encoders.names[index.number], off))
                index.accept_last()

    def look(self, now_ms):
        """Arm the check of following errors while that may halt; at rest, settle_ms behind the last step, act on the counts."""
        machine = self._machine
        if self._encoders.indexes:
            self._look_at_indexes()
        homing = machine.busy_with(commands.HOME)
        still = self._queue.still() and not homing
        self._encoders.arm(not (machine.alarm not in errors.WATCHED or self._halted or homing or machine.motors.state == RELEASED))
        if not still:
            self._still_ms = now_ms
            self._homing = homing
            if homing:
                self._mask = machine.command.value
            self._note_move()
            return
        if self._homing:  # the sensors have said where the axes are: forget the steps that encoders missed
            self._homing = self._halted = False
            for number in range(len(self._correct)):
                if not self._mask or self._mask >> self._encoders.axis_of(number) & 1:
                    self._encoders.clear_error(number)
                    self._made_up[number] = 0
            self._note_move()
        if (now_ms - self._still_ms) & COUNT_MASK < self._settle_ms or self._encoders.checks == self._checks:
            return
        self._act_at_rest()

    def _act_at_rest(self):
        """Act on the following errors at a stand, when the counts are exact: verify after a halt, follow without current, or make up."""
        encoders = self._encoders
        off = [encoders.steps_beyond(number) for number in range(len(encoders.names))]
        if self._halted:
            self._verify_position(off)
        elif any(off):
            if self._machine.motors.state == RELEASED:
                self._follow_encoders(off)
            elif not self._settled and not self._make_up(off):
                return
        else:
            self._tries = 0
        self._settled = True

    def _verify_position(self, off):
        """Take over the encoders' position behind a halt. A machine that was homed still is, if each of its axes has an encoder."""
        machine = self._machine
        self._halted = False
        if any(off):
            self._note_steps(POSITION_VERIFIED, off)
        self._follow_encoders(off)
        if self._known and self._all:
            if not machine.homed and not any(off):
                machine.note(POSITION_VERIFIED, "")
            machine.known = self._known
            machine.homed = self._homed

    def _follow_encoders(self, off):
        """Shift the position by `off`, steps of each motor."""
        for number in range(len(off)):
            if off[number] and number != self._second:
                self._account_for(number, off[number])
        self._queue.settle()

    def _account_for(self, number, steps):
        """Shift an axis's position by `steps`, and count them as no error any more; of a gantry for both motors, so that the lag stays."""
        encoders = self._encoders
        self._queue.shift(encoders.axis_of(number), steps)
        encoders.account_for(number, steps)
        if number == self._first:
            encoders.account_for(self._second, steps)  # the lag stays, until it is squared
        self._checks = encoders.checks

    def _make_up(self, off):
        """Queue the steps that are missing at the end of a move. Returns False if a gantry has to be squared first."""
        machine = self._machine
        if machine.alarm or machine.hold or machine.command is not None:
            return True
        missing = [number for number in range(len(off)) if off[number] and self._correct[number]]
        if not missing:
            return True
        if self._second >= 0 and off[self._first] != off[self._second]:
            return False  # first the gantry has to be square
        self._tries += 1
        beyond = [number for number in missing if abs(self._made_up[number] + off[number]) > self._limits[number]]
        if beyond or self._tries > _TRIES:
            self._tries = 0
            self._raise_alarm(beyond or missing)
            return True
        for number in missing:
            self._made_up[number] += off[number]
        self._note_steps(STEPS_MADE_UP, off)
        ways = []
        for number in missing:
            if number != self._second:
                self._account_for(number, off[number])
                axis = self._encoders.axis_of(number)
                ways.append((axis, -off[number], self._correction_speed(axis)))
        self._queue.travel(ways)
        machine.awake = True
        return True

    def _note_steps(self, number, off):
        """Log event `number` with the error of each motor, in steps."""
        names = self._encoders.names
        self._machine.note(number, " ".join(["%s %+d" % (names[n], off[n]) for n in range(len(off)) if off[n]]))

    def _correction_speed(self, axis):
        """Return a tenth of the axis's highest speed, steps/s, at least 1."""
        settings = self._machine.settings
        steps_s = settings.value(table.STEPS + axis) * settings.value(table.SPEED + axis) // 600_000_000
        return max(steps_s, 1)
