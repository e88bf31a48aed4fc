"""Names, units and bounds of settings: for each that there is, and as the firmware has them."""

import pytest

from host_tools import boards
from host_tools.clients import setting_names
from passo.config.boardfile import check
from passo.config.setting_numbers import PULSE_US

pytestmark = pytest.mark.quick
DECIMAL = 3


@pytest.mark.parametrize("name", boards.names())
def test_every_setting_has_a_name_and_the_bounds_of_the_firmware(name):
    board = check(boards.load(name))
    spoken = [link["protocol"] for link in board["links"]]
    of_options = getattr(board.get("additions"), "settings", {})
    for number, (_, places, _, least, most) in boards.settings_of(board).items():
        if number in of_options:
            continue  # a folder that was added has the names of its own, or none
        title, _, *bounds = setting_names.rule_of(number, len(board["axes"]))
        scale = 1000 if places == DECIMAL else 1
        own = [least / scale, most / scale]
        assert title and bounds[0] <= own[0] <= own[1] <= bounds[1], number
        narrower = number == PULSE_US or "grbl" not in spoken  # a pulse leaves room for the board's speeds; others have no homing
        assert bounds == own or narrower, number


def test_lines_with_what_they_mean():
    lines = ["$3=1", "$11=0.010", "$100=320.000", "$101=320.000", "$112=1500.000", "$N0=G54", "G10L2P2X1.000Y0.000", "$777=1"]
    shown = setting_names.describe_lines(lines)
    assert [text.split("  ")[0].strip() for text in shown] == lines
    assert "direction pin high" in shown[0] and shown[0].endswith("0 … 3")
    assert "mm " in shown[1] and shown[1].endswith("0 … 10")
    assert "x: steps per millimetre" in shown[2] and "steps/mm" in shown[2] and shown[2].endswith("0.001 … 100000")
    assert "z: highest speed" in shown[4] and shown[4].split()[-4:] == ["mm/min", "0.001", "…", "999999.999"]
    assert "origin of G55" in shown[6] and shown[7] == "$777=1"
