"""`passo pulses ramps`: speeds that accelerate within bounds, the same steps, and the pulses at the pins."""

import csv
import math
import random

import numpy as np
import pytest

from host_tools import boards
from host_tools.programs import pulse_file, pulse_shapes
from host_tools.programs.pulse_gcode import same_steps
from host_tools.programs.pulse_ramps import with_ramps
from passo.config.boardfile import check
from passo.options.step_program.commands import STEPS_ASK, STEPS_SPEED
from test_board_command import Board
from test_pulses_command import passo

BOARD = check(boards.load("lpt_router"))
CONFIG = BOARD["step_program"]
FASTEST = 2403  # mm/min


def items(text):
    return pulse_file.read_items(text.encode(), "xyz", CONFIG)


def speeds_of(found):
    """(moves, mm/s of each step, numbers of steps before a mark that stands) as the marks say; None while the operator decides."""
    speed, moves, speeds, stands = CONFIG["default_mm_min"] / 60, [], [], [0]
    for item in found:
        mask, kind, value = item & 15, item >> 4 & 15, item >> 8
        if mask:
            step = [(mask >> axis & 1) * (-1 if item >> 4 + axis & 1 else 1) for axis in range(3)]
            moves += [step] * value
            speeds += [speed] * value
        elif kind == STEPS_SPEED:
            speed = value / 60
        else:
            if kind == STEPS_ASK:
                speed = None
            stands.append(len(moves))
    return np.array(moves), speeds, [*stands, len(moves)]


@pytest.mark.parametrize("shape, accel", [("square", 100), ("triangle", 600), ("hexagon", 100), ("octagon", 600)])
def test_shapes_accelerate_within_bounds(shape, accel):
    text = pulse_shapes.shape_text(shape, 80, 1800)
    made = items(with_ramps(items(text), BOARD, accel))
    assert same_steps(items(text), made, 3)
    moves, speeds, _ = speeds_of(made)
    speeds = np.array(speeds)
    way = np.sqrt((moves**2).sum(axis=1)) / 80
    corners = np.flatnonzero((np.diff(moves, axis=0) != 0).any(axis=1)) + 1
    assert len(corners) == len(pulse_shapes.SHAPES[shape]) - 1 and speeds.max() == pytest.approx(30, rel=0.04)
    rest = math.sqrt(2 * accel * way.max())
    assert speeds[0] <= 1.1 * rest and speeds[-1] <= 1.1 * rest
    for corner in corners:
        into, out = (moves[corner + by] / np.hypot(*moves[corner + by][:2]) for by in (-1, 0))
        half = math.sqrt((1 + into @ out) / 2)
        allowed = math.sqrt(accel * 0.010 * half / (1 - half))
        assert speeds[corner - 1] <= 1.06 * math.hypot(allowed, rest) and speeds[corner] <= 1.06 * math.hypot(allowed, rest)
    # Over a millimetre and more v² changes by no more than 2 a s, but for the levels of 4 %.
    places = np.cumsum(way)
    for far in (80, 200):
        change = np.abs(speeds[far:] ** 2 - speeds[:-far] ** 2)
        assert (change <= 2 * accel * (places[far:] - places[:-far]) + 0.09 * np.maximum(speeds[far:], speeds[:-far]) ** 2).all()
    assert 0.5 < np.mean(speeds > 0.95 * 30) or accel == 100


def test_an_arc_stays_within_the_acceleration():
    from host_tools.programs.program_lines import strip_line

    lines = [(number, strip_line(line)) for number, line in enumerate(b"F2400\nG1X40\nG3X40Y10I0J5\nG1X0".split(b"\n"), 1)]
    found = items(pulse_file.Converter(BOARD).convert(lines))
    made = items(with_ramps(found, BOARD, 100))
    assert same_steps(found, made, 3)
    moves, speeds, _ = speeds_of(made)
    places = np.cumsum(moves, axis=0) / 80
    on_arc = places[:, 0] > 40.5
    assert max(np.array(speeds)[on_arc]) <= 1.03 * math.sqrt(100 * 5) and max(speeds) > 30


def test_it_stands_where_it_waits_or_is_asked():
    text = "[+1800" + "A" * 2000 + "*500" + "A" * 2000 + "(" + "C" * 800 + ")+0" + "A" * 400 + "+1200" + "A" * 400 + "]"
    made = items(with_ramps(items(text), BOARD, 300))
    assert same_steps(items(text), made, 3)
    moves, speeds, stands = speeds_of(made)
    rest = math.sqrt(2 * 300 / 80)
    assert {0, 2000, 4800, 5600} <= set(stands)
    for stand in (2000, 4800, 5600):
        assert speeds[stand - 1] is None or speeds[stand - 1] < 1.1 * rest or stand == 5600
    assert speeds[4800:5200] == [None] * 400 and None not in speeds[:4800] and max(speeds[5200:]) == pytest.approx(20, rel=0.04)
    assert speeds[4100] > 10  # the tool switches without a delay: no stand


def test_any_steps_stay_the_same():
    rng = random.Random(3)
    for _ in range(10):
        text = "".join(
            rng.choice(("A", "B", "C", "D", "G", "S", "Z", "(", ")", "[", "+600", "$", "@", "*20", "+0")) * rng.choice((1, 1, 7)) for _ in range(150)
        )
        found = items(text)
        assert same_steps(found, items(with_ramps(found, BOARD, rng.choice((20, 5000)))), 3)


@pytest.mark.unmeasured
def test_on_the_pins(tmp_path):
    """The time between steps falls and rises again, and nothing else of the path changes."""
    plain, soft, trace = tmp_path / "plain.txt", tmp_path / "soft.txt", tmp_path / "trace.csv"
    plain.write_text("[+2400" + "A" * 1600 + "]")
    status, text = passo("ramps", plain, "-o", soft, "--accel", 400)
    assert status == 0 and "cells" in text
    assert "asks for no acceleration" in passo("ramps", plain)[0]
    with Board("--board", "lpt_router", "--trace", trace, "--time", "fast") as board:
        assert passo("play", soft, "--port", board.port)[0] == 0
        board.end()
    with open(trace) as file:
        rows = [[float(row[0]), int(row[1])] for row in list(csv.reader(file))[1:]]
    times = [t for t, x in rows[1:]]
    assert [x for _, x in rows] == [*range(1601)]
    speeds = np.array([12.5 / (later - earlier) * 1000 for earlier, later in zip(times, times[1:])])  # mm/s
    assert speeds.max() == pytest.approx(40, rel=0.01) and speeds[0] < 5 and speeds[-1] < 5
    middle = np.flatnonzero(speeds > 39)
    assert middle[0] / 80 == pytest.approx(40**2 / 2 / 400, rel=0.1) and (1600 - middle[-1]) / 80 == pytest.approx(2, rel=0.1)
