"""Lines about settings, for languages that are not of lines: the same numbers as grbl's, and the board file's languages' own.

    teach_lines(words)      # `words`: a protocols.words.Words

    $               [$:0,1,2,3 …]   the numbers that there are
    $100            $100=48.000
    $100=48.5       $100=48.500     set and kept; refused as any setting is
    $100=           $100=48.000     as the board file has it

The answer's last line is `ok`, or `error:110`. As on a grbl link a setting changes only at a stand, with the tool off.
"""

from micropython import const

from passo import errors
from passo.commands import SETTING, Command

_DIGITS = "0123456789"
_DECIMALS = const(3)
_LONGEST = const(9)  # digits before the point


def parse_thousandths(text):
    """Return the thousandths of a decimal number, a whole number; None if it is none or has more decimals."""
    sign, digits = (-1, text[1:]) if text[:1] == "-" else (1, text)
    whole, point, part = digits.partition(".")
    if not (whole or part) or len(whole) > _LONGEST or len(part) > _DECIMALS or [letter for letter in whole + part if letter not in _DIGITS]:
        return None
    return sign * int((whole or "0") + (part + "000")[:_DECIMALS])


def decimal_text(value, places):
    """Return a setting's value as text; `places`: 0, or 3 of a value in thousandths."""
    if not places:
        return str(value)
    return "%s%d.%03d" % ("-" if value < 0 else "", abs(value) // 1000, abs(value) % 1000)


def line_commands(machine, text):
    """Return the command of a line in which `text` follows `$`, or the number of an error."""
    key, equals, value = text.partition("=")
    if not text:
        return [Command(SETTING)]
    if not 0 < len(key) < 4 or [letter for letter in key if letter not in _DIGITS]:
        return errors.STATEMENT
    command = Command(SETTING, int(key), None)
    if equals and value:
        command.value = parse_thousandths(value)
        if command.value is None:
            return errors.NUMBER
    elif equals:
        command.tool = True
    return [command]


def answer_text(value):
    """Return the line with a setting, or with the numbers of all."""
    if isinstance(value, tuple):
        return "$%d=%s\n" % (value[0], decimal_text(value[1], value[2]))
    return "[$:%s]\n" % ",".join([str(number) for number in value])


def add_jogs(axes, board, table):
    """Add to a table of settings: one jog of each of `axes` of the board file, in micrometres."""
    for number, axis in enumerate(axes):
        steps_per_m = axis["steps_per_m"]
        jog_um = ((axis["jog_steps"] or board["jog"]["steps"]) * 1_000_000 + steps_per_m // 2) // steps_per_m
        table[150 + number] = axis["name"] + "_jog", 3, jog_um, 0, 999_999_999


def teach_lines(words):
    """Add the `$` lines about settings to `words`."""
    words.learn_lines("$", SETTING, line_commands, answer_text)
