"""The interlock on the virtual port: between the port and its world, it hears of each change of an input at its tick.

It has the methods of a world, and hands on all calls. A change counts once it has lasted the input's filter_us, exactly; what
a chip's interrupt takes on top of that is not modelled, but that no pulse is cut short: the player is halted with the first
edge behind that time that leaves no pulse up. A world that has no listen(callback) is looked at once a cycle.
"""

from passo.ports.interlock import Interlock
from passo.steps.permits import INTERLOCK_OUTPUTS

_TICKS_PER_US = 12.5


class VirtualInterlock(Interlock):
    def __init__(self, board, port, world):
        Interlock.__init__(self, board, port)
        self._world = world
        self._levels = [item["active"] for item in board["inputs"]]
        self._ticks = [int(us * _TICKS_PER_US) for us in self.filters_us]
        self._amid = False  # the world is being told of an edge
        self._pulses = self._tool = 0  # masks of the player's pins
        self._due = {}  # number: (tick at which its change has lasted, active)
        self._offs = [(item["name"], 1 - item["active"]) for item in board["outputs"]]
        self.attach = world.attach
        self._switch = world.output
        if hasattr(world, "power"):
            self.power = world.power
        if hasattr(world, "pulses"):
            self.pulses = world.pulses
        self._pass_edges = world.edges
        self._hears = hasattr(world, "listen")
        if self._hears:
            world.listen(self.changed)
        self.read(self.now())

    def join(self, feeder, player):
        Interlock.join(self, feeder, player)
        self._pulses = feeder.layout.pulse_mask
        self._tool = feeder.layout.tool_mask

    # --- as a world

    def edges(self, tick, levels, changed):
        self._amid = True
        self._pass_edges(tick, levels, changed)
        self._amid = False
        if self._due:
            self._let(tick)

    def input(self, tick, name):
        return self._world.input(tick, name)

    def run(self, tick):
        self._world.run(tick)
        if not self._hears:
            raw = self._look(tick)
            for number in range(len(self._names)):
                if (raw ^ self.states) >> number & 1:
                    self._changed(tick, number, raw >> number & 1)
        self._let(tick)

    def next_event(self):
        due = self._world.next_event()
        late = self._port.now + 1 if self._pulse() else 0  # it waits for the pulse's end
        for tick, _ in self._due.values():
            tick = max(tick, late)
            due = tick if due is None or tick < due else due
        return due

    def _pulse(self):
        """True while a pulse is up."""
        return self._player is not None and self._player.levels() & self._pulses

    # --- inputs

    def changed(self, tick, name, level):
        """The world says that an input has changed."""
        number = self._names.index(name)
        self._changed(tick, number, 1 if level == self._levels[number] else 0)

    def _changed(self, tick, number, active):
        self._let(tick)
        if active == self.states >> number & 1:
            if self._due.pop(number, None) is not None:
                self.glitches[number] += 1
        elif (self.rise if active else self.fall) >> number & 1 and number not in self._due:
            self._due[number] = tick + self._ticks[number], active
            self._let(tick)

    def _let(self, tick):
        """Changes that have lasted by `tick` count."""
        if self._amid or self._pulse():
            return
        for number, (due, active) in list(self._due.items()):
            if due <= tick and number in self._due:
                del self._due[number]
                if self.states >> number & 1 != active:  # else the main loop has been first
                    self.change(number, active)

    def now(self):
        """The inputs as they are, a bit each: 1 active."""
        return self._look(self._port.now)

    def _look(self, tick):
        states = 0
        for number in range(len(self._names)):
            if self._world.input(tick, self._names[number]) == self._levels[number]:
                states |= 1 << number
        return states

    # --- outputs

    def lit(self):
        """True while the tool's pin is on."""
        return bool(self._player.levels() & self._tool)

    def put(self, mask, on):
        """Switch the outputs of `mask`, INTERLOCK_…: 1 on, 0 off."""
        tick = max(self._port.now, self._player.now) if self._player is not None else self._port.now
        bit = INTERLOCK_OUTPUTS
        for name, off in self._offs:
            if mask & bit:
                self._switch(tick, name, off ^ on)
            bit <<= 1
