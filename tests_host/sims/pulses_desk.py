"""The page's side of the wire beside the router of pulse files on a virtual port, in stepped time.

    desk = PulsesDesk()
    desk.order("step", by={"x": 5}, speed=1)
    desk.settle()
"""

from lpt import Lpt
from panel_desk import Shelf
from host_tools.page.orders import PanelOrders
from host_tools.page.pulses_machine import PulsesMachine
from stepped_desk import SteppedDesk


class Bytes(Shelf):
    """Jobs in memory, whole."""

    def lines_of(self, name):
        return self.jobs[name].encode()


class PulsesDesk(SteppedDesk):
    jog_speed = 1

    def __init__(self, **config):
        self.board = board = Lpt(**config)
        SteppedDesk.__init__(self, board.app, board.port, board.line)
        self.machine = PulsesMachine(self.put, self.told.append, board.board)
        self.store = Bytes()
        self.api = PanelOrders(self.machine, self.store, self.machine.teach)
        self.settle()
        assert self.machine.state["state"] == "Idle", self.machine.state

    def job(self):
        """How the job has ended."""
        self.until(lambda state: state["job"] and state["job"]["how"] not in ("load", "run"))
        return self.machine.state["job"]

    def place(self):
        return list(self.board.world.place)
