"""A router in memory, whose first link speaks frames over a noisy wire to `passo`'s own client of grbl."""

from host_tools import boards
from host_tools.clients.frames import FramedPort
from host_tools.clients.grbl import GrblClient
from host_tools.sim.machine import VirtualMachine
from noisy_wire import BAUD, Cable


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
        self._cable = Cable(seed)
        port = self
        if frames:
            port = FramedPort(self, lambda: int(self.machine.now_ms()))
            assert port.begin(1)
        self._cable.set(share)
        self.client = GrblClient("memory", opened=port)

    @property
    def in_waiting(self):
        return len(self._cable.arrived)

    def read(self, size):
        cable = self._cable
        if not cable.arrived:
            self.machine.cycle()
            cable.carry(self.machine, self.machine.now_ms())
        data, cable.arrived = cable.arrived, b""
        return data

    def write(self, data):
        self._cable.wires[0].put(data)

    def close(self):
        self.machine.close()
