"""The torch manipulator: the whole machine of its board file."""

from random import Random

import pytest

from host_tools import boards
from host_tools.sim.machine import VirtualMachine
from passo.protocols.torch import protocol as torch


@pytest.fixture
def machine():
    """The board file's machine, its motors connected, nothing on the wire."""
    made = VirtualMachine("torch_manipulator")
    made.send(torch.frame("CONNECT"))
    made.run_ms(100)
    assert made.take() == b""
    return made


def steps_of(machine, axis):
    """[(microseconds, place)] of each step of an axis, from the trace."""
    rows = machine.trace.rows()
    return [(row[0], row[1 + axis]) for before, row in zip(rows, rows[1:]) if row[1 + axis] != before[1 + axis]]


@pytest.mark.parametrize("ask_ms", [0, 37])
def test_two_axes_of_one_move(machine, ask_ms):
    """Each axis's intervals are as asked within the shortest word, their mean exactly; questions change nothing."""
    machine.send(torch.move(700, 480, 2000, -833))
    if ask_ms:
        for _ in range(30):
            machine.run_ms(ask_ms)
            machine.send(torch.frame("INFO"))
    machine.settle()
    shortest_us = machine.app.feeder.min_word_ticks * 0.08
    for axis, count, speed in ((0, 700, 480), (1, -2000, 833)):
        steps = steps_of(machine, axis)
        assert [place for _, place in steps] == list(range(1, count + 1) if count > 0 else range(-1, count - 1, -1))
        times = [us for us, _ in steps]
        for i, us in enumerate(times):
            assert abs(us - times[0] - i * 1e6 / speed) <= shortest_us + 0.16
        gaps = [after - before for before, after in zip(times, times[1:])]
        assert max(abs(gap - 1e6 / speed) for gap in gaps) <= shortest_us + 0.16
        assert abs(sum(gaps) / len(gaps) - 1e6 / speed) <= (shortest_us + 0.16) / len(gaps)
    assert machine.trace.rows()[-1][0] < 2.6e6 and not machine.plant.errors


def test_information_lies_between_the_steps_on_the_pins(machine):
    """500 questions at random moments: between what the pins had done at the question's last byte and the answer's first."""
    random = Random(5)
    base = list(machine.plant.position)
    asked = 0
    while asked < 500:
        if not machine.app.controller.busy():
            machine.run_ms(1)
            base = list(machine.plant.position)
            machine.send(torch.move(random.randrange(1, 900), random.choice((-1, 1)) * random.randrange(50, 9000),
                                    random.randrange(1, 900), random.choice((-1, 1)) * random.randrange(50, 9000)))
            machine.cycle()
        machine.port.advance(random.randrange(1, 12_500 * 25))
        before = list(machine.plant.position)
        machine.send(torch.frame("INFO"))
        while not machine.replies_so_far():
            machine.cycle()
        after = list(machine.plant.position)
        name, told = torch.answer_from(machine.take())
        assert name == "INFO"
        for axis, value in enumerate((told["x"], told["y"])):
            low, high = sorted((before[axis] - base[axis], after[axis] - base[axis]))
            assert low <= value <= high
        asked += 1


def test_a_move_sets_out_at_once(machine):
    """From the move's last byte to its first step: 5 ms at most; the original took one to two seconds."""
    latest_us = 0
    random = Random(7)
    for _ in range(40):
        machine.port.advance(random.randrange(1, 12_500 * 40))
        machine.send(torch.move(3, 480, 3, -830))
        asked_us = machine.port.now * 0.08
        known = len(machine.trace.rows())
        machine.settle()
        machine.run_ms(5)
        latest_us = max(latest_us, machine.trace.rows()[known][0] - asked_us)
    assert latest_us <= 5000


def test_halt_stops_both_axes_within_a_step(machine):
    random = Random(11)
    for _ in range(40):
        machine.send(torch.move(4000, 3000, 4000, -2500))
        machine.run_ms(5)
        machine.port.advance(random.randrange(1, 12_500 * 25))
        before = list(machine.plant.position)
        machine.send(torch.frame("STOP"))
        machine.cycle()
        machine.settle()
        after = list(machine.plant.position)
        assert all(abs(now - then) <= 1 for now, then in zip(after, before))
        assert machine.take()[:1] == b"\xdd"


def test_ramps_where_the_board_file_asks_for_them():
    board = boards.load("torch_manipulator")
    board["planning"]["independent_ramps"] = True
    for axis in board["axes"]:
        axis["accel_mm_s2"] = 50
    machine = VirtualMachine(board)
    machine.send(torch.frame("CONNECT") + torch.move(3500, 2400, 1000, -2000))
    machine.settle()
    machine.run_ms(100)
    machine.settle()
    times = [us for us, _ in steps_of(machine, 0)]
    speeds = [1e6 / (after - before) for before, after in zip(times, times[1:])]
    assert len(times) == 3500 and speeds[0] < 100 and speeds[-1] < 100
    assert abs(max(speeds) - 2400) < 80
    assert machine.app.controller.position() == [3500, -1000]
