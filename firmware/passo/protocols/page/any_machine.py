"""What the machines of all pages have in common: one state, a log, the lease of a jog. A language adds its own words.

    class PlotterPage(BoardMachine):           # a board that serves its own page: orders become commands, see board_machine.py
        language = "plotter"
        can = ("jog", "step", "home", …)       # the page hides what is not named

A PC's are told by cable, and tell the board in its language (host_tools/page). What a machine has no word for is refused with error
102, and the page hides it.
"""

from micropython import const

from passo import errors
from passo.protocols.page.jog import Jog, Limits
from passo.protocols.page.lease import Lease, since

_MOST_LOG = const(100)
_HUGE = 1e9  # mm/s²: no ramps


class AnyMachine:
    language = ""
    can = ()
    stood = ("Idle", "Check", "Alarm", "Sleep", "Hold", "Door")
    speaks = False  # a board's link for pages also understands lines of its language
    jogs_from = ("Idle", "Jog")  # states in which a continuous jog may begin

    def __init__(self, tell, board=None):
        """`tell(event)`: a dict for every page; `board`: the checked board file, for a language that does not tell its axes and their
        steps/mm."""
        axes = board["axes"] if board else ()
        self.axes = "".join([axis["name"] for axis in axes]) or "xyz"
        self.scale = [axis["steps_per_m"] / 1000 for axis in axes]
        self._tell = tell
        self.lease = Lease()
        self.jog = Jog(self._say_jog)
        self.settings = {}
        self.orders = {}  # name: function of an order, for what only this language has
        self.place = None  # mm, machine coordinates
        self._now_ms = self._measured_ms = 0
        self._measured = None  # steps, by the report before
        self._log = []
        self.state = {"link": False, "state": "", "sub": "0", "owner": "page", "alarm": 0, "job": None}

    # --- what is told

    def beat(self, number):
        """Report `number` goes out to the pages."""
        self.lease.beat(number, self._now_ms)

    def shown(self):
        """The state that pages get."""
        self.state["lease"] = self.lease.number
        return self.state

    def _show_place(self, steps):
        """A report of a machine that tells no speed: its place in mm, and the speed since the one before."""
        axes = range(len(self.scale))
        self.place = self.state["m"] = self.state["w"] = [round(steps[axis] / self.scale[axis], 4) for axis in axes]
        passed = since(self._now_ms, self._measured_ms)
        if self._measured and passed:
            far = sum([((steps[axis] - self._measured[axis]) / self.scale[axis]) ** 2 for axis in axes]) ** 0.5
            self.state["feed"] = round(far * 60_000 / passed)
        self._measured = [steps[axis] for axis in axes]
        self._measured_ms = self._now_ms

    def stands(self):
        """True if nothing moves, as far as is known."""
        return self.state["state"] in self.stood

    def note(self, number):
        """A line of the page's log: alarms and refusals."""
        self._log.append(number)
        if len(self._log) > _MOST_LOG:
            self._log.pop(0)
        self._tell({"t": "log", "log": [number]})

    def log(self):
        """Numbers of errors and alarms, the oldest first."""
        return list(self._log)

    # --- orders

    def refusal(self):
        """0, or why the page may not move the machine now."""
        if not self.state["link"]:
            return errors.NO_ANSWER
        if self.state["owner"] != "page":
            return errors.COMMANDED_ELSEWHERE
        return 0

    def still(self):
        """0, or why something may not begin."""
        return errors.BUSY if self.jog.active or not self.stands() else 0

    def abort(self):
        """Come to a stand, and give up the job that is streamed: there is none."""
        return 0

    def _wordless(self, *_):
        """The language has no word for it."""
        return errors.UNKNOWN_COMMAND

    hold = resume = home = unlock = zero = go = step = override = output = set = line = give = play = run = _wordless

    # --- the jog

    def begin_jog(self, number, beat, direction, speed):
        """A continuous jog; it lasts while its lease does. Returns 0 or an error."""
        if self.state["state"] == "Alarm":
            return errors.LOCKED
        if self.state["state"] not in self.jogs_from or self.jog.waiting or not self._may_jog(direction):
            return errors.BUSY
        if not self.lease.begin(number, beat, self._now_ms):
            return errors.LEASE
        self._start_jog(direction, speed)
        return 0

    def _may_jog(self, direction):
        return self.place is not None and len(direction) == len(self.place)

    def _start_jog(self, direction, speed):
        self.jog.begin(direction, speed, self._limits(), self.place)

    def go_on(self, now_ms):
        """It is `now_ms`: a jog that nobody holds any more ends."""
        self._now_ms = now_ms
        if self.jog.active and not self.lease.alive(now_ms):
            self.end_jog()

    def renew(self, number, beat):
        """True if the jog's lease lasts on."""
        return self.lease.renew(number, beat, self._now_ms)

    def end_jog(self):
        """Brake now."""
        self.lease.end()
        if self.jog.active:
            self.jog.end()
            self._brake()

    def drop_jog(self):
        """End the jog without a word: what is said next stops the machine at once, and nothing may come before it."""
        self.lease.end()
        self.jog.end()

    def _brake(self):
        """Say that the jog under way ends."""

    def _limits(self):
        """Of a machine that goes at any of its speeds at once."""
        return Limits([_HUGE] * len(self.place), [_HUGE] * len(self.place))

    def _say_jog(self, place, speed):
        """Queue a straight jog to machine coordinates in mm; False if it cannot be said now."""
        return False

    def jog_answered(self, error):
        """The board's answer to a piece of the jog."""
        if not self.jog.active:
            self.jog.waiting = False
            self._brake()  # the first one may have overtaken this piece
        elif error == errors.JOG_TRAVEL or not error:
            self.jog.answered(error)
            if not self.jog.active:  # at the end of the travel
                self.lease.end()
                self.finished(error)
        else:
            self.jog.waiting = False
            self.end_jog()
            self.finished(error)

    def finished(self, error):
        """An order has been answered: what was refused is told."""
        if error > 0:
            self.note(error)
