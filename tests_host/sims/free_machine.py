"""A machine whose axes run on their own, on the virtual port: STEP/DIR or coils, each step recorded with its tick.

    machine = FreeMachine()
    machine.run((100, None), ((480, 1000), None))
    machine.settle()
    machine.steps[0]                    # [(tick, +1 or −1)] of axis 0, as its driver or its rotor made them

Runs under CPython and MicroPython.
"""

from passo.app import App
from passo.commands import RUN, STOP, Command
from passo.config.boardfile import check
from passo.machine_builder import make_drive
from passo.options.independent.commands import AT_REST, Run
from passo.ports.virtual import Nothing, VirtualPort


def board(kind="step_dir", **changes):
    data = {
        "name": "free",
        "chip": "rp2040",
        "drive": {"kind": kind, "pulse_us": 2, "setup_us": 5},
        "axes": [
            {"name": "x", "pins": [2, 4] if kind == "step_dir" else [2, 3, 4, 5], "steps_per_m": 48_000,
             "travel_steps": 48_000, "max_mm_min": 60_000},
            {"name": "y", "pins": [3, 5] if kind == "step_dir" else [6, 7, 8, 9], "steps_per_m": 83_000,
             "travel_steps": 83_000, "max_mm_min": 60_000, "jog_steps": 100},
        ],
        "tool": {"pin": 6 if kind == "step_dir" else 10},
        "speed": {"unit": "steps_per_s", "default": 480, "min": 1, "max": 20_000},
        "idle_release_ms": 0,
        "links": [
            {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "protocol": "plotter"},
            {"name": "keys", "port": "usb", "protocol": "keys"},  # needs axes that run on their own
        ],
    }
    data.update(changes)
    return data


class Axes(Nothing):
    """The world: the steps of drivers or rotors, computed from the pins alone."""

    def __init__(self, data):
        self.layout, self.drive, _ = make_drive(check(data))
        self.steps = [[] for _ in range(self.layout.axes)]
        self.turned = [0] * self.layout.axes  # tick of the last change of a DIR pin
        self.shortest_setup = None
        self.outputs = []
        self._before = self.drive.levels() if self.drive else 0

    def edges(self, tick, levels, changed):
        axes = self.layout.axes
        for axis in range(axes):
            if self.drive is not None:
                step = self.drive.step_between(axis, self._before, levels)
            else:
                if changed >> (axes + axis) & 1:
                    self.turned[axis] = tick
                if not changed >> axis & 1 or not levels >> axis & 1:
                    continue
                setup = tick - self.turned[axis]
                if self.turned[axis] and (self.shortest_setup is None or setup < self.shortest_setup):
                    self.shortest_setup = setup
                step = 1 if levels >> (axes + axis) & 1 else -1
            if step:
                self.steps[axis].append((tick, step))
        self._before = levels

    def output(self, tick, name, level):
        self.outputs.append((tick, name, level))


class Jogs:
    """Settings with the jogs that no host has configured."""

    version = 0

    def __init__(self, steps, steps_s):
        self._steps, self._steps_s = steps, steps_s

    def jog_steps(self, axis):
        return self._steps[axis]

    def jog_steps_s(self, axis):
        return self._steps_s[axis]


class FreeMachine:
    def __init__(self, kind="step_dir", **changes):
        data = check(board(kind, **changes))
        self.world = Axes(data)
        self.port = VirtualPort(data, self.world, "stepped")
        self.app = App(data, self.port)
        self.controller = self.app.controller
        self.part = self.controller.features["independent"]
        self.steps = self.world.steps
        self.least = self.app.feeder.min_word_ticks
        self.events = []

    def send(self, data):
        self.port.lines["pc"].incoming += data

    def take(self):
        """Return the board's bytes since the last take."""
        line = self.port.lines["pc"]
        said, line.outgoing = line.outgoing, b""
        return said

    def accept(self, command):
        command.link = self.app.links[0]
        return self.controller.accept(command)

    def run(self, steps, rates, when=AT_REST):
        return self.accept(Run(steps, rates, when))

    def stop(self):
        return self.accept(Command(STOP))

    def cycle(self):
        self.app.poll()
        self.port.wait(self.controller.busy())

    def poll(self, ticks=0):
        """Let an exact number of ticks pass, turning at least every 8 ms."""
        while ticks > 0:
            self.app.poll()
            part = min(ticks, 100_000)
            self.port.advance(part)
            ticks -= part

    def settle(self):
        for _ in range(100_000):
            self.cycle()
            if self.controller.queue.still() and not self.part.owns_axes():
                return
        raise AssertionError("it goes on and on")

    def made(self):
        """Return the steps of the drivers, signed."""
        return [sum([step for _, step in steps]) for steps in self.steps]
