"""The start on a Raspberry Pi Pico and its like. Passo's UF2 has its code in flash; stock MicroPython, whose memory code and data share, has a start
of its own."""

import gc

import rp2
from micropython import const

from passo.ports import start

_COLLECT = const(100_000)  # bytes taken until garbage is collected: a router has 84 kB in one piece then instead of 44; with 80 000 it starts 20 ms later


class Start(start.Start):
    fits = start.FROZEN  # there is memory for the code
    _said = "code in the UF2"

    def ready(self):
        """Return False if the code does not fit, or the REPL is asked for. Prints why."""
        if not self.fits:
            print("Passo in files has no room in the memory of stock MicroPython: this board wants Passo's UF2, passo flash --uf2")
            return False
        return start.Start.ready(self)

    def begin_loading(self):
        """Collect garbage early."""
        gc.threshold(_COLLECT)

    def load(self, board):
        """Import what the Port of this board will ask for."""
        from passo.ports.rp2 import port

        port.load(board)

    def finish_loading(self):
        """Return the line that says where the code lies."""
        return self._said

    def settle(self, app):
        """From here on collect only when memory is used up: a collection takes some 30 ms."""
        gc.threshold(-1)
        start.Start.settle(self, app)

    def button(self):
        """Return "BOOTSEL" if the button is held; else None."""
        return "BOOTSEL" if rp2.bootsel_button() else None

    def port(self, board):
        """Set the clock and return the Port of a checked board. Raises RuntimeError if the chip does not take the board file's clock."""
        from passo.ports.rp2 import clock

        clock.set_mhz(board["clock_mhz"])
        from passo.ports.rp2.port import Port

        return Port(board)
