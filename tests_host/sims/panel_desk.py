"""The page's side of the wire beside a router on a virtual port, in stepped time.

    desk = Desk()
    desk.order("step", by={"x": 5}, speed=1000)     # 0: its error
    desk.settle()
    desk.place()                                    # steps
"""

from binascii import crc32

import pc_modules  # noqa: F401: before host_tools
from check_jobs import stored_form
from host_tools.page.orders import PanelOrders
from host_tools.page.stored_jobs import StoredJobs
from host_tools.page.teach import Teach
from host_tools.page.grbl_machine import GrblMachine
from router import Machine
from stepped_desk import SteppedDesk


class Shelf:
    """Jobs in memory."""

    def __init__(self):
        self.jobs = {}

    def name_error(self, name):
        return 0

    def lines_of(self, name):
        lines = [line for line in self.jobs[name].encode().split(b"\n")]
        return [(number + 1, lines[number]) for number in range(len(lines)) if lines[number]]

    def pack_job(self, name):
        data = self.jobs[name].encode()
        return len(data), crc32(data) & 0xFFFFFFFF, stored_form(data)

    def put_job(self, name, text):
        self.jobs[name] = text
        return 0


class Desk(SteppedDesk):
    def __init__(self, guest=None, recognise=None, **changes):
        """A router, unlocked in the middle of its travel, and a page that commands it. `recognise`: Teach's; `changes`: of the board
        file."""
        self.board = board = Machine(**changes)
        SteppedDesk.__init__(self, board.app, board.port, board.line)
        self.machine = GrblMachine(self.put, self.told.append, guest)
        self.teach = Teach(recognise and (lambda points, ways: recognise(points, ways, self.scales())))
        self.machine.watcher = self.teach.add_report
        self.store = Shelf()
        self.machine.job = StoredJobs(self.machine, self.told.append, self.store.pack_job)
        self.api = PanelOrders(self.machine, self.store, self.teach)
        self.run_ms(300)
        assert self.order("unlock") == 0
        self.run_ms(300)
        assert self.machine.state["state"] == "Idle", self.machine.state

    def scales(self):
        """Steps a mm of each axis, as the board has told."""
        return [float(self.machine.settings[100 + axis]) for axis in range(len(self.machine.axes))]

    def cycle(self):
        SteppedDesk.cycle(self)
        self.machine.guest.poll()

    def settle(self):
        """Until the last report says that nothing moves."""
        self.run_ms(100)
        while self.machine.state["state"] in ("Run", "Jog", "Home") or self.machine.job.is_running():
            self.cycle()
        self.run_ms(100)

    def place(self):
        return list(self.board.world.place)
