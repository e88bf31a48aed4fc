"""A whole machine in a browser's tab: the firmware on the virtual port, the plant wired to it, and the orders of the page.

    tab = Tab("router_3axis", {"part.gcode": "G0 X1\n"}, send)      # send(text): a message to the page, JSON
    tab.hear('{"do": "home", "id": 1}')                             # an order of the page, as over the network
    pause_ms = tab.turn(12)                                         # again and again: at most about 12 ms of work

It runs under MicroPython in a Web Worker (host_tools/site/worker.js), and the same under CPython. Time is the wall clock's; if the tab is too slow,
the machine lags and says so, and skips nothing. Orders need no key.
"""

import json

from host_tools.page.orders import PanelOrders
from host_tools.sim.plant import Plant
from host_tools.sim.stock import Stock
from host_tools.sim.tab_jobs import Jobs
from passo.app import App
from passo.config.boardfile import check
from passo.ports.virtual import COARSE_TICKS, FINE_TICKS, MemoryLine, VirtualPort
from passo.protocols.page.protocol import urgent_parts
from passo.records import COUNT_MASK, TICKS_PER_MS
from passo.web.pace import Pace

PUSH_MS = 50  # between two reports of the state
_SHOW_MS = 30  # between two pictures of the machine
_SPACING_TICKS = 2 * TICKS_PER_MS  # between two positions of the path drawn
_REST_MS = 5  # the worker's pause while nothing moves
_MOST_PLACES = 2000  # of one message
_START = (30, 80, 55)  # percent of each axis' travel where the machine of a page stands at first


def start(board):
    """A start from which the page shows the homing: [steps of each axis]."""
    homing = board["homing"]
    signs = [-1 if homing and axis["name"] in homing["high_end"] else 1 for axis in board["axes"]]
    return [axis["travel_steps"] * _START[n % 3] // 100 * signs[n] for n, axis in enumerate(board["axes"])]


def board_named(name):
    """Return the board file's table, which MicroPython imports as a module of the folder boards/."""
    return getattr(__import__("boards." + name), name).BOARD


class Trail:
    """The machine's positions since the page last asked, taken from the plant as its trace."""

    def __init__(self):
        self.positions = []  # flat: each axis in steps, and the tool, 0 … 1000
        self._next = 0
        self._tool = 0

    def add_row(self, tick, position, tool):
        """Note a position, at most one each _SPACING_TICKS unless the tool changes."""
        if tick < self._next and tool == self._tool:
            return
        self._next = tick + _SPACING_TICKS
        self._tool = tool
        if len(self.positions) < _MOST_PLACES:
            self.positions += position
            self.positions.append(tool)

    def take_positions(self):
        """Return the positions since the last call: flat, each axis in steps and the tool, 0…1000."""
        positions = self.positions
        self.positions = []
        return positions


class Tab:
    def __init__(self, name, jobs, send, boards=(), mode="real"):
        """`name`: a board file's; `jobs`: {name: text}; `boards`: names to choose from; `mode`: how the port's time passes."""
        board = check(board_named(name))
        self.name = name
        self._send = send
        self._boards = boards
        self.plant = Plant(board, start(board), stock=Stock(board) if Stock.can_touch(board) else None)
        self.trail = self.plant.trace = Trail()
        self._line = MemoryLine()
        self.port = VirtualPort(board, self.plant, mode, {board["links"][0]["name"]: self._line})
        self._board = board
        self.app = App(check(board_named(name)), self.port)
        self._teach = None
        self.machine = self._make_machine(board["links"][0]["protocol"])
        self.jobs = Jobs(jobs, self.machine.language)
        self.api = PanelOrders(self.machine, self.jobs, self._teach)
        self._pace = Pace()
        self._beats = self._pushed_ms = self._shown_ms = 0
        self._send_hello()

    def _make_machine(self, protocol):
        """Return the page's machine for a protocol: plotter, else grbl with teach-in."""
        if protocol == "plotter":
            from host_tools.page.plotter_machine import PlotterMachine

            return PlotterMachine(self._send_bytes, self._send_event, self._board)
        from host_tools.page.grbl_machine import GrblMachine
        from host_tools.page.teach import Teach

        machine = GrblMachine(self._send_bytes, self._send_event)
        self._teach = Teach()
        machine.watcher = self._teach.add_report
        return machine

    def _send_bytes(self, data):
        self._line.incoming += data

    def _send_event(self, event):
        self._send(json.dumps(event))

    def _send_hello(self):
        """Send the page the messages "hello" (abilities, axes, language) and "table" (steps a mm, ends of travel in steps)."""
        machine = self.machine
        told = {"t": "hello", "can": list(machine.can) + list(self.api.makes), "axes": machine.axes, "language": machine.language, "travel": machine.travel}
        told["machines"] = list(self._boards)
        self._send_event(told)
        axes = self._board["axes"]
        homing = self._board["homing"]
        high = homing["high_end"] if homing else ""
        ends = [(-1 if axis["name"] in high else 0, 0 if axis["name"] in high else 1) for axis in axes]
        self._send_event({
            "t": "table", "board": self.name, "axes": "".join([axis["name"] for axis in axes]),
            "scale": [axis["steps_per_m"] / 1000 for axis in axes],
            "low": [axes[n]["travel_steps"] * ends[n][0] for n in range(len(axes))],
            "high": [axes[n]["travel_steps"] * ends[n][1] for n in range(len(axes))],
        })  # fmt: skip

    def hear(self, text):
        """Carry out an order of the page, JSON, and send the answer."""
        order = json.loads(text)
        looks = isinstance(order, dict) and order.get("do") == "look"
        answer = self._pace.look(order) if looks else self.api.answer_order(order, True)
        if isinstance(order, dict) and "id" in order:
            answer["id"] = order["id"]
        self._send_event(answer)

    def turn(self, budget_ms):
        """Work for about `budget_ms`; return how many ms may pass until the next call."""
        port = self.port
        begun = port.link_ms()
        while True:
            before = port.now
            quantum = self.cycle()
            now = port.link_ms()
            spent = (now - begun) & COUNT_MASK
            moving = port.pending(self.app.controller.busy())
            behind = moving and port.now - before >= quantum  # else level with the wall clock
            if not behind or spent >= budget_ms:
                break
        self._push_state(now)
        return 0 if behind else 1 if moving else _REST_MS

    def cycle(self):
        """Run one cycle of the firmware's main loop, and of the page's side of the wire. Returns the most ticks that it may last."""
        port = self.port
        app = self.app
        app.poll()
        fine = app.controller.state == "home"
        port.wait(app.controller.busy(), fine)
        if self._line.outgoing:
            data = self._line.outgoing
            self._line.outgoing = b""
            self.machine.feed(data, port.link_ms())
        self.machine.poll(port.link_ms())
        return FINE_TICKS if fine else COARSE_TICKS

    def _push_state(self, now):
        """Send the page its state, each PUSH_MS if it is due, and the plant's position, trail and faults each _SHOW_MS."""
        if (now - self._pushed_ms) & COUNT_MASK >= PUSH_MS:
            self._pushed_ms = now
            self._beats += 1
            self.machine.note_beat(self._beats)
            state = dict(self.machine.page_state())
            state["t"] = "state"
            state["beat"] = self._beats
            state["pages"] = 1
            if self._teach:
                state["teaching"] = self._teach.count_positions()
            if self._pace.is_due(urgent_parts(state), now):
                self._send_event(state)
        if (now - self._shown_ms) & COUNT_MASK >= _SHOW_MS:
            self._shown_ms = now
            plant = self.plant
            self._send_event({
                "t": "machine", "at": plant.position, "tool": plant.tool, "trail": self.trail.take_positions(), "ms": self.port.machine_ms(),
                "faults": plant.error_count, "moving": self.port.pending(self.app.controller.busy()),
            })  # fmt: skip
