"""The G and M codes that are understood, each with its modal group, in hundredths as Words.codes has them.

Codes of the same group exclude each other in a line. Those of AXIS_COMMANDS want the line's axis words for themselves.
"""

from micropython import const

from passo import errors
from passo.protocols.gcode.words import M_CODES

NON_MODAL = const(0)
MOTION = const(1)
PLANE = const(2)
DISTANCE = const(3)
ARC_DISTANCE = const(4)
FEED_MODE = const(5)
UNITS = const(6)
CUTTER = const(7)
TOOL_LENGTH = const(8)
RETURN = const(9)
SYSTEM = const(10)
PATH = const(11)
STOPPING = const(12)
TOOL_CHANGE = const(13)
TURNING = const(14)
COOLING = const(15)
SWITCHING = const(16)
GROUPS = const(17)

G73 = const(7300)
G80 = const(8000)
G81 = const(8100)
G82 = const(8200)
G83 = const(8300)
G43 = const(4300)
G49 = const(4900)
CYCLES = (G73, G81, G82, G83)

# Of each group in the order of their numbers. As one text: tuples would keep a kilobyte of memory.
_CODES = (
    "400 1000 2800 2810 3000 3010 5300 9200 9210;"
    "0 100 200 300 3820 3830 3840 3850 7300 8000 8100 8200 8300;"
    "1700 1800 1900;"
    "9000 9100;"
    "9110;"
    "9300 9400;"
    "2000 2100;"
    "4000;"
    "4300 4310 4900;"
    "9800 9900;"
    "5400 5500 5600 5700 5800 5900;"
    "6100 6110 6400;"
    "M0 M100 M200 M3000;"
    "M600;"
    "M300 M400 M500;"
    "M700 M800 M900;"
    "M6200 M6300 M6400 M6500"
)
GROUP_OF = {}
_group = 0
for _code in _CODES.replace(";", " ; ").split():
    if _code == ";":
        _group += 1
    elif _code[0] == "M":
        GROUP_OF[int(_code[1:]) + M_CODES] = _group
    else:
        GROUP_OF[int(_code)] = _group

AXIS_COMMANDS = (0, 100, 200, 300, 3820, 3830, 3840, 3850, G73, G81, G82, G83, 1000, 2800, 3000, 9200, 4310)


def why_unknown(code):
    """The error's number of a code that is not in GROUP_OF."""
    if code in (5910, 5920, 5930):
        return errors.NO_SUCH_SYSTEM
    whole = code // 100
    if code % 100 and whole * 100 in GROUP_OF and whole not in (28, 30, 43, 61, 90, 92):
        return errors.NOT_INTEGER
    return errors.UNSUPPORTED
