"""The pages that a PC's server serves: orders in, answers and the state out.

    pages = PanelPages(api, key, most)
    page = pages.enter(socket, pages.about(more), now_ms)
    answer = pages.hear(page, text, now_ms)     # a dict; its "error" may be a SlowOrder, see finish(); None: it is to be closed
    pages.next_state(now_ms)                    # the message for all of them that are due
    page.pace.due(pages.version, now_ms)
"""

import json

from passo import errors
from passo.protocols.page.orders import order_of
from passo.protocols.page.protocol import urgent_parts
from passo.records import COUNT_MASK
from passo.web.pages import Pages


class ServedPages(Pages):
    """What all servers of a PC share: a message is proven and read here, carried out by `order(page, order, proven)` of the class behind."""

    def hear(self, page, text, now_ms):
        """The answer to a message, a dict; None: the page is to be closed."""
        said = text
        text, proven = self.open(page, text, now_ms)
        if text is None:
            return proven and _add_number(proven, said)
        try:
            order = order_of(text)
        except ValueError:
            return {"t": "answer", "do": "", "error": errors.ORDER_FIELD}
        answer = self.look(page, order)
        if answer is None:
            try:
                answer = self.order(page, order, proven)
            except OSError:  # a full disk
                answer = self.unwritten(order)
            if isinstance(order, dict) and isinstance(order.get("id"), int):
                answer["id"] = order["id"]
        return answer


    def unwritten(self, order):
        """The answer to an order, or to its first answer, on which the disk has failed."""
        do = order.get("do") if isinstance(order, dict) else ""
        return {"t": "answer", "do": do if isinstance(do, str) else "", "error": errors.NOT_WRITTEN}


def _add_number(answer, said):
    """An answer to a message that was not looked at, with the message's number: a slower order may be the oldest that waits for one."""
    try:
        order = order_of(said.split(".", 2)[-1])
    except ValueError:
        return answer
    if isinstance(order, dict) and isinstance(order.get("id"), int):
        answer["id"] = order["id"]
    return answer


class PanelPages(ServedPages):
    def __init__(self, api, key, most):
        """`api`: a PanelOrders; `key`: text; `most`: pages at once."""
        Pages.__init__(self, key, most)
        self.api = api
        self.beat = 0
        self.version = None  # another one once more than places have changed

    def about(self, more):
        """What the first message to a page says, with `more`."""
        told = self.api.hello()
        told.update(more)
        return told

    def leave(self, page):
        there = page in self.pages
        Pages.leave(self, page)
        if there and page.lease:
            self.api.machine.end_jog()

    def order(self, page, order, proven):
        answer = self.api.begin(order, proven, page.remote)
        if isinstance(order, dict) and order.get("do") == "jog" and not answer["error"]:
            page.lease = order["lease"]
        return answer

    def finish(self, page, answer, result):
        """The answer to an order whose work has given `result`; None: who asked has gone, and nothing is done."""
        return self.api.finish(answer, result) if page in self.pages else None

    def next_state(self, now_ms):
        """The state as it is pushed to all pages, JSON. A jog's lease counts from it: it is sent at once."""
        self.beat = self.beat % COUNT_MASK + 1
        machine = self.api.machine
        machine.beat(self.beat)
        state = dict(machine.shown())
        state["t"] = "state"
        state["beat"] = self.beat
        state["pages"] = len(self.pages)
        self.version = urgent_parts(state), state.get("queue"), state.get("recover")
        return json.dumps(state)
