"""The page of a machine that gets G-code on its other links: keys and positions become commands, and so does the report; orders that belong
to the modal state of G-code (work zeros, spindle and coolant, settings, a line as typed) become lines of the page's own link.

    machine = GrblPage(record, number, board, tell, spoken)     # `spoken`: what understands lines, and has their state
"""

from micropython import const

from passo import commands, errors
from passo.commands import NOTICE, RESTARTED, Command
from passo.protocols.page.jog import Limits
from passo.protocols.page.page_machine import PageMachine
from passo.records import SEEN_LINE, SEEN_MM_S, SEEN_NM_S, SEEN_ROOM, SETTING_MAX_RPM

AXES = "xyza"
_AXIS_SPEED = const(110)  # settings $110 …, thousandths
_AXIS_ACCELERATION = const(120)
_NM = const(1000)  # to which a position of the page is rounded: three decimals of a millimetre
_OVERRIDES = {"feed": commands.FEED, "rapid": commands.RAPID, "spindle": commands.POWER}
_PERCENT = ("100", "+10", "-10", "+1", "-1")
_RAPID = ("100", "50", "25")
OUTPUTS = {"spindle_cw": "M3", "spindle_ccw": "M4", "spindle_off": "M5", "mist": "M7", "flood": "M8", "coolant_off": "M9"}
_MACHINE, _WORK, _HERE = const(53), const(54), const(91)  # the origin of a position


def override_of(what, to):
    """The command that sets an override `what` (feed, rapid, spindle) to a percentage, or changes it by "+10", "-10", "+1", "-1"; None: there is no
    such override or step."""
    value = _OVERRIDES.get(what)
    if value is None or to not in (_RAPID if what == "rapid" else _PERCENT):
        return None
    command = Command(commands.OVERRIDE, value=value)
    if to[0] in "+-":
        command.feed = int(to)
    else:
        command.power = int(to)
    return command


class GrblPage(PageMachine):
    language = "grbl"
    speaks = True
    from_here = ("jog",)  # the others count from where the queue ends
    can = (
        "place", "jog", "step", "goto", "zero", "home", "unlock", "hold", "resume", "overrides", "outputs", "settings", "log",
        "line", "signals", "diagonal", "jog_speed",
    )  # fmt: skip

    def __init__(self, record, number, board, tell, spoken):
        PageMachine.__init__(self, record, number, board, tell)
        self._spoken = spoken
        self._gcode = spoken and spoken.gcode  # a PC has neither
        if spoken and spoken.gcode.turns:
            self.turns = AXES[3:]
        self._settings = record.settings
        self._version = -1  # of the settings that pages have
        self._line = b""  # to be carried out
        self._typing = False  # one is under way
        self._dwell = self._dwelt_ms = 0
        self.state["why"] = ""

    # --- commands

    def commands(self):
        """Yield the page's commands, then those of a line of G-code."""
        while self.said:
            said = self.said.pop(0)
            self.unanswered.append(said)
            yield said[0]
        if self._line or self._spoken.pending():
            line, self._line = self._line, b""
            for command in self._spoken.feed(line, self._now_ms):
                if command.kind == commands.DWELL:
                    self._dwell, self._dwelt_ms = command.value // 1000, self._now_ms
                yield command

    def pending(self):
        return self.said or self._line or self._spoken.pending()

    def take_answer(self, event):
        """Take the answer to a command. Sends the answers to a typed line to all pages. Returns its error."""
        said = b"" if [1 for each in self.unanswered if each[0] is event.command] else self._spoken.reply(event)
        if not said:
            if event.kind == commands.REFUSED:
                self._gcode.forget_position()
            return PageMachine.take_answer(self, event)
        error = 0
        lines = bytes(said).decode().split("\r\n")  # a report is a part of a buffer
        values = "\n".join([line for line in lines if line[:1] in ("$", "<")])  # $$ and ?, in one message
        if values:
            self._tell({"t": "said", "text": values})
        for line in lines:
            if line == "ok" or line[:6] == "error:":
                self._typing = False
                error = int(line[6:] or 0)
                self.note_result(error)
                self._tell({"t": "said", "text": line})
            elif line[:1] == "[":
                self._tell({"t": "said", "text": line})
        return error

    def take_event(self, event):
        """Take an event that the machine sends unasked: show pauses, tool changes, messages and a restart."""
        said = self._spoken.push_bytes(event)
        if event.kind == NOTICE and event.error == errors.NOTICE_PAUSE:
            self.state["why"] = "pause"
        elif event.kind == NOTICE and event.error == errors.NOTICE_TOOL:
            self.state["why"] = "T%d" % event.value
        if event.kind == RESTARTED:
            self._line = b""
            self._typing = False
            self._tell({"t": "said", "text": said.decode().strip()})
        elif said[:1] == b"[" and (self._typing or self.unanswered):
            self._tell({"t": "said", "text": said.decode().strip()})
        PageMachine.take_event(self, event)

    def drop(self, event):
        """Forget the commands and the line given before: another link, or an alarm, has stopped the machine."""
        said = self._spoken.drop(event)
        if said:  # another link has stopped the machine
            self._tell({"t": "said", "text": said.decode().strip()})
        self._line = b""
        self._typing = False
        PageMachine.drop(self, event)

    # --- what the machine says

    def _show_fields(self, report):
        """Show positions in mm, feed in mm/min, spindle in rpm, overrides and inputs; follow changed settings."""
        state = self.state
        name = report["state"]
        sub = report["substate"] if name in ("hold", "door") else ""
        if name == "alarm" and report["slows"]:  # on its way to the alarm's stand it is held
            name, sub = "hold", 1
        state["state"] = self._state_word(name)
        state["sub"] = str(sub)
        if state["alarm"] == errors.ALARM_LOCKED:
            state["alarm"] = 0  # nothing is wrong
        if name != "hold":
            state["why"] = ""
        offsets, system = self._gcode.offsets, self._gcode.system
        steps = report["position"]
        position = self.position = state["m"] = [round(steps[axis] / self.scale[axis], 4) for axis in range(len(self.scale))]
        state["w"] = [round(position[axis] - offsets.offset_of(system, axis) / 1_000_000, 4) for axis in range(len(position))]
        seen = report["seen"]
        state["feed"] = 60 * seen[SEEN_MM_S] + round(seen[SEEN_NM_S] * 3 / 50_000)
        state["rpm"] = (report["power"] * self._settings.value(SETTING_MAX_RPM) + 500_000_000) // 1_000_000_000
        state["pins"] = report["pins"]
        state["line"] = seen[SEEN_LINE]
        state["full"] = 100 - 100 * seen[SEEN_ROOM] // self._spoken.system.blocks
        state["ov"] = list(report["overrides"])
        state["on"] = ("", "", "", "S", "C", "")[report["spindle"]] + ("", "F", "M", "FM")[report["coolant"]]
        state["wait"] = self._wait_ms() / 1000
        if self._version != self._settings.version:
            self._take_settings()
        if self.jog.active:
            self.jog.report(position)

    def _wait_ms(self):
        """The milliseconds that a G4 still lasts, 0: none is under way."""
        if not self._record.busy_with(commands.DWELL):
            return 0
        return max(0, self._dwell - (self._now_ms - self._dwelt_ms) % 0x20000000)

    def _follow_settings(self, settings):
        """Do nothing: _take_settings() follows the settings' version."""

    def settings_texts(self):
        return self.settings

    def _take_settings(self):
        self._version = self._settings.version
        self.scale = [resolution / 1000 for resolution in self._record.steps_per_m]
        show = self._spoken.system.setting_text
        self.settings = {number: show(number) for number in self._settings.numbers}
        self._tell({"t": "settings", "axes": self.axes, "settings": self.settings})

    # --- orders

    def stop(self):
        """Queue a reset at once, and forget commands and lines that wait. Returns 0."""
        self.said = []
        self._line = b""
        self.drop_jog()
        return self.queue_command(Command(commands.RESET))

    def home(self):
        """Queue homing, in an alarm that wants it behind a reset. Returns 0 or an error."""
        return self._reset_before(lambda: self._queue_line("$H"))

    def unlock(self):
        """Queue the unlock, in an alarm that wants it behind a reset. Returns 0 or an error."""
        return self._reset_before(lambda: self.queue_command(Command(commands.UNLOCK)))

    def _reset_before(self, say):
        """Call `say()`, in an alarm that only a reset ends behind a reset. Returns 0 or an error."""
        if not errors.ALARMS.get(self._record.alarm, 0) & errors.NEEDS_RESET:
            return say()
        return self.queue_command(Command(commands.RESET), lambda error: say())

    def _queue_line(self, line):
        """Queue a line for the G-code of the page's link. Returns 0, or TOO_MANY_WAITING while one is under way."""
        if self._typing:
            return errors.TOO_MANY_WAITING
        self._typing = True
        self._line = line.encode() + b"\n"
        return 0

    def set_work_zero(self, axes):
        """Set the work zero of `axes`, letters, to where the machine stands (G10 L20). Returns 0 or an error."""
        return self.busy_error() or self._queue_line("G10L20P0" + "".join([axis.upper() + "0" for axis in axes]))

    def set_output(self, name, rpm):
        """Switch an output by its M word, the spindle at `rpm`. Returns 0 or an error."""
        word = OUTPUTS.get(name)
        if word is None:
            return errors.NUMBER
        return self.busy_error() or self._queue_line(word + ("S%d" % rpm if name[:9] == "spindle_c" else ""))

    def set_setting(self, number, text):
        return self.busy_error() or self._queue_line("$%d=%s" % (number, text))

    def run_line(self, text):
        return self.busy_error() or self._queue_line(text)

    def set_override(self, what, to):
        command = override_of(what, to)
        return self.queue_command(command) if command else errors.NUMBER

    def go_to(self, position, speed):
        """Jog straight to `position`, {axis: mm} in work coordinates, at `speed` mm/min; hold and STOP end it. Returns 0 or an error."""
        return self.busy_error() or self._jog_to(position, speed, _WORK)

    def step_by(self, way, speed):
        """Jog straight by `way`, {axis: mm}, at `speed` mm/min. Returns 0 or an error."""
        return self.busy_error() or self._jog_to(way, speed, _HERE)

    def _jog_to(self, position, speed, counted, answered=None):
        """Queue a jog to `position`, {axis: mm}, at `speed` mm/min; `counted`: its origin, _MACHINE, _WORK or _HERE. Returns 0 or an error."""
        nm = {AXES.find(axis): round(position[axis] * 1000) * _NM for axis in position}
        error = self._gcode.jog_to(nm, (round(speed * 10) * 100_000 + 30) // 60, counted)
        return error or self.queue_command(self._gcode.commands[0], answered)

    # --- the jog

    def _brake(self):
        self.queue_command(Command(commands.JOG_CANCEL))

    def _limits(self):
        """Each axis' speed and acceleration, from settings $110 … and $120 …"""
        axes = range(len(self.position))
        return Limits(*[[self._setting_value(first + axis) for axis in axes] for first in (_AXIS_SPEED, _AXIS_ACCELERATION)])

    def _setting_value(self, number):
        return self._settings.value(number) / 1000

    def _queue_jog(self, position, speed):
        target = {AXES[axis]: position[axis] for axis in range(len(position))}
        return not self._jog_to(target, speed, _MACHINE, self.jog_answered)
