"""How `bench` compares two measurements of the same part."""

import re

import pytest

from host_tools.bench import main as bench
from host_tools.failure import Failure

HEADER = ("what", "a", "b", "c", "d", "late")
FREE = [["x", "1", "2", "3", "4", "0"], ["y", "1", "2", "3", "4", "0"]]


def test_what_does_not_differ_stands_once():
    assert bench.join_tables((HEADER, FREE), (HEADER, FREE)) == (list(HEADER), FREE)


def test_few_columns_that_differ_stand_side_by_side():
    charged = [FREE[0], ["y", "1", "9", "3", "4", "5"]]
    header, rows = bench.join_tables((HEADER, FREE), (HEADER, charged))
    assert header == ["what", "a", "b", "b, flash cache", "c", "d", "late", "late, flash cache"]
    assert rows == [["x", "1", "2", "2", "3", "4", "0", "0"], ["y", "1", "2", "9", "3", "4", "0", "5"]]


def test_of_many_the_rows_follow_each_other():
    charged = [FREE[0], ["y", "6", "7", "8", "9", "0"]]
    header, rows = bench.join_tables((HEADER, FREE), (HEADER, charged))
    assert header == ["what", "flash cache", "a", "b", "c", "d", "late"]
    assert rows == [
        ["x", "yes or no", "1", "2", "3", "4", "0"],
        ["y", "no", "1", "2", "3", "4", "0"],
        ["y", "yes", "6", "7", "8", "9", "0"],
    ]


def test_every_part_has_its_place_in_the_document():
    document = bench.DOCUMENT.read_text()
    for part in bench.PARTS:
        assert "a table" in bench.replace_part(document, part, "a table")
    with pytest.raises(Failure):
        bench.replace_part(document, "nothing", "")


def test_every_table_says_when_it_was_measured():
    document = bench.DOCUMENT.read_text(encoding="utf-8")
    for part in bench.PARTS:
        line = re.search(rf"<!-- /bench:{part} -->\n\n(Measured on \d{{4}}-\d\d-\d\d at [0-9a-f]{{8}}\.)\n", document)
        assert line, part
        for _ in range(2):  # measured again, it has the new day only
            document = bench.date_part(document, part, "on 2031-02-03 at 01234567")
            assert document.count("Measured on 2031-02-03 at 01234567.\n") == 1
        document = bench.date_part(document, part, line[1].removeprefix("Measured ")[:-1])
    assert document == bench.DOCUMENT.read_text(encoding="utf-8")


def test_a_measurement_has_its_day():
    assert re.fullmatch(r"on \d{4}-\d\d-\d\d(?: at [0-9a-f]{8,})?", bench.now_text())
