"""The time that a job takes, thought out before it starts, beside what the firmware takes for it."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from host_tools import boards
from host_tools.programs import gcode_file
from host_tools.programs.gcode_time import Limits, Remaining, estimate_seconds
from host_tools.sim.job import VirtualJob

SETTINGS = ["$110=5000.000", "$111=5000.000", "$112=1500.000", "$120=250.000", "$121=250.000", "$122=150.000"]
ROUTER = Limits.of_settings(SETTINGS)


def numbered(text):
    return list(enumerate(text.encode().split(b"\n"), 1))


def test_the_settings_are_the_boards():
    board = boards.load("router_3axis")
    assert ROUTER.speeds[:3] == [axis["max_mm_min"] / 60 for axis in board["axes"]]
    assert ROUTER.accelerations[:3] == [axis["accel_mm_s2"] for axis in board["axes"]]


@pytest.mark.parametrize("text, seconds", [
    ("G1X10F600", 1.04), ("G21G90G1X10F600\nX20\nX30", 3.04), ("G20\nG1X1F60", 1.0 * 60 / 60 + 0.1016),
    ("G1X10F600\nG4P2\nX20", 4.08), ("G91\nG1X5F600\nX5", 1.04), ("G0X50", 50 / (5000 / 60) + 5000 / 60 / 250),
    ("G2X0Y0I10J0F600", 2 * math.pi + 0.04), ("G3X10Y10R10F600", math.pi / 2 + 0.04), ("G93G1X10F30", 2.02),
    ("G92X0\nG1F600", 0.0), ("$H\n(nothing)\nM3S1000", 0.0), ("G17G2X0Y0Z-2I5P3F600", 6 * math.pi / 2 + 0.04),
])  # fmt: skip
def test_lines(text, seconds):
    assert sum(estimate_seconds(numbered(text), ROUTER)) == pytest.approx(seconds, rel=0.05, abs=0.01)


def test_corners_stop_and_straight_goes_on():
    straight, corner = (sum(estimate_seconds(numbered("F5000\nG1X50\n" + line), ROUTER)) for line in ("X100", "X50Y50"))
    assert corner - straight == pytest.approx(5000 / 60 / 250, rel=0.05)


PROGRAMS = {
    "square": "G21G90\nG1X20F3000\nY20\nX0\nY0\nG2X0Y0I5J0",
    "many": "F2000\n" + "\n".join(f"G1X{30 * math.cos(t / 30):.4f}Y{30 * math.sin(t / 30):.4f}" for t in range(200)),
    "rapids": "\n".join(f"G0X{x % 2 * 40}Y{x}Z{-x % 3}\nG1X{20 + x % 5}F1200" for x in range(30)),
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_as_the_firmware_takes_it(name):
    job = VirtualJob("router_3axis")
    job.run(numbered(PROGRAMS[name]))
    assert sum(estimate_seconds(numbered(PROGRAMS[name]), ROUTER)) == pytest.approx(job.seconds, rel=0.15)


def test_real_programs(corpus, show):
    rows = []
    for path in sorted(corpus.glob("*.gcode")):
        if path.stat().st_size < 100_000 and "Calibration" not in path.name:
            lines = gcode_file.read(path)
            job = VirtualJob("router_3axis")
            job.run(lines)
            rows.append((path.name, job.seconds, sum(estimate_seconds(lines, ROUTER))))
    assert rows and all(thought == pytest.approx(took, rel=0.2) for _, took, thought in rows), rows
    show("time of real programs", "\n".join(f"{name}: {took:.1f} s, thought {thought:.1f} s" for name, took, thought in rows))


def clock_of(seconds, pace, per_line=5):
    """(line, seconds gone, seconds that are really left) of a job that takes `pace` times what was thought."""
    ends = [sum(seconds[: index + 1]) * pace for index in range(len(seconds))]
    for index in range(len(seconds)):
        for part in range(per_line):
            gone = ends[index] - seconds[index] * pace * (1 - part / per_line)
            yield index, gone, ends[-1] - gone


@given(st.lists(st.floats(0.01, 100), min_size=1, max_size=60), st.floats(0.5, 2))
def test_what_is_left_is_right_from_the_start_and_exact_at_the_end(seconds, pace):
    """From the first moment the error is within that of the estimate, for lines of any lengths."""
    remaining = Remaining(seconds)
    shares = []
    for index, gone, left in clock_of(seconds, pace):
        said = remaining.seconds_left(index, gone)
        whole = sum(seconds) * pace
        assert abs(said - left) <= abs(1 - 1 / pace) * whole * 1.01 + 1e-6
        shares.append(remaining.share)
    assert shares == sorted(shares) and remaining.seconds_left(len(seconds), whole) == 0 and remaining.share == 1


@given(st.lists(st.floats(0.01, 100), min_size=1, max_size=60))
def test_one_long_line_does_not_fool_it(seconds):
    """If the estimate was right, the time left is right, too, at any moment of any line."""
    remaining = Remaining(seconds)
    for index, gone, left in clock_of(seconds, 1.0):
        assert remaining.seconds_left(index, gone) == pytest.approx(left, abs=1e-3 + 1e-6 * sum(seconds))


def test_no_motion_counts_lines():
    remaining = Remaining([0.0, 0.0])
    assert (remaining.seconds_left(1, 5.0), remaining.share) == (0.0, 0.5)


@given(st.text(alphabet="GXYZIJRPFMNS0123456789.-+ ", max_size=40))
@example("F-1X0")
@example("G4P-1")
def test_any_line_is_read(text):
    assert all(taken >= 0 and math.isfinite(taken) for taken in estimate_seconds(numbered("F600\nG1X1\n" + text), ROUTER))


@given(st.lists(st.tuples(st.sampled_from(["", "", "G0", "G1", "G91", "G20", "G93", "G2", "F300", "Y5"]), st.integers(-50, 50), st.sampled_from(["", "S", "S12.5"])), max_size=40))
def test_a_line_of_x_alone_is_read_as_any_other(lines):
    """Dots of a picture have a way of their own; a blank takes a line from it."""
    texts = [f"{code}X{x / 4:g}{power}" if code in ("", "G0", "G1") else code for code, x, power in lines]
    quick, other = ("F600\nG1X1\n" + "\n".join(each) for each in (texts, [text.replace("X", " X") for text in texts]))
    assert estimate_seconds(numbered(quick), ROUTER) == estimate_seconds(numbered(other), ROUTER)
