"""The start on a Raspberry Pi Pico and its like."""

import gc
import sys
from array import array

import rp2
from micropython import const

from passo.ports import start
from passo.records import ARCS, ARC_FIELDS, QUEUE_SIZE, ROW_STEPS

_FOR_WORK = const(16_500)  # bytes kept free in one piece for what the main loop takes and gives back
_FOR_MARKS = const(2_100)  # the same for the feeder's
_SHORT = const(14_000)  # free bytes beside that when all code is loaded, below which it is given back
_WORDS = const(1024)  # of the ring of most boards
_COLLECT = const(72_000)  # bytes taken while code is loaded until garbage is collected: what stays lies close together


class Start(start.Start):
    _code = None
    _said = ""

    def loading(self):
        from passo.ports.rp2 import clock

        clock.hurry()
        gc.threshold(_COLLECT)
        from passo.ports.rp2.flash_code import FlashCode

        rooms = [b""]
        self._code = code = FlashCode(rooms)
        code.begin()
        if code.why:
            self._said = code.text()
            self.whole = "RP2040" not in sys.implementation._machine
            self._code = code = None
            start.forget("passo.ports.rp2.flash_code")
            gc.collect()
        else:
            self.rooms = rooms
            self._keep_for_work()
            # The largest arrays are made now, while there are pieces of memory as large: what is loaded leaves none.
            rooms.append(bytes(_FOR_MARKS))
            sizes = ("I", _WORDS), ("i", ARC_FIELDS * ARCS), ("i", QUEUE_SIZE * (ROW_STEPS + self.axes))
            rooms.extend([(kind, array(kind, bytearray(4 * count))) for kind, count in sizes])

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

    def _keep_for_work(self):
        if self.rooms and not self.lean:
            try:
                self.rooms[0] = bytearray(_FOR_WORK)
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
        gc.collect()
        if self.rooms:
            if not self.rooms[0]:
                self._keep_for_work()
            if gc.mem_free() < _SHORT:
                self.rooms[0] = b""
                gc.collect()
        return made
