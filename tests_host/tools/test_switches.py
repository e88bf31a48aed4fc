"""Each output of each board file can be switched by a documented command, and does; an output that nothing switches is a caution."""

import copy
import subprocess

import pytest
from passo import commands
from passo.app import App
from passo.commands import Command
from passo.config.boardfile import check
from passo.config.journal import MemorySlots
from passo.ports.virtual import Nothing, VirtualPort

from host_tools import boards, interpreter, switches

OF_GCODE = {"flood": "M8", "mist": "M7", "reverse": "M4 S100", "vacuum": "M10", "clamp": "M10"}
# At rest, what no interlock forbids: the mill's drives are good, and its selector is at this board.
ACTIVE = ("dx1", "dx2", "dy", "dz", "sel")


class Pins(Nothing):
    """Outputs as they are; inputs at rest."""

    def __init__(self, board):
        self.inputs = {item["name"]: item["active"] ^ (item["name"] not in ACTIVE) for item in board["inputs"]}
        self.outputs = {}

    def input(self, tick, name):
        return self.inputs[name]

    def encoder(self, number):
        return 0

    def output(self, tick, name, level):
        self.outputs[name] = level


def changed_by(app, port, world, do):
    """Names of the outputs that `do()` switches on, or off."""
    before = dict(world.outputs)
    do()
    for _ in range(3000):
        app.cycle()
        if app.controller.queue.still() and not app.controller.machine.command and not app.controller.machine.events:
            port.advance(12_500_000 // 50)
    return {name for name, level in world.outputs.items() if before.get(name) != level}


@pytest.mark.parametrize("name", boards.names())
def test_each_output_is_switched_by_its_command(name):
    board = check(boards.load(name))
    if not board["outputs"]:
        return
    assert switches.outputs_without_switch(board) == []
    absent = {key: None for key in ("inverter", "drivers", "spi_drivers", "network")}  # these wait for hardware that is not there
    links = [{"name": "pc", "port": "usb", "protocol": board["links"][0]["protocol"]}]
    board = check({key: value for key, value in {**boards.load(name), **absent, "links": links, "commands": ""}.items() if value is not None})
    world = Pins(board)
    port = VirtualPort(board, world)
    app = App(board, port, None, MemorySlots())
    controller, line = app.controller, port.lines[board["links"][0]["name"]]
    controller.machine.alarm = 0
    motors = controller.machine.motors
    powered = changed_by(app, port, world, lambda: motors.drives(True)) | changed_by(app, port, world, motors.release)
    for item in board["outputs"]:
        output = item["name"]
        if item["role"] != "none":
            kind, value = commands.CONNECT, 1
            found = changed_by(app, port, world, lambda: controller.accept(Command(kind, value=value)))
        elif output.startswith("enable"):
            found = powered
        else:
            code = OF_GCODE[output]
            found = changed_by(app, port, world, lambda text=code: setattr(line, "incoming", line.incoming + f"{text}\n".encode()))
            assert world.outputs[output] == item["active"], (output, line.outgoing)
        assert output in found or item["role"] != "none" and world.outputs[output] == item["active"], output


def changed(**outputs):
    board = copy.deepcopy(boards.load("router_3axis"))
    board["outputs"] = [{"name": name, "pin": pin} for name, pin in outputs.items()]
    return board


@pytest.mark.parametrize(
    "names, free",
    [
        (("enable", "flood", "p0", "clamp", "p1_vacuum"), []), (("vacuum", "clamp"), ["vacuum"]), (("fan", "p0_fan", "p10"), ["fan", "p0_fan", "p10"]),
        (("vacuum", "mist", "enable_x"), []),
    ],
)
def test_what_nothing_switches(names, free):
    board = changed(**{name: 17 + count for count, name in enumerate(names)})
    check(copy.deepcopy(board))
    assert switches.outputs_without_switch(board) == free
    for protocol in ("plotter", "pulses", "torch", "keys"):
        plotter = {**board, "links": [{"name": "pc", "port": "usb", "protocol": protocol}]}
        assert switches.outputs_without_switch(plotter) == [name for name in names if not name.startswith("enable")]


def test_the_caution_is_said_and_the_board_starts(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(f"BOARD = {changed(fan=17)!r}\n")
    done = subprocess.run([*interpreter.passo(), "wiring", str(file)], capture_output=True, text=True, timeout=120, check=True)
    assert "nothing switches the output fan" in done.stderr and "fan" in done.stdout
