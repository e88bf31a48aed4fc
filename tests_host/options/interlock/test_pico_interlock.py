"""The interlock on the emulated Pico: from a limit's edge to the last step, and noise at speed."""

from functools import lru_cache
from random import Random

import pytest
from emulated import uf2  # noqa: F401

from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.halting import set_out, try_halt, try_halts
from host_tools.emulator.rig import Rig, router_board

FIRST_PIN = 16
FILTER_US = 50
NAMES = ("right", "left", "good", "stop")
INPUTS = [
    {"name": "right", "pin": FIRST_PIN, "active": 1, "pull": "down", "filter_us": FILTER_US},
    {"name": "left", "pin": FIRST_PIN + 1, "active": 1, "pull": "down", "filter_us": FILTER_US},
    {"name": "good", "pin": FIRST_PIN + 2, "active": 0, "pull": "down", "filter_us": FILTER_US},  # low at rest: active
    {"name": "stop", "pin": FIRST_PIN + 3, "active": 1, "pull": "down", "halt": True},
]
TABLE = {
    "rows": {"enable": "!stop", "x": "good", "y": "good", "tool": "!stop"},
    "limits": {"x+": "right", "x-": "left"},
}
DELTAS = (3000, 2333, -1875)
SAID = """
print([port.veto.glitches[n] for n in range(4)], controller.machine.alarm, controller.machine.log.entries)
"""


@lru_cache
def _rig(uf2):
    return Rig(router_board(3, inputs=INPUTS, interlock=TABLE), uf2)


@pytest.fixture(scope="session")
def guarded(uf2):  # noqa: F811
    """A Rig with an interlock. Only for tests marked `on_a_copy`."""
    return _rig(uf2)




@pytest.mark.on_a_copy
@pytest.mark.xdist_group("interlock")
@pytest.mark.parametrize("steps_s", [30_000, 100_000])
@pytest.mark.parametrize("name", ["right", "good", "stop"])
def test_from_the_edge_to_the_last_step(guarded, steps_s, name, show):
    """The steps end with the filter's time and the interrupt's, and the firmware knows the position to the step."""
    random = Random(steps_s)
    pin = FIRST_PIN + NAMES.index(name)
    set_out(guarded, DELTAS, steps_s, 2000)
    found = try_halts(guarded, pin, [random.uniform(0, 15_000) for _ in range(4)])
    filter_us = 0 if name == "stop" else FILTER_US
    for reaction_us, reported, counted, _ in found:
        assert reported == counted and any(counted)
        assert reaction_us <= filter_us + 120 + 1e6 / steps_s
    worst = max(found)[0]
    show(f"interlock, {name} at {steps_s // 1000} kHz", f"last step at most {worst:.0f} µs after the edge, filter {filter_us} µs")


@pytest.mark.on_a_copy
@pytest.mark.xdist_group("interlock")
def test_a_limit_behind_lets_it_go_on(guarded):
    set_out(guarded, DELTAS, 30_000, 2000)
    guarded.pico.drive_pin(FIRST_PIN + 1, 1)
    guarded.pico.run(3000)
    before = sum(map(abs, guarded.count_steps()))
    guarded.pico.run(3000)
    assert sum(map(abs, guarded.count_steps())) > before + 100
    _, reported, counted, _ = on_a_copy(lambda: try_halt(guarded, FIRST_PIN, 0))
    assert reported == counted


@pytest.mark.on_a_copy
@pytest.mark.xdist_group("interlock")
@pytest.mark.parametrize("steps_s", [30_000, 100_000])
def test_spikes_stop_nothing_and_are_counted(guarded, steps_s, show):
    """Spikes of up to 5 µs, 150 µs and more apart, and bursts of up to 40 µs, while three axes step."""
    random = Random(steps_s)
    set_out(guarded, DELTAS, steps_s, 2000, "controller.machine.alarm = 1 if planner.empty() and not player.busy() else 0")
    wanted = [0, 0, 0, 0]
    for _ in range(30):
        number = random.randrange(3)
        pin, rest = FIRST_PIN + number, 0
        width_us = random.choice((2, 5, 40))
        guarded.pico.drive_pin(pin, 1 - rest)
        guarded.pico.run(width_us)
        guarded.pico.drive_pin(pin, rest)
        guarded.pico.run(random.randint(150, 400))
        wanted[number] += 1
    assert guarded.pico.run_until(lambda: guarded.pico.console.text.count(b"\x04") >= 2, 400_000, 500)
    position = eval(guarded.pico.console.take_output().split(b"\x04")[0].decode())
    assert position == guarded.count_steps() == list(DELTAS)
    said = guarded.pico.exec(SAID).strip()
    assert said.startswith(f"{wanted} 1 []"), said
    show(f"interlock, spikes at {steps_s // 1000} kHz", f"{sum(wanted)} spikes, all counted, no step lost")


@pytest.mark.slow
@pytest.mark.on_a_copy
@pytest.mark.xdist_group("interlock")
@pytest.mark.parametrize("steps_s", [30_000, 100_000])
def test_bursts_of_many_spikes_stop_nothing(guarded, steps_s, show):
    """Up to eight spikes within 5 to 50 µs, on two wires at once. Those within one interrupt count as one: never more than were
    injected, never none."""
    random = Random(steps_s + 1)
    set_out(guarded, DELTAS, steps_s, 2000, "controller.machine.alarm = 1 if planner.empty() and not player.busy() else 0")
    bursts, most = [0, 0, 0, 0], [0, 0, 0, 0]
    for _ in range(25):
        numbers = random.sample(range(3), 2)
        within_us = random.choice((5, 50))
        times = sorted(random.sample(range(1, 10 * within_us), 2 * random.randint(2, 8)))
        events = []
        for number in numbers:
            shift = random.randint(0, 20)
            events += [((time + shift) / 10, number, 1 - index % 2) for index, time in enumerate(times)]
            bursts[number] += 1
            most[number] += len(times) // 2
        now_us = 0
        for at_us, number, level in sorted(events):
            guarded.pico.run(at_us - now_us)
            now_us = at_us
            guarded.pico.drive_pin(FIRST_PIN + number, level)
        guarded.pico.run(random.randint(300, 500))
    assert guarded.pico.run_until(lambda: guarded.pico.console.text.count(b"\x04") >= 2, 400_000, 500)
    position = eval(guarded.pico.console.take_output().split(b"\x04")[0].decode())
    assert position == guarded.count_steps() == list(DELTAS)
    glitches, _, rest = guarded.pico.exec(SAID).strip().partition("] ")
    found = eval(glitches + "]")
    assert rest == "1 []", rest
    for number in range(3):
        assert bursts[number] // 2 <= found[number] <= most[number], (found, bursts, most)
    show(f"interlock, bursts at {steps_s // 1000} kHz", f"{sum(bursts)} bursts of {sum(most)} spikes, {sum(found)} counted, no step lost")


LOCKED = """
import micropython
interlock = port.veto
watch = interlock.items[0]
def locked():
    micropython.heap_lock()
    interlock.start()
    interlock.take_change(0, 1)
    interlock.start()
    interlock.take_change(2, 0)
    interlock.take_change(2, 1)
    interlock.take_change(0, 0)
    interlock.update_denied()
    port.trip(interlock.items[3])
    interlock.take_change(3, 0)
    micropython.heap_unlock()
planner.line((4000, 3000, -2000), 12_500_000, False)
planner.flush()
controller.machine.awake = True
for turn in range(40):
    app.cycle()
before = gc.mem_alloc()
locked()
print(gc.mem_alloc() - before, port._trip is not None, list(interlock.trips), feeder.position(player.words_played()))
"""


@pytest.mark.on_a_copy
@pytest.mark.xdist_group("interlock")
def test_nothing_is_allocated_in_the_interrupt(guarded):
    """Changes that forbid amid a line, with the heap locked; outputs go off, the player stops, the position is known."""
    guarded.clear_edges()
    said = guarded.pico.exec(LOCKED).split(" ", 2)
    assert said[:2] == ["0", "True"], said
    trips, position = eval(said[2].replace("] [", "], ["))
    assert trips == [0, 0, 0, 1] and position == guarded.count_steps() and any(position)
