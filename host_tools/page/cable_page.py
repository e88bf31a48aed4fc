"""The page of a machine on a cable: the same as its board would serve, but that commands become bytes, and bytes reports.

    class TorchMachine(on_cable(TorchPage)): …
        Cabled.__init__(self, tell, TorchWire(write, self), board)
    machine.feed(data, now_ms)              # bytes from the board
    machine.poll(now_ms)                    # some hundred times a second

A wire (host_tools/clients) says commands in the board's language: can_take(command), send_command(command), ask_report(), feed(data, now_ms),
note_silence() and drop(). It calls the machine's take_answer(event) and report(dict). Boards are asked for reports all the time, and are lost when none come.
"""

from host_tools.page.slow_order import run_at_once
from passo import errors
from passo.protocols.page.lease import ms_since

_JOG_ASK_MS = 40  # between two reports, while a jog goes on
_MOST = 64  # commands that wait for room


class Told:
    """The fields of a machine's record that a page reads, with the values of its reports."""

    state = "idle"
    settings = None
    lender = -1
    commander = alarm = 0

    def busy_with(self, kind):
        return False


def on_cable(kind):
    """The class of pages `kind` (passo/protocols/page), of a machine on a cable."""
    return _with_reports(_with_wire(kind))


def _with_wire(kind):
    """The class of pages `kind` that sends its commands on a wire, as many as the wire can take."""

    class Said(kind):
        tells = ()
        beside = staticmethod(run_at_once)  # beside(work, then): then(work()), later where a loop is not to wait for it
        retries = 0  # questions that were asked again
        late = 0  # reports of steps that were not computed in time; grbl has no word for it in its reports
        left = False  # the port has been closed, which may be amid an order: poll() calls lose_board()

        def __init__(self, tell, wire, board, spoken=None):
            kind.__init__(self, Told(), 0, board, tell, spoken)
            self.wire = wire
            self.state["link"] = False
            self._presence = bool(board and board.get("network") and board["network"]["presence"])

        def queue_command(self, command, answered=None):
            """Queue a command and send it if the wire can take it. Returns 0, or TOO_MANY_WAITING if _MOST wait."""
            if len(self.said) >= _MOST:
                return errors.TOO_MANY_WAITING
            kind.queue_command(self, command, answered)
            self.send_waiting()
            return 0

        def send_waiting(self):
            """Send waiting commands, oldest first, until the wire can take no more."""
            while self.said and self.wire.can_take(self.said[0][0]):
                said = self.said.pop(0)
                self.unanswered.append(said)
                self.wire.send_command(said[0])

        def hand_over(self, owner):
            """Take the command from another link. Returns 0, or UNKNOWN_COMMAND for "guest": the page hands it to no other link."""
            return kind.hand_over(self, owner) if owner == "page" else errors.UNKNOWN_COMMAND

        def presence_error(self):
            """Return PRESENCE if the board file wants somebody at the machine before an order of another computer starts the tool; else 0.
            Only grbl's reports show that somebody is there; in other languages such orders are always refused."""
            return errors.PRESENCE if self._presence else 0

        def note_port(self, is_open):
            """Note that the port has been opened or closed. Commands under way get no answer from a closed port; poll() drops them."""
            if not is_open:
                self.state["link"] = False
                self.left = True

        def lose_board(self):
            """Drop the commands under way: the board has gone, or another one takes its place."""
            self.wire.drop()
            self.note_silence()

        def note_silence(self):
            """Show the link as down, end the jog and forget waiting commands: the board has not answered for silent_ms."""
            self.state["link"] = False
            self.end_jog()
            self.said = []
            self.wire.note_silence()

    return Said


def _with_reports(kind):
    """The class of pages `kind` that asks the board for a report each ask_ms, and shows the link as down silent_ms after the last one."""

    class Reported(kind):
        ask_ms = 40  # between two reports: 25 a second
        silent_ms = 1500  # since it was asked for a report: the link is down
        again_ms = 3000  # it is asked for again
        watcher = None  # watcher(state): told of each report

        def __init__(self, tell, wire, board, spoken=None):
            kind.__init__(self, tell, wire, board, spoken)
            self._asked_ms = self._unanswered_ms = 0
            self._asking = False

        def feed(self, data, now_ms):
            self._now_ms = now_ms
            self.wire.feed(data, now_ms)
            self.send_waiting()

        def poll(self, now_ms):
            """Ask for a report if it is time, end a lapsed jog, send waiting commands. Call it at least each ask_ms."""
            if self.left:
                self.left = False
                self.lose_board()
            self.update_jog(now_ms)
            if ms_since(now_ms, self._asked_ms) >= (self.again_ms if self._asking else _JOG_ASK_MS if self.jog.active else self.ask_ms):
                self._asked_ms = now_ms
                if self._asking:
                    self.retries += 1
                else:
                    self._unanswered_ms = now_ms
                self._asking = True
                self.wire.ask_report()
            if self.state["link"] and self._asking and ms_since(now_ms, self._unanswered_ms) > self.silent_ms:
                self.note_silence()
            self.send_waiting()

        def report(self, report):
            """Take a report, a dict as the board's own page has it: the link is up; raise a new alarm; call watcher(state)."""
            self._asking = False
            self.state["link"] = True
            self.late += report.get("error") == errors.WORDS_LATE
            alarm = self._alarm_of(report)
            if alarm and not self._record.alarm:
                self.raise_alarm(alarm)
            self._record.alarm = self.state["alarm"] = alarm
            kind.report(self, report)
            if self.watcher:
                self.watcher(self.state)

        def _alarm_of(self, report):
            """The number of the alarm that a report shows, 0: no alarm."""
            return (report["error"] or self._record.alarm or errors.NUMBER) if report["state"] == "alarm" else 0

        def raise_alarm(self, number):
            self._record.alarm = self.state["alarm"] = number
            self.drop_jog()
            self.log_error(number)

    return Reported
