"""Holding and going on: feed hold, safety door, the operator's pause, and coming to a stand to drop what is left.

`kind` is the machine's state while it is held: "hold" or "door"; "" otherwise.
"""

from passo.protocols import commands, errors
from passo.steps.word import COUNT_MASK


class Pauses:
    def __init__(self, queue, machine, port):
        self._queue = queue
        self._machine = machine
        self._port = port
        self.kind = ""
        self.dropping = False  # at the stand, what is left is dropped
        self._stood = False
        self._was_lit = False  # the tool was on when the machine came to its stand
        self._resume_ms = None  # when the tool will be there again

    def handlers(self):
        return {
            commands.HOLD: self._hold,
            commands.RESUME: self._resume,
            commands.DOOR: self._door,
            commands.JOG_CANCEL: self._cancel_jog,
            commands.TOGGLE: self._toggle,
        }

    def clear(self):
        """All is dropped: nothing is held any more."""
        self.kind = ""
        self.dropping = self._stood = self._was_lit = False
        self._resume_ms = None

    def standing(self):
        """True in a hold that has come to its stand."""
        return bool(self.kind) and self._stood

    def substate(self):
        """grbl's number behind Hold: (0 at a stand, 1 on the way there) and Door: (0 ready, 1 open, 2 on the way to its
        stand, 3 resuming)."""
        if self._resume_ms is not None:
            return 3 if self.kind == "door" else 1
        if not self._stood:
            return 2 if self.kind == "door" else 1
        return 1 if self.kind == "door" and self._machine.inputs.door_open() else 0

    def pause(self):
        """The operator's pause: at a stand already."""
        self._stop("hold")

    def drop(self):
        """Come to a stand, then drop what is queued."""
        self.dropping = True
        self._queue.flush()
        self._queue.hold(True)

    # --- commands

    def _hold(self, command):
        machine = self._machine
        if machine.program.jogging:
            return self._cancel_jog(command)
        if machine.state in ("idle", "run"):
            self._stop("hold")
        return machine.accepted(command)

    def _door(self, command):
        machine = self._machine
        self.open_door()
        return machine.accepted(command)

    def open_door(self):
        """As grbl: an alarm and check mode take no notice of the door, and homing ends with an alarm that says it."""
        machine = self._machine
        if machine.busy_with(commands.HOME):
            machine.resets.homing_failed(errors.ALARM_HOMING_DOOR)
            return
        state = machine.state
        if state not in ("alarm", "check"):
            machine.notice(errors.NOTICE_DOOR)
        if state in ("idle", "run", "hold", "jog", "door"):
            if machine.program.jogging:
                self.drop()
            self._stop("door")

    def _stop(self, kind):
        self.kind = kind
        self._stood = False
        self._resume_ms = None
        self._queue.hold(True)

    def _resume(self, command):
        machine = self._machine
        ready = self._stood and self._resume_ms is None and not machine.alarm
        if ready and not (self.kind == "door" and machine.inputs.door_open()):
            self._resume_ms = self._port.machine_ms()
            if self._was_lit and not self._queue.lit():
                self._queue.rest(True)
                self._resume_ms += self._queue.tool_ms(True)
            if self.kind == "door":
                machine.tools.show_outputs(True)
        return machine.accepted(command)

    def _cancel_jog(self, command):
        if self._machine.program.jogging and not self.dropping:
            self.drop()
        return self._machine.accepted(command)

    def _toggle(self, command):
        machine = self._machine
        if command.value == commands.SPINDLE_STOP:
            if self.kind == "hold" and self._stood and self._was_lit and not machine.tools.laser():
                self._queue.rest(not self._queue.lit())
        elif machine.state in ("idle", "run", "hold", "jog"):
            machine.tools.set_coolant(machine.tools.coolant ^ command.value)
        return machine.accepted(command)

    # --- what goes on over many turns

    def poll(self, now_ms):
        if not self.kind and not self.dropping:
            return
        if not self._queue.standing():
            return
        if self.dropping:
            kind = self.kind
            self._queue.drop()
            self._machine.program.dropped()
            self.clear()
            if self._machine.alarm in errors.NEED_RESET:
                self._machine.tools.switch_off()
            if kind == "door":
                self._stop(kind)
        elif not self._stood:
            self._stood = True
            lit = self._queue.lit()
            self._was_lit = self._was_lit or lit
            if lit and (self.kind == "door" or self._machine.tools.laser()):
                self._queue.rest(False)
            if self.kind == "door":
                self._machine.tools.show_outputs(False)
        elif self._resume_ms is not None and (now_ms - self._resume_ms) & COUNT_MASK < COUNT_MASK // 2:
            self.clear()
            self._queue.hold(False)
            if self._machine.busy_with(commands.PAUSE):
                self._machine.finish()
