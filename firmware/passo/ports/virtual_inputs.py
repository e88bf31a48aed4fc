"""Inputs with interrupts on the virtual port: between the port and its world, it sees changes at their tick.

VirtualInputs has the methods of a world, and hands on all calls. A change counts once it has lasted the input's filter, exactly;
the further time of a chip's interrupt is not modelled, but pulses stay whole: the player stops with
the first edge behind that time that leaves no pulse up.
"""

from passo.steps.position import Latch

TICKS_PER_US = 12.5


class VirtualInputs:
    def __init__(self, port, world):
        self._port = port
        self._world = world
        self._player = None
        self._pulses = 0  # mask of the player's pins
        self._amid = False  # the world gets an edge at this moment
        self._due = {}  # of an input: (tick at which its change has lasted, what it is then)
        self.input = world.input
        self._pass_edges = world.edges

    def __getattr__(self, name):
        return getattr(self._world, name)

    def join(self, feeder, player):
        """From here on `player` plays."""
        self._player = player
        self._pulses = feeder.layout.pulse_mask

    def edges(self, tick, levels, changed):
        """Hand on the player's edges at `tick`, then count the changes that waited for a pulse's end."""
        self._amid = True
        self._pass_edges(tick, levels, changed)
        self._amid = False
        if self._due:
            self._let(tick)

    def run(self, tick):
        """Run the world up to `tick`, and count the changes that have lasted by then."""
        self._world.run(tick)
        if self._due:
            self._let(tick)

    def next_event(self):
        """Return the tick of the world's next event or of the next change that counts; None: there is none."""
        due = self._world.next_event()
        if self._due:
            late = self._port.now + 1 if self._pulse() else 0  # it waits for the pulse's end
            for tick, _ in self._due.values():
                tick = max(tick, late)
                due = tick if due is None or tick < due else due
        return due

    def _pulse(self):
        """Return True while a pulse is up."""
        return self._player is not None and self._player.levels() & self._pulses

    def _let(self, tick):
        """Count the changes that have lasted by `tick`, unless a pulse is up."""
        if self._amid or not self._due or self._pulse():
            return
        for key, (due, active) in list(self._due.items()):
            if due <= tick and key in self._due:
                del self._due[key]
                self._accept_change(key, active)

    def _accept_change(self, key, active):
        """Act on a change of an input that has lasted its filter's time. For subclasses; here it does nothing."""


class VirtualLimits(VirtualInputs):
    """Hard limits, where no interlock looks at them: the methods of limit_watch.py."""

    def __init__(self, port, world, levels):
        """`levels`: {name of an input: its level when active}."""
        VirtualInputs.__init__(self, port, world)
        self._levels = levels
        self._watches = {}
        self.output = world.output
        self._pass_time()
        world.listen(self._handle_change)

    def watch_limit(self, name, filter_us):
        """Return the Latch of a limit input, to be armed. `filter_us`: how long a change has to last."""
        self._watches[name] = watch = _Watch(name, self._levels[name], int(filter_us * TICKS_PER_US))
        return watch

    def _pass_time(self):
        """As long as no change is on its way, time is the world's alone."""
        self.run, self.next_event = self._world.run, self._world.next_event

    def _run(self, tick):
        VirtualInputs.run(self, tick)
        if not self._due:
            self._pass_time()

    def _next_event(self):
        return VirtualInputs.next_event(self)

    def _handle_change(self, tick, name, level):
        """Latch a change of a watched input, and begin its filter's time if it is armed and now active."""
        watch = self._watches.get(name)
        if watch is None:
            return
        watch.hold()
        self._let(tick)
        if level != watch.level:
            self._due.pop(name, None)
        elif watch.armed:
            self._due[name] = tick + watch.filter_ticks, True
            self.run, self.next_event = self._run, self._next_event
            self._let(tick)

    def _accept_change(self, key, active):
        """Stop the player for an armed limit, and disarm it."""
        watch = self._watches[key]
        if watch.armed:
            watch.armed = False
            self._port.trip(watch)


class _Watch(Latch):
    def __init__(self, name, level, filter_ticks):
        Latch.__init__(self)
        self.name = name
        self.level = level
        self.filter_ticks = filter_ticks
        self.armed = False

    def turn(self, level):
        self.level = level

    def arm(self, on):
        self.armed = on
