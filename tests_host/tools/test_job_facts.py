"""The panel's facts of a job before it runs."""

import pytest
from hypothesis import given, strategies as st

from host_tools import boards
from host_tools.panel import job_facts
from passo.config.boardfile import check

pytestmark = pytest.mark.quick
SETTINGS = {110: "6000", 111: "6000", 112: "3000", 120: "500", 121: "500", 122: "300"}


def numbered(text):
    return list(enumerate(text.encode().split(b"\n"), 1))


@given(st.lists(st.integers(-50, 50), max_size=200))
def test_the_parts_are_those_of_the_whole(places):
    found = job_facts.gcode_facts(numbered("G21 G90 F1200\n" + "\n".join(f"G1 X{place}" for place in places)), SETTINGS)
    assert len(found["parts"]) == 33 and found["parts"] == sorted(found["parts"])
    assert found["parts"][0] == 0 and found["parts"][-1] == found["seconds"]
    length = sum(abs(to - at) for at, to in zip([0, *places], places))
    assert found["seconds"] >= length / 20 - 0.1 and found["lines"] == len(places) + (1 if places else 2)


def test_tools_and_pauses():
    found = job_facts.gcode_facts(numbered("T1 M6\nG0 X1\nM0\nM00\nT2\nM06\nM30\nM60\nT2 M6\nm1"), SETTINGS)
    assert (found["tools"], found["pauses"]) == (["T1", "T2"], 3)


def test_a_long_job_is_not_estimated():
    found = job_facts.gcode_facts([(1, b"G0 X1")] * (job_facts.MOST_LINES + 1), SETTINGS)
    assert "seconds" not in found and found["lines"] == job_facts.MOST_LINES + 1


def test_packets():
    tell = job_facts.packets_of(check(boards.load("plotter_2014")))
    short, long = (tell(numbered(f"MOVE 100 100\nLINE {x} 100\nEND"), {}) for x in (200, 900))
    assert 0 < short["seconds"] < long["seconds"] and short["lines"] == 3
