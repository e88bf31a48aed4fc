"""Arcs of compiled programs: as many as the program has, and each turns as far as its words say, whole turns above all.

The sweep of a program's arc is known here from the way the program is made. The sweep of a listing's arc is the one that the firmware's parser and its rule for
whole turns compute from the listing's numbers.
"""

import json
import math
import random
import shutil
import subprocess

import pytest

from host_tools.programs import compiler, gcode_time, replay
from host_tools.programs.listing import Listing
from host_tools.programs.ngc import interpreter as ngc
from host_tools.programs.num import interpreter as num
from host_tools.programs.replay_machine import Machine
from host_tools.programs.tool_table import Tool
from host_tools.resources import FIRMWARE
from passo import commands
from passo.motion.circle import turns_off

PAGE = FIRMWARE / "passo" / "web" / "page"
PLANES = {17: "XYZIJ", 18: "ZXYKI", 19: "YZXJK"}
SCALES = ([250.0, 250.0, 400.0], [320.0, 320.0, 320.0], [133.333, 133.333, 133.333])


def swept(lines, scale=SCALES[0]):
    """Return the radians of each arc of plain G-code, as a machine with `scale` steps/mm turns."""
    machine = replay.Replay(Machine(list(scale), 0.0, False, False, 1000.0), list(enumerate(lines, 1)))
    angles = []
    for index in range(len(lines)):
        before = list(machine._board.target)
        for made in machine._interpret_line(index):
            if made.kind == commands.ARC:
                unit = scale[made.second], scale[made.first]
                spoke = [-by * each for by, each in zip(made.centre, unit)]
                end = [(made.target[axis] - before[axis] - by) * each for axis, by, each in zip((made.first, made.second), made.centre, unit)]
                cross, dot = spoke[0] * end[1] - spoke[1] * end[0], spoke[0] * end[0] + spoke[1] * end[1]
                cross = -cross if made.clockwise else cross
                angle = math.atan2(cross, dot) % math.tau or math.tau
                angles.append(angle + math.tau * (made.turns - 1 + turns_off(cross, dot, made.over_half)))
            if made.target is not None:
                machine._board.target = list(made.target)
    return angles


def compiled(dialect, text, tools=None):
    listing = Listing()
    (ngc if dialect == "ngc" else num).compile_program("p", text, listing, tools or {})
    return [line for _, line in listing.lines()]


def place(draw, inches):
    """A coordinate's words, as programs have them: by 3 to 6 decimals, or by a quarter."""
    size = 4 if inches else 100
    return draw.choice((f"{draw.uniform(-size, size):.{draw.randint(3, 6)}f}", f"{draw.randint(-4 * size, 4 * size) / 4:g}"))


def circle(draw, dialect, inches, plane):
    """(program, radians) of a whole turn or a helix, its end said or left out."""
    first, second, third, i, j = PLANES[plane]
    x, y = place(draw, inches), place(draw, inches)
    radius, angle = draw.uniform(0.01, 1 if inches else 25), draw.choice((0, 90, 180, 270, draw.uniform(0, 360)))
    across, along = (f"{radius * by(math.radians(angle)):.{draw.randint(4, 6)}f}" for by in (math.cos, math.sin))
    turns = draw.choice((1, 1, 2, 7)) if dialect == "ngc" else 1
    word = draw.choice("23")
    rows = [f"G{(20 if inches else 21) if dialect == 'ngc' else 70 if inches else 71} G90 G{plane} F100", f"G0 {first}{x} {second}{y} {third}0"]
    if dialect == "num":
        across, along = f"{float(x) + float(across):.6f}", f"{float(y) + float(along):.6f}"
    end = draw.choice((f"{first}{x} {second}{y}", first + x, "" if dialect == "ngc" else second + y))
    rise = draw.choice(("", f" {third}-{draw.uniform(0.1, 3):.3f}"))
    row = f"G{word} {end} {i}{across} {j}{along}{rise}"
    rows.append(row + f" P{turns}" if turns > 1 else row)
    if dialect == "ngc" and draw.random() < 0.3:  # the same by parameters, and relative
        rows[1] = f"#1={x}\n#2={y}\nG0 {first}#1 {second}#2 {third}0"
        rows[-1] = "G91 " + rows[-1].replace(end, f"{first}0", 1) if end else rows[-1]
    return "\n".join(rows), math.tau * turns


@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("inches", [False, True])
@pytest.mark.parametrize("dialect", ["ngc", "num"])
def test_every_circle_is_a_whole_turn(dialect, inches, plane):
    """200 circles and helices each: none is lost, none turns twice."""
    draw = random.Random(f"{dialect}{inches}{plane}")
    for each in range(200):
        text, wanted = circle(draw, dialect, inches, plane)
        found = swept(compiled(dialect, text), SCALES[each % 3])
        assert found == [pytest.approx(wanted, abs=0.02)], text


def test_the_words_decide():
    """The ends of arcs nearly whole and nearly nothing, in every rounding: 3000, by I J and by R."""
    draw = random.Random(5)
    for each in range(3000):
        radius = 10 ** draw.uniform(-0.5, 2)
        begin, gap = draw.uniform(-math.pi, math.pi), 10 ** draw.uniform(-6.2, -1) * draw.choice((1, -1))
        x, y = draw.uniform(-50, 50), draw.uniform(-50, 50)
        end = [at + radius * (by(begin + gap) - by(begin)) for at, by in ((x, math.cos), (y, math.sin))]
        clockwise = draw.random() < 0.5
        by_radius = each % 3 == 0
        centre = f"R{'-' if (gap > 0) == clockwise else ''}{radius!r}" if by_radius else f"I{-radius * math.cos(begin):.9f} J{-radius * math.sin(begin):.9f}"
        text = f"F100\nG0 X{x:.9f} Y{y:.9f} Z0\nG{2 if clockwise else 3} X{end[0]:.9f} Y{end[1]:.9f} {centre} Z-1"
        wanted = abs(gap) if (gap > 0) != clockwise else math.tau - abs(gap)
        found = swept(compiled("ngc", text), SCALES[each % 3])
        slack = 0.02 + 0.02 / radius
        if wanted > math.pi:
            assert found == [pytest.approx(wanted, abs=slack)], text
        else:  # a line, if it is very short
            assert found == [] or found == [pytest.approx(wanted, abs=slack)], text


def test_compensated_bores():
    """300 bores and bosses, beside a whole turn: one whole turn each, of the radius less or more the tool's."""
    draw = random.Random(9)
    for each in range(300):
        radius, tool = draw.uniform(4, 30), draw.uniform(0.2, 3.5)
        x, y, angle = draw.uniform(-50, 50), draw.uniform(-50, 50), draw.uniform(0, math.tau)
        inside, code = draw.random() < 0.5, draw.choice((41, 42))
        clockwise = (code == 42) == inside
        unit = complex(math.cos(angle), math.sin(angle))
        start = complex(x, y) + radius * unit
        way_in = start + unit * (tool + 0.3) * (-1 if inside else 1)
        words = f"X{start.real:.6f} Y{start.imag:.6f}"
        centre = f"I{-radius * unit.real:.6f} J{-radius * unit.imag:.6f}"
        if each % 2:
            centre = f"I{x:.6f} J{y:.6f}"
        turn = f"G{2 if clockwise else 3}"
        text = f"G90 F100\nG0 X{way_in.real:.6f} Y{way_in.imag:.6f}\nG{code} D1 G1 {words}\n{turn} {words} {centre}\nG40 G1 X{way_in.real:.6f} Y{way_in.imag:.6f}"
        lines = compiled("num" if each % 2 else "ngc", text, {1: Tool(2 * tool)})
        assert swept(lines, SCALES[each % 3]) == [pytest.approx(math.tau, abs=0.02)], text


def test_no_whole_turn_out_of_nothing():
    """The rest of an arc that inside corners have cut off, and a corner's arc of next to nothing, are no whole turns."""
    draw = random.Random(3)
    for _ in range(200):
        corner = 10 ** draw.uniform(-9, -2)
        rows = ["G0 X-10 Y-5 Z0", "G41 D1 G1 X0 Y0 F100", "X10", f"G3 X20 Y10 R{10 + corner:.9f}", "G1 Y20"]
        found = swept(compiled("ngc", "\n".join([*rows, "G40 X0 Y30"]), {1: Tool(4.0)}))
        assert all(angle < 3.5 for angle in found), rows


def test_every_road_reads_the_same(tmp_path):
    """stream and check send the lines that compile writes, and with --tools a plain file, too; and each takes the circle's time."""
    draw = random.Random(2)
    for each in range(20):
        text, wanted = circle(draw, "ngc", bool(each % 2), 17)
        source = tmp_path / f"p{each}.ngc"
        source.write_text(text)
        table = tmp_path / "tools.tbl"
        table.write_text("T1 P1 D6.0 Z40 ;mill\n")
        program = compiler.read(source, "ngc", table)
        sent = [line for _, line in program.rows()]
        assert swept(sent) == [pytest.approx(wanted, abs=0.02)]
        out = tmp_path / "out.gcode"
        out.write_text(program.listing.text(program.texts))
        assert swept([line for _, line in compiler.read(out).rows()]) == [pytest.approx(wanted, abs=0.02)]
        times = gcode_time.estimate_seconds(list(program.rows()), gcode_time.Limits([1000.0] * 4, [1e9] * 4))
        stroke = next(stroke for stroke in program.listing.strokes if len(stroke.points) > 2)
        way = sum(map(math.dist, stroke.points, stroke.points[1:]))
        feed = 100 * (25.4 if each % 2 else 1)
        assert max(times) == pytest.approx(way / feed * 60, rel=0.02)


def test_a_stream_that_begins_at_a_circle_has_it():
    """--from, at places between steps: the machine is led to where the program stands, not to the step beside it."""
    draw = random.Random(4)
    for each in range(60):
        x, y, scale = draw.uniform(-9, 9), draw.uniform(-9, 9), SCALES[each % 3]
        program = ["G90G21", f"G0X{x:.6f}Y{y:.6f}", "G1Z-1F100", f"G{draw.choice('23')}X{x:.6f}Y{y:.6f}J0.5", "G0Z1"]
        lines = list(enumerate([line.encode() for line in program], 1))
        stages, rest = replay.Replay(Machine(list(scale), 0.0, False, False, 1000.0), lines).from_line(4)
        sent = [line.encode() for _, each in stages for line in each] + [line for _, line in rest]
        assert swept(sent, scale) == [pytest.approx(math.tau, abs=0.02)], sent


@pytest.mark.skipif(not shutil.which("node"), reason="node is not installed")
def test_the_picture_of_the_page_has_them(tmp_path):
    """Circles from every side, both ways, on the page's canvas: as long as they are."""
    for name in ("gcode_path.js", "program.js"):
        shutil.copy(PAGE / name, tmp_path)
    (tmp_path / "package.json").write_text('{"type": "module"}')
    starts = [(5, 0), (-5, 0), (0, 5), (0, -5), (3, 4), (-3.3, 4.1)]
    programs = [f"G0 X1 Y1\nG1 X1 F100\n{word} X1 Y1 I{i} J{j}" for i, j in starts for word in ("G2", "G3")]
    (tmp_path / "run.mjs").write_text(
        f"import {{ read }} from './gcode_path.js';\nconsole.log(JSON.stringify({programs}.map((text) => read(text).at(-1).points)));"
    )
    run = subprocess.run(["node", tmp_path / "run.mjs"], capture_output=True, text=True, timeout=60, check=True)
    for points, (i, j) in zip(json.loads(run.stdout), [each for each in starts for _ in range(2)]):
        assert sum(map(math.dist, points, points[1:])) == pytest.approx(math.tau * math.hypot(i, j), rel=0.05)


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("rs274"), reason="LinuxCNC's interpreter rs274 is not installed")
def test_linuxcnc_has_as_many_turns(tmp_path):
    """The same circles through LinuxCNC's own interpreter (Debian: linuxcnc-uspace): as many arcs, of as many turns."""
    draw = random.Random(11)
    parameters = tmp_path / "rs274.var"
    for inches in (False, True):
        for plane in PLANES:
            rows, wanted = [], []
            for _ in range(200):
                text, angle = circle(draw, "ngc", inches, plane)
                rows += [text, "G90"]
                wanted.append(round(angle / math.tau))
            program = tmp_path / "p.ngc"
            program.write_text("\n".join([*rows, "M2", ""]))
            parameters.write_text("".join(f"{number} 0\n" for number in (*range(5161, 5170), *range(5181, 5190), *range(5210, 5220), 5220)))
            made = subprocess.run(["rs274", "-v", str(parameters), "-g", str(program)], capture_output=True, text=True, timeout=120, stdin=subprocess.DEVNULL)
            arcs = [row.split("ARC_FEED(")[1].rstrip(")").split(", ") for row in made.stdout.splitlines() if "ARC_FEED(" in row]
            assert [abs(int(arc[4])) for arc in arcs] == wanted, made.stderr
            assert [round(angle / math.tau) for angle in swept(compiled("ngc", "\n".join(rows)))] == wanted
