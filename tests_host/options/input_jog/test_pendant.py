"""A jog pendant on the virtual machine: while a button is held the axis moves, and no longer."""

import pytest

from host_tools import boards
from host_tools.sim.machine import VirtualMachine
from passo.config.boardfile import BoardError, check, pin_claims

pytestmark = pytest.mark.quick
NAMES = ("jog_x+", "jog_x-", "jog_y+", "jog_y-", "jog_fast")


def board(**keys):
    made = boards.load("router_3axis")
    free = [pin for pin in range(29) if pin not in [pin for pin, _ in pin_claims(check(made))]]
    made["inputs"] = [*made["inputs"], *({"name": name, "pin": pin, "active": 0} for name, pin in zip(NAMES, free))]
    made["speed"] = {"unit": "steps_per_s", "default": 2000, "min": 10, "max": 4000}
    made.update(keys)
    return made


class Pendant:
    def __init__(self, homed=False, **keys):
        self.machine = made = VirtualMachine(board(**keys), start=(9000, 9000, -3000), trace=True)
        made.run_ms(30)
        made.send(b"$H\n" if homed else b"$X\n")
        made.run_until(lambda: b"ok" in made.replies_so_far(), 200_000)
        made.settle()
        self.state = made.app.controller.machine

    def hold(self, name, ms, release=True):
        made = self.machine
        made.plant.set_input(made.port.now, name, True)
        made.run_ms(ms)
        if release:
            self.release(name)

    def release(self, name):
        made = self.machine
        made.plant.set_input(made.port.now, name, False)

    @property
    def position(self):
        return self.machine.plant.position


def test_it_moves_while_the_button_is_held_and_no_longer():
    pendant = Pendant()
    at = list(pendant.position)
    pendant.hold("jog_x+", 1000)
    moved = pendant.position[0] - at[0]
    assert 1600 <= moved <= 2000, "2000 steps/s, less the ramp"
    pendant.machine.run_ms(60)
    pendant.machine.settle()
    assert pendant.position[0] - at[0] - moved <= 200, "the ramp, 20 ms of words, and the debouncing"
    assert pendant.position[1:] == at[1:] and pendant.state.state == "idle"
    assert at[0] + pendant.machine.app.controller.position()[0] == pendant.position[0]
    rows = [row for row in pendant.machine.trace.rows() if row[1] != 0]
    gaps = [b[0] - a[0] for a, b in zip(rows[50:-200], rows[51:-200])]
    assert max(gaps) < 510, "it does not come to a stand between pieces"


def test_both_at_once_and_back():
    pendant = Pendant()
    at = list(pendant.position)
    pendant.hold("jog_x+", 10, release=False)
    pendant.hold("jog_y-", 800)
    pendant.release("jog_x+")
    pendant.machine.run_ms(60)
    pendant.machine.settle()
    by = [now - then for now, then in zip(pendant.position, at)]
    assert by[0] > 1000 and -by[1] > 1000 and by[2] == 0
    pendant.hold("jog_x-", 300)
    pendant.machine.settle()
    assert pendant.position[0] < at[0] + by[0]
    at = list(pendant.position)
    pendant.machine.plant.set_input(pendant.machine.port.now, "jog_x+", True)
    pendant.hold("jog_x-", 300)
    pendant.release("jog_x+")
    pendant.machine.settle()
    assert pendant.position == at, "both ways at once: none"


def test_fast():
    pendant = Pendant()
    at = pendant.position[0]
    pendant.hold("jog_fast", 20, release=False)
    pendant.hold("jog_x+", 1000)
    pendant.machine.settle()
    assert pendant.position[0] - at > 8000


def test_it_keeps_to_the_travel_of_a_homed_machine():
    pendant = Pendant(homed=True)
    pendant.hold("jog_x-", 800)
    pendant.machine.settle()
    assert pendant.position[0] == 0 and pendant.state.alarm == 0
    pendant.hold("jog_x+", 300)
    pendant.machine.settle()
    assert pendant.position[0] > 0


def test_not_in_an_alarm_nor_beside_a_program_nor_with_the_tool_on():
    pendant = Pendant()
    made = pendant.machine
    made.send(b"G91G1X5F600\n")
    made.run_ms(100)
    at = pendant.position[1]
    pendant.hold("jog_y+", 2000, release=False)
    made.settle()
    made.run_ms(300)
    assert pendant.position[1] == at, "held since before: it has to be released first"
    pendant.release("jog_y+")
    made.run_ms(50)
    made.send(b"M3S500\n")
    made.run_ms(3000)
    pendant.hold("jog_y+", 300)
    assert pendant.position[1] == at
    made.send(b"M5\n\x18")
    made.run_ms(500)
    pendant.state.raise_alarm(201)
    pendant.hold("jog_y+", 300)
    assert pendant.position[1] == at and pendant.state.alarm


def test_a_board_file_names_them_right():
    assert check(board())
    inputs = board()["inputs"]
    for wrong in ("jog_a+", "jog_x", "jog_slow"):
        with pytest.raises(BoardError, match="a pendant's are jog_x"):
            VirtualMachine(board(inputs=[*inputs, {"name": wrong, "pin": 29, "active": 0}]))
    plotter = boards.load("plotter_2014")
    plotter["inputs"] = [*plotter["inputs"], {"name": "jog_x+", "pin": 28, "active": 0}]
    with pytest.raises(BoardError, match="speaks grbl"):
        VirtualMachine(plotter)
