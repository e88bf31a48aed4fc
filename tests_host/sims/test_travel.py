"""Over random programs no axis leaves its travel, and no axis or motor is faster than it may be: soak_travel.py, on four axes, CoreXY, lost motion."""

import pytest
import soak_travel


@pytest.mark.parametrize("programs", [(0, 2), pytest.param((2, 20), marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", soak_travel.BOARDS)
def test_no_axis_leaves_its_travel(name, programs, show):
    refused, places = soak_travel.run(name, *programs)
    assert refused and places > 10_000
    show(f"travel of {name}", f"{programs[1] - programs[0]} programs, {refused} lines refused, {places} places")
