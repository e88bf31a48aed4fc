"""The interlock on the virtual port: it stands between the port and its world."""

from passo.options.interlock.port import Interlock
from passo.options.interlock.steps_viper import INTERLOCK_OUTPUTS
from passo.ports.virtual_inputs import TICKS_PER_US, VirtualInputs


class VirtualInterlock(Interlock, VirtualInputs):
    """Hears of each change of an input at its tick. A world that has no listen(callback) is looked at once a cycle."""

    def __init__(self, board, port, world):
        Interlock.__init__(self, board, port)
        VirtualInputs.__init__(self, port, world)
        self._levels = [item["active"] for item in board["inputs"]]
        self._ticks = [int(us * TICKS_PER_US) for us in self.filters_us]
        self._tool = 0  # mask of the player's pin
        self._offs = [(item["name"], 1 - item["active"]) for item in board["outputs"]]
        self._hears = hasattr(world, "listen")
        if self._hears:
            world.listen(self.on_change)
        self.read(self.read_pins())

    def join(self, feeder, player):
        """See both bases; from here on the tool's level is known."""
        Interlock.join(self, feeder, player)
        VirtualInputs.join(self, feeder, player)
        self._tool = feeder.layout.tool_mask

    def run(self, tick):
        """Run the world up to a tick, and take changes that have lasted their filters' times."""
        self._world.run(tick)
        if not self._hears:
            raw = self._read_world(tick)
            for number in range(len(self._names)):
                if (raw ^ self.states) >> number & 1:
                    self._take_change(tick, number, raw >> number & 1)
        self._let(tick)

    # --- inputs

    def on_change(self, tick, name, level):
        """Take an input's new level, which the world reports at its tick."""
        number = self._names.index(name)
        self._take_change(tick, number, 1 if level == self._levels[number] else 0)

    def _take_change(self, tick, number, active):
        """Begin or end the filter's time of an input."""
        self._let(tick)
        if active == self.states >> number & 1:
            if self._due.pop(number, None) is not None:
                self.glitches[number] += 1
        elif (self.rise if active else self.fall) >> number & 1 and number not in self._due:
            self._due[number] = tick + self._ticks[number], active
            self._let(tick)

    def _accept_change(self, key, active):
        """Take over a change that has lasted its filter's time."""
        if self.states >> key & 1 != active:  # else the main loop has been first
            self.take_change(key, active)

    def read_pins(self):
        """See PinInterlock; of the world at this tick."""
        return self._read_world(self._port.now)

    def _read_world(self, tick):
        """Return the inputs of the world at a tick, a bit each: 1 active."""
        states = 0
        for number in range(len(self._names)):
            if self._world.input(tick, self._names[number]) == self._levels[number]:
                states |= 1 << number
        return states

    # --- outputs

    def is_tool_on(self):
        """See PinInterlock."""
        return bool(self._player.levels() & self._tool)

    def put_outputs(self, mask, on):
        """See PinInterlock; the world gets the levels at this tick."""
        tick = max(self._port.now, self._player.now) if self._player is not None else self._port.now
        bit = INTERLOCK_OUTPUTS
        for name, off in self._offs:
            if mask & bit:
                self._world.output(tick, name, off ^ on)
            bit <<= 1


def create(board, port, world):
    """Return the port's part, which stands between the port and its world."""
    made = VirtualInterlock(board, port, world)
    port.world = made
    return made
