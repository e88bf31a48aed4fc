"""What the machines of a PC's pages have in common: they are asked for reports over a cable, and are lost when none come."""

from passo import errors
from passo.protocols.page.any_machine import AnyMachine
from passo.protocols.page.lease import since

_JOG_ASK_MS = 40  # between two reports, while a jog goes on


class NoJob:
    """No file is streamed."""

    name = ""

    def running(self):
        return False

    def poll(self):
        pass

    def refresh(self):
        pass

    def fail(self, error):
        pass

    def abort(self):
        return 0

    def run(self, name, lines, passes, checked, single=False):
        return errors.UNKNOWN_COMMAND


class CableMachine(AnyMachine):
    ask_ms = 40  # between two reports otherwise: 25 a second
    silent_ms = 1500  # without a report: the link is down
    again_ms = 3000  # it is asked for again

    def __init__(self, tell, job, board=None):
        """`job`: what runs jobs; the rest: see AnyMachine."""
        AnyMachine.__init__(self, tell, board)
        self.job = job
        network = board["network"] if board else None
        self._presence = bool(network and network["presence"])
        self._asked_ms = self._heard_ms = 0
        self._asking = False
        self.watcher = None  # watcher(state): told of each report

    def poll(self, now_ms):
        """Ask, end what has lapsed, go on with the job."""
        self._now_ms = now_ms
        if self.jog.active and not self.lease.alive(now_ms):
            self.end_jog()
        if since(now_ms, self._asked_ms) >= (self.again_ms if self._asking else _JOG_ASK_MS if self.jog.active else self.ask_ms):
            self._asked_ms = now_ms
            self._asking = True
            self._ask()
        if self.state["link"] and since(now_ms, self._heard_ms) > self.silent_ms:
            self._lose()
        if self.state["link"]:
            self._go_on()
        self.job.poll()

    def shown(self):
        self.job.refresh()
        return AnyMachine.shown(self)

    def still(self):
        return errors.BUSY if self.job.running() else AnyMachine.still(self)

    def abort(self):
        return self.job.abort()

    def _may_jog(self, direction):
        return AnyMachine._may_jog(self, direction) and not self.job.running()

    def _ask(self):
        """Ask the board for a report."""

    def _go_on(self):
        """What is to be said as soon as it can be."""

    def _reported(self):
        """A report has come, and the state is as it says."""
        self._asking = False
        self._heard_ms = self._now_ms
        self.state["link"] = True

    def attached(self, is_open):
        """The port has been opened, or closed."""

    def lost(self):
        """There is no board any more: it is about to be another one."""
        self._lose()

    def _lose(self):
        self.state["link"] = False
        self.end_jog()
        self.job.fail(errors.NO_ANSWER)

    def absent(self):
        """0, or why who orders over a network may not start the tool or go on: the board wants somebody at the machine.
        Most languages have no word for who is there: then never."""
        return errors.PRESENCE if self._presence else 0
