"""Points a second over the links of the emulated Pico, asleep otherwise and stepping flat out. Times are the chip's own."""

import pytest
from emulated import rig, uf2, usb_rig  # noqa: F401

from host_tools.emulator.sender import NEXT, Sender

pytestmark = [pytest.mark.on_a_copy]
COUNT = 240
HZ = 100_000  # of each of three axes
OF_THE_WIRE = 0.9
USB_IDLE, USB_STEPPING = 2000, 1500


def all_is_well(sent, count):
    return (sent.answers, sent.late, sent.lost, sent.log) == (NEXT * count, 0, 0, "[]")


@pytest.mark.xdist_group("rig")
@pytest.mark.parametrize("baud", [57_600, 115_200])
def test_points_on_the_uart(rig, baud, show):
    sent = Sender(rig, baud).send(COUNT, hz=HZ)
    assert all_is_well(sent, COUNT), sent
    assert sent.share >= OF_THE_WIRE
    show(f"points at {baud} baud, three axes at 100 kHz", f"{sent.rate:.0f} a second, {sent.share:.0%} of the wire")


@pytest.mark.slow
@pytest.mark.xdist_group("usb_rig")
@pytest.mark.parametrize("hz, least", [(0, USB_IDLE), (HZ, USB_STEPPING)])
def test_points_over_usb(usb_rig, hz, least, show):
    sent = Sender(usb_rig).send(COUNT, hz=hz)
    assert all_is_well(sent, COUNT), sent
    assert sent.rate >= least
    show(f"points over USB, three axes at {hz // 1000} kHz", f"{sent.rate:.0f} a second")


@pytest.mark.slow
@pytest.mark.xdist_group("rig")
def test_a_program_that_waits_for_each_answer(rig, show):
    """Main loop and feeder fall into step with each other: no word may be late for it."""
    sent = Sender(rig, 57_600).send(COUNT // 3, window=1, hz=HZ)
    assert all_is_well(sent, COUNT // 3), sent
    show("points one by one at 57 600 baud, three axes at 100 kHz", f"{sent.rate:.0f} a second")
