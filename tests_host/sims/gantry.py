"""A router whose X has a motor at each side, on the virtual port, with encoders."""

import re

from host_tools import boards
from host_tools.sim.machine import VirtualMachine

START = (30_000, 20_000, -20_000)
WAIT, LIMIT = 4, 20
PINS = {"limit_x": 0, "limit_y": 1, "limit_z": 11, "probe": 12, "door": 13, "stop": 27}


def board(encoders=("x", "x2", "y"), correct=True, **changes):
    board = boards.load("router_3axis")
    board["links"] = board["links"][:1]
    board["inputs"] = [dict(item, pin=PINS[item["name"]]) for item in board["inputs"] if item["name"] in PINS]
    board["inputs"].append({"name": "limit_x2", "pin": 26, "active": 1, "pull": "up"})
    for axis, step in zip(board["axes"], (2, 3, 4)):
        axis["pins"] = [step, step + 4]
    board["tool"] = {"pin": 10}
    board["gantry"] = {
        "axis": "x", "pins": [5, 9], "opposite": True, "sensor": "limit_x2", "wait_steps": WAIT, "limit_steps": LIMIT, **changes,
    }  # fmt: skip
    board["encoders"] = [
        {"motor": motor, "pins": [pin, pin + 1], "pulses": 500, "steps": 400, "limit_steps": 60, "correct": correct}
        for motor, pin in zip(encoders, (18, 20, 22))
    ]
    return board


class Router:
    """`board` as above."""

    def __init__(self, board, unlock=True, **options):
        self.machine = VirtualMachine(board, **{"start": START, "trace": None, **options})
        self.plant = self.machine.plant
        self.controller = self.machine.app.controller
        if unlock:
            self.ask("$X")
        self.ask("G91")

    def ask(self, line):
        self.machine.take()
        self.machine.send(line.encode() + b"\n")
        self.machine.run_until(lambda: re.search(rb"^(ok|error:\d+)\r\n\Z", self.machine.replies_so_far(), re.M), 600_000)
        return self.machine.take().decode()

    def go(self, line):
        """Run a line to the end of its motion and of the checks of encoders and motors; return the board's lines."""
        said = self.ask(line)
        self.machine.settle()
        self.machine.run_ms(150)
        self.machine.settle()
        return said + self.machine.take().decode()

    def off(self):
        """Steps that the machine is off by: where the carriages are, less where it says they are."""
        return [at - start - said for at, start, said in zip(self.plant.position, START, self.controller.position())]

    def noted(self, number):
        return [who for _, noted, who in self.controller.machine.log.entries if noted == number]
