"""What `passo prove` promises stands in docs/reference/benchmarks.md."""

import re

import pytest

from host_tools.prove.promises import BETTER, KEPT, MEMORY, PROMISES, WORSE, verdict
from host_tools.resources import ROOT

DOCUMENT = (ROOT / "docs" / "reference" / "benchmarks.md").read_text(encoding="utf-8")
TEXT = re.sub(r"\s+", " ", DOCUMENT)
LINES = DOCUMENT.splitlines()


@pytest.mark.quick
def test_each_promise_is_measured_there():
    missing = [key for key, promise in PROMISES.items() if promise.said not in TEXT]
    assert not missing, missing


@pytest.mark.quick
def test_memory_is_that_of_the_table():
    for board, ((free, piece), (uf2_free, uf2_piece)) in MEMORY.items():
        row = next(line for line in TEXT.split("| " + board + " |") if f" no | " in line[:40])
        cells = [cell.strip() for cell in row.split("|")]
        assert {str(free), str(piece), str(uf2_free), str(uf2_piece)} <= set(cells), board


@pytest.mark.quick
def test_verdicts():
    assert [verdict(PROMISES["stop_us"], each) for each in (0.1, 10, 25, 25.1)] == [BETTER, KEPT, KEPT, WORSE]
    assert [verdict(PROMISES["lines_s"], each) for each in (1001, 500, 499)] == [BETTER, KEPT, WORSE]
    assert verdict(PROMISES["free_bytes"], 55_000, 60_992) == KEPT and verdict(PROMISES["free_bytes"], 50_000, 60_992) == WORSE


def rows_of(part):
    """Cells of each row of a bench's table."""
    table = LINES[LINES.index(f"<!-- bench:{part} -->") + 3 : LINES.index(f"<!-- /bench:{part} -->")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table]


def said_of(figure):
    """The cell "measured" of a figure's row at the top."""
    return next(line for line in LINES if line.startswith(f"| {figure} |")).split("|")[4]


@pytest.mark.quick
def test_the_rows_at_the_top_are_those_of_their_tables():
    boot = {row[0]: row for row in rows_of("boot") if row[2] == "no"}
    boards = [boot[board] for board in ("plotter_2014", "router_3axis", "mill_2004")]
    free, uf2_free = ([round(int(row[column]) / 1000) for row in boards] for column in (5, 10))
    pieces = [round(int(boot["router_3axis"][column]) / 1000) for column in (6, 11)]
    assert [int(number) for number in re.findall(r"(\d+)(?= kB|, \d+ and| and)", said_of("heap free, all loaded"))] == [*free, pieces[0], *uf2_free, pieces[1]]
    ready, uf2_ready = ([f"{int(row[column]) / 1000:.1f}" for row in boards] for column in (4, 9))
    told = re.findall(r"\d+\.\d", said_of("reset to the first answer"))
    assert told[:3] == ready and told[4:] == uf2_ready
    links = {tuple(row[:3]): row for row in rows_of("links")}
    assert re.findall(r"(\d+)/s", said_of("points over USB")) == [links["USB", "0", "32"][4], links["USB", "100", "32"][4]]
    wire = links["UART, 57 600 baud", "100", "32"], links["UART, 115 200 baud", "100", "32"]
    assert [int(each) for each in re.findall(r"(\d+)/s", said_of("points on the UART, three axes at 100 kHz, part of the wire's limit"))] == [int(row[3]) for row in wire]
