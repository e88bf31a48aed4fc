"""The language of a page that the board serves: messages of its server in, commands out; events in, messages to pages out.

    page = Page(machine_of)
    for command in page.feed(server's message, now_ms): … event … line.write(page.reply(event))

A message of the server (web/page_line.py) is two bytes and text: the number of the page and FREE, PROVEN or GONE, and an order in JSON; or
ALL and how many pages there are: the state is wanted. A message to it is two bytes and JSON: the number of a page, 0, and the answer; TOLD,
0, and a message for all pages; ALL, and a byte that is another one once more than places have changed, and the state. Several are separated
by a line feed, which no number is.

An order is checked (orders.py), its commands are carried out one by one, and it is answered: a refusal at once is in the answer, a later
one in the log of the page.
"""

import json

from micropython import const

from passo import errors
from passo.commands import ACCEPTED, HELLO, STATUS, Command, Event
from passo.protocols.page.lease import ms_since
from passo.protocols.page.orders import Orders, order_of
from passo.records import COUNT_MASK

ALL = const(1)
TOLD = const(2)
FIRST = const(32)  # number of the first page; MOST more follow, and the one of a request without a page
MOST = const(200)
FREE = const(32)  # an order without a proof
PROVEN = const(33)
GONE = const(34)  # the page has gone
_JOG_ASK_MS = const(40)  # between two reports, while a jog goes on


class Page:
    def __init__(self, machine_of, language):
        """`machine_of(tell)`: a PageMachine, which options teach their orders; `language`: the name of its link's."""
        self._language = language
        self._messages = []  # to pages: messages to all, and answers to orders
        self._ordered = None  # the command of an order that is being carried out
        self._refused = 0  # the error of the order's commands
        self._pages = 0
        self._beat = 0
        self._version = 0
        self._shown = None
        self._wanted = False  # the state, by the pages
        self._asked_ms = 0
        self._lease_of = 0  # number of the page that holds the jog
        self._status = Command(STATUS)
        self._status.reply = Event(ACCEPTED, self._status)
        self._hello = Command(HELLO)
        self._hello.reply = Event(ACCEPTED, self._hello)
        self._jobs = None
        self.machine = machine_of(self.tell)
        self._orders = Orders(self.machine)
        self.first_message = self._orders.first_message  # hello(): a page's first message, a dict

    def add_jobs(self, jobs_of):
        """Add the jobs that the board stores. `jobs_of`: the class StoredJobs of options/jobs/language_page.py."""
        self._jobs = jobs_of(self.machine, self.tell, self._language)

    def tell(self, event):
        """Queue a message for every page, a dict."""
        self._messages.append(bytes((TOLD, FREE)) + json.dumps(event).encode())

    # --- messages to commands

    def feed(self, data, now_ms):
        """Take a message of the server, and yield its commands; the caller carries out each before it asks for the next."""
        machine = self.machine
        if not data and not (machine.jog.active or self._messages or machine.pending()):
            return ()
        machine.refresh_state(now_ms)
        if not data:
            return self._new_commands(now_ms)
        number, what = data[0], data[1]
        if number == ALL:
            self._pages = what
            self._wanted = True
            return self._poll_state()
        if what != GONE:
            return self._carry_out(number, bytes(data[2:]), what == PROVEN)
        if number == self._lease_of:
            machine.end_jog()
        return self._new_commands(now_ms)

    def _poll_state(self):
        """Yield the status command for the pages' state; before it the commands of a stored job."""
        if self._jobs:
            self._jobs.poll()
            for command in self.machine.commands():
                yield command
        yield self._status

    def _carry_out(self, number, text, proven):
        """Carry out an order of page `number`: yield its commands, then a question at which the answer is sent."""
        self._refused = 0
        try:
            order = order_of(text.decode())
        except ValueError:
            order, answer = None, {"t": "answer", "do": "", "error": errors.ORDER_FIELD}
        else:
            if proven and isinstance(order, dict) and order.get("do") in self.machine.from_here:
                yield self._status
            answer = self._orders.answer_order(order, proven)
            for command in self.machine.commands():
                self._ordered = command
                yield command
            self._ordered = None
        if self._refused and not answer.get("error", 1):
            answer["error"] = self._refused
        if isinstance(order, dict):
            if order.get("do") == "jog" and not answer["error"]:
                self._lease_of = number
            if isinstance(order.get("id"), int):
                answer["id"] = order["id"]
        self._messages.append(bytes((number, FREE)) + json.dumps(answer).encode())
        yield self._hello

    def _new_commands(self, now_ms):
        """Yield the commands that wait, and a status question each _JOG_ASK_MS of a jog."""
        machine = self.machine
        if machine.jog.active and ms_since(now_ms, self._asked_ms) >= _JOG_ASK_MS:
            self._asked_ms = now_ms
            yield self._status
        for command in machine.commands():
            yield command
        if self._messages:
            yield self._hello

    # --- events to messages

    def reply(self, event):
        """Return the messages that wait, for an answer to this page's own question; take other answers."""
        command = event.command
        if command is self._status:
            self._show_report(event.value)
        elif command is not self._hello:
            error = self.machine.take_answer(event)
            if command is self._ordered:
                self._refused = self._refused or error
            return b""
        messages, self._messages = self._messages, []
        return b"\n".join(messages)

    def push_bytes(self, event):
        """Take an event; the next feed() brings it to the pages."""
        self.machine.take_event(event)
        return b""

    def drop(self, event):
        """Forget the commands held back."""
        self.machine.drop(event)
        return b""

    def _show_report(self, report):
        """Take a report into the machine's state, and queue the state if pages want it."""
        machine = self.machine
        machine.report(report)
        if not self._wanted:
            return
        self._wanted = False
        self._beat = self._beat % COUNT_MASK + 1
        machine.note_beat(self._beat)
        state = machine.page_state()
        state["t"] = "state"
        state["beat"] = self._beat
        state["pages"] = self._pages
        shown = urgent_parts(state)
        if shown != self._shown:
            self._shown = shown
            self._version = (self._version + 1) % MOST
        self._messages.append(bytes((ALL, FIRST + self._version)) + json.dumps(state).encode())


def urgent_parts(state):
    """Return the parts of a state that pages get at once, however rarely they want reports: all but places."""
    job = state["job"]
    return state["state"], state["link"], state["alarm"], state.get("owner"), job and (job["name"], job["how"], job["pass"])
