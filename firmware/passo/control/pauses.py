"""Holding and going on: feed hold, safety door, the operator's pause, and coming to a stand to drop what is left."""

from passo import commands, errors
from passo.config.setting_numbers import LASER
from passo.control.feature import OFF, Feature
from passo.records import COUNT_MASK


class Pauses(Feature):
    def __init__(self, board, machine, queue):
        self._spindle = board["spindle"]
        Feature.__init__(self, board, machine, queue)
        self._port = machine.port
        self._was_lit = False  # the tool was on when the machine came to its stand
        self._ready_ms = None  # before that spindle and coolant, just switched on again, are not there yet

    def handlers(self):
        """Return {kind of command: method} of this feature."""
        return {
            commands.HOLD: self._feed_hold,
            commands.RESUME: self._resume_motion,
            commands.DOOR: self._handle_door,
            commands.JOG_CANCEL: self._cancel_jog,
            commands.TOGGLE: self._toggle_output,
            commands.PAUSE: self._pause_program,
        }

    # --- commands

    def _feed_hold(self, command):
        """Come to a stand and hold; of a jog drop the rest. Ignored unless idle or running."""
        machine = self._machine
        if machine.jogging:
            return self._cancel_jog(command)
        if machine.resuming:
            self._begin_hold(machine.hold)
        elif machine.state in ("idle", "run"):
            self._begin_hold("hold")
        return machine.confirm_command(command)

    def _handle_door(self, command):
        """Hold as the door opens, as grbl does: an alarm and check mode take no notice of the door, and homing ends with an alarm that says it."""
        machine = self._machine
        if machine.busy_with(commands.HOME):
            machine.homing_failed(errors.ALARM_HOMING_DOOR)
            return machine.confirm_command(command)
        state = machine.state
        if state not in ("alarm", "check"):
            machine.notice(errors.NOTICE_DOOR)
        if state in ("idle", "run", "hold", "jog", "door"):
            if machine.jogging:
                machine.drop_at_stand()
            self._begin_hold("door")
        return machine.confirm_command(command)

    def _pause_program(self, command):
        """Hold for the operator until RESUME (M0, M6; `value`: the tool + 1). Returns LATER until the machine stands."""
        machine = self._machine
        result = machine.gate()
        if result:
            return result
        if machine.checking:
            return machine.confirm_command(command)
        machine.begin(command)
        if command.value:
            machine.notice(errors.NOTICE_TOOL, command.value - 1)
        else:
            machine.notice(errors.NOTICE_PAUSE)
        self._begin_hold("hold")
        return 0

    def _begin_hold(self, kind):
        """Begin a hold, `kind` "hold" or "door": the feeder comes to a stand."""
        machine = self._machine
        if not machine.hold:
            self._was_lit = False
            self._ready_ms = None
        machine.hold = kind
        machine.stood = machine.resuming = False
        self._queue.hold(True)

    def _is_laser(self):
        """Return True if the tool is a laser ($32)."""
        return self._machine.settings.value(LASER)

    def _light_tool(self):
        """Switch the tool on again at a stand."""
        if self._machine.gauge:
            self._machine.gauge.expect(True)
        self._queue.rest(True)
        self._delay_resume(max(self._queue.tool_ms(True), 0 if self._is_laser() else self._spindle["spin_up_ms"]))

    def _delay_resume(self, ms):
        """Delay the resume until `ms` milliseconds from now; the longest delay counts."""
        ready_ms = self._port.machine_ms() + ms & COUNT_MASK
        if ms and (self._ready_ms is None or (ready_ms - self._ready_ms) & COUNT_MASK < COUNT_MASK // 2):
            self._ready_ms = ready_ms

    def _resume_motion(self, command):
        """Begin to resume a hold that has come to its stand, unless the door is open or an alarm is on."""
        machine = self._machine
        ready = machine.stood and not machine.resuming and not machine.alarm
        if ready and not (machine.hold == "door" and machine.inputs.door_open()):
            machine.resuming = True
            self._switch_on()
        return machine.confirm_command(command)

    def _switch_on(self):
        """Switch coolant on again, then the tool; a laser only once the coolant is there."""
        machine = self._machine
        if machine.hold == "door":
            machine.show_outputs(True)
            self._delay_resume(self._spindle["coolant_ms"] if machine.coolant else 0)
        if not self._is_laser():  # a laser would burn while the coolant comes
            self._restore_tool()

    def _restore_tool(self):
        """Light the tool again if it was on when the machine came to its stand."""
        if self._was_lit and not self._queue.lit():
            if self._machine.hold == "hold" and not self._is_laser():
                self._machine.notice(errors.NOTICE_SPINDLE)
            self._light_tool()

    def _cancel_jog(self, command):
        """Come to a stand and drop the rest of a jog."""
        machine = self._machine
        if machine.jogging and not machine.dropping:
            machine.drop_at_stand()
        return machine.confirm_command(command)

    def _toggle_output(self, command):
        """Switch the coolants of mask `value` over, or in a hold the spindle."""
        machine = self._machine
        if command.value == commands.SPINDLE_STOP:
            at_stand = machine.hold == "hold" and machine.stood and not machine.resuming
            if at_stand and self._was_lit and not self._is_laser():
                if self._queue.lit():
                    self._queue.rest(False)
                else:
                    self._restore_tool()
        elif machine.state in ("idle", "run", "hold", "jog"):
            if machine.hold and not machine.coolant & command.value:
                self._delay_resume(self._spindle["coolant_ms"])
            machine.coolant ^= command.value
            machine.show_outputs(machine.hold != "door")
        return machine.confirm_command(command)

    # --- what goes on over many passes

    def poll_hold(self):
        """Once a hold has come to its stand: drop the rest, note the stand, or go on when tool and coolant are back."""
        machine = self._machine
        if not self._queue.standing():
            return
        if machine.dropping:
            kind = machine.hold
            machine.drop()
            machine.end_hold()
            if errors.ALARMS.get(machine.alarm, 0) & (errors.NEEDS_RESET | errors.OUTPUTS_OFF) and not machine.retracts:
                machine.inform(OFF)
            if kind == "door":
                self._begin_hold(kind)
        elif not machine.stood:
            self._begin_stand()
        elif self._ready_ms is not None:
            if (self._port.machine_ms() - self._ready_ms) & COUNT_MASK < COUNT_MASK // 2:
                self._ready_ms = None
        elif machine.resuming:
            self._restore_tool()
            if self._ready_ms is None and (machine.is_at_speed() or not self._queue.lit()):
                self._go_on()

    def _begin_stand(self):
        """Note that the hold has come to its stand: a laser goes off, behind an open door all outputs do."""
        machine = self._machine
        machine.stood = True
        lit = self._queue.lit()
        self._was_lit = self._was_lit or lit
        if lit and (machine.hold == "door" or self._is_laser()):
            self._queue.rest(False)
        if machine.hold == "door":
            machine.show_outputs(False)

    def _go_on(self):
        """End the hold: motion goes on."""
        machine = self._machine
        machine.end_hold()
        self._queue.hold(False)
        if machine.busy_with(commands.PAUSE):
            machine.finish()
