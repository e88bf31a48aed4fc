"""M66 on the emulated Pico: a change of a pin that lasts as long as docs/use/spindle.md wants lets the program go on."""

import copy
import random

from emulated import make_machine, uf2  # noqa: F401

from host_tools import boards

CHANGE_MS = 20
PIN = {"name": "p0", "pin": 22, "active": 0, "pull": "up"}


def test_a_pin_ends_the_wait(make_machine, show):  # noqa: F811
    board = {**copy.deepcopy(boards.load("router_3axis")), "journal": None, "inputs": [*boards.load("router_3axis")["inputs"], PIN]}
    machine = make_machine(board)
    machine.run_until(lambda: b"$H" in machine.replies_so_far() or b"$X" in machine.replies_so_far(), 10_000)

    def ask(data, answer=b"ok"):
        machine.take()
        machine.send(data + b"\n" if answer == b"ok" else data)
        machine.run_until(lambda: answer in machine.replies_so_far() or b"error" in machine.replies_so_far(), 10_000)
        assert answer in machine.replies_so_far(), (data, machine.replies_so_far())
        return machine.take()

    machine.plant.set_input(0, "p0", False)
    ask(b"$X")
    ask(b"G21G91G1X1F1500")
    machine.settle()
    chance = random.Random(66)
    found, places, took_ms = [], [], []
    for seen_ms in (CHANGE_MS, 0) * 4:
        at = machine.plant.position[0]
        machine.send(b"M66P0L1Q60\nX0.5\n")
        machine.run_ms(100 + 30 * chance.random())
        assert b"<Run|" in ask(b"?", b">") and machine.plant.position[0] == at
        machine.plant.set_input(0, "p0", True)
        begun_ms = machine.now_ms()
        if seen_ms:
            machine.run_ms(seen_ms)
            machine.plant.set_input(0, "p0", False)
        else:
            machine.run_until(lambda: machine.plant.position[0] != at, 1000, 100)
            took_ms.append(machine.now_ms() - begun_ms)
        machine.settle()
        machine.plant.set_input(0, "p0", False)
        places.append(machine.plant.position[0] - at)
    begun_ms = machine.now_ms()
    ask(b"M66P0L1Q0.2")
    waited_ms = machine.now_ms() - begun_ms
    for _ in range(31):
        found += [field for field in ask(b"?", b">").strip(b"\r\n>").split(b"|") if field[:3] == b"In:"]
    assert places == [160] * 8 and max(took_ms) < 2 * CHANGE_MS and 200 <= waited_ms <= 200 + 2 * CHANGE_MS and {*found} == {b"In:-1"}
    show("M66 on a Pico", f"first step {min(took_ms):.1f} to {max(took_ms):.1f} ms behind the pin; time-out of 200 ms after {waited_ms:.1f}")
