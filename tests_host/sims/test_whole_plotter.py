"""The whole plotter on the virtual board, bytes in and rotor positions out: faults on the wire, homing, rotated squares."""

import copy
import math
import random

import pytest
import tiers

from host_tools import boards
from host_tools.sim.machine import VirtualMachine
from noisy_wire import damaged
from passo.protocols.plotter.host import COMMANDS, RESYNC_MS, packet, status_from

GAP_MS = boards.load("plotter_2014")["links"][0]["idle_gap_ms"]
TURN_MS = 8  # of the virtual board in motion: how late it may look at its line
FAULT_IN = 30  # one packet in FAULT_IN has a fault
SEEDS = 200


def machine_at_origin(**options):
    """A quick machine (1 ms a step), homed from a place near the origin so that tests are short."""
    board = boards.load("plotter_2014")
    board["tool"].update(on_ms=2, off_ms=2)
    board["speed"].update(overhead_us=0, default=200)
    machine = VirtualMachine(board, start=(20, 20), **options)
    assert machine.ask(packet(COMMANDS["ORIGIN"])) == b"o"
    return machine


def random_object(dice, count):
    """`count` points, the first a MOVE: a walk of short lines with some pen-up moves."""
    x, y = dice.randint(50, 400), dice.randint(50, 400)
    points = [("MOVE", x, y)]
    while len(points) < count:
        x, y = max(0, x + dice.randint(-9, 9)), max(0, y + dice.randint(-9, 9))
        points.append(("MOVE" if dice.random() < 0.1 else "LINE", x, y))
    return points


def send(machine, data, dice):
    """Send a packet as the hosts of 2014 do: wait for the answer, send again on RESEND. Returns (answer, worst delay)."""
    asked = machine.now_ms()
    faulty = dice is not None and dice.randrange(FAULT_IN) == 0
    answer = machine.ask(damaged(dice, data) if faulty else data, limit_ms=600_000)
    delay = machine.now_ms() - asked
    if answer == b"r":
        answer = machine.ask(data, limit_ms=600_000)
    return answer, delay if faulty else 0


def steps_drawn(points, dice):
    """[(x, y, tool)] of every step while the object is drawn, and the longest a fault delayed an answer."""
    machine = machine_at_origin()
    begin = len(machine.trace.rows())
    worst = 0
    for name, x, y in points:
        answer, delay = send(machine, packet(COMMANDS[name], x, y), dice)
        assert answer == b"n"
        worst = max(worst, delay)
    assert send(machine, packet(COMMANDS["END"]), None)[0] == b"d"
    assert machine.plant.errors == []
    return [row[1:3] + row[5:] for row in machine.trace.rows()[begin:]], worst


@pytest.mark.parametrize("part", range(8))
def test_faults_on_the_wire_change_nothing(part):
    for seed in range(part, SEEDS, 8 if tiers.current == "all" else 32):
        dice = random.Random(seed)
        points = random_object(dice, 20 + 480 * seed // (SEEDS - 1))
        clean, _ = steps_drawn(points, None)
        drawn, worst = steps_drawn(points, dice)
        assert drawn == clean
        assert worst <= RESYNC_MS + GAP_MS + 3 * TURN_MS


def test_a_doubled_byte_that_could_be_another_packet():
    """LINE whose first byte doubled gives six bytes with a good checksum: neither reading is drawn."""
    code = COMMANDS["LINE"]
    for x in range(0, 3000, 7):
        for y in (0, 5, 2999):
            data = packet(code, x, y)
            twin = data[:1] + data
            if sum(twin[:5]) & 255 == twin[5]:
                machine = VirtualMachine()
                assert machine.ask(twin) == b"r"
                assert machine.app.controller.features["drawing"].points.count == 0
                return
    raise AssertionError("no such packet")


@pytest.mark.parametrize("degree", range(0, 90, 15))
def test_squares_at_every_degree(degree):
    """The fault of 2014: a rotated square whose motors turned back at random. Every edge steps its own way only."""
    machine = machine_at_origin()
    for angle in range(degree, degree + 15, 1 if tiers.current == "all" else 4):
        for quarter in range(4):
            corners = []
            for corner in range(5):
                turn = math.radians(angle + 90 * quarter + 90 * corner)
                corners.append((round(300 + 90 * math.cos(turn)), round(300 + 90 * math.sin(turn))))
            machine.ask(packet(COMMANDS["MOVE"], *corners[0]))
            for corner in corners[1:]:
                machine.ask(packet(COMMANDS["LINE"], *corner))
            begin = len(machine.trace.rows())
            assert machine.ask(packet(COMMANDS["END"])) == b"d"
            check_edges([row for row in machine.trace.rows()[begin:] if row[5]], corners)
            assert machine.app.controller.position() == list(corners[0])
    assert machine.plant.errors == []


def check_edges(rows, corners):
    """The pen-down rows run from corner to corner, no step against its edge's direction, and close exactly."""
    places = [tuple(row[1:3]) for row in rows]
    assert places[0] == places[-1] == corners[0]
    at = 0
    for (x0, y0), (x1, y1) in zip(corners, corners[1:]):
        steps = max(abs(x1 - x0), abs(y1 - y0))
        edge = places[at : at + steps + 1]
        assert edge[-1] == (x1, y1)
        for (xa, ya), (xb, yb) in zip(edge, edge[1:]):
            assert (xb - xa) * (x1 - x0) >= 0 and (yb - ya) * (y1 - y0) >= 0
        at += steps
    assert at == len(places) - 1


def test_a_hundred_homings_agree():
    """Random starts, some on a sensor, barriers that chatter: all within one step of each other; with a commit a quarter of them."""
    origins = []
    for seed in range(100 if tiers.current == "all" else 25):
        dice = random.Random(seed)
        start = dice.randint(-60, 300), dice.randint(-60, 200)
        machine = VirtualMachine(start=start, bounce_ms=dice.randint(0, 8), seed=seed, trace=None)
        assert machine.ask(packet(COMMANDS["ORIGIN"])) == b"o"
        assert machine.plant.errors == []
        origins.append(tuple(machine.plant.position))
    for axis in range(2):
        places = [origin[axis] for origin in origins]
        assert max(places) - min(places) <= 1


DRIVES = [("step_dir", "half"), ("unipolar", "wave"), ("unipolar", "full"), ("unipolar", "half"),
          ("pbl3770a", "full"), ("pbl3770a", "half"), ("pbl3770a", "quarter"), ("pbl3770a", "eighth")]


def board_with(kind, mode):
    """The plotter with another drive, on neighbouring pins in the order of a word."""
    board = copy.deepcopy(boards.load("plotter_2014"))
    board["drive"] = {"kind": kind, "mode": mode}
    width = {"step_dir": 2, "unipolar": 4, "pbl3770a": 6}[kind]
    for number, axis in enumerate(board["axes"]):
        first, apart = (16 + number, 2) if kind == "step_dir" else (16 + number * width, 1)
        axis["pins"] = [first + apart * pin for pin in range(width)]
        axis["reversed"] = number == 1
    board["tool"]["pin"] = 16 + 2 * width
    return board


@pytest.mark.parametrize("kind, mode", DRIVES)
def test_every_drive_goes_exactly_where_it_is_told(kind, mode):
    """The plant decodes the pins back to exactly the commanded places, with no sequence a motor could not follow."""
    machine = VirtualMachine(board_with(kind, mode), start=(30, 40))
    assert machine.ask(packet(COMMANDS["ORIGIN"])) == b"o"
    zero = list(machine.plant.position)
    dice = random.Random(7)
    for _ in range(12):
        x, y = dice.randint(0, 300), dice.randint(0, 300)
        machine.ask(packet(COMMANDS["LINE"], x, y))
        assert machine.ask(packet(COMMANDS["END"])) == b"d"
        assert [machine.plant.position[0] - zero[0], machine.plant.position[1] - zero[1]] == [x, y]
        machine.run_ms(dice.choice((1, 200, 6000)))  # held, or released in between
    assert machine.plant.errors == []


def test_status_while_drawing_tells_the_place_on_the_pins():
    machine = machine_at_origin()
    zero = list(machine.plant.position)
    for x, y in ((200, 10), (20, 150), (180, 140)):
        machine.ask(packet(COMMANDS["LINE"], x, y))
    machine.send(packet(COMMANDS["END"]))
    drawn = []
    while not machine.replies_so_far():
        machine.cycle()
        place = [machine.plant.position[axis] - zero[axis] for axis in range(2)]
        assert machine.app.controller.position() == place
        drawn.append(machine.app.controller.features["drawing"].count_drawn())
    assert drawn == sorted(drawn) and set(drawn) == {0, 1, 2, 3}
    status = status_from(machine.ask(packet(COMMANDS["STATUS"]), 12))
    assert (status["x"], status["y"], status["drawn"], status["state"]) == (180, 140, 3, "idle")
