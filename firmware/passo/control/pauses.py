"""Holding and going on: feed hold, safety door, the operator's pause, and coming to a stand to drop what is left.

`kind` is the machine's state while it is held: "hold" or "door"; "" otherwise.
"""

from passo import commands, errors
from passo.control.settings import LASER
from passo.steps.word import COUNT_MASK


class Pauses:
    def __init__(self, board, queue, machine, port):
        self._spindle = board["spindle"]
        self._queue = queue
        self._machine = machine
        self._port = port
        self.kind = ""
        self.dropping = False  # at the stand, what is left is dropped
        self._stood = False
        self._was_lit = False  # the tool was on when the machine came to its stand
        self._resuming = False
        self._ready_ms = None  # before that spindle and coolant, just switched on again, are not there yet

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
        self.dropping = self._stood = self._was_lit = self._resuming = False
        self._ready_ms = None

    def standing(self):
        """True in a hold that has come to its stand."""
        return bool(self.kind) and self._stood

    def substate(self):
        """grbl's number behind Hold: (0 at a stand, 1 on the way there) and Door: (0 ready, 1 open, 2 on the way to its
        stand, 3 resuming)."""
        if self._resuming:
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
        if self._resuming:
            self._stop(self.kind)
        elif machine.state in ("idle", "run"):
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
        self._stood = self._resuming = False
        self._queue.hold(True)

    def _laser(self):
        return self._machine.settings.value(LASER)

    def _light(self):
        """Switch the tool on again at a stand."""
        self._queue.rest(True)
        self._wait(max(self._queue.tool_ms(True), 0 if self._laser() else self._spindle["spin_up_ms"]))

    def _wait(self, ms):
        """Do not go on before so many milliseconds from now; the longest such time counts."""
        ready_ms = self._port.machine_ms() + ms & COUNT_MASK
        if ms and (self._ready_ms is None or (ready_ms - self._ready_ms) & COUNT_MASK < COUNT_MASK // 2):
            self._ready_ms = ready_ms

    def _resume(self, command):
        machine = self._machine
        ready = self._stood and not self._resuming and not machine.alarm
        if ready and not (self.kind == "door" and machine.inputs.door_open()):
            self._resuming = True
            if self.kind == "door":
                machine.tools.show_outputs(True)
                self._wait(self._spindle["coolant_ms"] if machine.tools.coolant else 0)
            if not self._laser():  # a beam would burn while the coolant comes
                self._restore()
        return machine.accepted(command)

    def _restore(self):
        if self._was_lit and not self._queue.lit():
            if self.kind == "hold" and not self._laser():
                self._machine.notice(errors.NOTICE_SPINDLE)
            self._light()

    def _cancel_jog(self, command):
        if self._machine.program.jogging and not self.dropping:
            self.drop()
        return self._machine.accepted(command)

    def _toggle(self, command):
        machine = self._machine
        if command.value == commands.SPINDLE_STOP:
            if self.kind == "hold" and self._stood and self._was_lit and not self._resuming and not self._laser():
                if self._queue.lit():
                    self._queue.rest(False)
                else:
                    self._restore()
        elif machine.state in ("idle", "run", "hold", "jog"):
            if self.kind and not machine.tools.coolant & command.value:
                self._wait(self._spindle["coolant_ms"])
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
            if lit and (self.kind == "door" or self._laser()):
                self._queue.rest(False)
            if self.kind == "door":
                self._machine.tools.show_outputs(False)
        elif self._ready_ms is not None:
            if (now_ms - self._ready_ms) & COUNT_MASK < COUNT_MASK // 2:
                self._ready_ms = None
        elif self._resuming:
            self._restore()
            if self._ready_ms is None:
                self._go_on()

    def _go_on(self):
        self.clear()
        self._queue.hold(False)
        if self._machine.busy_with(commands.PAUSE):
            self._machine.finish()
