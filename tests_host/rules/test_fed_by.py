"""Each rate and each wait of the benchmarks says what the board was fed by: the same firmware takes twice as many lines from its memory as over USB.

A row tells a rate if it counts lines, dots or points a second, and a wait if it is of a question, a command or a hold. The source of the lines stands in the
row or in its table's columns.
"""

import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.quick
DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGES = [DOCS / name for name in ("reference/benchmarks.md", "inside/kernels.md", "use/network.md")]
ROW = re.compile(r"^\|(.*)\|$")
MEASURED = re.compile(r"\b(lines|dots|points|codes)\b[^|]*\b(a second|second)\b|\b(lines|dots|points)/s\b|`\?` (answered|in a)|\bfeed hold\b|\bfirst step after\b|\bcommand to the first step\b")
FED_BY = re.compile(r"from (the board's )?memory|\bUSB\b|\bUART\b|\bWi-Fi\b")


def tables(text):
    """[(columns, rows)] of a page; cells are texts."""
    found, table = [], []
    for line in [*text.splitlines(), ""]:
        row = ROW.match(line)
        if row:
            table.append([cell.strip() for cell in row[1].split("|")])
        elif table:
            found.append((table[0], table[2:]))
            table = []
    return found


def unfed(text):
    """Rows that tell a rate or a wait, and not what the board was fed by."""
    told = [(cells[0], " | ".join([*columns, *cells])) for columns, rows in tables(text) for cells in rows]
    return [name for name, row in told if MEASURED.search(row) and not FED_BY.search(row)]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_each_row_says_what_it_was_fed_by(page):
    assert unfed(page.read_text(encoding="utf-8")) == []


def test_usb_and_the_uart_have_rows_of_their_own():
    text = (DOCS / "reference" / "benchmarks.md").read_text(encoding="utf-8")
    rows = [cells[0] for columns, rows in tables(text) for cells in rows if columns[0] == "G-code on router_3axis"]
    for what in ("lines", "dots"):
        for link in ("from memory", "over USB", "over a UART of 115 200 baud"):
            assert [row for row in rows if what in row and link in row], (what, link)


def test_a_row_that_does_not_say_it_is_found():
    head = "| G-code | MHz | measured |\n| --- | ---: | ---: |\n"
    assert unfed(head + "| lines of 0.2 mm, a second | 125 | 758 |\n") == ["lines of 0.2 mm, a second"]
    assert unfed(head + "| lines of 0.2 mm over USB, a second | 125 | 758 |\n") == []
    assert unfed(head + "| a feed hold begins to slow, ms | 125 | 12 |\n") == ["a feed hold begins to slow, ms"]
    assert unfed("| by | lines of 0.2 mm a second |\n| --- | ---: |\n| C | 2070 |\n") == ["C"]
    assert unfed("| axes | kHz |\n| --- | ---: |\n| 3 | 100 |\n") == []
