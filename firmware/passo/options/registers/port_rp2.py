"""Shift registers on the RP2040 and the RP2350: their pins are written as registers of SIO. 16 bits take about 25 µs."""

import micropython

from passo.options.registers.port import ShiftRegisters, first_levels
from passo.ports.rp2 import chip


class SioRegisters(ShiftRegisters):
    def __init__(self, config, outputs):
        ShiftRegisters.__init__(self, config, outputs)
        self._toggle = chip.TOGGLE
        self._clock_bit = 1 << config["clock"]
        self._latch_bit = 1 << config["latch"]
        self._out_bit = 1 << config["out"]
        self._in_bit = 1 << config["in"]
        self.mask = 0  # of the pins of the other inputs

    def begin(self, port, board, mask):
        """See the base."""
        self.mask = mask
        ShiftRegisters.begin(self, port, board, mask)

    @micropython.viper
    def _shift_bits(self) -> int:  # ISR: no allocation
        """See the base; 16 bits take about 25 µs."""
        toggle = ptr32(int(self._toggle))
        pins = ptr32(0xD0000004)
        clock = int(self._clock_bit)
        latch = int(self._latch_bit)
        out = int(self._out_bit)
        data = int(self._in_bit)
        outputs = int(self.outputs)
        bits_in = int(self.chips_in) << 3
        bits_out = int(self.chips_out) << 3
        count = bits_in if bits_in > bits_out else bits_out
        toggle[0] = latch
        toggle[0] = latch
        inputs = 0
        shown = 0  # level of the wire out
        at = 0
        while at < count:
            left = count - 1 - at
            bit = outputs >> left & 1 if left < bits_out else 0
            if bit != shown:
                toggle[0] = out
                shown = bit
            if at < bits_in and pins[0] & data:
                inputs |= 1 << ((at & -8) + 7 - (at & 7))
            toggle[0] = clock
            toggle[0] = clock
            at += 1
        if shown:
            toggle[0] = out
        toggle[0] = latch
        toggle[0] = latch
        return inputs

    @micropython.viper
    def levels(self) -> int:
        """Return the levels of the pins, as Port.levels(); bits 23 to 25 count the changes of inputs behind registers."""
        return ptr32(0xD0000004)[0] & int(self.mask) | (int(self.changes) & 7) << 23


def create(board, port, inputs, outputs):
    """Return the port's part."""
    return SioRegisters(board["registers"], first_levels(board))
