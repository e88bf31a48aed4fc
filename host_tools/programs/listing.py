"""The result of compiling a program: lines of plain G-code, each with the line of the program that it came from, and its path.

    listing = Listing()
    listing.add_line("G1 X5", source, stroke)
    listing.lines()             # [(number, bytes)] for a sender: numbers count the lines of the listing
    listing.origin(7)           # "part.ngc:12": where line 7 comes from
    listing.text(texts)         # the same as a file, origins as comments
"""

from typing import NamedTuple

from host_tools.programs.program_errors import ENDLESS, ProgramError


class Source(NamedTuple):
    """A line of a program's file."""

    file: str
    line: int

    def __str__(self):
        return f"{self.file}:{self.line}"


class Stroke(NamedTuple):
    """The path of one line of the listing: `points` are (x, y, z) in mm of the program; unknown positions are 0."""

    source: Source
    rapid: bool
    points: list


class Listing:
    def __init__(self, bound=1_000_000):
        """`bound`: the most lines that a program may make."""
        self._bound = bound
        self.codes = []
        self.sources = []
        self.strokes = []
        self.warnings = []  # texts
        self.progress = None  # called with each line that is carried out
        self.plane = 17  # of the arcs so far
        self.turns_in_inches = False  # A has words in G20, which are read as degrees

    def add_line(self, code, source, stroke=None):
        """Append a line of G-code. Raises ProgramError if there are too many."""
        if len(self.codes) >= self._bound:
            raise ProgramError(ENDLESS, "{} lines have been made", self._bound, place=source)
        self.codes.append(code)
        self.sources.append(source)
        if stroke:
            self.strokes.append(stroke)

    def begin(self, code):
        """Put a line before all others, which sets the state that they rely on."""
        self.codes.insert(0, code)
        self.sources.insert(0, self.sources[0])

    def lines(self):
        """Return [(number in the listing, bytes)]."""
        return [(number, code.replace(" ", "").encode()) for number, code in enumerate(self.codes, 1)]

    def origin(self, number):
        """Return the line of the program from which line `number` of the listing comes, as text; "" if there is no such line."""
        return str(self.sources[number - 1]) if 0 < number <= len(self.sources) else ""

    def text(self, texts):
        """Return the listing as a file. `texts`: {file: its lines}. Behind each line stands the program's line as a comment; its text only if the
        line before comes from another one."""
        rows = []
        before = None
        for code, source in zip(self.codes, self.sources):
            note = f"{source.file}:{source.line}" if len(texts) > 1 else str(source.line)
            if source != before:
                note += ": " + _printable(texts[source.file][source.line - 1])
            before = source
            rows.append(f"{code:<32} ; {note}")
        return "\n".join(rows) + "\n"


def _printable(line):
    return "".join(char if " " <= char <= "~" else " " for char in line.strip())
