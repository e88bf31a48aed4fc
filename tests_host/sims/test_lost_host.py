"""A lost host in the languages that a router does not speak: the machine does as its board file asks."""

import pytest

from host_tools import boards
from host_tools.sim.machine import VirtualMachine
from passo import errors
from passo.config.boardfile import check
from passo.protocols.plotter.host import COMMANDS, packet
from passo.protocols.pulses.protocol import frame
from passo.protocols.torch import protocol as torch

LOST_MS = 400


JOBS = {
    "plotter_2014": lambda: packet(COMMANDS["LINE"], 644, 454) + packet(COMMANDS["END"]),
    "torch_manipulator": lambda: torch.move(480, 200, 0, 0),
    "two_motor_kit": lambda: b"A\x01C",
    "lpt_router": lambda: frame("stream") + b"[+60" + b"A" * 400 + frame("end"),
}


def machine_of(name, lost):
    board = boards.load(name)
    for link in board["links"]:
        link.update(lost=lost, lost_ms=LOST_MS)
    machine = VirtualMachine(board, start=(300, 300, 0)[: len(board["axes"])])
    if name == "torch_manipulator":
        machine.send(torch.frame("CONNECT"))
    machine.run_ms(50)
    return machine


@pytest.mark.parametrize("name", JOBS)
@pytest.mark.parametrize("lost", ["pause", "stop"])
def test_a_lost_host(name, lost):
    machine = machine_of(name, lost)
    machine.send(JOBS[name]())
    machine.run_ms(LOST_MS - 150)
    moving = list(machine.plant.position)
    assert machine.app.controller.state in ("run", "jog"), machine.take()
    machine.run_ms(1500)
    there = list(machine.plant.position)
    machine.run_ms(3000)
    assert moving != there == list(machine.plant.position), "it stands"
    told = [number for _, number, _ in machine.app.controller.machine.log.entries]
    if lost == "stop" and "pauses" in machine.app.controller.features:
        assert machine.app.controller.state == "alarm" and told == [errors.ALARM_HOST_LOST]
    else:
        assert machine.app.controller.state == ("hold" if lost == "pause" else "idle") and told == [errors.HOST_LOST]


def test_shipped_machines_mind_a_host_that_asks():
    """Each of them stops its spindle or beam if its host's program dies; if flash has room for a journal, it knows its place."""
    for name in boards.names():
        board = check(boards.load(name))
        cables = [link for link in board["links"] if link["protocol"] == "grbl" and link["port"] in ("usb", "uart0", "uart1", "uart2")]
        deep = any(axis["name"] == "z" for axis in board["axes"]) and not board["spindle"]["laser"]  # then the tool is drawn out of the cut
        assert {link["lost"] for link in cables} <= {"retract" if deep else "stop"}, name
        assert not cables or board["chip"] == "esp32" or board.get("journal"), name


def test_nothing_is_asked_for():
    machine = machine_of("two_motor_kit", "go_on")
    machine.send(b"A\x01C")
    machine.run_ms(3000)
    moving = list(machine.plant.position)
    machine.run_ms(1000)
    assert moving != machine.plant.position
