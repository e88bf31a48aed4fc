"""Streams G-code to the emulated Pico over USB or a UART, in plain text or in frames, with `passo`'s own client.

    machine = streaming_router(("pc",))                     # booted; "pc" is on USB, "serial" on a UART
    on_a_copy(lambda: lines_s(machine, "pc", True, 600))    # lines a second
"""

import random

from host_tools import boards
from host_tools.clients.frames import FramedPort
from host_tools.clients.grbl import GrblClient
from host_tools.emulator.machine import EmulatedMachine

_LENGTH_MM = 0.1  # of a line, along X at the axis's full speed: 833 lines a second move the machine
_LINE = b"G1X%.3fY50.000Z-20.000"
_SLICE_US = 250
_SETTLE_MS = 300
_PATIENCE_S = 1e6  # of the PC, whose clock is not the Pico's


class EmulatedPort:
    """A link as a pyserial port: while a read waits, the Pico runs, `waits_us` until the PC looks again; with a `seed` 0.5 to 1.5 times that, by
    chance, as no PC looks in step with a board's answers."""

    timeout = 0.01

    def __init__(self, machine, link, waits_us=_SLICE_US, seed=None):
        self.machine = machine
        self._waits_us = waits_us
        self._chance = None if seed is None else random.Random(seed)
        self._wire = machine.wire(link)
        config = next(config for config in machine.board["links"] if config["name"] == link)
        self._baud = config["baud"]
        self.baudrate = None if config["port"] == "usb" else config["baud"]
        self._received = bytearray(self._wire.drain())

    @property
    def in_waiting(self):
        self._received += self._wire.drain()
        return len(self._received)

    def read(self, size=1):
        """Return up to `size` bytes. If there are none, let the machine run first, as long as a read waits (µs, ± half with a seed)."""
        if not self.in_waiting:
            self.machine.pico.run(round(self._waits_us * self._chance.uniform(0.5, 1.5)) if self._chance else self._waits_us)
        size = min(size, self.in_waiting)
        data = bytes(self._received[:size])
        del self._received[:size]
        return data

    def write(self, data):
        self._wire.feed(bytes(data), self._baud)

    def reset_input_buffer(self):
        self.in_waiting
        self._received.clear()


def streaming_router(framed, clock_mhz=125):
    """Boot a router; the links named in `framed` have frames."""
    board = {**boards.load("router_3axis"), "clock_mhz": clock_mhz}
    for link in board["links"]:
        link["frames"] = link["name"] in framed
    machine = EmulatedMachine(board, trace=None).boot()
    machine.run_until(lambda: b"code in" in machine.pico.console.text)  # the last words of the start
    machine.run_ms(_SETTLE_MS)
    return machine


def lines_s(machine, link, frames, count):
    """Return the lines a second of the last half of `count` lines, 500 or more; `frames`: in frames, else in plain text, by counting characters."""
    port = EmulatedPort(machine, link)
    port.reset_input_buffer()
    if frames:
        port = FramedPort(port, lambda: int(machine.now_ms()))
        assert port.begin(1), "no WELCOME"
    client = GrblClient(link, timeout_s=_PATIENCE_S, opened=port)
    if link != machine.board["links"][0]["name"]:
        client.command("$LINK=0")
    for line in ("$X", "G21G90G94", "G92X0Y50Z-20", "G1F5000"):
        client.command(line)
    begun = None
    for number in client.stream([(number, _LINE % (number * _LENGTH_MM)) for number in range(count)]):
        if number == count // 2:
            begun = machine.now_ms()
    return (count - 1 - count // 2) * 1000 / (machine.now_ms() - begun)
