"""The spindle's speed by its pulses, on the virtual machine: awaited, watched, lost."""

import pytest

from host_tools import boards
from host_tools.sim.machine import VirtualMachine
from passo.config.boardfile import BoardError, check

pytestmark = pytest.mark.quick


def board(**keys):
    made = boards.load("router_3axis")
    made["inputs"] = [*made["inputs"], {"name": "turns", "pin": 22, "active": 1}]
    made["spindle"] = {"max_rpm": 12_000, "min_rpm": 0, "spin_up_ms": 0, "coolant_ms": 0, "pwm": True, "pin": 21}
    made["tachometer"] = {"input": "turns", "pulses": 2, "spin_up_ms": 2000}
    made.update(keys)
    return made


def machine(**keys):
    made = VirtualMachine(board(**keys), start=(1000, 1000, -1000), trace=None)
    made.run_ms(30)
    made.send(b"$X\n")
    made.run_ms(30)
    made.take()
    return made



def answered(made, line, limit_ms=5000):
    begun = made.now_ms()
    made.send(line)
    made.run_until(lambda: b"ok" in made.replies_so_far() or b"ALARM" in made.replies_so_far(), limit_ms)
    return made.now_ms() - begun, made.take().decode()


def test_no_cut_begins_before_the_spindle_is_at_speed():
    made = machine()
    made.send(b"M3S9000\nG91G1X5F1200\n")
    at = list(made.plant.position)
    made.run_until(lambda: made.plant.position != at, 5000)
    assert 8100 <= made.plant.spindle.rpm <= 9000
    made.settle()
    assert made.plant.position[0] > at[0] and b"ok\r\nok" in made.replies_so_far()


def test_a_new_speed_is_awaited_and_the_report_tells_it():
    made = machine()
    assert answered(made, b"M3S4000\n")[0] >= 1000 * 3600 / 20_000
    ms, said = answered(made, b"S10000\nM3\n")
    made.run_ms(700)
    assert made.plant.spindle.rpm == pytest.approx(10_000, rel=0.01)
    for _ in range(30):
        made.send(b"?")
        made.run_ms(20)
    said = made.take().decode()
    told = [int(part[4:].rstrip(">")) for line in said.splitlines() for part in line.split("|") if part.startswith("RPM:")]
    assert told and abs(told[-1] - 10_000) <= 100


def test_a_relay_turns_it_at_its_one_speed():
    spindle = {"max_rpm": 6000, "min_rpm": 0, "spin_up_ms": 0, "coolant_ms": 0}
    made = machine(spindle=spindle)
    assert "ok" in answered(made, b"M3S100\n")[1] and made.plant.spindle.rpm >= 5400


def test_one_that_does_not_reach_it_is_an_alarm():
    made = machine()
    made.plant.spindle.held = 5000
    at = list(made.plant.position)
    ms, said = answered(made, b"M3S9000\nG91G1X5F1200\n")
    assert "ALARM:44" in said and 2000 <= ms <= 2300
    made.run_ms(100)
    assert made.plant.position == at and made.plant.tool == 0
    (who,) = [entry[2] for entry in made.app.controller.machine.log.entries if entry[1] == 244]
    assert who in ("spindle at 4999 rpm", "spindle at 5000 rpm")


@pytest.mark.parametrize("fault", ["stall", "wire"])
def test_one_that_is_lost_in_a_cut_ends_it_at_a_stand(fault):
    made = machine()
    assert "ok" in answered(made, b"M3S9000\n")[1]
    made.send(b"G91G1X50F1200\n")
    made.run_ms(500)
    begun = made.now_ms()
    if fault == "stall":
        made.plant.spindle.held = 0
    else:
        made.plant.spindle.unplugged = True
    made.run_until(lambda: b"ALARM:44" in made.replies_so_far(), 3000)
    assert made.now_ms() - begun < (900 if fault == "stall" else 800)
    made.settle()
    made.run_ms(50)
    assert made.plant.tool == 0 and 1000 + made.app.controller.position()[0] == made.plant.position[0]
    made.send(b"\x18")
    made.run_ms(50)
    made.plant.spindle.held, made.plant.spindle.unplugged = 1e9, False
    made.send(b"$X\n")
    made.run_ms(50)
    made.take()
    assert "ok" in answered(made, b"M3S9000\n")[1], "a way out"


def test_what_a_board_file_may_say():
    assert check(board())["tachometer"]["at_speed_percent"] == 10
    for wrong, why in (
        ({"tachometer": {"input": "spins"}}, "no input 'spins'"),
        ({"tachometer": {"input": "door"}}, "no other use"),
        ({"tachometer": {"input": "limit_x"}}, "no other use"),
        ({"tachometer": {"input": "turns", "pulses": 100}}, "25 a turn"),
    ):
        with pytest.raises(BoardError, match=why):
            check(board(**wrong))
