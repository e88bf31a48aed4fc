"""Programs with Z on machines of two axes: which words go, which lift the pen, which are refused."""

import pytest

from host_tools.cli.check import _check_file
from host_tools.failure import Failure
from host_tools.programs.flat import without_z

PEN = "G21G90 M3S500 G0Z5 G0X10Y0 G1Z-0.1F300 X20F600 Y5Z-0.1 G0Z5 X0 G1X1Z-1 X2Z1 M5"


def rows_of(text):
    return list(enumerate((line.encode() for line in text.split()), 1))


def flat(text, pen=None):
    return " ".join(line.decode() for _, line in without_z(rows_of(text), pen))


@pytest.mark.parametrize("text, line", [
    (PEN, "line 3, G0Z5"), ("G90 G0Z-1 M4S1 G91 X1 G1X5Z0.1F90", "line 6, G1X5Z0.1F90"), ("M3S1 G81X1Z-1R2F90", "line 2, G81"), ("M3S1 G2X2Z1I1F9", "line 2"),
    ("G0Z-2 M3S1Z-1", "line 2, M3S1Z-1"), ("M3S1 G28Z1", "line 2, G28Z1"), ("G92Z9 G0Z-3 M3S9 G53G0Z0", "line 4"),
])  # fmt: skip
def test_the_tool_stays_on_as_z_rises(text, line):
    with pytest.raises(Failure) as refused:
        flat(text)
    assert line in str(refused.value) and "--z-pen" in str(refused.value)


def test_z_is_left_out():
    """Words that want an axis keep Z0, with which nothing moves: G28 without a word would move X and Y."""
    assert flat("G21G90 G0Z5 G0X1Y2Z3 M3S5 G1Z-1F90 X5Z-2 M5 G0Z9 G91G28Z0 G92Z1 $G") == "G21G90 G0Z0 G0X1Y2 M3S5 G1Z0F90 X5 M5 G0Z0 G91G28Z0 G92Z0 $G"
    assert flat("M3S5 G1X1Z0F90 Z0 M5Z4") == "M3S5 G1X1F90 Z0 M5Z0"


def test_z_lifts_a_pen():
    """The tool is on where the program has it on and Z is down from one end of the line to the other."""
    wanted = "G21G90 M3 S500 M5 G0Z0 G0X10Y0 G1Z0F300 M3 X20F600 Y5 M5 G0Z0 X0 G1X1 M3 M5 X2"
    assert flat(PEN, 0.0) == wanted
    assert flat("G20 M4S9 G0X1Z0.1 G0Z0.05", 2.0) == "G20 M4 S9 M5 G0X1 G0Z0 M4"
    with pytest.raises(Failure, match="no pen"):
        flat("G0Z1 G1X1Z-1F9", 0.0)


@pytest.mark.parametrize("pen", [None, 0.0])
def test_a_laser_takes_it(tmp_path, capsys, pen):
    file = tmp_path / "a.nc"
    file.write_text("G21 G90\nG0 Z0\nG0 X5 Y5\nM3 S500\nG1 X20 F1000\nM5\nG0 Z3\n")
    with pytest.raises(Failure, match="1 line "):
        _check_file(file, "laser_xy", ((), None, None), None, None, None)
    assert "--drop-z" in capsys.readouterr().err
    _check_file(file, "laser_xy", ((), None, None), None, None, None, True, pen)
    with pytest.raises(Failure, match="has a Z axis"):
        _check_file(file, "router_3axis", ((), None, None), None, None, None, True, pen)
