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
    """What all servers of a PC share: a message is proven and read here, carried out by `answer_order(page, order, proven)` of the class behind."""

    def answer_message(self, page, text, now_ms):
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
                answer = self.answer_order(page, order, proven)
            except OSError:  # a full disk
                answer = self.not_written_answer(order)
            if isinstance(order, dict) and isinstance(order.get("id"), int):
                answer["id"] = order["id"]
        return answer


    def not_written_answer(self, order):
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

    def first_fields(self, more):
        """What the first message to a page says, with `more`."""
        told = self.api.first_message()
        told.update(more)
        return told

    def remove_page(self, page):
        there = page in self.pages
        Pages.remove_page(self, page)
        if there and page.lease:
            self.api.machine.end_jog()

    def answer_order(self, page, order, proven):
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
        machine.note_beat(self.beat)
        state = dict(machine.page_state())
        state["t"] = "state"
        state["beat"] = self.beat
        state["pages"] = len(self.pages)
        self.version = urgent_parts(state), state.get("queue"), state.get("recover")
        return json.dumps(state)
