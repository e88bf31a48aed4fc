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

G80 = const(8000)
G81 = const(8100)

_LISTS = (
    (NON_MODAL, (400, 1000, 2800, 2810, 3000, 3010, 5300, 9200, 9210)),
    (MOTION, (0, 100, 200, 300, 3820, 3830, 3840, 3850, G80, G81)),
    (PLANE, (1700, 1800, 1900)),
    (DISTANCE, (9000, 9100)),
    (ARC_DISTANCE, (9110,)),
    (FEED_MODE, (9300, 9400)),
    (UNITS, (2000, 2100)),
    (CUTTER, (4000,)),
    (TOOL_LENGTH, (4310, 4900)),
    (RETURN, (9800, 9900)),
    (SYSTEM, (5400, 5500, 5600, 5700, 5800, 5900)),
    (PATH, (6100,)),
    (STOPPING, (M_CODES, M_CODES + 100, M_CODES + 200, M_CODES + 3000)),
    (TOOL_CHANGE, (M_CODES + 600,)),
    (TURNING, (M_CODES + 300, M_CODES + 400, M_CODES + 500)),
    (COOLING, (M_CODES + 700, M_CODES + 800, M_CODES + 900)),
    (SWITCHING, (M_CODES + 6200, M_CODES + 6300, M_CODES + 6400, M_CODES + 6500)),
)
GROUP_OF = {}
for _group, _codes in _LISTS:
    for _code in _codes:
        GROUP_OF[_code] = _group

AXIS_COMMANDS = (0, 100, 200, 300, 3820, 3830, 3840, 3850, G81, 1000, 2800, 3000, 9200, 4310, 4900)


def why_unknown(code):
    """The error's number of a code that is not in GROUP_OF."""
    if code in (5910, 5920, 5930):
        return errors.NO_SUCH_SYSTEM
    whole = code // 100
    if code % 100 and whole * 100 in GROUP_OF and whole not in (28, 30, 61, 90, 92):
        return errors.NOT_INTEGER
    return errors.UNSUPPORTED
