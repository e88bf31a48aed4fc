"""Path data of SVG as segments: those of `d` up to its first mistake.

    segments, whole = read("M0 0C1 1 2 2 3 0")

A segment is a tuple, its letter first: ("M", to), ("L", [to, …]), ("C", control, control, to), ("Q", control, to), ("A", arc, to), ("Z", to).
Positions are complex numbers x + iy; an arc is svgelements' Arc. SVG 2, 9.3.
"""

import re

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_NUMBERS = re.compile(_NUMBER)
_NEXT = re.compile(rf"[\s,]*({_NUMBER})")
_COMMAND = re.compile("([MmZzLlHhVvCcSsQqTtAa])([^MmZzLlHhVvCcSsQqTtAa]*)")
_ARC = re.compile(rf"[\s,]*({_NUMBER})[\s,]*({_NUMBER})[\s,]*({_NUMBER})[\s,]*([01])[\s,]*([01])[\s,]*({_NUMBER})[\s,]*({_NUMBER})")
_BETWEEN = " ,\t\r\n\f"
_WANTED = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2}  # numbers of a command


def read(data):
    """Read path data; return (segments up to the first mistake, True if there is none)."""
    reader = _Reader()
    begun = data.lstrip(_BETWEEN)
    if begun[:1] not in ("M", "m"):
        return [], not begun
    for letter, text in _COMMAND.findall(begun):
        if not reader.take_command(letter, text):
            return reader.segments, False
    return reader.segments, True


def _read_numbers(text):
    """Return (numbers up to the first mistake, True if there is none)."""
    found = _NUMBERS.findall(text)
    if len(text) - sum(map(len, found)) == sum(map(text.count, _BETWEEN)):
        return list(map(float, found)), True
    found, at = [], 0
    while match := _NEXT.match(text, at):
        found.append(float(match[1]))
        at = match.end()
    return found, False


class _Reader:
    def __init__(self):
        self.segments = []
        self._here = self._first = 0j
        self._control, self._kind = 0j, ""  # the last control point of the curve before, and its letter

    def take_command(self, letter, text):
        """Read one command with all its numbers. Returns False behind a mistake."""
        kind, base = letter.upper(), letter.islower()
        if kind == "Z":
            self._add_segment(("Z", self._first), self._first)
            return not text.strip(_BETWEEN)
        if kind == "A":
            return self._add_arcs(text, base)
        values, whole = _read_numbers(text)
        size = _WANTED[kind]
        count = len(values) // size
        whole = whole and count > 0 and len(values) == count * size
        if kind in "HV":
            self._add_sides(kind, values, base)
        elif kind in "ML":
            self._add_lines(kind, values[: 2 * count], base)
        else:
            self._add_curves(kind, [complex(x, y) for x, y in zip(values[::2], values[1::2])], size // 2, count, base)
        return whole

    def _add_segment(self, segment, end):
        self.segments.append(segment)
        self._here, self._kind = end, ""

    def _add_lines(self, kind, values, relative):
        """Add the segments of M or L, two numbers a position. The first position of M begins a subpath, lines lead to the others."""
        points, here = [], self._here
        for x, y in zip(values[::2], values[1::2]):
            here = here + complex(x, y) if relative else complex(x, y)
            points.append(here)
        if kind == "M" and points:
            self._first = points[0]
            self._add_segment(("M", self._first), self._first)
            points = points[1:]
        if points:
            self._add_segment(("L", points), here)

    def _add_sides(self, kind, values, relative):
        """Add one segment of lines along X (H) or Y (V), a number each."""
        points, here = [], self._here
        for value in values:
            if kind == "H":
                here = complex(here.real + value if relative else value, here.imag)
            else:
                here = complex(here.real, here.imag + value if relative else value)
            points.append(here)
        if points:
            self._add_segment(("L", points), here)

    def _add_curves(self, kind, points, size, count, relative):
        """Add `count` curves of C, S, Q or T, of `size` positions each. S and T mirror the control of the curve before, if it is of their kind; else
        their first control is its end."""
        for index in range(0, size * count, size):
            given = [self._here + point if relative else point for point in points[index : index + size]]
            if kind in "ST":
                follows = self._kind == ("C" if kind == "S" else "Q")
                given.insert(0, 2 * self._here - self._control if follows else self._here)
            made = "C" if kind in "CS" else "Q"
            self._add_segment((made, *given), given[-1])
            self._control, self._kind = given[-2], made

    def _add_arcs(self, text, relative):
        """Add the arcs of A's text, seven numbers each; return True if there is one, and nothing else follows."""
        import svgelements

        at, found = 0, 0
        while match := _ARC.match(text, at):
            across, down, turn, large, sweep, x, y = map(float, match.groups())
            end = complex(x, y) + (self._here if relative else 0)
            start, to = ((each.real, each.imag) for each in (self._here, end))
            arc = svgelements.Arc(start, abs(across), abs(down), turn, bool(large), bool(sweep), to)
            self._add_segment(("A", arc, end), end)
            at, found = match.end(), found + 1
        return found > 0 and not text[at:].strip(_BETWEEN)
