"""An encoder's two wires on an emulated Pico.

    wires = Quadrature(pico, 16, 250_000)       # A on GPIO16, B on GPIO17; counts a second
    wires.turn_by(1200)                            # 1200 counts from now on, back if negative
    wires.count
"""

_LEVELS = ((0, 0), (1, 0), (1, 1), (0, 1))  # of A and B, by count
_NS = 1_000_000_000


class Quadrature:
    def __init__(self, pico, pin, counts_s, offset_ns=0):
        self.count = 0
        self.left = 0
        self._pico, self._pin = pico, pin
        self._period_ns = _NS / counts_s
        self._offset_ns = offset_ns
        self._alarm = pico.chip.clock.create_alarm(self._step_once)
        self._show_levels()

    def turn_by(self, counts):
        """Turn by `counts` from now on, behind those under way; negative: back."""
        if counts and not self.left:
            self._alarm.schedule(self._period_ns + self._offset_ns)
        self.left += counts

    def jump_by(self, counts):
        """Jump by `counts`, 2 for example: both wires change at once, and nobody can tell the direction."""
        self.count += counts
        self._show_levels()

    def _step_once(self):
        """Turn the encoder by one count towards `left` = 0, and set the alarm for the next."""
        if not self.left:  # turned back meanwhile
            return
        sign = 1 if self.left > 0 else -1
        self.count += sign
        self.left -= sign
        self._show_levels()
        if self.left:
            self._alarm.schedule(self._period_ns)

    def _show_levels(self):
        for pin, level in zip((self._pin, self._pin + 1), _LEVELS[self.count & 3]):
            self._pico.drive_pin(pin, level)
