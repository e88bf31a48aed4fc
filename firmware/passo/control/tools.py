"""The outputs that a programme switches beside motion: the spindle or laser, coolant, and the overrides."""

from micropython import const

from passo import commands, errors
from passo.commands import SPINDLE_OFF, thousandths
from passo.config import setting_numbers as table
from passo.control.feature import ANEW, HANDED_OVER, OFF, Feature
from passo.errors import LATER
from passo.records import SEEN_LIT

_BLOCKS = const(2)  # room for a change of the tool
_LOWEST = const(10)  # of feed and spindle override, per cent
_HIGHEST = const(200)


class Tools(Feature):
    event_mask = OFF | HANDED_OVER | ANEW

    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        self._planner = queue.planner
        self._port = machine.port
        self._outputs = [item["name"] for item in board["outputs"]]
        self._settings_of = None  # the settings' version that the power's range is of
        self._lasing = False
        self._own = False  # jogs, probing and homing are under way: none of them is the programme's
        self._dark = False  # at a stand: a laser whose power follows the speed is off
        self._cools = 0  # coolant as it is; the machine has it as it should be
        machine.overrides = [100, 100, 100]  # feed, rapid, spindle

    def on_events(self, what):
        """Switch spindle and coolant off; with ANEW all is as after power-up."""
        machine = self._machine
        machine.spindle = SPINDLE_OFF
        machine.power = machine.coolant = 0
        if self._queue.lit():
            self._queue.rest(False)
        self._dark = True
        self.show_outputs(False)
        if what & ANEW:
            if machine.overrides != [100, 100, 100]:
                machine.overrides = [100, 100, 100]
                self._override_all()

    def poll_end(self, still):
        """Switch off a laser whose power follows the speed while nothing moves (`still`)."""
        machine = self._machine
        own = machine.jogging or machine.command is not None and machine.fine()
        if own != self._own:
            self._own = own
            if machine.overrides != [100, 100, 100]:
                self._override_motion()
        if self._settings_of != machine.settings.version:
            self._settings_of = machine.settings.version
            lases = machine.settings.value(table.LASER)
            changes = self._lasing != lases
            if changes and self._lasing:  # a laser was on, and is a spindle now, which M3 or M4 has to start
                machine.spindle = SPINDLE_OFF
                machine.power = 0
                self.show_outputs(machine.hold != "door")
            self._lasing = lases
            self._override_power()
            if changes and still and self._queue.lit():  # if it is a laser now, it is dark until a motion lights it
                self._queue.rest(False)
        if not still:
            self._dark = False
        elif not self._dark:
            self._dark = True
            if self._lasing and self._queue.dynamic() and self._queue.lit():
                self._queue.rest(False)

    def handlers(self):
        return {
            commands.SPINDLE: self._turn_spindle,
            commands.COOLANT: self._set_coolant,
            commands.OVERRIDE: self._set_override,
        }

    def _turn_spindle(self, command):
        """Switch the spindle or laser: `value` 3, 4 or SPINDLE_OFF, `power` in millionths. Returns 0, LATER, or an error."""
        machine = self._machine
        laser = machine.settings.value(table.LASER)
        if machine.alarm or machine.sleeping:
            return errors.LOCKED
        if laser and command.value == machine.spindle:
            if machine.command is not None or self._queue.room() < _BLOCKS:
                return LATER
        else:
            result = machine.gate()
            if result:
                return result
        if not machine.checking:
            if command.value != SPINDLE_OFF:
                result = machine.interlock_error((), True)
                if result:
                    return result
            turned = command.value != machine.spindle
            machine.spindle = command.value
            machine.power = command.power if command.value != SPINDLE_OFF else 0
            if machine.gauge:
                machine.gauge.expect(command.value != SPINDLE_OFF)
            self._planner.set_power(0 if laser and not command.tool else thousandths(machine.power), False)
            self.show_outputs(machine.hold != "door")
            still = self._queue.still()
            lit = self._queue.lit() if still else self._queue.tool
            if command.tool != lit:
                self._queue.set_tool(command.tool, 0)
                machine.note_motion()
                if still or not laser:
                    self._queue.flush()
                    return machine.begin(command)
            elif not laser or still and lit:
                self._queue.analogue.set(thousandths(machine.power))
                self._queue.restore_power()
                if turned and lit and not laser and self._queue.tool_ms(True):  # the other way round
                    self._queue.wait(self._queue.tool_ms(True), 0)
                    self._queue.flush()
                    return machine.begin(command)
                if lit and not machine.is_at_speed():
                    return machine.begin(command)
        return machine.confirm_command(command)

    def _set_coolant(self, command):
        """Set the coolant, mask `value`, at a stand. Returns 0, LATER, or an error."""
        machine = self._machine
        result = machine.gate()
        if result:
            return result
        if not machine.checking:
            machine.coolant = command.value
            self.show_outputs(machine.hold != "door")
        return machine.confirm_command(command)

    def show_outputs(self, on):
        """Switch coolant and the spindle's direction as set, or all of them off (`on` False: the door holds the machine)."""
        self._cools = self._machine.coolant if on else 0
        for name, shown in (("flood", self._cools & 1), ("mist", self._cools & 2), ("reverse", on and self._machine.spindle == 4)):
            if name in self._outputs:
                self._port.output(name, bool(shown))

    def _set_override(self, command):
        """Set override `value`: to `power` percent, or by `feed` percent within 10 … 200; commands.ALL: all to 100."""
        which = command.value
        overrides = self._machine.overrides
        if which == commands.ALL:
            overrides[:] = (100, 100, 100)
        elif command.power:
            overrides[which] = command.power
        else:
            overrides[which] = max(_LOWEST, min(_HIGHEST, overrides[which] + command.feed))
        self._override_all()
        return self._machine.confirm_command(command)

    def _override_motion(self):
        """Give the planner feed and rapid override; jogs, probing and homing go at 100 %."""
        feed, rapid, _ = (100, 100, 0) if self._own else self._machine.overrides
        self._planner.override(feed, rapid)

    def _override_all(self):
        """Apply all overrides."""
        self._override_motion()
        self._override_power()

    def _override_power(self):
        """Apply the spindle override to the power, not below $31."""
        settings = self._machine.settings
        least = settings.value(table.MIN_RPM) * 1000 // settings.value(table.MAX_RPM)
        self._queue.analogue.adjust(self._machine.overrides[2], min(least, 999))
        if self._queue.lit():
            self._queue.restore_power()

    def report(self, report):
        """Add spindle, coolant and overrides to the status report."""
        power = 0
        machine = self._machine
        lit = self._queue.seen[SEEN_LIT]
        if lit:
            power = self._queue.analogue.value * 1000 if self._lasing else machine.power
            percent = machine.overrides[2]
            if percent != 100:
                power = min(power * percent // 100, 1_000_000)
        report["power"] = power
        report["spindle"] = machine.spindle if lit else SPINDLE_OFF
        report["coolant"] = self._cools
        report["overrides"] = machine.overrides
