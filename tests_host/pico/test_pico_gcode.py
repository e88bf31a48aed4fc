"""G-code on the emulated Pico, from bytes to steps: the rates of `make bench ARGS=gcode` must not collapse."""

import contextlib
import io
import re
from pathlib import Path

import pytest
from cam_files import FREECAD as CAM
from emulated import uf2  # noqa: F401

from host_tools.emulator import gcode
from host_tools.emulator.machine import EmulatedMachine
from host_tools.emulator.pico import EmulatedPico
from passo import records
from passo.protocols.gcode import parse_records, parse_viper
from test_pico_digest import compiled

FREE_BYTES = 12_000  # with the larger ring of the faster axes, and the memory that the lines come from
LINES_S = 450
LINK = "serial"
ANSWER = re.compile(rb"(^|\n)(ok|error:\d+)\r\n")
FLOOD = 450
LINE_END = re.compile(rb"(ok|error:\d+)\r\n")
DOTS_S = 350
# Quarters of 0.5 and 1 mm radius, between lines and next to each other.
TIGHT = ["G21G91F600", "G1X0.3", "G3X0.5Y0.5J0.5", "G1Y0.3", "G2X0.5Y0.5I0.5", "G2X1Y-1J-1", "G3X1Y1J1", "G1X0.3"]
END_STEPS = [1152, 416, 0]  # 3.6 mm, 1.3 mm
# From rest and back to it, long and short, with corners of all kinds; back to where it began.
GENTLE = ["G21G91F3000", "G1X1", "Y0.6", "X0.2Y0.1", "X0.2", "X0.2Y-0.1", "X-1.6Y-0.6"]
JERK = 5000  # mm/s³
FIRST_STEPS = 16  # 0.05 mm: (6 · 0.05 mm / J)^⅓ = 39 ms from rest; at 250 mm/s² alone they take 20 ms
GENTLE_MS = 32
X_STEP = 2


def test_short_lines_are_read_planned_and_stepped(uf2, show):
    machine = gcode.fast_router()
    assert machine.free_bytes > FREE_BYTES
    run = gcode.run_lines(machine, 0.2, 200, 80)
    assert run["lines_s"] > LINES_S and run["late"] == 0
    show("lines of 0.2 mm a second on the Pico", f"{run['lines_s']:.0f}")


FAR = (
    "from array import array\n"
    "def read(place, text):\n"
    "    rows = array('i', [0] * 80)\n"
    "    at = 0\n"
    "    while at < len(text):\n"
    "        count = parse(text, at, len(text), place, rows, rows, None, 1)\n"
    "        print(count, list(place), list(rows))\n"
    "        at = text.find(b'\\n', at) + 1 if not count else place[%d]\n" % parse_records.PARSE_AFTER
)


def test_far_lines_are_read_as_on_a_pc(uf2):
    """Up to 2.1 m, at the limits of 32 bits."""
    place = [0] * parse_records.PARSE_FIELDS
    place[parse_records.PARSE_NAMED] = 3
    place[parse_records.PARSE_AXES], place[parse_records.PARSE_MODAL], place[parse_records.PARSE_FEED] = 3, 1, 10_000
    for axis, (offset, per_m) in enumerate(((0, 320_000), (1_900_000_000, 83_333), (-2_147_483_647, 400_000))):
        place[parse_records.PARSE_OFFSET + axis], place[parse_records.PARSE_RESOLUTION + axis] = offset, per_m
        place[parse_records.PARSE_LOW + axis], place[parse_records.PARSE_HIGH + axis] = 0, 0x3FFFFFFF
    text = "".join(
        f"X{x}Y{y}Z{z}\n"
        for x, y, z in zip(
            ("600", "1073.741824", "1073.741", "2139.5", "-2139.999", "2141", "-.001", "536.871"),
            ("0", "247.483", "247.484", "-1900.5", "1.5", "200", "-2140", "99.9999"),
            ("0", "-0.000001", "2139.1", "1500.0625", "700.7", "1999", "0.5", "1000"),
        )
    ).encode()
    code = FAR + f"read(array('i', {place}), {text})\n"
    here = io.StringIO()
    with contextlib.redirect_stdout(here):
        exec(code, {"parse": parse_viper.parse_lines})
    modules = {"passo/records.py": records, "parse_viper.py": parse_viper, "passo/protocols/gcode/parse_records.py": parse_records}
    files = compiled({path: Path(module.__file__) for path, module in modules.items()})
    files["passo/__init__.py"] = b""
    code = "from parse_viper import parse_lines as parse\n" + code
    counts = [line[0] for line in here.getvalue().splitlines()]
    assert counts.count("1") >= 4 and "0" in counts, counts
    assert EmulatedPico(files=files, uf2=uf2).boot().exec(code, limit_us=5_000_000).split() == here.getvalue().split()


@pytest.mark.slow
def test_a_picture_is_read_planned_and_burnt(uf2, show):
    run = gcode.run_raster(gcode.fast_router((0.1,), laser=True), 0.1, 100, 100)
    assert run["lines_s"] > DOTS_S and run["late"] == 0
    show("dots of 0.1 mm a second on the Pico", f"{run['lines_s']:.0f}")


@pytest.mark.slow
def test_tight_arcs_are_stepped_in_time(uf2):
    """On the board as it is; where it stands at the end its pins tell."""
    machine = gcode.boot_router()
    start = list(machine.plant.position)
    assert gcode.late_words(machine, TIGHT) == 0
    assert [after - before for after, before in zip(machine.plant.position, start)] == END_STEPS


@pytest.mark.slow
def test_s_curves_are_stepped_in_time(uf2):
    """Lines, on the shipped board, except for the memory that it reserves for arcs."""
    machine = gcode.boot_router(jerk=JERK)
    start = list(machine.plant.position)
    pulses = machine.pico.record_edges(X_STEP)
    assert gcode.late_words(machine, GENTLE) == 0
    assert machine.plant.position == start
    rising = [cycle for cycle, level in pulses if level == 1]
    assert rising[FIRST_STEPS] - rising[0] > GENTLE_MS * gcode.CYCLES_PER_MS


@pytest.mark.slow
def test_a_router_as_it_is_has_memory_for_its_arcs(uf2):
    """With its questions before them and a settings file behind them; over the UART, nothing changed."""
    machine = EmulatedMachine("router_3axis", trace=None).boot()
    machine.run_until(lambda: b"$X" in machine.replies_so_far(LINK), 10_000)

    def ask(line):
        machine.take(LINK)
        machine.send(line + b"\n", LINK)
        machine.run_until(lambda: ANSWER.search(machine.replies_so_far(LINK)), 10_000)
        return machine.take(LINK)

    for line in (b"$LINK=0", b"$X", b"$$", b"$#", b"$110=4000", b"G91G1X1F600", b"G2X2I1F600", b"G3X-2I-1Z1"):
        assert ANSWER.search(ask(line))[2] == b"ok", line
    machine.settle()
    for line in (b"$$", b"$111=4000", b"G10L20P1X0", b"$#", b"G2X1Y1J1"):
        assert ANSWER.search(ask(line))[2] == b"ok", line


@pytest.mark.slow
def test_lines_sent_without_waiting_are_answered(uf2):
    """At the wire's full speed, each of them taking longer than it takes to arrive: none is lost without a word."""
    machine = EmulatedMachine("router_3axis", trace=None).boot()
    machine.run_until(lambda: b"$X" in machine.replies_so_far(LINK), 10_000)
    machine.send(b"$LINK=0\n$X\n", LINK)
    machine.run_until(lambda: machine.replies_so_far(LINK).count(b"ok") == 2, 10_000)
    machine.take(LINK)
    machine.send(b"G53G0X0 \n" * FLOOD + b"G4P0\n", LINK)
    machine.run_until(lambda: len(LINE_END.findall(machine.replies_so_far(LINK))) > FLOOD, 10_000)
    answers = [line for line in machine.take(LINK).split(b"\r\n") if line and line[:1] != b"["]  # without the caution that it is not homed
    assert set(answers) == {b"ok", b"error:11"} and len(answers) == FLOOD + 1 and machine.wire(LINK).overruns == 0
    # The first were done, the rest found no room; one of them may come just as a line is done.
    assert 0 <= answers.count(b"ok") - answers.index(b"error:11") <= 2


@pytest.mark.slow
def test_a_cam_program_runs_on_the_board(uf2):
    """Over the UART, as a CAM system wrote it: tool change, tool length, pecks. No line is refused, and memory stays."""
    machine = EmulatedMachine("router_3axis", trace=None).boot()
    machine.run_until(lambda: b"$X" in machine.replies_so_far(LINK), 10_000)
    machine.take(LINK)
    start = list(machine.plant.position)
    lines = [line for line in CAM.split("\n") if line.strip() and line != "%"]
    for line in ["$LINK=0", "$X", *lines]:
        machine.send(line.encode() + b"\n", LINK)
        if "M6" in line:
            machine.run_until(lambda: b"Tool change" in machine.replies_so_far(LINK), 10_000)
            machine.send(b"~", LINK)
        machine.run_until(lambda: ANSWER.search(machine.replies_so_far(LINK)), 30_000)
        answer = machine.take(LINK)
        assert ANSWER.search(answer)[2] == b"ok", (line, answer)
    machine.settle()
    assert [after - before for after, before in zip(machine.plant.position, start)] == [8 * 320, 16 * 320, 15 * 400]
