"""Numbers, parameters and expressions of RS274/NGC.

    cursor = Cursor("[#1+2]*3", values)
    cursor.read_value()          # one value: a number, a parameter, an expression in brackets, a function

Blanks and comments must have been removed, letters be small. Angles are degrees. Values that differ by less than 1e-6 are equal.
`values` has get(name) and has(name); a name is a whole number, or a text.
"""

import math

from host_tools.programs.program_errors import (
    BRACKETS, DEPTH, DIVISION, DOMAIN, PARAMETER, SYNTAX, UNKNOWN_NAME, WHOLE, ProgramError,
)  # fmt: skip

EQUAL = 1e-6
_DEEPEST = 50  # values inside each other: brackets, functions, # and signs
_DIGITS = "0123456789"


def _divide(a, b):
    if b == 0:
        raise ProgramError(DIVISION)
    return a / b


def _modulo(a, b):
    if b == 0:
        raise ProgramError(DIVISION, "MOD 0")
    return a % abs(b)


def _power(a, b):
    """Return a ** b. Raises ProgramError if there is no real result, or it is too large."""
    if a < 0 and b % 1 or a == 0 and b < 0:
        raise ProgramError(DOMAIN, "{:g} ** {:g}", a, b)
    try:
        return float(a**b)
    except OverflowError:
        raise ProgramError(DOMAIN, "{:g} ** {:g}", a, b) from None


# By precedence, the first binds most.
OPERATORS = (
    {"**": _power},
    {"*": lambda a, b: a * b, "/": _divide, "mod": _modulo},
    {"+": lambda a, b: a + b, "-": lambda a, b: a - b},
    {
        "eq": lambda a, b: abs(a - b) < EQUAL,
        "ne": lambda a, b: abs(a - b) >= EQUAL,
        "gt": lambda a, b: a > b,
        "ge": lambda a, b: a >= b or abs(a - b) < EQUAL,
        "lt": lambda a, b: a < b,
        "le": lambda a, b: a <= b or abs(a - b) < EQUAL,
    },
    {
        "and": lambda a, b: bool(a) and bool(b),
        "or": lambda a, b: bool(a) or bool(b),
        "xor": lambda a, b: bool(a) != bool(b),
    },
)
_SPELLINGS = sorted((name for group in OPERATORS for name in group), key=len, reverse=True)
_LEVELS = {name: level for level, group in enumerate(OPERATORS) for name in group}


def check_finite(value):
    """Return `value`. Raises ProgramError if it is more than a number can be."""
    if not math.isfinite(value):
        raise ProgramError(DOMAIN, "a number without bounds")
    return value


def half_away(value):
    """Round to the nearest whole number, halves away from zero."""
    return math.floor(abs(value) + 0.5) * (1 if value >= 0 else -1)


FUNCTIONS = {
    "abs": abs,
    "acos": lambda a: math.degrees(math.acos(a)),
    "asin": lambda a: math.degrees(math.asin(a)),
    "cos": lambda a: math.cos(math.radians(a)),
    "exp": math.exp,
    "fix": math.floor,
    "fup": math.ceil,
    "ln": math.log,
    "round": half_away,
    "sin": lambda a: math.sin(math.radians(a)),
    "sqrt": math.sqrt,
    "tan": lambda a: math.tan(math.radians(a)),
}


class Cursor:
    def __init__(self, text, values, at=0):
        self.text = text
        self.at = at
        self._values = values
        self._depth = 0

    def at_end(self):
        """True if nothing is left of the text."""
        return self.at >= len(self.text)

    def peek(self):
        """Return the next character, "" at the end."""
        return self.text[self.at : self.at + 1]

    def take_text(self, text):
        """Step over `text` if it comes next; return whether it did."""
        if not self.text.startswith(text, self.at):
            return False
        self.at += len(text)
        return True

    def rest_text(self):
        """Return the next letters, for an error."""
        return self.text[self.at : self.at + 12] or "the line ends"

    def read_value(self):
        """Read one value: a number, a parameter, an expression in brackets, a function. Raises ProgramError."""
        if self._depth > _DEEPEST:
            raise ProgramError(DEPTH, "{} at most", _DEEPEST)
        self._depth += 1
        value = self._read_operand()
        self._depth -= 1
        return value

    def _read_operand(self):
        """Read a value without powers or operators: a number, a parameter, `[…]` or a function, each with a sign in front. Raises ProgramError."""
        char = self.peek()
        if char in ("+", "-") and self.text[self.at + 1 : self.at + 2] not in (*_DIGITS, ".", ""):
            self.at += 1
            return -self.read_value() if char == "-" else self.read_value()
        if char == "[":
            return self.read_expression()
        if char == "#":
            return self._read_parameter()
        if char.isalpha():
            return self._read_function()
        return self._read_number()

    def read_expression(self):
        """Read an expression in brackets, `[…]`. Raises ProgramError."""
        if not self.take_text("["):
            raise ProgramError(SYNTAX, "[ before {}", self.rest_text())
        if self.text.count("[", 0, self.at) - self.text.count("]", 0, self.at) > _DEEPEST:
            raise ProgramError(BRACKETS, "{} inside each other at most", _DEEPEST)
        values = [self.read_value()]
        operators = []
        while not self.take_text("]"):
            if self.at_end():
                raise ProgramError(BRACKETS, "{}", self.text)
            operator = next((name for name in _SPELLINGS if self.take_text(name)), None)
            if operator is None:
                raise ProgramError(UNKNOWN_NAME, "{}", self.rest_text())
            # Operators that bind at least as much as the new one are worked out first: all go from left to right.
            while operators and _LEVELS[operators[-1]] <= _LEVELS[operator]:
                _reduce_once(values, operators)
            operators.append(operator)
            values.append(self.read_value())
        while operators:
            _reduce_once(values, operators)
        return values[0]

    def _read_number(self):
        """Read a number with its sign; return a float. Raises ProgramError if there is none."""
        begin = self.at
        if self.peek() in ("+", "-") and not self.at_end():
            self.at += 1
        while not self.at_end() and self.peek() in _DIGITS + ".":
            self.at += 1
        try:
            return check_finite(float(self.text[begin : self.at]))
        except ValueError:
            self.at = begin
            raise ProgramError(SYNTAX, "{}", self.rest_text()) from None

    def read_name(self):
        """Read a parameter's number or name, behind its #. Raises ProgramError."""
        if not self.take_text("<"):
            number = self.read_value()
            if abs(number - half_away(number)) > EQUAL:
                raise ProgramError(WHOLE, "#{:g}", number)
            return int(half_away(number))
        end = self.text.find(">", self.at)
        if end <= self.at:
            raise ProgramError(BRACKETS, "<{}", self.rest_text())
        name = self.text[self.at : end]
        self.at = end + 1
        return name

    def _read_parameter(self):
        self.at += 1
        return self._values.get(self.read_name())

    def _read_function(self):
        """Read a function with its argument, ATAN[y]/[x] and EXISTS[#…] too; return its value, angles in degrees. Raises ProgramError if it is not
        known, or has no value there."""
        if self.take_text("exists["):
            if not self.take_text("#"):
                raise ProgramError(PARAMETER, "EXISTS[#<name>]")
            known = self._values.has(self.read_name())
            if not self.take_text("]"):
                raise ProgramError(BRACKETS, "{}", self.text)
            return float(known)
        if self.take_text("atan"):
            y = self.read_expression()
            if not self.take_text("/"):
                raise ProgramError(SYNTAX, "ATAN[y]/[x]")
            return math.degrees(math.atan2(y, self.read_expression()))
        name = next((name for name in FUNCTIONS if self.take_text(name)), None)
        if name is None:
            raise ProgramError(UNKNOWN_NAME, "{}", self.rest_text())
        argument = self.read_expression()
        try:
            return float(FUNCTIONS[name](argument))
        except (ValueError, OverflowError):
            raise ProgramError(DOMAIN, "{}[{:g}]", name.upper(), argument) from None


def _reduce_once(values, operators):
    operator = operators.pop()
    right = values.pop()
    values[-1] = check_finite(float(OPERATORS[_LEVELS[operator]][operator](values[-1], right)))
