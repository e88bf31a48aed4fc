"""Feeds at the pins of the emulated Pico and of the virtual board, and in `?`: within 0.1 % of the line's F, on machines whose motors are
not simply X, Y and Z: with a rotary table, CoreXY, and backlash compensation."""

import copy
import math
import re
from statistics import linear_regression, mode

import pytest
from emulated import make_machine, uf2  # noqa: F401

from host_tools import boards
from host_tools.sim.machine import VirtualMachine

WITHIN = 1e-3
START = {"router_4axis": (2000, 2000, -2000, 0), "corexy_plotter": (1200, 1200), "router_ballscrew": (2000, 2000, -2000)}
PLAY = {"router_ballscrew": {"x": 13, "y": 16, "z": 6}}
# (line, per minute as `?` has it, centre of an arc against its beginning, mm). A word A alone counts in degrees.
LINES = {
    "router_4axis": (
        ("G94G1X10A90F1200", 1200, None), ("G1X-8Y-6A-30F1800", 1800, None), ("G1A120F7200", 7200, None), ("G93G1X10A90F120", 1200, None),
        ("G93G1A-90F80", 7200, None), ("G93G1X-10Y5Z-2.5A45F100", math.hypot(10, 5, 2.5) * 100, None), ("G94G3X-10Y0I-5J0F1200", 1200, (-5, 0)),
    ),
    "corexy_plotter": (
        ("G94G1X40F3000", 3000, None), ("G1X-20Y20F3000", 3000, None), ("G1X20Y35F2400", 2400, None), ("G93G1X-30Y5F60", math.hypot(30, 5) * 60, None),
        ("G94G3X-20Y0I-10J0F1800", 1800, (-10, 0)),
    ),
    "router_ballscrew": (
        ("G94G1X10F1200", 1200, None), ("G1X-10F1200", 1200, None), ("G1X8Y-6F1800", 1800, None), ("G93G1X-8Y6F90", 900, None),
        ("G94G2X10Y0I5J0F1200", 1200, (5, 0)),
    ),
}  # fmt: skip


def plain(name):
    board = {**copy.deepcopy(boards.load(name)), "journal": None}
    for link in board["links"]:
        link.pop("lost", None)
    return board


def measured(rows, board, centre):
    """Units a minute along the path of linear axes, or of A alone, amid a motion: the slope of the way over time. `rows`: the first is where
    the motion begins. Of an arc before it crosses an axis: there lost motion is taken up."""
    scale = [axis["steps_per_m"] / 1000 for axis in board["axes"]]
    ends = [(rows[-1][1 + axis] - rows[0][1 + axis]) / each for axis, each in enumerate(scale)]
    begins, lasts = rows[1][0], rows[-1][0] - rows[1][0]
    middle = [row for row in rows[1:] if 0.25 < (row[0] - begins) / lasts < (0.45 if centre else 0.75)]
    places = [[(row[1 + axis] - rows[0][1 + axis]) / each for axis, each in enumerate(scale)] for row in middle]
    if centre:
        angles = [math.atan2(place[1] - centre[1], place[0] - centre[0]) for place in places]
        turned = [angles[0]]
        for angle in angles[1:]:
            turned.append(turned[-1] + (angle - turned[-1] + math.pi) % (2 * math.pi) - math.pi)
        way = [angle * math.hypot(*centre) for angle in turned]
    else:
        linear = range(3 if len(scale) == 4 and any(abs(each) > 0.01 for each in ends[:3]) else len(scale))
        whole = math.hypot(*(ends[axis] for axis in linear))
        way = [sum(place[axis] * ends[axis] for axis in linear) / whole for place in places]
    return abs(linear_regression([row[0] for row in middle], way).slope) * 60e6


@pytest.mark.parametrize("where", ["virtual", pytest.param("Pico", marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", LINES)
def test_feeds_at_the_pins_and_in_reports(name, where, make_machine, show):  # noqa: F811
    board = plain(name)
    machine = (VirtualMachine if where == "virtual" else make_machine)(copy.deepcopy(board), start=START[name], play=PLAY.get(name))
    machine.run_until(lambda: b"$X" in machine.replies_so_far() or b"$H" in machine.replies_so_far(), 10_000)

    def ask(data, answer=b"ok"):
        machine.take()
        machine.send(data)
        machine.run_until(lambda: answer in machine.replies_so_far() or b"error" in machine.replies_so_far(), 60_000)
        assert answer in machine.replies_so_far(), (data, machine.replies_so_far())
        return machine.take()

    for line in (b"$X\n", b"G21G91G17\n"):
        ask(line)
    pins, reports = [], []
    for line, wanted, centre in LINES[name]:
        first = len(machine.trace.rows())
        machine.send(line.encode() + b"\n")
        said = []
        for _ in range(400):
            report = ask(b"?", b">")
            if b"<Idle" in report and said:
                break
            if b"<Run" in report:
                said.append(float(re.search(rb"\|FS?:([0-9.]+)", report)[1]))
            machine.run_ms(20)
        machine.settle()
        rows = machine.trace.rows()[max(first - 1, 0) :]
        pins.append(measured(rows, board, centre) / wanted - 1)
        reports.append((mode(said) - wanted) / wanted)
        assert abs(mode(said) - wanted) <= WITHIN * wanted + 1, (line, mode(said), wanted)  # reports have whole units
    show(f"feeds of {name}, {where}", f"pins within {100 * max(map(abs, pins)):.4f} %, reports within {100 * max(map(abs, reports)):.4f} %")
    assert max(map(abs, pins)) <= WITHIN, pins
