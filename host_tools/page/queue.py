"""Jobs that wait for one another.

    queue = Queue(machine, look, run)               # look(name): (lines, [] or ["T1", …]), takes a moment; run(name, lines): 0 or an error
    queue.order({"do": "queue", "what": "add", "name": "part.gcode"})
    queue.poll()                                    # begins the next one once the one before has been done
    machine.state["queue"]          # {"jobs": [names], "on": it has been begun, "waits": "", or why somebody has to say go on, "tool": "T2"}

The next job begins by itself only if no tool has to be changed in between: its first tool is the one that is in the spindle, or it names none.
Else, and in a language without tools, somebody says so: "run". One that fails or is ended stops the queue.
"""

from host_tools.page.slow_order import SlowOrder, is_refusal
from passo import errors
from passo.protocols.page.orders import Wrong, number_field, text_field

_MOST = 50


class Queue:
    def __init__(self, machine, look, run):
        """`look(name)`: (lines of a job, the tools that it changes to, in order, or None: the language has no word for them), or an error."""
        self._machine = machine
        self._look = look
        self._run = run
        self._reads = False  # the next one is being read
        self._stops = 0
        self._jobs = []
        self._now = ""  # the job of the queue that runs
        self._tool = ""  # in the spindle, as far as the queue's jobs say
        self._show_state("")

    def _show_state(self, waits, tool=""):
        """Show the queue on all pages. `waits`: "", "asks", "tool" or "gone"; `tool`: the one to change to."""
        self._machine.state["queue"] = {"jobs": list(self._jobs), "on": bool(self._now or waits), "waits": waits, "tool": tool}

    def carry_out(self, order):
        """Carry out a page's order: `what` is add, run, clear, up, down or remove. Returns 0, an error or a SlowOrder. Raises Wrong."""
        what = text_field(order, "what", 8)
        jobs, waits = self._jobs, self._machine.state["queue"]
        if what == "add":
            name = text_field(order, "name", 64)
            if len(jobs) >= _MOST:
                return errors.JOB_SIZE
            return SlowOrder(lambda: self._look(name), lambda found: self._add_job(name, found), name)
        elif what == "run":
            return self._run_next()
        elif what == "clear":
            jobs.clear()
            waits = {"waits": "", "tool": ""}
        elif what in ("up", "down", "remove"):
            at = int(number_field(order, "at", 0, _MOST - 1))
            if at >= len(jobs) or jobs[at] != order.get("name"):  # another page has changed it meanwhile
                return errors.NO_SUCH_JOB
            name = jobs.pop(at)
            if what != "remove":
                jobs.insert(max(0, at - 1) if what == "up" else at + 1, name)
            waits = {"waits": "", "tool": ""}  # another one may be the next: it is asked anew
        else:
            raise Wrong("what")
        self._show_state(waits["waits"], waits["tool"])
        return 0

    def _add_job(self, name, found):
        """Append a job whose lines `found` could be read. Returns 0 or a refusal."""
        if is_refusal(found):
            return found
        if len(self._jobs) >= _MOST:
            return errors.JOB_SIZE
        self._jobs.append(name)
        waits = self._machine.state["queue"]
        self._show_state(waits["waits"], waits["tool"])
        return 0

    def _run_next(self):
        """Begin the first job that waits, for a person who has ordered it. Returns a SlowOrder or an error."""
        machine = self._machine
        if not self._jobs:
            return errors.NO_SUCH_JOB
        name, stops = self._jobs[0], self._stops
        return machine.refusal() or machine.busy_error() or SlowOrder(
            lambda: self._look(name), lambda found: errors.STOPPED if self._stops != stops else self._begin_job(name, found), name
        )

    def _begin_job(self, name, found):
        """Begin the job `name`, if it is still the first. `found`: (lines, tools) or a refusal. Returns 0 or a refusal."""
        machine = self._machine
        if is_refusal(found):
            return found
        if self._jobs[:1] != [name]:
            return errors.BUSY  # another page has changed it meanwhile
        lines, tools = found
        error = machine.refusal() or machine.busy_error() or self._run(name, lines)
        if error:
            return error
        self._jobs.pop(0)
        self._now = name
        self._tool = (tools or [self._tool])[-1]
        self._show_state("")
        return 0

    def poll(self):
        """Begin the next job once the queue's job is done, or ask for it. Call it some hundred times a second."""
        machine = self._machine
        if not self._now or self._reads or machine.job.is_running() or machine.state["state"] != "Idle":
            if self._now and not machine.state["link"]:
                self._stop_queue()
            return
        done = machine.state["job"]
        if not done or done["name"] != self._now or done["how"] != "done":
            self._stop_queue()
        elif not self._jobs:
            self._stop_queue()
        else:
            self._read_next()

    def note_stop(self):
        """Note a STOP: the job that is being read does not begin."""
        self._stops += 1

    def _stop_queue(self):
        self._now = ""
        self._show_state("")

    def _read_next(self):
        """Read the next job beside the machine, then offer it, unless a STOP came meanwhile."""
        name, stops = self._jobs[0], self._stops
        self._reads = True

        def take_job(found):
            """Offer the job just read, or stop the queue if it was stopped meanwhile."""
            self._reads = False
            if self._now and self._stops == stops:
                self._now = ""
                self._offer_job(name, found)
            else:
                self._stop_queue()

        self._machine.beside(lambda: self._look(name), take_job)

    def _offer_job(self, name, found):
        """Begin the next job, or show on the pages what it waits for: a tool, a person, a file that has gone."""
        tools = None if is_refusal(found) else found[1]
        if is_refusal(found):
            self._show_state("gone")
        elif self._jobs[:1] != [name] or tools is None or self._machine.presence_error():
            self._show_state("asks")
        elif tools and tools[0] != self._tool:
            self._show_state("tool", tools[0])
        elif self._begin_job(name, found):
            self._show_state("asks")
