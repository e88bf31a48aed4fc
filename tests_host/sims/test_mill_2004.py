"""The mill's board file on the plant: the selector, homing and probing beside the interlock, one switch or two, and its log."""

import pytest

from host_tools import boards
from host_tools.cli.log import log_line_text
from host_tools.sim.machine import VirtualMachine

pytestmark = pytest.mark.quick


def mill(start=(3000, 2500, -1800), **changes):
    board = boards.load("mill_2004")
    board.update(changes)
    machine = VirtualMachine(board, start=start, trace=None)
    machine.run_ms(30)
    machine.take()
    return machine


def say(machine, text, ms=30):
    machine.take()
    machine.send(text)
    machine.run_ms(ms)
    machine.settle()
    return machine.take().decode()


def press(machine, name, active=True, ms=40):
    machine.plant.set_input(machine.port.now, name, active)
    machine.run_ms(ms)


def outputs(machine):
    """{name: level} from now on."""
    levels = {}
    switch = machine.plant.output

    def output(tick, name, level):
        levels[name] = level
        switch(tick, name, level)

    machine.plant.output = output
    return levels


def test_homing_comes_up_to_its_switches_and_all_others_still_count():
    machine = mill()
    assert "ok" in say(machine, b"$H\n") and machine.plant.position == [0, 0, 0]
    machine.run_ms(5)
    assert machine.port.veto.exempt == 0
    machine.send(b"$H\n")
    machine.run_ms(300)
    assert machine.app.controller.state == "home" and machine.port.veto.exempt
    press(machine, "dz", False)
    assert "ALARM:20" in machine.take().decode() and machine.app.controller.machine.log.entries[-1][2] == "dz"
    position = list(machine.plant.position)
    machine.run_ms(300)
    assert machine.plant.position == position


def test_home_and_limit_on_two_switches():
    board = boards.load("mill_2004")
    home = {"name": "home_x", "pin": 29, "active": 1, "pull": "up"}
    homing = {**board["homing"], "sensors": {**board["homing"]["sensors"], "x": "home_x"}}
    machine = mill(inputs=[*board["inputs"], home], homing=homing)
    assert "ok" in say(machine, b"$H\n") and machine.plant.position == [0, 0, 0]
    say(machine, b"$20=0\n")
    said = say(machine, b"G91G1X-9F2400\n", 200)
    home, limit = machine.plant.barriers["home_x"], machine.plant.barriers["bxa"]
    assert "ALARM:1" in said and limit.last - 2 <= machine.plant.position[0] <= limit.last < home.last


def test_the_probe_may_touch_and_then_keeps_z_from_going_down():
    machine = mill()
    say(machine, b"$X\n")
    machine.send(b"G91\nG38.2Z-5F300\n")
    machine.run_ms(300)
    at = machine.plant.position[2]
    press(machine, "probe")
    machine.settle()
    assert "PRB" in machine.take().decode() and at - 60 < machine.plant.position[2] <= at
    assert "error:131" in say(machine, b"G1Z-0.1F300\n")
    assert "error:131" in say(machine, b"$J=G91Z-0.1F300\n")
    assert "error" not in say(machine, b"G1Z1X1F300\n")
    press(machine, "probe", False)
    assert "error" not in say(machine, b"G1Z-1X-1F300\n")
    machine.send(b"G1Z-1F300\n")
    machine.run_ms(60)
    press(machine, "probe")
    assert "ALARM:20" in machine.take().decode(), "not while probing: the tool runs into something"


def test_the_selector_at_the_parallel_port():
    """No step of this board, the vacuum off; the drives are enabled by themselves once all has been at rest for 500 ms."""
    machine = mill()
    levels = outputs(machine)
    say(machine, b"$X\n")
    press(machine, "sel", False)
    assert "error:131" in say(machine, b"G91G1X1F900\n")
    assert not levels.get("enable")
    machine.run_ms(300)
    press(machine, "bxa", ms=100)
    press(machine, "bxa", False, ms=300)
    assert not levels.get("enable"), "inputs have not been at rest for long enough"
    machine.run_ms(400)
    assert levels["enable"] == 1 and machine.plant.tool == 0
    press(machine, "stop", ms=0)
    assert levels["enable"] == 0, "at once"
    machine.run_ms(30)
    press(machine, "stop", False, ms=1000)
    assert levels["enable"] == 0, "not in an alarm"
    machine.send(b"\x18")
    machine.run_ms(30)
    say(machine, b"$X\n")
    machine.run_ms(700)
    assert levels["enable"] == 1
    press(machine, "sel", ms=0)
    machine.run_ms(2)
    machine.run_ms(40)
    assert levels["enable"] == 0, "this board does not ask for it"
    assert "error" not in say(machine, b"G91G1X1F900\n") and levels["enable"] == 1


def test_the_selector_enables_nothing_unless_the_board_file_says_so():
    board = boards.load("mill_2004")
    machine = mill(interlock={**board["interlock"], "unasked_ms": 0})
    levels = outputs(machine)
    press(machine, "sel", False, ms=3000)
    assert not levels.get("enable")


def test_a_drive_fault_stops_both_motors_of_the_gantry_and_is_named():
    for name in ("dx1", "dx2"):
        machine = mill()
        say(machine, b"$X\n")
        machine.send(b"G91\nG1X20F2400\n")
        machine.run_ms(200)
        press(machine, name, False, ms=0)
        machine.run_ms(10)
        at = machine.plant.position[0]
        machine.run_ms(300)
        assert machine.plant.position[0] == at and "ALARM:20" in machine.take().decode()
        assert machine.app.controller.machine.log.entries[-1][1:] == (220, name)
        assert machine.app.controller.position()[0] == at - 3000, "the position stays exact"


def test_lines_wait_for_what_is_queued_before_they_are_refused():
    """Off the limit and back: when the second line is looked at, the first is still under way."""
    machine = mill(start=(-170, 2500, -1800))
    say(machine, b"$X\nG91\n")
    assert "error:131" in say(machine, b"G1X-0.1F900\n")
    assert "error" not in say(machine, b"G1X2F900\nG1X-1F900\nG2X1Y0I0.5J0\n")
    assert machine.plant.position[0] == -170 + 160
    assert machine.app.controller.machine.alarm == 0


def test_arcs_want_both_directions_of_their_plane():
    machine = mill(start=(-170, 2500, -1800))
    say(machine, b"$X\nG91\n")
    assert "error:131" in say(machine, b"G2X1Y0I0.5J0F900\n")
    assert machine.plant.position[0] == -170


def test_the_log_as_people_read_it():
    machine = mill()
    say(machine, b"$X\n")
    machine.plant.inject_noise("bxb", [machine.port.now + 100, machine.port.now + 200])
    machine.run_ms(10)
    machine.send(b"G91\nG1X-60F2400\n")
    machine.run_ms(2000)
    machine.settle()
    lines = [log_line_text(line) for line in say(machine, b"$LOG\n").splitlines()]
    text = "\n".join(line for line in lines if line)
    assert "bxa        201  a limit switch or the emergency stop was hit" in text
    assert "input bxa: active, stopped the machine 1 times, 0 glitches; last became active at" in text and "and still is" in text
    assert "input bxb: inactive, stopped the machine 0 times, 1 glitches" in text
