"""Random trouble on the mill's inputs while it moves, and a witness that knows only wires, steps and the document's equations.

    session = Session(seed=1)
    for _ in range(1000):
        session.sequence()          # raises AssertionError if the machine does what it must not

Each sequence: a motion or two, spindle on or off; while they go on some inputs bounce, chatter, stick, come late or two at
once, or the selector's wire breaks; then all is mended, and the operator goes on. The rules:

- after a direction has been forbidden for the filter's time no step is made in it, but for one that is on its way;
- the spindle goes off with the emergency stop, and never on while that is pressed; no drive steps without its enable;
- without a change that lasts there is no alarm, and the motion ends exactly where it should;
- an alarm names an input that forbids something, and has done so for its filter's time;
- when the inputs are mended, reset and unlock lead out, and the axes move wherever the equations let them.
"""

import math
import random

from mill_equations import allowed

from host_tools import boards
from host_tools.sim.machine import VirtualMachine

TICKS_PER_US = 12.5
CALLED = {"stop": "urg", "probe": "pal"}  # in the document
GOOD = ("dx1", "dx2", "dy", "dz", "sel")  # forbid while they are not active
OFF_TICKS = 25 * 12.5  # from the emergency stop to the spindle's pin: a pulse is not cut short
KINDS = ("bounce", "burst", "burst", "stuck", "late", "two", "selector", "none")
STEPS_MM = 80
MENDED_MS = 26  # after which what forbade allows again: release_ms, the longest filter, and some cycles


def small_mill(whole=False):
    """The mill with short axes: their ends are often reached. `whole`: with all that has no say in the interlock, too."""
    board = boards.load("mill_2004")
    if not whole:
        for key in ("gantry", "encoders", "inverter"):
            del board[key]
        board["player"] = "timer"  # whose pins need not be neighbours
    board["axes"] = [{**axis, "travel_steps": steps} for axis, steps in zip(board["axes"], (900, 700, 500))]
    return board


class Witness:
    """Sees each change of an input and each step."""

    def __init__(self, machine):
        self.machine = machine
        plant = machine.plant
        plant.trace = self
        plant.listen(self.changed)
        self.filters = {item["name"]: item["filter_us"] * TICKS_PER_US for item in machine.board["inputs"]}
        self.rests = {name: name in GOOD for name in self.filters}
        self.actives = {item["name"]: item["active"] for item in machine.board["inputs"]}
        self.active = {name: plant.input(0, name) == self.actives[name] for name in self.filters}
        self.since = dict.fromkeys(self.filters, 0)
        self._states, self._until = None, 0  # the last value of states(), and the tick at which it changes
        self.position = list(plant.position)
        self.lasted = set()  # inputs that have forbidden for their filter's time, in this sequence
        self.over = {}  # (axis, forward): steps made though forbidden
        self.tool = 0
        self.steps = 0
        self.blind = False  # a limit that is hit reads as if it were not: then nothing keeps the carriage from its end
        self.faults = []

    def begin(self):
        self.blind = False
        self.lasted.clear()
        self.over.clear()

    def changed(self, tick, name, level):
        self.note(tick)
        active = level == self.actives[name]
        if active != self.active[name]:
            self.blind = self.blind or name in self.machine.plant.noise and self.machine.plant.noise[name].flipped and not active
            self.active[name] = active
            self.since[name] = tick
            self._states = None
            self.over.clear()
        if self.tool and name == "stop" and active:
            self.pressed = tick

    def note(self, tick):
        for name in self.filters:
            if self.forbids(name, tick):
                self.lasted.add(name)

    def forbids(self, name, tick):
        return self.active[name] != self.rests[name] and tick - self.since[name] >= self.filters[name]

    def states(self, tick):
        """Return the inputs as they count: one that has not lasted its filter's time does not forbid."""
        if self._states is None or tick >= self._until:
            self._states = {
                CALLED.get(name, name): int(self.active[name] if self.forbids(name, tick) else self.rests[name])
                for name in self.filters
            }
            ends = [self.since[name] + self.filters[name] for name in self.filters if self.active[name] != self.rests[name]]
            self._until = min([end for end in ends if end > tick], default=math.inf)
        return self._states

    def add_row(self, tick, position, tool):
        homing = self.machine.app.controller.state == "home"
        for axis, (now, before) in enumerate(zip(position, self.position)):
            if now != before:
                self.steps += 1
                states = self.states(tick)
                if homing:
                    states = {**states, "bxa": 0, "bya": 0, "bza": 0}
                forward = now > before
                if states["urg"] or not allowed("xyz"[axis], forward, states):
                    key = axis, forward
                    self.over[key] = self.over.get(key, 0) + 1
                    if self.over[key] > 1:
                        self.faults.append(f"{tick}: {'xyz'[axis]} steps {'forward' if forward else 'back'}, {states}")
        self.position = list(position)
        if tool and self.active["stop"] and tick - self.since["stop"] > OFF_TICKS:
            self.faults.append(f"{tick}: the spindle runs with the emergency stop pressed")
        self.tool = tool

    def check(self):
        tick = self.machine.port.now
        self.note(tick)
        if self.tool and self.active["stop"] and tick - self.since["stop"] > OFF_TICKS:
            self.faults.append(f"{tick}: the spindle runs with the emergency stop pressed")
        plant = self.machine.plant
        if plant.enabled and self.active["stop"] and tick - self.since["stop"] > OFF_TICKS:
            self.faults.append(f"{tick}: the drives are enabled with the emergency stop pressed")
        errors = [text for _, text in plant.errors if not (self.blind and "hard end" in text)]
        plant.errors.clear()
        assert not errors and not self.faults, errors + self.faults


class Session:
    def __init__(self, seed, whole=False):
        self.random = random.Random(seed)
        self.machine = VirtualMachine(small_mill(whole), start=(450, 350, -250), trace=None, seed=seed)
        self.witness = Witness(self.machine)
        self.names = [item["name"] for item in self.machine.board["inputs"]]
        self.state = self.machine.app.controller.machine
        self.trips = self.quiet = 0
        self.kinds = {}
        self.machine.run_ms(30)
        self.say("$X")

    def say(self, *lines):
        """Send lines; return the board's answers."""
        machine = self.machine
        machine.take()
        for line in lines:
            machine.send(line.encode() if len(line) == 1 else line.encode() + b"\n")
        machine.cycle()
        machine.cycle()
        return machine.take().decode()

    # --- one sequence

    def sequence(self):
        self.witness.begin()
        logged = len(self.state.log.entries), dict(self.state.log.counts)
        position = list(self.machine.plant.position)
        target = self.set_out(position)
        kind = self.random.choice(KINDS)
        self.kinds[kind] = self.kinds.get(kind, 0) + 1
        flipped = self.trouble(kind)
        self.machine.run_ms(self.random.choice((2, 10, 40)))
        if self.random.random() < 0.3:  # somebody tries in vain
            self.say(self.random.choice(("\x18", "!")), "$X", "G91G1X1F2400", "M3S900")
            target = None
        self.let_end()
        self.witness.check()
        self.judge(logged, target)
        self.mend(flipped)
        self.way_out()
        self.witness.check()

    def set_out(self, position):
        """Some lines; returns where they lead, None if the machine does not take them."""
        lines = []
        target = list(position)
        if self.random.random() < 0.5:
            lines.append(self.random.choice(("M3 S9000", "M5")))
        for _ in range(self.random.randint(1, 3)):
            by = [self.random.choice((0, 0, 1, -1)) * self.random.randint(1, 400) for _ in range(3)]
            if not any(by):
                by[self.random.randrange(3)] = 60
            target = [at + steps for at, steps in zip(target, by)]
            words = "".join(f"{axis}{steps / STEPS_MM:.4f}" for axis, steps in zip("XYZ", by) if steps)
            lines.append(f"G91G1{words}F{self.random.randint(600, 3000)}")
        said = self.say(*lines)
        return target if said.count("ok") == len(lines) else None

    def trouble(self, kind):
        """Noise on inputs, from some time on; returns those that are left turned round."""
        now = self.machine.port.now + int(self.random.randint(0, 60_000) * TICKS_PER_US)
        names = self.random.sample(self.names, 2)
        flipped = []

        def flip(name, times_us):
            self.machine.plant.inject_noise(name, sorted({now + max(1, round(us * TICKS_PER_US)) for us in times_us}))

        def many(count, within_us):
            times = set()
            while len(times) < count:
                times.add(self.random.randint(1, int(within_us * TICKS_PER_US)) / TICKS_PER_US)
            return times

        if kind == "bounce":
            flip(names[0], many(2 * self.random.randint(1, 20) + 1, 4000))
            flipped = names[:1]
        elif kind == "burst":
            name = self.random.choice([name for name in self.names if name != "stop"])  # that one has no filter
            flip(name, many(2 * self.random.randint(1, 8), 50))
        elif kind in ("stuck", "late"):
            flip(names[0], [self.random.randint(1, 100_000) if kind == "late" else 1])
            flipped = names[:1]
        elif kind == "two":
            flip(names[0], [5])
            flip(names[1], [5 + self.random.choice((0, 0, 3, 90))])
            flipped = names
        elif kind == "selector":
            flip("sel", [1])
            flipped = ["sel"]
        return flipped

    def let_end(self):
        """Until nothing happens any more."""
        self.machine.run_ms(3)
        self.machine.settle(20_000)
        self.machine.run_ms(3)

    def judge(self, logged, target):
        entries = [entry for entry in self.state.log.entries if entry[1] in (201, 220)]
        before = sum(logged[1].get(number, 0) for number in (201, 220))
        alarms = sum(self.state.log.counts.get(number, 0) for number in (201, 220)) - before
        if alarms:
            self.trips += 1
            for _, number, who in entries[-alarms:]:
                assert who in self.witness.lasted, (number, who, self.witness.lasted)
        elif target is not None and not self.witness.lasted and not self.witness.blind and not self.state.alarm:
            self.quiet += 1
            assert self.machine.plant.position == target, "without trouble it arrives"
        if not self.witness.lasted:
            assert not alarms, ("a false alarm", entries[-alarms:])

    def mend(self, flipped):
        now = self.machine.port.now
        for name in flipped:
            if self.machine.plant.noise[name].flipped:
                self.machine.plant.inject_noise(name, [now + 10])
        self.machine.run_ms(MENDED_MS)
        for name in self.names:
            assert not self.machine.plant.noise.get(name) or not self.machine.plant.noise[name].flipped

    def way_out(self):
        """Reset and unlock; then an axis moves wherever the equations allow."""
        said = self.say("\x18") + self.say("$X")
        for _ in range(3):
            if self.state.alarm:
                said += self.say("\x18") + self.say("$X")
        assert self.state.state == "idle", (self.state.state, self.state.alarm, said, self.state.log.entries[-3:])
        axis = self.random.randrange(3)
        states = self.witness.states(self.machine.port.now)
        at = self.machine.plant.position[axis]
        carriage = self.machine.plant.carriages[axis]
        forward = at < (carriage.low + carriage.high) // 2
        may = allowed("xyz"[axis], forward, states)
        assert may, "away from the end is always free"
        said = self.say(f"G91G1{'XYZ'[axis]}{(1 if forward else -1) * 40 / STEPS_MM}F1200")
        assert "ok" in said, (said, axis, forward, states)
        self.machine.settle(20_000)
        assert self.machine.plant.position[axis] == at + (40 if forward else -40)
