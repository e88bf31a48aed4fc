"""What an experiment returns: rows of the table, and pictures beside them."""

from dataclasses import dataclass, field

from host_tools.experiments.authors import Author


@dataclass
class Row:
    what: str
    author: Author
    ours: float | None  # None: not measured; `told` says why
    unit: str
    told: str = ""  # in place of the number, or beside it
    agrees: bool | None = None  # of rows that are right or wrong


@dataclass
class Outcome:
    how: str  # the way of measuring, a sentence
    rows: list = field(default_factory=list)
    pictures: list = field(default_factory=list)  # (caption, SVG)

    def add(self, *values, **named):
        self.rows.append(Row(*values, **named))


def better(float_time, integer_time):
    """Percent by which the integer line is better, as the document counts: float / integer − 1."""
    return 100 * (float_time / integer_time - 1)
