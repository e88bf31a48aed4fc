"""The page of a kit of two motors on a cable that speaks keys.

    machine = KeysMachine(write, tell, board)
    machine.attached(True)          # the port is open: nothing else tells that there is a board

The board never answers. The state shown is what follows from the keys that this page has sent.
"""

from host_tools.page.cabled import NoJob, cabled
from passo.protocols.page.keys import KeysPage

_Cabled = cabled(KeysPage)


class Unheard:
    """A wire without answers: as long as the port is open, all is as the page knows it."""

    def __init__(self, machine):
        self._machine = machine
        self.open = False

    def feed(self, data, now_ms):
        """The board never speaks."""

    def ask(self):
        if self.open:
            self._machine.report({"state": "idle", "error": 0})

    def drop(self):
        """Nothing waits for an answer."""


class KeysMachine(_Cabled):
    def __init__(self, write, tell, board):
        self._say_key = write
        _Cabled.__init__(self, tell, Unheard(self), NoJob(), board)

    def _write(self, key):
        self._say_key(key)

    def attached(self, is_open):
        self.wire.open = is_open
        if not is_open:
            self.lost()
