"""Beginning anew, and being out of service: reset, unlock, check mode, sleep."""

from passo import commands, errors
from passo.control.feature import ANEW, WORK_GONE, Feature

_STANDS = (commands.DWELL, commands.SPINDLE)  # while one of these takes its time the machine stands


class Resets(Feature):
    def handlers(self):
        """Return {kind of command: method} of this feature."""
        return {
            commands.RESET: self._reset_machine,
            commands.UNLOCK: self._unlock_machine,
            commands.CHECK: self._set_check_mode,
            commands.SLEEP: self._enter_sleep,
        }

    def _reset_machine(self, command):
        """Begin anew, as grbl's soft reset: amid motion or homing an alarm, as the position may be lost."""
        machine = self._machine
        alarm = 0
        kind = commands.RESET if machine.command is None else machine.command.kind
        if kind == commands.HOME:
            alarm = errors.ALARM_HOMING_RESET
        elif not (self._queue.still() or machine.hold and machine.stood or kind in _STANDS):
            alarm = errors.ALARM_RESET
        elif machine.sleeping or machine.needs_reset():
            machine.alarm = errors.ALARM_LOCKED
        machine.checking = machine.sleeping = False
        if alarm:
            machine.command = None
            machine.raise_alarm(alarm, None, ANEW)
        else:
            machine.abort()
            machine.inform(WORK_GONE | ANEW)
        machine.announce_restart(command)
        return machine.confirm_command(command)

    def _unlock_machine(self, command):
        """End an alarm. Returns 0, LOCKED if only a reset or homing ends it, or DOOR_OPEN."""
        machine = self._machine
        if machine.sleeping or machine.needs_reset():
            return errors.LOCKED
        if machine.alarm:
            if machine.inputs.door_open():
                return errors.DOOR_OPEN
            machine.unlock()
            machine.notice(errors.NOTICE_UNLOCKED)
            machine.warn()
        return machine.confirm_command(command)

    def _set_check_mode(self, command):
        """Switch check mode on (`value` 1) or off, which resets the machine. Returns 0, or BUSY unless idle."""
        machine = self._machine
        if command.value:
            if machine.state != "idle":
                return errors.BUSY
            machine.checking = True
            machine.notice(errors.NOTICE_CHECK_ON)
            return machine.confirm_command(command)
        machine.notice(errors.NOTICE_CHECK_OFF)
        machine.confirm_command(command)
        return self._reset_machine(command)

    def _enter_sleep(self, command):
        """Switch everything off until RESET."""
        machine = self._machine
        machine.shut_down(ANEW)
        machine.guarded = 0
        machine.sleeping = True
        machine.notice(errors.NOTICE_SLEEPING)
        return machine.confirm_command(command)
