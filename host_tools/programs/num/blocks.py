"""One block of a NUM program: its words, codes, assignments and condition.

    block = read("N10 G01 XL1 Y-5 ER2", variables)
    block.words["X"], block.words["ER"], block.codes

Variables are L0 … L19, L100 … L199, L900 … L959, and 0 until they are set. Expressions go from left to right; one in which
* or / follows + or - is refused, because controllers differ about it.
"""

import math
import re

from host_tools.programs.program_errors import (
    DEPTH, DIVISION, DOMAIN, NOT_IN_DIALECT, PARAMETER, RANGE, REPEATED, SYNTAX, ProgramError,
)  # fmt: skip

_DEEPEST = 50  # functions inside each other
_DIGITS = 9  # of a whole number
_LETTERS = "DFHIJKPQRSTXYZ"
_PAIRS = ("ER", "EX", "EY", "EB", "EP", "EQ", "EI", "EJ")
_NUMBER = re.compile(r"[0-9]+\.?[0-9]*|\.[0-9]+")
_WHOLE = re.compile(r"[0-9]+")
_COMPARISONS = {
    ">=": lambda a, b: a >= b, "<=": lambda a, b: a <= b, "<>": lambda a, b: a != b, "=": lambda a, b: a == b,
    "<": lambda a, b: a < b, ">": lambda a, b: a > b,
}  # fmt: skip
_FUNCTIONS = {
    "S": lambda a: math.sin(math.radians(a)), "C": lambda a: math.cos(math.radians(a)), "A": lambda a: math.degrees(math.atan(a)),
    "R": math.sqrt, "T": math.trunc,
}  # fmt: skip
VARIABLES = (range(0, 20), range(100, 200), range(900, 960))


class Variables:
    def __init__(self):
        self._values = {}

    def get(self, number):
        self._check_number(number)
        return self._values.get(number, 0.0)

    def set(self, number, value):
        self._check_number(number)
        self._values[number] = value

    @staticmethod
    def _check_number(number):
        if not any(number in each for each in VARIABLES):
            raise ProgramError(PARAMETER, "L{}: L0 to L19, L100 to L199, L900 to L959", number)


class Block:
    def __init__(self):
        self.words = {}
        self.g = []
        self.m = []
        self.targets = []  # N words behind G77 and G79
        self.condition = None  # of G79: True or False; None if there is none


def clean_line(line):
    """Return a line without comments and blanks, in capitals."""
    return re.sub(r"\s", "", re.sub(r"\([^)]*\)?", "", line)).upper()


def number_of(text):
    """Return the number behind N of a cleaned line, or None."""
    found = re.match(r"/?N([0-9]+)", text)
    return whole_number(found[1]) if found else None


def whole_number(digits):
    """Return the number of these digits. Raises ProgramError if there are more than a controller takes."""
    if len(digits) > _DIGITS:
        raise ProgramError(RANGE, "{} digits at most", _DIGITS)
    return int(digits)


def read(text, variables):
    """Read the Block of a cleaned line. Raises ProgramError."""
    return _Reader(text.lstrip("/"), variables).read_block()


class _Reader:
    def __init__(self, text, variables):
        self._text = text
        self._variables = variables
        self._at = 0
        self._depth = 0  # of functions inside each other

    def read_block(self):
        """Return the Block of the text; variables get their values behind its last word. Raises ProgramError if a word is repeated, not known or
        without a number."""
        block = Block()
        assigned = []
        while self._at < len(self._text):
            letter = self._text[self._at]
            pair = self._text[self._at : self._at + 2]
            if letter == "N":
                labels = self._at == 0
                number = self._read_code()
                if not labels:
                    block.targets.append(number)
            elif letter in "GM":
                (block.g if letter == "G" else block.m).append(self._read_code())
            elif letter == "L":
                self._read_variable(block, assigned)
            elif pair in _PAIRS or letter in _LETTERS:
                name = pair if pair in _PAIRS else letter
                self._at += len(name)
                if name in block.words:
                    raise ProgramError(REPEATED, "{}", name)
                block.words[name] = self._number_with_sign()
            else:
                raise ProgramError(NOT_IN_DIALECT if letter.isalpha() else SYNTAX, "{}", self._rest_text())
        for number, value in assigned:
            self._variables.set(number, value)
        return block

    def _read_variable(self, block, assigned):
        """Read `L1=…`, or a condition behind G79. Raises ProgramError."""
        if 79 in block.g:
            block.condition = self._read_condition()
            return
        self._at += 1
        number = self._read_whole()
        if not self._take_text("="):
            raise ProgramError(SYNTAX, "= before {}", self._rest_text())
        assigned.append((number, self._read_expression()))

    def _read_condition(self):
        """Return the truth of comparisons joined by & and !, from left to right; all are read. Raises ProgramError."""
        truth = self._read_comparison()
        while True:
            if self._take_text("&"):
                truth = self._read_comparison() and truth
            elif self._take_text("!"):
                truth = self._read_comparison() or truth
            else:
                return truth

    def _read_comparison(self):
        """Return the truth of one comparison of two expressions. Raises ProgramError if there is no comparison sign."""
        left = self._read_expression()
        for name, compare in _COMPARISONS.items():
            if self._take_text(name):
                return compare(left, self._read_expression())
        raise ProgramError(SYNTAX, "= < > <= >= or <> before {}", self._rest_text())

    def _read_expression(self):
        """Return the value of an expression, from left to right, a float or the number of a variable. Raises ProgramError at * or / behind + or -,
        and at a division by 0."""
        value = self._number_with_sign()
        added = False
        while True:
            if self._take_text("+"):
                value, added = value + self._read_term(), True
            elif self._take_text("-"):
                value, added = value - self._read_term(), True
            elif added and self._rest_text()[0] in "*/":
                raise ProgramError(SYNTAX, "* or / behind + or -: make two assignments of it")
            elif self._take_text("*"):
                value *= self._read_term()
            elif self._take_text("/"):
                divisor = self._read_term()
                if divisor == 0:
                    raise ProgramError(DIVISION)
                value /= divisor
            else:
                if not math.isfinite(value):
                    raise ProgramError(DOMAIN, "a number without bounds")
                return value

    def _number_with_sign(self):
        """Return the value of a term with a sign or without one. Raises ProgramError."""
        if self._take_text("-"):
            return -self._read_term()
        self._take_text("+")
        return self._read_term()

    def _read_term(self):
        """Return the value of a variable, a function or a number. Raises ProgramError if functions are nested too deeply, or there is no such root or
        number."""
        if self._take_text("L"):
            return self._variables.get(self._read_whole())
        letter = self._rest_text()[0]
        if letter in _FUNCTIONS:
            self._at += 1
            self._depth += 1
            if self._depth > _DEEPEST:
                raise ProgramError(DEPTH, "{} at most", _DEEPEST)
            argument = self._number_with_sign()
            self._depth -= 1
            if letter == "R" and argument < 0:
                raise ProgramError(DOMAIN, "R{:g}", argument)
            return float(_FUNCTIONS[letter](argument))
        value = float(self._match_pattern(_NUMBER))
        if math.isinf(value):
            raise ProgramError(DOMAIN, "a number without bounds")
        return value

    def _read_code(self):
        self._at += 1
        return self._read_whole()

    def _read_whole(self):
        return whole_number(self._match_pattern(_WHOLE))

    def _match_pattern(self, pattern):
        """Step over the text that a pattern matches here, and return it. Raises ProgramError if it does not match."""
        found = pattern.match(self._text, self._at)
        if not found:
            raise ProgramError(SYNTAX, "a number before {}", self._rest_text())
        self._at = found.end()
        return found[0]

    def _take_text(self, text):
        """Step over `text` if it comes next; return whether it did."""
        if not self._text.startswith(text, self._at):
            return False
        self._at += len(text)
        return True

    def _rest_text(self):
        return self._text[self._at : self._at + 12] or "the end of the block"
