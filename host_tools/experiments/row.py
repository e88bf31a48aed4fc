"""The result of an experiment: rows of the table, and pictures beside them."""

from dataclasses import dataclass, field

from host_tools.experiments.authors import Author
from host_tools.language import current_language

NOTHING = 1e-9  # of a distance: less is the rounding of floats


@dataclass
class Row:
    """A row of the table: a figure of the author's, and the one measured."""

    what: str
    author: Author
    ours: float | None  # None: not measured; `told` says why
    unit: str
    told: str = ""  # in place of the number, or beside it
    agrees: bool | None = None  # of rows that are right or wrong


@dataclass
class Outcome:
    """The result of an experiment at a place."""

    how: str  # the way of measuring, a sentence
    rows: list = field(default_factory=list)
    pictures: list = field(default_factory=list)  # (caption, SVG)

    def add_row(self, *values, **named):
        """Add a Row of these values."""
        self.rows.append(Row(*values, **named))


def figure_text(value, digits=4):
    """Return a number with `digits` digits, in the notation of the language; "" for None."""
    if value is None:
        return ""
    if value == round(value) or abs(value) >= 10 ** (digits - 1):
        text = f"{value:.0f}"
    else:
        text = "0" if abs(value) < NOTHING else f"{value:.{digits}g}"
    return text.replace(".", ",") if current_language() == "pt" else text


def percent_better(float_time, integer_time):
    """Return the percent by which the integer line is better, as the document counts: float / integer − 1."""
    return 100 * (float_time / integer_time - 1)
