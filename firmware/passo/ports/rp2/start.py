"""The start on a Raspberry Pi Pico and its like."""

import gc
import sys
from array import array

import rp2
from micropython import const

from passo.ports import start
from passo.ports.rp2.fields import LEAD_TICKS
from passo.records import ARCS, ARC_FIELDS, LINES_BYTES, QUEUE_SIZE, ROW_STEPS

_FOR_WORK = const(4_125)  # words kept free in one piece for what the main loop takes and gives back
_FOR_LEAN = const(2_050)  # the same of a board that has no memory to spare: its table of names grows by as much
_LEAST_FOR_WORK = const(1_000)  # a smaller piece is not kept
_FOR_NAMES = const(2_050)  # words for the interpreter's table of names, 1_930 if it doubles at its 1261st name, and for that name
_BUFFERS = const(8)  # of _BUFFER bytes: the piece for work is made smaller until they fit beside it when all code is loaded
_BUFFER = const(1_100)  # as links and tables have them
_MODULES = const(130)
_COLLECT = const(72_000)  # bytes taken while code is loaded until garbage is collected: what stays lies close together
_COLLECT_FROZEN = const(80_000)  # the same of frozen code: a router has 95 kB in one piece then instead of 44, and starts 15 ms later


class Start(start.Start):
    _code = None
    _said = ""

    def loading(self):
        if start.FROZEN:
            self._said = "code in the UF2"
            gc.threshold(_COLLECT_FROZEN)
            return
        from passo.ports.rp2 import clock

        clock.hurry()
        for number in range(_MODULES):  # so that the list of them need not grow where no piece of memory is as large
            sys.modules[str(number)] = None
        for number in range(_MODULES):
            del sys.modules[str(number)]
        gc.threshold(_COLLECT)
        from passo.ports.rp2.flash_code import FlashCode

        rooms = [[], []]
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
        self.rooms[1] = [None] * (_FOR_LEAN if self.lean else _FOR_WORK)
        if not self.lean:
            self.rooms[0] = [None] * _FOR_NAMES
        self.rooms.extend([(kind, array(kind, bytearray(4 * count))) for kind, count in sizes])

    def _keep_buffers(self, board):
        """Make what links and stored jobs keep. It fits the holes that redirected code has left, beside the piece for work."""
        languages = [link["protocol"] for link in board["links"]]
        if board["jobs"]:
            from passo.memory import FILE_BYTES, spent

            languages.append(board["jobs"]["language"])
            self.rooms.insert(2, ("d", spent(0)))
            self.rooms.insert(2, ("b", bytearray(FILE_BYTES)))
        for language in languages:
            if language == "grbl":
                self.rooms.insert(2, ("b", bytearray(LINES_BYTES)))

    def give_back(self):
        """Free what has been kept and was not asked for."""
        if self.rooms:
            self.rooms[1].clear()  # not by collection: a stale word on the stack may point to it
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
                if place > 1:
                    self.rooms[place] = ()
                else:
                    name = "name %d" % gc.mem_free()
                    self.rooms[place].clear()
                    try:
                        getattr(self, name, None)  # a table of names that is full doubles here and now
                    except MemoryError:
                        pass  # the next piece may be large enough
                self._code.redirect(place > 1)
                return True
        return False

    def loaded(self):
        code, self._code = self._code, None
        if code:
            code.finish()
            self._said = code.text()
        return self._said

    def _keep_for_work(self, buffers):
        """Keep one piece for work, as large as leaves room for `buffers`."""
        count = _FOR_LEAN if self.lean else _FOR_WORK
        while count >= _LEAST_FOR_WORK:
            self.rooms[1].clear()
            self.rooms[1] = []  # the one before still has its first words
            gc.collect()
            try:
                self.rooms[1] = [None] * count
                [bytearray(_BUFFER) for number in range(buffers)]
                return
            except MemoryError:
                count -= count // 4
        self.rooms[1].clear()

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
            self.rooms[0].clear()
            if self.rooms[1] or not self.lean:  # a lean board that has given it back needs what is left for the app
                self._keep_for_work(_BUFFERS)
            gc.collect()
            self._keep_buffers(board)
        return made
