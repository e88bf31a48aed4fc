"""The start on a Raspberry Pi Pico and its like."""

import gc
import sys

import rp2
from micropython import const

from passo.ports import start

# Bytes, each kept free in one piece while code is loaded and moved to flash.
_FOR_BLOCKS = const(17_500)  # for the arrays of the planner
_BLOCKS = const(16_200)  # what these take: if no piece is as large, _FOR_WORK is given back, too
_FOR_WORDS = const(10_000)  # for those of ring and feeder, which come later
_SHORT = const(36_000)  # free bytes then, with _FOR_BLOCKS and without the others, below which these are given back
_FOR_WORK = const(16_500)  # for what the main loop takes and gives back
_COLLECT = const(72_000)  # bytes taken while code is loaded until garbage is collected: what stays lies close together


class Start(start.Start):
    _code = None
    rooms = [bytearray(0)]  # nothing, until code has been found to run from flash
    _said = ""

    def loading(self):
        from passo.ports.rp2 import clock

        clock.hurry()
        gc.threshold(_COLLECT)
        from passo.ports.rp2.flash_code import FlashCode

        rooms = []
        self._code = code = FlashCode(rooms)
        code.begin()
        if code.why:
            self._said = code.text()
            self.whole = "RP2040" not in sys.implementation._machine
            self._code = code = None
            start.forget("passo.ports.rp2.flash_code")
            gc.collect()
        else:
            rooms.append(bytearray(self._for_work()))
            rooms.append(bytearray(_FOR_WORDS))
            rooms.append(bytearray(_FOR_BLOCKS))
            self.rooms = rooms

    def run(self, app, port):
        self.rooms.clear()
        gc.threshold(-1)  # from here on only when memory is used up: a collection takes some 30 ms
        start.Start.run(self, app, port)

    def load(self, board):
        from passo.ports.rp2 import port

        if self._code:
            self._code.redirect()
        port.load(board)

    def loaded(self):
        code, self._code = self._code, None
        if code:
            code.finish()
            self._said = code.text()
        return self._said

    def _for_work(self):
        return 0 if self.lean else _FOR_WORK

    def _keep_again(self):
        """What was given back while code was loaded, if it fits beside the planner's arrays, which come first."""
        try:
            blocks = bytearray(_FOR_BLOCKS)
            for size in (self._for_work(), _FOR_WORDS)[len(self.rooms) :]:
                self.rooms.append(bytearray(size))
        except MemoryError:
            pass

    def button(self):
        return "BOOTSEL" if rp2.bootsel_button() else None

    def port(self, board):
        """Raises RuntimeError if the chip does not take the board file's clock."""
        from passo.ports.rp2 import clock

        clock.set_mhz(board["clock_mhz"])
        start.forget("passo.ports.rp2.clock")
        from passo.ports.rp2.port import Port

        made = Port(board)
        if self.rooms:
            self.rooms.pop()
            gc.collect()
            self._keep_again()
            if gc.mem_free() < _SHORT:
                self.rooms.clear()
            try:
                bytearray(_BLOCKS)
            except MemoryError:  # memory is too short to keep _FOR_WORK free
                self.rooms.clear()
        gc.collect()
        return made
