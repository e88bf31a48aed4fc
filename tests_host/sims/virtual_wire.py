"""The commands of `passo` against a machine in memory: their ports are its lines, and their time is its own.

    with plugged(machine):
        resume.resume(file, "virtual", yes=True, …)

A read lets the machine go on by a cycle; to sleep lets it go on for so long. `stopped(cycles)` ends the PC amid its work: Killed.
"""

import contextlib
import random

from host_tools.cli import draw_run, jobs, pulses_panel, resume_pulses
from host_tools.clients import plotter, pulses, wire
from host_tools.clients.frames import FramedPort
from host_tools.programs import job


class Killed(BaseException):
    """The PC's process is gone: nothing of it runs any more."""


class Wire:
    """A serial port, and the module time, of a VirtualMachine."""

    baudrate = 115_200

    def __init__(self, machine, cycles=None, share=0.0):
        """`cycles`: so many of the board's, then the PC is killed; `share` of the bytes are lost, doubled or flipped."""
        self._rng = random.Random(share)
        self._share = share
        self._machine = machine
        self._cycles = cycles
        self.timeout = 0.01

    def _cycle(self):
        if self._cycles is not None:
            if not self._cycles:
                raise Killed
            self._cycles -= 1
        self._machine.cycle()

    @property
    def in_waiting(self):
        return len(self._machine.received())

    def write(self, data):
        self._machine.send(self._noisy(data))

    def read(self, size=1):
        end = self.monotonic() + self.timeout
        while not self._machine.received() and self.monotonic() < end:
            self._cycle()
        data = self._machine.take()
        line = self._machine.lines[self._machine.first]
        line.outgoing = data[size:]
        return self._noisy(data[:size])

    def _noisy(self, data):
        if not self._share:
            return data
        made = bytearray()
        for byte in data:
            kind = self._rng.randrange(3) if self._rng.random() < self._share else None
            made += (b"", bytes((byte, byte)), bytes((byte ^ 1 << self._rng.randrange(8),)), bytes((byte,)))[3 if kind is None else kind]
        return bytes(made)

    def close(self):
        pass

    # --- as the module time

    def monotonic(self):
        return self._machine.now_ms() / 1000

    time = monotonic

    def sleep(self, seconds):
        end = self.monotonic() + seconds
        while self.monotonic() < end:
            self._cycle()


def _framed(made):
    opened = FramedPort(made, lambda: round(1000 * made.monotonic()))
    assert opened.begin(2.0), "the board has no frames"
    return opened


@contextlib.contextmanager
def plugged(machine, cycles=None, framed=False, share=0.0):
    """The PC is plugged in, until the end or until it is killed. `framed`: as by `passo --frames`."""
    made = Wire(machine, cycles, share)
    kept = [(module, module.time) for module in (pulses, pulses_panel, plotter, wire, job, jobs, resume_pulses, draw_run)]
    kept_open = pulses.open_port, wire.open_port
    try:
        for module, _ in kept:
            module.time = made
        pulses.open_port = wire.open_port = lambda port, baud: _framed(made) if framed else made
        yield
    finally:
        for module, clock in kept:
            module.time = clock
        pulses.open_port, wire.open_port = kept_open
