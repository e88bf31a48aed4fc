"""A status asked for on the emulated Pico: its fields, and the time to the answer while three axes step at 100 kHz."""

from statistics import median

import pytest
from emulated import uf2  # noqa: F401

from host_tools.bench import moving

pytestmark = [pytest.mark.on_a_copy, pytest.mark.xdist_group("status")]
ANSWERS = 24
SETTLE_MS = 400


@pytest.fixture
def asked(uf2):
    return moving.boot_router("pc")


@pytest.mark.slow
def test_answers_come_in_time_while_three_axes_step(asked, show):
    """All but one: asking leaves next to no garbage, but garbage of before may be collected now."""
    took_ms = sorted(moving.time_answers(asked, moving.long_lines(), ANSWERS))
    show("`?` on the Pico at 3 x 100 kHz", f"median {median(took_ms):.1f} ms, all but one within {took_ms[-2]:.1f} ms")
    assert median(took_ms) <= 4.5 and took_ms[-2] <= 5


@pytest.mark.slow
def test_places_are_told_to_the_last_digit(asked):
    """Machine code with integers of 32 bits, on both sides of zero and in both units."""
    machine, asking = asked

    def tell(*lines):
        asking.stream_lines([line + b"\n" for line in lines])
        machine.run_until(lambda: not asking.unanswered, 1000)
        machine.run_ms(SETTLE_MS)
        asking.said.clear()
        asking.ask_status()
        machine.run_ms(20)
        return bytes(asking.said)

    assert b"<Idle|MPos:-1.250,12.500,-0.003|" in tell(b"G90G0X-1.25Y12.5Z-.003")
    assert b"<Idle|WPos:-10001.250,12.500,-0.003|Bf:96,512|FS:0,0|" in tell(b"G10L2P1X10000", b"$10=2")
    assert b"<Idle|WPos:-393.7500,0.4921,-0.0001|" in tell(b"$13=1")
