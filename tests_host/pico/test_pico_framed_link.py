"""Lines of G-code in frames, over the emulated Pico's USB and UART."""

import pytest
from emulated import uf2  # noqa: F401

from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.streaming import lines_s, streaming_router

pytestmark = pytest.mark.slow
COUNT = 500


@pytest.mark.parametrize("link, share", [("pc", 0.9), ("serial", 0.85)])
def test_frames_are_nearly_as_fast_as_plain_text(uf2, show, link, share):
    machine = streaming_router((link,), 200)
    framed, plain = (on_a_copy(lambda: lines_s(machine, link, frames, COUNT)) for frames in (True, False))
    show(f"lines a second on {link}, in frames and plain", f"{framed:.0f}, {plain:.0f}")
    assert framed > share * plain
