"""`passo agent`'s work: one loop for all its boards, each with its own connection to the broker.

    agent = Agent()
    agent.add_board("plotter-3", "grbl", board, make_port, link)      # make_port(changed): a Port of host_tools/panel/board.py
    agent.run(stopped)                                          # until stopped() is true
    agent.close()

Boards are spoken to by the machines behind `passo panel`'s page (host_tools/page): they are asked for reports, and stopped. Nothing else
is sent to them.

A STOP is carried out by the thread of its connection, whatever the loop does meanwhile: the file of a job of one board may take it seconds. Each board has a
lock for that.
"""

import re
import selectors
import threading
import time

from host_tools.language import _
from host_tools.panel import languages
from host_tools.panel.server import clock_ms
from host_tools.shop.link import SHOP, complain_of_errors
from host_tools.shop.state_topics import StateTopics
from passo import errors

_ASK_MS = 200  # between two reports of a board
_TELL_S = 0.2  # between two looks at what has changed
_WAIT_S = 0.02
_BUTTON = "S"  # in the report's Pn: cycle start, which does nothing else at a machine that stands
_LOGGED = "[LOGGED:"  # the last line of $LOG: how many times each number, 3x109,1x201
_LATE = re.compile(rf"[:,](\d+)x{errors.WORDS_LATE}[],]")
_FIRST_S = 3.0  # a board's first report has come by then, or it is lost


class _Board:
    def __init__(self, name, language, board, make_port, link, changed, key, about):
        self.name = name
        self._link = link
        self._lock = threading.RLock()
        self.state_topics = StateTopics()
        self._port = make_port(lambda fd, opened: changed(self, fd, opened))
        self._machine = languages.create(language, board, self._port.write, self._take_event).machine
        self._machine.ask_ms = max(self._machine.ask_ms, _ASK_MS)
        self._shop = ""  # its nonce
        self.work = None
        if key and language == "grbl":
            from host_tools.shop.work import Work

            self.work = Work(key, name, about, self._machine, self._take_event, link.parcel)
        self._pressed = True  # one that is closed as the link begins may be stuck: it counts once it has been seen open
        self._begun_s = None  # not looked at yet
        self._told_s = 0.0
        self._grbl = self._logs = language == "grbl"
        self._log_due = True  # behind each motion
        link.stopped = self.stop
        link.doubled = self._yield_machine

    def stop(self):
        """Stop the machine at once, for the broker (in the connection's thread) or the person at the machine. Returns False if no board answers."""
        with self._lock:
            self._machine.stop()
            if self.work:
                self.work.note_stop()
            self.state_topics.count_stop()
            return bool(self._machine.state["link"])

    def _yield_machine(self, text):
        """Take no more orders, because another agent speaks for the machine. `text`: a sentence for the person at the machine."""
        with self._lock:
            if self.work:
                self.work.yield_machine(text)

    def note_port(self, opened):
        self._machine.note_port(opened)

    def _take_event(self, event):
        """Take an event that the machine sends to its pages."""
        if event["t"] == "log":
            for number in event["log"]:
                if number < errors.ALARM_LOCKED and number != errors.WORDS_LATE:
                    self.state_topics.count_refusal(number)
        elif event["t"] == "refused" and self.work:
            self.work.note_refusal(event["text"])
        elif event["t"] == "said" and event["text"].startswith(_LOGGED):
            late = _LATE.search(event["text"])
            self.state_topics.note_late(int(late[1]) if late else 0)

    @complain_of_errors
    def read(self):
        """Take the bytes at the board's port."""
        with self._lock:
            data = self._port.read()
            if data:
                self._machine.feed(data, clock_ms())

    @complain_of_errors
    def poll(self, now_s):
        with self._lock:
            self._poll_board(now_s)

    def complain(self, text):
        self._link.complain(text)

    def page_row(self):
        """This machine's entry of the page at the machine, a dict."""
        with self._lock:
            return {"name": self.name, **self.work.page_row(), **self.state_topics.told}

    def act(self, what):
        """See Work.act()."""
        with self._lock:
            return self.work.act(what)

    def _poll_board(self, now_s):
        """Poll port, machine and queue; each _TELL_S publish the topics that have changed, and new events."""
        self._begun_s = self._begun_s or now_s
        self._port.look()
        self._machine.poll(clock_ms())
        if self.work:
            self._poll_work(now_s)
        if now_s - self._told_s < _TELL_S:
            return
        self._told_s = now_s
        shown = self._machine.page_state()
        if not shown["link"] and now_s - self._begun_s < _FIRST_S:
            return
        self._count_events(shown)
        topics = self.state_topics.look(shown, now_s)
        for event in self.state_topics.events(time.time()):
            self._link.add_event(event)
        if self.work:
            topics = {**topics, "work": self.work.message_for(self._shop)}
        self._link.publish_topics(topics)

    def _count_events(self, shown):
        """Fill in the counters that no report has. Asks a board that speaks grbl behind each motion how often its steps were late; other languages
        report it."""
        machine, state_topics = self._machine, self.state_topics
        state_topics.scale = self._axis_scale(machine)
        state_topics.counters["retries"] = machine.retries + getattr(machine.wire, "retries", 0)
        state_topics.counters["connections"] = max(self._link.connections - 1, 0)
        if not self._grbl:
            state_topics.note_late(machine.late)
        elif not shown["link"] or not machine.is_at_rest():
            self._log_due = True
        elif self._logs and self._log_due and machine.options is not None and machine.settings and not machine.wire.count_lines(0):
            self._log_due = machine.send_line(b"$LOG", self._note_log) != 0

    def _note_log(self, error):
        self._logs = error <= 0  # else a grbl without a log
        self._log_due = error < 0

    def _axis_scale(self, machine):
        """Steps/mm of each axis, a list; empty: not known yet."""
        return [float(machine.settings[number]) for number in range(100, 104) if number in machine.settings] if self._grbl else machine.scale

    def _poll_work(self, now_s):
        """Take the shop's messages and the machine's button, and poll the work. The button counts as it closes."""
        for what, text in self._link.take_orders():
            if what == SHOP:
                self._shop = text
            else:
                self.work.take_order(text)
        state = self._machine.state
        pressed = _BUTTON in state.get("pins", "")
        if pressed and not self._pressed:
            self.work.press_button()
        self._pressed = pressed or not state["link"]
        self.work.poll(now_s)

    def close(self):
        """Close the port and the connection."""
        self._port.close()
        self._link.close()


class Agent:
    def __init__(self, figures=None):
        """`figures`: a Figures that watches the machines, or None."""
        self._figures = figures
        self._selector = selectors.DefaultSelector()
        self._boards = []

    def add_board(self, name, language, board, make_port, link, key="", about=None):
        """`board`: a board file's table; `link`: a Link of that name; `key`: the shop's, "": the machine takes no jobs; `about`: {"kind": …}, the
        machine's properties for the shop."""
        added = _Board(name, language, board, make_port, link, self._watch_port, key, about or {})
        self._boards.append(added)
        if self._figures:
            self._figures.watch_machine(name, added.state_topics)

    def machines(self):
        """The entries of the page at the machine: [{"name", "how", "job", "text", "state", "alarm", "progress", "left"}] of the machines that take
        jobs."""
        return [board.page_row() for board in self._boards if board.work]

    def carry_out(self, name, what):
        """Carry out an order of the person at the machine `name`, see Work.act(). Returns "", or a sentence that says why it was refused."""
        for board in self._boards:
            if board.name == name and board.work:
                return board.act(what)
        return _("no machine {} takes jobs here", name)

    def stop(self, name=""):
        """Stop the machine `name`, or all for "", in the calling thread, for the person there. Returns "", or a sentence that names boards without
        an answer."""
        boards = [board for board in self._boards if name in ("", board.name)]
        silent = [board.name for board in boards if not board.stop()]
        return _("no board answers at {}: use the emergency stop", ", ".join(silent)) if silent or not boards else ""

    def _watch_port(self, board, fd, opened):
        """Watch the file descriptor of a board's port from now on, or no longer."""
        board.note_port(opened)
        if opened:
            self._selector.register(fd, selectors.EVENT_READ, board)
        else:
            self._selector.unregister(fd)

    def run(self, stopped, asked=None):
        """Serve all boards until stopped() returns True. `asked`: a queue of functions that this thread is to call."""
        while not stopped():
            while asked and not asked.empty():
                asked.get()()
            for key, _events in self._selector.select(_WAIT_S):
                key.data.read()
            now_s = time.monotonic()
            for board in self._boards:
                board.poll(now_s)

    def close(self):
        """Close all boards and connections."""
        for board in self._boards:
            board.close()
        self._selector.close()
