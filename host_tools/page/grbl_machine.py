"""The page of a machine on a cable that speaks grbl.

    machine = GrblMachine(write, tell)      # tell(event): a dict for every page

It streams jobs, and lets a guest speak on the same wire.
"""

from host_tools.clients.grbl_wire import FIELDS, GUEST, LOST, PAGE, RX_ROOM, Wire, dwell_ms, fields_of
from host_tools.page.cable_page import on_cable
from host_tools.page.guest_sender import GuestSender
from host_tools.page.job import Job
from host_tools.page.jobs import with_jobs
from passo import commands, errors
from passo.commands import Command
from passo.protocols.page.page_machine import PageMachine
from passo.protocols.page.grbl import AXES, GrblPage
from passo.protocols.page.lease import ms_since

_FROM = {53: b"G90G53", 54: b"G90", 91: b"G91"}  # the origin of a position
_MOST_DOUBTS = 200  # more than the lines that a board has unanswered
_Cabled = with_jobs(on_cable(GrblPage))


class GrblMachine(_Cabled):
    can = GrblPage.can + ("jobs", "teach", "single")
    take_answer = PageMachine.take_answer

    def __init__(self, write, tell, guest=None):
        """`write(bytes)`: to the board; `guest(bytes)`: to the guest, if there may be one."""
        self.job = Job(self)
        _Cabled.__init__(self, tell, Wire(write, self._take_line, self.take_answer), None)
        self.guest = GuestSender(self, guest)
        self._offset = None
        self._waits = b""  # the line that is answered next
        self._wait_ms = self._counted_ms = 0
        self._known = False  # the settings have been asked for
        self.turns = self.rotary = ""  # the axis that does, and how the board says it
        self.options = None  # letters of [OPT:…]: J, a journal; F, stored jobs; None: not known yet
        self._letters = None
        self._doubts = 0  # how often "ok" came for $I without its lines: an answer to who spoke here before
        self._blocks = 0  # that the board queues; 0: not known
        self._more = []  # words of the last report that has overrides: only that one has them
        self._typed_line = b""  # the newest; b"" is no line
        self._asked = False  # ? has been typed: its report is shown
        self.cause = None  # cause(error, line): the cause of an error in a typed line, "" if the line does not show it
        self.touched = None  # touched(position) is called for each probe that has touched, mm of the work

    # --- the board

    def poll(self, now_ms):
        """Do the page's work; ask for options and settings once the machine stands, if they are not known."""
        if self.state["link"] and not self._known and self.is_at_rest() and self.wire.has_room(len(b"$I\n$$")):
            if self.options is None:
                self.turns = self.rotary = ""
                self.wire.send_line(PAGE, b"$I", self._take_options)
            self._known = self.wire.send_line(PAGE, b"$$", self._note_settings)
        _Cabled.poll(self, now_ms)

    def _take_options(self, error):
        """Take the end of $I's answer: keep the option letters, or "" after _MOST_DOUBTS answers without them."""
        if not error and self._letters is None and self._doubts < _MOST_DOUBTS:
            self._doubts += 1
        elif not error:
            self.options = self._letters or ""

    def _note_settings(self, error):
        """Take the end of $$'s answer: send axes and settings to the pages; at an error ask again later."""
        if error or self.options is None or not self.settings:
            self._known = False
            return
        self.axes = AXES[: len([number for number in self.settings if 100 <= number < 104])]
        self._tell({"t": "settings", "axes": self.axes, "settings": self.settings, "turns": self.turns})

    def lose_board(self):
        """Forget settings, position and work offset, which may be another board's from now on."""
        _Cabled.lose_board(self)
        self.settings = {}
        self._more = []
        self.position = self._offset = None

    def note_silence(self):
        """Ask for options and settings anew once the board answers again."""
        self._known = False
        self.options = self._letters = None
        self._doubts = 0
        _Cabled.note_silence(self)

    def _take_line(self, line, owner):
        """Take a line that is no answer: report, setting, alarm, banner or message. `owner`: whose line is under way, PAGE, GUEST or None."""
        if line[:1] == "<" and line[-1:] == ">":
            try:
                self._take_report(fields_of(line))
            except ValueError:  # a byte of it is wrong
                return
            self.guest.report(line)
            if self._asked:
                self._asked = False
                self._tell({"t": "said", "text": line})
            return
        if line[:1] == "$" and owner == PAGE:
            if self.wire.oldest_line() is self._typed_line:
                self._tell({"t": "said", "text": line})
            number, _, value = line[1:].partition("=")
            if number.isdigit():
                self.settings[int(number)] = value
            return
        if line[:6] == "ALARM:" and line[6:].isdigit():
            self.raise_alarm(200 + int(line[6:]))
        elif line[:5] == "Grbl ":
            self.end_jog()
            self.job.fail(errors.STOPPED)
            self._record.alarm = self.state["alarm"] = 0
            self._tell({"t": "said", "text": line})
        elif line[:11] == "[MSG:Pause:":
            self.state["why"] = "pause"
        elif line[:18] == "[MSG:Tool change: ":
            self.state["why"] = line[18:].split(",")[0]
        elif line[:5] in ("[VER:", "[OPT:") and owner == PAGE and self.options is None:
            if line[1] == "O":
                self._letters, *sizes = line[5:-1].split(",")
                if len(sizes) > 1 and all(map(str.isdigit, sizes)):
                    self._blocks, self.wire.window = int(sizes[0]), max(RX_ROOM, int(sizes[1]))
        elif line[:1] == "[" and not self.job.take_line(line) and owner == PAGE:
            if line[:8] == "[ROTARY:":
                self.rotary = line
                self.turns = line[8:-1].partition(",")[0].lower()
            self._tell_touch(line)
            self._tell({"t": "said", "text": line})
        if owner != PAGE or line[:1] != "[" or line[:5] == "[MSG:":
            self.guest.pass_line(line)

    def _tell_touch(self, line):
        """Call touched(position) for the line [PRB:…:1], with the position in mm of the work."""
        if line[:5] == "[PRB:" and line[-3:] == ":1]" and self.touched and self._offset:
            self.touched([float(part) - offset for part, offset in zip(line[5:-3].split(","), self._offset)])

    def _take_report(self, fields):
        name, _, sub = fields["state"].partition(":")
        self.report({"state": name.lower(), "substate": sub, "fields": fields})

    def _alarm_of(self, report):
        """The number of the alarm that a report shows, 0: no alarm. A machine that still brakes because of an alarm reports hold."""
        if report["state"] not in ("alarm", "hold", "door"):
            return 0
        number = int(report["fields"].get("Al", "0"))
        return number if number > errors.ALARM_LOCKED else self._record.alarm

    def _show_fields(self, report):
        """Show the fields of grbl's report: position in mm, feed in mm/min, spindle in rpm, overrides; pass it to jog and job."""
        state, fields = self.state, report["fields"]
        name, sub = state["state"], report["substate"]
        if name != "Hold":
            state["why"] = ""
        state["sub"] = sub
        self._take_positions(fields)
        speeds = fields.get("FS", fields.get("F", "0")).split(",")
        state["feed"] = float(speeds[0])
        state["rpm"] = float(speeds[1]) if len(speeds) > 1 else 0.0
        state["pins"] = fields.get("Pn", "")
        state["line"] = int(fields.get("Ln", "0"))
        free = fields.get("Bf", "").partition(",")[0]
        state["full"] = 100 - 100 * int(free) // self._blocks if free.isdigit() and self._blocks else None
        self._count_down(name == "Run" and not state["feed"])
        if "Ov" in fields:
            state["ov"] = [int(part) for part in fields["Ov"].split(",")]
            state["on"] = fields.get("A", "")
            state["stored"] = fields.get("SD", "")
            self._more = [[word, fields[word]] for word in fields if word not in FIELDS]
        state["more"] = self._more
        if self.jog.active:
            self.jog.report(self.position)
        self.job.report("" if name == "Hold" and sub == "1" else name)  # it is still braking

    def _count_down(self, stands):
        """Show how many seconds a G4 still lasts: its line is answered at its end, and the machine stands meanwhile."""
        line = self.wire.oldest_line()
        if line is not self._waits:
            self._waits = line
            self._wait_ms = dwell_ms(line)
        elif self._wait_ms and stands:
            self._wait_ms = max(0, self._wait_ms - ms_since(self._now_ms, self._counted_ms))
        self._counted_ms = self._now_ms
        self.state["wait"] = self._wait_ms / 1000 if stands else 0

    def _take_positions(self, fields):
        """Take machine and work position in mm from MPos or WPos, and the work offset from WCO, which only some reports have."""
        if "WCO" in fields:
            self._offset = [float(part) for part in fields["WCO"].split(",")]
        told = [float(part) for part in fields.get("MPos", fields.get("WPos", "0")).split(",")]
        offset = self._offset if self._offset and len(self._offset) == len(told) else [0.0] * len(told)
        machine = told if "MPos" in fields else [told[axis] + offset[axis] for axis in range(len(told))]
        self.position = machine
        self.state["m"] = machine
        self.state["w"] = [round(machine[axis] - offset[axis], 4) for axis in range(len(told))]

    # --- lines to the board

    def send_line(self, line, answered=None):
        """Send a line of the page; answered(error) follows. Returns 0, or TOO_MANY_WAITING."""
        return 0 if self.wire.send_line(PAGE, line, answered or self.note_result) else errors.TOO_MANY_WAITING

    def _queue_line(self, line):
        return self.send_line(line.encode(), self._answer_typed)

    def _say_typed(self, line):
        """Send a line and show its answers in the page's log, also those of `$$` and `?`. Returns 0 or an error."""
        self._typed_line = typed = line.encode()
        error = self.send_line(typed, lambda error: self._answer_typed(error, typed))
        self._asked = not error and line.strip() == "?"
        return error

    def _answer_typed(self, error, line=b""):
        """Show the answer to a typed line on all pages: ok, or the error with its cause. `line`: bytes, for the cause."""
        self.note_result(error)
        if error != LOST:
            text = error and self.cause and self.cause(error, line)
            if text:
                self._tell({"t": "said", "text": text})
            self._tell({"t": "said", "text": "error:%d" % error if error else "ok"})

    def home(self):
        """Send `$H`, in an alarm that wants it behind a reset. Returns 0 or an error."""
        return self._reset_before(lambda: self._send_or_reset(b"$H"))

    def unlock(self):
        """Send `$X`, in an alarm that wants it behind a reset. Returns 0 or an error."""
        return self._reset_before(lambda: self._send_or_reset(b"$X"))

    def _send_or_reset(self, line):
        """Send a line; if the board refuses it as locked, reset the board and send it again: an alarm from before this page began may want that."""

        def take_answer(error):
            if error != errors.LOCKED or self.queue_command(Command(commands.RESET), lambda _: self.send_line(line, self._answer_typed)):
                self._answer_typed(error)

        return self.send_line(line, take_answer)

    def _jog_to(self, position, speed, counted, answered=None):
        return self.send_line(b"$J=" + _FROM[counted] + b"G21" + axis_words(position) + b"F%.1f" % speed, answered)

    def _setting_value(self, number):
        return float(self.settings.get(number, "1"))

    def set_setting(self, number, text):
        """Set a setting, and read all settings again. Returns 0 or an error."""
        error = GrblPage.set_setting(self, number, text)
        self._known = False
        return error

    def run_line(self, text):
        """Send a line as typed. Reads all settings again if it sets one. Returns 0 or an error."""
        error = self.busy_error() or self._say_typed(text)
        if text[:1] == "$" and "=" in text:
            self._known = False
        return error

    def leave_check(self):
        """End check mode by a reset, which works behind lines under way too, and unlock: the machine was ready before, and nothing has moved."""
        self.drop_jog()
        self._queue_pair(Command(commands.RESET), Command(commands.UNLOCK))

    def _may_jog(self, direction):
        return self._known and _Cabled._may_jog(self, direction)

    def presence_error(self):
        """Return PRESENCE if the report's inputs show that nobody is at the machine ("n"), else 0."""
        return errors.PRESENCE if "n" in self.state.get("pins", "") else 0

    # --- who commands

    def hand_over(self, owner):
        """Hand the command to "page" or "guest", only at rest. The page takes it back from another link of the board, too. Returns 0 or an error."""
        if owner == self.state["owner"]:
            return self.queue_command(Command(commands.HAND_OVER)) if owner == "page" else 0
        if self.busy_error() or self.wire.count_lines(GUEST) or self.wire.count_lines(PAGE):
            return errors.BUSY
        self.state["owner"] = owner
        self.guest.commanded = self.guest.commanded or owner == "guest"
        return 0


def axis_words(position):
    """The words X… Y… of G-code for {axis: mm}, bytes, with three decimals."""
    return b"".join([b"%s%.3f" % (axis.upper().encode(), position[axis]) for axis in AXES if axis in position])
