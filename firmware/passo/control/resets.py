"""Beginning anew, and being out of service: reset, unlock, check mode, sleep."""

from passo import commands, errors
from passo.commands import RESTARTED, Event


class Resets:
    def __init__(self, machine):
        self._machine = machine

    def handlers(self):
        return {
            commands.RESET: self._reset,
            commands.UNLOCK: self._unlock,
            commands.CHECK: self._check,
            commands.SLEEP: self._sleep,
        }

    def restarted(self, command=None):
        """Tell all links that the machine begins anew, by `command` or because it was switched on; an active limit locks
        it, an open door holds it."""
        machine = self._machine
        limits = machine.inputs.limits_hit()
        if limits and not machine.alarm:
            machine.lock()
        machine.tell(Event(RESTARTED, None, machine.alarm, command))
        if limits:
            machine.notice(errors.NOTICE_LIMITS)
        if machine.inputs.door_open() and not machine.alarm:
            machine.pauses.open_door()

    def homing_failed(self, alarm):
        """Alarm, and the machine begins anew, as grbl does: nothing is done of what was sent behind the homing."""
        machine = self._machine
        machine.fail(alarm)
        machine.tools.restart()
        self.restarted()

    def _reset(self, command):
        machine = self._machine
        alarm = 0
        if machine.busy_with(commands.HOME):
            alarm = errors.ALARM_HOMING_RESET
        elif not (machine.queue.still() or machine.pauses.standing() or self._waits()):
            alarm = errors.ALARM_RESET
        elif machine.sleeping or machine.alarm in errors.NEED_RESET:
            machine.alarm = errors.ALARM_LOCKED
        machine.command = None
        machine.checking = machine.sleeping = False
        machine.arrest()
        machine.forget()
        machine.tools.restart()
        if alarm:
            machine.fail(alarm)
        self.restarted(command)
        return machine.accepted(command)

    def _waits(self):
        """True while the machine stands and something else takes its time."""
        command = self._machine.command
        return command is not None and command.kind in (commands.DWELL, commands.SPINDLE)

    def _unlock(self, command):
        machine = self._machine
        if machine.sleeping or machine.alarm in errors.NEED_RESET:
            return errors.LOCKED
        if machine.alarm:
            if machine.inputs.door_open():
                return errors.DOOR_OPEN
            machine.links.wary = 0
            machine.alarm = 0
            machine.notice(errors.NOTICE_UNLOCKED)
        return machine.accepted(command)

    def _check(self, command):
        machine = self._machine
        if command.value:
            if machine.state != "idle":
                return errors.BUSY
            machine.checking = True
            machine.notice(errors.NOTICE_CHECK_ON)
            return machine.accepted(command)
        machine.notice(errors.NOTICE_CHECK_OFF)
        machine.accepted(command)
        return self._reset(command)

    def _sleep(self, command):
        machine = self._machine
        machine.shut_down()
        machine.tools.restart()
        machine.links.wary = 0
        machine.sleeping = True
        machine.notice(errors.NOTICE_SLEEPING)
        return machine.accepted(command)
