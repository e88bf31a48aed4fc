"""All text that the grbl language says, formed in one place."""

from micropython import const

from passo.protocols.gcode_words import rounded

VERSION = "1.1h"
DATE = "20190830"  # of the grbl whose interface this is
BANNER = "\r\nGrbl 1.1h ['$' for help]\r\n"
HELP = "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]"
RX_BYTES = const(128)
NOTICES = (
    "", "Reset to continue", "'$H'|'$X' to unlock", "Caution: Unlocked", "Enabled", "Disabled", "Check Door",
    "Check Limits", "Sleeping", "Command handed over",
)  # fmt: skip
PROGRAMME_END = "Pgm End"
RESTORING = "Restoring defaults"

_STATES = {
    "idle": "Idle", "run": "Run", "hold": "Hold:", "jog": "Jog", "alarm": "Alarm", "door": "Door:", "check": "Check",
    "home": "Home", "sleep": "Sleep",
}  # fmt: skip
_BUSY = ("run", "hold", "jog", "door", "home")
_WCO_BUSY = const(30)
_OVERRIDES_BUSY = const(20)
_IDLE = const(10)
_NM_PER_TENTH_MIL = const(2540)


def message(text):
    return "[MSG:%s]\r\n" % text


def link(number, name):
    """The line of $LINK: who may command."""
    return "[LINK:%d,%s]\r\n" % (number, name)


def log(log):
    """The lines of $LOG, the oldest first: milliseconds, number, which link or input; then how many times each number
    has been since the start."""
    lines = ["[LOG:%d,%d,%s]\r\n" % (ms, number, who or "") for ms, number, who in log.entries]
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


def place(places, inches):
    return ",".join([length(nm, inches) for nm in places])


def rate(nm_s, inches):
    """A speed as text: whole mm/min, or in/min with one decimal."""
    return decimal(rounded(nm_s * 60, _NM_PER_TENTH_MIL * 1000), 1) if inches else str(rounded(nm_s * 60, 1_000_000))


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

    def __init__(self):
        self.reset()

    def reset(self):
        self._wco = 0  # reports until the offsets are due
        self._overrides = 0
        self._version = None

    def text(self, report, gcode, scale, settings):
        """`report`: the controller's; `scale`: nm of so many steps of an axis; `settings`: (mask $10, inches $13,
        max_rpm $30 in thousandths)."""
        mask, inches, max_rpm = settings
        state = report["state"]
        text = "<" + _STATES[state]
        if state in ("hold", "door"):
            text += str(report["substate"])
        offset = [gcode.offsets.of(gcode.system, axis) for axis in range(gcode.axes)]
        here = [scale(axis, report["position"][axis]) for axis in range(gcode.axes)]
        if mask & 1:
            text += "|MPos:" + place(here, inches)
        else:
            text += "|WPos:" + place([at - by for at, by in zip(here, offset)], inches)
        if mask & 2:
            text += "|Bf:%d,%d" % (report["blocks"], report["bytes"])
        if report["number"]:
            text += "|Ln:%d" % report["number"]
        text += "|FS:%s,%d" % (rate(report["feed"], inches), rounded(report["power"] * max_rpm, 1_000_000_000))
        if report["pins"]:
            text += "|Pn:" + report["pins"]
        return text + self._now_and_then(report, gcode, offset, inches) + ">\r\n"

    def _now_and_then(self, report, gcode, offset, inches):
        busy = report["state"] in _BUSY
        version = (gcode.offsets.version, gcode.system)
        if version != self._version:
            self._version = version
            self._wco = 0
        text = ""
        if self._wco:
            self._wco -= 1
        else:
            self._wco = (_WCO_BUSY if busy else _IDLE) - 1
            self._overrides = self._overrides or 1
            text = "|WCO:" + place(offset, inches)
        if self._overrides:
            self._overrides -= 1
            return text
        self._overrides = (_OVERRIDES_BUSY if busy else _IDLE) - 1
        text += "|Ov:%d,%d,%d" % report["overrides"]
        accessories = ("", "", "", "S", "C", "")[report["spindle"]] + ("", "F", "M", "FM")[report["coolant"]]
        return text + "|A:" + accessories if accessories else text
