"""Hard limits of a router without an interlock on the emulated Pico: from the switch's edge to the last step, at the pins."""

import pytest
import tiers
from emulated import uf2  # noqa: F401

from host_tools import boards
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.cycles import CYCLES_PER_US
from host_tools.emulator.machine import EmulatedMachine

FILTER_US = 50
LATE_US = 250  # beside the filter
TOOL_PIN = 8
SERIAL = "serial"
pytestmark = pytest.mark.xdist_group("limits")


@pytest.fixture(scope="module")
def router(uf2):  # noqa: F811
    """Unlocked, $21 on, the spindle turning."""
    board = boards.load("router_3axis")
    board["clock_mhz"] = 125
    board["spindle"] = {**board["spindle"], "spin_up_ms": 100}
    board["links"] = [link for link in board["links"] if link["name"] == SERIAL]
    machine = EmulatedMachine(board, trace=None, start=(30_000, 20_000, -8000)).boot()
    machine.run_until(machine.is_listening, 10_000)
    machine.run_ms(500)
    machine.send(b"$X\n$21=1\nG91\nM3S24000\nG4P0.2\n")
    machine.run_until(lambda: machine.replies_so_far().count(b"ok") >= 5, 20_000)
    machine.take()
    return machine


def hit(machine, name, speed, wait_ms):
    """(µs from the edge of a limit amid a motion to the last step, the answer, whether the tool was off within 1 ms)"""
    pins = [axis["pins"][0] for axis in machine.board["axes"]]
    tool = machine.pico.record_edges(TOOL_PIN)
    logs = [machine.pico.record_edges(pin) for pin in pins]
    machine.send(b"G1X80Y-40F%d\n" % speed)
    machine.run_ms(wait_ms)
    assert sum(map(len, logs)) > 4
    pin = {item["name"]: item["pin"] for item in machine.board["inputs"]}[name]
    edge = machine.pico.cycle
    machine.pico.drive_pin(pin, 1)
    machine.run_ms(1)
    off = [state for _, state in tool] == [0]
    machine.run_ms(200)
    last = max(cycle for log in logs for cycle, state in log if state == 1)
    return (last - edge) / CYCLES_PER_US, machine.take(), off


@pytest.mark.parametrize("name", ["limit_x", "limit_y", "limit_z"])
def test_from_the_switch_to_the_last_step(router, name, show):
    """Each switch at each speed and at each of three moments of a cycle; with a commit at the highest, at one moment each."""
    found = []
    one = ["limit_x", "limit_y", "limit_z"].index(name)
    for speed in (300, 2000, 5000) if tiers.current == "all" else (5000,):
        for trial in range(3) if tiers.current == "all" else [one]:
            late_us, said, off = on_a_copy(lambda: hit(router, name, speed, 250 + 1.37 * trial))
            assert b"ALARM:1" in said
            assert late_us <= FILTER_US + LATE_US and off
            found.append(late_us)
    show(f"hard limit {name} without an interlock", f"last step at most {max(found):.0f} µs after the edge, filter {FILTER_US} µs")


def test_spikes_stop_nothing(router):
    def spikes():
        pins = [item["pin"] for item in router.board["inputs"] if item["name"][:5] == "limit"]
        router.send(b"G1X20Y-10F5000\n")
        router.run_ms(100)
        for width in (1, 5, 20, 35):
            for pin in pins:
                router.pico.drive_pin(pin, 1)
                router.pico.run(width)
                router.pico.drive_pin(pin, 0)
                router.pico.run(700)
        router.run_ms(700)
        router.send(b"?")
        router.run_ms(30)
        return router.take()

    said = on_a_copy(spikes)
    assert b"ALARM" not in said and b"<Idle|MPos:20.000,-10.000" in said
