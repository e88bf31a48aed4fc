"""TMC2209 drivers on one wire at a UART of an emulated Pico.

    drivers = WiredDrivers(pico, board["drivers"])
    drivers.model["x"].dead = True          # a SimDrivers

The wire gives back what the Pico sends; replies come behind it at the wire's pace.
"""

from host_tools.emulator import cycles
from host_tools.emulator.wire import BITS_A_BYTE
from host_tools.sim.tmc import CLOCKS, SimDrivers


class WiredDrivers:
    def __init__(self, pico, config):
        self._pico = pico
        self._baud = config["baud"]
        self.model = SimDrivers(config, lambda: pico.now_us / 1000)
        self.wire = pico.uart(int(config["port"][4:]))
        self.wire.listeners.append(self._heard)

    def _heard(self, value):
        data = bytes((value,))
        self.wire.feed(data, self._baud)
        for reply in self.model.hear(data):
            wait_ns = (CLOCKS + BITS_A_BYTE) * 1_000_000_000 // self._baud
            self._pico.at(self._pico.cycle + wait_ns // cycles.CYCLE_NS, lambda reply=reply: self.wire.feed(reply, self._baud))
