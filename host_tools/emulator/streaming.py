"""Streams G-code to the emulated Pico over USB or a UART, in plain text or in frames, with `passo`'s own client.

    machine = streaming_router()                            # booted; "pc" is on USB, "serial" on a UART
    on_a_copy(lambda: lines_s(machine, "pc", True, 600))    # lines a second
"""

from host_tools import boards
from host_tools.clients.frames import FramedPort
from host_tools.clients.grbl import GrblClient
from host_tools.emulator.gcode import chords
from host_tools.emulator.machine import EmulatedMachine

_LENGTH_MM, _FEED_MM_S = 0.2, 249
_SLICE_US = 250
_SETTLE_MS = 300
_PATIENCE_S = 1e6  # of the PC, whose clock is not the Pico's


class EmulatedPort:
    """A link as a pyserial port: while a read waits, the Pico runs."""

    timeout = 0.01

    def __init__(self, machine, link):
        self.machine = machine
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
        if not self.in_waiting:
            self.machine.pico.run(_SLICE_US)
        size = min(size, self.in_waiting)
        data = bytes(self._received[:size])
        del self._received[:size]
        return data

    def write(self, data):
        self._wire.feed(bytes(data), self._baud)

    def reset_input_buffer(self):
        self.in_waiting
        self._received.clear()


def streaming_router(clock_mhz=125, frames=True):
    """A booted router whose processor is the limit: its axes do 250 mm/s and 20 000 mm/s²."""
    board = {**boards.load("router_3axis"), "clock_mhz": clock_mhz}
    for axis in board["axes"]:
        axis.update(max_mm_min=15_000, accel_mm_s2=20_000)
    for link in board["links"]:
        link["frames"] = frames
    machine = EmulatedMachine(board, trace=None).boot()
    machine.run_until(lambda: b"code in" in machine.pico.console.text)  # the last words of the start
    machine.run_ms(_SETTLE_MS)
    return machine


def lines_s(machine, link, frames, count):
    """Lines a second of the last three quarters of `count` chords; `frames`: in frames, else plain, counting characters."""
    port = EmulatedPort(machine, link)
    port.reset_input_buffer()
    if frames:
        port = FramedPort(port, lambda: int(machine.now_ms()))
        assert port.begin(1), "no WELCOME"
    client = GrblClient(link, timeout_s=_PATIENCE_S, opened=port)
    start, text = chords(_LENGTH_MM)
    if link != machine.board["links"][0]["name"]:
        client.command("$LINK=0")
    for line in ("$X", "G21G90G94", f"G92X{start}Y50Z-20", f"G1F{60 * _FEED_MM_S}"):
        client.command(line)
    path = text.rstrip(b"\n").split(b"\n")
    begun = None
    for number in client.stream([(number, path[number % len(path)]) for number in range(count)]):
        if number == count // 4:
            begun = machine.now_ms()
    return (count - 1 - count // 4) * 1000 / (machine.now_ms() - begun)
