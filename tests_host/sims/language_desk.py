"""The page's side of the wire beside a board of the project on the virtual port and its plant, in stepped time.

    desk = LanguageDesk(BOARD, TorchMachine)
    desk.order("step", by={"x": 5}, speed=600)
    desk.settle()
    desk.place()                        # steps
"""

import pc_modules  # noqa: F401: before host_tools
from panel_desk import Shelf
from host_tools.page.orders import PanelOrders
from host_tools.sim.plant import Plant
from passo.app import App
from passo.config.boardfile import check
from passo.ports.virtual import MemoryLine, VirtualPort
from stepped_desk import SteppedDesk


class Path:
    """Each place that the plant comes to, and when."""

    def __init__(self):
        self.rows = []  # (tick, (steps of each axis), tool)

    def add_row(self, tick, position, tool):
        self.rows.append((tick, tuple(position), tool))


class LanguageDesk(SteppedDesk):
    def __init__(self, board, machine_of, store=None, **changes):
        """`machine_of(write, tell, board)`; `changes`: of the board file."""
        data = dict(board)
        data.update(changes)
        self.world = Plant(check(data), [0] * len(data["axes"]))
        self.trail = self.world.trace = Path()
        line = MemoryLine()
        port = VirtualPort(check(data), self.world, "stepped", {data["links"][0]["name"]: line})
        SteppedDesk.__init__(self, App(check(data), port), port, line)
        self.machine = machine_of(self.put, self.told.append, check(data))
        self.store = store or Shelf()
        self.api = PanelOrders(self.machine, self.store)
        self.settle()

    def place(self):
        return list(self.world.position)
