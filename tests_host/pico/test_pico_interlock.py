"""The interlock on the emulated Pico: from a limit's edge to the last step, noise at speed, and the mill's own board file."""

from functools import lru_cache
from random import Random

import pytest
from emulated import make_machine, uf2  # noqa: F401

from host_tools import boards
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.heap import Heap
from host_tools.emulator.halting import set_out, trial, trials
from host_tools.emulator.rig import Rig, router

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
print([port.interlock.glitches[n] for n in range(4)], controller.machine.alarm, controller.machine.log.entries)
"""


@lru_cache
def _rig(uf2):
    return Rig(router(3, inputs=INPUTS, interlock=TABLE), uf2)


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
    found = trials(guarded, pin, [random.uniform(0, 15_000) for _ in range(4)])
    filter_us = 0 if name == "stop" else FILTER_US
    for reaction_us, reported, counted, _ in found:
        assert reported == counted and any(counted)
        assert reaction_us <= filter_us + 180 + 1e6 / steps_s
    worst = max(found)[0]
    show(f"interlock, {name} at {steps_s // 1000} kHz", f"last step at most {worst:.0f} µs after the edge, filter {filter_us} µs")


@pytest.mark.on_a_copy
@pytest.mark.xdist_group("interlock")
def test_a_limit_behind_lets_it_go_on(guarded):
    set_out(guarded, DELTAS, 30_000, 2000)
    guarded.pico.drive(FIRST_PIN + 1, 1)
    guarded.pico.run(3000)
    before = sum(map(abs, guarded.counted()))
    guarded.pico.run(3000)
    assert sum(map(abs, guarded.counted())) > before + 100
    _, reported, counted, _ = on_a_copy(lambda: trial(guarded, FIRST_PIN, 0))
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
        guarded.pico.drive(pin, 1 - rest)
        guarded.pico.run(width_us)
        guarded.pico.drive(pin, rest)
        guarded.pico.run(random.randint(150, 400))
        wanted[number] += 1
    assert guarded.pico.run_until(lambda: guarded.pico.console.text.count(b"\x04") >= 2, 400_000, 500)
    position = eval(guarded.pico.console.take().split(b"\x04")[0].decode())
    assert position == guarded.counted() == list(DELTAS)
    said = guarded.pico.exec(SAID).strip()
    assert said.startswith(f"{wanted} 1 []"), said
    show(f"interlock, spikes at {steps_s // 1000} kHz", f"{sum(wanted)} spikes, all counted, no step lost")


LOCKED = """
import micropython
interlock = port.interlock
watch = interlock.items[0]
def locked():
    micropython.heap_lock()
    interlock.start()
    interlock.halt_before(0)
    interlock.change(0, 1)
    interlock.start()
    interlock.halt_before(2)
    interlock.change(2, 0)
    interlock.change(2, 1)
    interlock.change(0, 0)
    interlock.decide()
    port.trip(interlock.items[3])
    interlock.change(3, 0)
    micropython.heap_unlock()
planner.line((4000, 3000, -2000), 12_500_000, False)
planner.flush()
for turn in range(40):
    app.cycle()
before = gc.mem_alloc()
locked()
print(gc.mem_alloc() - before, port._trip is not None, list(interlock.trips), feeder.position(player.played()))
"""


@pytest.mark.on_a_copy
@pytest.mark.xdist_group("interlock")
def test_nothing_is_allocated_in_the_interrupt(guarded):
    """Changes that forbid amid a line, with the heap locked; outputs go off, the player stops, the position is known."""
    guarded.clear()
    said = guarded.pico.exec(LOCKED).split(" ", 2)
    assert said[:2] == ["0", "True"], said
    trips, position = eval(said[2].replace("] [", "], ["))
    assert trips == [0, 0, 0, 1] and position == guarded.counted() and any(position)


@pytest.mark.slow
@pytest.mark.unmeasured
def test_the_mill_boots_moves_and_stops_at_its_limit(make_machine, show):  # noqa: F811
    """The board file's own firmware and table: refused towards a limit, allowed away from it, halted by one."""
    board = boards.load("mill_2004")
    board["links"] = [{"name": "serial", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "grbl"}]
    del board["inverter"]  # its serial line is this link's
    machine = make_machine(board, start=(0, 200, -200))
    machine.run_until(lambda: b"unlock" in machine.received(), 8000)
    machine.run_ms(60)
    heap = Heap(machine.pico)
    assert heap.free > 4_000, "garbage included: none is collected before memory is used up"

    def ask(line, ms=400):
        machine.take()
        machine.send(line)
        machine.run_until(lambda: any(word in machine.received() for word in (b"ok", b"error", b"ALARM", b"Grbl")), 5000)
        machine.run_ms(ms)
        return machine.take()

    assert b"ok" in ask(b"$X\n", 10)
    said = ask(b"G91G1X-5F2400\n", 600)
    assert b"ALARM:1" in said, said
    limit = machine.plant.barriers["bxa"].last
    assert limit - 12 <= machine.plant.position[0] <= limit, "4 kHz for 100 µs and an interrupt; 1 step, and some of bounce"
    assert b"[LOG:" in (log := ask(b"$LOG\n", 20)) and b",201,bxa]" in log and b"[PIN:bxa,1,1," in log, log
    ask(b"\x18", 50)
    assert b"ok" in ask(b"$X\n", 10)
    assert b"error:131" in ask(b"G91G1X-1F600\n", 10)
    at = machine.plant.position[0]
    assert b"ok" in ask(b"G91G1X1F600\n", 300)
    assert machine.plant.position[0] == at + 80
    chains = machine.wiring.chains
    assert chains.outputs[:4] == [1, 0, 0, 0], "enable, behind the 74HC595"
    assert b"ok" in ask(b"M8\n", 10) and chains.outputs[:4] == [1, 0, 1, 0]
    machine.plant.set_input(machine.wiring.tick, "dy", False)
    machine.run_ms(20)
    assert b"error:131" in ask(b"G91G1Y1F600\n", 10), "a drive fault, behind the 74HC165"
    assert b",131,dy]" in ask(b"$LOG\n", 20)
    machine.plant.set_input(machine.wiring.tick, "dy", True)
    machine.run_ms(60)
    machine.send(b"G91G1Y20F2400\n")
    machine.run_ms(100)
    machine.plant.set_input(machine.wiring.tick, "dy", False)
    begun = machine.plant.position[1]
    machine.run_ms(30)
    assert machine.plant.position[1] - begun <= 12, "3200 steps/s, seen by two readings, 3 ms apart"
    machine.plant.set_input(machine.wiring.tick, "stop", True)
    machine.run_ms(20)
    assert chains.outputs[0] == 0
    assert not machine.plant.enabled and machine.plant.errors == []
    show("mill on the emulated Pico", f"stands {limit - at} steps behind its limit's edge; heap free {heap.free}, "
         f"largest piece {heap.largest} bytes")  # fmt: skip
