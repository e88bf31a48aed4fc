"""The motors' current while nothing moves: standstill current after a while, then released; woken before a motion."""

from micropython import const

from passo.records import COUNT_HALF, COUNT_MASK

_WAKE_MS = const(20)  # for the rotor to settle on its phase before it is asked to step

RUNNING = const(0)
HOLDING = const(1)
RELEASED = const(2)


class Motors:
    def __init__(self, port, player, layout, drive, off_levels, board, enable_inverted):
        """`drive` and `off_levels` for coils; `drive` None for STEP/DIR drivers, which have an output "enable", or more whose names begin so."""
        self._port = port
        self._player = player
        self._tool_mask = layout.tool_mask
        self._drive = drive
        self._off_levels = off_levels
        self._enable = [output["name"] for output in board["outputs"] if output["name"][:6] == "enable"]
        self._wake_ms = _WAKE_MS if self._enable or drive is not None else 0  # motors without a switch need not settle
        self._hold_ms = board["drive"]["hold_ms"]
        self._enable_inverted = enable_inverted
        self._keep = False  # the current stays on until it is switched off: see drives()
        self._without = False  # see unpower()
        self.detached = False  # they are another controller's, and no motion takes them
        self._board = board  # its idle_release_ms may change
        self._since_ms = 0
        self.state = RELEASED
        self._tool = False  # as it was when the last motion ended: waking must not move it
        self._ready_ms = 0

    def poll(self, now_ms, moving, tool):
        """Once a cycle while the machine is awake. `moving`: motion is under way or wanted; `tool`: where its end leaves the tool.
        Returns True if the current is still to change."""
        if moving and not self._without or self._keep:
            self._since_ms = now_ms
            if self.state != RUNNING and not self._player.busy():
                self._ready_ms = now_ms + (self._wake_ms if self.state == RELEASED else 0)
                self._set_state(RUNNING)
            return self.state != RUNNING
        self._tool = tool
        idle_ms = (now_ms - self._since_ms) & COUNT_MASK
        if self.state == RUNNING and idle_ms >= self._hold_ms:
            self._set_state(HOLDING)
        release_ms = self._board["idle_release_ms"]
        if self.state == HOLDING and release_ms and idle_ms >= release_ms:
            self._set_state(RELEASED)
        return self.state == RUNNING or self.state == HOLDING and release_ms > 0

    def ready(self):
        """Return True when motion may begin. Drivers with STEP and DIR know no current to hold with."""
        if self._without:
            return True
        if self.state == HOLDING:
            return self._drive is None
        return self.state == RUNNING and (self._port.machine_ms() - self._ready_ms) & COUNT_MASK < COUNT_HALF

    def cut_current(self, mask):
        """Cut the current of the axes of `mask` while the others run; 0: of none. Drivers with STEP and DIR share one
        output: theirs stays on."""
        if self._drive is not None:
            self._drive.cut_current(mask)

    def unpower(self, axes):
        """Let motion go out while no motor has current, if `axes`, a mask, is not 0; 0: as usual again. Only at a stand."""
        self._without = axes != 0
        if self._drive is not None:
            self._drive.cut_current(axes)
        if axes and self.state != RELEASED:
            self._set_state(RELEASED)

    def drives(self, on):
        """Keep the motors' current on until drives(False), or switch it off now."""
        self._keep = on
        if not on:
            self.release()

    def release(self):
        """Switch off current and tool at once: the safe state."""
        self._tool = False
        self._set_state(RELEASED)

    def _set_state(self, state):
        """Set RUNNING, HOLDING or RELEASED: the outputs "enable", or the levels of coils."""
        self.state = state
        for name in self._enable:
            self._port.output(name, (state != RELEASED) != self._enable_inverted)
        if self._drive is None:
            return
        levels = self._off_levels if state == RELEASED else self._drive.levels_at_rest() if state == HOLDING else self._drive.levels()
        self._player.rest(levels | (self._tool_mask if self._tool else 0))
