"""A router with three STEP/DIR drivers for the virtual port, and the whole firmware on it, stepped, lines in memory.

    machine = Machine()
    machine.ask("$X")                   # ["[MSG:Caution: Unlocked]", "ok"]
    machine.ask("G0 X10")
    machine.settle()
    machine.world.place

Small enough for MicroPython; host_tools.sim.plant is the full model.
"""

from boards.router_3axis import BOARD
from passo.app import App
from passo.config.boardfile import check
from passo.config.journal import MemorySlots
from passo.ports.virtual import VirtualPort

HOME = (0, 0, 0)  # places where the limit switches of X, Y (low ends) and Z (high end) trip
# Without what needs flash, and a host that goes on asking.
PLAIN = dict(BOARD, journal=None, links=[{key: link[key] for key in link if key != "lost"} for link in BOARD["links"]])
PULL_OFF = BOARD["homing"]["pull_off_steps"]
LASER = {"max_rpm": 1000, "min_rpm": 0, "pwm": True, "pin": 18, "laser": True}
UNHOMED = "[MSG:'$H'|'$X' to unlock]"
BANNER = "Grbl 1.1h ['$' for help]"


class World:
    def __init__(self, start=(3000, 2500, -1800)):
        self.place = list(start)
        self.floor = None  # Z place below which the probe touches
        self.path = None  # set it to []: (tick, x, y, z, tool) at each step
        self.switches = {}  # level of an input by name, above what the world says
        self.outputs = {}
        self.steps = 0
        self.tool = 0
        self.tool_changes = []  # (tick, on)
        self.power_level = 0
        self.burnt = None  # set it to []: (tick, x, y, power while the tool is on) at each step
        self.top = [0, 0, 0]

    def attach(self, tick, names, levels):
        self.names = names
        self.rest = levels
        self._step = [1 << names.index(axis + "_step") for axis in "xyz"]
        self._dir = [1 << names.index(axis + "_dir") for axis in "xyz"]
        self._tool = 1 << names.index("tool")

    def edges(self, tick, levels, changed):
        if changed & self._tool:
            self.tool = 1 if levels & self._tool else 0
            self.tool_changes.append((tick, self.tool))
        moved = False
        for axis in range(3):
            if changed & levels & self._step[axis]:
                self.place[axis] += 1 if levels & self._dir[axis] else -1
                moved = True
        if moved:
            self.steps += 1
            if self.path is not None:
                self.path.append((tick, self.place[0], self.place[1], self.place[2], self.tool))

            if self.burnt is not None:
                self.burnt.append((tick, self.place[0], self.place[1], self.power_level if self.tool else 0))

    def power(self, tick, level):
        self.power_level = level

    def output(self, tick, name, level):
        self.outputs[name] = level

    def input(self, tick, name):
        if name in self.switches:
            return self.switches[name]
        if name == "probe":
            return 0 if self.floor is not None and self.place[2] <= self.floor else 1
        if name in ("door", "stop", "repl"):
            return 0 if name == "stop" else 1
        axis = "xyz".find(name[-1])
        at = self.place[axis] - HOME[axis]
        return 1 if (at >= 0 if axis == 2 else at <= 0) else 0

    def run(self, tick):
        pass

    def next_event(self):
        return None


def answers(said):
    """The lines that answer a line."""
    return [line for line in said if line == "ok" or line.startswith("error:")]


class Machine:
    def __init__(self, world=None, slots=None, radio=None, pages=None, **changes):
        board = check(PLAIN)
        board.update(changes)
        board = check(board)  # the port wants what its options add
        self.world = world or World()
        self.port = VirtualPort(board, self.world, radio=radio)
        if pages:
            self.port.pages = pages
        self.slots = slots or MemorySlots()
        self.app = App(check(board), self.port, None, self.slots)
        self.controller = self.app.controller
        self.line = self.port.lines["pc"]

    def put(self, data):
        """Bytes on the wire to the board."""
        self.line.incoming += data if isinstance(data, bytes) else data.encode()

    def said(self):
        """All lines the board has said since the last time."""
        data = self.line.outgoing
        self.line.outgoing = b""
        return [line for line in data.decode().split("\r\n") if line]

    def cycles(self, count=1):
        for _ in range(count):
            self.app.cycle()
        return self.said()

    def ask(self, line, turns=100_000):
        """Send a line; return all lines up to its answer."""
        self.put(line + "\n")
        said = []
        while turns:
            self.app.cycle()
            turns -= 1
            said += self.said()
            if answers(said):
                return said
        raise AssertionError("no answer to %r: %r" % (line, said))

    def do(self, *lines):
        """Send lines one after the other; each must be ok."""
        for line in lines:
            said = self.ask(line)
            assert answers(said) == ["ok"], (line, said)
        return said

    def settle(self, turns=200_000):
        """Until nothing moves."""
        self.app.cycle()
        while not self.controller.queue.still() or self.controller.machine.command is not None:
            self.app.cycle()
            turns -= 1
            assert turns, "still busy: " + self.controller.state
        self.app.cycle()

    def status(self):
        """The status report as a dict; "state" is its first field."""
        before = self.said()
        self.put("?")
        self.app.cycle()
        text = [line for line in self.said() if line.startswith("<")][0]
        self.line.outgoing = "".join([line + "\r\n" for line in before]).encode() + self.line.outgoing
        fields = {"state": text[1:-1].split("|")[0], "text": text}
        for field in text[1:-1].split("|")[1:]:
            name, _, value = field.partition(":")
            fields[name] = value
        return fields

    def ready(self):
        """Unlock, read the greeting; the first motion comes without the caution on soft limits."""
        self.said()
        self.do("$X")
        self.controller.machine.cautious = False
        return self


def home(machine):
    machine.said()
    assert machine.ask("$H") == ["ok"]
    return machine
