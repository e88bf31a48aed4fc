"""The pages that look at a machine: which of them may order, and their messages. The rules of every server: of the PC's
(host_tools/page/pages.py) and of a board's own (page_line.py).

    pages = Pages(key, most)
    page = pages.add_page(socket, hello, now_ms)       # None: there are too many. page.hello is the first message to it
    text, proven = pages.open(page, message, now_ms)    # of an order; text None: `proven` is the answer, None: the page is to be closed
    pages.tell(event)                               # with the next state
    page.pace.is_due(version, now_ms)
    pages.refuse_older(b"NONCE.COUNT")                  # a STOP has come beside a page's WebSocket
    pages.remove_page(page)                         # its jog is to end
"""

from micropython import const

from passo import errors
from passo.records import COUNT_MASK
from passo.web.guard import WRONG, make_nonce
from passo.web.pace import Pace
from passo.web.session import Session

_MESSAGES_S = const(100)  # orders a second, of one page
_SECOND_MS = const(1000)
_TOLD = const(100)  # events that wait for the next push
_DIGITS = const(8)  # of a count
_UNDER_WAY = const(100)  # orders of a page that has not proven them yet, at most: a STOP that names a later one is not the page's


def refusal_answer(error):
    """The answer to an order that was refused unread. It has no number: the page takes it for its oldest order's."""
    return {"t": "answer", "do": "", "error": error}


class Page:
    """One page: its session, and its messages still to be sent."""

    def __init__(self, socket, session, remote):
        """`socket`: the server's own name for it; `remote`: it is on another computer."""
        self.remote = remote
        self.socket = socket
        self.session = session
        self.number = 0
        self.hello = None
        self.told = []
        self.wrong = 0
        self.before = 0  # orders up to this count are older than a STOP that has overtaken them
        self.second_ms = 0
        self.count = 0
        self.lease = 0  # of the jog that this page holds
        self.pace = Pace()


class Pages:
    def __init__(self, key, most):
        """`key`: text; `most`: pages at once."""
        self._key = key
        self._most = most
        self.pages = []

    def is_full(self):
        return len(self.pages) >= self._most

    def add_page(self, socket, hello, now_ms, remote=False):
        """Add a page and return it; None: there are too many. `hello`: the fields of its first message beside the nonce, a dict; `remote`: it is on
        another computer, and the board does not know that."""
        if self.is_full():
            return None
        page = Page(socket, Session(self._key, make_nonce()), remote)
        page.hello = {"t": "hello", "nonce": page.session.nonce}
        page.hello.update(hello)
        page.second_ms = now_ms
        self.pages.append(page)
        return page

    def remove_page(self, page):
        if page in self.pages:
            self.pages.remove(page)

    def open(self, page, text, now_ms):
        """(the order's text, whether it is proven) of a message: an order in JSON, with its proof before it (session.py), or without one. If it is
        refused, (None, answer), and (None, None) if the page must be closed."""
        if (now_ms - page.second_ms) & COUNT_MASK >= _SECOND_MS:
            page.second_ms = now_ms
            page.count = 0
        page.count += 1
        if page.count > _MESSAGES_S:
            return None, None
        if text[:1] == "{":
            return text, False
        text = page.session.open(text)
        if text is None:
            page.wrong += 1
            return None, refusal_answer(errors.NO_SESSION) if page.wrong < WRONG else None
        if page.session.count <= page.before:
            return None, refusal_answer(errors.STOPPED)
        return text, True

    def refuse_older(self, said):
        """Refuse the orders that a page sent before its STOP, which came by a way of its own and may be the quicker one. `said`: the
        page's nonce and how many orders it has sent, b"NONCE.COUNT". Any reader of the wire can send this: the barrier never falls, and
        stays within _UNDER_WAY of the last order that the page has proven."""
        nonce, _, count = said.partition(b".")
        if not count.isdigit() or len(count) > _DIGITS:
            return
        count = int(count)
        for page in self.pages:
            if page.session.nonce.encode() == nonce and page.before < count <= page.session.count + _UNDER_WAY:
                page.before = count

    def look(self, page, order):
        """Return the answer to an order that sets how often the page gets the state; None: it is another order."""
        if not isinstance(order, dict) or order.get("do") != "look":
            return None
        answer = page.pace.look(order)
        if isinstance(order.get("id"), int):
            answer["id"] = order["id"]
        return answer

    def tell(self, event):
        """Queue an event for every page, for the next push; a page keeps _TOLD at most."""
        for page in self.pages:
            if len(page.told) < _TOLD:
                page.told.append(event)
