"""All text that the grbl language says, formed in one place."""

from array import array

from micropython import const

from passo.protocols.gcode.words import rounded
from passo.protocols.grbl.text_viper import FARTHEST_MM, INCHES, MILLIMETRES, places, tell
from passo.records import (
    NUMBER_DECIMALS, NUMBER_FIELDS, NUMBER_FIRST, NUMBER_WHOLE, REPORT_AXIS, REPORT_FIELDS, REPORT_OFFSET_MM, REPORT_OFFSET_NM,
    REPORT_STEPS_PER_M, REPORT_UNIT, SETTING_INCHES, SETTING_MAX_RPM, SETTING_REPORT,
)  # fmt: skip

VERSION = "1.1h"
DATE = "20190830"  # of the grbl whose interface this is
BANNER = "\r\nGrbl 1.1h ['$' for help]\r\n"
HELP = "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]"
NOTICES = (
    "", "Reset to continue", "'$H'|'$X' to unlock", "Caution: Unlocked", "Enabled", "Disabled", "Check Door",
    "Check Limits", "Sleeping", "Command handed over", "No S-curves on this board", "Pause: ~ to continue",
    "Tool change: T%d, ~ to continue", "Restoring spindle",
)  # fmt: skip
PROGRAMME_END = "Pgm End"
RESTORING = "Restoring defaults"

_STATES = {
    "idle": b"<Idle\0", "run": b"<Run\0", "hold": b"<Hold:\0", "jog": b"<Jog\0", "alarm": b"<Alarm\0",
    "door": b"<Door:\0", "check": b"<Check\0", "home": b"<Home\0", "sleep": b"<Sleep\0",
}  # fmt: skip
_BUSY = ("run", "hold", "jog", "door", "home")
_WCO_BUSY = const(30)
_OVERRIDES_BUSY = const(20)
_IDLE = const(10)
_NM_PER_TENTH_MIL = const(2540)
_LONGEST = const(224)  # bytes of a report
_SECOND = const(NUMBER_FIELDS)  # number of a row
_THIRD = const(2 * NUMBER_FIELDS)


def message(text):
    return "[MSG:%s]\r\n" % text


def link(number, name):
    """The line of $LINK: who may command."""
    return "[LINK:%d,%s]\r\n" % (number, name)


def masks(settings):
    """The line of $MASKS: what the board file says of the settings that are masks, by which old ones are converted."""
    return "[MASKS:%s]\r\n" % ",".join(["%d=%d" % item for item in settings.masks()])


def log(log):
    """The lines of $LOG, the oldest first: milliseconds, number, which link or input; then how many times each number
    has been since the start; of an interlock a line an input: name, active, how often it stopped the machine, glitches, when it
    last became active, milliseconds it was so (-1: it still is)."""
    lines = ["[LOG:%d,%d,%s]\r\n" % (ms, number, who or "") for ms, number, who in log.entries]
    if log.pins:
        lines += ["[PIN:%s,%d,%d,%d,%d,%d]\r\n" % pin for pin in log.pins()]
    counts = ["%dx%d" % (log.counts[number], number) for number in sorted(log.counts)]
    return "".join(lines) + "[LOGGED:%s]\r\n" % ",".join(counts)


def decimal(value, places):
    """`value` in units of 10⁻ᵖˡᵃᶜᵉˢ as text."""
    unit = 10**places
    sign = "-" if value < 0 else ""
    value = abs(value)
    return "%s%d.%0*d" % (sign, value // unit, places, value % unit) if places else sign + str(value)


def length(nm, inches):
    """Nanometres as text: millimetres with three decimals, or inches with four."""
    return decimal(rounded(nm, _NM_PER_TENTH_MIL), 4) if inches else decimal(rounded(nm, 1000), 3)


def place(lengths, inches):
    return ",".join([length(nm, inches) for nm in lengths])


def rate(nm_s, inches):
    """A speed as text: whole mm/min, or in/min with one decimal."""
    speed = _minute(nm_s, inches)
    return decimal(speed, 1) if inches else str(speed)


def _minute(nm_s, inches):
    """A speed in mm/min, or tenths of inches a minute, rounded; in parts, so that it takes no large integers."""
    unit = 127_000 if inches else 50_000
    return 3 * (nm_s // unit) + (3 * (nm_s % unit) + unit // 2) // unit


def modes(gcode, inches):
    """The [GC:…] line of $G."""
    motion = gcode.motion
    words = ["G" + (decimal(motion // 10, 1) if motion % 100 else str(motion // 100))]
    words.append("G%d G%d G%d" % (54 + gcode.system, gcode.plane, 20 if gcode.inches else 21))
    words.append("G%d G%d M%d" % (90 if gcode.absolute else 91, 94 if gcode.per_minute else 93, gcode.spindle))
    words.append(("M9", "M8", "M7", "M7 M8")[gcode.coolant])
    words.append("T%d F%s S%d" % (gcode.tool, rate(gcode.feed, inches), rounded(gcode.rpm, 1000)))
    return "[GC:%s]\r\n" % " ".join(words)


def parameters(gcode, probed, touched, inches):
    """The lines of $#; `probed` is the place of the last touch in nm, `touched` whether there was one."""
    offsets = gcode.offsets
    lines = ["[G%d:%s]" % (54 + number, place(offsets.systems[number], inches)) for number in range(6)]
    lines += ["[G%d:%s]" % (number, place(offsets.homes[number], inches)) for number in (28, 30)]
    lines.append("[G92:%s]" % place(offsets.shift, inches))
    lines.append("[TLO:%s]" % length(offsets.tool, inches))
    return "\r\n".join(lines) + "\r\n" + probe(probed, touched, inches)


def probe(probed, touched, inches):
    return "[PRB:%s:%d]\r\n" % (place(probed, inches), 1 if touched else 0)


class Status:
    """The `<…>` report, which says some things only now and then."""

    def __init__(self, gcode, settings, machine):
        """`machine`: the record of the machine's state: steps_per_m."""
        self._gcode = gcode
        self._settings = settings
        self._machine = machine
        self._out = None  # made when first asked: many a link never is
        self.reset()

    def reset(self):
        self._wco = 0  # reports until the offsets are due
        self.overrides = 0
        self._settings_of = self._offsets_of = self._system = None  # that the figures are of

    def _take_over(self):
        """Settings and offsets."""
        gcode = self._gcode
        settings = self._settings
        if self._out is None:
            self._out = bytearray(_LONGEST)
            self._view = self._said = memoryview(self._out)
            self._fields = array("i", [0] * (REPORT_AXIS + REPORT_FIELDS * gcode.axes))
        self._settings_of = settings.version
        self._offsets_of = gcode.offsets.version
        self._system = gcode.system
        self._mask = settings.value(SETTING_REPORT)
        self._inches = settings.value(SETTING_INCHES)
        self._pins = self._power = None  # that `_pressed` and `_rpm` are of
        self._fields[REPORT_UNIT:REPORT_AXIS] = INCHES if self._inches else MILLIMETRES
        offsets = [gcode.offsets.of(gcode.system, axis) for axis in range(gcode.axes)]
        self._offset = ("|WCO:%s\0" % place(offsets, self._inches)).encode()
        at = REPORT_AXIS
        for axis in range(gcode.axes):
            offset = 0 if self._mask & 1 else offsets[axis]
            self._fields[at + REPORT_STEPS_PER_M] = self._machine.steps_per_m[axis]
            self._fields[at + REPORT_OFFSET_MM] = max(0, min(offset // 1_000_000 + FARTHEST_MM, 2 * FARTHEST_MM))
            self._fields[at + REPORT_OFFSET_NM] = offset % 1_000_000
            at += REPORT_FIELDS

    # In small pieces, whose variables do not go on the heap (see app.py).

    def text(self, report, room):
        """As bytes that are good until the next report. `report`: the controller's; `room`: for so many bytes of lines."""
        gcode = self._gcode
        if self._offsets_of != gcode.offsets.version or self._system != gcode.system:
            self._wco = 0
            self._take_over()
        elif self._settings_of != self._settings.version:
            self._take_over()
        self._at = 0
        self._tell_place(report)
        if self._mask & 2:
            self._fields[NUMBER_WHOLE] = report["blocks"]
            self._fields[_SECOND + NUMBER_WHOLE] = room
            self._tell(b"|Bf:\0", 2)
        self._tell_speed(report)
        pins = report["pins"]
        if pins:
            if pins != self._pins:
                self._pins = pins
                self._pressed = ("|Pn:%s\0" % pins).encode()
            self._tell(self._pressed, 0)
        if self._wco and self.overrides:
            self._wco -= 1
            self.overrides -= 1
        else:
            self._now_and_then(report)
        self._tell(b">\r\n\0", 0)
        if len(self._said) != self._at:
            self._said = self._view[: self._at]
        return self._said

    def _tell(self, label, count):
        """Append `label` and the first `count` numbers of `_fields`, NUMBER_… of records.py each; of a whole one NUMBER_FIRST is 0."""
        self._at = tell(self._out, self._at, label, self._fields, count)

    def _tell_place(self, report):
        fields = self._fields
        state = report["state"]
        if state == "hold" or state == "door":
            fields[NUMBER_WHOLE] = report["substate"]
            fields[NUMBER_FIRST] = 0
            self._tell(_STATES[state], 1)
        else:
            self._tell(_STATES[state], 0)
        axes = self._gcode.axes
        places(fields, report["position"], axes)
        self._tell(b"|MPos:\0" if self._mask & 1 else b"|WPos:\0", axes)
        fields[NUMBER_FIRST] = fields[_SECOND + NUMBER_FIRST] = 0

    def _tell_speed(self, report):
        fields = self._fields
        if report["number"]:
            fields[NUMBER_WHOLE] = report["number"]
            self._tell(b"|Ln:\0", 1)
        speed = _minute(report["feed"], self._inches)
        if self._inches:
            fields[NUMBER_DECIMALS] = speed % 10
            fields[NUMBER_FIRST] = 1
            speed //= 10
        fields[NUMBER_WHOLE] = speed
        power = report["power"]
        if power != self._power:
            self._power = power
            self._rpm = rounded(power * self._settings.value(SETTING_MAX_RPM), 1_000_000_000)
        fields[_SECOND + NUMBER_WHOLE] = self._rpm
        self._tell(b"|FS:\0", 2)

    def _now_and_then(self, report):
        busy = report["state"] in _BUSY
        if self._wco:
            self._wco -= 1
        else:
            self._wco = (_WCO_BUSY if busy else _IDLE) - 1
            self.overrides = self.overrides or 1
            self._tell(self._offset, 0)
        if self.overrides:
            self.overrides -= 1
            return
        self.overrides = (_OVERRIDES_BUSY if busy else _IDLE) - 1
        fields = self._fields
        fields[NUMBER_WHOLE], fields[_SECOND + NUMBER_WHOLE], fields[_THIRD + NUMBER_WHOLE] = report["overrides"]
        fields[NUMBER_FIRST] = fields[_SECOND + NUMBER_FIRST] = fields[_THIRD + NUMBER_FIRST] = 0
        self._tell(b"|Ov:\0", 3)
        accessories = ("", "", "", "S", "C", "")[report["spindle"]] + ("", "F", "M", "FM")[report["coolant"]]
        if accessories:
            self._tell(("|A:%s\0" % accessories).encode(), 0)
        if "glitches" in report and report["glitches"]:
            self._tell(("|Gl:%d\0" % report["glitches"]).encode(), 0)
