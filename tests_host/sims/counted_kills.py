"""Pulse programs and drawings interrupted at random moments, and gone on with by `passo resume` itself.

    kill(job, seed)     # one interruption and its resumption; asserts that the picture is the whole one, and nothing is cut twice

Any of these fails: the cable, amid a message; the PC's process; the board's main loop, after which the watchdog resets it; the power, while the
flash is written torn at any byte. The board is virtual, its time too; the PC is the commands of `passo` (virtual_wire.py). The pins' history is read from the
plant.
"""

import random
from collections import Counter

from host_tools.cli import resume
from host_tools.failure import Failure
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.pages import Pages, PowerCut
from virtual_wire import Killed, plugged

KINDS = ("link", "host", "loop", "power")
AHEAD_MS = 50  # of words, and a cycle
FROZEN_MS = 1200  # longer than the watchdog waits
EVERY_MS = 100


class Job:
    """A job to interrupt. A subclass has begin(machine, rng), the PC's part to the end of the job, and says what its machine is."""

    file = None  # its path
    board = None
    zero = (0, 0, 0)  # the plant's coordinates of the machine's zero
    homes = False
    lost_ms = 400  # longer than the PC ever says nothing
    alone = False  # it needs no PC

    def machine(self, pages, start):
        made = VirtualMachine(self.board(), pages=pages, start=start)
        made.cycle()
        made.take()
        return made


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

    def _program_byte(self, at, byte):
        super()._program_byte(at, byte)
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
    try:
        with plugged(machine, at):
            job.begin(machine, rng)
    except (Killed, PowerCut):
        pass
    where = f"{job.name} {seed} {kind}"
    machines = [machine]
    known = kind in ("link", "host")
    after = survive(job, machine, kind, pages, rng)
    if after is not machine:
        machines.append(after)
    if rng.random() < 0.3:  # the resumption is interrupted as well
        try:
            with plugged(after, rng.randrange(1, cycles)):
                go_on(job, after, known, where)
        except Killed:
            survive(job, after, "host", pages, rng)
        known = None
    with plugged(after):
        go_on(job, after, known, where)
    for each in machines:
        assert not each.plant.errors, (where, each.plant.errors[:2])
    assert not after.plant.tool, where
    made = sum([cut(each) for each in machines], Counter())
    if job.near:
        missing, extra = set(wanted) - beside(made), set(made) - beside(wanted)
        twice = max(sum(made.values()) - sum(wanted.values()), 0)
    else:
        missing, extra = wanted - made, set(made) - set(wanted)
        twice = sum((made - wanted).values())
    assert not missing, (where, len(missing), list(missing)[:3])
    assert not extra, (where, len(extra), list(extra)[:3])
    most = 2 * job.twice if kind in ("link", "host") else 2 * job.twice + job.steps_s * (EVERY_MS + AHEAD_MS) // 1000
    assert twice <= most, (where, twice)
    return kind, twice


def beside(places):
    """The places, and those a step beside them."""
    return {(x + dx, y + dy, *rest) for x, y, *rest in places for dx in (-1, 0, 1) for dy in (-1, 0, 1)}


def survive(job, machine, kind, pages, rng):
    """Return the machine after the failure: itself, or one that was switched on again at the place where the operator has put it at its zero, or where it
    stands and homes.
    """
    if kind in ("link", "host"):
        if kind == "link":
            line = machine.lines[machine.first]
            line.incoming = line.incoming[: rng.randrange(len(line.incoming) + 1)]
        if job.alone:
            machine.settle()
        machine.run_ms(job.lost_ms + rng.randrange(1200))
        assert not machine.plant.tool, "the tool is on, and no host is there"
        machine.take()
        return machine
    if kind == "loop":
        machine.port.advance(FROZEN_MS * 12_500)  # the words in the ring play
    pages = Pages(data=pages.data)
    if not job.homes:
        return job.machine(pages, job.start)
    return job.machine(pages, [max(at + rng.randrange(-9, 10), 1) for at in machine.plant.position[: len(job.start)]])


def go_on(job, machine, known, where):
    """The operator's part. `known`: whether the board must know its position; None: it may."""
    try:
        job.resume(home=False, unverified=False)
        assert known is not False, (where, "it went on from a place that is not known")
    except Failure as failure:
        text = str(failure)
        if "done to its end" in text:
            return
        if "another" in text or "is empty" in text:  # it failed before the first record
            assert not cut(machine), where
            job.begin(machine, random.Random(0))
            return
        assert not known and "not known" in text, (where, text)
        job.resume(home=job.homes, unverified=not job.homes)


def resumed(job, home, unverified):
    resume.resume(job.file, "virtual", home=home, unverified=unverified, yes=True)
