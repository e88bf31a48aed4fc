"""`passo engrave`: pictures to rows, rows to G-code, and the lines that the virtual laser burns."""

import re
import subprocess
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib import cbook
from PIL import Image
from typer.testing import CliRunner

from digest import Sink, board_named, checked
from host_tools import interpreter
from host_tools.build import pc_kernels
from host_tools.cli.main import app
from host_tools.drawings import engraving
from host_tools.drawings.engraving import Machine, Options
from host_tools.failure import Failure
from host_tools.programs.gcode_time import Limits
from passo.app import App
from passo.steps.word import COUNT_MASK

LASER = Machine(Limits([200.0] * 4, [1500.0] * 4), 1000)
CLUSTERS = Machine(LASER.limits, 1000, 16)
PACKED = Machine(LASER.limits, 1000, 100, True)
WORD = re.compile(r"([A-Z])(-?\d*\.?\d+)")
pytestmark = pytest.mark.unmeasured


def run(*arguments):
    return CliRunner().invoke(app, ["--lang", "en", "engrave", *map(str, arguments)])


def said(result):
    return " ".join(f"{result.output} {result.exception or ''}".split())


def moves(lines):
    """(x before, x, y, S, rapid) of each line that moves along X, by the words of G-code alone."""
    x = y = power = 0.0
    rapid = False
    for line in lines:
        line, _, row = line.partition("S=")
        words = dict(WORD.findall(line))
        if "G" in words and words["G"] in "01":
            rapid = words["G"] == "0"
        power = float(words.get("S", power))
        before, x, y = x, float(words.get("X", x)), float(words.get("Y", y))
        powers = re.findall(r"(?<=[S:])[\d.]+", line) or [power]
        if row:
            powers = [(ord(high) - 64) * 32 + ord(low) - 64 for high, low in zip(row[::2], row[1::2])]
        for dot, burns in enumerate(powers):
            if "X" in words and before != x:
                yield *(before + (x - before) * end / len(powers) for end in (dot, dot + 1)), y, float(burns), rapid


@st.composite
def pictures(draw):
    """Powers of dots: some blank, some equal side by side."""
    width, height = draw(st.integers(1, 40)), draw(st.integers(1, 6))
    values = st.sampled_from((0.0, 0.0, 0.0, 0.1, 0.25, 1.0))
    return np.array(draw(st.lists(st.lists(values, min_size=width, max_size=width), min_size=height, max_size=height)))


@settings(max_examples=60)
@given(pictures(), st.booleans(), st.sampled_from((0.0, 0.07, -0.2)), st.sampled_from((3000, 9000)), st.sampled_from((10, 4)),
       st.sampled_from((LASER, CLUSTERS, PACKED, Machine(LASER.limits, 1, 5))))  # fmt: skip
def test_each_dot_is_burnt_once_with_its_power(powers, one_way, offset, speed, dots, machine):
    options = Options(dots_mm=dots, one_way=one_way, offset_mm=offset, speed=speed, origin=(3.0, 5.0))
    rows = engraving.rows_of(powers, options)
    if not rows:
        with pytest.raises(Failure, match="nothing burns"):
            list(engraving.gcode_lines(rows, options, machine))
        return
    lines = list(engraving.gcode_lines(rows, options, machine))
    assert max(map(len, lines)) < (235 if machine.packed else 120) and all(line.count(":") < max(1, machine.cluster) for line in lines)
    found = np.zeros_like(powers)
    for before, x, y, power, rapid in moves(lines):
        if rapid or power == 0:
            continue
        backward = x < before
        shift = 3.0 + (offset if backward else 0)
        ends = [round((end - shift) * dots, 1) for end in sorted((before, x))]
        begin, end = map(int, ends)
        assert [begin, end] == ends and not (backward and one_way)
        row = (y - 5.0) * dots - 0.5
        assert abs(row - round(row)) < 0.03
        found[round(row), begin:end] += power / machine.full
    assert np.array_equal(found, powers)


@settings(max_examples=30)
@given(st.floats(0, 1), st.sampled_from((engraving._FLOYD, engraving._JARVIS)))
def test_diffused_dots_are_as_dark_as_the_picture(darkness, way):
    dots = engraving.diffuse_dots(np.full((40, 60), darkness), *way)
    assert set(np.unique(dots)) <= {0.0, 1.0}
    assert abs(dots.mean() - darkness) < 0.04


@pytest.mark.skipif(pc_kernels.compiler_command() is None, reason="there is no C compiler for this PC")
@pytest.mark.parametrize("way", (engraving._FLOYD, engraving._JARVIS))
def test_dots_by_c_are_those_of_python(way, monkeypatch):
    """And a million of them take less than a second there: in Python seven."""
    dark = np.random.default_rng(2).random((40, 70)) * np.linspace(0, 1, 70)
    plain = engraving.diffuse_dots(dark, *way)
    monkeypatch.setenv(pc_kernels.CHOICE, "c")
    assert np.array_equal(engraving.diffuse_dots(dark, *way), plain)
    begun = time.process_time()
    dots = engraving.diffuse_dots(np.full((1000, 1000), 0.3), *way)
    assert time.process_time() - begun < 3 and abs(dots.mean() - 0.3) < 0.001


def test_the_head_has_its_speed_at_the_first_dot():
    over = engraving.overscan_length(Options(speed=9000), LASER)
    assert over >= 150**2 / (2 * 1500)
    first = next(moves(engraving.gcode_lines(engraving.rows_of(np.ones((1, 20)), Options(speed=9000)), Options(speed=9000), LASER)))
    assert first[1] == pytest.approx(-over, abs=0.001)


@pytest.mark.parametrize("machine, wants, brings", [(LASER, 800, 1700), (CLUSTERS, 1000, 5000), (PACKED, 1000, 10_000)])
def test_what_the_densest_row_wants(machine, wants, brings):
    """Each change of power is a line, or each dot of a row one of its powers; a long dot is a line in any case."""
    powers = np.array([[0.1, 0.2, 0.3, 0.3, 0.5] * 8, [0.5] * 40])
    options = Options(dots_mm=10, speed=6000)
    assert engraving.powers_s(engraving.rows_of(powers, options), options, machine) == (pytest.approx(wants), brings)


class Burnt(Sink):
    """A board whose beam burns: duty × ticks at each step of X, and rows by Y. `plate[y, x]` in steps; `outside`: beyond it."""

    def __init__(self, height, width, zero):
        super().__init__(counts=False)
        self.plate = np.zeros((height, width))
        self.outside = 0.0
        self._place = -np.array(zero)
        self.clock = 0

    def start(self):
        ring, layout = self._ring, self._layout
        while self._played != ring.head:
            at = self._played & ring.mask
            count = min((ring.head - self._played) & COUNT_MASK, ring.size - at)
            mark = ring.power.next(self._played)
            if mark >= 0:
                until = (mark - self._played) & COUNT_MASK
                if until == 0:
                    ring.power.play((mark + 1) & COUNT_MASK)
                    continue
                count = min(count, until)
            self._burn(np.array(ring.words[at : at + count], np.uint32), layout, ring.power.level)
            self._played = (self._played + count) & COUNT_MASK

    def _burn(self, words, layout, power):
        lasts = (words >> layout.bits).astype(np.int64)
        moved = [((words >> axis) & 1).astype(np.int64) * (2 * ((words >> (layout.motors + axis)) & 1).astype(np.int64) - 1) for axis in (0, 1)]
        x, y = (self._place[axis] + np.cumsum(moved[axis]) for axis in (0, 1))
        self._place = np.array([x[-1], y[-1]])
        self.clock += int(lasts.sum())
        energy = lasts * power * ((words & layout.tool_mask) != 0)
        x = x - (moved[0] > 0)  # the step's way lies below the position it ends at, or above
        inside = (x >= 0) & (x < self.plate.shape[1]) & (y >= 0) & (y < self.plate.shape[0])
        np.add.at(self.plate, (y[inside], x[inside]), energy[inside])
        self.outside += float(energy[~inside].sum())


def burn(lines, height, width, zero=(0, 0)):
    """The plate that the laser of boards/laser_xy.py leaves behind, in steps."""
    port = Burnt(height, width, zero)
    machine = App(checked(board_named("laser_xy")), port)
    for line in ("$X", *lines):
        if line == "M2":
            continue
        port.incoming += line.encode() + b"\n"
        port.outgoing = b""
        while b"ok" not in port.outgoing:
            assert b"error" not in port.outgoing, (line, port.outgoing)
            machine.cycle()
    still = 0
    while still < 40:
        machine.cycle()
        still = 0 if machine.controller.busy() else still + 1
    return port


@pytest.mark.parametrize("machine", [LASER, CLUSTERS, PACKED], ids=["plain", "cluster", "packed"])
@pytest.mark.parametrize("overscan", [None, 0.0])
def test_what_is_burnt_is_the_picture(overscan, machine):
    """From the words and the duty: each dot's energy is in proportion to its power, both directions in register to a step; in the ramps
    too, if there is no way beside the dots to gain speed on."""
    powers = np.array([[0.1, 0.2, 0.5, 0, 0, 1, 0.4, 0.4, 0, 0.1], [0.3, 0, 0.9, 0.1, 0.1, 0, 0, 0.7, 1, 1]] * 3)
    options = Options(dots_mm=10, speed=3000, power=1.0, overscan_mm=overscan)
    port = burn(engraving.gcode_lines(engraving.rows_of(powers, options), options, machine), 48, 80)
    rows = np.array([round(8 * (n + 0.5)) for n in range(6)])
    assert port.outside <= 1e-4 * port.plate.sum()  # 5 µs before the first step, in which DIR settles
    assert np.count_nonzero(port.plate.any(axis=1)) == 6
    steps = port.plate[rows]
    expected = np.repeat(powers, 8, axis=1)
    assert np.array_equal(steps > 0, expected > 0)  # to a step
    scale = steps[expected == 1].mean()
    dots = steps.reshape(6, 10, 8).sum(axis=2) / (8 * scale)
    assert np.abs(dots - powers)[powers > 0].max() <= 0.01 * powers[powers > 0].max(), np.round(dots, 3)


@pytest.mark.parametrize("shade", ["jarvis", "grey"])
def test_a_photograph_is_burnt_dot_for_dot(shade):
    """The light specks in what is dark are the picture's: nothing else is left out, in neither direction."""
    options = Options(width_mm=4, dots_mm=10, shade=shade, power=1.0)
    powers = engraving.powers_of(engraving.open_picture(cbook.get_sample_data("grace_hopper.jpg", asfileobj=False)), options)
    height, width = powers.shape
    port = burn(engraving.gcode_lines(engraving.rows_of(powers, options), options, PACKED), 8 * height, 8 * width)
    steps = port.plate[[round(8 * (n + 0.5)) for n in range(height)]]
    assert np.array_equal(steps > 0, np.repeat(powers > 0, 8, axis=1)) and np.isclose(steps.sum(), port.plate.sum())  # to a step
    dots = steps.reshape(height, width, 8).sum(axis=2)
    assert np.abs(dots / dots.max() - powers / powers.max()).max() <= 0.005


def test_a_picture_is_written_shown_and_taken_by_the_machine(tmp_path):
    picture = Image.radial_gradient("L").resize((64, 48))
    picture.save(tmp_path / "ball.png")
    done = run(tmp_path / "ball.png", "--width", 6, "--shade", "grey", "-o", tmp_path / "ball.gcode", "--preview", tmp_path / "p.png", "--frame", 1, "--air")
    assert done.exit_code == 0, said(done)
    assert "6 × 4.5 mm, 60 × 45 dots" in said(done)
    assert Image.open(tmp_path / "p.png").width > 500
    lines = (tmp_path / "ball.gcode").read_text().splitlines()
    assert lines[-1] == "M2" and "M0" in lines and "M3 S10" in lines and "M9" in lines
    checked_ = CliRunner().invoke(app, ["--lang", "en", "check", str(tmp_path / "ball.gcode"), "--board", "laser_xy"])
    assert checked_.exit_code == 0, said(checked_)


def test_the_card_comes_back_as_a_curve(tmp_path):
    """A wood that burns by the square of the power: after the curve, grey is grey."""
    options = Options(power=0.5)
    picture = engraving.draw_card(options)
    burnt = Image.fromarray((255 - 200 * (1 - np.asarray(picture, np.float64) / 255) ** 2).astype(np.uint8))
    burnt.save(tmp_path / "card.png")
    curve = engraving.read_curve(tmp_path / "card.png")
    dark = np.linspace(0, 1, 21)
    powers = engraving.powers_of_darkness(dark, Options(power=0.5, curve=curve))
    assert powers[0] == 0 and np.abs((powers / 0.5) ** 2 - dark).max() < 0.02
    (tmp_path / "card.txt").write_text("".join(f"{100 * power:g} {100 * found:g}\n" for power, found in curve))
    assert np.allclose(engraving.read_curve(tmp_path / "card.txt"), curve, atol=1e-5)


@pytest.mark.parametrize("text, arguments, error", [
    (None, ["none.png", "--width", "5"], "no file"),
    (b"no picture", ["a.png", "--width", "5"], "cannot be read as a picture"),
    (b"", ["a.png", "--width", "5"], "cannot be read as a picture"),
    ("white", ["a.png", "--width", "5"], "nothing burns"),
    ("grey", ["a.png"], "give --width or --height"),
    ("grey", ["a.png", "--width", "50000"], "too many"),
    ("grey", ["a.png", "--width", "5", "--shade", "fine"], "--shade is one of"),
    ("grey", ["a.png", "--width", "5", "--origin", "3"], "--origin wants two lengths"),
    ("grey", ["a.png", "--width", "5", "--board", "router_3axis"], "is no laser"),
    ("grey", ["a.png", "--width", "5", "--black", "60", "--white", "50"], "--black is darker"),
    ("grey", ["a.png", "--card"], "give a picture, or --card"),
])  # fmt: skip
def test_what_cannot_be_engraved_is_said(tmp_path, monkeypatch, text, arguments, error):
    monkeypatch.chdir(tmp_path)
    if isinstance(text, bytes):
        (tmp_path / "a.png").write_bytes(text)
    elif text:
        Image.new("L", (8, 8), text).save(tmp_path / "a.png")
    done = run(*arguments)
    assert done.exit_code == 1 and error in said(done), said(done)


@pytest.mark.parametrize("text, error", [("40\n", "line 1"), ("40 sixty\n", "line 1"), ("10 20\n40 160\n", "line 2"), ("# nothing\n", "no curve"), ("0 0\n10 0\n", "no curve")])
def test_a_curve_that_is_none_is_said(tmp_path, text, error):
    (tmp_path / "c.txt").write_text(text)
    with pytest.raises(Failure, match=error):
        engraving.read_curve(tmp_path / "c.txt")


def test_a_big_picture_is_read_small_or_refused(tmp_path, monkeypatch):
    """A JPEG is taken at a part of its size as it is read, any other is refused before it is read."""
    monkeypatch.setattr(engraving, "MOST_PIXELS", 100_000)
    picture = Image.linear_gradient("L").resize((800, 600))
    picture.save(tmp_path / "a.jpg")
    picture.save(tmp_path / "a.png")
    small = engraving.open_picture(tmp_path / "a.jpg")
    assert small.size == (200, 150) and abs(np.asarray(small, float) - np.asarray(picture.resize((200, 150)), float)).mean() < 3
    with pytest.raises(Failure, match="800 × 600 pixels: at most 100000"):
        engraving.open_picture(tmp_path / "a.png")


def test_a_picture_of_400_million_pixels_is_refused_by_its_size(tmp_path):
    """Pillow refuses pictures above a bound of its own; the message must still be the one about pixels."""
    Image.new("1", (20_000, 20_000)).save(tmp_path / "a.png")
    done = run(tmp_path / "a.png", "--width", "20")
    assert done.exit_code == 1 and "has 20000 × 20000 pixels: at most 20000000" in said(done), said(done)


def test_a_broken_picture_is_not_sent_to_where_it_was(tmp_path):
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(99))
    done = run(tmp_path / "a.png", "--width", "20")
    assert done.exit_code == 1 and "cannot be read as a picture" in said(done), said(done)


PEAK = """
import re, sys
from host_tools.drawings import engraving
def peak():  # that of getrusage() begins with the parent's
    return 1024 * int(re.search(r"VmHWM:\\s+(\\d+)", open("/proc/self/status").read())[1])
before = peak()
picture = engraving.open_picture(sys.argv[1])
print((peak() - before) / picture.width / picture.height)
"""


@pytest.mark.parametrize("mode, most", [("RGBA", 7), ("I;16", 7), ("L", 4)])
def test_a_big_picture_takes_a_few_bytes_a_pixel(tmp_path, mode, most):
    """Once as it is, once in grey, and a band of rows: whole copies in other modes made 14 bytes of RGBA and 21 of 16 bits."""
    Image.new(mode, (4000, 2500), 200 if mode != "RGBA" else (200, 100, 50, 120)).save(tmp_path / "a.png", compress_level=1)
    done = subprocess.run([*interpreter.python(), "-c", PEAK, str(tmp_path / "a.png")], capture_output=True, text=True, check=True)
    assert 1 < float(done.stdout) < most


@pytest.mark.parametrize("mode", ["RGBA", "LA", "P", "RGB", "L", "1"])
def test_clear_parts_of_a_picture_are_white(tmp_path, mode):
    """As alpha_composite() over white has it, within a grey level or two."""
    picture = Image.merge("RGBA", [Image.linear_gradient("L").rotate(90 * turn) for turn in range(4)]).convert(mode)
    picture.save(tmp_path / "a.png")
    clear = Image.open(tmp_path / "a.png").convert("RGBA")
    wanted = Image.alpha_composite(Image.new("RGBA", clear.size, "white"), clear).convert("L")
    assert abs(np.asarray(engraving.open_picture(tmp_path / "a.png"), int) - np.asarray(wanted, int)).max() <= 2
