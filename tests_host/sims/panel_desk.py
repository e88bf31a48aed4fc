"""The page's side of the wire beside a router on a virtual port, in stepped time: what a server does, without a network.

    desk = Desk()
    desk.order("step", by={"x": 5}, speed=1000)     # 0: its error
    desk.settle()
    desk.place()                                    # steps
"""

from binascii import crc32

from check_jobs import stored_form
from passo.records import COUNT_MASK
from passo.web.api import Api
from passo.web.grbl_machine import GrblMachine
from passo.web.stored import StoredJobs
from passo.web.teach import Teach
from router import Machine

TICKS_PER_MS = 12_500
PUSH_MS = 50


class Shelf:
    """Jobs in memory."""

    def __init__(self):
        self.jobs = {}

    def name_error(self, name):
        return 0

    def lines(self, name):
        lines = [line for line in self.jobs[name].encode().split(b"\n")]
        return [(number + 1, lines[number]) for number in range(len(lines)) if lines[number]]

    def packed(self, name):
        data = self.jobs[name].encode()
        return len(data), crc32(data) & 0xFFFFFFFF, stored_form(data)

    def put(self, name, text):
        self.jobs[name] = text
        return 0


class Desk:
    def __init__(self, guest=None, recognise=None, **changes):
        """A router, unlocked in the middle of its travel, and a page that commands it. `recognise`: Teach's; `changes`: of the board
        file."""
        self.board = Machine(**changes)
        self.told = []
        self.machine = GrblMachine(self.board.put, self.told.append, guest)
        self.teach = Teach(recognise and (lambda points, ways: recognise(points, ways, self.scales())))
        self.machine.watcher = self.teach.see
        self.store = Shelf()
        self.machine.job = StoredJobs(self.machine, self.told.append, self.store.packed)
        self.api = Api(self.machine, self.store, self.teach)
        self.beats = 0
        self._pushed = 0
        self.run_ms(300)
        assert self.order("unlock") == 0
        self.run_ms(300)
        assert self.machine.state["state"] == "Idle", self.machine.state

    def scales(self):
        """Steps a mm of each axis, as the board has told."""
        return [float(self.machine.settings[100 + axis]) for axis in range(len(self.machine.axes))]

    def now_ms(self):
        return (self.board.port.now // TICKS_PER_MS) & COUNT_MASK

    def order(self, do, proven=True, **fields):
        """The error of an order's answer; 0: none."""
        return self.ask(do, proven, **fields).get("error", 0)

    def ask(self, do, proven=True, **fields):
        fields["do"] = do
        return self.api.order(fields, proven)

    def cycle(self):
        board = self.board
        board.app.cycle()
        data = board.line.outgoing
        board.line.outgoing = b""
        now = self.now_ms()
        self.machine.feed(bytes(data), now)
        self.machine.poll(now)
        self.machine.guest.poll()
        if (now - self._pushed) & COUNT_MASK >= PUSH_MS:
            self._pushed = now
            self.beats += 1
            self.machine.beat(self.beats)

    def run_ms(self, milliseconds):
        end = self.board.port.now + milliseconds * TICKS_PER_MS
        while self.board.port.now < end:
            self.cycle()

    def settle(self):
        """Until the last report says that nothing moves."""
        self.run_ms(100)
        while self.machine.state["state"] in ("Run", "Jog", "Home") or self.machine.job.running():
            self.cycle()
        self.run_ms(100)

    def place(self):
        return list(self.board.world.place)

    def hold_jog(self, lease, milliseconds, **fields):
        """Hold a jog for so long, renewed each 60 ms."""
        assert self.order("jog", lease=lease, beat=self.beats, **fields) == 0
        while milliseconds > 0:
            self.run_ms(60)
            milliseconds -= 60
            assert self.order("keep", lease=lease, beat=self.beats) == 0
