"""The G and M codes that are understood: a table, a line a modal group. A new code is a mark in it.

    G92*            it wants the line's axis words for itself
    G83**           so does a canned cycle
    M62=P           reader.py hands it on as it is, before the line's motion: Command(CODE + 62), `value` the whole number behind P, to the
                    feature whose handlers() name it; M62= has no number. M66 has L and Q, too. What the other codes do says parser.py

Codes of the same group exclude each other in a line.
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

# One text: tuples would keep a kilobyte of memory. The first groups have the numbers above, in this order.
_TABLE = (
    "G4 G10* G28* G28.1 G30* G30.1 G53 G92* G92.1;"
    "G0* G1* G2* G3* G38.2* G38.3* G38.4* G38.5* G73** G80 G81** G82** G83**;"
    "G17 G18 G19;"
    "G90 G91;"
    "G91.1;"
    "G93 G94;"
    "G20 G21;"
    "G40;"
    "G43 G43.1* G49;"
    "G98 G99;"
    "G54 G55 G56 G57 G58 G59;"
    "G61 G61.1 G64;"
    "M0 M1 M2 M30;"
    "M6;"
    "M3 M4 M5;"
    "M7 M8 M9;"
    "M62=P M63=P M64=P M65=P M66=P;"
    "M10= M11="
)

# Of a code's entry in CODES.
GROUP = const(31)  # mask: its group
AXES = const(32)
CYCLE = const(64)
ON = const(128)  # it is handed on
LETTER = const(8)  # the letter of its number is this many bits to the right, 0: it has none

G73 = const(7300)
G80 = const(8000)
G82 = const(8200)
G83 = const(8300)
G43 = const(4300)


def _read_table(table):
    """Return ({code in hundredths, M codes from M_CODES on: its entry}, how many groups there are)."""
    codes = {}
    group = 0
    for mark in table.replace(";", " ; ").split():
        if mark == ";":
            group += 1
            continue
        entry = group | (0, AXES, AXES | CYCLE)[mark.count("*")]
        code, on, letter = mark.rstrip("*").partition("=")
        if on:
            entry |= ON | (ord(letter) - 65 if letter else 0) << LETTER
        whole, _, tenth = code[1:].partition(".")
        codes[int(whole) * 100 + int(tenth or 0) * 10 + (M_CODES if code[0] == "M" else 0)] = entry
    return codes, group + 1


CODES, GROUPS = _read_table(_TABLE)


def why_unknown(code):
    """Return the error's number of a code that is not in CODES."""
    if code in (5910, 5920, 5930):
        return errors.NO_SUCH_SYSTEM
    whole = code // 100
    if code % 100 and whole * 100 in CODES and whole not in (28, 30, 43, 61, 90, 92):
        return errors.NOT_INTEGER
    return errors.UNSUPPORTED
