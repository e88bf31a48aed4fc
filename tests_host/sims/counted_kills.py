"""Pulse programs and drawings interrupted at random moments, and gone on with by `passo resume` itself.

    kill(job, seed)     # one interruption and its resumption; asserts that the picture is the whole one, and nothing is cut twice

What fails: the cable, amid a message; the PC's process; the board's main loop, after which the watchdog resets it; the power, while the
flash is written torn at any byte. The board is virtual, its time too; the PC is the commands of `passo` (virtual_wire.py). What the pins
did is read from the plant.
"""

import random
from collections import Counter

from host_tools.cli import resume
from host_tools.failure import Failure
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.pages import Pages, PowerCut
from virtual_wire import Killed, plugged

KINDS = ("link", "host", "loop", "power")
LOST_MS = 400
AHEAD_MS = 50  # of words, and a cycle
FROZEN_MS = 1200  # longer than the watchdog waits
EVERY_MS = 100


class Job:
    """What is interrupted. A subclass says how it begins, and what its machine is."""

    file = None  # its path
    board = None
    zero = (0, 0, 0)  # where the plant has the machine's zero
    homes = False
    alone = False  # it needs no PC

    def machine(self, pages, start):
        made = VirtualMachine(self.board(), pages=pages, start=start)
        made.cycle()
        made.take()
        return made

    def begin(self, machine, rng):
        """The PC's part, to the end of the job."""
        raise NotImplementedError


def cut(machine, first=0):
    """How often each place was stepped to with the tool on."""
    rows = machine.trace.rows()
    found = Counter()
    for before, row in zip(rows[first:], rows[first + 1 :]):
        if row[5] and row[1:5] != before[1:5]:
            found[row[1:5]] += 1
    return found


def whole(job, seed=0):
    """(the picture, cycles, bytes of flash written) of the job when nothing fails."""
    pages = Counting()
    machine = job.machine(pages, job.start)
    cycles = Cycles(machine)
    with plugged(machine):
        job.begin(machine, random.Random(seed))
    return cut(machine), cycles.count, pages.written


class Counting(Pages):
    written = 0

    def _put(self, at, byte):
        super()._put(at, byte)
        self.written += 1


class Cycles:
    """Counts the cycles of a machine."""

    def __init__(self, machine):
        self.count = 0
        self._cycle = machine.cycle
        machine.cycle = self._counted

    def _counted(self):
        self.count += 1
        self._cycle()


def kill(job, seed, wanted, cycles, written):
    """One interruption. Returns its kind, and how many steps were cut twice."""
    rng = random.Random(f"{job.name} {seed}")
    kind = rng.choice(KINDS)
    pages = Pages()
    torn = kind == "power" and rng.random() < 0.5
    if torn:
        pages.cut_after(rng.randrange(written))
    machine = job.machine(pages, job.start)
    at = None if torn else rng.randrange(1, cycles)
    ended = False
    try:
        with plugged(machine, at):
            job.begin(machine, rng)
        ended = True
    except (Killed, PowerCut):
        pass
    where = f"{job.name} {seed} {kind}"
    after = survive(job, machine, kind, pages, rng)
    seen = 0 if after is not machine else len(machine.trace.rows())
    before = cut(machine)
    assert not machine.plant.errors, (where, machine.plant.errors[:2])
    went_on(job, after, kind, wanted == before or ended, where)
    assert not after.plant.errors, (where, after.plant.errors[:2])
    made = before + cut(after, seen) if after is not machine else cut(machine)
    missing = wanted - made
    twice = made - wanted
    assert not missing, (where, len(missing), list(missing)[:3])
    assert set(twice) <= set(wanted) or job.near, (where, list(set(twice) - set(wanted))[:3])
    most = job.twice if kind in ("link", "host") else job.twice + job.steps_s * (EVERY_MS + AHEAD_MS) // 1000
    assert sum(twice.values()) <= most, (where, sum(twice.values()))
    return kind, sum(twice.values())


def survive(job, machine, kind, pages, rng):
    """What the failure leaves: the machine itself, or one that was switched on again where the operator has put it at its zero, or
    where it stands and homes."""
    if kind in ("link", "host"):
        if kind == "link":
            line = machine.lines[machine.first]
            line.incoming = line.incoming[: rng.randrange(len(line.incoming) + 1)]
        if job.alone:
            machine.settle()
        machine.run_ms(LOST_MS + rng.randrange(1200))
        assert not machine.plant.tool, "the tool is on, and no host is there"
        machine.take()
        return machine
    if kind == "loop":
        machine.port.advance(FROZEN_MS * 12_500)  # what lies in the ring plays
    pages = Pages(data=pages.data)
    start = [at + rng.randrange(-9, 10) for at in machine.plant.position[:3]] if job.homes else job.start
    return job.machine(pages, [max(at, 1) for at in start] if job.homes else start)


def went_on(job, machine, kind, over, where):
    known = kind in ("link", "host")
    with plugged(machine):
        try:
            job.resume(home=False, unverified=False)
            assert known, (where, "it went on from a place that is not known")
        except Failure as failure:
            text = str(failure)
            if "done to its end" in text:
                return
            if "another" in text:  # the power went before the first record
                assert not known or not cut(machine), where
                job.begin(machine, random.Random(0))
                return
            assert not known and "not known" in text, (where, text)
            job.resume(home=job.homes, unverified=not job.homes)


def resumed(job, home, unverified):
    resume.resume(job.file, "virtual", home=home, unverified=unverified, yes=True)
