"""The heap of the emulated Pico: the free bytes with the App loaded, and that making words takes none of them."""

import pytest
from emulated import rig, uf2  # noqa: F401

pytestmark = [pytest.mark.on_a_copy, pytest.mark.xdist_group("rig")]
FREE_BYTES = 80_000

LOCKED = """
import micropython
from passo.motion.limits import Limits
port._timer.deinit()
planner.load()
feeder.ramp = planner.ramp
planner.limits(Limits([400000] * 3, [400_000_000] * 3, [20_000_000_000] * 3, 10_000))
for deltas in ((400, 300, -200), (-400, 20, 0), (0, 0, 200)):
    planner.line(deltas, 40_000, False)
planner.flush()
feeder.open, feeder.hold, feeder.brake = True, False, False
def locked():
    micropython.heap_lock()
    for turn in range(5000):
        feeder.fill(player.words_played(), 150_000)
        player.start()
        if planner.empty():
            break
    micropython.heap_unlock()
for turn in range(25):  # the motors wake up
    controller.poll()
    sleep_ms(1)
before = gc.mem_alloc()
locked()
print(gc.mem_alloc() - before, feeder.late, feeder.position(player.words_played()))
"""


def test_words_are_made_without_the_heap(rig):
    rig.clear_edges()
    assert rig.pico.exec(LOCKED) == "0 0 [0, 320, 0]\r\n"
    assert rig.count_steps() == [0, 320, 0]


def test_room_on_the_heap(rig, show):
    free = int(rig.pico.exec("gc.collect()\nprint(gc.mem_free())"))
    assert free >= FREE_BYTES
    show("heap free on the Pico, a plotter's App loaded", f"{free} bytes")
