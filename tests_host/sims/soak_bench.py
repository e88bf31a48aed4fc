"""The base of every machine of the soak: a seed, faults counted by kind, the last events, time that jumps, and a measure of its memory.

A machine is a class with `round()`, which raises Wrong (or any error) where it has done what it must not do, and close().
"""

import contextlib
import gc
import io
import random
import sys
from array import array
from collections import Counter, deque
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from unittest import mock

from noisy_wire import BAUD, Cable
from soak_witness import Witness, Wrong
from virtual_wire import patched

TICKS_PER_MS = 12_500
EVENTS = 40
LONGEST_MS = 1_800_000  # of a command of passo
SAFE_MS = 120  # from whatever stops the machine to tool off, coils and relays included
HEAP_GROWTH = 12_000  # bytes between two measures, hundreds of lines apart: a log that fills and buffers first used take 6500
_SHARED = (type, ModuleType, FunctionType, BuiltinFunctionType, CodeType)


def reachable(root, without=()):
    """Bytes of the objects that `root` leads to, code and `without` left out."""
    seen = {id(each) for each in without}
    todo, total = [root], 0
    while todo:
        each = todo.pop()
        if id(each) in seen or isinstance(each, _SHARED):
            continue
        seen.add(id(each))
        if isinstance(each, (bytes, bytearray, str, array, list, dict, tuple, set, int)):
            total += sys.getsizeof(each)
        todo += gc.get_referents(each)
    return total


class Bench:
    NAME = ""

    def __init__(self, seed):
        self.seed = seed
        self.dice = random.Random(f"{self.NAME} {seed}")
        self.faults = Counter()
        self.actions = 0  # lines and real-time bytes sent but `?`, and faults but those of bytes on a wire
        self.events = deque(maxlen=EVENTS)
        self.machine = None
        self.witness = None
        self.rounds = 0
        self._steps = 0
        self._past_ms = 0.0  # of boards that have been switched off
        self._ahead = []  # [(ms, number, what to do)]
        self._number = 0
        self._heap = None

    # --- for the record

    def note(self, text):
        self.events.append(f"{self.now_ms():12.1f} ms  {text}")

    def fault(self, kind, text="", count=1):
        self.faults[kind] += count
        self.actions += count
        self.note(f"FAULT {kind} {text}")

    @property
    def steps(self):
        return self._steps + (self.witness.steps if self.witness else 0)

    def now_ms(self):
        """Virtual ms since the first board was switched on."""
        return self._past_ms + (self.machine.now_ms() if self.machine else 0)

    # --- the machine

    def switch_on(self, machine, least_ticks):
        """Another board, the old one is without power."""
        if self.machine:
            self._past_ms += self.machine.now_ms()
            self._steps += self.witness.steps
        self.machine = machine
        self.witness = Witness(machine.plant, least_ticks)
        self._heap = None

    def after(self, ms, what):
        """Call what() after `ms` milliseconds."""
        self._number += 1
        self._ahead.append((self.now_ms() + ms, self._number, what))
        self._ahead.sort(key=lambda entry: entry[:2], reverse=True)

    def forget(self):
        self._ahead.clear()

    def cycle(self):
        """Run one cycle of the board, and the calls that are due then."""
        self.machine.cycle()
        while self._ahead and self._ahead[-1][0] <= self.now_ms():
            self._ahead.pop()[2]()

    def run_ms(self, ms):
        end = self.now_ms() + ms
        while self.now_ms() < end:
            self.cycle()

    def run_until(self, condition, limit_ms, what):
        end = self.now_ms() + limit_ms
        while not condition():
            if self.now_ms() > end:
                raise Wrong(f"{what}: not within {limit_ms} ms")
            self.cycle()

    def moving(self):
        return self.machine.port.pending(self.machine.app.controller.busy())

    def settle(self, limit_ms=600_000):
        self.cycle()
        self.run_until(lambda: not self.moving(), limit_ms, "to a stand")

    def jump(self):
        """Up to three hours in which nobody wants anything: minutes at once, a cycle between."""
        before = list(self.machine.plant.position)
        for _ in range(self.dice.choice((0, 0, 1, 5, 60))):
            self.machine.port.advance(self.dice.randint(1, 180_000) * TICKS_PER_MS)
            self.machine.cycle()
        if self.machine.plant.position != before:
            raise Wrong(f"it moved while nobody wanted anything: {before} → {self.machine.plant.position}")

    # --- what holds always

    def check_plant(self, allowed=()):
        """Raise Wrong if the plant has an error that a real machine could not have followed, except errors with one of the texts `allowed`."""
        plant = self.machine.plant
        wrong = [text for _, text in plant.errors if not any(each in text for each in allowed)]
        plant.errors.clear()
        if wrong:
            raise Wrong(f"the plant: {wrong[:3]}")

    def check_stands(self, tool_off=True):
        """Nothing steps, and the tool is off. `tool_off`: False if it may be on, as in a hold."""
        self.run_ms(SAFE_MS)
        before = list(self.machine.plant.position)
        self.run_ms(SAFE_MS)
        if self.machine.plant.position != before:
            raise Wrong("it moves although it has been stopped")
        if tool_off and self.machine.plant.tool:
            raise Wrong("the tool is on although it has been stopped")

    def check_late(self):
        """No word came late, by the firmware's own log."""
        counts = self.machine.app.controller.machine.log.counts
        if counts.get(109):
            raise Wrong("words came late (error 109)")

    def check_heap(self):
        """At rest. The first time it is only measured."""
        app = self.machine.app
        plant = self.machine.plant
        machine = self.machine
        outside = [machine.port, machine.board, machine.inverter, plant, self.witness, self, machine, *machine.lines.values()]
        size = reachable(app, outside)
        if self._heap is None:
            self._heap = size
        elif size > self._heap + HEAP_GROWTH:
            raise Wrong(f"the board's objects have grown from {self._heap} to {size} bytes")


class Wire:
    """The PC's end of link `pc`, as a serial port and as the module time: while something is waited for cycles of the board pass."""

    baudrate = BAUD
    timeout = 0.05

    def __init__(self, bench):
        self._bench = bench
        self.end_ms = None  # by when whoever uses it has come to an end

    def _wait(self):
        self._bench.cycle()
        if self.end_ms is not None and self._bench.now_ms() > self.end_ms:
            raise Wrong("a command of passo does not come to its end")

    @property
    def in_waiting(self):
        return len(self._bench.line.arrived)

    def read(self, size):
        line = self._bench.line
        if not line.arrived:
            self._wait()
        data, line.arrived = line.arrived, b""
        return data

    def write(self, data):
        self._bench.line.wires[0].put(data)

    def reset_input_buffer(self):
        self._bench.line.arrived = b""

    def close(self):
        """The cable stays."""

    # --- as the module time

    def monotonic(self):
        return self._bench.now_ms() / 1000

    time = monotonic

    def monotonic_ns(self):
        return int(self._bench.now_ms() * 1e6)

    def sleep(self, seconds):
        end_ms = self._bench.now_ms() + 1000 * seconds
        while self._bench.now_ms() < end_ms:
            self._wait()


class Cabled(Bench):
    """A machine whose link `pc` is a cable, with noise on it, that may be cut."""

    def __init__(self, seed):
        super().__init__(seed)
        self.line = Cable(seed, "pc")
        self.wire = Wire(self)
        self._counted = 0  # faults of the wires

    def cycle(self):
        super().cycle()
        self.line.carry(self.machine, self.now_ms())

    @contextlib.contextmanager
    def passo(self, framed=None):
        """Commands of `passo` run here, and nobody looks at what they say. `framed`: as virtual_wire.patched()."""
        self.wire.end_ms = self.now_ms() + LONGEST_MS
        with (
            patched(self.wire, framed), contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()),
            mock.patch.object(sys, "stdin", io.StringIO()),
        ):  # fmt: skip
            try:
                yield
            finally:
                self.wire.end_ms = None

    def count_noise(self):
        faults = self.line.faults()
        if faults > self._counted:
            self.faults["byte on the wire"] += faults - self._counted
            self._counted = faults

    def unplug(self, ms):
        self.line.plugged = False
        self.after(ms, self.plug)

    def plug(self):
        self.line.plugged = True
