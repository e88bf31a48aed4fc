"""The machine behind a page: orders become commands, the machine's report becomes the state that is shown.

    machine = PlotterPage(record, number, board, tell)
    machine.step_by({"x": 1.0}, 500)       # 0, or a number of errors; what is to be done waits in machine.said
    machine.report(report, now_ms)      # the machine's own, as any language has it
    machine.state

`record`: the machine's state; `number`: of the page's link. Each language has a class of its own, with its additions and the orders of its
page (can). Orders without a word of the machine are refused with error 102, and the page hides them. On a PC the same classes get reports
by cable (host_tools/page).
"""

from micropython import const

from passo import commands, errors
from passo.commands import Command
from passo.protocols.page.jog import Jog, Limits
from passo.protocols.page.lease import Lease, ms_since
from passo.protocols.setting_lines import decimal_text, parse_thousandths

_MOST_LOG = const(100)
_HUGE = 1e9  # mm/s²: no ramps


def travel_of(board):
    """[[least, most]] of each axis in mm of the homed machine."""
    high_end = board["homing"]["high_end"]
    found = []
    for axis in board["axes"]:
        mm = round(axis["travel_steps"] * 1000 / axis["steps_per_m"], 3)
        found.append([-mm, 0] if axis["name"] in high_end else [0, mm])
    return found


class PageMachine:
    language = ""
    turns = ""  # axes that count degrees
    can = ()
    tells = ("command",)  # orders that a page may give to any board that serves it
    stood = ("Idle", "Check", "Alarm", "Sleep", "Hold", "Door")
    speaks = False  # a board's link for pages also understands lines of its language
    jogs_from = ("Idle", "Jog")  # states in which a continuous jog may begin
    untold = (errors.STOPPED,)  # refusals of the machine that are no matter of pages
    from_here = ("jog", "step", "goto")  # orders that count from the newest report: one is made before them

    def __init__(self, record, number, board, tell):
        """`tell(event)`: a dict for every page; `board`: the checked board file, None where the language tells axes and steps/mm."""
        axes = board["axes"] if board else ()
        self.axes = "".join([axis["name"] for axis in axes]) or "xyz"
        self.scale = [axis["steps_per_m"] / 1000 for axis in axes]
        self.travel = travel_of(board) if board and board["homing"] else None
        self.can = self.can + self.tells
        self._record = record
        self._board = board
        self._settings_of = record.settings.version if record.settings else 0  # that scale and travel are of
        if record.settings and "settings" not in self.can:
            self.can = self.can + ("settings",)
        self._number = number
        self._tell = tell
        self.lease = Lease()
        self.jog = Jog(self._queue_jog)
        self.settings = {}
        self.orders = {}  # name: function of an order that only this language has
        self.said = []  # (command, answered) to be carried out; answered(error): its result
        self.unanswered = []  # the same of those that have been
        self.kinds = {}  # kind of command: heard(event), for its further answers
        self._aside = -1  # the kind of commands that make the page's machine busy with nothing
        self.position = None  # mm, machine coordinates
        self._now_ms = self._measured_ms = 0
        self._measured = None  # steps, by the report before
        self._log = []
        self._refused = 0  # the number of the last refusal that pages have, until the next report
        self.state = {"link": True, "state": "", "sub": "0", "owner": "page", "alarm": 0, "job": None}

    # --- commands

    def queue_command(self, command, answered=None):
        """Queue a command behind those before it. answered(error) gets its result; without it a refusal goes to all pages. Returns 0 or an error."""
        self.said.append((command, answered))
        return 0

    def _queue_pair(self, first, second):
        """Queue `first`, and `second` once it has been carried out: `first` may drop commands queued behind it. Returns 0 or an error."""
        return self.queue_command(first, lambda error: self.note_result(error) if error else self.queue_command(second))

    def pending(self):
        return self.said

    def commands(self):
        """Yield the queued commands; the caller carries out each before it asks for the next."""
        while self.said:
            said = self.said.pop(0)
            self.unanswered.append(said)
            yield said[0]

    def take_answer(self, event):
        """Take the answer to a command. Returns its error."""
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
                    self.note_result(error)
                return error
        if error and not heard:
            self.note_result(error)
        return error

    def add_stored_jobs(self, order, kind, heard):
        """Add the orders for jobs that the board stores. `order(order)` carries one out, by commands of `kind`; `heard(event)` gets their answers."""
        self.orders["stored"] = order
        self.kinds[kind] = heard
        self._aside = kind
        self.can = self.can + ("kept",)

    def busy_with(self, kind):
        return self._record.busy_with(kind)

    def runs_stored(self):
        return self._record.lender >= 0

    # --- what the machine says

    def refresh_state(self, now_ms):
        """Take state, owner and alarm from the machine's record, for the next order. Ends a jog that nobody holds any more."""
        record = self._record
        commander = record.commander if record.lender < 0 else record.lender
        self.state["owner"] = "page" if commander == self._number else "guest"
        self.state["state"] = self._state_word(record.state)
        self.state["alarm"] = record.alarm
        self._now_ms = now_ms
        if self.jog.active:
            self.update_jog(now_ms)

    def update_jog(self, now_ms):
        """Take the time, and end the jog if its lease has lapsed."""
        self._now_ms = now_ms
        if self.jog.active and not self.lease.is_alive(now_ms):
            self.end_jog()

    def _state_word(self, state):
        """The state's word on the page."""
        return state[:1].upper() + state[1:]

    def report(self, report):
        """Take the machine's report, a dict, into the state for pages."""
        state = self.state
        settings = self._record.settings
        if settings and self._settings_of != settings.version:
            self._settings_of = settings.version
            self._follow_settings(settings)
        state["state"] = self._state_word(report["state"])
        if "job" in report:
            state["stored"] = report["job"] or ""
        state["more"] = [[word, str(report[key])] for key, word in commands.STATUS_WORDS if report.get(key) is not None]
        self._show_fields(report)

    def _show_fields(self, report):
        """Add the fields of this machine alone."""

    def _follow_settings(self, settings):
        """Take changed settings over, with steps/mm, and send them to all pages."""
        self.scale = [resolution / 1000 for resolution in self._record.steps_per_m[: len(self.scale)]]
        self.travel = travel_of(self._board) if self.travel else None
        self._tell({"t": "settings", "axes": self.axes, "settings": self.settings_texts()})

    def settings_texts(self):
        """{number: value as text} of all settings; made at each call, to save memory."""
        settings = self._record.settings
        return {number: decimal_text(settings.value(number), settings.places(number)) for number in settings.numbers} if settings else {}

    def _show_position(self, steps):
        """Show the position in mm of a machine that reports no speed, and its mean speed in mm/min since the last report. `steps`: of each axis."""
        axes = range(len(self.scale))
        self.position = self.state["m"] = self.state["w"] = [round(steps[axis] / self.scale[axis], 4) for axis in axes]
        passed = ms_since(self._now_ms, self._measured_ms)
        if self._measured and passed:
            far = sum([((steps[axis] - self._measured[axis]) / self.scale[axis]) ** 2 for axis in axes]) ** 0.5
            self.state["feed"] = round(far * 60_000 / passed)
        self._measured = [steps[axis] for axis in axes]
        self._measured_ms = self._now_ms

    def _tell_error(self, report):
        """Send the last refusal to all pages, of a machine that logs refusals and has no answers."""
        error = report["error"]
        if error and error != self._refused and error not in self.untold and not self._record.alarm:
            self.log_error(error)
        self._refused = 0

    def take_event(self, event):
        """Take an event that the machine sends unasked."""
        if event.kind == commands.ALARM:
            self.drop_jog()
            self.log_error(event.error)
        elif event.kind == commands.DROPPED or event.kind == commands.RESTARTED:
            PageMachine.drop(self, event)

    def drop(self, event):
        """Forget the commands given before: another link, or an alarm, has stopped the machine."""
        self.drop_jog()
        self.said = []
        if event.kind == commands.RESTARTED:  # commands under way get no answer any more, but for the one that brought this about
            self.jog.waiting = False
            self.unanswered = [said for said in self.unanswered if said[0] is event.value]

    # --- messages to pages

    def note_beat(self, number):
        """Note that report `number` goes out to the pages: leases count from it."""
        self.lease.note_beat(number, self._now_ms)

    def page_state(self):
        """Return the state for the pages, a dict, with the newest lease's number."""
        self.state["lease"] = self.lease.number
        return self.state

    def log_error(self, number):
        """Add the number of an alarm or refusal to the page's log, and send it to all pages."""
        self._log.append(number)
        if len(self._log) > _MOST_LOG:
            self._log.pop(0)
        self._tell({"t": "log", "log": [number]})

    def log(self):
        """Numbers of errors and alarms, the oldest first."""
        return list(self._log)

    def note_result(self, error):
        """Note the result of a command: log an error and send it to all pages."""
        self._refused = error
        if error > 0:
            self.log_error(error)

    # --- orders

    def refusal(self, by_hand=False):
        """0, or the error why the page may not order motion now: no link, another link commands, or, `by_hand`, an alarm."""
        if not self.state["link"]:
            return errors.NO_ANSWER
        if self.state["owner"] != "page":
            return errors.COMMANDED_ELSEWHERE
        return errors.LOCKED if by_hand and self.state["state"] == "Alarm" else 0

    def is_at_rest(self):
        """True if nothing moves by the last report."""
        return self.state["state"] in self.stood

    def busy_error(self):
        """0, or BUSY: a jog, a motion or a command is under way, so nothing else may begin."""
        if self.jog.active or self.state["state"] not in self.stood or [1 for command, _ in self.unanswered if command.kind != self._aside]:
            return errors.BUSY
        return 0

    def stop(self):
        """Queue a stop at once, for any page, and forget commands that wait. Returns 0 or an error."""
        self.drop_jog()
        self.said = []
        return self.queue_command(Command(commands.STOP))

    def hold(self):
        """End the jog, and queue a hold. Returns 0 or an error."""
        self.end_jog()
        return self.queue_command(Command(commands.HOLD))

    def resume(self):
        """Queue the command that ends a hold. Returns 0 or an error."""
        return self.queue_command(Command(commands.RESUME))

    def home(self):
        """Queue homing. Returns 0 or an error."""
        return self.queue_command(Command(commands.HOME))

    def unlock(self):
        """Queue the command that ends an alarm. Returns 0 or an error."""
        return self.queue_command(Command(commands.UNLOCK))

    def hand_over(self, owner):
        """Hand the command to this page's link, or for "guest" to the board file's first; the machine refuses it in motion. Returns 0 or an error."""
        return self.queue_command(Command(commands.HAND_OVER, value=1 if owner == "guest" else 0))

    def abort(self):
        """Do nothing and return 0: no job is streamed to a board's own page."""
        return 0

    def _refuse_order(self, *_):
        """Return UNKNOWN_COMMAND: the language has no word for this order."""
        return errors.UNKNOWN_COMMAND

    set_work_zero = go_to = step_by = set_override = set_output = run_line = play = run = _refuse_order

    def set_setting(self, number, text):
        """Set and keep setting `number` to a number as text, of a board's own page. Returns 0 or an error."""
        if not self._record.settings:
            return errors.UNKNOWN_COMMAND
        value = parse_thousandths(text)
        return errors.NUMBER if value is None else self.busy_error() or self.queue_command(Command(commands.SETTING, number, value))

    def _steps_by(self, way):
        """The way {axis: mm} in steps of each axis, 0 for others."""
        return [round(way.get(self.axes[axis], 0) * self.scale[axis]) for axis in range(len(self.scale))]

    def _steps_to(self, position, at):
        """The position {axis: mm} in steps of each axis; axes that it leaves out stay `at`, in steps."""
        return [round(position[self.axes[axis]] * self.scale[axis]) if self.axes[axis] in position else at[axis] for axis in range(len(self.scale))]

    # --- the jog

    def begin_jog(self, number, beat, direction, speed):
        """Begin a continuous jog along `direction` at `speed` mm/min, under lease `number`. Returns 0 or an error."""
        if self.state["state"] not in self.jogs_from or self.jog.waiting or not self._may_jog(direction):
            return errors.BUSY
        if not self.lease.begin(number, beat, self._now_ms):
            return errors.LEASE
        self._start_jog(direction, speed)
        return 0

    def _may_jog(self, direction):
        """True if the position is known and `direction` has a part for each axis."""
        return self.position is not None and len(direction) == len(self.position)

    def _start_jog(self, direction, speed):
        self.jog.begin(direction, speed, self._limits(), self.position)

    def renew_jog(self, number, beat):
        return self.lease.renew(number, beat, self._now_ms)

    def end_jog(self):
        """End the lease and the jog, and brake."""
        self.lease.end()
        if self.jog.active:
            self.jog.end()
            self._brake()

    def drop_jog(self):
        """End the jog without a command: the next command stops the machine at once, and nothing may come before it."""
        self.lease.end()
        self.jog.end()

    def _brake(self):
        """Queue the command that ends the jog under way."""

    def _limits(self):
        """The limits of the jog: no ramps, for a machine that goes at any of its speeds at once."""
        return Limits([_HUGE] * len(self.position), [_HUGE] * len(self.position))

    def _queue_jog(self, position, speed):
        """Queue a straight jog to machine coordinates in mm; return False if it cannot be queued now."""
        return False

    def jog_answered(self, error):
        """Take the machine's answer to a piece of the jog; `error` 0: accepted. Ends the jog at the end of the travel, or if a piece is refused."""
        if not self.jog.active:
            self.jog.waiting = False
            self._brake()  # the first one may have overtaken this piece
        elif error == errors.JOG_TRAVEL or not error:
            self.jog.take_answer(error)
            if not self.jog.active:  # at the end of the travel
                self.lease.end()
                self.note_result(error)
        else:
            self.jog.waiting = False
            self.end_jog()
            self.note_result(error)
