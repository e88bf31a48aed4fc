"""The pages that a PC's server serves: orders in, answers and the state out.

    pages = PanelPages(api, key, most)
    page = pages.add_page(socket, pages.first_fields(more), now_ms)
    answer = pages.answer_message(page, text, now_ms)     # a dict; its "error" may be a SlowOrder, see finish(); None: it is to be closed
    pages.next_state(now_ms)                    # the message for all of them that are due
    page.pace.is_due(pages.version, now_ms)
"""

import json

from passo import errors
from passo.protocols.page.orders import order_of
from passo.protocols.page.protocol import urgent_parts
from passo.records import COUNT_MASK
from passo.web.pages import Pages


class ServedPages(Pages):
    """The base of all servers of a PC: it checks a message's proof and reads it; the subclass's answer_order(page, order, proven) carries it out."""

    def answer_message(self, page, text, now_ms):
        """Check and carry out a page's message. Returns the answer, a dict; None: close the page."""
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
                answer = self.answer_order(page, order, proven)
            except OSError:  # a full disk
                answer = self.not_written_answer(order)
            if isinstance(order, dict) and isinstance(order.get("id"), int):
                answer["id"] = order["id"]
        return answer


    def not_written_answer(self, order):
        """The answer to an order that failed because the disk could not be written. `order`: the order, or its first answer."""
        do = order.get("do") if isinstance(order, dict) else ""
        return {"t": "answer", "do": do if isinstance(do, str) else "", "error": errors.NOT_WRITTEN}


def _add_number(answer, said):
    """Add the message's number to the answer of a refused message: else the page takes it for the answer to its oldest order."""
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

    def first_fields(self, more):
        """The fields of the first message to a page, a dict; `more`: fields to add."""
        told = self.api.first_message()
        told.update(more)
        return told

    def remove_page(self, page):
        """Remove a page that has gone; end the jog that it holds."""
        there = page in self.pages
        Pages.remove_page(self, page)
        if there and page.lease:
            self.api.machine.end_jog()

    def answer_order(self, page, order, proven):
        """Carry out an order, see PanelOrders.begin(); note which page holds a jog."""
        answer = self.api.begin(order, proven, page.remote)
        if isinstance(order, dict) and order.get("do") == "jog" and not answer["error"]:
            page.lease = order["lease"]
        return answer

    def finish(self, page, answer, result):
        """The answer to a slow order, see PanelOrders.finish(); None: the page has gone, and the order is not carried out."""
        return self.api.finish(answer, result) if page in self.pages else None

    def next_state(self, now_ms):
        """The state for all pages, JSON, with a new beat. Send it at once: the lease of a jog counts from it."""
        self.beat = self.beat % COUNT_MASK + 1
        machine = self.api.machine
        machine.note_beat(self.beat)
        state = dict(machine.page_state())
        state["t"] = "state"
        state["beat"] = self.beat
        state["pages"] = len(self.pages)
        self.version = urgent_parts(state), state.get("queue"), state.get("recover")
        return json.dumps(state)
