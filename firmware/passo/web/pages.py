"""The pages that look at a machine: which of them may order, and what they are told. The rules of every server: of the PC's
(host_tools/panel/server.py) and of a board's own (page_line.py).

    pages = Pages(api, key, most)
    page = pages.enter(socket, about, now_ms)   # None: there are too many. page.hello is the first message to it
    answer = pages.hear(page, text, now_ms)     # a dict; None: it is to be closed
    pages.next_state(now_ms)                    # the message for all of them that are due
    page.pace.due(pages.state, now_ms)
    pages.leave(page)                           # its jog ends
"""

import json

from micropython import const

from passo import errors
from passo.records import COUNT_MASK
from passo.web.guard import WRONG, nonce
from passo.web.pace import Pace
from passo.web.session import Session

_MESSAGES_S = const(100)  # orders a second, of one page
_SECOND_MS = const(1000)
_TOLD = const(100)  # events that wait for the next push
_DEEPEST = const(8)  # brackets in each other: an order has two


def too_deep(text):
    """True if brackets of JSON stand in each other more than _DEEPEST times: a parser that calls itself would run out of stack."""
    if text.count("{") + text.count("[") <= _DEEPEST:
        return False
    depth = 0
    quoted = escaped = False
    for letter in text:
        if escaped:
            escaped = False
        elif quoted:
            escaped = letter == "\\"
            quoted = letter != '"'
        elif letter == '"':
            quoted = True
        elif letter in "{[":
            depth += 1
            if depth > _DEEPEST:
                return True
        elif letter in "}]":
            depth -= 1
    return False


class Page:
    """One page: its session, and what it is still to be told."""

    def __init__(self, socket, session, remote):
        """`socket`: what its server knows it by; `remote`: it is on another computer."""
        self.remote = remote
        self.socket = socket
        self.session = session
        self.hello = None
        self.told = []
        self.wrong = 0
        self.second_ms = 0
        self.count = 0
        self.lease = 0  # of the jog that this page holds
        self.pace = Pace()


class Pages:
    def __init__(self, api, key, most):
        """`api`: an Api; `key`: text; `most`: pages at once."""
        self.api = api
        self._key = key
        self._most = most
        self.pages = []
        self.beat = 0
        self.state = {}  # as it is pushed

    def full(self):
        return len(self.pages) >= self._most

    def enter(self, socket, about, now_ms, remote=False):
        """A new page; `about`: what more its first message says, a dict; `remote`: it is on another computer, and the board does not
        know that. None: there are too many."""
        if self.full():
            return None
        page = Page(socket, Session(self._key, nonce()), remote)
        machine = self.api.machine
        page.hello = {"t": "hello", "nonce": page.session.nonce, "can": self.api.can(), "axes": machine.axes, "language": machine.language}
        page.hello.update(about)
        page.second_ms = now_ms
        self.pages.append(page)
        return page

    def leave(self, page):
        """A page has gone."""
        if page in self.pages:
            self.pages.remove(page)
            if page.lease:
                self.api.machine.end_jog()

    def hear(self, page, text, now_ms):
        """The answer to a message, a dict; None: the page is to be closed. A message is an order in JSON, with its proof before
        it (session.py), or without: then it moves nothing."""
        if not self._within_rate(page, now_ms):
            return None
        proven = text[:1] != "{"
        if proven:
            text = page.session.open(text)
            if text is None:
                page.wrong += 1
                return {"t": "answer", "do": "", "error": errors.NO_SESSION} if page.wrong < WRONG else None
        try:
            order = None if too_deep(text) else json.loads(text)
        except ValueError:
            return {"t": "answer", "do": "", "error": errors.ORDER_FIELD}
        looks = isinstance(order, dict) and order.get("do") == "look"
        answer = page.pace.look(order) if looks else self.api.order(order, proven, page.remote)
        if isinstance(order, dict):
            if order.get("do") == "jog" and not answer["error"]:
                page.lease = order["lease"]
            if isinstance(order.get("id"), int):
                answer["id"] = order["id"]
        return answer

    def _within_rate(self, page, now_ms):
        if (now_ms - page.second_ms) & COUNT_MASK >= _SECOND_MS:
            page.second_ms = now_ms
            page.count = 0
        page.count += 1
        return page.count <= _MESSAGES_S

    def tell(self, event):
        """Something for every page, with the next push."""
        for page in self.pages:
            if len(page.told) < _TOLD:
                page.told.append(event)

    def next_state(self, now_ms):
        """The state as it is pushed to all pages, JSON. A jog's lease counts from it: it is sent at once."""
        self.beat = self.beat % COUNT_MASK + 1
        machine = self.api.machine
        machine.beat(self.beat)
        state = dict(machine.shown())
        state["t"] = "state"
        state["beat"] = self.beat
        state["pages"] = len(self.pages)
        self.state = state
        return json.dumps(state)
