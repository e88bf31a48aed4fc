"""The start on stock MicroPython: bytecode stays in flash, machine code is in memory, and the largest arrays are made before any of it is
imported. Modules that only the start needs are dropped."""

import gc
import sys

from micropython import const

from passo.ports.rp2.stock import flash_code

flash_code.begin()  # modules imported from here on stay in flash

from passo.ports.rp2.stock import pieces  # isort: skip
from passo.ports.rp2 import start  # isort: skip

_COLLECT = const(56_000)  # bytes taken while code is loaded until garbage is collected: objects that stay lie close together
_OF_LOADING = (".flash_code", ".flash_names", "_flash_names", ".reserve")  # the parts after "stock" in the names of modules


class Start(start.Start):
    fits = True

    def begin_loading(self):
        """Collect garbage early while code is loaded, which then lies close together."""
        gc.threshold(_COLLECT)
        self._code = flash_code.code

    def load(self, board):
        """Drop what only the check of the board file needs, make the largest arrays and the buffers of links and files, then import the port."""
        start.drop_check()
        from passo.ports.rp2.stock.reserve import reserve

        self._code.borrow(reserve(board))
        start.Start.load(self, board)

    def finish_loading(self):
        """Drop the modules that only loading needs. Returns the line that says where the code lies."""
        code, self._code = self._code, None
        if code:
            code.finish()
            self._said = code.text()
            for name in [name for name in sys.modules if name.rpartition("stock")[2] in _OF_LOADING]:
                start.drop(name)
        return self._said

    def port(self, board):
        """Return the Port. The app comes next: the builder is dropped before its last step, the links of stored jobs."""
        made = start.Start.port(self, board)
        pages = getattr(made, "pages", None)
        if pages:  # of a journal: later there may be no memory to make them
            pages.make_files()
        App = sys.modules["passo.app"].App
        real = App.add_file_links

        def add_file_links(*made):
            start.drop_builder()
            setattr(App, "add_file_links", real)
            real(*made)

        setattr(App, "add_file_links", add_file_links)
        return made

    def settle(self, app):
        """Take back arrays that nobody has asked for, and drop this module, too."""
        pieces.offer(())
        settle = start.Start.settle
        globals().clear()  # of this module, too, nothing is needed any more
        settle(self, app)
