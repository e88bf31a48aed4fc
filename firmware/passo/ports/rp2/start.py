"""The start on a Raspberry Pi Pico and its like. Passo's UF2 has its code in flash; stock MicroPython, whose memory code and data share, has a start
of its own."""

import gc
import sys

import rp2
from micropython import const

from passo.ports import start

_COLLECT = const(90_000)  # bytes taken until garbage is collected: of a full router 88 kB are in one piece; with 100 000 85 are, 20 ms sooner
_OF_CHECK = ("board", "passo.config.boardfile", "passo.config.chip_pins")


def drop(name, empty=True):
    """Give back the memory of a module that only the start needs; if it is imported again, it is loaded again. `empty`: clear its globals, too,
    because a stale word on the stack that points to one of its functions would keep all of them. False: its functions are still used."""
    module = sys.modules.pop(name, None)
    if module:
        package, _, short = name.rpartition(".")
        if package:
            delattr(sys.modules[package], short)
        if empty:
            module.__dict__.clear()


def drop_builder():
    """Drop the modules by which the app is made."""
    drop("passo.config.setting_numbers", False)
    drop("passo.machine_builder")


def drop_check():
    """Drop the modules by which the board file is checked."""
    for name in [name for name in sys.modules if name in _OF_CHECK or name[:14] == "passo.options." and ".manifest" in name]:
        drop(name)


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
        """Drop the modules of the check, and import what the Port of this board will ask for."""
        drop_check()
        from passo.ports.rp2 import port

        port.load(board)

    def finish_loading(self):
        """Return the line that says where the code lies."""
        return self._said

    def settle(self, app):
        """Drop what only the making of the app needed. From here on collect only when memory is used up: a collection takes some 30 ms."""
        drop_builder()
        drop(getattr(app.board.pop("additions", None), "lines", None), False)
        gc.threshold(-1)
        start.Start.settle(self, app)

    def button(self):
        """Return "BOOTSEL" if the button is held; else None."""
        return "BOOTSEL" if rp2.bootsel_button() else None

    def port(self, board):
        """Set the clock and return the Port of a checked board. Raises RuntimeError if the chip does not take the board file's clock."""
        from passo.ports.rp2 import clock

        clock.set_mhz(board["clock_mhz"])
        drop("passo.ports.rp2.clock", False)
        from passo.ports.rp2.port import Port

        return Port(board)
