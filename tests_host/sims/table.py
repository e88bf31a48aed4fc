"""A table with two barriers, for the virtual port: it decodes pins by the drive's own tables, which the drives' checks
hold against the documents. Small enough for MicroPython; host_tools.sim.plant is the full model.

    table = Table(start=(100, 80))
    machine = Machine(table)
    machine.ask(packet(COMMANDS["ORIGIN"]))
"""

from boards.plotter_2014 import BOARD
from passo.app import App
from passo.config.boardfile import check
from passo.machine_builder import make_drive
from passo.ports.virtual import Nothing, VirtualPort
from passo.protocols.plotter.host import COMMANDS, packet, status_from

EDGE = 30  # steps from the table's end at which a barrier is interrupted


class Table(Nothing):
    def __init__(self, start=(100, 80), fault=None, noise=0):
        """`fault`: {barrier: level it always reads}; `noise`: of this many moments of reading, one is wrong for all readers (0: none)."""
        self.place = list(start)
        self.start = list(start)
        self.pen = 0
        self.path = None  # set it to []: (x, y, pen) after each step, in the table's coordinates
        self.steps = 0
        self.lowest = list(start)
        self.fault = fault or {}
        self.noise = noise
        self._count = 0
        self._read_at = None
        self._before = 0
        self._levels_mask = 0

    def attach(self, tick, names, levels):
        self.layout, self.drive, self.off = make_drive(check(BOARD))
        self._before = self.drive.levels()

    def edges(self, tick, levels, changed):
        self.pen = 1 if levels & self.layout.tool_mask else 0
        coils = levels & (self.layout.tool_mask - 1)
        if coils == self.off:
            return
        moved = False
        for axis in range(2):
            step = self.drive.step_between(axis, self._before, coils)
            self.place[axis] += step
            self.lowest[axis] = min(self.lowest[axis], self.place[axis])
            moved = moved or step
        self._before = coils
        if moved:
            self.steps += 1
            if self.path is not None:
                self.path.append((self.place[0], self.place[1], self.pen))

    def input(self, tick, name):
        if name in self.fault:
            return self.fault[name]
        level = 1 if self.place["xy".find(name[-1])] <= EDGE else 0
        if self.noise:
            if tick != self._read_at:
                self._read_at = tick
                self._count += 1
            if self._count % self.noise == 0:
                return 1 - level
        return level


class Machine:
    """The whole firmware of the 2014 plotter, stepped, with its serial line in memory."""

    def __init__(self, table=None, **changes):
        board = check(BOARD)
        board.update(changes)
        self.table = table or Table()
        self.port = VirtualPort(board, self.table)
        self.app = App(check(board), self.port)
        self.line = self.port.lines["pc"]

    def send(self, name, x=0, y=0):
        self.line.incoming += packet(COMMANDS[name], x, y)

    def cycles(self, count):
        for _ in range(count):
            self.app.cycle()
        return self.answer()

    def answer(self):
        data = self.line.outgoing
        self.line.outgoing = b""
        return data

    def ask(self, name, x=0, y=0, turns=100_000):
        """Send a packet and run until it is answered; b"" if it is not within `turns`."""
        self.send(name, x, y)
        while turns and not self.line.outgoing:
            self.app.cycle()
            turns -= 1
        return self.answer()

    def status(self):
        return status_from(self.ask("STATUS"))

    def draw(self, points):
        """Send (pen, x, y) points and END; run to DONE."""
        for pen, x, y in points:
            assert self.ask("LINE" if pen else "MOVE", x, y) == b"n"
        assert self.ask("END") == b"d"
