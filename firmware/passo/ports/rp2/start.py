"""The start on a Raspberry Pi Pico and its like."""

import gc
import sys
from array import array

import rp2
from micropython import const

from passo.ports import start
from passo.ports.rp2.fields import LEAD_TICKS
from passo.records import ARCS, ARC_FIELDS, JOB_WORDS, QUEUE_SIZE, ROW_STEPS

_FOR_WORK = const(4_125)  # words kept free in one piece for what the main loop takes and gives back
_FOR_LEAN = const(2_050)  # the same of a board that has no memory to spare: its table of names grows by as much
_BUFFERS = const(8)  # of _BUFFER bytes: if they do not fit beside _FOR_WORK when all code is loaded, that is given back
_BUFFER = const(1_100)  # as links and tables have them
_MODULES = const(130)
_COLLECT = const(72_000)  # bytes taken while code is loaded until garbage is collected: what stays lies close together


class Start(start.Start):
    _code = None
    _said = ""

    def loading(self):
        from passo.ports.rp2 import clock

        clock.hurry()
        for number in range(_MODULES):  # so that the list of them need not grow where no piece of memory is as large
            sys.modules[str(number)] = None
        for number in range(_MODULES):
            del sys.modules[str(number)]
        gc.threshold(_COLLECT)
        from passo.ports.rp2.flash_code import FlashCode

        rooms = [[]]
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

    def keep(self, board):
        """The largest arrays are made now, while there are pieces of memory as large: what is loaded leaves none."""
        if not self.rooms:
            return
        from passo.steps.ring import arrays

        sizes = arrays(board, LEAD_TICKS)
        if "grbl" in [link["protocol"] for link in board["links"]]:  # no other language has arcs
            sizes += (("i", ARC_FIELDS * ARCS),)
        sizes += (("i", QUEUE_SIZE * (ROW_STEPS + len(board["axes"]))),)
        self._keep_for_work()
        if board["jobs"]:
            self.rooms.append(("n", [None] * JOB_WORDS))
        self.rooms.extend([(kind, array(kind, bytearray(4 * count))) for kind, count in sizes])

    def give_back(self):
        """Free what has been kept and was not asked for."""
        if self.rooms:
            self.rooms[0].clear()  # not by collection: a stale word on the stack may point to it
            self.rooms.clear()

    def run(self, app, port):
        self.give_back()
        gc.threshold(-1)  # from here on only when memory is used up: a collection takes some 30 ms
        start.Start.run(self, app, port)

    def load(self, board):
        from passo.ports.rp2 import port

        if self._code:
            self._code.redirect()
        port.load(board)

    def relieve(self):
        for place in range(len(self.rooms)):
            if self.rooms[place]:
                if place:
                    self.rooms[place] = ()
                else:
                    self.rooms[0].clear()
                self._code.redirect(place > 0)
                return True
        return False

    def loaded(self):
        code, self._code = self._code, None
        if code:
            code.finish()
            self._said = code.text()
        return self._said

    def _keep_for_work(self):
        try:
            self.rooms[0] = [None] * (_FOR_LEAN if self.lean else _FOR_WORK)
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
            try:
                [bytearray(_BUFFER) for number in range(_BUFFERS)]
            except MemoryError:
                self.rooms[0].clear()
        return made
