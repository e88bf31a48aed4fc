"""A link that pages speak on: served by the board itself, to the app a serial line like any other.

    line = PageLine(server, machine_of, radio.key, clock_ms)
    line.join(link, controller)
    line.read(), line.write(data), line.any()

What a page orders becomes bytes of the link's language, by the same code that `passo panel` has on a PC; so the machine's rules
are those of a cable. The link takes the command by hand-over at rest, and gives it back to the first cable. Jobs are those that the
board stores (board_jobs.py), if its board file has any: to stream one takes the room of a PC.
"""

import json

from micropython import const

from passo.commands import HAND_OVER, Command
from passo.errors import LATER, BUSY
from passo.records import COUNT_MASK
from passo.web.api import Api
from passo.web.pages import Pages
from passo.web.websocket import TEXT, frame

_ASK_MS = const(170)  # between two reports, while no jog goes on. Polls and passes add up to 30: five a second, or more
_POLL_MS = const(20)  # between two looks at what is to be done, while no jog goes on
_PAGES = const(4)  # at once: each takes 2 to 4 kB
_FRESH_MS = const(150)  # between two pushes, each behind a report
_LATE_MS = const(280)  # then the state is pushed without a report


class PageLine:
    browser = True  # its WebSockets are opened by a page of this server

    def __init__(self, server, machine_of, key, clock_ms, jobs_of=None):
        """`server`: a Server; `machine_of(write, tell)`: what speaks the link's language; `key`: text; `clock_ms()`: the links' clock;
        `jobs_of`: BoardJobs, of a board with stored jobs."""
        self._server = server
        self._clock_ms = clock_ms
        self._said = b""
        self._fresh = False  # a report has come since the last push
        self._pushed_ms = self._polled_ms = 0
        self._seat = self._controller = self._jobs = None
        self._jobs_of = jobs_of
        self.machine = machine_of(self._say, self._tell)
        self.machine.watcher = self._reported
        if hasattr(self.machine, "attached"):  # of a language in which the board never speaks
            self.machine.attached(True)
        self.machine.ask_ms = _ASK_MS
        self.pages = Pages(BoardApi(self.machine, self._give, jobs_of is not None), key, _PAGES)
        server.sockets[b"/ws"] = self
        server.calls[b"/stop"] = self._stop

    def join(self, link, controller):
        self._seat = Seat(link.number, link.name)
        self._controller = controller
        if self._jobs_of:
            self._jobs = self._jobs_of(controller, self._seat, self.machine, self._tell, self.machine.language)

    # --- the app's side

    def any(self):
        return bool(self._said)

    def read(self):
        """Bytes for the language."""
        now_ms = self._clock_ms()
        self._server.poll(now_ms)
        if self.pages.pages and (self._fresh or self.machine.jog.active or (now_ms - self._polled_ms) & COUNT_MASK >= _POLL_MS):
            self._polled_ms = now_ms
            machine = self._controller.machine
            commander = machine.commander if machine.lender < 0 else machine.lender
            self.machine.state["owner"] = "page" if commander == self._seat.number else "guest"
            self.machine.poll(now_ms)
            passed = (now_ms - self._pushed_ms) & COUNT_MASK
            if passed >= (_FRESH_MS if self._fresh else _LATE_MS):
                self._push(now_ms)
        said = self._said
        self._said = b""
        return said

    def write(self, data):
        self.machine.feed(bytes(data), self._clock_ms())

    def watched(self):
        return self._server.watched()

    def close(self):
        self._server.close()

    # --- the machine's

    def _say(self, data):
        self._said += data

    def _tell(self, event):
        self.pages.tell(event)

    def _reported(self, state):
        self._fresh = True

    def _give(self, to):
        """Hand the command over. Returns 0 or an error."""
        command = Command(HAND_OVER, value=1 if to == "guest" else 0)
        command.link = self._seat
        error = self._controller.accept(command)
        return BUSY if error == LATER else error

    # --- the pages'

    def _push(self, now_ms):
        self._pushed_ms = now_ms
        self._fresh = False
        if self._jobs:
            self._jobs.poll()
        state = frame(TEXT, self.pages.next_state(now_ms).encode())
        for page in list(self.pages.pages):
            if page.socket.sending():
                continue  # it is slower than this: the next state is as good
            told = page.told
            page.told = []
            said = b"".join([packed(event) for event in told])
            if page.pace.due(self.pages.state, now_ms):
                said = state + said
            if said:
                self._server.send(page.socket, said)

    def open(self, connection, now_ms):
        """A page has come. Returns what it is told first; None: there are too many. One that has proven nothing makes room."""
        if self.pages.full():
            for page in self.pages.pages:
                if not page.session.opened:
                    self._server.drop(page.socket)
                    break
        page = self.pages.enter(connection, {}, now_ms)
        if page is None:
            return None
        hello = packed(page.hello)
        page.hello = None  # it has done its duty
        return hello

    def heard(self, connection, data, now_ms):
        """A message. False: the page is to be closed. Raises ValueError if it is no text."""
        page = self._page_of(connection)
        answer = self.pages.hear(page, data.decode(), now_ms) if page else None
        if answer is not None:
            self._server.send(connection, packed(answer))
        return answer is not None

    def gone(self, connection):
        self.pages.leave(self._page_of(connection))

    def _page_of(self, connection):
        for page in self.pages.pages:
            if page.socket is connection:
                return page
        return None

    def _stop(self):
        return json.dumps(self.pages.api.order({"do": "stop"}, False)).encode()


def packed(message):
    """The frame of a message, a dict."""
    return frame(TEXT, json.dumps(message).encode())


class BoardApi(Api):
    """The API without what a board leaves out, and with links that command by turns."""

    def __init__(self, machine, give, keeps):
        """`keeps`: the board stores jobs."""
        Api.__init__(self, machine)
        self._hand_over = give
        self._keeps = keeps

    def can(self):
        return Api.can(self) + ["command"] + (["kept"] if self._keeps else [])

    def _give(self, order):
        return self._hand_over("guest" if order.get("to") == "guest" else "page")


class Seat:
    """Who asks for the command, and for stored jobs: the link itself, but for the answer, which is no word of its language."""

    def __init__(self, number, name):
        self.number = number
        self.name = name
        self.protocol = self
        self.heard = None  # heard(event): an answer

    def reply(self, event):
        if self.heard:
            self.heard(event)
        return b""
