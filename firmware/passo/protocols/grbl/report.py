"""Text that the grbl language says; that of a few `$` lines stands in system.py."""

from array import array

from micropython import const

from passo.commands import STATUS_WORDS
from passo.protocols.gcode.reader import MAX_TOOL
from passo.protocols.gcode.words import round_half_away
from passo.protocols.grbl.text_viper import FARTHEST_MM, INCHES, MILLIMETRES, write_form, write_report
from passo.protocols.grbl.report_records import *
from passo.records import SEEN_LINE, SETTING_INCHES, SETTING_MAX_RPM, SETTING_REPORT

BANNER = "\r\nGrbl 1.1h ['$' for help]\r\n"
HELP = "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]"
NOTICES = (
    "", "Reset to continue", "'$H'|'$X' to unlock", "Caution: Unlocked", "Enabled", "Disabled", "Check Door",
    "Check Limits", "Sleeping", "Command handed over", "Pause: ~ to continue",
    "Tool change: T%d, ~ to continue", "Restoring spindle", "Steps missing: %s",
    "Gantry: %s", "", "Homing required: %s", "Caution: not homed, soft limits do not hold",
)  # fmt: skip
PROGRAMME_END = "Pgm End"
LETTERS = "Letters beyond ASCII acted: %s"
RESTORING = "Restoring defaults"

_STATES = {
    "idle": b"Idle", "run": b"Run", "hold": b"Hold:", "jog": b"Jog", "alarm": b"Alarm",
    "door": b"Door:", "check": b"Check", "home": b"Home", "sleep": b"Sleep",
}  # fmt: skip
# Numbers of the array that write_form() takes, from 1, as it wants them.
_BUFFERS = bytes((REPORT_BLOCKS // NUMBER_FIELDS + 1, 44, REPORT_ROOM // NUMBER_FIELDS + 1))
_LINE = bytes((REPORT_LINE // NUMBER_FIELDS + 1,))
_SPEEDS = bytes((REPORT_SPEED // NUMBER_FIELDS + 1, 44, REPORT_RPM // NUMBER_FIELDS + 1, 0))
_SPINDLES = ("", "", "", "S", "C", "")
_COOLANTS = ("", "F", "M", "FM")
_BUSY = ("run", "hold", "jog", "door", "home")
_WCO_BUSY = const(30)
_OVERRIDES_BUSY = const(20)
_IDLE = const(10)
_NM_PER_TENTH_MIL = const(2540)
_END = const(3)  # bytes of a report's end


def message_line(text):
    """Return a [MSG:…] line."""
    return "[MSG:%s]\r\n" % text


def log_lines(log):
    """The lines of $LOG, the oldest first: milliseconds, number, which link or input; then how many times each number
    has been since the start; of an interlock a line an input: name, active, how often it stopped the machine, glitches, when it
    last became active, milliseconds it was active (-1: it still is)."""
    lines = ["[LOG:%d,%d,%s]\r\n" % (ms, number, who or "") for ms, number, who in log.entries]
    if log.pins:
        lines += ["[PIN:%s,%d,%d,%d,%d,%d]\r\n" % pin for pin in log.pins()]
    counts = ["%dx%d" % (log.counts[number], number) for number in sorted(log.counts)]
    lines.append("[LOGGED:%s]\r\n" % ",".join(counts))
    return lines


def decimal_text(value, places):
    """Return `value` in units of 10⁻ᵖˡᵃᶜᵉˢ as text."""
    unit = 10**places
    sign = "-" if value < 0 else ""
    value = abs(value)
    return "%s%d.%0*d" % (sign, value // unit, places, value % unit) if places else sign + str(value)


def length_text(nm, inches):
    """Return nanometres as text: millimetres with three decimals, or inches with four."""
    return decimal_text(round_half_away(nm, _NM_PER_TENTH_MIL), 4) if inches else decimal_text(round_half_away(nm, 1000), 3)


def position_text(lengths, inches):
    """Return lengths of axes, nm, as text with commas."""
    return ",".join([length_text(nm, inches) for nm in lengths])


def rate_text(nm_s, inches):
    """Return a speed as text: whole mm/min, or in/min with one decimal."""
    return decimal_text(round_half_away(3 * nm_s, 127_000), 1) if inches else str(round_half_away(3 * nm_s, 50_000))


def modes_line(gcode, inches):
    """Return the [GC:…] line of $G."""
    motion = gcode.motion
    words = ["G" + (decimal_text(motion // 10, 1) if motion % 100 else str(motion // 100))]
    words.append("G%d G%d G%d" % (54 + gcode.system, gcode.plane, 20 if gcode.inches else 21))
    words.append("G%d G%d M%d" % (90 if gcode.absolute else 91, 94 if gcode.per_minute else 93, gcode.spindle))
    words.append(("M9", "M8", "M7", "M7 M8")[gcode.coolant])
    words.append("T%d F%s S%d" % (gcode.tool, rate_text(gcode.feed, inches), round_half_away(gcode.rpm, 1000)))
    return "[GC:%s]\r\n" % " ".join(words)


def parameter_lines(gcode, probed, touched, inches, homed):
    """Return the lines of $#. `probed`: the position of the last touch, nm; `touched`: whether there was one."""
    offsets = gcode.offsets
    lines = ["[G%d:%s]\r\n" % (54 + number, position_text(offsets.systems[number], inches)) for number in range(6)]
    lines += ["[G%d:%s]\r\n" % (number, position_text(offsets.homes[number], inches)) for number in (28, 30)]
    lines.append("[G92:%s]\r\n" % position_text(offsets.shift, inches))
    lines.append("[TLO:%s]\r\n" % length_text(offsets.tool, inches))
    for tool in range(1, MAX_TOOL + 1):
        text = offsets.length_of(tool)
        if text:
            lines.append("[T%d:%s]\r\n" % (tool, length_text(int(text), inches)))
    lines.append("[HOMED:%d]\r\n" % homed)
    lines.append(probe_line(probed, touched, inches))
    return lines


def probe_line(probed, touched, inches):
    """Return the [PRB:…] line."""
    return "[PRB:%s:%d]\r\n" % (position_text(probed, inches), 1 if touched else 0)


class Status:
    """The `<…>` report, which says some things only now and then."""

    def __init__(self, gcode, settings, machine):
        """`machine`: the record of the machine's state: steps_per_m."""
        self._gcode = gcode
        self._settings = settings
        self._machine = machine
        self._out = None  # made when first asked: many a link never is
        self.offsets = self.overrides = 0  # reports until they are due
        self._settings_of = self._offsets_of = self._system = None  # that the fields are of

    def _take_over(self):
        """Take over settings and offsets."""
        gcode = self._gcode
        settings = self._settings
        if self._out is None:
            self._out = bytearray(REPORT_LONGEST + _END)
            self._view = self._said = memoryview(self._out)
            self._fields = array("i", [0] * (REPORT_AXIS + REPORT_FIELDS * gcode.axes))
        self._settings_of = settings.version
        self._offsets_of = gcode.offsets.version
        self._system = gcode.system
        self._mask = settings.value(SETTING_REPORT)
        self._max_rpm = most = settings.value(SETTING_MAX_RPM)
        self._rpm = 0 if most % 1000 else most // 1000  # the same in whole rpm; 0: it has a fraction
        self._inches = settings.value(SETTING_INCHES) and not gcode.turns
        self._pins = self._power = self._state = self._percents = None  # that `_pressed`, the rpm, `_form` and `_overridden` are of
        self._words = None  # items of STATUS_WORDS whose key this machine's reports have; None: not looked up yet
        self._fields[REPORT_UNIT:REPORT_AXIS] = INCHES if self._inches else MILLIMETRES
        self._fields[REPORT_SPEED + NUMBER_FIRST] = 1 if self._inches else 0
        offsets = [gcode.offsets.offset_of(gcode.system, axis) for axis in range(gcode.axes)]
        self._offset = ("|WCO:%s\0" % position_text(offsets, self._inches)).encode()
        at = REPORT_AXIS
        for axis in range(gcode.axes):
            offset = 0 if self._mask & 1 else offsets[axis]
            self._fields[at + REPORT_STEPS_PER_M] = self._machine.steps_per_m[axis]
            self._fields[at + REPORT_OFFSET_MM] = max(0, min(offset // 1_000_000 + FARTHEST_MM, 2 * FARTHEST_MM))
            self._fields[at + REPORT_OFFSET_NM] = offset % 1_000_000
            at += REPORT_FIELDS

    # In small pieces, whose variables do not go on the heap (see app.py).

    def report_bytes(self, report, room):
        """Return a report, bytes that are good until the next one. `report`: the controller's; `room`: for lines, in bytes."""
        if self._offsets_of != self._gcode.offsets.version or self._system != self._gcode.system:
            self.offsets = 0
            self._take_over()
        elif self._settings_of != self._settings.version:
            self._take_over()
        self._fields[REPORT_ROOM + NUMBER_WHOLE] = room
        self._choose_form(report, report["seen"][SEEN_LINE] > 0)
        at = self._write_begin(report)
        pins = report["pins"]
        if pins:
            if pins != self._pins:
                self._pins = pins
                self._pressed = ("|Pn:%s\0" % pins).encode()
            at = write_form(self._out, at, self._pressed, self._fields)
        if self.offsets and self.overrides:
            self.offsets -= 1
            self.overrides -= 1
        else:
            at = self._now_and_then(report, at)
        self._out[at] = 62  # one by one: a slice takes longer
        self._out[at + 1] = 13
        self._out[at + 2] = 10
        at += _END
        if len(self._said) != at:
            self._said = self._view[:at]
        return self._said

    def _write_begin(self, report):
        """Write the part that each report has. Returns where it ends."""
        return write_report(self._out, self._form, self._fields, report["seen"], report["position"], self._gcode.axes)

    def _choose_form(self, report, numbered):
        """Take the power, and the form for the state; `numbered`: the line has a number."""
        power = report["power"]
        if power != self._power:
            self._power = power
            rpm = self._rpm
            if rpm and not power % 1000:  # as a laser's dots have it: without long integers in half the time
                rpm = (power // 1000 * rpm + 500) // 1000
            else:
                rpm = round_half_away(power * self._max_rpm, 1_000_000_000)
            self._fields[REPORT_RPM + NUMBER_WHOLE] = rpm
        state = report["state"]
        substate = report["substate"] if state == "hold" or state == "door" else -1
        if state == "alarm" and report["slows"]:  # on its way to the alarm's stand
            state = "hold"
            substate = 1
        if state != self._state or substate != self._substate or numbered != self._numbered:
            self._state = state
            self._substate = substate
            self._numbered = numbered
            self._form = self._make_form()

    def _make_form(self):
        """Return the form of a report up to FS, for write_form()."""
        form = b"<" + _STATES[self._state]
        if self._substate >= 0:
            form += b"%d" % self._substate
        form += b"|MPos:" if self._mask & 1 else b"|WPos:"
        form += b",".join([bytes((axis + 1,)) for axis in range(self._gcode.axes)])
        if self._mask & 2:
            form += b"|Bf:" + _BUFFERS
        if self._numbered:
            form += b"|Ln:" + _LINE
        return form + b"|FS:" + _SPEEDS

    def _now_and_then(self, report, at):
        """Write offsets, or overrides and accessories, if they are due. Returns where they end."""
        busy = report["state"] in _BUSY
        if self.offsets:
            self.offsets -= 1
        else:
            self.offsets = (_WCO_BUSY if busy else _IDLE) - 1
            self.overrides = self.overrides or 1
            at = write_form(self._out, at, self._offset, self._fields)
        if self.overrides:
            self.overrides -= 1
            return at
        self.overrides = (_OVERRIDES_BUSY if busy else _IDLE) - 1
        if self._percents != report["overrides"]:
            self._percents = list(report["overrides"])
            self._overridden = {}
        number = report["spindle"] << 2 | report["coolant"]
        if number not in self._overridden:
            self._overridden[number] = self._override_form(number >> 2, number & 3)
        at = write_form(self._out, at, self._overridden[number], self._fields)
        if self._words is None:
            self._words = [word for word in STATUS_WORDS if word[0] in report]
        for key, word in self._words:
            if report[key] is not None:
                at = write_form(self._out, at, ("|%s:%s\0" % (word, report[key])).encode(), self._fields)
        return at

    def _override_form(self, spindle, coolant):
        """Return overrides and accessories, for write_form()."""
        accessories = _SPINDLES[spindle] + _COOLANTS[coolant]
        return ("|Ov:%d,%d,%d" % tuple(self._percents) + ("|A:%s\0" % accessories if accessories else "\0")).encode()
