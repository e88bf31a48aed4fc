"""The start on a Raspberry Pi Pico and its like.

MicroPython as it comes has one rule for its memory: bytecode stays in flash, machine code is in memory, and the largest arrays are made
before any of it is imported. In Passo's UF2 there is room for all.
"""

import gc
import sys
from array import array

import rp2
from micropython import const

from passo.memory import forget
from passo.ports import start
from passo.ports.rp2.fields import LEAD_TICKS
from passo.records import ARCS, ARC_FIELDS, LINES_BYTES, QUEUE_SIZE, ROW_STEPS

_COLLECT = const(56_000)  # bytes taken while code is loaded until garbage is collected: objects that stay lie close together
_OF_LOADING = (".flash_code", ".flash_names", "_flash_names", ".image", "_image")  # the parts after "rp2" in the names of modules
_COLLECT_FROZEN = const(100_000)  # the same of frozen code: a router has 84 kB in one piece then instead of 44; with 80 000 it starts 20 ms later


class Start(start.Start):
    _code = None
    _said = ""

    def begin_loading(self):
        """Collect garbage early while code is loaded, which then lies close together; on stock MicroPython leave it in flash."""
        if start.FROZEN:
            self._said = "code in the UF2"
            gc.threshold(_COLLECT_FROZEN)
            forget("passo_image")
            return
        from passo.ports.rp2 import flash_code

        gc.threshold(_COLLECT)
        self._code = flash_code.code

    def keep(self, board):
        """Make the largest arrays, and the buffers of links and files."""
        if start.FROZEN:
            if not getattr(board.get("additions"), "lines", None):  # 90 kB and more stay free, but with a radio
                from passo.memory import FileRoom

                FileRoom.spare()
            return
        from passo.steps.ring import arrays

        languages = [link["protocol"] for link in board["links"]]
        sizes = (("i", QUEUE_SIZE * (ROW_STEPS + len(board["axes"]))),) + arrays(board, LEAD_TICKS)
        if "grbl" in languages:  # no other language has arcs
            sizes += (("i", ARC_FIELDS * ARCS),)
        self.rooms = [(kind, array(kind, bytearray(4 * count))) for kind, count in sizes]
        if self._code:
            self._code.borrow(self.rooms[0][1])
        for _, language in getattr(board.get("additions"), "file_links", ()):
            from passo.memory import FILE_BYTES, empty_stream

            self.rooms += [("d", empty_stream(0)), ("b", bytearray(FILE_BYTES))]
            languages.append(language)
        self.rooms += [("b", bytearray(LINES_BYTES)) for language in languages if language == "grbl"]

    def run(self, app, port):
        self.rooms = None
        gc.threshold(-1)  # from here on only when memory is used up: a collection takes some 30 ms
        start.Start.run(self, app, port)

    def load(self, board):
        """Import what the Port of this board will ask for."""
        from passo.ports.rp2 import port

        port.load(board)

    def finish_loading(self):
        """Drop the modules that only loading needs. Returns the line that says where the code lies."""
        code, self._code = self._code, None
        if code:
            code.finish()
            self._said = code.text()
        for name in [name for name in sys.modules if name.rpartition("rp2")[2] in _OF_LOADING]:
            forget(name, True)
        return self._said

    def button(self):
        """Return "BOOTSEL" if the button is held; else None."""
        return "BOOTSEL" if rp2.bootsel_button() else None

    def port(self, board):
        """Set the clock and return the Port of a checked board. Raises RuntimeError if the chip does not take the board file's clock."""
        from passo.ports.rp2 import clock

        clock.set_mhz(board["clock_mhz"])
        forget("passo.ports.rp2.clock")
        from passo.ports.rp2.port import Port

        return Port(board)
