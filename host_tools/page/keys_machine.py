"""A kit of two motors that speaks keys, as the page sees it: orders in, one state out.

    machine = KeysMachine(write, tell, board)
    machine.attached(True)          # the port is open: nothing else tells that there is a board

The board never answers. The state shown is what follows from the keys that this page has sent, from the start of the board on: both
off, clockwise, speed 1. A motor that turns while a button is held is switched off when it is let go; one that has been switched on
turns until it is switched off, as the language has it.
"""

from host_tools.page.cable_machine import CableMachine, NoJob
from passo.protocols.page.keys import KeysPage, Kit


class KeysMachine(CableMachine):
    language = "keys"
    jogs_from = KeysPage.jogs_from
    can = KeysPage.can

    def __init__(self, write, tell, board):
        CableMachine.__init__(self, tell, NoJob(), board)
        self._kit = Kit(write)
        self._open = False
        self.orders = {"motor": self._motor}

    def feed(self, data, now_ms):
        """The board never speaks."""
        self._now_ms = now_ms

    def attached(self, is_open):
        self._open = is_open
        if not is_open:
            self._lose()

    def _ask(self):
        self._asking = False
        if not self._open:
            return
        self._reported()
        self._show()
        if self.watcher:
            self.watcher(self.state)

    def _show(self):
        self.state["state"] = "Jog" if self.jog.active else "Run" if self._kit.turns() else "Idle"
        self.state["motors"] = self._kit.shown()

    def stop(self):
        """Both off."""
        self.drop_jog()
        self._kit.switch_off()
        self._show()
        return 0

    def _motor(self, order):
        error = self._kit.order(order, self)
        self._show()
        return error

    # --- while a button is held

    def _may_jog(self, direction):
        return not self.jog.active and self._kit.may_hold(direction)

    def _start_jog(self, direction, speed):
        self.jog.active = True
        self._kit.hold(direction)
        self._show()

    def _brake(self):
        self._kit.let_go()
        self._show()
