"""A dwell takes as long as it says, also one for which the queue has no room; a reset ends it."""

import pytest

from host_tools.sim.machine import VirtualMachine
from passo.control import program
from passo.records import TICKS_PER_MS


@pytest.fixture
def router():
    machine = VirtualMachine("router_3axis", trace=None)
    machine.send(b"$X\n")
    machine.run_ms(100)
    machine.take()
    return machine


@pytest.mark.parametrize("seconds, at_a_time_ms", [(3.25, 700), (2.8, 700), (0.7, 700), (2, 3_600_000)])
def test_it_lasts_as_long_as_it_says(router, monkeypatch, seconds, at_a_time_ms):
    monkeypatch.setattr(program, "_DWELL_MS", at_a_time_ms)
    router.send(f"G4P{seconds}\n".encode())
    begun = router.port.now
    router.run_until(lambda: b"ok" in router.replies_so_far())
    took_ms = (router.port.now - begun) / TICKS_PER_MS
    assert 0 <= took_ms - 1000 * seconds < 60


def test_one_that_is_longer_than_the_queue_is_ended_by_a_reset(router):
    router.send(b"G4P111111111\n")
    router.run_ms(500)
    assert 0 < router.app.planner.room() < 96
    router.send(b"?")
    router.run_ms(100)
    assert b"<Run|" in router.take()
    router.send(b"\x18")
    router.run_ms(500)
    assert b"Grbl 1.1h" in router.take()
    router.send(b"$X\nG91G1X1F600\n")
    router.run_ms(2000)
    assert router.take().count(b"ok") == 2
    assert router.app.planner.room() == 96
