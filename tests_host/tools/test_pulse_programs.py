"""Pulse files as G-code and back, recognised shapes, and files far longer than a board's memory."""

import csv
import random

import numpy as np
import pytest

from host_tools import boards
from host_tools.cli.pulses_stream import play_long
from host_tools.clients.pulses import PulsesClient
from host_tools.failure import Failure
from host_tools.programs import pulse_file, pulse_gcode, pulse_shapes
from host_tools.programs.program_lines import strip_line
from host_tools.programs.long_pulses import LongFile
from host_tools.programs.pulse_gcode import moves_of, same_steps, to_gcode
from host_tools.programs.recognition import pieces
from passo.config.boardfile import check
from test_board_command import Board
from test_pulses_command import passo

BOARD = check(boards.load("lpt_router"))
CONFIG = BOARD["step_program"]


def items(text):
    return pulse_file.read_items(text if isinstance(text, bytes) else text.encode(), "xyz", CONFIG)


def of_gcode(text):
    """Return the items that the converter makes of G-code."""
    lines = [(number, strip_line(line)) for number, line in enumerate(text.encode().splitlines(), 1)]
    return items(pulse_file.Converter(BOARD).convert([row for row in lines if row[1]]))


def back_and_forth(found):
    """(G-code's moves without marks, counts); its steps are those of `found`, as read by another way than to_gcode()'s own."""
    text, counts = to_gcode(found, BOARD)
    again = of_gcode(text)
    walk = [moves_of([item for item in some if item & 15], 3) for some in (found, again)]
    assert np.array_equal(*walk)
    return [line for line in text.splitlines() if line[:3] in ("G0 ", "G1 ", "G2 ", "G3 ")], counts


@pytest.mark.parametrize("shape, sides", [("square", 4), ("triangle", 3), ("hexagon", 6), ("octagon", 8)])
def test_the_document_s_shapes_are_their_sides(shape, sides):
    moves, counts = back_and_forth(items(pulse_shapes.shape_text(shape, 80)))
    assert counts["lines"] == sides and counts["arcs"] == 0
    corners = pulse_shapes.SHAPES[shape]
    x, y = corners[0]
    where = [0.0, 0.0]
    for move, (to_x, to_y) in zip(moves, (*corners[1:], corners[0]), strict=True):
        words = {word[0]: float(word[1:]) for word in move.split()[1:]}
        where = [words.get("X", where[0]), words.get("Y", where[1])]
        assert where == [(to_x - x) * 10, (to_y - y) * 10]


@pytest.mark.parametrize("arc, found", [
    ("G2X10Y0I5J0", "G2 X10 Y0 I5 J0"), ("G3X10Y0I5J0", "G3 X10 Y0 I5 J0"), ("G2X0Y0I7.3J2.1", "G2 X0 Y0 I7.3 J2.1"),
    ("G3X0Y0I-25J0", "G3 X0 Y0 I-25 J0"), ("G3X4Y4I0J4", "G3 X4 Y4 I0 J4"), ("G2X2.5Y2.5I2.5J0", "G2 X2.5 Y2.5 I2.5 J0"),
    ("G3X60Y60I0J60", "G3 X60 Y60 I0 J60"), ("G18G3X6Z0I3K0", "G3 X6 Z0 I3 K0"), ("G19G2Y0Z6J0K3", "G2 Y0 Z6 J0 K3"),
])  # fmt: skip
def test_arcs_are_arcs_and_nothing_else(arc, found):
    moves, counts = back_and_forth(of_gcode("F600\n" + arc))
    assert counts["arcs"] == 1 and counts["lines"] == 0
    assert moves == [found + " F600"]


def test_a_contour_of_both():
    program = "F600\nG1X30\nG3X40Y10I0J10\nG1Y25\nG3X30Y35I-10J0\nG1X10\nG2X0Y25I-10J0\nG1X0Y0"
    moves, counts = back_and_forth(of_gcode(program))
    assert (counts["lines"], counts["arcs"]) == (4, 3)
    assert [move.split()[0] for move in moves] == ["G1", "G3", "G1", "G3", "G1", "G2", "G1"]


def test_any_polygon_has_as_many_lines_as_sides_or_fewer():
    """Sides of any direction, in three axes. A side that is not taken as such would leave more lines."""
    rng = random.Random(4)
    for _ in range(10):
        corners = [[rng.randrange(-3000, 3000) for _ in range(3)] for _ in range(6)]
        lines = [f"G1X{x / 80}Y{y / 80}Z{z / 80}F900" for x, y, z in corners]
        _, counts = back_and_forth(of_gcode("\n".join(lines)))
        assert counts["lines"] <= 6 and counts["arcs"] == 0


def test_random_steps_come_back_as_they_were():
    rng = random.Random(8)
    for _ in range(12):
        letters = "".join(rng.choice("ABCDEFGHIJKLMNOPQRSTUVWXYZ") * rng.choice((1, 1, 2, 40)) for _ in range(60))
        back_and_forth(items(letters))


def test_marks_keep_their_places():
    found = items("[+900(AAAA*250BB)$CCCC@DD+0EE]")
    text, _ = to_gcode(found, BOARD)
    assert [line for line in text.splitlines() if line != "G21 G90 G94 G17"] == [
        "(drives on)", "M3 S1000", "G1 X0.05 F900", "G4 P0.25", "G1 X0.025", "M5", "G0 Y0.05", "G1 Y0.025 F1200", "M0",
        "G1 Z0.025", "(drives off)", "M2",
    ]  # fmt: skip
    with pytest.raises(Failure, match="no step"):
        to_gcode(items("[]"), BOARD)


def test_a_line_s_end_is_exact():
    """Against the firmware's own lines, of all ratios: the end found is that of one line with exactly these steps."""
    from array import array

    from passo.motion.line import Line

    rng = random.Random(2)
    walker, out = Line(3), array("I", [0] * 4000)
    for _ in range(120):
        longest = rng.choice((7, 60, 800, 3000))
        deltas = [rng.randint(-longest, longest) for _ in range(3)]
        if not any(deltas):
            continue
        walker.begin(deltas)
        count = walker.left
        done = 0
        while walker.left:
            part = array("I", [0] * min(walker.left, 64))
            walker.walk(part, 0, len(part))
            out[done : done + len(part)] = part
            done += len(part)
        moves = [[(1 if delta > 0 else -1) * (mask >> axis & 1) for axis, delta in enumerate(deltas)] for mask in out[:count]]
        (only,) = pieces(np.array(moves), arcs=False)
        assert only.count == count and list(only.deltas) == deltas


# --- files far longer than memory


LETTERS = b"ABCDEFGHIJKLMNOPQRSTUVWXYZ"


def long_file(path, count, seed=1):
    """A file of `count` commands, most of them steps; returns [(kind, …)] of each as Python sees it, naively."""
    rng = random.Random(seed)
    parts, commands = [], []
    while len(commands) < count:
        kind = rng.random()
        if kind < 0.97:
            letter = rng.choice(LETTERS)
            run = min(rng.choice((1, 3, 50, 400)), count - len(commands))
            parts.append(bytes([letter]) * run)
            commands += [bytes([letter])] * run
        else:
            token = rng.choice((b"(", b")", b"[", b"]", b"$", b"@", b"*120", b"*7", b"+900", b"+1500", b"+0"))
            parts.append(token)
            commands.append(token)
        if kind > 0.9:
            parts.append(b"\n")
    path.write_bytes(b"".join(parts))
    return commands


def walk_of(data):
    """(the steps as an array, [(steps before, tool)] where the tool changes) of bytes, read by the firmware's reader."""
    found = items(data)
    return moves_of([item for item in found if item & 15] or [0], 3), len(found)


def states_of(commands):
    """(place, tool, speed) before each command, and behind the last."""
    from passo.protocols.pulses.codes import CODES

    place, tool, speed = [0, 0, 0], b")", b"@"
    for command in (*commands, None):
        yield tuple(place), tool, speed
        if command is None:
            return
        if command in (b"(", b")"):
            tool = command
        elif command[:1] in b"+$@" and command != b"+0":
            speed = command
        elif len(command) == 1 and command in LETTERS:
            code = CODES[command[0] - 65]
            for axis in range(3):
                place[axis] += (code >> axis & 1) * (-1 if code >> 4 + axis & 1 else 1)


def test_every_place_of_a_file_both_ways(tmp_path, monkeypatch):
    """Blocks of 50 bytes, so that each kind of token lies at a block's end somewhere."""
    from host_tools.programs import long_pulses

    monkeypatch.setattr(long_pulses, "BLOCK", 50)
    commands = long_file(tmp_path / "file.txt", 3000)
    states = list(states_of(commands))
    file = LongFile(tmp_path / "file.txt", "xyz")
    assert file.total == 3000
    whole, _ = walk_of(b"".join(file.play_forward()))
    for number in range(0, 3001, 29):
        state = file.seek(number)
        assert (state.number, state.place, state.tool, state.speed) == (number, *states[number])
        ahead = b"".join(file.play_forward(number))
        steps, count = walk_of(ahead)
        behind = b"".join(file.play_backward(number))
        back, _ = walk_of(behind)
        before = sum(len(command) == 1 and command in LETTERS for command in commands[:number])
        assert len(steps) == len(whole) - before or before == len(whole)
        if 0 < before < len(whole):
            assert np.array_equal(steps, whole[before:]) and np.array_equal(back, -whole[:before][::-1])


def test_backward_tool_and_speed_are_those_of_the_place(tmp_path):
    path = tmp_path / "file.txt"
    path.write_bytes(b"A+700BB(CC*500+0D)E$FF")
    file = LongFile(path, "xyz")
    assert b"".join(file.play_backward()) == b"$)EE+700F(C*0*0DD)AA@B"
    assert b"".join(file.play_backward(8)) == b"+700(*0DD)AA@B"
    assert b"".join(file.play_forward(8)) == b"+700(+0D)E$FF"
    path.write_bytes(b"[AA]")
    assert b"".join(LongFile(path, "xyz").play_backward(3)) == b"[@)BB*0]"


@pytest.mark.parametrize("data, text", [
    (b"AA\nC*D", "2:2: error 121"), (b"AA?", "1:3: error 120"), (b"A\n+900001", "2:1: error 122"), (b" \n ", "has no command"), (b"A\0", "1:2"),
])  # fmt: skip
def test_what_is_wrong_in_a_long_file(tmp_path, data, text):
    (tmp_path / "file.txt").write_bytes(data)
    with pytest.raises(Failure, match=text):
        LongFile(tmp_path / "file.txt", "xyz")
    (tmp_path / "flat.txt").write_bytes(b"AE")
    with pytest.raises(Failure, match="1:2: error 120"):
        LongFile(tmp_path / "flat.txt", "xy")


def test_a_million_codes_turned_round_repeated_and_sought(tmp_path):
    """All by arrays: places of a million commands, 100 passes as one stream, 200 places at random."""
    rng = np.random.default_rng(5)
    letters = np.frombuffer(LETTERS, np.uint8)
    codes = np.repeat(letters[rng.integers(0, 26, 250_000)], 4)
    path = tmp_path / "million.txt"
    path.write_bytes(codes.tobytes())
    file = LongFile(path, "xyz")
    assert file.total == 1_000_000
    steps = moves_of(items(codes.tobytes()), 3)
    places = np.concatenate([np.zeros((1, 3), np.int64), np.cumsum(steps, axis=0, dtype=np.int64)])
    for number in rng.integers(0, 1_000_001, 200).tolist():
        assert file.seek(number).place == tuple(places[number])
    turned = moves_of([item for item in items(b"".join(file.play_backward())) if item & 15], 3)
    assert np.array_equal(turned, -steps[::-1])
    middle = int(rng.integers(1, 1_000_000))
    again = moves_of([item for item in items(b"".join(file.play_forward(middle))) if item & 15], 3)
    assert np.array_equal(again, steps[middle:])
    counted, at = 0, 0
    for chunk in file.play_forward(times=100):
        assert chunk == codes[at : at + len(chunk)].tobytes()
        counted += len(chunk)
        at = (at + len(chunk)) % len(codes)
    assert counted == 100_000_000 and at == 0


def test_same_steps_sees_a_difference():
    assert same_steps(items("AAB"), items("[A*5AB]"), 3) and not same_steps(items("AAB"), items("ABA"), 3)
    assert pulse_gcode.moves_of(items("Z"), 3).tolist() == [[-1, -1, -1]]


def places_of(trace):
    with open(trace) as file:
        rows = list(csv.reader(file))[1:]
    return [[int(value) for value in row[1:4]] for row in rows]


def steps_of(places):
    """The steps between neighbouring rows; rows of the tool alone make none."""
    steps = np.diff(np.array(places), axis=0)
    return steps[steps.any(axis=1)]


@pytest.mark.unmeasured
def test_a_long_file_on_the_board_from_a_place_backward_and_twice(tmp_path):
    """Twelve thousand codes: three times what the board's 4096 cells hold, of runs of one or two."""
    rng = random.Random(12)
    path, trace = tmp_path / "long.txt", tmp_path / "trace.csv"
    path.write_text("[+2400(" + "".join(rng.choice("ACEBDF") * rng.choice((1, 2)) for _ in range(8000)) + ")]")
    file = LongFile(path, "xyz")
    steps, _ = walk_of(path.read_bytes())
    number = 5000
    before = number - 3  # [ +2400 (
    at = np.array(file.seek(number).place)
    with Board("--board", "lpt_router", "--trace", trace, "--time", "fast") as board:
        where = ("--port", board.port)
        assert passo("play", path, "--stream", "--repeat", "2", *where)[0] == 0
        assert passo("play", path, "--back", *where)[0] == 0
        assert passo("play", path, "--from", number, *where)[0] == 0
        assert passo("play", path, "--from", file.total + 1, *where)[0].endswith(f"there is no place {file.total + 1}")
        status, _, errors = board.end()
        assert status == 0 and not errors
    made = steps_of(places_of(trace))
    whole = len(steps)
    assert np.array_equal(made[:whole], steps) and np.array_equal(made[whole : 2 * whole], steps)
    assert np.array_equal(made[2 * whole : 3 * whole], -steps[::-1])
    jogged = int(np.abs(at).sum())
    assert made[3 * whole : 3 * whole + jogged].sum(axis=0).tolist() == at.tolist()
    assert np.array_equal(made[3 * whole + jogged :], steps[before:])


@pytest.mark.unmeasured
def test_turned_round_beyond_what_the_board_remembers(tmp_path):
    """The key b at the end of a long stream: the board goes back as far as it remembers, this PC streams the rest of the way."""
    rng = random.Random(13)
    path, trace = tmp_path / "long.txt", tmp_path / "trace.csv"
    path.write_text("[$" + "".join(rng.choice("ACEBDF") for _ in range(9000)) + "]")
    steps, _ = walk_of(path.read_bytes())
    with Board("--board", "lpt_router", "--trace", trace, "--time", "fast") as board:
        with PulsesClient(board.port) as client:
            file = LongFile(path, "xyz")
            turned = []
            forward = file.play_forward

            def held(number, times):
                """The end comes once the key has been pressed, however fast the board is."""
                for block in forward(number, times):
                    yield block[:8500]
                    while len(block) > 8500 and not turned:
                        yield b""
                    yield block[8500:]

            file.play_forward = held

            def show(panel, status):
                if not turned and int(status["at"]) > 8000:
                    turned.append(int(status["at"]))
                    client.command("back")

            status = play_long(client, file, show=show)
            assert turned and status["state"] == "idle"
            assert [int(part) for part in client.status()["place"].split(",")] == [0, 0, 0]
        status, _, errors = board.end()
        assert status == 0 and not errors
    made = steps_of(places_of(trace))
    there = len(made) // 2
    assert there > 7990 and np.array_equal(made[:there], steps[:there]) and np.array_equal(made[there:], -steps[:there][::-1])


# --- a tool's radius beside a taught contour


def path_of(text):
    """The tool's centre while it is on, as points in mm, read from the G-code by itself; arcs in chords of 2 degrees."""
    import math
    import re

    x = y = 0.0
    on, paths = False, []
    for line in text.splitlines():
        words = {word[0]: float(word[1:]) for word in re.findall(r"[XYIJ]-?[\d.]+", line)}
        if line.startswith("M3"):
            on = True
            paths.append([(x, y)])
        elif line.startswith("M5"):
            on = False
        if line[:3] not in ("G0 ", "G1 ", "G2 ", "G3 "):
            continue
        to_x, to_y = words.get("X", x), words.get("Y", y)
        if line[1] in "23":
            cx, cy = x + words["I"], y + words["J"]
            radius, first = math.hypot(x - cx, y - cy), math.atan2(y - cy, x - cx)
            sign = -1 if line[1] == "2" else 1
            sweep = sign * (math.atan2(to_y - cy, to_x - cx) - first) % math.tau or math.tau
            count = max(2, int(math.degrees(sweep) / 2))
            paths[-1] += [(cx + radius * math.cos(first + sign * sweep * part / count), cy + radius * math.sin(first + sign * sweep * part / count))
                          for part in range(1, count)]  # fmt: skip
        if on:
            paths[-1].append((to_x, to_y))
        x, y = to_x, to_y
    return paths


@pytest.mark.parametrize("shape", pulse_shapes.SHAPES)
@pytest.mark.parametrize("side", ["left", "right"])
def test_a_radius_beside_the_document_s_shapes(shape, side, tmp_path):
    """The shapes go counter-clockwise: right is outside. Against shapely's buffer, within 0.01 mm."""
    from shapely import LineString, Polygon

    file, out = tmp_path / "shape.txt", tmp_path / "part.gcode"
    file.write_text(pulse_shapes.shape_text(shape, 80))
    status, text = passo("convert", file, "-o", out, "--side", side, "--radius", 3.5)
    assert status == 0, (status, text)
    (path,) = path_of(out.read_text())
    contour = Polygon([(10 * (x - pulse_shapes.SHAPES[shape][0][0]), 10 * (y - pulse_shapes.SHAPES[shape][0][1])) for x, y in pulse_shapes.SHAPES[shape]])
    wanted = contour.buffer(3.5 if side == "right" else -3.5, quad_segs=200).exterior
    assert path[0] == path[-1]
    assert LineString(path).hausdorff_distance(wanted) < 0.01


def test_contours_that_cannot_be_compensated(tmp_path):
    from host_tools.programs.compensation import LEFT

    for text, why in (
        ("(" + "A" * 800 + "C" * 80 + "B" * 800 + ")", "does not fit|too small|narrow"), ("(AAAA*50CC)", "in the middle of a contour"),
        ("(AAAAEEECC)", "Z moves in the middle"), ("(" + "S" * 800 + ")", "Z moves in the middle"), ("EE(EEUUUU)", "Z moves in the middle"), ("(" + "A" * 800 + "C" * 800 + "B" * 800 + "D" * 720 + ")", "cut into its own contour"),
    ):  # fmt: skip
        with pytest.raises(Failure, match=why):
            to_gcode(items(text), BOARD, (LEFT, 3.0))
    # A tool that stays on to the end, or is switched on twice, has cut all the same.
    wanted = to_gcode(items("(" + "A" * 800 + "C" * 800 + ")"), BOARD, (LEFT, 1.0))[0]
    for text in ("(" + "A" * 800 + "C" * 800, "(" + "A" * 800 + "(" + "C" * 800 + ")"):
        made = to_gcode(items(text), BOARD, (LEFT, 1.0))[0]
        assert [line for line in made.splitlines() if line[0] == "G"] == [line for line in wanted.splitlines() if line[0] == "G"], text
    # Z goes down over the contour's start, not where the contour before has ended; the way that leads nowhere is left out.
    square = "(" + "A" * 800 + "C" * 800 + "B" * 800 + "D" * 800 + ")"
    for down, up in (("E", "F"), ("F", "E")):
        text = "A" * 800 + down * 400 + square + up * 400 + "C" * 1600 + down * 400 + square + up * 400 + "D" * 80
        ways = [line for line in to_gcode(items(text), BOARD, (LEFT, 1.0))[0].splitlines() if line[:2] == "G0" or line[:4] == "G1 Z"]
        assert [line[:4] for line in ways] == ["G0 X", "G1 Z"] + ["G1 Z", "G0 X", "G1 Z"] + ["G1 Z"], ways
        alone = [line for line in to_gcode(items(down * 400 + square + up * 400), BOARD, (LEFT, 1.0))[0].splitlines() if line[:1] == "G"]
        assert alone[1][:4] == "G0 X" and alone[2][:4] == "G1 Z", alone
    file = tmp_path / "a.txt"
    file.write_text("(AA)")
    assert "makes G-code" in passo("convert", file, "--side", "left")[0] and "left or right" in passo("convert", file, "--side", "up")[0]
