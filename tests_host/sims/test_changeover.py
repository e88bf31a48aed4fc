"""The torch manipulator's relays, whatever language asks for motion: the machine of the plant moves only where they are
closed, and reports steps that come while they are not."""

import pytest

from host_tools import boards
from host_tools.sim.machine import VirtualMachine
from passo import errors
from passo.protocols.torch import protocol as torch
from passo.protocols.plotter.host import COMMANDS, packet

MOTION = {
    "grbl": (b"$X\n", b"G91 G1 X5 Y3 F600\n", b"G0 X1\nG0 X2\n", b"$J=G91 X5 F600\n", b"G2 X4 I2 F600\n"),
    "torch": (torch.move(100, 480, 50, -480), torch.frame("JOG_X+")),
    "pulses": (b"{jog x 100}", 30 * b"A", b"{stream 3}AAA", b"{load 3}AAA{end}{run}"),
    "keys": (b"I", b"C"),
    "plotter": tuple(packet(COMMANDS[name], 50, 50) for name in ("MOVE", "END", "UP")),
}


def machine_of(language, **changes):
    board = {**boards.load("torch_manipulator"), "step_program": {}, **changes}
    link = {"port": "usb", "baud": 115_200}
    links = [{"name": "other", "protocol": "torch", **link}, {"name": "pc", "protocol": language, "port": "uart0"}]
    machine = VirtualMachine({**board, "links": links, "commands": "pc"})
    machine.run_ms(100)
    return machine


def moved(machine, data):
    """How far the plant's axes have gone by `data`, and the numbers that were logged meanwhile."""
    before = list(machine.plant.position)
    log = machine.app.controller.machine.log
    seen = dict(log.counts)
    machine.send(data, "pc")
    machine.run_ms(1500)
    assert not machine.plant.errors
    numbers = {number for number, count in log.counts.items() if count != seen.get(number)}
    return [after - at for at, after in zip(before, machine.plant.position)], numbers


@pytest.mark.parametrize("language", sorted(MOTION))
def test_motion_is_refused_until_the_motors_are_connected(language):
    """Before CONNECT and after DISCONNECT: a number in the log, nothing moves and no position is counted."""
    machine = machine_of(language)
    controller = machine.app.controller
    for motors in (None, "CONNECT", "DISCONNECT"):
        if motors:
            machine.send(torch.passo(torch.LINK_OF), "other")
            machine.run_ms(20)
            machine.send(torch.frame(motors), "other")
            machine.run_ms(100)
            machine.send(torch.passo(torch.LINK_OF, 2), "other")
            machine.run_ms(20)
        place = controller.position()
        if motors != "CONNECT":
            for data in MOTION[language]:
                by, numbers = moved(machine, data)
                assert by == [0, 0] and controller.position() == place
                assert data == b"$X\n" or errors.NO_MOTORS in numbers
        else:
            steps = [moved(machine, data)[0] for data in MOTION[language]]
            assert any(step != [0, 0] for step in steps)
            machine.send({"keys": b"J", "grbl": b"!\x18$X\n"}.get(language, b""), "pc")
            machine.run_ms(100)
            machine.settle()


def test_words_for_the_motors():
    """G-code and pulse files have words of their own; a refusal has its reason."""
    machine = machine_of("grbl")
    machine.send(b"$X\nG91 G1 X5 Y3 F600\n", "pc")
    machine.run_ms(100)
    machine.take("pc")
    for asked, answers in (
        (b"$MOTORS=1\n", b"ok\r\n"), (b"G91 G1 X5 Y3 F600\n", b"ok\r\n"), (b"$MOTORS=2\n", b"error:3\r\n"),
    ):  # fmt: skip
        machine.send(asked, "pc")
        machine.run_ms(1200)
        assert machine.take("pc").endswith(answers)
    assert machine.app.controller.position() == [240, 249] and not machine.plant.errors
    machine.send(b"$MOTORS=0\nG1X1\n", "pc")
    machine.run_ms(200)
    assert machine.take("pc") == b"ok\r\nerror:117\r\n"
    machine = machine_of("pulses")
    machine.take("pc")
    machine.send(b"{jog x 5}{motors on}{jog x 5}{motors off}", "pc")
    machine.run_ms(300)
    assert machine.take("pc") == b"error:117\nok\nok\nerror:8\n"


@pytest.mark.parametrize("language", sorted(MOTION))
def test_the_first_motion_takes_the_motors_where_the_board_file_says_so(language):
    """Break before make: no step comes before the relays have closed and the time for it has passed once more."""
    machine = machine_of(language, changeover_by="motion")
    assert not machine.app.controller.machine.motors.detached
    steps = [moved(machine, data)[0] for data in MOTION[language]]
    assert any(step != [0, 0] for step in steps)
    controller = machine.app.controller
    controller.machine.raise_alarm(errors.ALARM_HARD_LIMIT, "test")
    machine.run_ms(50)
    position = list(machine.plant.position)
    machine.run_ms(500)
    assert machine.plant.position == position and not machine.plant.errors
