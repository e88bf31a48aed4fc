"""The bank of an ESP32 whose motors, tool and outputs are on shift registers: i2s_player.py plays their levels."""

from micropython import const

from passo.ports.esp32.i2s_player import I2sPlayer
from passo.records import REGISTER_BIT

_LEAD_TICKS = const(24 * 12_500)  # 16.4 ms of frames, 2 to the next pump, and a segment of an arc, which counts whole
_PSRAM_LEAD_TICKS = const(41 * 12_500)  # 32.8 ms of frames


class ShiftBank:
    def __init__(self, board):
        self._psram = board["psram"]
        self.lead_ticks = _PSRAM_LEAD_TICKS if self._psram else _LEAD_TICKS
        self.player = None  # until there is one
        self._section = board["shift"]
        self._pins = []

    def output(self, entry):
        """Return the ShiftPin of an entry of the board file."""
        self._pins.append(ShiftPin(self, entry["pin"] - REGISTER_BIT, 1 - entry["active"]))
        return self._pins[-1]

    def make_player(self, ring, layout, pins, pulse_ticks, invert):
        """Return the I2sPlayer of the board's motors. The outputs show their levels from here on."""
        outputs = [pin - REGISTER_BIT for pin in pins]
        self.player = I2sPlayer(ring, layout, outputs, pulse_ticks, invert, self._section, self._psram)
        for pin in self._pins:
            pin.show_level()
        return self.player

    def exchange(self, *_):
        """Do nothing: frames go out all the time."""

    begin = join = close = exchange


class ShiftPin:
    """An output of the register, in the place of a Pin."""

    def __init__(self, bank, number, level):
        self._bank = bank
        self._number = number
        self.level = level

    def value(self, level):
        """Show a level."""
        self.level = level
        self.show_level()

    def show_level(self):
        """Show the level, if there is a player."""
        player = self._bank.player
        if player is not None:
            player.output(self._number, self.level)


def create(board, port, inputs, outputs):
    """Return the port's part."""
    return ShiftBank(board)
