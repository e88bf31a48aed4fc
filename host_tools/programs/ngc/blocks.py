"""One line of RS274/NGC: its words, codes and assignments.

    block = read("g1 x[#1*2] f100", values)
    block.words["x"], block.codes("g")
"""

from host_tools.programs.ngc.expressions import EQUAL, Cursor, half_away
from host_tools.programs.program_errors import (
    BRACKETS, NOT_IN_DIALECT, RANGE, REPEATED, SYNTAX, WHOLE, ProgramError,
)  # fmt: skip

LETTERS = "adefhijklpqrstxyz@^"
ELSEWHERE = "bcuvw$"  # axes and words that LinuxCNC has, and no Passo machine


class Block:
    def __init__(self):
        self.words = {}  # letter: value
        self.g = []  # in tenths: 431 is G43.1
        self.m = []
        self.settings = []  # (parameter, value)


def clean_line(line):
    """Return (text without blanks and comments in small letters, True if the line begins with /). Raises ProgramError."""
    kept = []
    inside = False
    for char in line:
        if inside:
            inside = char != ")"
        elif char == "(":
            inside = True
        elif char == ";":
            break
        elif char == ")":
            raise ProgramError(BRACKETS, ")")
        elif not char.isspace():
            kept.append(char.lower())
    if inside:
        raise ProgramError(BRACKETS, "a comment begins with ( and does not end")
    text = "".join(kept)
    return text.lstrip("/"), text.startswith("/")


def read(text, values):
    """Read the Block of a cleaned line. Raises ProgramError."""
    block = Block()
    cursor = Cursor(text, values)
    if cursor.take_text("n"):
        cursor.read_value()
    while not cursor.at_end():
        letter = cursor.peek()
        cursor.at += 1
        if letter == "#":
            name = cursor.read_name()
            if not cursor.take_text("="):
                raise ProgramError(SYNTAX, "= before {}", cursor.rest_text())
            block.settings.append((name, cursor.read_value()))
        elif letter in "gm":
            (block.g if letter == "g" else block.m).append(_code_in_tenths(letter, cursor.read_value()))
        elif letter in LETTERS:
            if letter in block.words:
                raise ProgramError(REPEATED, "{}", letter.upper())
            block.words[letter] = cursor.read_value()
        elif letter in ELSEWHERE:
            raise ProgramError(NOT_IN_DIALECT, "{}: machines have X, Y, Z and A", letter.upper())
        else:
            raise ProgramError(SYNTAX, "{}{}", letter, cursor.rest_text())
    return block


def _code_in_tenths(letter, value):
    """Return the code in tenths, 431 for G43.1. Raises ProgramError."""
    tenths = half_away(value * 10)
    if abs(value * 10 - tenths) > EQUAL * 10 or value < 0:
        raise ProgramError(NOT_IN_DIALECT, "{}{:g}", letter.upper(), value)
    return int(tenths)


def whole_number(words, letter, low=0, high=1_000_000):
    """Return the value of a word that is a whole number within `low` … `high`. Raises ProgramError."""
    value = words[letter]
    if abs(value - half_away(value)) > EQUAL:
        raise ProgramError(WHOLE, "{}{:g}", letter.upper(), value)
    if not low <= half_away(value) <= high:
        raise ProgramError(RANGE, "{}{:g} is not within {} … {}", letter.upper(), value, low, high)
    return int(half_away(value))
