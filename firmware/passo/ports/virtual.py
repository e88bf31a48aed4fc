"""The virtual port: virtual time, virtual pins, and a player that plays the ring in them.

    port = VirtualPort(board, world)          # world: whatever is wired to the pins, for example host_tools.sim.plant.Plant
    app = App(board, port)
    while True:
        app.poll()
        port.wait(app.controller.busy(), app.controller.state == "home")

Virtual time counts ticks of 80 ns from 0 and passes only in `wait`. How it passes is the port's `mode`:

    "real"     with the wall clock; it may lag behind, it never skips
    "fast"     as "real" while nothing is pending; while motion, a dwell or an event of the world is, it jumps
    "stepped"  a quantum a cycle, whatever the wall clock says, which `link_ms` follows: tests are deterministic

The world sees electrical pin levels, polarity included, and each change with its tick. It has these methods:

    attach(tick, names, levels)     the player's pins, lowest bit first, and their levels at power-up
    edges(tick, levels, changed)    the player's pins changed: all levels, and the mask of those that changed
    output(tick, name, level)       another output changed
    input(tick, name) -> level      what an input reads
    listen(callback)                call callback(tick, name, level) as an input changes; only where the world has this method
    encoder(number) -> count        what an encoder has counted, of those of the board file; only if that names any
    pulses(tick) -> (count, tick of the last)   of the spindle; only if the board file has a tachometer
    servo(tick, us)                 the pulses of a servo are so long from now on; only if the board file has one
    power(tick, level)              the tool's analogue power changed, 0 … 1000; only where the world has this method
    run(tick)                       let the world's own events up to `tick` happen
    next_event() -> tick or None    when the next of them is due

It runs under CPython and under unix MicroPython, and knows no file, no pty and no operating system.
"""

try:
    from time import monotonic_ns as wall_ns
except ImportError:  # MicroPython's clock is monotonic only as far as the system's is
    from time import time_ns as wall_ns

from passo.ports import parts
from passo.ports.virtual_player import Player
from passo.records import COUNT_MASK, TICKS_PER_MS
from passo.steps.position import Latch
from passo.steps.wiring import inversion_mask, mute_mask, word_times

TICK_NS = 80
COARSE_TICKS = 8 * TICKS_PER_MS  # a cycle in motion: well inside the 30 ms that the feeder keeps ahead
CATCH_UP_TICKS = 2 * COARSE_TICKS  # a cycle in motion of real time that is behind: fewer cycles let it come level
FINE_TICKS = 2 * TICKS_PER_MS  # a cycle while homing, about as long as a chip's; an edge within it is kept by the pin's interrupt
IDLE_MS = 5  # the longest sleep of an idle cycle
LAG_TICKS = 100 * TICKS_PER_MS  # real time further behind than this is given up, not caught up with


class VirtualPort:
    """Port of the virtual board; see the module's text. Methods as in chip_port.py.

    `world` defaults to nothing at all wired. `lines` maps a link's name to an object with `read()` and `write(bytes)`;
    a link that is not in it gets a `MemoryLine`. `sleep(ms)` is called in real and fast time when a cycle has nothing
    to do; it may return early, for example when a byte has come. `player`: the class that plays the ring.
    `radio`: the network, if the board file has one; None: it is off.
    """

    def __init__(self, board, world=None, mode="stepped", lines=None, sleep=None, player=Player, radio=None):
        if mode not in ("real", "fast", "stepped"):
            raise ValueError("time is real, fast or stepped, not " + repr(mode))
        self.world = world or Nothing()
        self.mode = mode
        self.now = 0
        self.lines = lines if lines is not None else {}
        self._sleep = sleep
        self.radio = radio
        self._player_class = player
        self._player = None
        inputs, outputs = board.get("inputs", ()), board.get("outputs", ())
        self._inputs = {entry["name"]: entry.get("active", 1) for entry in inputs}
        self._halting = [entry["name"] for entry in inputs if entry.get("halt", False)]
        self._outputs = {entry["name"]: entry.get("active", 1) for entry in outputs}
        self._trip = None  # the input that has stopped the player, until halting_input() has returned it
        self.veto = self._limits = None
        if "veto" not in getattr(board.get("additions"), "parts", ()) and hasattr(world, "listen") and self._inputs:
            from passo.ports.virtual_inputs import VirtualLimits

            self.world = self._limits = VirtualLimits(self, world, self._inputs)
        self._listen = getattr(world, "listen", None)
        self._watches = {}
        self.clocked = []  # those of the parts that have a time: run(tick) once it is `due`
        self._parts = []
        for name, module in parts.load(board, "port_virtual"):  # but "bank": inputs and outputs are known by their names here
            self._parts.append(module.create(board, self, self.world))
            setattr(self, name, self._parts[-1])
        if mode == "stepped":
            self.link_ms = self.machine_ms
        self._anchor()

    def player(self, ring, layout, board):
        """Return the player of `ring`. Once."""
        pulse_ticks, min_word_ticks = word_times(board)
        muted = mute_mask(board)
        if muted:
            self.world = MutedWorld(self.world, muted)
        self._player = self._player_class(self, ring, layout, pulse_ticks, min_word_ticks, inversion_mask(board, layout))
        return self._player

    def feed_from_interrupt(self, feeder, player):
        """There are no interrupts here: the main loop fills the ring itself."""
        for part in [self._limits] + self._parts:
            if hasattr(part, "join"):
                part.join(feeder, player)
        return False

    def serial(self, link):
        """Return the line of a link, in memory: one for each name."""
        name = link["name"]
        if name not in self.lines:
            self.lines[name] = MemoryLine()
        return self.lines[name]

    def writing(self, on=False):
        """Flash is about to be written, or has been: here that takes no time."""

    feed_watchdog = put_off = catch_up = writing  # do nothing: no interrupt calls the feeder here

    def input(self, name):
        """Return True while the world's input of this name is in its active state."""
        return self.world.input(self.now, name) == self._inputs[name]

    def levels(self):
        """Return the levels of all inputs as one integer, the first input's in the highest bit."""
        levels = 0
        for name in self._inputs:
            levels = levels << 1 | self.world.input(self.now, name)
        return levels

    def watch_limit(self, name, filter_us=0):
        """Return a Latch that keeps the moment when this input changes; None if the world tells no changes. `filter_us`: how long a hard limit's
        change has to last."""
        if name not in self._watches and self._listen:
            if self._limits is not None:
                self._watches[name] = self._limits.watch_limit(name, filter_us)
            else:
                made = self._watches[name] = Latch()
                self._listen(lambda tick, changed, level: changed == name and made.hold())
        return self._watches.get(name)

    def make(self, kind, config):
        """Return an option's part, which few boards have, as ports/chip_port.py does."""
        return parts.of_option(kind, "port_virtual").create(self, config)

    def halting_input(self):
        """Return the name of a halting input that is active, or of the input for which the veto has stopped the player; or None. Halting
        inputs are looked at once a cycle."""
        trip, self._trip = self._trip, None
        if trip is not None:
            return trip.name
        for name in self._halting:
            if self.input(name):
                return name
        return None

    def output(self, name, on):
        """Switch an output of the board file on or off; through the veto if there is one."""
        if self.veto is not None:
            self.veto.output(name, on)
            return
        active = self._outputs[name]
        self.world.output(self.now, name, active if on else 1 - active)

    def power(self, level):
        """Show the tool's analogue power, 0 … 1000, at once."""
        self._player.show_power(self.now, level)

    def trip(self, item):
        """Stop the player; halting_input() tells for what."""
        self._trip = item
        self._player.halt()

    def machine_ms(self):
        """Return the virtual time in ms, modulo 2²⁹."""
        return (self.now // TICKS_PER_MS) & COUNT_MASK

    def link_ms(self):
        """Return the wall clock in ms, modulo 2²⁹: hosts live by it."""
        return (wall_ns() // 1000000) & COUNT_MASK

    def wait(self, busy, fine=False, at_once=False):
        """End a cycle of the main loop. `busy`: motion, dwell or homing is pending; `fine`: a short cycle; `at_once`: no sleep, where an interrupt feeds."""
        quantum = FINE_TICKS if fine else COARSE_TICKS
        pending = busy or self.pending()
        if self.mode == "stepped":
            self.advance(quantum if pending else TICKS_PER_MS)
        elif pending and self.mode == "fast":
            self.advance(quantum)
            self._anchor()
        else:
            self._follow(pending, quantum)

    def pending(self, busy=False):
        """Return True while anything is on its way: `busy`, words, or an event of the world."""
        return busy or (self._player is not None and self._player.busy()) or self.world.next_event() is not None

    def advance(self, ticks):
        """Let `ticks` of virtual time pass: words play and the world's events happen, in the order of their ticks."""
        world = self.world
        end = self.now + ticks
        while self.now < end:
            event = world.next_event()
            until = end if event is None or event > end else max(event, self.now)
            for part in self.clocked:
                until = min(until, part.due)
            if self._player is not None:
                self._player.run(until)
            self.now = until
            world.run(until)
            for part in self.clocked:
                part.run(until)

    def _anchor(self):
        self._anchor_ns = wall_ns()
        self._anchor_tick = self.now

    def _follow(self, pending, quantum):
        """Follow the wall clock while something is pending, by cycles of `quantum`, or twice that in motion; sleep once level with it."""
        most = CATCH_UP_TICKS if quantum == COARSE_TICKS else quantum
        behind = self._anchor_tick + (wall_ns() - self._anchor_ns) // TICK_NS - self.now
        if pending and behind > LAG_TICKS:
            self._anchor()
            behind = quantum
        if behind > 0:
            # At rest by whole milliseconds: motion sees the same of them whenever it begins.
            self.advance(min(behind, most) if pending else behind - behind % TICKS_PER_MS)
        if self._sleep and (not pending or behind <= most):
            self._sleep(max(1, quantum // (2 * TICKS_PER_MS)) if pending else IDLE_MS)


class MemoryLine:
    """A serial line in memory: the board's end reads what was put in `incoming` and adds to `outgoing`."""

    def __init__(self):
        self.incoming = b""
        self.outgoing = b""
        self._lent = bytearray()

    def read(self):
        """Bytes that have come, good until the next read, as those of a chip's lines are; b"" if none."""
        lent = self._lent
        lent[:] = bytes(len(lent))
        data = self.incoming
        if not data:
            return b""
        self.incoming = b""
        self._lent = bytearray(data)
        return memoryview(self._lent)

    def write(self, data):
        self.outgoing += bytes(data)


class MutedWorld:
    """A world some of whose pins are cut off, and stay low."""

    def __init__(self, world, muted):
        """`muted`: mask of the player's pins."""
        self._world = world
        self._muted = muted

    def __getattr__(self, name):
        return getattr(self._world, name)

    def attach(self, tick, names, levels):
        self._world.attach(tick, names, levels & ~self._muted)

    def edges(self, tick, levels, changed):
        changed &= ~self._muted
        if changed:
            self._world.edges(tick, levels & ~self._muted, changed)


class Nothing:
    """The world of a board with nothing wired to it: inputs read low."""

    def run(self, *_):
        pass

    attach = edges = output = servo = next_event = run  # do nothing

    def input(self, tick, name):
        return 0
