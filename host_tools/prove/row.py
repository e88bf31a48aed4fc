"""A row of `passo prove`'s report."""

from dataclasses import dataclass, field
from pathlib import Path

from host_tools.language import _
from host_tools.prove.promises import KEPT, WORSE

LEFT_OUT, FACT = "left out", ""


@dataclass
class Row:
    key: str
    what: str
    found: str
    promised: str = ""
    verdict: str = FACT
    advice: str = ""
    figures: dict = field(default_factory=dict)


def equality_row(key, what, found, ok, advice):
    """Return a row whose promise is that two things are the same."""
    return Row(key, what, found, _("equal"), KEPT if ok else WORSE, "" if ok else advice)


def number_text(value):
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}" if abs(value) >= 0.001 else "0"


def program_text(name):
    """Return a program for the board, a file of this folder."""
    return (Path(__file__).parent / name).read_text(encoding="utf-8")
