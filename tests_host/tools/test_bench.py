"""What `bench` makes of two measurements of the same part."""

import pytest

from host_tools.bench import main as bench
from host_tools.failure import Failure

HEADER = ("what", "a", "b", "c", "d", "late")
FREE = [["x", "1", "2", "3", "4", "0"], ["y", "1", "2", "3", "4", "0"]]


def test_what_does_not_differ_stands_once():
    assert bench.beside((HEADER, FREE), (HEADER, FREE)) == (list(HEADER), FREE)


def test_few_columns_that_differ_stand_side_by_side():
    charged = [FREE[0], ["y", "1", "9", "3", "4", "5"]]
    header, rows = bench.beside((HEADER, FREE), (HEADER, charged))
    assert header == ["what", "a", "b", "b, flash cache", "c", "d", "late", "late, flash cache"]
    assert rows == [["x", "1", "2", "2", "3", "4", "0", "0"], ["y", "1", "2", "9", "3", "4", "0", "5"]]


def test_of_many_the_rows_follow_each_other():
    charged = [FREE[0], ["y", "6", "7", "8", "9", "0"]]
    header, rows = bench.beside((HEADER, FREE), (HEADER, charged))
    assert header == ["what", "flash cache", "a", "b", "c", "d", "late"]
    assert rows == [
        ["x", "yes or no", "1", "2", "3", "4", "0"],
        ["y", "no", "1", "2", "3", "4", "0"],
        ["y", "yes", "6", "7", "8", "9", "0"],
    ]


def test_every_part_has_its_place_in_the_document():
    document = bench.DOCUMENT.read_text()
    for part in bench.PARTS:
        assert "a table" in bench.replace(document, part, "a table")
    with pytest.raises(Failure):
        bench.replace(document, "nothing", "")
