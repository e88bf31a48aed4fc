"""Outputs that hand the motors from another controller to this one and back: relays, and lamps that show whose turn it is.

The roles of the board file's outputs: "ours" is on while the motors are this board's, "theirs" while they are not. Break
before make: all of them are released, and only `changeover_ms` later the ones wanted are switched on; nothing is stepped
before that time has passed once more, for the relays to have closed. As long as the motors are the other controller's,
motion is refused; with "changeover_by": "motion" in the board file the first steps take them. At the start, in an alarm and
when the app ends the outputs of role "ours" are off, which is how a machine without power stands: with the other controller.
"""

from passo import commands, errors
from passo.control.feature import SAFE, Feature
from passo.records import COUNT_MASK


class Changeover(Feature):
    event_mask = SAFE

    def __init__(self, board, machine, queue):
        self._port = machine.port
        Feature.__init__(self, board, machine, queue)
        self._pause_ms = board["changeover_ms"]
        self._ours = [item["name"] for item in board["outputs"] if item["role"] == "ours"]
        self._theirs = [item["name"] for item in board["outputs"] if item["role"] == "theirs"]
        self._relays = bool(self._ours or self._theirs)
        self._by_motion = board["changeover_by"] == "motion"
        self.ours = False
        self._made = True  # the outputs wanted are on
        self._due_ms = None  # when the next phase begins
        self._begin_switch(False)

    def handlers(self):
        return {commands.CONNECT: self._connect_motors}

    def report(self, report):
        report["ours"] = self.ours

    def ready(self):
        """Return True when steps may go out. Asked when there are some; by "motion" this takes the motors."""
        if self._by_motion and self._relays and not self.ours and not self._machine.alarm and not self._machine.sleeping:
            self._begin_switch(True)
        return self._due_ms is None

    def on_events(self, _=SAFE):
        """Give the motors to the other controller at once, the safe state; its own relays close after changeover_ms."""
        if self.ours:
            self._begin_switch(False)

    def poll(self, now_ms):
        """Close the relays when their wait is over; give the motors back in an alarm, once the machine stands."""
        machine = self._machine
        if (machine.alarm not in errors.WATCHED or machine.sleeping) and self._queue.still():
            self.on_events()
        if self._due_ms is None:
            return
        machine.awake = True
        if (now_ms - self._due_ms) & COUNT_MASK > COUNT_MASK // 2:
            return
        if self._made:
            self._due_ms = None
            return
        self._made = True
        self._set_outputs(self._ours if self.ours else self._theirs, True)
        self._start_wait()

    def _connect_motors(self, command):
        """Take the motors (`command.value` 1) or give them back (0). Returns 0, LOCKED in an alarm or asleep, or BUSY while anything moves."""
        machine = self._machine
        ours = bool(command.value)
        if ours and (machine.alarm not in errors.WATCHED or machine.sleeping):
            return errors.LOCKED
        if machine.state not in ("idle", "alarm") or not self._queue.still():
            return errors.BUSY
        if ours != self.ours:
            self._begin_switch(ours)
        return machine.confirm_command(command)

    def _begin_switch(self, ours):
        """Release all relays; poll() closes those wanted, changeover_ms later. Not `ours`: the position is lost."""
        self.ours = ours
        self._machine.motors.detached = self._relays and not ours and not self._by_motion
        if self._relays and not ours:
            self._machine.lose_position()
        self._made = False
        self._set_outputs(self._ours + self._theirs, False)
        self._start_wait()

    def _set_outputs(self, names, on):
        """Switch the outputs of these names."""
        for name in names:
            self._port.output(name, on)

    def _start_wait(self):
        """Begin the wait of changeover_ms for the relays, if the board has any."""
        if self._relays:
            self._due_ms = (self._port.machine_ms() + self._pause_ms) & COUNT_MASK
