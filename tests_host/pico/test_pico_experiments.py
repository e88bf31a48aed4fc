"""`passo experiments` on the emulated Pico, and over a port as a real board."""

import csv
from functools import lru_cache

import pytest
from emulated import uf2  # noqa: F401
from pico_on_a_port import PicoPort, running
from typer.testing import CliRunner

from host_tools.cli.main import app
from host_tools.emulator.copies import on_a_copy
from host_tools.experiments import arcs, codes, drawing, inputs, lines, rates, strokes
from host_tools.experiments.places import Emulated, Virtual
from host_tools.prove import connection
from host_tools.prove.connection import EmulatedBoard

PC = Virtual()

pytestmark = [pytest.mark.slow, pytest.mark.unmeasured, pytest.mark.xdist_group("experiments")]


@pytest.fixture
def place(uf2):  # noqa: F811
    with Emulated() as made:
        yield made


def test_lines_on_the_chip(place, show):
    """The chip makes the same steps as the PC, and its software floats cost more than integers."""
    times, mhz = lines.measure_lines(place)
    here = {name: row[1::2] for name, row in lines.measure_lines(PC)[0].items()}
    assert mhz in (125, 200), "as the chip starts, or as main.py has set it before it was interrupted"
    assert {name: row[1::2] for name, row in times.items()} == here
    assert all(float_us > integer_us for integer_us, _steps, float_us, _others in times.values())
    show("integer and floating-point lines on the chip", ", ".join(f"{name} {row[0]} and {row[2]} µs" for name, row in times.items()))


def test_drawing_at_the_motors_pace(place):
    """Pace and computing add up: two waits a step, and the time that the line needs by itself."""
    computed = lines.measure_lines(place)[0]
    for name, (integer_s, float_s) in drawing.measure_paced(place).items():
        points = [(0, 0), *lines.points_of()[name]]
        pace_s = 2 * drawing.SPEED / 1e6 * sum(max(abs(b[0] - a[0]), abs(b[1] - a[1])) for a, b in zip(points, points[1:]))
        assert pace_s + computed[name][0] / 1e6 < integer_s < 1.1 * pace_s
        assert integer_s < float_s < 1.1 * pace_s + computed[name][2] / 1e6


def test_the_chip_agrees_with_the_pc(place):
    ends = arcs.random_ends()[:40]
    document, firmware = arcs.end_errors(place, ends)
    assert firmware == arcs.end_errors(PC, ends)[1]
    assert max(document) < 48_000 * 2**-14 + 1.5, "floats of 32 bits"
    assert codes.port_bytes(place) == codes.port_bytes(PC)


def test_inputs_and_outputs_of_the_mill(place):
    pressed, switched = inputs.press_inputs(place)
    assert all(each.is_right() for each in pressed) and all(switched.values()), (pressed, switched)


def test_strokes_and_their_wait(place, monkeypatch):
    monkeypatch.setattr(strokes, "LENGTHS_MM", (10,))
    for each in strokes.draw_strokes(place):
        assert each.made == 10 and 0 < each.wait_s < 0.02


def test_rates(place, monkeypatch):
    monkeypatch.setattr(rates, "PIO_KHZ", (480,))
    monkeypatch.setattr(rates, "TIMER_KHZ", (10, 500))
    by_pio, by_timer = rates.measure_clean_rates(place)
    assert by_pio == {480: True} and by_timer == {10: True, 500: False}, "the timer's shortest word is 40 µs"


@lru_cache
def _board():
    return EmulatedBoard("lpt_router")


@pytest.mark.parametrize("moves", [False, True])
def test_a_board_on_a_port(uf2, tmp_path, moves):  # noqa: F811
    """As a real one: it moves only if that is allowed, and is at its own work in the end."""

    def done():
        link = tmp_path / "port"
        with running(_board().pico, link) as made, pytest.MonkeyPatch.context() as patch:
            patch.setattr(connection, "PortBoard", lambda name: PicoPort(made, name))
            patch.setattr(rates, "PIO_KHZ", (480,))
            edges = [made.pico.record_edges(pin) for pin in (2, 3, 4)]
            words = ["experiments", "lines", "codes", "rates", "--on", str(link), "--out", str(tmp_path / "out"), *["--moves"] * moves]
            result = CliRunner().invoke(app, words)
            enable = made.pico.pads.state_of(9)
        if result.exception and not isinstance(result.exception, SystemExit):
            raise result.exception
        return result.exit_code, result.output, sum(map(len, edges)), enable

    status, output, steps, enable = on_a_copy(done)
    rows = list(csv.DictReader((tmp_path / "out" / "table.csv").open(encoding="utf-8")))
    assert status == 0, output
    assert {row["experiment"] for row in rows} == ({"lines", "codes", "rates"} if moves else {"lines", "codes"})
    assert (steps > 0) == moves and enable != 0, "enable is active low"
    if moves:
        assert [row["ours"] for row in rows if row["experiment"] == "rates"] == ["480"]
