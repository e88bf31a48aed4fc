"""Pulse programs and drawings interrupted at random, by everything that may fail: `passo resume` ends them with the same picture."""

import math
from collections import Counter

import pytest
from rich.console import Console

from counted_kills import EVERY_MS, Cycles, Job, beside, cut, kill, resumed, whole
from host_tools import boards
from host_tools.cli import draw, draw_run, jobs, pulses
from host_tools.failure import Failure
from host_tools.programs import drawing_progress
from host_tools.sim.pages import Pages
from passo.protocols.plotter.host import COMMANDS, packet
from virtual_wire import Killed, plugged

# Down, an outline with diagonals, a wait, another speed, up. It begins and ends elsewhere, and crosses nothing.
CODES = (
    "[+2400 " + "F" * 80 + "(" + "A" * 700 + "G" * 400 + "C" * 300 + "*120 " + "I" * 350 + "+1500 " + "B" * 700 + "J" * 200 + ")"
    + "E" * 80 + "A" * 9 + "]"
)  # fmt: skip


class Pulses(Job):
    name = "pulses"
    near = False
    twice = 0
    steps_s = 3200
    start = (4000, 4000, 3000)

    def __init__(self, folder, way):
        self.file = folder / "part.txt"
        self.file.write_text(CODES)
        self.way = way
        self.alone = way == "job"
        self.name = f"pulses {way}"

    def board(self):
        made = boards.load("lpt_router")
        made["journal"] = {"every_ms": EVERY_MS}
        made["links"][0].update(lost="stop", lost_ms=self.lost_ms)
        if self.way == "job":
            made["jobs"] = {"language": "pulses"}
        return made

    def begin(self, machine, rng):
        where = {"port": "virtual", "baud": 115200}
        if self.way == "job":
            jobs.store(self.file, protocol="pulses", name="PART", language=None, **where)
            jobs.run("PART", home=False, wait=True, protocol="pulses", **where)
        else:
            pulses.play(self.file, 1, None, self.way == "stream", None, False, wait=True, log=None, **where)

    def resume(self, home, unverified):
        resumed(self, home, unverified)


def outline(x, y, count=40, size=60):
    """A star whose lines do not cross: [(pen down, x, y)], closed."""
    corners = []
    for number in range(count):
        radius = size * (1 if number % 2 else 3)
        corners.append((round(x + radius * math.cos(math.tau * number / count)), round(y + radius * math.sin(math.tau * number / count))))
    return [(number > 0, *place) for number, place in enumerate([*corners, corners[0]])]


OBJECTS = [outline(200, 200), outline(650, 230) + outline(640, 220, 12, 10), outline(1100, 220, 9)]


class Drawing(Job):
    near = True  # from amid a line its rest may run a step beside it
    twice = 3  # steps: the pen goes down where it went up, and beside it
    start = (300, 200)
    lost_ms = 1500
    homes = True

    def __init__(self, folder, way):
        self.file = folder / "map.packets"
        self.file.write_bytes(drawing_progress.packets_of(OBJECTS, True))
        self.name = f"drawing {way}"
        self.way = way
        self.alone = way == "job"

    def board(self):
        made = boards.load("plotter_2014")
        made["journal"] = {"every_ms": EVERY_MS}
        made["tool"].update(on_ms=20, off_ms=20)
        made["speed"].update(overhead_us=0, default=250)
        made["homing"].update(seek_steps_s=2000, locate_steps_s=500)
        made["links"][0].update(lost="stop", lost_ms=self.lost_ms)
        if self.way == "job":
            made["jobs"] = {"language": "plotter"}
        return made

    steps_s = 2000

    def begin(self, machine, rng):
        where = {"port": "virtual", "baud": 57600}
        if self.way == "job":
            jobs.store(self.file, protocol="plotter", name="MAP", language=None, **where)
            jobs.run("MAP", home=False, wait=True, protocol="plotter", **where)
        else:
            draw_run.run(Console(quiet=True), OBJECTS, machine.board, None, "virtual", 57600, None, draw_run.Way())

    def resume(self, home, unverified):
        resumed(self, home, unverified)


WAYS = ((Drawing, "sent"), (Drawing, "job"), (Pulses, "stream"), (Pulses, "stored"), (Pulses, "job"))


@pytest.mark.parametrize("kind, way", WAYS)
def test_it_is_gone_on_with(kind, way, tmp_path):
    job = kind(tmp_path, way)
    facts = whole(job)
    for seed in range(2):
        kill(job, seed, *facts)


@pytest.mark.slow
@pytest.mark.parametrize("kind, way", WAYS)
def test_it_is_gone_on_with_sixty_times(kind, way, tmp_path):
    job = kind(tmp_path, way)
    facts = whole(job)
    kinds = Counter(kill(job, seed, *facts)[0] for seed in range(100, 160))
    assert len(kinds) == 4, kinds


# (way, seed): a pulse cut short by the halt of a lost host; a stand that came behind a poll, and the tool stayed on.
FOUND = (("stored", 218), ("stream", 273))


@pytest.mark.parametrize("way, seed", FOUND)
def test_seeds_that_found_something(way, seed, tmp_path):
    job = Pulses(tmp_path, way)
    kill(job, seed, *whole(job))


SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" viewBox="0 0 60 40">'
    '<path d="M5 5 L50 8 L45 30 L10 35 Z" fill="none" stroke="black"/></svg>'
)


def test_an_svg_file_is_gone_on_with_by_its_name(tmp_path):
    """Resume with the options with which it began, from the file beside it; refuse if the file has changed."""
    job = Drawing(tmp_path, "sent")
    job.file = tmp_path / "map.svg"
    job.file.write_text(SVG)
    machine, other = job.machine(Pages(), job.start), job.machine(Pages(), job.start)
    options = {"file": [job.file], "port": "virtual", "origin": "20,30", "speed": 400}
    cycles = Cycles(other)
    with plugged(other):
        draw.draw(**options)
    job.file.with_name("map.svg.journal").unlink(missing_ok=True)
    with pytest.raises(Killed), plugged(machine, cycles.count * 93 // 100):
        draw.draw(**options)
    machine.ask(packet(COMMANDS["STOP"]))
    before = cut(machine)
    with plugged(machine):
        job.resume(False, False)
    made, wanted = cut(machine), cut(other)
    assert 0 < sum(before.values()) < sum(wanted.values())
    assert set(wanted) <= beside(made) and set(made) <= beside(wanted)
    job.file.write_text(SVG.replace("45 30", "45 31"))
    with plugged(machine), pytest.raises(Failure, match="another drawing"):
        job.resume(False, False)


@pytest.mark.parametrize("kind, way, share", ((Pulses, "stream", 0.002), (Pulses, "stored", 0.002), (Drawing, "sent", 0.002)))
def test_frames_carry_the_language_over_a_noisy_line(kind, way, share, tmp_path):
    """As by `passo --frames`: bytes are lost, doubled or flipped, and each step is the one that it should be."""
    job = kind(tmp_path, way)
    wanted, _, _ = whole(job)
    plain = job.board
    job.board = lambda: with_frames(plain())
    machine = job.machine(Pages(), job.start)
    with plugged(machine, framed=True, share=share):
        job.begin(machine, None)
    assert cut(machine) == wanted and not machine.plant.errors


def with_frames(board):
    board["links"][0].update(frames=True, lost="go_on")
    return board
