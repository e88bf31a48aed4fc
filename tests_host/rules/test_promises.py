"""docs/reference/benchmarks.md has the promises of `passo prove`."""

import re

import pytest

from host_tools.bench.summary import LINES, Tables, with_cache, summarise
from host_tools.prove.promises import BETTER, KEPT, MEMORY, PROMISES, WORSE, verdict
from host_tools.resources import ROOT

DOCUMENT = (ROOT / "docs" / "reference" / "benchmarks.md").read_text(encoding="utf-8")
TEXT = re.sub(r"\s+", " ", DOCUMENT)


@pytest.mark.quick
def test_each_promise_is_measured_there():
    missing = [key for key, promise in PROMISES.items() if promise.said not in TEXT]
    assert not missing, missing


@pytest.mark.quick
def test_memory_is_that_of_the_table():
    columns = "heap free, bytes", "in one piece", "heap free", "UF2: in one piece"
    rows = {row["board"]: [int(row[column]) for column in columns] for row in Tables(DOCUMENT).rows("boot") if row["flash cache"] == "no"}
    assert {board: [*stock, *uf2] for board, (stock, uf2) in MEMORY.items()} == rows


@pytest.mark.quick
def test_verdicts():
    assert [verdict(PROMISES["stop_us"], each) for each in (0.1, 10, 25, 25.1)] == [BETTER, KEPT, KEPT, WORSE]
    assert [verdict(PROMISES["lines_s"], each) for each in (1001, 500, 499)] == [BETTER, KEPT, WORSE]
    assert verdict(PROMISES["free_bytes"], 55_000, 60_992) == KEPT and verdict(PROMISES["free_bytes"], 50_000, 60_992) == WORSE


@pytest.mark.quick
def test_the_rows_at_the_top_are_those_of_their_tables():
    assert summarise(DOCUMENT) == DOCUMENT, "make bench ARGS=ways writes them anew"


@pytest.mark.quick
def test_another_figure_in_a_table_is_another_at_the_top():
    row = Tables(DOCUMENT).row("boot", "router_3axis", "grbl", "no")
    other = summarise(DOCUMENT.replace(f"| {row['heap free, bytes']} |", "| 11900 |"))
    assert "kB plotter, 12 kB router" in other and other != DOCUMENT


@pytest.mark.quick
@pytest.mark.parametrize("worst, over", [("24.9", ""), ("25.0", ""), ("25.1", ", more than the 25 µs")])
def test_a_halt_that_takes_too_long_is_named(worst, over):
    stops = re.search(r"<!-- bench:stops -->\n.*?<!-- /bench:stops -->", DOCUMENT, re.DOTALL)[0]
    row, cached = Tables(DOCUMENT).row("stops", "other pins"), Tables(DOCUMENT).row_with_cache("stops", "other pins")
    line = "| " + " | ".join(cached.values()) + " |"
    assert line in stops
    column = "worst" if "flash cache" in cached else "worst, flash cache"
    other = "| " + " | ".join({**cached, column: worst}.values()) + " |"
    text = summarise(DOCUMENT.replace(line, other))
    assert f"at most {row['worst']} µs, with the flash cache {worst}{over}; {row['exact']} of" in text


@pytest.mark.quick
@pytest.mark.parametrize("page", ["README.md", "docs/pt/README.md"])
def test_readme_has_figures_of_these_tables(page):
    text, tables = (ROOT / page).read_text(encoding="utf-8"), Tables(DOCUMENT)
    fastest = tables.row("pulses", "3", "480")
    assert fastest["words late"] == "0" and f"{fastest['kHz']} 000 " in text
    over_usb = [row for row in tables.rows("gcode") if row["G-code on router_3axis"].startswith(LINES + " over USB, the PC takes 0 ")]
    low, high = (int(with_cache(row, "measured")) // 100 * 100 for row in over_usb)
    assert re.findall(r"(\d+) (?:to|a) (\d+) (?:short lines|linhas curtas)/s", text) == [(str(low), str(high))]


@pytest.mark.quick
def test_the_timers_page_has_figures_of_its_table():
    text, rows = (ROOT / "docs" / "use" / "timer.md").read_text(encoding="utf-8"), Tables(DOCUMENT).rows("timer")
    free, charged = (max(float(row["µs, worst"]) for row in rows if row["flash cache"] == cache) for cache in ("no", "yes"))
    taken = [100 - int(row["CPU left"][:-1]) for row in rows if row["kHz"] == "25"]
    assert f"within {free} µs of their time; with the flash cache within {charged} µs" in text
    assert f"{min(taken)} to {max(taken)} % at 25 kHz" in text
