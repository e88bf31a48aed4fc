"""Feeds in mm/s where mm/min are wanted: a job that takes sixty times too long is asked about."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host_tools.cli.check import _check_file
from host_tools.programs.feeds import fastest_feed, slow_feeds

FABLIN = "G90\nG0 Z5.0000 F10000\nG0 X10.0000 Y0.0000\nG1 Z-1.0000 F2.50\nG1 X40.0000 F10.00\nM5\nG00 X-1.0 Y1.0\n"


def rows_of(text):
    return list(enumerate((line.encode() for line in text.splitlines()), 1))


@pytest.mark.parametrize("text, feed", [
    (FABLIN, 10), ("G1 X1 F600", 600), ("F600 G0 X1\nG1 X2", 600), ("G20 G1 X1 F2", 50.8), ("G93 G1 X1 F2", 0), ("G0 X1 F900", 0), ("$X", 0), ("g1x5f7g4p1", 7), ("G1 F5 X1\nX2 F9\nX3 F4", 9),
])  # fmt: skip
def test_the_fastest_feed(text, feed):
    assert fastest_feed(rows_of(text), 1000) == pytest.approx(feed)


@given(st.lists(st.floats(1, 5000), min_size=1, max_size=9))
def test_it_is_the_largest_of_all(feeds):
    text = "".join(f"G1 X{index} F{feed:.3f}\nG0 X0 F9000\n" for index, feed in enumerate(feeds))
    assert fastest_feed(rows_of(text), 1e9) == pytest.approx(max(feeds), abs=0.001)
    assert bool(slow_feeds(rows_of(text), 1000.0)) == (round(max(feeds), 3) <= 100) and not slow_feeds(rows_of(text), 10.0)


def test_check_asks_about_a_file_of_fablin(tmp_path, capsys):
    path = tmp_path / "a.nc"
    path.write_text(FABLIN)
    _check_file(path, "router_3axis", ((), None, None), None, None, None)
    said = capsys.readouterr().out
    assert "every feed is 10 mm/min or less" in said and "fablin" in said and "write F600 in place of F10" in said
    path.write_text(FABLIN.replace("F10.00", "F600"))
    _check_file(path, "router_3axis", ((), None, None), None, None, None)
    assert "mm/min or less" not in capsys.readouterr().out
