"""A router in memory, whose first link speaks frames over a noisy wire to `passo`'s own client of grbl."""

from host_tools import boards
from host_tools.clients.frames import FramedPort
from host_tools.clients.grbl import GrblClient
from host_tools.sim.machine import VirtualMachine
from noisy_wire import BAUD, NoisyWire


def framed(name="router_3axis", **changes):
    """The board file of `name`, its first link in frames."""
    board = boards.load(name)
    board["links"][0].update(frames=True, **changes)
    return board


class MachineAndClient:
    """The machine's time passes while the client waits for bytes."""

    baudrate = BAUD
    timeout = 0.02

    def __init__(self, seed=0, share=0.0, frames=True, board=None):
        """`frames`: False speaks plain text, over the same wire."""
        self.machine = VirtualMachine(board or framed(), start=(3000, 2500, -1800))
        self.wires = [NoisyWire(seed, 0.0), NoisyWire(seed + 1, 0.0)]
        self._arrived = b""
        self._at_ms = 0
        port = self
        if frames:
            port = FramedPort(self, lambda: int(self.machine.now_ms()))
            assert port.begin(1)
        for wire in self.wires:
            wire.set(share)
        self.client = GrblClient("memory", opened=port)

    @property
    def in_waiting(self):
        return len(self._arrived)

    def read(self, size):
        if not self._arrived:
            self.machine.cycle()
            now_ms = int(self.machine.now_ms())
            while self._at_ms < now_ms:
                self._at_ms += 1
                self.machine.send(self.wires[0].take(self._at_ms))
                self._arrived += self.wires[1].take(self._at_ms)
            self.wires[1].put(self.machine.take())
        data, self._arrived = self._arrived, b""
        return data

    def write(self, data):
        self.wires[0].put(data)

    def close(self):
        self.machine.close()
