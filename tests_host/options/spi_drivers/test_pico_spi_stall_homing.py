"""Homing by stallGuard2 on the emulated Pico: drivers on SPI pins that are set up bit by bit, DIAG pins that tremble and whose interrupt stops the axis."""

import pytest
from emulated import make_machine, uf2  # noqa: F401
from test_spi_stall_homing import FULL, router


@pytest.mark.slow
@pytest.mark.parametrize("chip, phase", [("tmc5160", 0), ("tmc5160", 7), ("tmc2130", 3)])
def test_it_repeats_within_two_full_steps(chip, phase, make_machine, show):  # noqa: F811
    board = router(chip, phase)
    for axis in board["axes"][:2]:
        axis["travel_steps"] = 4000
    machine = make_machine(board, start=(900, 700, -1200), stalls=phase)
    drivers = machine.drivers.model
    machine.run_until(lambda: b"$X" in machine.replies_so_far() or b"$H" in machine.replies_so_far(), 10_000)
    places = []
    for number in range(3):
        machine.take()
        machine.send(b"$H\n")
        machine.run_until(lambda: b"ok" in machine.replies_so_far() or b"ALARM" in machine.replies_so_far(), 60_000)
        assert b"ok" in machine.replies_so_far() and b"ALARM" not in machine.replies_so_far(), machine.replies_so_far()
        places.append(list(machine.plant.position[:2]))
        machine.send(b"G90G0X%dY%d\n" % (5 + number, 7))
        machine.settle()
        assert not machine.plant.errors, machine.plant.errors[:3]
    ranges = [max(each) - min(each) for each in zip(*places)]
    show(f"homing by stall, {chip}", f"range of {len(places)} homings: {ranges} steps of 1/{FULL}; poles slipped: {machine.plant.slipping.slips}")
    assert max(ranges) <= 2 * FULL and all(abs(each) <= 2 * FULL for place in places for each in place), places
    assert [drivers[axis].registers[0x6D] for axis in "xy"] == [0, 0], "no threshold behind it"
    assert [drivers[axis].registers[0x14] for axis in "xy"] == [0, 0]
