"""`passo experiments`: the authors' figures, the figures measured beside them, the report, and its refusals.

PASSO_DOCUMENTS names a folder with the documents as text files: then each figure is looked for there, as printed.
"""

import csv
import os
import re
from array import array
from math import cos, hypot, pi, sin
from pathlib import Path
from statistics import fmean

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from running_router import Running
from tiers import examples
from typer.testing import CliRunner

from host_tools import boards, language
from host_tools.cli.main import app
from host_tools.clients.grbl import GrblClient
from host_tools.experiments import arcs, authors, board_lines, charts, codes, drawing, homing, inputs, lines, rates, report, strokes
from host_tools.experiments.board_cordic import document_end, firmware_end
from host_tools.experiments.experiments import EXPERIMENTS, why_not_here
from host_tools.experiments.places import BOARD, Virtual
from host_tools.experiments.row import Outcome, Row, percent_better
from host_tools.failure import Failure
from passo.motion.cordic import TURN
from passo.motion.line import MAX_RUN, Line

pytestmark = pytest.mark.quick
OBJECTS = ("square", "triangle", "spiral", "text", "circle")
STEPS = st.integers(-MAX_RUN, MAX_RUN)
VIRTUAL = Virtual()


@pytest.fixture(autouse=True)
def english():
    yield
    language.choose_language(None)


def passo(*words):
    result = CliRunner().invoke(app, ["experiments", *map(str, words)])
    if result.exception and not isinstance(result.exception, (SystemExit, Failure)):
        raise result.exception
    return result


# --- the authors' figures


def test_each_figure_has_its_place_and_is_the_number_that_is_printed():
    for name, row in authors.read_data()["figures"].items():
        found = authors.author_figure(name)
        assert found.place.document in authors.NAMES and found.place.text() and found.unit, name
        digits = re.sub(r"[^\d,.]", "", row["printed"])
        assert "value" in row or found.value == float(digits.replace(",", ".")), name


def test_table_8_is_consistent():
    """Its percentages are float / integer − 1, and its last row the mean of the times."""
    integer, floating = ([authors.author_figure(f"{name} {kind}").value for name in OBJECTS] for kind in ("integer", "float"))
    for name, a, b in zip(OBJECTS, integer, floating):
        assert percent_better(b, a) == pytest.approx(authors.author_figure(f"{name} better").value, abs=0.01)
    assert authors.author_figure("mean integer").value == pytest.approx(fmean(integer), abs=2e-3)
    assert authors.author_figure("mean float").value == pytest.approx(fmean(floating), abs=2e-3)


def test_the_figures_are_those_of_the_documents():
    folder = os.environ.get("PASSO_DOCUMENTS")
    if not folder:
        pytest.skip("PASSO_DOCUMENTS names no folder")
    texts = [re.sub(r"[\\*$]", "", path.read_text(encoding="utf-8")) for path in sorted(Path(folder).glob("*.txt"))]
    assert texts
    for name, row in authors.read_data()["figures"].items():
        words = row["printed"].split() if name == "bytes of the port" else [row["printed"].replace(" µs", "")]
        assert any(all(word in text for word in words) for text in texts), name


# --- lines


@given(STEPS, STEPS)
@settings(max_examples=examples(60), deadline=None)
def test_the_integer_line_is_the_firmwares(x, y):
    out, wanted = array("I", bytearray(4 * MAX_RUN)), array("I", bytearray(4 * MAX_RUN))
    line = Line(2)
    line.begin((x, y))
    total = line.total
    if total:
        line.walk(wanted, 0, total)
    assert board_lines.integer_line(0, 0, x, y, out) == total
    assert out[:total] == wanted[:total]


@given(STEPS, STEPS, STEPS, STEPS)
@settings(max_examples=examples(60), deadline=None)
def test_the_float_line_truncates_and_ends_a_step_short(x1, y1, x2, y2):
    out = array("I", bytearray(4 * 2 * MAX_RUN))
    dx, dy = x2 - x1, y2 - y1
    count = board_lines.float_line(x1, y1, x2, y2, out)
    assert count == max(abs(dx), abs(dy))
    if not count:
        return
    dominant, minor, start, rise = (1, 2, y1, dy / dx) if abs(dx) >= abs(dy) else (2, 1, x1, dx / dy)
    sign = 1 if (dx if dominant == 1 else dy) > 0 else -1
    places = [int(rise * (sign * at) + start) for at in range(count)]
    moved = [now != before for before, now in zip([start, *places], places)]
    assert [bool(mask & minor) for mask in out[:count]] == moved and all(mask & dominant for mask in out[:count])


def test_both_lines_of_an_object_make_the_same_steps():
    for name, (_int_us, integer, _float_us, floating) in lines.measure_lines(VIRTUAL)[0].items():
        points = lines.points_of()[name]
        assert integer == floating == sum(max(abs(b[0] - a[0]), abs(b[1] - a[1])) for a, b in zip(points, points[1:]))


# --- drawing


def test_the_square_of_the_log_takes_the_pace_and_the_pen():
    """1404 steps of 2 × 1000 + 225 µs, and the pen down and up, 60 ms each; the packets and the loop take some milliseconds."""
    pace_s = sum(max(abs(b[1] - a[1]), abs(b[2] - a[2])) for a, b in zip([(0, 0, 0), *drawing.LOG], drawing.LOG)) * 2225e-6
    took_s = drawing.draw_objects(VIRTUAL)["log"]
    assert pace_s + 0.12 <= took_s <= pace_s + 0.15
    assert pace_s == pytest.approx(authors.author_figure("square of the log").value, abs=0.01)


# --- arcs

POINT = st.tuples(st.integers(-2000, 2000), st.integers(-2000, 2000))


@given(st.integers(1, 2000), st.floats(-720, 720), st.lists(POINT, min_size=1, max_size=20))
@settings(max_examples=examples(60), deadline=None)
def test_distances_are_those_of_numpy(radius, sweep, points):
    import numpy as np

    arc = arcs.Arc(radius, sweep, [(radius, 0), *points])
    found = np.array(arc.points, float)
    assert np.allclose(arc.off_circle(), np.linalg.norm(found, axis=1) - radius)
    turned = np.exp(1j * np.radians(sweep)) * radius
    assert arc.end_error() == pytest.approx(abs(complex(*found[-1]) - turned), abs=1e-6)


@given(st.integers(1, 48_000), st.integers(-TURN // 4, TURN // 4))
@settings(max_examples=examples(100), deadline=None)
def test_ends_by_cordic(radius, angle):
    """15 steps leave an angle of 2⁻¹⁴ at most; the firmware's end is the nearest step or a neighbour."""
    true = radius * cos(2 * pi * angle / TURN), radius * sin(2 * pi * angle / TURN)
    x, y = document_end(radius, angle * 360 / TURN)
    assert hypot(x - true[0], y - true[1]) <= radius * 2**-14 + 0.01
    x, y = firmware_end(radius, angle)
    assert hypot(x - true[0], y - true[1]) < 0.9


def test_arcs_of_the_mill_stay_within_half_a_step_and_end_on_the_nearest():
    for arc in arcs.walk(VIRTUAL):
        assert max(map(abs, arc.off_circle())) <= 0.5 + 1e-9
        assert arc.end_error() <= 2**0.5 / 2 + 0.2
        assert arc.angles_deg()[-1] == pytest.approx(arc.sweep_deg, abs=0.5)


# --- inputs, codes, strokes, rates, homing


def test_each_input_is_named_and_each_output_switches():
    pressed, switched = inputs.press_inputs(VIRTUAL)
    assert len(pressed) == 13 and all(each.is_right() for each in pressed), pressed
    assert set(switched) == {"vacuum", "flood", "mist", "tool", "enable"} and all(switched.values()), switched


def test_an_input_that_is_not_named_is_wrong(monkeypatch):
    monkeypatch.setattr(inputs, "words_of", lambda _machine: {"state": "Idle"})
    assert not any(row.agrees for row in inputs.run(VIRTUAL).rows if row.what.startswith("input "))


def test_the_bytes_are_those_of_table_3(monkeypatch, tmp_path):
    assert all(row.agrees for row in codes.run(VIRTUAL).rows if row.what.startswith("code "))
    monkeypatch.setattr(codes, "FILE", codes.FILE.replace("X", "W"))
    wrong = [row.what for row in codes.run(VIRTUAL).rows if row.agrees is False]
    assert wrong == ["code W"]
    assert passo("codes", "--out", tmp_path).exit_code == 1, "a different byte must give exit status 1"


def test_a_diagonal_is_as_fast_as_a_side():
    """By Pythagoras, in whole microseconds: 12.5 µm at 1200 mm/min are 625 of them."""
    assert codes.period_us(VIRTUAL, codes.STRAIGHT) == pytest.approx(625)
    assert codes.period_us(VIRTUAL, codes.DIAGONAL) == pytest.approx(round(625 * 2**0.5))


def test_strokes_are_as_long_as_asked_for():
    for each in strokes.draw_strokes(VIRTUAL):
        assert each.made == each.length and each.mm_s == pytest.approx(strokes.MM_S, rel=1e-3)


def test_the_kit_makes_250_steps_a_second():
    assert rates.kit_rate(VIRTUAL) == pytest.approx(authors.author_figure("pause of the kit").value, rel=1e-3)


def test_homing_ends_on_the_same_step():
    ends = homing.home_repeatedly(VIRTUAL, 4)
    assert len(ends) == 4 and set(ends) == {(0, 0)}


class OnRouter:
    """A board at the other end of a port, which speaks G-code."""

    kind, moves, clients = BOARD, True, GrblClient

    def __init__(self, port, **homing):
        self._port = port
        board = boards.load("router_3axis")
        self._raw = {**board, "homing": {**board["homing"], **homing}}

    def board_table(self):
        return self._raw

    def open_client(self):
        return self.clients(self._port, timeout_s=15)


def test_a_board_says_how_well_it_homes():
    with Running("fast", homing={**boards.load("router_3axis")["homing"], "latch": True}) as router:
        rows = homing.home_board(OnRouter(router.line.name, latch=True), 3)
    assert {row[0] for row in rows} == {"x", "y", "z"} and all(count == 3 and wide == 0 for _axis, count, wide, _sigma in rows)
    assert not homing.why_left_out(OnRouter("", latch=True).board_table()) and "latch" in homing.why_left_out(OnRouter("", latch=False).board_table())


class Interrupted(GrblClient):
    """Ctrl-C is pressed once the machine homes."""

    def command(self, line, timeout_s=None):
        if line.startswith("$HR"):
            self._send_line(line.encode())
            while self.ask_status()["state"] != "Home":
                pass
            raise KeyboardInterrupt
        return super().command(line, timeout_s)


def test_homing_that_is_interrupted_ends(monkeypatch):
    monkeypatch.setattr(OnRouter, "clients", Interrupted)
    with Running("real", homing={**boards.load("router_3axis")["homing"], "latch": True}) as router:
        with pytest.raises(KeyboardInterrupt):
            homing.home_board(OnRouter(router.line.name, latch=True), 3)
        router.until(lambda: router.app.controller.state == "alarm")


def test_a_board_measures_what_its_board_file_can():
    found = {name: {of.__name__.rpartition(".")[2] for of in (codes, rates, homing) if not of.why_left_out(boards.load(name))} for name in boards.names()}
    assert found["lpt_router"] == {"codes", "rates"} and found["router_3axis"] == {"rates"}
    assert found["plotter_2014"] == found["two_motor_kit"] == set()


# --- the report


def outcome(*values):
    made = Outcome("some way of measuring")
    for at, value in enumerate(values):
        made.rows.append(Row(f"row <{at}>", authors.author_figure("square better"), value, "%", agrees=value > 0))
    made.pictures.append(("a picture", charts.draw_bars(["a", "b"], {"one": [1, -2], "two": [None, 3]}, "s")))
    return made


def test_the_report_is_one_page_with_all_figures(tmp_path):
    done = [("lines", outcome(12.5, -1)), ("homing", "it moves pins"), ("arcs", outcome(3))]
    html, table = report.write(tmp_path / "new" / "folder", done, "a place")
    text = html.read_text(encoding="utf-8")
    assert not re.search(r"(src|href)=|https?:|@import|url\(", text), "nothing is loaded from elsewhere"
    assert "row &lt;0&gt;" in text and "row <" not in text
    for each in ("3,96 %", "plotter 2014, p. 76, table 8", "12.5 % ✓", "-1 % ✗", "Not measured: it moves pins.", "A4", "Israel Burigo", "a place"):
        assert each in text, each
    rows = list(csv.DictReader(table.open(encoding="utf-8")))
    assert [float(row["ours"]) for row in rows] == [12.5, -1, 3] and {row["page"] for row in rows} == {"76"}


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=8))
@settings(max_examples=examples(60), deadline=None)
def test_a_picture_stays_inside_its_frame(values):
    for svg in (charts.draw_bars([str(at) for at in range(len(values))], {"a": values}, "s"), charts.draw_dots({"a": list(enumerate(values))}, "x", "y")):
        assert "nan" not in svg and "inf" not in svg
        found = [float(y) for y in re.findall(r' c?y="(-?[\d.]+)"', svg)]
        assert all(-1 <= y <= charts.HEIGHT for y in found), svg


def test_the_report_speaks_portuguese(tmp_path):
    assert passo("codes", "--lang", "pt", "--out", tmp_path).exit_code == 0
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert 'lang="pt"' in text and "Experimentos de cinco documentos" in text and "porta paralela 2009, p. 57, tabela 3" in text


# --- the command


def test_the_list_names_each_experiment():
    text = passo("--list").output
    assert all(re.search(rf"^{name} +\S", text, re.MULTILINE) for name in EXPERIMENTS)


@pytest.mark.parametrize("words, told", [
    (["lins"], "no experiment lins"), (["--lang", "xx"], "en or pt"), (["--on", "/dev/no-such-port"], "there is no port"),
    (["--on", "emulated"], "PASSO_UF2 names"),
])  # fmt: skip
def test_what_is_refused_is_told(monkeypatch, tmp_path, words, told):
    monkeypatch.setenv("PASSO_UF2", str(tmp_path / "none.uf2"))
    result = passo(*words, "--out", tmp_path / "out")
    assert isinstance(result.exception, Failure) and told in result.exception.message() and not (tmp_path / "out").exists()


def test_a_board_moves_only_if_that_is_allowed():
    place = OnRouter("", latch=True)
    place.moves = False
    assert {name for name in EXPERIMENTS if why_not_here(name, place)} == {"inputs", "strokes", "rates", "homing", "codes"}
    place.moves = True
    assert {name for name in EXPERIMENTS if why_not_here(name, place)} == {"inputs", "strokes", "codes"}, "a router speaks no pulses"


def test_ctrl_c_keeps_what_was_measured(monkeypatch, tmp_path):
    def interrupt(_place):
        raise KeyboardInterrupt

    monkeypatch.setattr(rates, "run", interrupt)
    assert passo("codes", "rates", "homing", "--out", tmp_path).exit_code == 1
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "code [" in text and "Not measured: interrupted." in text and "Homing" not in text


def test_one_that_fails_leaves_the_others(monkeypatch, tmp_path):
    def fail(_place):
        raise Failure("the board does not answer any more")

    monkeypatch.setattr(rates, "run", fail)
    assert passo("rates", "codes", "--out", tmp_path).exit_code == 1
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Not measured: the board does not answer any more." in text and "code [" in text
