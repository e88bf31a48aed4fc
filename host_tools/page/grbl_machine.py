"""A machine that speaks grbl, as the page sees it: orders in, one state out.

    machine = GrblMachine(write, tell)      # tell(event): a dict for every page
    machine.feed(data, now_ms)              # bytes from the board
    machine.poll(now_ms)                    # some hundred times a second
    error = machine.order("hold", {})       # 0, or a number of errors
    machine.state                           # a dict

It asks for reports, streams jobs, feeds a jog while its lease lasts, and lets a guest speak on the same wire.
"""

from micropython import const

from host_tools.page.cable_machine import CableMachine
from host_tools.page.guest import Guest
from host_tools.page.job import Job
from host_tools.page.wire import GUEST, PAGE, Wire, dwell_ms, fields_of
from passo import commands, errors
from passo.protocols.grbl.real_time import real_time
from passo.protocols.page.grbl import AXES, OUTPUTS, GrblPage, override_of
from passo.protocols.page.jog import Limits
from passo.protocols.page.lease import since

_RESET = b"\x18"
_HOLD = b"!"
_RESUME = b"~"
_JOG_CANCEL = b"\x85"
_AXIS_SPEED = const(110)  # $110 …
_AXIS_ACCELERATION = const(120)
_OVERRIDES = {}  # the byte of each: (which, percent, change)
for _byte in range(0x90, 0x9E):
    _command = real_time(_byte)
    if _command:
        _OVERRIDES[_command.value, _command.power, _command.feed] = _byte


class GrblMachine(CableMachine):
    language = "grbl"
    can = GrblPage.can + ("jobs", "teach", "single")

    def __init__(self, write, tell, guest=None):
        """`write(bytes)`: to the board; `guest(bytes)`: to the guest, if there may be one."""
        CableMachine.__init__(self, tell, Job(self))
        self.wire = Wire(write, self._heard)
        self.guest = Guest(self, guest)
        self._offset = None
        self._waits = b""  # the line that is answered next
        self._wait_ms = self._counted_ms = 0
        self._known = False  # the settings have been asked for
        self.options = None  # letters of [OPT:…]: J, a journal; F, stored jobs; None: not known yet
        self._letters = ""
        self._behind = b""  # what is said once the board has been reset

    # --- bytes

    def feed(self, data, now_ms):
        self._now_ms = now_ms
        self.wire.feed(data)

    def _ask(self):
        self.wire.write(b"?")

    def _go_on(self):
        if not self._known and self.stands() and self.wire.room(len(b"$I\n$$")):
            if self.options is None:
                self.wire.say(PAGE, b"$I", self._options_known)
            self._known = self.wire.say(PAGE, b"$$", self._all_known)

    def _options_known(self, error):
        if not error:
            self.options = self._letters

    def lost(self):
        """There is no board any more: it is about to be another one."""
        self.wire.drop()
        self._lose()
        self.settings = {}
        self.place = self._offset = None

    def _lose(self):
        self._known = False
        self.options = None
        CableMachine._lose(self)

    def _all_known(self, error):
        if error:
            self._known = False
            return
        self.axes = AXES[: len([number for number in self.settings if 100 <= number < 104])]
        self._tell({"t": "settings", "axes": self.axes, "settings": self.settings})

    def _heard(self, line, owner):
        if line[:1] == "<" and line[-1:] == ">":
            self._report(fields_of(line))
            self.guest.report(line)
            return
        if line[:1] == "$" and owner == PAGE:
            number, _, value = line[1:].partition("=")
            if number.isdigit():
                self.settings[int(number)] = value
            return
        if line[:6] == "ALARM:":
            self.state["alarm"] = 200 + int(line[6:])
            self.end_jog()
            self.job.fail(self.state["alarm"])
            self.note(self.state["alarm"])
        elif line[:5] == "Grbl ":
            self.end_jog()
            self.job.fail(errors.STOPPED)
            self.state["alarm"] = 0
            behind = self._behind
            self._behind = b""
            if behind:
                self.say(behind)
        elif line[:11] == "[MSG:Pause:":
            self.state["why"] = "pause"
        elif line[:18] == "[MSG:Tool change: ":
            self.state["why"] = line[18:].split(",")[0]
        elif line[:5] in ("[VER:", "[OPT:") and owner == PAGE and self.options is None:
            if line[1] == "O":
                self._letters = line[5:].split(",")[0]
        elif line[:1] == "[" and not self.job.heard(line) and owner == PAGE:
            self._tell({"t": "said", "text": line})
        if owner != PAGE or line[:1] != "[" or line[:5] == "[MSG:":
            self.guest.hear(line)

    def _report(self, fields):
        state = self.state
        self._reported()
        name, _, sub = fields["state"].partition(":")
        if name not in ("Alarm", "Hold", "Door"):  # on its way to an alarm's stand it is held
            state["alarm"] = 0
        if name != "Hold":
            state["why"] = ""
        state["state"] = name
        state["sub"] = sub
        self._places(fields)
        speeds = fields.get("FS", fields.get("F", "0")).split(",")
        state["feed"] = float(speeds[0])
        state["rpm"] = float(speeds[1]) if len(speeds) > 1 else 0.0
        state["pins"] = fields.get("Pn", "")
        state["line"] = int(fields.get("Ln", "0"))
        self._count_down(name == "Run" and not state["feed"])
        if "Ov" in fields:
            state["ov"] = [int(part) for part in fields["Ov"].split(",")]
            state["on"] = fields.get("A", "")
            state["stored"] = fields.get("SD", "")
            state["more"] = [[word, fields[word]] for _, word in commands.STATUS_WORDS if word in fields]
        if self.jog.active:
            self.jog.report(self.place)
        self.job.report("" if name == "Hold" and sub == "1" else name)  # it is still braking
        if self.watcher:
            self.watcher(state)

    def _count_down(self, stands):
        """How long a G4 still lasts: its line is answered at its end, and the machine stands meanwhile."""
        line = self.wire.oldest()
        if line is not self._waits:
            self._waits = line
            self._wait_ms = dwell_ms(line)
        elif self._wait_ms and stands:
            self._wait_ms = max(0, self._wait_ms - since(self._now_ms, self._counted_ms))
        self._counted_ms = self._now_ms
        self.state["wait"] = self._wait_ms / 1000 if stands else 0

    def _places(self, fields):
        if "WCO" in fields:
            self._offset = [float(part) for part in fields["WCO"].split(",")]
        told = [float(part) for part in fields.get("MPos", fields.get("WPos", "0")).split(",")]
        offset = self._offset if self._offset and len(self._offset) == len(told) else [0.0] * len(told)
        machine = told if "MPos" in fields else [told[axis] + offset[axis] for axis in range(len(told))]
        self.place = machine
        self.state["m"] = machine
        self.state["w"] = [round(machine[axis] - offset[axis], 4) for axis in range(len(told))]

    def say(self, line):
        """A line of the page; 0, or why it cannot be said."""
        return 0 if self.wire.say(PAGE, line, self.finished) else errors.TOO_MANY_WAITING

    # --- orders

    def absent(self):
        """0, or why who orders over a network may not start the tool or go on: the board wants somebody at the machine."""
        return errors.PRESENCE if "n" in self.state.get("pins", "") else 0

    def stop(self):
        """Stop at once: who asks does not matter."""
        self.drop_jog()
        self.job.fail(errors.STOPPED)
        self.wire.write(_RESET)
        return 0

    def leave_check(self):
        """A reset leaves the mode, also behind lines that are still under way; the machine was ready before, and nothing has moved."""
        self.drop_jog()
        self._behind = b"$X"
        self.wire.write(_RESET)

    def hold(self):
        self.end_jog()
        self.wire.write(_HOLD)
        return 0

    def resume(self):
        self.wire.write(_RESUME)
        return 0

    def home(self):
        return self._begin_anew(b"$H")

    def unlock(self):
        return self._begin_anew(b"$X")

    def _begin_anew(self, line):
        """Say `line`; of an alarm that only a reset ends, reset the board first, and say it behind that."""
        if self.state["state"] != "Alarm" or self.state["alarm"] not in errors.NEED_RESET:
            return self.say(line)
        self._behind = line
        self.wire.write(_RESET)
        return 0

    def zero(self, axes):
        """Work zero of the axes named is here."""
        return self.still() or self.say(b"G10L20P0" + b"".join([b"%s0" % axis.upper().encode() for axis in axes]))

    def go(self, place, speed):
        """{axis: mm} of work coordinates, straight, as a jog that hold and STOP end."""
        return self.still() or self.say(b"$J=G90G21" + words(place) + b"F%.1f" % speed)

    def step(self, way, speed):
        """{axis: mm} from here."""
        return self.still() or self.say(b"$J=G91G21" + words(way) + b"F%.1f" % speed)

    def override(self, what, to):
        command = override_of(what, to)
        if command is None:
            return errors.NUMBER
        self.wire.write(bytes((_OVERRIDES[command.value, command.power, command.feed],)))
        return 0

    def output(self, name, rpm):
        word = OUTPUTS.get(name)
        if word is None:
            return errors.NUMBER
        return self.still() or self.say(word.encode() + (b"S%d" % rpm if name[:9] == "spindle_c" else b""))

    def set(self, number, text):
        """Change a setting."""
        error = self.still() or self.say(b"$%d=%s" % (number, text.encode()))
        self._known = False
        return error

    def line(self, text):
        """A line as typed."""
        return self.still() or self.say(text.encode())

    def play(self, what):
        """Go on with a job that goes line by line: "step", one line; "run", all the rest."""
        if what == "step":
            return self.job.step()
        return self.job.go() if what == "run" else errors.UNKNOWN_COMMAND

    # --- the jog

    def _may_jog(self, direction):
        return self._known and CableMachine._may_jog(self, direction)

    def _brake(self):
        self.wire.write(_JOG_CANCEL)

    def _limits(self):
        axes = range(len(self.place))
        return Limits(*[[float(self.settings.get(first + axis, "1")) for axis in axes] for first in (_AXIS_SPEED, _AXIS_ACCELERATION)])

    def _say_jog(self, place, speed):
        line = b"$J=G90G53G21" + words({AXES[axis]: place[axis] for axis in range(len(place))}) + b"F%.1f" % speed
        return self.wire.say(PAGE, line, self.jog_answered)

    # --- who commands

    def give(self, owner):
        """Hand the command over: "page" or "guest"; only at rest."""
        if owner != self.state["owner"]:
            if self.still() or self.wire.of(GUEST) or self.wire.of(PAGE):
                return errors.BUSY
            self.state["owner"] = owner
            self.guest.commanded = self.guest.commanded or owner == "guest"
        return 0


def words(place):
    """X… Y… of {axis: mm}."""
    return b"".join([b"%s%.3f" % (axis.upper().encode(), place[axis]) for axis in AXES if axis in place])
