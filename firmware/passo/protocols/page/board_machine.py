"""The machine behind a page that its own board serves: orders become commands, the machine's report becomes the state that is shown.

    machine = PlotterPage(record, number, board, tell)
    machine.step({"x": 1.0}, 500)       # 0, or a number of errors; what is to be done waits in machine.said
    machine.report(report, now_ms)      # the machine's own, as any language has it
    machine.state

`record`: the machine's state; `number`: of the page's link. What a machine can do without, its language leaves out (can).
"""

from passo import commands, errors
from passo.commands import Command
from passo.protocols.page.any_machine import AnyMachine


class BoardMachine(AnyMachine):
    tells = ("command",)  # what a page may ask for of any board that serves it
    untold = (errors.STOPPED,)  # what the machine logs and is no matter of pages
    from_here = ("jog", "step", "goto")  # orders that count from the newest report: one is made before them

    def __init__(self, record, number, board, tell):
        AnyMachine.__init__(self, tell, board)
        self._record = record
        self._number = number
        self.said = []  # (command, answered) to be carried out; answered(error): what came of it
        self.unanswered = []  # the same of those that have been
        self.kinds = {}  # kind of command: heard(event), of who wants to know more of its answers
        self._refused = 0  # the number of the last refusal that was told, until the next report
        self.state["link"] = True
        self.can = self.can + self.tells

    # --- commands

    def do(self, command, answered=None):
        """Have a command carried out behind those that have been said; answered(error), or else a refusal is told to all pages."""
        self.said.append((command, answered))
        return 0

    def _behind(self, first, second):
        """Have `second` carried out once `first` has been: which may drop what was said behind it."""
        return self.do(first, lambda error: self.finished(error) if error else self.do(second))

    def pending(self):
        """True if there is something to be carried out."""
        return self.said

    def commands(self):
        """Commands to be carried out, each before the next is asked for."""
        while self.said:
            said = self.said.pop(0)
            self.unanswered.append(said)
            yield said[0]

    def answered(self, event):
        """What has come of a command. Returns its error."""
        command = event.command
        error = event.error if event.kind == commands.REFUSED else 0
        heard = self.kinds.get(command.kind)
        if heard:
            heard(event)
        for said in self.unanswered:
            if said[0] is command:
                self.unanswered.remove(said)
                if said[1]:
                    said[1](error)
                elif error:
                    self.finished(error)
                return error
        if error and not heard:
            self.finished(error)
        return error

    def keep_jobs(self, order, heard):
        """The board stores jobs: `order` of them, and `heard(event)`, what comes of it."""
        self.orders["stored"] = order
        self.kinds[commands.JOB] = heard
        self.can = self.can + ("kept",)

    def busy_with(self, kind):
        return self._record.busy_with(kind)

    def runs_stored(self):
        """True while a stored job runs."""
        return self._record.lender >= 0

    # --- what the machine says

    def now(self, now_ms):
        """Look at the clock and at the machine: an order counts on what is so now. A jog that nobody holds any more ends."""
        record = self._record
        commander = record.commander if record.lender < 0 else record.lender
        self.state["owner"] = "page" if commander == self._number else "guest"
        self.state["state"] = self._name(record.state)
        self.state["alarm"] = record.alarm
        self.go_on(now_ms)

    def _name(self, state):
        """The state's word on the page."""
        return state[:1].upper() + state[1:]

    def report(self, report):
        """The machine's report, a dict: what is shown is so from now on."""
        state = self.state
        state["state"] = self._name(report["state"])
        if "job" in report:
            state["stored"] = report["job"] or ""
        state["more"] = [[word, str(report[key])] for key, word in commands.STATUS_WORDS if report.get(key) is not None]
        self._show(report)

    def _show(self, report):
        """What only this machine has."""

    def _tell_error(self, report):
        """Of a machine that logs what goes wrong and says no more: all pages are told the last of it."""
        error = report["error"]
        if error and error != self._refused and error not in self.untold and not self._record.alarm:
            self.note(error)
        self._refused = 0

    def finished(self, error):
        self._refused = error
        AnyMachine.finished(self, error)

    def pushed(self, event):
        """What the machine says unasked."""
        if event.kind == commands.ALARM:
            self.drop_jog()
            self.note(event.error)
        elif event.kind == commands.DROPPED or event.kind == commands.RESTARTED:
            self._forget(event)

    def drop(self, event):
        """What was said before is not done any more: another link, or an alarm, has stopped the machine."""
        self._forget(event)

    def _forget(self, event):
        self.drop_jog()
        self.said = []
        if event.kind == commands.RESTARTED:  # nothing that was under way is answered any more, but for what brought this about
            self.jog.waiting = False
            self.unanswered = [said for said in self.unanswered if said[0] is event.value]

    # --- orders that all machines have words for

    def stop(self):
        """Stop at once: who asks does not matter."""
        self.drop_jog()
        self.said = []
        return self.do(Command(commands.STOP))

    def hold(self):
        self.end_jog()
        return self.do(Command(commands.HOLD))

    def resume(self):
        return self.do(Command(commands.RESUME))

    def home(self):
        return self.do(Command(commands.HOME))

    def unlock(self):
        return self.do(Command(commands.UNLOCK))

    def give(self, owner):
        """Hand the command over, at rest: to this page's link, or to the board file's first."""
        return self.do(Command(commands.HAND_OVER, value=1 if owner == "guest" else 0))

    def still(self):
        return errors.BUSY if [1 for command, _ in self.unanswered if command.kind != commands.JOB] else AnyMachine.still(self)
