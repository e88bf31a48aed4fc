"""Programs interrupted at random moments: by the power, with the flash torn at any byte, by a stop, by a lost PC. What is resumed
cuts what is missing, at most what was cut since the last record twice, and nothing else."""

import random

import pytest

from host_tools import boards
from host_tools.cli.lead_in import number_of
from host_tools.cli.resume import interrupted
from host_tools.clients.grbl import tagged
from host_tools.failure import Failure
from host_tools.programs import gcode_file, replay
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.pages import Pages, PowerCut
from kills import near

LINES = b"G21G90\nM3S9000\nG0Z-2\nG0X10Y10\nG1Z-4F600\nX22F1500\nY18\nX12Y12\nG0Z-2\nM5\nM30\n"
ARCS = b"G21G90\nM3S9000\nG0Z-2\nG0X12Y10\nG1Z-4F600\nG2X20Y10I4J0F1500\nG3X12Y10I-4J3\nG0Z-2\nM5\nM30\n"
OFFSETS = b"G21G90\nM4S5000\nM8\nG0Z-2\nG10L2P2X8Y9\nG55\nG0X2Y2\nG1Z-4F600\nG91\nX9F1500\nY4\nX-4Y-2\nG90\nG54\nG1X12Y12\nG0Z-2\nM5M9\nM30\n"
JOBS = {"lines": LINES, "arcs": ARCS, "offsets": OFFSETS}
CUT_MM = -3
NEAR = 2  # steps


def board():
    made = boards.load("router_3axis")
    made["journal"] = {"every_ms": 200}
    return made


class Bench:
    """A machine that homes, and a PC that sends."""

    def __init__(self, pages):
        self.pages = pages
        self.machine = VirtualMachine(board(), pages=pages, start=(3000, 2500, -1800))
        self.cycles = 0

    def ask(self, line):
        machine = self.machine
        machine.take("pc")
        machine.send((line if isinstance(line, bytes) else line.encode()) + b"\n", "pc")
        machine.run_until(lambda: b"ok\r\n" in machine.received("pc") or b"error" in machine.received("pc"), 100_000)
        said = machine.take("pc").decode().split("\r\n")
        assert "ok" in said, (line, said)
        return said

    def home(self):
        self.ask("$H")
        return self

    def stream(self, lines, cycles=None):
        """As a sender that counts characters; ends after so many cycles of the board."""
        waiting = list(lines)
        machine = self.machine
        while waiting or machine.port.pending(machine.app.controller.busy()):
            if waiting and len(machine.lines["pc"].incoming) < 60:
                machine.send(tagged(*waiting.pop(0)) + b"\n", "pc")
            machine.cycle()
            if cycles is not None:
                cycles -= 1
                if cycles <= 0:
                    return False
        assert b"error" not in machine.received("pc"), machine.received("pc")
        machine.settle()
        return True

    def cut(self):
        """Places passed with the spindle on and the tool down."""
        per_mm = 400
        return {row[1:4] for row in self.machine.trace.rows() if row[5] and row[3] < CUT_MM * per_mm}


def program(name, tmp_path):
    path = tmp_path / f"{name}.nc"
    path.write_bytes(JOBS[name])
    return gcode_file.read(path)


def begin(bench, lines):
    bench.home().ask(f"$JR={number_of(lines):08x}")


def go_on(bench, lines):
    """As passo resume does. Returns X and Y of where the tool went down."""
    number, place, known = interrupted(bench.ask("$JR"), lines)
    if not known:
        bench.home()
    facts = replay.Machine.of_answers(bench.ask("$$"), bench.ask("$#"))
    state = replay.Replay(facts, lines)
    stages, rest = state.from_line(number) if place is None else state.from_place(number, place)
    for what, sent in stages:
        if what == replay.DOWN:
            assert not any(row[5] and row[3] < CUT_MM * 400 for row in bench.machine.trace.rows()[bench.seen :]), "it cut on the way"
        for line in sent:
            bench.ask(line)
        bench.ask("G4P0")
        if what == replay.DOWN:
            column = bench.machine.plant.position[:2]
    bench.stream(rest)
    return column


def beside(place, down):
    return abs(place[0] - down[0]) <= NEAR and abs(place[1] - down[1]) <= NEAR


def whole(lines):
    bench = Bench(Pages())
    begin(bench, lines)
    steps = bench.machine.trace
    first = bench.machine.now_ms()
    bench.stream(lines)
    assert steps.rows()
    return bench.cut(), (bench.machine.now_ms() - first)


def interrupt(name, seed, tmp_path, wanted, lasts_ms):
    """One interruption at a moment of its own, and its resumption. Returns the steps that were made."""
    rng = random.Random(f"{name} {seed}")
    lines = program(name, tmp_path)
    bench = Bench(Pages())
    begin(bench, lines)
    kind = rng.choice(("power", "power", "reset", "pc"))
    if kind == "power" and rng.random() < 0.6:
        bench.pages.cut_after(rng.randrange(0, 800))
    cycles = rng.randrange(1, round(lasts_ms / 8))
    try:
        ended = bench.stream(lines, cycles)
    except PowerCut:
        ended = False
    before = bench.cut()
    if kind == "pc" or ended:
        bench.machine.settle()
        before = bench.cut()
        after = bench
    elif kind == "reset":
        bench.machine.send(b"\x18", "pc")
        bench.machine.run_ms(50)
        before = bench.cut()
        bench.ask("$X")
        after = bench
    else:
        assert not bench.machine.plant.errors, bench.machine.plant.errors[:2]
        after = Bench(Pages(data=bench.pages.data))
        after.ask("$X")  # where it stands is not known: it homes before it goes on
    after.seen = len(after.machine.trace.rows())
    down = None
    try:
        down = go_on(after, lines)
    except Failure as failure:
        assert "done to its end" in str(failure), (name, seed, failure)
    cut = before | after.cut()
    missing = [place for place in wanted - cut if not near(place, cut)]
    assert not missing, (name, seed, kind, len(missing), missing[:3])
    extra = [place for place in cut - wanted if not near(place, wanted) and (down is None or not beside(place, down))]
    assert not extra, (name, seed, kind, len(extra), extra[:3])
    machines = (bench,) if after is bench else (bench, after)
    return sum(len(each.machine.trace.rows()) for each in machines)


@pytest.mark.slow  # test_kills.py shows the same
@pytest.mark.parametrize("name", JOBS)
def test_interrupted_programs_are_cut_whole(name, tmp_path):
    wanted, lasts_ms = whole(program(name, tmp_path))
    for seed in range(2):
        interrupt(name, seed, tmp_path, wanted, lasts_ms)


@pytest.mark.slow
@pytest.mark.parametrize("name", JOBS)
def test_interrupted_a_hundred_times(name, tmp_path):
    wanted, lasts_ms = whole(program(name, tmp_path))
    for seed in range(100, 200):
        interrupt(name, seed, tmp_path, wanted, lasts_ms)
