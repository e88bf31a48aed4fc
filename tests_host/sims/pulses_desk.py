"""The page's side of the wire beside the router of pulse files on a virtual port, in stepped time.

    desk = PulsesDesk()
    desk.order("step", by={"x": 5}, speed=1)
    desk.settle()
"""

from lpt import Lpt
from panel_desk import PUSH_MS, TICKS_PER_MS, Shelf
from passo.records import COUNT_MASK
from passo.web.api import Api
from passo.web.pulses_machine import PulsesMachine


class Bytes(Shelf):
    """Jobs in memory, whole."""

    def lines(self, name):
        return self.jobs[name].encode()


class PulsesDesk:
    def __init__(self, **config):
        self.board = Lpt(**config)
        self.told = []
        self.machine = PulsesMachine(self.board.put, self.told.append, self.board.board)
        self.store = Bytes()
        self.api = Api(self.machine, self.store, self.machine.teach)
        self.beats = 0
        self._pushed = 0
        self.settle()
        assert self.machine.state["state"] == "Idle", self.machine.state

    def order(self, do, **fields):
        fields["do"] = do
        return self.api.order(fields, True).get("error", 0)

    def cycle(self):
        board = self.board
        board.app.cycle()
        data = board.line.outgoing
        board.line.outgoing = b""
        now = (board.port.now // TICKS_PER_MS) & COUNT_MASK
        self.machine.feed(data, now)
        self.machine.poll(now)
        if (now - self._pushed) & COUNT_MASK >= PUSH_MS:
            self._pushed = now
            self.beats += 1
            self.machine.beat(self.beats)

    def run_ms(self, milliseconds):
        end = self.board.port.now + milliseconds * TICKS_PER_MS
        while self.board.port.now < end:
            self.cycle()

    def until(self, wanted, limit_ms=60_000):
        end = self.board.port.now + limit_ms * TICKS_PER_MS
        while not wanted(self.machine.shown()):
            assert self.board.port.now < end, self.machine.state
            self.cycle()

    def settle(self):
        """Until reports say that it stands."""
        self.run_ms(100)
        self.until(lambda state: state["state"] in ("Idle", "Hold", "Alarm"))
        self.run_ms(100)

    def job(self):
        """How the job has ended."""
        self.until(lambda state: state["job"] and state["job"]["how"] not in ("load", "run"))
        return self.machine.state["job"]

    def place(self):
        return list(self.board.world.place)

    def hold_jog(self, lease, milliseconds, **fields):
        """Hold a jog for so long, renewed each 60 ms."""
        error = self.order("jog", lease=lease, beat=self.beats, speed=1, **fields)
        assert error == 0, error
        while milliseconds > 0:
            self.run_ms(60)
            milliseconds -= 60
            assert self.order("keep", lease=lease, beat=self.beats) == 0
