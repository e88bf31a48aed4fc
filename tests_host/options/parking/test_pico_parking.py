"""Parking on the emulated Pico: its pins go the way of the virtual board's, up before anything else and back to the step."""

import copy

from emulated import make_machine, uf2  # noqa: F401

from host_tools import boards


def test_the_path_is_the_one_without_a_door(make_machine, show):  # noqa: F811
    board = {**copy.deepcopy(boards.load("router_3axis")), "idle_release_ms": 0, "journal": None}
    board["parking"] = {"target_mm": -1, "mm_min": 1500, "pull_out_mm": 1, "pull_out_mm_min": 900}
    board["spindle"] = {**board["spindle"], "spin_up_ms": 100, "coolant_ms": 50}
    machine = make_machine(board)
    machine.run_until(lambda: b"$H" in machine.replies_so_far() or b"$X" in machine.replies_so_far(), 10_000)

    def do(*lines):
        for line in lines:
            machine.take()
            machine.send(line.encode() + b"\n")
            machine.run_until(lambda: b"ok" in machine.replies_so_far() or b"error" in machine.replies_so_far(), 60_000)
            assert b"ok" in machine.replies_so_far(), (line, machine.replies_so_far())

    def until(state):
        for _ in range(400):
            machine.take()
            machine.send(b"?")
            machine.run_until(lambda: b">" in machine.replies_so_far(), 2000)
            if b"<" + state in machine.replies_so_far():
                return
            machine.run_ms(20)
        raise AssertionError((state, machine.replies_so_far()))

    for axis, steps in zip("xyz", (500, 400, -500)):
        machine.plant.slip_motor(axis, steps - machine.plant.position["xyz".index(axis)])
    do("$H", "G21G90G17", "M3S12000", "G1Z-3F1500")
    machine.settle()
    first = len(machine.trace.rows())
    do("X3F1500", "G2X5Y3R4", "G1X1Y1")
    machine.run_ms(300)
    places = []
    for then_ms in (150, 500, 0):  # the second time it is on its way back
        machine.plant.set_input(0, "door", True)
        until(b"Door:1")
        assert machine.plant.position[2] == -400 and not machine.plant.tool
        places.append(tuple(machine.plant.position[:2]))
        machine.plant.set_input(0, "door", False)
        until(b"Door:0")
        machine.send(b"~")
        machine.run_ms(then_ms)
    until(b"Idle")
    machine.settle()
    assert machine.plant.position == [320, 320, -1200] and not machine.plant.errors
    rows = [row[1:4] for row in machine.trace.rows()[first:]]
    moved = [there - said for there, said in zip(machine.plant.position, rows[-1])]  # by hand, before homing
    rows = [tuple(each + by for each, by in zip(row, moved)) for row in rows]
    away = [row for row in rows if row[2] > -1200]
    assert away and {row[:2] for row in away} == {*places}, "off the path only up and down, where the door found it"
    way = [row[:2] for row in rows if row[2] == -1200]
    assert max(max(abs(a - c), abs(b - d)) for (a, b), (c, d) in zip(way, way[1:])) == 1, "not a step is missing"
    show("parking on a Pico", f"parked at {places}, ended at {machine.plant.position}")
