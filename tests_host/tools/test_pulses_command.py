"""`passo pulses` against `passo board --board lpt_router`, and its results for files without a board."""

import contextlib
import csv
import os
import select
import subprocess
import time

import pytest
from typer.testing import CliRunner

from host_tools import boards, interpreter
from host_tools.cli.main import app
from host_tools.failure import Failure
from host_tools.programs import pulse_file, pulse_shapes
from passo.config.boardfile import check
from passo.motion.line import Line
from test_board_command import Board

# As the document has them, whatever the firmware thinks.
VECTOR = "80 86 86 84 DC D8 81 F1 D1 E5 F5 D5 80 00".split()


def passo(*words):
    """(exit status or failure's text, what was printed)"""
    result = CliRunner().invoke(app, ["pulses", *map(str, words)])
    if isinstance(result.exception, Failure):
        return str(result.exception), result.stdout
    assert result.exception is None or result.exit_code, result.exception
    return result.exit_code, result.stdout


def rows_of(trace):
    with open(trace) as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["t_us", "x", "y", "z", "a", "tool"]
    return [[int(value) for value in row[1:4]] for row in rows[1:]]


def test_a_session(tmp_path):
    trace = tmp_path / "trace.csv"
    good, ask, bad = tmp_path / "good.txt", tmp_path / "ask.txt", tmp_path / "bad.txt"
    good.write_text("[+2000(\n" + "A" * 60 + "G" * 60 + "\n)D]\n")
    ask.write_text("[AA+0BB")
    bad.write_text("AA\nC*D")
    with Board("--board", "lpt_router", "--trace", trace, "--time", "fast") as board:
        where = ("--port", board.port)
        status, text = passo("play", good, *where)
        assert status == 0 and text.startswith(f"{good}: 126 commands\nidle  command 126 of 126, forward at 2000.0 mm/min")
        assert "place 120,59,0, tool off, port 00" in text
        assert "command 0 of 126, backward" in passo("reverse", *where)[1]
        assert "pass 3/3" in passo("play", good, "--repeat", "3", *where)[1]
        assert passo("jog", "z", "-0.5", "x", "1", *where)[1].count("place 440,177,-40") == 1
        assert "place 560,236,-40" in passo("play", good, "--stream", *where)[1]
        failure, _ = passo("play", bad, *where)
        assert failure.endswith("line 2 column 2: error 121: a number is missing, or unfinished: complete it")
        failure, text = passo("play", ask, *where)
        assert "WAITS FOR A SPEED" in text and failure == "paused at command 4 of 6: passo pulses speed N goes on"
        assert passo("speed", "500", *where)[0] == 0
        deadline = time.monotonic() + 120
        while "command 6 of 6" not in passo("status", *where)[1]:
            assert time.monotonic() < deadline
        assert passo("run", "101", *where)[0] != 0
        assert passo("repeat", "2", *where)[0] == 0
        assert passo("step", *where)[0] == 0 and "hold  command 1 of 6" in passo("status", *where)[1]
        assert passo("jog", "y", "3", "--steps", *where)[0] == 0
        failure, _ = passo("run", *where)
        assert failure.startswith("run: error 127: ")
        assert "WAITS" in passo("return", *where)[1]
        assert passo("stop", *where)[0] == 0
        assert passo("drives", "on", *where)[0] == 0 and "port 80" in passo("status", *where)[1]
        assert passo("tool", "on", *where)[0] == 0 and "port 81" in passo("status", *where)[1]
        status, _, errors = board.end()
        assert status == 0 and not errors
    rows = rows_of(trace)
    assert [0, 0, 0] in rows and rows[-1][2] == -40


class Terminal:
    """`passo pulses …` with a terminal of its own: keys go in, what is shown comes out."""

    def __init__(self, *words):
        self._master, slave = os.openpty()
        command = [*interpreter.passo(), "pulses", *map(str, words)]
        self.process = subprocess.Popen(command, stdin=slave, stdout=slave, stderr=slave, env=interpreter.environment())
        os.close(slave)
        self.text = ""

    def key(self, keys):
        os.write(self._master, keys.encode())

    def wait_for(self, text):
        """Read until `text` is shown, behind the text that the last call waited for."""
        deadline = time.monotonic() + 120
        while text not in self.text:
            assert time.monotonic() < deadline, self.text
            if select.select([self._master], [], [], 0.1)[0]:
                self.text += os.read(self._master, 4096).decode()
        self.text = self.text.split(text, 1)[1]

    def end(self):
        """Read all output up to the end; return the exit status."""
        while self.process.poll() is None:
            if select.select([self._master], [], [], 0.1)[0]:
                with contextlib.suppress(OSError):
                    self.text += os.read(self._master, 4096).decode()
        os.close(self._master)
        return self.process.wait(30)


@pytest.mark.parametrize("stream", [False, True], ids=["stored", "streamed"])
def test_keys_command_a_run_from_the_terminal_that_plays_it(tmp_path, stream):
    file, short = tmp_path / "long.txt", tmp_path / "short.txt"
    file.write_text("[+600" + "A" * 24000 + "]")  # 30 s
    short.write_text("[+1200" + "B" * 800 + "]")
    more = ["--stream"] if stream else []
    with Board("--board", "lpt_router", "--time", "real") as board:
        where = ["--port", board.port]
        terminal = Terminal("play", file, *where, *more)
        terminal.wait_for("run ")
        second, _ = passo("pause", *where)  # of another terminal
        assert f"port {board.port} is in use by" in second and f"process {terminal.process.pid}" in second
        terminal.key("p")
        terminal.wait_for("hold ")
        terminal.wait_for("r go on")
        terminal.key("r")
        terminal.wait_for("run ")
        terminal.key("1200\n")
        terminal.wait_for("at 1200")
        terminal.key("s")
        assert terminal.end() == 1 and "stopped at" in terminal.text
        terminal = Terminal("play", short, *where, *more)
        assert terminal.end() == 0 and "command 803 of 803" in terminal.text


def test_a_run_that_is_only_paused_does_not_end_well(tmp_path):
    file = tmp_path / "ask.txt"
    file.write_text("A+0A")
    with Board("--board", "lpt_router", "--time", "fast") as board:
        assert passo("play", file, "--port", board.port)[0].startswith("paused at command 2 of 3")
        assert passo("stop", "--port", board.port)[0] == 0
        assert passo("play", file, "--no-wait", "--port", board.port)[0] == 0
        assert "WAITS FOR A SPEED" in passo("status", "--port", board.port)[1]


def test_reverse_of_a_stream_whose_start_is_forgotten(tmp_path):
    """It says so, and another file may be played from there."""
    long, short = tmp_path / "long.txt", tmp_path / "short.txt"
    long.write_text("[$" + "AC" * 5000 + "]")
    short.write_text("[$BBBD]")
    with Board("--board", "lpt_router", "--time", "fast") as board:
        where = ("--port", board.port)
        assert passo("play", long, "--stream", *where)[0] == 0
        failure, _ = passo("reverse", *where)
        assert failure.startswith("not back at the start, but at command ") and failure.endswith("run goes forward again")
        assert "place 5000,5000,0" in passo("run", *where)[1]
        assert passo("reverse", *where)[0] == failure
        assert passo("play", short, *where)[0] == 0
        status, _, errors = board.end()
        assert status == 0 and not errors


@pytest.mark.parametrize("shape", pulse_shapes.SHAPES)
def test_examples_are_closed(shape, tmp_path):
    file = tmp_path / "shape.txt"
    assert passo("example", shape, "-o", file, "--speed", 2400)[0] == 0
    board = check(boards.load("lpt_router"))
    course = pulse_file.Course(pulse_file.read_items(file.read_bytes(), "xyz", board["step_program"]), board)
    assert course.place == [0, 0, 0]
    size = {"square": (100, 100), "triangle": (100, 100), "hexagon": (150, 100), "octagon": (150, 150)}[shape]
    assert [(high - low) / 80 for low, high in zip(course.low, course.high)][:2] == list(size)
    status, text = passo("check", file)
    assert status == 0 and "ends at 0.000" in text
    picture = tmp_path / "shape.png"
    assert passo("convert", file, "-o", picture) == (0, f"{picture}\n") and picture.stat().st_size > 5000
    assert passo("example", shape, "-o", file, "--down", "1.5")[0] == 0
    assert file.read_text().count("F") == file.read_text().count("E") == 120


def test_image(tmp_path):
    file = tmp_path / "vector.txt"
    file.write_text("[ +1000 A A B X P ( Q R M Y Z ) ]")
    assert passo("image", file) == (0, "\n".join(VECTOR) + "\n")


def test_gcode_becomes_the_steps_of_the_firmware(tmp_path):
    source, target = tmp_path / "part.gcode", tmp_path / "part.txt"
    source.write_text("G21 G90\nG0 Z1\nM3 S1000\nG1 X10 Y3.3 F600\nG2 X10 Y3.3 I5 J0\nM5\nG4 P0.5\nM0\nG1 X0 Y0 F900\n")
    assert passo("convert", source, "-o", target) == (0, f"{target}\n")
    text = target.read_text().replace("\n", "")
    assert text.startswith("[$" + "E" * 80 + "(+600") and ")*500+0+900" in text and text.endswith("]")
    line = Line(3)
    line.begin((800, 264, 0))
    out = [0] * 500
    letters = ""
    while line.left:
        count = min(line.left, 500)
        line.walk(out, 0, count)
        letters += "".join({1: "A", 3: "G"}[mask] for mask in out[:count])
    assert text.split("+600")[1].startswith(letters)
    board = check(boards.load("lpt_router"))
    course = pulse_file.Course(pulse_file.read_items(target.read_bytes(), "xyz", board["step_program"]), board)
    assert course.place == [0, 0, 80]
    assert (course.high[0] - 800, course.high[1] - 264, course.low[1] - 264) == (800, 400, -400)  # a whole circle of 5 mm


@pytest.mark.parametrize(
    "lines, pulses",
    [
        ("M3\nG1 X.025 F100\nM5", "(+100AA)"),
        ("M3 (no S: but here)\nG1 X.025 F100 ; S0", "(+100AA)"),
        ("M4\nG0 X.025\nM5\nG0 X0\nM3\nG1 X.0125 F100", "($AA)BB(+100A)"),
        ("M3 S0\nG1 X.0125 F100\nS500\nX.025\nS0 X.0375\nM5", "+100A(A)A"),
        ("G1 X.0125 F100 S500\nM3\nX.025\nM5", "+100A(A)"),
        ("M3 S1\nG1 X.0125 F100\nM2", "(+100A)"),
        ("M3\nG1 X.0125 F100\nM30\nG1 X1\nG38.2 X5", "(+100A)"),
        ("M8\nG1 X.0125 F100\nM9\nM02", "+100A"),
    ],
)
def test_the_tool_and_the_end_of_a_programme(lines, pulses, tmp_path):
    source, target = tmp_path / "part.gcode", tmp_path / "part.txt"
    source.write_text(f"G21 G90\n{lines}\n")
    assert passo("convert", source, "-o", target) == (0, f"{target}\n")
    assert target.read_text().replace("\n", "") == f"[{pulses}]"


@pytest.mark.parametrize(
    "lines, place",
    [
        ("G0X10Y0\nG3X9.9999Y0.001I-10J0Z1", (800, 0, 80)),
        ("G0X10Y0\nG3X9.9999Y0.001R10Z1", (800, 0, 80)),
        ("G2X0Y0Z-30I0.025J0", (0, 0, -2400)),  # too steep a helix for a circle
    ],
)
def test_arcs_of_a_step_and_less(lines, place, tmp_path):
    """The third axis's steps, and hardly any others."""
    source, target = tmp_path / "part.gcode", tmp_path / "part.txt"
    source.write_text(f"G21 G90 F600\n{lines}\n")
    assert passo("convert", source, "-o", target) == (0, f"{target}\n")
    board = check(boards.load("lpt_router"))
    course = pulse_file.Course(pulse_file.read_items(target.read_bytes(), "xyz", board["step_program"]), board)
    assert tuple(course.place) == place
    assert course.steps <= 800 + abs(place[2]) and max(course.high[:2]) <= 804 and course.low[:2] > [-5, -5]


def test_an_arc_on_unlike_axes_is_made_of_chords(tmp_path):
    """A circle in X and Z, whose steps are not as long."""
    board = tmp_path / "unlike.py"
    text = boards.path("lpt_router").read_text()
    cut = text.index('"name": "z"')
    board.write_text(text[:cut] + text[cut:].replace("80000", "50000"))
    source, target = tmp_path / "part.gcode", tmp_path / "part.txt"
    source.write_text("G21 G90 G18 F600\nG2 X0 Z0 I5 K0\n")
    assert passo("convert", source, "-o", target, "--board", board) == (0, f"{target}\n")
    config = check(boards.load(str(board)))
    course = pulse_file.Course(pulse_file.read_items(target.read_bytes(), "xyz", config["step_program"]), config)
    assert course.place == [0, 0, 0] and (course.low, course.high) == ([0, 0, -250], [800, 0, 250])


@pytest.mark.parametrize(
    "text, said",
    [("G1 X5", "line 1: G1X5: error 22"), ("G38.2 X5 F100", "no word for that"), ("G93 G1 X5 F2", "inverse time")],
)
def test_gcode_that_cannot_be(text, said, tmp_path):
    source = tmp_path / "part.gcode"
    source.write_text(text + "\n")
    assert said in passo("convert", source)[0]


@pytest.mark.parametrize(
    "words",
    [("example", "star"), ("jog", "x"), ("jog", "q", "1"), ("tool", "up"), ("check", "/none"), ("status", "--port", "/none"),
     ("play", "/none", "--port", "/none"), ("repeat", "0"), ("fly",), ("check", "/none", "--board", "plotter_2014")],
)  # fmt: skip
def test_what_cannot_be_fails(words):
    assert passo(*words)[0] != 0


def test_errors_have_line_and_column(tmp_path):
    file = tmp_path / "bad.txt"
    file.write_text("AB\nC!\n")
    assert passo("check", file)[0] == f"{file}:2:2: error 120: neither a pulse code nor a command of the language: check the line"


@pytest.mark.parametrize("text, place", [("A{home}B", "1:2"), ("AA\n{$100=5}\n", "2:1"), ("AA{", "1:3"), ("{unlock}", "1:1")])
@pytest.mark.parametrize("words", [("check",), ("play",), ("play", "--stream"), ("play", "--back"), ("convert", "-o", "x.png")])
def test_a_file_has_no_control_commands(tmp_path, monkeypatch, text, place, words):
    """They would be carried out as they come. No port is opened."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "others.txt"
    file.write_text(text)
    port = ("--port", "/dev/nothing") if words[0] == "play" else ()
    failure, said = passo(words[0], file, *words[1:], *port)
    assert not said
    if words[1:] not in (("--stream",), ("--back",)):  # these ask the board for its axes first
        assert f"{file}:{place}: error 120" in str(failure)


@pytest.mark.parametrize("verb", ["play", "jog", "convert", "check", "image", "example"])
def test_help_has_examples(verb):
    status, text = passo(verb, "--help")
    assert status == 0 and f"passo pulses {verb}" in text
