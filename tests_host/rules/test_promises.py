"""What `passo prove` promises stands in docs/reference/benchmarks.md."""

import re

import pytest

from host_tools.prove.promises import BETTER, KEPT, MEMORY, PROMISES, WORSE, verdict
from host_tools.resources import ROOT

TEXT = re.sub(r"\s+", " ", (ROOT / "docs" / "reference" / "benchmarks.md").read_text(encoding="utf-8"))


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
