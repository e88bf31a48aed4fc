"""The author's first test of 2004, on every shipped board: each input pressed, stuck, broken and bouncing, by --fault, and told by its name."""

import re

import pytest

from host_tools import boards
from host_tools.page.grbl_machine import GrblMachine
from host_tools.sim.machine import VirtualMachine

# Inputs that only a command, or only the start, reads: {name: the effect that shows them}.
BY_COMMAND = {"repl": "MicroPython's prompt at the start", "jog_fast": "the speed of the other jog inputs"}
MILLS = ("mill_2004", "mill_pico_2")
PRESSED = [(name, item["name"]) for name in MILLS for item in boards.load(name)["inputs"]]


def mill(name, **faults):
    board = boards.load(name)
    machine = VirtualMachine(board, start=(3000, 2500, -1800), trace=None, faults=faults)
    machine.run_ms(60)
    return machine


def status(machine):
    """All words of the reports, the newest of each."""
    machine.take()
    words = {}
    for _ in range(45):
        machine.send(b"?")
        machine.run_ms(3)
    for report in re.findall(rb"<(.*?)>", machine.take()):
        fields = report.decode().split("|")
        words.update(field.partition(":")[::2] for field in fields[1:])
        if any(field.startswith("Ov:") for field in fields) and not any(field.startswith("Fb:") for field in fields):
            words.pop("Fb", None)
    return words


def shown_of(board, name):
    ends = {sensor: end for end, sensor in board["interlock"]["limits"].items()}
    return f"{name}({ends[name]})" if name in ends else name


@pytest.mark.parametrize("name, pressed", PRESSED)
def test_each_input_of_the_mill_is_named_while_it_forbids(name, pressed):
    """Pressed from 100 ms on; drives and selector are good while they are active. At rest the report has no name."""
    board = boards.load(name)
    good = pressed in ("dx1", "dx2", "dy", "dz", "sel")
    machine = mill(name, **{pressed: ("dead" if good else "pressed") + "@100-700"})
    machine.run_ms(max(0, 160 - machine.port.now // 12_500))
    assert status(machine)["Fb"] == shown_of(board, pressed)
    while machine.port.now < 800 * 12_500:
        machine.run_ms(20)
    assert "Fb" not in status(machine), "released"


@pytest.mark.parametrize("name", MILLS)
def test_a_broken_wire_is_told_as_the_board_file_says(name):
    """A limit reads as hit, a drive as faulty."""
    for wire in ("bxa", "bzb", "dx2", "dy", "stop"):
        machine = mill(name, **{wire: "broken@70"})
        machine.run_ms(100)
        assert status(machine)["Fb"] == shown_of(boards.load(name), wire), wire


def test_an_input_that_bounces_is_counted_and_stops_nothing():
    """Glitches shorter than the filter's time, at rest."""
    for wire in ("bxa", "dz"):
        machine = mill("mill_2004", **{wire: "bounces@100"})
        machine.run_ms(200)
        assert "Fb" not in status(machine) and machine.app.controller.machine.alarm in (0, 200, 211), wire


@pytest.mark.parametrize("name", [name for name in boards.names() if boards.load(name).get("inputs")])
def test_each_input_is_told_by_name(name):
    """Pressed at rest, it is in a report, in the log, or a command's: no input of a shipped board is silent."""
    from passo.config.board_error import inputs_of
    from passo.config.boardfile import check

    board = check(boards.load(name))
    named = {row[0] for row in inputs_of(board)} | set((board["homing"] or {"sensors": {}})["sensors"].values())
    named |= {motor["sensor"] for motor in getattr(board.get("additions"), "more_motors", ())}
    for item in board["inputs"]:
        told = item["name"] in named | set(BY_COMMAND) or item["halt"] or re.fullmatch(r"limit_[xyza]|p\d|jog_[xyza][+-]", item["name"])
        told = told or board.get("interlock") or item["name"] in str([board.get(key) for key in ("tachometer", "drivers", "spi_drivers", "network", "journal", "jobs", "encoders")])
        assert told, f"{item['name']} is in no report, message or setting"


def test_an_input_stays_on_the_page_until_a_report_without_it():
    """Only reports with overrides, every tenth at rest, name the inputs that forbid: the lamp stays lit in between."""
    page, shown = GrblMachine(lambda data: None, lambda event: None), []
    for words in ("Ov:100,100,100|Fb:dx2,bxb(x+)", "Pn:X", "WCO:0,0,0", "Ov:100,100,100", "Pn:X"):
        page.wire.feed(f"<Alarm|MPos:0.000,0.000,0.000|FS:0,0|{words}>\r\n".encode(), 0)
        shown.append(page.state["more"])
    assert shown == 3 * [[["Fb", "dx2,bxb(x+)"]]] + 2 * [[]]
