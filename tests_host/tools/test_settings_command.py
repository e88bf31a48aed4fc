"""`passo settings` and `passo calibrate --write` at a board of every language: set, the power off and on: kept."""

import pytest
from test_board_command import Board
from typer.testing import CliRunner

from host_tools.cli.main import app
from host_tools.clients.settings import setting_numbers, number_of
from host_tools.failure import Failure

BOARDS = {"torch": "torch_manipulator", "plotter": "plotter_2014", "pulses": "lpt_router", "keys": "two_motor_kit", "grbl": "router_3axis"}
TABLE = "".join(f"x {length} {0.97 * length:.3f} 0.02 10\n" for length in (10, 20, 50, 100))


def passo(*words):
    """(0 or the failure's text, what was printed)"""
    result = CliRunner().invoke(app, [str(word) for word in words])
    if isinstance(result.exception, Failure):
        return str(result.exception), result.output
    assert result.exception is None, result.exception
    return result.exit_code, result.output


def test_names_and_numbers():
    assert number_of("x_steps_mm") == number_of("100") == number_of("$100") == 100 and number_of("interval_us") == 181
    assert len(set(setting_numbers().values())) == len(setting_numbers()) > 40
    with pytest.raises(Failure, match="there is no setting x_speed; known are"):
        number_of("x_speed")


@pytest.mark.parametrize("language", BOARDS)
def test_set_off_and_on_again(tmp_path, language):
    """The command finds the link's language by asking; a back-up restores the former values; a refusal has its reason."""
    on = ("--board", BOARDS[language], "--flash", tmp_path / "kept", "--time", "fast")
    with Board(*on) as board:
        where = ("--port", board.port)
        assert passo("settings", "backup", tmp_path / "before.txt", *where)[0] == 0
        status, said = passo("settings", "x_steps_mm=49.5", "130", *where)
        assert status == 0 and said.startswith("$100=49.500  x: steps per millimetre") and "position is unknown now" in said
        failure, _ = passo("settings", "x_steps_mm=-3", *where)
        assert failure.startswith("$100=-3") and "error 4, " in failure
        assert board.end()[0] == 0
    with Board(*on) as board:
        where = ("--port", board.port)
        assert passo("settings", "100", *where, "--protocol", language)[1].startswith("$100=49.500 ")
        assert passo("settings", *where)[1].count("$100=49.500") == 1
        assert passo("settings", "restore", tmp_path / "before.txt", *where)[1].startswith("1 of ")
        table = tmp_path / "table.txt"
        table.write_text(TABLE)
        used = float(passo("settings", "x_steps_mm", *where)[1].split()[0].partition("=")[2])
        status, said = passo("calibrate", table, *where, "--write")
        assert status == 0 and f"written: $100={used / 0.97:.3f}" in said, said
        assert passo("settings", "x_steps_mm", *where)[1].startswith(f"$100={used / 0.97:.3f}")
        assert board.end()[0] == 0


@pytest.mark.parametrize("language", BOARDS)
@pytest.mark.parametrize("value", ["nan", "inf", "1e400", "48,5", "4 8", "0x10", "1*5", "5\n$101=9", "٣", "=5", "-"])
def test_a_wrong_value_changes_none_of_several(language, value):
    """No port is opened: names and values are looked at before the first is sent."""
    failure, said = passo("settings", "x_steps_mm=50", f"y_steps_mm={value}", "--protocol", language, "--port", "/dev/nothing")
    assert failure.startswith(f"y_steps_mm={value}: no number") and not said


@pytest.mark.parametrize("line", ["$H", "$HX", "$J=G91X50F500", "$X", "$SLP", "$C", "$RST=*", "$LINK=2", "$$", "$", "$N0", "$F=PART", "$100", " $100=5", "$100 =5", "G10L20P1X0", "G0X5"])
def test_a_back_up_sets_and_does_nothing_else(tmp_path, line):
    """A file of settings may come from anybody: a line that moves, unlocks or erases is none. No port is opened."""
    file = tmp_path / "others.txt"
    file.write_text(f"$110=500.000\n{line}\n")
    failure, said = passo("settings", "restore", file, "--port", "/dev/nothing")
    assert failure == f"{file}, line 2: {line!r} is no setting" and not said


def test_what_has_been_set_before_a_refusal_is_told():
    with Board("--board", "torch_manipulator", "--time", "fast") as board:
        failure, said = passo("settings", "x_steps_mm=50", "y_steps_mm=0", "--port", board.port)
        assert failure.startswith("$101=0: error 110") and said.startswith("$100=50.000") and "position is unknown now" in said
        assert board.end()[0] == 0


def test_the_torch_calibrates_itself(tmp_path):
    """The document's chapter 4: it draws the waves, the lengths are measured, steps/mm set; then a millimetre is one."""
    trace = tmp_path / "trace.csv"
    with Board("--board", "torch_manipulator", "--trace", trace, "--time", "fast") as board:
        where = ("--port", board.port)
        assert passo("torch", "connect", *where)[0] == 0
        assert passo("torch", "strokes", "x", "--lengths", "10,20", "--strokes", "2", *where)[0] == 0
        assert passo("torch", "config", *where)[1].startswith("$100=48.000")
        (tmp_path / "table.txt").write_text(TABLE)
        assert passo("calibrate", tmp_path / "table.txt", *where, "--write")[0] == 0
        assert passo("torch", "config", *where)[1].startswith(f"$100={48 / 0.97:.3f}")
        assert passo("torch", "origin", *where)[0] == 0
        whose, place = passo("torch", "move", "97", "0", *where)[1].splitlines()
        assert whose == "steps/mm X 49.485, Y 83.000: the board's own; the board file says X 48.000, Y 83.000"
        assert place.startswith("idle  X 96.999 ")  # whole steps
        assert passo("torch", "config", "--steps-per-mm", "50,83", *where)[1].startswith("$100=50.000")
        assert passo("torch", "config", "2", "3", *where)[1] == "jogs of 100 and 249 steps at 500 and 830 steps/s\n"
        assert passo("torch", "config", "--steps-per-mm", "50", *where)[0].startswith("--steps-per-mm wants two numbers")
        assert board.end()[0] == 0
    lines = trace.read_text().splitlines()
    assert int(lines[-1].split(",")[1]) == round(97 * 48 / 0.97)


SQUARE = '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100"><path d="M10 10h20v20h-20z" stroke="black" fill="none"/></svg>'


def test_a_drawing_counts_in_the_steps_of_the_board_that_draws_it(tmp_path):
    """Calibrated on the board, not in the file; without a port the file's count, and `passo draw` says so."""
    (tmp_path / "a.svg").write_text(SQUARE)
    status, said = passo("draw", tmp_path / "a.svg", "--dry-run")
    assert status == 0 and said.startswith("steps/mm X 10.000, Y 10.000: the board file's\n")
    trace = tmp_path / "trace.csv"
    with Board("--board", "plotter_2014", "--trace", trace, "--time", "fast") as board:
        where = ("--port", board.port)
        assert "as in the board file" in passo("draw", tmp_path / "a.svg", "--dry-run", *where)[1]
        assert passo("settings", "x_steps_mm=12.5", *where)[0] == 0
        status, said = passo("draw", tmp_path / "a.svg", *where)
        assert status == 0 and said.startswith("steps/mm X 12.500, Y 10.000: the board's own; the board file says X 10.000, Y 10.000\n")
        assert board.end()[0] == 0
    xs = [int(line.split(",")[1]) for line in trace.read_text().splitlines()[1:]]
    behind_homing = xs[len(xs) - xs[::-1].index(0) :]
    assert max(behind_homing) == round(30 * 12.5)


def test_pulses_count_in_the_steps_of_the_board(tmp_path):
    trace = tmp_path / "trace.csv"
    with Board("--board", "lpt_router", "--trace", trace, "--time", "fast") as board:
        where = ("--port", board.port)
        file_says = float(passo("settings", "x_steps_mm", *where)[1].split()[0].partition("=")[2])
        assert passo("settings", f"x_steps_mm={file_says * 1.25}", *where)[0] == 0
        assert passo("pulses", "drives", "on", *where)[0] == 0
        status, said = passo("pulses", "jog", "x", "2", *where)
        assert status == 0 and f"steps/mm X {file_says * 1.25:.3f}" in said and "the board's own" in said
        assert board.end()[0] == 0
    assert int(trace.read_text().splitlines()[-1].split(",")[1]) == round(2 * file_says * 1.25)
