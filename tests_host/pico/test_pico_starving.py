"""A stream of lines or dots on the emulated Pico that are played at 50 to 150 % of the rate at which its link brings them: the step pin
says that it does not stand, and how long it takes.
"""

from functools import lru_cache

import pytest
from emulated import uf2  # noqa: F401

from host_tools import boards
from host_tools.clients.grbl import GrblClient
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.cycles import CYCLES_PER_US
from host_tools.emulator.machine import EmulatedMachine
from host_tools.emulator.streaming import EmulatedPort

STEPS_MM = 80
ACCEL_MM_S2 = 20_000
FASTEST = 40_000  # mm/min
STEP = boards.load("laser_xy")["axes"][0]["pins"][0]
STAND_MS = 5
LATE = 1.05  # of the time that the lines take to be played, or to come
COUNT = 2000  # lines: they last most of a second, because a queue of 30 ms has to be made first
PC_US = 1000  # it looks for answers as often as real ones do, in the mean
SEED = 1
SHARES = (50, 80, 100, 120, 150)
MM = 0.1  # of a line
WHAT = {"lines": "", "M3": "M3S0", "M4": "M4S0"}  # lines sent before
pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("starving")]


@lru_cache
def laser(uf2, clock_mhz, fastest=FASTEST):  # noqa: F811
    """A booted laser whose axes are faster than any link; its links as they are."""
    board = {**boards.load("laser_xy"), "clock_mhz": clock_mhz}
    for axis in board["axes"]:
        axis.update(accel_mm_s2=ACCEL_MM_S2, max_mm_min=fastest)
    machine = EmulatedMachine(board, trace=None, uf2=uf2).boot()
    machine.run_until(lambda: b"unlock" in machine.replies_so_far("pc"), 10_000)
    machine.run_ms(500)
    return machine


def stream(machine, link, what, mm_min, count, mm=MM):
    """(ms from the first step to the last, the longest time between two steps in ms, steps) of a straight row of lines."""
    client = GrblClient(link, timeout_s=1e6, opened=EmulatedPort(machine, link, PC_US, SEED))
    if link != machine.board["links"][0]["name"]:
        client.command("$LINK=0")
    for line in ("$X", "G21G91G94", "G1F%d" % mm_min, "X1", "X-1", WHAT[what]):
        client.command(line)
    machine.run_ms(500)
    edges = machine.pico.record_edges(STEP)
    lines = [b"G1X%.4fY0.0000" % mm + (b"S%d" % (number * 397 % 999 + 1) if WHAT[what] else b"") for number in range(count)]
    for _ in client.stream(list(enumerate(lines))):
        pass
    machine.settle()
    rises = [cycle / CYCLES_PER_US / 1000 for cycle, state in edges if state == 1]
    return rises[-1] - rises[0], max(after - before for before, after in zip(rises, rises[1:])), len(rises)


@pytest.mark.parametrize("what, link, clock_mhz", [
    ("lines", "usb", 125), ("lines", "usb", 200), ("lines", "pc", 125), ("M3", "usb", 125), ("M4", "usb", 200), ("M4", "pc", 125),
])  # fmt: skip
def test_a_starved_stream_does_not_stand(uf2, what, link, clock_mhz, show):  # noqa: F811
    machine = laser(uf2, clock_mhz)
    unlimited_ms, _, steps = on_a_copy(lambda: stream(machine, link, what, FASTEST, COUNT))
    assert steps == round(COUNT * MM * STEPS_MM)
    rate = COUNT * 1000 / unlimited_ms
    assert rate * MM * 60 < FASTEST / 1.5, "the link, and not the axes, is the limit"
    told = []
    for share in SHARES:
        mm_s = rate * MM * share / 100
        took_ms, longest_ms, steps = on_a_copy(lambda: stream(machine, link, what, mm_s * 60, COUNT))
        assert steps == round(COUNT * MM * STEPS_MM)
        wanted_ms = max(COUNT * MM / mm_s, COUNT / rate) * 1000 + mm_s * 1000 / ACCEL_MM_S2
        told.append((share, longest_ms, took_ms / wanted_ms))
    show(f"{what} over {link} at {clock_mhz} MHz, {rate:.0f} a second", ", ".join("%d %%: %.1f ms, %.3f" % row for row in told))
    assert all(longest_ms <= STAND_MS and share_of_time <= LATE for _, longest_ms, share_of_time in told), told


def test_feeds_beyond_any_link(uf2):  # noqa: F811
    """Lines that would be played three times as fast as they come."""
    machine = laser(uf2, 200, 60_000)
    slower, faster = (on_a_copy(lambda: stream(machine, "usb", "lines", mm_min, 300, 0.2)) for mm_min in (24_000, 60_000))
    assert faster[0] <= slower[0] and faster[1] <= STAND_MS
