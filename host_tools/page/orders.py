"""The orders of a page to a PC's server, beside those of every machine (passo/protocols/page/orders.py): jobs that are streamed, teach-in, and
another machine. Tool on, run and resume from another computer want somebody at the machine, if the board file names an input for that.

    api = PanelOrders(machine, store, teach, choose)
"""

from host_tools.page.slow_order import SlowOrder, is_refusal
from host_tools.page.set_up import SetUp
from host_tools.page.presence import starts_motion
from host_tools.page.queue import Queue
from passo import errors
from passo.protocols.page.orders import Orders, Wrong, number_field, text_field

_MOST_NUMBER = 0x1FFFFFFF
_PASSES = 100
_MOST_PLACED = 100_000  # mm


class PanelOrders(Orders):
    def __init__(self, machine, store, teach=None, choose=None, proving=None, own=None):
        """`store`: the jobs: job_names(), lines_of(name), text_piece(name, at), facts_of(name, settings), add_piece(name, at, piece, last), put_job(name, text), remove_job(name); they
        return the number of an error if they fail; None: there are no jobs here. `choose(name)`: another board file, and a new start; None: there is
        no choice. `proving`: its carry_out(order) and end() begin and end a proof of the board; None: there is no proof here. `own`: its
        carry_out(order) makes and changes board files of the user's own; None: there are none here."""
        Orders.__init__(self, machine)
        self.store = store
        self.teach = teach
        self._choose = choose
        if choose:
            self._orders["machine"] = self._order_machine
        self._proving = proving
        if proving:
            self._orders["prove"] = proving.carry_out
        self._own = own
        if own:
            self._orders["board"] = self._order_board
        self.makes = ()  # orders of the set-up that this server computes
        if store and machine.language == "grbl":
            made = SetUp(machine, store).orders()
            self._orders.update(made)
            self.makes = tuple(made)
        if store:
            self._orders.update({
                "job_text": self._job_text, "job_about": self._job_about, "job_part": self._job_part,
                "job_remove": self._job_remove, "run": self._order_run, "teach": self._order_teach,
            })  # fmt: skip
        self._stops = 0  # how often somebody has said STOP
        self._queue = None
        if hasattr(store, "tools_of"):  # a tab's jobs are not looked at
            self._queue = Queue(machine, self._look_through, self._run_whole)
            self._orders["queue"] = self._queue.carry_out
        if hasattr(store, "place_job"):
            self._orders["job_place"] = self._job_place

    def page_orders(self):
        lacking = (() if self.store else ("jobs", "single")) + (() if self.teach else ("teach",))
        return [what for what in self.machine.can if what not in lacking] + (["queue"] if self._queue else []) + (["prove"] if self._proving else []) + (["board"] if self._own else []) + list(self.makes)

    def poll(self):
        """Begin the next job of the queue if it is time. Call it some hundred times a second."""
        if self._queue:
            self._queue.poll()

    def answer_order(self, order, proven, remote=False):
        """The answer to an order, a dict; waits for a SlowOrder's work. `proven`: its session has the key; `remote`: it comes from another
        computer, and the board does not know that."""
        answer = self.begin(order, proven, remote)
        later = answer.get("error")
        return self.finish(answer, later.work()) if isinstance(later, SlowOrder) else answer

    def begin(self, order, proven, remote=False):
        """The answer to an order without waiting: if it takes a moment, its "error" is a SlowOrder, and finish() returns the answer."""
        known = isinstance(order, dict)
        if known and order.get("do") == "stop":
            self._stops += 1
            if self._queue:
                self._queue.note_stop()
            if self._proving:
                self._proving.end()
        error = self.machine.presence_error() if remote and proven and known and starts_motion(order) else 0
        answer = self._plain_answer(order["do"], error) if error else self._full_answer(order, Orders.answer_order(self, order, proven))
        if known and order.get("do") == "stop" and not answer["error"] and not self.machine.state["link"]:
            answer["error"] = errors.NO_ANSWER  # it is sent if there is a port, but nobody says that it has arrived
        return answer

    def _full_answer(self, order, found):
        """The complete answer for the dict `found` that an order returned: a message with "t", or the fields of a refusal, see is_refusal()."""
        if "t" in found:
            return found
        answer = self._plain_answer(order["do"], found["error"])
        answer.update(found)
        return answer

    def finish(self, answer, result):
        """The answer to a slow order: `answer` from begin(), `result` of its work."""
        found = answer["error"].then(result)
        if not isinstance(found, dict):
            answer["error"] = found
            return answer
        if "t" not in found:
            answer.update(found)
            return answer
        if "id" in answer:
            found["id"] = answer["id"]
        return found

    def _order_machine(self, order):
        return self.machine.busy_error() or self._choose(text_field(order, "name", 64))

    def _order_board(self, order):
        """Read or change a board file of the user's own: `what` is get, new, set, back or remove."""
        if text_field(order, "what", 8) != "get" and self.machine.busy_error():
            return self.machine.busy_error()
        return SlowOrder(lambda: self._own.carry_out(order), self._own.finish)

    # --- jobs

    def _order_jobs(self, order):
        return {"t": "jobs", "jobs": self.store.job_names() if self.store else []}

    def _job_text(self, order):
        """Return a piece of a job's text from offset `at` on, with the job's size, or the number of an error."""
        name = text_field(order, "name", 64)
        at = int(number_field(order, "at", 0, _MOST_NUMBER, 0))
        found = self.store.text_piece(name, at)
        return found if isinstance(found, int) else {"t": "job_text", "name": name, "at": at, "text": found[0], "size": found[1]}

    def _job_about(self, order):
        """Estimate a job: time, tools, pauses. Only at rest, because it takes a moment. Returns a SlowOrder or an error."""
        name = text_field(order, "name", 64)
        settings = dict(self.machine.settings)

        def about_answer(found):
            """The answer to the order: a message with the job's facts, or the refusal."""
            if is_refusal(found) and (isinstance(found, int) or "error" in found):
                return found
            answer = {"t": "job_about", "name": name}  # MicroPython, in a tab, does not know {**found}
            answer.update(found)
            return answer

        return self.machine.busy_error() or SlowOrder(lambda: self.store.facts_of(name, settings), about_answer, slow=True)

    def _job_part(self, order):
        """Take a piece of a job's text. Order: `at`: the piece's first character, 0 for the first; `last`: the job is complete. Returns 0, an error or
        a SlowOrder."""
        name = text_field(order, "name", 64)
        at = int(number_field(order, "at", 0, _MOST_NUMBER))
        piece = order.get("text")
        if not isinstance(piece, str):
            raise Wrong("text")
        if not order.get("last"):
            return self.store.add_piece(name, at, piece, False)
        return SlowOrder(lambda: self.store.add_piece(name, at, piece, True), job=name, slow=True)  # a drawing becomes a job

    def _job_place(self, order):
        """Make a drawing's job anew with its lower left corner at x, y, `width` wide, in mm. Returns a SlowOrder or an error."""
        name = text_field(order, "name", 64)
        place = [number_field(order, field, least, _MOST_PLACED) for field, least in (("x", -_MOST_PLACED), ("y", -_MOST_PLACED), ("width", 0))]
        return self.machine.busy_error() or SlowOrder(lambda: self.store.place_job(name, place), job=name, slow=True)

    def _job_remove(self, order):
        return self.machine.busy_error() or self.store.remove_job(text_field(order, "name", 64))

    def _look_through(self, name):
        """(lines, the tools they change to or None) of a job, or the number of an error."""
        lines = self.store.lines_of(name)
        return lines if is_refusal(lines) else (lines, self.store.tools_of(lines))

    def _run_whole(self, name, lines):
        return self.machine.run(name, lines, 1, False, False)

    def _order_run(self, order):
        """Run a job `passes` times, 1 … 100, or only check it. A STOP before its lines are read prevents it. Returns a SlowOrder or an error."""
        passes = int(number_field(order, "passes", 1, _PASSES, 1))
        error = self.machine.refusal() or self.machine.busy_error()
        if error:
            return error
        name = text_field(order, "name", 64)
        stops = self._stops

        def begin(lines):
            error = lines if is_refusal(lines) else errors.STOPPED if self._stops != stops else self.machine.refusal() or self.machine.busy_error()
            return error or self.machine.run(name, lines, passes, bool(order.get("check")), bool(order.get("single")))

        return SlowOrder(lambda: self.store.lines_of(name), begin, name)

    # --- teach-in

    def _order_teach(self, order):
        """Record manual moves: `what` is begin, save (under a name) or drop. Returns 0 or an error."""
        what = text_field(order, "what", 8)
        if self.teach is None or what not in ("begin", "save", "drop"):
            return errors.UNKNOWN_COMMAND
        if what == "begin":
            return self.machine.busy_error() or self.teach.begin()
        if what == "drop":
            return self.teach.drop()
        name = text_field(order, "name", 64)
        error = self.machine.busy_error() or self.store.name_error(name)
        if error:
            return error
        taught = self.teach.program_text()
        return taught if isinstance(taught, int) else self.store.put_job(name, taught)
