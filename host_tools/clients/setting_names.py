"""Names, units and bounds of a controller's settings, for people.

    describe_line("$110=5000.000", axes=3)       # ("x: highest speed", "mm/min", "0.001 … 999999.999")
    describe_line("$N0=G54", axes=3)             # ("sent when the board starts", "", "")

The bounds are those of the firmware (config/setting_numbers.py; a test compares them). Speed times steps/mm is bounded too, by the
step rate of the board's player.
"""

import re

from host_tools import options
from host_tools.language import _

_AXES = "xyza"
_ANY = (0.001, 999_999.999)
_ANY_OR_0 = (0, 999_999.999)
# number: (name, unit, least, most); most None: a bit for each axis. Options add theirs.
NAMES = {
    0: ("length of a step pulse", "µs", 3, 100),
    1: ("idle time until motors are released; 255: never", "ms", 0, 255),
    2: ("step pulse low: mask, x 1 + y 2 + z 4 + a 8", "", 0, None),
    3: ("direction pin high in + direction: mask", "", 0, None),
    4: ("enable pin high when drivers are on", "", 0, 1),
    5: ("limit inputs active when high", "", 0, 1),
    6: ("probe active when high", "", 0, 1),
    10: ("status report: 1 machine position, 2 buffer", "", 0, 255),
    11: ("junction deviation; 0: a stop at each corner", "mm", 0, 10),
    12: ("arc tolerance", "mm", 0, 10),
    13: ("reports are in inches", "", 0, 1),
    20: ("soft limits: no target beyond the travel", "", 0, 1),
    21: ("hard limits: a limit input stops the machine", "", 0, 1),
    22: ("homing; locked at the start until homed", "", 0, 1),
    23: ("homes at the negative end: mask", "", 0, None),
    24: ("homing: speed to locate the switch", "mm/min", *_ANY),
    25: ("homing: speed to seek the switch", "mm/min", *_ANY),
    26: ("homing: time a switch may bounce", "ms", 0, 1000),
    27: ("homing: pull-off from the switch", "mm", 0.001, 1000),
    30: ("spindle: highest speed", "rpm", *_ANY),
    31: ("spindle: lowest speed", "rpm", *_ANY_OR_0),
    32: ("laser mode", "", 0, 1),
    180: ("drawing: speed at the start, in the board file's unit", "", 1, 1_000_000),
    181: ("pulses: least time between two, the drivers' interval", "µs", 1, 250_000),
    182: ("pulses: speed of moves by hand, and until a program says one", "mm/min", 1, 900_000),
    140: ("speed up to which there is no ramp", "mm/min", *_ANY_OR_0),
    **options.setting_rows(),
}
AXIS_NAMES = {
    100: ("steps per millimetre", "steps/mm", 0.001, 100_000),
    110: ("highest speed", "mm/min", *_ANY),
    120: ("acceleration", "mm/s²", *_ANY),
    130: ("travel", "mm", *_ANY),
    150: ("length of a jog", "mm", *_ANY_OR_0),
    170: ("speed of a jog", "mm/min", *_ANY),
    **options.axis_settings(),
}


def rule_of(number, axes):
    """(name, unit, least, most) of a setting on a machine with `axes` axes; None if it is not known."""
    if number in NAMES:
        name, unit, least, most = NAMES[number]
        return name, unit, least, (1 << axes) - 1 if most is None else most
    first, axis = number // 10 * 10, number % 10
    if first in AXIS_NAMES and axis < len(_AXES):
        name, unit, least, most = AXIS_NAMES[first]
        return f"{_AXES[axis]}: {name}", unit, least, most
    return None


def all_rules(axes):
    """{number: (name, unit, least, most)} of all settings of a machine with `axes` axes, in order."""
    found = {number: rule_of(number, axes) for number in [*NAMES, *(first + axis for first in AXIS_NAMES for axis in range(axes))]}
    return dict(sorted(found.items()))


def describe_line(line, axes):
    """(name, unit, bounds) of a line of a back-up, as texts; empty if it is not known."""
    start_up = re.match(r"\$N(\d)=", line)
    if start_up:
        return _("sent when the board starts"), "", ""
    offset = re.match(r"G10L2P(\d)", line)
    if offset:
        return _("origin of {system}", system=f"G{53 + int(offset[1])}"), "", ""
    setting = re.match(r"\$(\d+)=", line)
    found = rule_of(int(setting[1]), axes) if setting else None
    if not found:
        return "", "", ""
    name, unit, least, most = found
    name = _(name) if int(setting[1]) in NAMES else name[:3] + _(name[3:])  # behind "x: "
    return name, unit, f"{least:g} … {most:.10g}"


def describe_lines(lines, axes=0):
    """The lines of a back-up with their meanings beside them, aligned. `axes`: the machine's number of axes, 0: count the lines of steps/mm."""
    axes = axes or sum(1 for line in lines if re.match(r"\$10\d=", line))
    rows = [(line, *describe_line(line, axes)) for line in lines]
    widths = [max(len(row[column]) for row in rows) for column in range(3)]
    return ["  ".join((*(text.ljust(width) for text, width in zip(row, widths)), row[3])).rstrip() for row in rows]
