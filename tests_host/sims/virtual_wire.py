"""The commands of `passo` against a machine in memory: their ports are its lines, and their time is its own.

    with plugged(machine):
        resume.resume(file, "virtual", yes=True, …)

A read lets the machine go on by a cycle; a sleep lets it go on for its time. `plugged(machine, cycles)` ends the PC amid its work: Killed.
"""

import contextlib

from host_tools.cli import draw_run, jobs, pulses_panel, resume_pulses, stream
from host_tools.clients import frames, grbl, plotter, pulses, serial_port, wire
from host_tools.programs import job
from noisy_wire import BAUD, Cable

STALLED_S = 300  # a command here takes a tenth of that


class Killed(BaseException):
    """The PC's process is gone: nothing of it runs any more."""


class Stalled(AssertionError):
    """A command does not come to its end."""


class Wire:
    """A serial port, and the module time, of a VirtualMachine."""

    baudrate = BAUD

    def __init__(self, machine, cycles=None, share=0.0, seed=0):
        """`cycles`: the board's cycles until the PC is killed, None: any; `share` of the bytes are lost, doubled or flipped, at random by `seed`."""
        self._machine = machine
        self._cycles = cycles
        self._end = self.monotonic() + STALLED_S
        self.cable = Cable(seed)
        self.cable.renew(machine.now_ms())
        self.cable.set(share)
        self.timeout = 0.01

    def _cycle(self):
        if self._cycles is not None:
            if not self._cycles:
                raise Killed
            self._cycles -= 1
        if self.monotonic() > self._end:
            raise Stalled
        self._machine.cycle()
        self.cable.carry(self._machine, self._machine.now_ms())

    @property
    def in_waiting(self):
        return len(self.cable.arrived)

    def write(self, data):
        self.cable.wires[0].put(data)

    def read(self, size=1):
        cable = self.cable
        end = self.monotonic() + self.timeout
        while not cable.arrived and self.monotonic() < end:
            self._cycle()
        data, cable.arrived = cable.arrived[:size], cable.arrived[size:]
        return data

    def reset_input_buffer(self):
        self.cable.arrived = b""

    def close(self):
        pass

    # --- as the module time

    def monotonic(self):
        return self._machine.now_ms() / 1000

    time = monotonic

    def monotonic_ns(self):
        return int(self.monotonic() * 1e9)

    def sleep(self, seconds):
        end = self.monotonic() + seconds
        while self.monotonic() < end:
            self._cycle()


@contextlib.contextmanager
def patched(made, framed):
    """`made` is the port, and the time, of the commands of `passo`. `framed`: as by `passo --frames`; None: as they please."""
    timed = (frames, grbl, pulses, pulses_panel, plotter, wire, job, jobs, resume_pulses, draw_run, stream)
    with contextlib.ExitStack() as patches:
        for module, name, value in (
            *((module, "time", made) for module in timed),
            (serial_port, "frames", framed),
            (serial_port, "open_exclusively", lambda *_: made),
        ):  # fmt: skip
            patches.callback(setattr, module, name, getattr(module, name))
            setattr(module, name, value)
        yield


@contextlib.contextmanager
def plugged(machine, cycles=None, framed=False, share=0.0, seed=0):
    """The PC is plugged in, until the end or until it is killed: a Wire."""
    made = Wire(machine, cycles, share, seed)
    with patched(made, framed):
        yield made
