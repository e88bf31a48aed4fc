"""A machine with a page that its own board serves, and the same machine on a cable, with a page of a PC: one browser for both, stepped time.

    for served in (OnBoard, OnCable):
        desk = served("plotter_2014")
        page = desk.page()
        page.order("step", by={"x": 2}, speed=600)      # the answer, a dict
        desk.until(page, lambda state: state["state"] == "Idle")
        desk.place()                                    # steps

A second cable, "other", is there to take the command away: desk.take().
"""

import json

import pc_modules  # noqa: F401: before host_tools
from board_browser import KEY, Browser, Here, ServedRouter
from host_tools.page.orders import PanelOrders
from host_tools.page.pages import PanelPages
from host_tools.sim.plant import Plant
from passo.app import App
from passo.commands import HAND_OVER, Command
from passo.config.boardfile import check
from passo.ports.virtual import MemoryLine, VirtualPort
from passo.records import COUNT_MASK, TICKS_PER_MS
from passo.web.session import Session

PUSH_MS = 50
_LINK = {"name": "other", "port": "usb"}


class Trail:
    """When the plant came to a place last."""

    def __init__(self):
        self.tick = 0

    def add_row(self, tick, position, tool):
        self.tick = tick


class Desk:
    """The common part of both: the board and its plant."""

    def __init__(self, name, links, radio):
        """`links(first)`: the board file's, of its first one."""
        data = dict(getattr(__import__("boards." + name), name).BOARD)
        first = dict(data["links"][0])
        first.pop("lost", None)
        data["links"] = links(first)
        data["journal"] = None
        data["network"] = {"host": "passo"}
        self.language = first["protocol"]
        self.board = check(dict(data))
        self.world = Plant(check(dict(data)), [1000] * len(data["axes"]))
        self.trail = self.world.trace = Trail()
        lines = {"pc": MemoryLine()} if radio is None else None
        self.port = VirtualPort(check(dict(data)), self.world, "stepped", lines, radio=radio)
        self.app = App(check(dict(data)), self.port)

    def place(self):
        return list(self.world.position)

    def now_ms(self):
        return self.port.now / TICKS_PER_MS

    def stood_ms(self):
        """Return the time since the last step."""
        return (self.port.now - self.trail.tick) / TICKS_PER_MS

    def take(self):
        """The link "other" takes the command."""
        link = [link for link in self.app.links if link.name == "other"][0]
        command = Command(HAND_OVER)
        command.link = link
        assert self.app.controller.accept(command) == 0
        self.run_ms(300)

    def commands(self):
        """The name of the link that commands."""
        machine = self.app.controller.machine
        return machine.links[machine.commander]


def other(first):
    """A second cable in the first one's language."""
    link = dict(_LINK)
    link["protocol"] = first["protocol"]
    return link


class OnBoard(Desk):
    """Served by the board: real sockets."""

    mine = "page"  # name of the page's link
    now_ms = ServedRouter.now_ms
    connect = ServedRouter.connect
    run_ms = ServedRouter.run_ms

    def __init__(self, name):
        self.radio = Here()
        self.browsers = []

        def links(first):
            return [other(first), {"name": "page", "port": "page", "protocol": first["protocol"]}]

        Desk.__init__(self, name, links, self.radio)
        self.run_ms(20)

    def page(self, key=KEY):
        return Browser(self, key)


class OnCable(Desk):
    """Served by a PC: its orders, its pages and its machine, on a cable."""

    mine = "pc"

    def __init__(self, name):
        def links(first):
            first["name"] = "pc"
            return [first, other(first)]

        Desk.__init__(self, name, links, None)
        self.line = self.port.lines["pc"]
        self.browsers = []
        self._pushed = 0
        kind = self.language[:1].upper() + self.language[1:] + "Machine"
        machine = getattr(__import__("host_tools.page." + self.language + "_machine", None, None, (kind,)), kind)
        self.machine = machine(self._put, self._tell) if self.language == "grbl" else machine(self._put, self._tell, self.board)
        self.pages = PanelPages(PanelOrders(self.machine, None), KEY, 8)
        self.machine.note_port(True)
        self.run_ms(300)

    def _put(self, data):
        self.line.incoming += data

    def _tell(self, event):
        if hasattr(self, "pages"):
            self.pages.tell(event)

    def run_ms(self, milliseconds):
        end = self.port.now + int(milliseconds * TICKS_PER_MS)
        while self.port.now < end:
            self.app.cycle()
            now = int(self.now_ms()) & COUNT_MASK
            data, self.line.outgoing = self.line.outgoing, b""
            self.machine.feed(bytes(data), now)
            self.machine.poll(now)
            if (now - self._pushed) & COUNT_MASK >= PUSH_MS:
                self._pushed = now
                self._push(now)

    def _push(self, now):
        text = self.pages.next_state(now)
        for browser in self.browsers:
            page = browser.served
            told, page.told = page.told, []
            if page.pace.is_due(self.pages.version, now):
                browser._hear(text)
            for event in told:
                browser._hear(json.dumps(event))

    def stop(self):
        """Stop as the server does for a POST to /stop."""
        return self.pages.api.answer_order({"do": "stop"}, False)["error"]

    def page(self, key=KEY):
        return Tab(self, key)


class Tab(Browser):
    """A browser whose messages go to the pages at once."""

    def __init__(self, desk, key):
        self._board = desk
        self.alive = True
        self.told = []
        self.state = {}
        self.pushes = []
        self.count = self.asked = 0
        self.served = desk.pages.add_page(self, desk.pages.first_fields({}), 0)
        self.hello = json.loads(json.dumps(self.served.hello))
        self.session = Session(key, self.hello["nonce"])
        desk.browsers.append(self)

    def say(self, text):
        answer = self._board.pages.answer_message(self.served, text, int(self._board.now_ms()) & COUNT_MASK)
        if answer is None:
            self.close()
        else:
            self.told.append(json.loads(json.dumps(answer)))

    def close(self):
        self.alive = False
        self._board.browsers.remove(self)
        self._board.pages.remove_page(self.served)
