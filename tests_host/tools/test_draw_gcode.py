"""`passo draw` by G-code: the pins of a laser, a router and a tool on M3 and M5; files, sending, going on."""

import collections
import itertools
import random
import re
import sys

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from running_router import Running
from test_draw import farthest_mm, page_of, sampled

from shapely import Polygon

from host_tools import boards
from host_tools.cli import draw_gcode, stream
from host_tools.cli import main as cli
from host_tools.cli.draw_options import Said
from host_tools.drawings import drawing, gcode, sources
from host_tools.drawings.drawing import Drawing, Part
from host_tools.failure import Failure
from host_tools.programs.program_lines import program_lines
from host_tools.sim.job import VirtualJob

PLACES = st.tuples(st.integers(0, 9600), st.integers(0, 6400))
LINES = st.lists(st.lists(PLACES, min_size=2, max_size=6), min_size=1, max_size=6)
CUTS = st.builds(
    gcode.Cut, st.sampled_from(gcode.TOOLS), st.sampled_from([100.0, 987.5]), st.just(200.0), st.integers(0, 900),
    st.sampled_from([0.0, 0.5, 1.7]), st.integers(1, 4), st.sampled_from([1.0, 5.0]), st.sampled_from([0.0, 0.25]),
)  # fmt: skip


def plan_of(parts, steps_per_mm=(320.0, 320.0)):
    found = [Part(number, None, lines) for number, lines in enumerate(parts, 1)]
    return Drawing("a.svg", found, steps_per_mm, 1.0, 1.0, (0, 0), (0, 0), (0, 0, 1, 1), (0, 0, 1, 1))


class Reader:
    """G-code as its tool goes: [(place, place, z, power)] of the lines that it draws. Any other motion is up or dark."""

    def __init__(self, lines, tool):
        self.drawn, self.passed = [], []
        place, z, power, rapid = (0.0, 0.0), None, 0.0, True
        for line in lines:
            words = dict(re.findall(r"([A-Z])(-?[\d.]+)", line))
            if "M" in words:
                power = 0.0 if words["M"] == "5" else float(words.get("S", 0)) if words["M"] in "34" else power
                continue
            if words.get("G") not in ("0", "1"):
                continue
            rapid = words["G"] == "0"
            if "Z" in words:
                assert not {"X", "Y"} & set(words)
                z = float(words["Z"])
                continue
            there = float(words["X"]), float(words["Y"])
            down = {"laser": not rapid, "m3": power > 0, "z": not rapid}[tool]
            assert not (rapid and down)
            if tool == "z":
                assert not rapid or z > 0
                assert rapid or z <= 0
            (self.drawn if down else self.passed).append((place, there, z, power))
            place = there


@settings(max_examples=80, deadline=None)
@given(st.lists(LINES, min_size=1, max_size=3), CUTS, st.booleans())
def test_every_line_is_drawn_in_each_pass_and_nothing_else(parts, cut, pens):
    cut = cut if cut.tool != "m3" else cut.with_values(f"power={cut.power + 1}")
    plan = plan_of(parts)
    lines = gcode.lines_of(plan, {part.number: cut for part in plan.parts}, ["M0"] if pens else None)
    reader = Reader(lines, cut.tool)
    wanted = [frozenset(pair) for part in parts for line in part for pair in zip(line, line[1:])] * cut.passes
    found = [frozenset((round(x * 320), round(y * 320)) for x, y in (a, b)) for a, b, _, _ in reader.drawn]
    assert sorted(map(sorted, wanted)) == sorted(map(sorted, found))
    if cut.tool == "z":
        depths = {round(-cut.depth * (index + 1) / cut.passes, 4) + 0.0 for index in range(cut.passes)}
        assert {z for _, _, z, _ in reader.drawn} == depths
        assert {z for _, _, z, _ in reader.passed} == {cut.lift}
    else:
        assert {power for _, _, _, power in reader.drawn} == {cut.power}
    assert lines.count("M0") == (len(parts) - 1 if pens else 0)
    assert all(len(line) < 80 for line in lines) and lines[-1] == "M30"


@pytest.mark.parametrize("board, tool", [("laser_xy", "laser"), ("router_3axis", "z"), ("router_3axis", "m3")])
def test_the_pins_draw_the_drawing(tmp_path, board, tool):
    """Through the firmware, each step: the tool is on along the drawing's lines, all of them, and nowhere else."""
    chance = random.Random(board)
    body = "".join(
        f'<path fill="none" stroke="black" d="M{chance.uniform(5, 95):.2f} {chance.uniform(5, 95):.2f}'
        f'q{chance.uniform(-5, 5):.2f} {chance.uniform(-5, 5):.2f} {chance.uniform(-5, 5):.2f} {chance.uniform(-5, 5):.2f}"/>'
        for _ in range(12)
    )
    machine = boards.load(board)
    plan = drawing.load(page_of(tmp_path, 100, 100, body), machine, drawing.Options(fit=True))
    said = Said(tmp_path, tool=tool, feed=3000.0, depth=0.5, passes=2)
    lines = gcode.lines_of(plan, draw_gcode.cuts_of_parts(machine, plan, said))
    job = VirtualJob(board, inside=True)
    if tool == "m3":
        job.track.by_height = False
    job.run(list(program_lines(line.encode() for line in lines)))
    assert not job.errors
    wanted = [numpy.array(line) / plan.steps_per_mm for line in plan.lines]
    drawn = [numpy.array(places)[:, :2] for on, places in job.track.strokes if on and len(places) > 1]
    assert farthest_mm(numpy.concatenate([sampled(line, 0.5) for line in wanted]), drawn) < 0.2
    assert farthest_mm(numpy.concatenate([sampled(line, 0.5) for line in drawn]), wanted) < 0.2
    length = sum(numpy.hypot(*numpy.diff(line, axis=0).T).sum() for line in wanted)
    inked = sum(numpy.hypot(*numpy.diff(line, axis=0).T).sum() for line in drawn)
    assert inked == pytest.approx(2 * length, rel=0.01)


def command(monkeypatch, capsys, *words):
    """(what `passo draw` said, its exit status)."""
    monkeypatch.setattr(sys, "argv", ["passo", "draw", *map(str, words)])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    said = capsys.readouterr()
    return said.out + said.err, ended.value.code or 0


def layered(tmp_path, name="two.svg"):
    """Two layers."""
    path = tmp_path / name
    body = '<g id="layer1"><path d="M10 10 h30"/></g><g id="layer2"><path d="M10 20 h30"/></g>'
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="50mm" viewBox="0 0 100 50" stroke="black">{body}</svg>')
    return path


def test_layers_have_their_own_figures_and_a_file_is_what_check_takes(tmp_path, monkeypatch, capsys):
    path, out = layered(tmp_path, "two (é).svg"), tmp_path / "two.gcode"
    said, status = command(
        monkeypatch, capsys, path, "--board", "router_3axis", "--depth", 1, "--passes", 2, "--for", "2:feed=150,depth=0.3,passes=1", "-o", out
    )
    assert not status and "layer 1: tool on Z, F600, 1 mm deep in 2 passes" in said and "layer 2: tool on Z, F150, 0.3 mm" in said
    text = out.read_text()
    assert [float(z) for z in re.findall(r"G1 Z(\S+)", text)] == [-0.5, -1, -0.3]
    assert re.findall(r"G1 X\S+ Y\S+ F(\S+)", text) == ["600", "600", "150"]
    monkeypatch.setattr(sys, "argv", ["passo", "check", str(out), "--board", "router_3axis"])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert not ended.value.code and re.search(r"Z +-1.000 … +2.000 mm", capsys.readouterr().out)


@pytest.mark.parametrize("words, message", [
    (["--tool", "knife"], "--tool takes laser, z, m3, not 'knife'"),
    (["--feed", 0], "feed: 0 cannot be"),
    (["--passes", 0], "passes: 0 cannot be"),
    (["--depth", "nan"], "depth: nan cannot be"),
    (["--for", "2"], "--for wants LAYER:NAME=NUMBER"),
    (["--for", "7:feed=1"], "there is no layer 7; it has 1, 2"),
    (["--for", "2:speed=1"], "'speed=1' is no setting of a layer"),
    (["--tool", "m3", "--power", 0], "M3 S0 leaves the tool up"),
    (["--for", "2:feed=-1"], "feed: -1 cannot be"),
    (["-o", "/nowhere/a.gcode"], "cannot write /nowhere/a.gcode"),
])
def test_figures_that_cannot_be(tmp_path, monkeypatch, capsys, words, message):
    said, status = command(monkeypatch, capsys, layered(tmp_path), "--board", "laser_xy", "--dry-run" if words[0] != "-o" else "--center", *words)
    assert status == 1 and message in said


def test_a_file_is_written_for_boards_that_speak_neither(tmp_path, monkeypatch, capsys):
    path, out = layered(tmp_path), tmp_path / "a.gcode"
    assert command(monkeypatch, capsys, path, "--board", "lpt_router", "-o", out)[1] == 0
    assert "G1 X40 Y40" in out.read_text() or "G1 X10 Y40" in out.read_text()


@pytest.mark.parametrize("more", [
    (), *(pytest.param(more, marks=pytest.mark.slow)
          for more in (("--copies", "1x2", "--scale", "0.4", "--hatch", "0,3"), ("--repeat", "2", "--passes", "2", "--marks")))])  # fmt: skip
def test_sent_broken_off_and_gone_on_with(tmp_path, monkeypatch, capsys, more):
    """Each line is cut once, but for the one amid which it was broken off."""
    body = "".join(f'<path d="M5 {y} h20"/>' for y in range(5, 35, 3))
    path = page_of(tmp_path, 40, 40, body)
    journal = path.with_name("page.svg.journal")

    def drawn(mode, *words):
        with Running(mode) as running:
            options = ("--board", "router_3axis", "--port", running.line.name, "--feed", 3000, "--depth", 1, "--lift", 0)
            return *command(monkeypatch, capsys, path, *options, *more, *words), running.position()[:2]

    said, status, where = drawn("fast")
    assert not status and "drawn in" in said and where == [0, 0] and not journal.exists(), said
    plain = stream.Panel.poll_keys

    def broken(panel):
        plain(panel)
        if panel._line >= 8:
            raise KeyboardInterrupt

    with monkeypatch.context() as changed:
        changed.setattr(stream.Panel, "poll_keys", broken)
        said, status, _ = drawn("real")  # fast time leaps over the line
    assert status == 1 and "aborted at line" in said and "and --continue" in said and journal.exists(), said
    said, status, _ = drawn("fast", "--continue")
    assert status == 1 and "nobody can be asked" in said
    said, status, where = drawn("fast", "--continue", "--yes")
    assert not status and "drawn in" in said and where == [0, 0], said
    said, status, _ = drawn("fast", "--continue")
    assert status == 1 and "nothing to continue" in said


def pens_page(tmp_path):
    """Three colours, three lines each."""
    colours = enumerate(("red", "blue", "green"))
    body = "".join(f'<path stroke="{colour}" d="M5 {y} h10"/>' for n, colour in colours for y in range(5 + n, 35, 10))
    return page_of(tmp_path, 40, 40, body)


def rows_of(running, first, end):
    """Return {y in whole mm: number of steps} that a tool below Z0, or a lit laser, drew from one step to another."""
    world = running.world
    _, zero_y, zero_z = (place - position for place, position in zip(world.place, running.position()))
    rows = zip(world.path[first:], world.path[first + 1 : end], world.burnt[first + 1 : end])
    lit = [round((y - zero_y) / 320) for before, (_, x, y, z, _), (*_, power) in rows if (z < zero_z or power) and x != before[1]]
    return collections.Counter(lit)


LASER = {"spindle": {**boards.load("router_3axis")["spindle"], "laser": True}}
PENS = [{35, 25, 15}, {34, 24, 14}, {33, 23, 13}]  # y of the lines of each


@pytest.mark.parametrize("changes, tool", [({}, ("--depth", 1, "--lift", 0)), (LASER, ("--tool", "laser", "--power", 300))])
def test_broken_off_behind_and_at_a_pens_change(tmp_path, monkeypatch, capsys, changes, tool):
    """Broken off by pen 2, then while it waits for pen 3: the pen that draws on is named, the one that is missing is asked for again, and
    each line is drawn by its pen."""
    path = pens_page(tmp_path)
    plain = stream.Panel.poll_keys
    drawn = [collections.Counter() for _ in PENS]

    def run(ends, pen, *more):
        """Return (the text shown, the pens asked for). `ends(panel, pen)`: whether to break off; `pen`: that the machine has."""
        asked = []

        def cycle(panel):
            plain(panel)
            text = panel.progress_text()
            waits = re.search(r"put in pen (\d)", text)
            if waits and panel._paused_at is not None and running.standing() and int(waits[1]) not in asked:
                asked.append(int(waits[1]))
                steps.append(len(running.world.path))
            if ends(panel, asked[-1] if asked else pen):
                raise KeyboardInterrupt
            if panel._paused_at is not None and running.standing():
                panel.press_key("r")

        steps = []
        with monkeypatch.context() as changed, Running("real", **changes) as running:
            changed.setattr(stream.Panel, "poll_keys", cycle)
            running.world.path, running.world.burnt = [], []
            said, _ = command(monkeypatch, capsys, path, *options, "--port", running.line.name, *more)
            for number, (first, end) in enumerate(itertools.pairwise([0, *steps, len(running.world.path)])):
                drawn[([pen, *asked][number]) - 1] += rows_of(running, first, end)
        return said, asked

    options = ("--board", "router_3axis", "--feed", 6000, "--unlock", *tool, "--pens", "colours")
    lines = written(monkeypatch, capsys, path, *options)
    third = lines.index("(pen 3)") + 1
    motions = [number for number, line in enumerate(lines, 1) if line.startswith("G1 X")]
    amid = [number for number in motions if number < third][-2]  # pen 2's last but one
    said, asked = run(lambda panel, pen: panel._line >= amid, 1)
    assert asked == [2] and f"aborted at line {amid}" in said and "put in" not in said.splitlines()[-1]
    assert "put in pen 2 (blue): the machine waits" in said and "nobody can press a key here" in said
    said, asked = run(lambda panel, pen: pen == 3, 2, "--continue", "--yes")
    assert asked == [3] and "pen 2 (blue) draws on" in said and "put in pen 3 (green)" in said.splitlines()[-1]
    said, asked = run(lambda panel, pen: False, 2, "--continue", "--yes")
    assert asked == [3] and "draws on" not in said and "drawn in" in said
    whole = 10 * 320
    assert [set(rows) for rows in drawn] == PENS
    # A laser's first steps are dark; the line that was broken off, at its end if the PC was slow, is drawn anew from its start.
    assert all(0.9 * whole < steps <= 2 * whole for rows in drawn for steps in rows.values()), drawn
    assert sum(sum(rows.values()) for rows in drawn) <= sum(len(rows) + 1 for rows in drawn) * whole, drawn
    assert sum(steps > whole for rows in drawn for steps in rows.values()) <= 1, drawn  # the one amid which it was broken off


def written(monkeypatch, capsys, path, *options):
    """The lines that are sent."""
    out = path.with_suffix(".gcode")
    command(monkeypatch, capsys, path, *options, "-o", out)
    return out.read_text().splitlines()[1:]


def test_a_board_file_decides_the_tool():
    tools = {name: gcode.usual_cut(boards.load(name)).tool for name in ("laser_xy", "router_3axis", "mill_2004", "plotter_2014")}
    assert tools == {"laser_xy": "laser", "router_3axis": "z", "mill_2004": "z", "plotter_2014": "m3"}
    with pytest.raises(Failure):
        gcode.Cut("z").with_values("passes=two")


@settings(max_examples=40, deadline=None)
@given(st.lists(LINES, min_size=1, max_size=2), CUTS)
def test_g_code_is_a_drawing_again(tmp_path_factory, parts, cut):
    cut = cut.with_values(f"power={cut.power + 1}")
    plan = plan_of(parts)
    path = tmp_path_factory.mktemp("again") / "a.gcode"
    path.write_text("\n".join(gcode.lines_of(plan, {part.number: cut for part in plan.parts})))
    wanted = {frozenset(pair) for part in parts for line in part for pair in zip(line, line[1:]) if pair[0] != pair[1]}
    if not wanted:
        return
    (lines,) = sources.open_drawing(path).outlines(0.1).layers.values()
    left = min(x for pair in wanted for x, _ in pair)
    top = max(y for pair in wanted for _, y in pair)
    found = [[(left + round(p.real * 25.4 / 96 * 320), top - round(p.imag * 25.4 / 96 * 320)) for p in line] for line in lines]
    assert {frozenset(pair) for line in found for pair in zip(line, line[1:])} == wanted


def test_arcs_and_cycles_of_g_code(tmp_path):
    path = tmp_path / "a.ngc"
    path.write_text("G21 G90\nM3 S100\nG0 X10 Y0\nG3 X-10 Y0 I-10 J0 F100\nM5\nG1 X50\n")
    (line,) = sources.open_drawing(path).outlines(0.1).layers[1]
    middle = complex(10, 10) * 96 / 25.4
    assert abs(abs(line - middle) - 10 * 96 / 25.4).max() < 0.05
    path.write_text("G0 X10\nG0 Y3\n")
    with pytest.raises(Failure, match="draws nothing"):
        sources.open_drawing(path)


def test_a_pen_a_layer_waits_and_says_which(tmp_path, monkeypatch, capsys):
    out = tmp_path / "a.gcode"
    path = layered(tmp_path)
    assert command(monkeypatch, capsys, path, "--board", "laser_xy", "--pens", "layers", "--change", "M6 T{};G4 P1", "-o", out)[1] == 0
    lines = out.read_text().splitlines()
    at = lines.index("M6 T2")
    assert lines[at - 2 : at + 3] == ["M5", "(pen 2)", "M6 T2", "G4 P1", "M4 S300"]
    running = Running("fast")
    try:
        monkeypatch.setattr(stream.Panel, "poll_keys", answered(stream.Panel.poll_keys, told := []))
        where = ["--board", "router_3axis", "--port", running.line.name, "--feed", 3000, "--lift", 0, "--pens", "layers"]
        said, status = command(monkeypatch, capsys, path, *where)
        assert not status and any("put in pen 2 (layer2)" in each for each in told), told[-3:]
    finally:
        running.close()


def answered(plain, told):
    """A Panel's poll_keys() that presses r at each pause."""

    def cycle(panel):
        plain(panel)
        if panel._paused_at is not None:
            told.append(panel.progress_text())
            panel.press_key("r")

    return cycle


@pytest.mark.parametrize("words, message", [
    (["--copies", "3"], "--copies wants COLUMNSxROWS"), (["--copies", "900x900"], "--copies wants"),
    (["--copies", "9x9"], "the drawing with its copies"), (["--pens", "three"], "--pens takes none, layers or colours"),
    (["--hatch", "45"], "--hatch wants"),
])
def test_layouts_that_cannot_be(tmp_path, monkeypatch, capsys, words, message):
    said, status = command(monkeypatch, capsys, layered(tmp_path), "--dry-run", *words)
    assert status == 1 and message in said


def test_packets_do_not_wait_for_pens(tmp_path, monkeypatch, capsys):
    said, status = command(monkeypatch, capsys, layered(tmp_path), "--pens", "layers", "-o", tmp_path / "a")
    assert status == 1 and "cannot wait for a pen's change" in said


def ink_of(plan):
    return sorted(tuple(sorted(pair)) for line in plan.lines for pair in zip(line, line[1:]))


def test_copies_repeats_marks_and_colours(tmp_path):
    board = boards.load("plotter_2014")
    path = layered(tmp_path)
    plain = ink_of(drawing.load(path, board))
    copied = ink_of(drawing.load(path, board, drawing.Options(copies="2x3", gap=2.0)))
    shifted = [tuple(sorted((x + dx, y + dy) for x, y in pair)) for dx in (0, 1020) for dy in (0, 520, 1040) for pair in plain]
    assert copied == sorted(shifted)
    assert ink_of(drawing.load(path, board, drawing.Options(repeat=3))) == sorted(3 * plain)
    marked = drawing.load(path, board, drawing.Options(marks=True, origin=(50, 50)))
    assert [len(part.lines) for part in marked.parts] == [9, 9]
    assert [part.lines for part in marked.parts] != [part.lines for part in drawing.load(path, board).parts]
    path.write_text('<svg xmlns="http://www.w3.org/2000/svg" width="99mm" height="99mm" fill="none">' + "".join(
        f'<path stroke="{colour}" d="M{x} 9v40"/>' for x, colour in enumerate(["red", "blue", "red"], 1)) + "</svg>")
    parts = drawing.load(path, board, drawing.Options(pens="colours")).parts
    assert [(part.number, part.name, len(part.lines)) for part in parts] == [(1, "red", 2), (2, "blue", 1)]


def test_several_drawings_keep_their_gap(tmp_path):
    board = boards.load("plotter_2014")
    paths = []
    for number in range(6):
        path = tmp_path / f"{number}.svg"
        path.write_text('<svg xmlns="http://www.w3.org/2000/svg" width="80mm" height="80mm" viewBox="0 0 80 80"><path fill="none" stroke="black" d="M0 0h80v20h-60v60h-20z"/></svg>')
        paths.append(path)
    plan = drawing.load(paths, board, drawing.Options(gap=4.0))
    shapes = [Polygon([(x / 10, y / 10) for x, y in line]) for line in plan.lines]
    assert len(shapes) == 6 and all(a.distance(b) >= 3.9 for index, a in enumerate(shapes) for b in shapes[:index])
    assert any("6 drawings on one sheet" in note for note in plan.notes)
    with pytest.raises(Failure, match="no room on the sheet"):
        drawing.load(paths * 4, board)


def test_the_order_of_the_file_is_kept(tmp_path):
    board = boards.load("plotter_2014")
    path = page_of(tmp_path, 100, 100, "".join(f'<path d="M{x} 10v50"/>' for x in (90, 10, 80, 20)))
    kept = drawing.load(path, board, drawing.Options(keep_order=True))
    assert [line[0][0] for line in kept.lines] == [900, 100, 800, 200] and kept.lengths_mm()[1] == pytest.approx(kept.before_mm, rel=0.01)
    short = drawing.load(path, board)
    assert short.lengths_mm()[1] < 0.6 * short.before_mm


def test_pictures_in_the_terminal_and_as_svg(tmp_path, monkeypatch, capsys):
    path = layered(tmp_path)
    monkeypatch.setenv("COLUMNS", "60")
    said, status = command(monkeypatch, capsys, path, "--dry-run", "--preview", "-")
    rows = [row for row in said.splitlines() if row and 0x2800 <= ord(row[0]) < 0x2900]
    assert not status and len(rows) > 5 and max(map(len, rows)) <= 60
    again = tmp_path / "again.svg"
    assert command(monkeypatch, capsys, path, "--dry-run", "--preview", again)[1] == 0
    board = boards.load("plotter_2014")
    assert ink_of(drawing.load(again, board)) == ink_of(drawing.load(path, board))
