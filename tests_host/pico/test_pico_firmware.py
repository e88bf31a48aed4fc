"""The firmware as it is flashed, on the emulated Pico: the conversation of 2014, homing, drawing, ways to the REPL,
wrong board files, a crash and a hang. Times are the chip's own."""

import copy
import math
import tempfile
from pathlib import Path

import pytest
from emulated import make_machine, uf2  # noqa: F401

from host_tools import boards
from host_tools.build.constants import fold_constants
from host_tools.build.mpy import in_place
from host_tools.build.tree import FIRMWARE, compile_module, select_modules
from host_tools.emulator.machine import firmware_files, files_of
from host_tools.emulator.pico import EmulatedPico
from host_tools.sim.machine import VirtualMachine
from passo.protocols.plotter.host import COMMANDS, packet, status_from
from test_virtual_machine import LOG_2014

BOARD = "plotter_2014"
HELLO = packet(COMMANDS["REQUEST"])
UP_LIMIT_MS = 3000
POLL_MS = 50
START = (20, 15)
SPEED = 200


def until_up(machine):
    """Milliseconds from now to the first answer."""
    begun = machine.now_ms()
    machine.take()
    while machine.now_ms() < begun + UP_LIMIT_MS:
        machine.send(HELLO)
        machine.run_ms(POLL_MS)
        if machine.take().startswith(b"k"):
            return machine.now_ms() - begun
    machine.pico.console.send(b"\r")
    machine.run_ms(POLL_MS)
    raise AssertionError(f"no answer within {UP_LIMIT_MS} ms: {machine.pico.console.take_output().decode()}")


def said(pico, limit_us=2_000_000):
    """Return the REPL's text, once its prompt is there."""
    pico.console.send(b"\r")
    return pico.console.expect(b">>> ", limit_us).decode()


def told(machine):
    """Interrupt the program and return its output."""
    machine.pico.console.send(b"\r\x03\x03")
    return machine.pico.console.expect(b">>> ").decode()


def turned_square(degrees, side, x, y):
    """Corners of a square turned about its first corner, closed."""
    turn = math.radians(degrees)
    corners = [(0, 0), (side, 0), (side, side), (0, side), (0, 0)]
    return [
        (round(x + a * math.cos(turn) - b * math.sin(turn)), round(y + a * math.sin(turn) + b * math.cos(turn)))
        for a, b in corners
    ]


def converse(machine):
    """The conversation of 2014, then the square turned by 30°: milliseconds from END to DONE of the first, microseconds
    from its first step to its last, and the rows of the trace after homing, without times."""
    for question, answer in LOG_2014[:2]:
        assert machine.ask(bytes.fromhex(question)) == answer, question
    homed = len(machine.trace.rows())
    for question, answer in LOG_2014[2:-1]:
        assert machine.ask(bytes.fromhex(question)) == answer, question
    begun = machine.now_ms()
    assert machine.ask(bytes.fromhex(LOG_2014[-1][0])) == b"d"
    took_ms = machine.now_ms() - begun
    steps = [row[0] for before, row in zip(machine.trace.rows()[homed:], machine.trace.rows()[homed + 1 :])
             if before[1:3] != row[1:3]]
    assert machine.ask(packet(COMMANDS["SPEED"], SPEED)) == b"s"
    for index, (x, y) in enumerate(turned_square(30, 60, 600, 300)):
        assert machine.ask(packet(COMMANDS["LINE" if index else "MOVE"], x, y)) == b"n"
    assert machine.ask(packet(COMMANDS["END"])) == b"d"
    machine.run_ms(100)
    return took_ms, steps[-1] - steps[0], [row[1:] for row in machine.trace.rows()[homed:]]


def test_conversation_homing_and_squares_are_those_of_the_virtual_board(make_machine, show):
    machine = make_machine(BOARD, start=START)
    up_ms = until_up(machine)
    machine.run_ms(2200)  # a question that was torn by the start of the serial line is dropped by now
    machine.ask(packet(COMMANDS["STATUS"]), 12)  # clears what it has left behind
    took_ms, drawing_us, path = converse(machine)
    on_virtual_ms, expected_us, expected = converse(VirtualMachine(BOARD, start=START))
    assert path == expected
    assert abs(drawing_us - expected_us) < 1
    assert 0 <= took_ms - on_virtual_ms < 20  # the path's time is exact; the rest is the chip's, in bytecode
    status = status_from(machine.ask(packet(COMMANDS["STATUS"]), 12))
    assert (status["state"], status["error"], status["x"], status["y"]) == ("idle", 0, 600, 300)
    assert machine.plant.errors == [] and machine.wire().overruns == 0
    show(
        "the conversation of 2014 on the Pico",
        f"first answer {up_ms:.0f} ms after USB is up; the square took {took_ms / 1000:.3f} s"
        f" ({took_ms - on_virtual_ms:.1f} ms more than on the virtual board);"
        f" {machine.now_ms() / 1000:.1f} s emulated in all",
    )


# --- ways to the REPL


@pytest.mark.slow
def test_escape_hatches(uf2):
    pico = EmulatedPico(files=firmware_files(BOARD), uf2=uf2)
    pico.hold_bootsel(True)
    pico.boot()
    assert "BOOTSEL" in said(pico)
    assert pico.exec("print(2 + 2)") == "4\r\n"
    pico.hold_bootsel(False)
    pico.hard_reset()
    pico.run(900_000)
    assert pico.exec("print(2 + 2)") == "4\r\n", "Ctrl-C in the grace period"
    pico.hard_reset()
    pico.run(3_000_000)
    assert pico.exec("print(2 + 2)") == "4\r\n", "Ctrl-C later, where no link is on USB"
    pico.run(1_100_000)
    assert pico.exec("import machine\nprint(machine.reset_cause())") == "1\r\n", "the watchdog is off"


# --- what goes wrong


def slow(*values):
    return pytest.param(*values, marks=pytest.mark.slow)


def broken(change):
    board = copy.deepcopy(boards.load(BOARD))
    change(board)
    return f"BOARD = {board!r}\n".encode()


@pytest.mark.parametrize(
    "text, wanted",
    [
        slow(broken(lambda board: board["axes"][0]["pins"].pop()), "axis x: a unipolar drive has 4 pins, not 3"),
        slow(broken(lambda board: board["tool"].update(pin=14)), "pin 14 is claimed by"),
        slow(broken(lambda board: board.update(color=1)), "unknown key 'color'"),
        (broken(lambda board: board["tool"].update(pin=20)), "PIO pins not consecutive"),
        (b"BOARD = {\n", "board.py cannot be read: SyntaxError"),
    ],
)
def test_a_wrong_board_file_gives_one_line(uf2, text, wanted):
    files = dict(firmware_files(BOARD))
    files["board.py"] = text
    pico = EmulatedPico(files=files, uf2=uf2)
    driven = [pico.record_edges(gpio) for gpio in range(2, 10)]
    pico.boot()
    lines = [line for line in said(pico).splitlines() if "board.py" in line]
    assert len(lines) == 1 and wanted in lines[0]
    assert not any(state == 1 for edges in driven for _, state in edges), "no coil is ever on"


def with_fault(module, after, inserted, board=BOARD):
    """The firmware's files with lines put into a module."""
    texts = {path.as_posix(): (FIRMWARE / path).read_text() for path in select_modules(board if isinstance(board, dict) else boards.load(board))}
    assert texts[module].count(after) == 1
    texts[module] = texts[module].replace(after, after + inserted)
    files = dict(files_of(board) if isinstance(board, dict) else firmware_files(board))
    with tempfile.TemporaryDirectory() as folder:
        changed, target = Path(folder) / "changed.py", Path(folder) / "changed.mpy"
        changed.write_text(fold_constants(texts)[module])
        compile_module(changed, target, "armv6m", module)
        files[str(Path(module).with_suffix(".mpy"))] = in_place(target.read_bytes())
    return files


TURN = '        """The end of a cycle."""\n'  # of App.rest()
JOG = packet(COMMANDS["RIGHT"])


@pytest.mark.slow
def test_a_crash_while_it_moves_leaves_safe_outputs_and_a_report(make_machine):
    fault = "        if self.controller.state == 'jog':\n            raise ValueError('on purpose')\n"
    machine = make_machine(BOARD, with_fault("passo/app.py", TURN, fault), start=START)
    until_up(machine)
    machine.send(JOG)
    machine.run_ms(300)
    assert "ValueError: on purpose" in said(machine.pico)
    assert machine.plant.decoder_of(0).released and machine.plant.decoder_of(1).released and machine.plant.tool == 0
    assert b"ValueError: on purpose" in machine.pico.files()["crash.txt"]
    machine.pico.hard_reset()
    machine.run_ms(900)
    assert "the last run ended by" in told(machine) and "last_crash.txt" in machine.pico.files()


@pytest.mark.slow
def test_a_hang_ends_in_the_watchdog(make_machine):
    fault = "        while self.controller.state == 'jog':\n            pass\n"
    machine = make_machine(BOARD, with_fault("passo/app.py", TURN, fault), start=START)
    until_up(machine)
    machine.run_ms(2200)
    machine.send(JOG)
    begun = machine.now_ms()
    machine.pico.await_reset(3_000_000)
    assert 900 < machine.now_ms() - begun < 1400
    assert machine.plant.tool == 0 and machine.plant.decoder_of(0).released
    machine.run_ms(900)
    assert "by the watchdog" in told(machine)
