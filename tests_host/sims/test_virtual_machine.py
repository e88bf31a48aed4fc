"""The whole machine in memory, on which the tests of everything else stand."""

import pytest

from host_tools.sim.machine import VirtualMachine

LOG_2014 = [
    ("72 00 00 00 00 72", b"k"),
    ("6f 00 00 00 00 6f", b"o"),
    ("73 03 e8 00 00 5e", b"s"),
    ("6d 02 84 01 3a 2e", b"n"),
    ("6c 02 84 01 c6 b9", b"n"),
    ("6c 03 74 01 c6 aa", b"n"),
    ("6c 03 74 01 3a 1e", b"n"),
    ("6c 02 84 01 3a 2d", b"n"),
    ("65 00 00 00 00 65", b"d"),
]
HOME = bytes.fromhex(LOG_2014[1][0])


def play(machine):
    for packet, answer in LOG_2014:
        assert machine.ask(bytes.fromhex(packet)) == answer, packet
    machine.settle()


def test_the_log_of_2014():
    machine = VirtualMachine(start=(700, 500))
    play(machine)
    assert machine.replies_so_far() == b"" and machine.app.controller.machine.homed
    assert machine.plant.position == [644, 314] and machine.plant.tool == 0
    assert machine.plant.errors == []
    pen_down = [row[1:3] for row in machine.trace.rows() if row[5]]
    assert {(x, y) for x, y in pen_down if x in (644, 884) and y in (314, 454)} == {
        (644, 314), (644, 454), (884, 454), (884, 314)
    }  # fmt: skip


def test_the_same_options_give_the_same_run():
    runs = []
    for _ in range(2):
        machine = VirtualMachine(bounce_ms=4, seed=9)
        play(machine)
        runs.append(machine.trace.rows())
    assert runs[0] == runs[1]


@pytest.mark.parametrize("start", [(-140, -140), (-40, -41), (4100, 3100), (-39, 0)])
def test_homing_from_the_corners_with_bounce(start):
    machine = VirtualMachine(start=start, bounce_ms=4, seed=3)
    assert machine.ask(HOME) == b"o"
    assert all(-1 <= place <= 1 for place in machine.plant.position)
    assert machine.plant.errors == []


def test_a_dead_barrier_ends_in_the_safe_state():
    machine = VirtualMachine(start=(300, 300), faults={"barrier_x": "dead"})
    machine.send(HOME)
    machine.run_until(lambda: machine.app.controller.state == "alarm", 120_000)
    machine.settle()
    assert machine.plant.tool == 0 and machine.plant.decoder_of(0).released and machine.plant.decoder_of(1).released
    assert machine.plant.carriages[0].lost > 0, "the hard end held it"


def test_helpers():
    machine = VirtualMachine()
    with pytest.raises(TimeoutError, match="not within 50 virtual ms; state idle"):
        machine.run_until(lambda: False, 50)
    before = machine.now_ms()
    machine.run_ms(30)
    assert 30 <= machine.now_ms() - before <= 31
    machine.flush()
    machine.close()


def test_closing_in_the_middle_of_a_line_leaves_pen_and_motors_off():
    machine = VirtualMachine(start=(0, 0))
    machine.ask(bytes.fromhex("6c 03 74 01 3a 1e"))
    machine.send(bytes.fromhex(LOG_2014[-1][0]))
    machine.run_ms(400)
    assert machine.plant.tool == 1000 and machine.app.player.busy()
    machine.close()
    assert machine.plant.tool == 0 and machine.plant.decoder_of(0).released
    assert machine.app.player.levels() == 0
