"""The page of a kit of two motors on a cable that speaks keys.

    machine = KeysMachine(write, tell, board)
    machine.note_port(True)         # the port is open: a kit that is no board of Passo tells nothing else

The state shown is what follows from the keys that this page has sent.
"""

from host_tools.clients.keys_wire import KeysWire
from host_tools.page.cable_settings import with_settings
from host_tools.page.cable_page import on_cable
from passo.protocols.page.keys import KeysPage

_Cabled = with_settings(on_cable(KeysPage))


class KeysMachine(_Cabled):
    again_ms = 300
    hand_over = _Cabled._refuse_order

    def __init__(self, write, tell, board):
        _Cabled.__init__(self, tell, KeysWire(write, self), board)

    def _write_key(self, key):
        self.wire.write(key)

    def note_port(self, is_open):
        """Note that the port has been opened or closed. A kit answers nothing, so an open port counts as a link."""
        self.wire.open = is_open
        if not is_open:
            self.lose_board()
