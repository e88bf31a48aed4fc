"""The page's side of the wire beside a board of the project on the virtual port and its plant, in stepped time.

    desk = LanguageDesk(BOARD, TorchMachine)
    desk.order("step", by={"x": 5}, speed=600)
    desk.settle()
    desk.place()                        # steps
"""

import sys

from panel_desk import PUSH_MS, TICKS_PER_MS, Shelf
from passo.app import App
from passo.config.boardfile import check
from passo.ports.virtual import MemoryLine, VirtualPort
from passo.records import COUNT_MASK
from passo.web.api import Api

if sys.implementation.name == "micropython":  # the package's own start is for a PC: here it is only a folder

    class _Folder:
        __path__ = __file__.rsplit("/", 3)[0] + "/host_tools"

    sys.modules["host_tools"] = _Folder
    sys.path.insert(0, _Folder.__path__ + "/site")  # with a random of what the plant takes
from host_tools.sim.plant import Plant  # noqa: E402


class Path:
    """Each place that the plant comes to, and when."""

    def __init__(self):
        self.rows = []  # (tick, (steps of each axis), tool)

    def row(self, tick, position, tool):
        self.rows.append((tick, tuple(position), tool))


class LanguageDesk:
    def __init__(self, board, machine_of, store=None, **changes):
        """`machine_of(write, tell, board)`; `changes`: of the board file."""
        data = dict(board)
        data.update(changes)
        self.world = Plant(check(data), [0] * len(data["axes"]))
        self.trail = self.world.trace = Path()
        self.line = MemoryLine()
        self.port = VirtualPort(check(data), self.world, "stepped", {data["links"][0]["name"]: self.line})
        self.app = App(check(data), self.port)
        self.told = []
        self.machine = machine_of(self._put, self.told.append, check(data))
        self.store = store or Shelf()
        self.api = Api(self.machine, self.store)
        self.beats = 0
        self._pushed = 0
        self.settle()

    def _put(self, data):
        self.line.incoming += data

    def order(self, do, **fields):
        fields["do"] = do
        return self.api.order(fields, True).get("error", 0)

    def now_ms(self):
        return (self.port.now // TICKS_PER_MS) & COUNT_MASK

    def cycle(self):
        self.app.cycle()
        data = self.line.outgoing
        self.line.outgoing = b""
        now = self.now_ms()
        self.machine.feed(data, now)
        self.machine.poll(now)
        if (now - self._pushed) & COUNT_MASK >= PUSH_MS:
            self._pushed = now
            self.beats += 1
            self.machine.beat(self.beats)

    def run_ms(self, milliseconds):
        end = self.port.now + milliseconds * TICKS_PER_MS
        while self.port.now < end:
            self.cycle()

    def until(self, wanted, limit_ms=60_000):
        end = self.port.now + limit_ms * TICKS_PER_MS
        while not wanted(self.machine.shown()):
            assert self.port.now < end, self.machine.state
            self.cycle()

    def settle(self):
        """Until reports say that it stands."""
        self.run_ms(150)
        self.until(lambda state: state["state"] in ("Idle", "Hold", "Alarm"))
        self.run_ms(100)

    def place(self):
        return list(self.world.position)

    def hold_jog(self, lease, milliseconds, **fields):
        """Hold a jog for so long, renewed each 60 ms."""
        error = self.order("jog", lease=lease, beat=self.beats, speed=600, **fields)
        assert error == 0, error
        while milliseconds > 0:
            self.run_ms(60)
            milliseconds -= 60
            assert self.order("keep", lease=lease, beat=self.beats) == 0
