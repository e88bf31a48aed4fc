"""Homing, repeated: from elsewhere each time, sensors that bounce, and the spread of where it ends.

Machines with a plant are moved by hand between the runs. A board homes itself by `$HR` ($H and ten times more), if it speaks grbl.
"""

import copy
import random
import re
from contextlib import suppress
from statistics import pstdev

from host_tools import boards
from host_tools.experiments import charts
from host_tools.experiments.authors import ORIGIN, without_figure
from host_tools.experiments.places import BOARD, EMULATED, VIRTUAL
from host_tools.experiments.row import Outcome, figure_text
from host_tools.failure import Failure
from host_tools.language import _
from passo.protocols.plotter.host import COMMANDS, packet

RUNS = {VIRTUAL: 10, EMULATED: 5, BOARD: 10}
SEED = 2014
PULL_OFF = 80  # steps: a short way to the edge that counts
BOUNCE_MS = 3
FARTHEST = 200  # steps from the origin
MOST_MS = 120_000
HOMED_S = 600
ROW = re.compile(r"\[HOM:(\w+),(\d+),(\d+),([\d.]+)")


def plotter_board():
    """Return the board file of the plotter of 2014 with a pull-off of PULL_OFF steps."""
    board = copy.deepcopy(boards.load("plotter_2014"))
    board["homing"]["pull_off_steps"] = PULL_OFF
    return board


def home_repeatedly(place, runs):
    """Home `runs` times; return [(x, y)] in steps where each ended, as the plant knows it: the first from FARTHEST, each from elsewhere. Raises
    Failure."""
    machine = place.create_machine(plotter_board(), start=(FARTHEST, FARTHEST), bounce_ms=BOUNCE_MS, trace=None, seed=SEED)
    chance = random.Random(SEED)
    found = []
    try:
        machine.run_ms(1000)
        for _again in range(runs):
            if machine.ask(packet(COMMANDS["ORIGIN"]), limit_ms=MOST_MS) != b"o":
                raise Failure("homing was refused")
            machine.settle()
            found.append(tuple(machine.plant.position))
            for axis in ("x", "y"):
                machine.plant.slip_motor(axis, chance.randint(-PULL_OFF // 3, FARTHEST))
    finally:
        machine.close()
    return found


def why_left_out(raw):
    """Return the reason why a board of this board file does not say how well it homes; "" if it does."""
    first = raw["links"][0]
    if first["protocol"] != "grbl" or first["port"] != "usb" or not raw.get("homing"):
        return _("its board file has no homing in G-code over USB: passo send ORIGIN homes a plotter")
    if not raw["homing"].get("latch"):
        return _("its board file counts no homing: give homing the key latch, True, and flash it")
    return ""


def home_board(place, runs):
    """Home a board by $HR; return [(sensor, runs, range, standard deviation)] in steps, as the board itself counts them. Raises Failure."""
    with place.open_client() as client:
        client.connect()
        try:
            said = client.command(f"$HR={runs}", HOMED_S)
        except BaseException:  # Ctrl-C, too: the machine would home on
            with suppress(Failure):
                client.reset()
            raise
    return [(axis, int(count), int(wide), float(sigma)) for axis, count, wide, sigma in ROW.findall("\n".join(said))]


def run(place):
    """Return the Outcome: the spread of the positions at which homing ends."""
    if place.kind == BOARD:
        outcome = Outcome(_("$HR={}: the board's own sensors and counts", RUNS[BOARD]))
        for axis, count, wide, sigma in home_board(place, RUNS[BOARD]):
            outcome.add_row(_("{}, {} times: range", axis, count), without_figure(ORIGIN), wide, _("steps"), _("standard deviation {}", figure_text(sigma)))
        return outcome
    ends = home_repeatedly(place, RUNS[place.kind])
    outcome = Outcome(_("{} times, moved by hand in between, sensors that bounce for up to {} ms; where the carriage stands", len(ends), BOUNCE_MS))
    for axis, name in enumerate("XY"):
        each = [end[axis] for end in ends]
        told = _("standard deviation {}", figure_text(pstdev(each)))
        outcome.add_row(_("{}, {} times: range", name, len(each)), without_figure(ORIGIN), max(each) - min(each), _("steps"), told)
    groups = {name: [(at + 1, end[axis]) for at, end in enumerate(ends)] for axis, name in enumerate("XY")}
    outcome.pictures.append((_("Where each homing ended, steps"), charts.draw_dots(groups, _("which homing"), _("steps"))))
    return outcome
