"""TMC2209 drivers on one wire at a UART of an emulated Pico.

    drivers = WiredDrivers(pico, board["drivers"])
    drivers.model["x"].dead = True          # a SimDrivers

The wire gives back what the Pico sends; replies come behind it at the wire's pace.
"""

from host_tools.emulator import cycles
from host_tools.emulator.wire import BITS_A_BYTE
from host_tools.sim.tmc import CLOCKS, SimDrivers
from host_tools.sim.tmc_spi import SpiDrivers


class WiredDrivers:
    def __init__(self, pico, config):
        self._pico = pico
        self._baud = config["baud"]
        self.model = SimDrivers(config, lambda: pico.now_us / 1000)
        self.wire = pico.uart(int(config["port"][4:]))
        self.wire.listeners.append(self._take_byte)

    def _take_byte(self, value):
        """Give a byte of the Pico back on the wire, and let the drivers' replies follow CLOCKS bits behind it."""
        data = bytes((value,))
        self.wire.feed(data, self._baud)
        for reply in self.model.replies_to(data):
            wait_ns = (CLOCKS + BITS_A_BYTE) * 1_000_000_000 // self._baud
            self._pico.call_at(self._pico.cycle + wait_ns // cycles.CYCLE_NS, lambda reply=reply: self.wire.feed(reply, self._baud))


class WiredSpiDrivers:
    """TMC2130 or TMC5160 drivers at the pins of an emulated Pico; `model`: a SpiDrivers."""

    def __init__(self, pico, config):
        self._pads = pico.pads
        self._config = config
        self.model = SpiDrivers(config)
        self._cs = None  # that is low
        for cs in self.model.chains:
            pico.pads.add_listener(cs, lambda _, state, cs=cs: self._on_select(cs, state))
        pico.pads.add_listener(config["sck"], lambda _, state: self._on_clock(state))

    def _on_select(self, cs, state):
        """Begin or end a transfer with the driver of pin `cs`, as the pin goes low or high."""
        if state == 1 and self._cs == cs:
            self._cs = None
            self.model.set_cs(cs, 1)
            self._pads.drive_pin(self._config["rx"], None)
        elif state == 0 and self._cs is None:
            self._cs = cs
            self.model.set_cs(cs, 0)
            self._show_output()

    def _on_clock(self, state):
        """Clock a bit into the selected driver as the clock rises; show the next bit of its output as it falls."""
        if self._cs is not None and state == 1:
            self.model.clock_bit(self._cs, self._pads.state_of(self._config["tx"]) & 1)
        elif self._cs is not None:
            self._show_output()  # it changes as the clock falls

    def _show_output(self):
        self._pads.drive_pin(self._config["rx"], self.model.output_level(self._cs))
