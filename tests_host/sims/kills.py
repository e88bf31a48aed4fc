"""Programs whose link, PC, main loop or power is killed at random moments, and which are gone on with.

    for kill, wrong, story in killed(job, kills_of(100, seed)): …      # job: one of kill_jobs.py; wrong: "", or what went wrong
    with Pc(bench): …                               # the PC's own programs, `passo stream` and `passo resume`, in virtual time

One run of a program serves all its kills: at the moment of each the process forks, the child carries out the kill, resumes as an
operator would, and judges; the parent goes on. The PC's code is the real one; only its clock and its port are the machine's.
Cuts, and whether outputs are safe, are read from the plant.

The failures, KINDS:

    link        what the PC writes is torn at any byte, and nothing comes through any more; the board goes on alone
    process     the PC's program is gone; all that it has written comes through
    freeze      the main loop does not run any more: interrupts go on, and after a second the watchdog resets
    power       memory is gone; flash is as it is
    torn        the same, amid the next write of flash: at any of its bytes
    reset       another program sends Ctrl-X
    fail        the power-fail input becomes active; 15 ms later the power is gone
"""

import contextlib
import io
import json
import os
import random
import sys
import tempfile
import traceback
from pathlib import Path

from host_tools.cli import jobs, resume, stream
from host_tools.clients import frames, grbl, serial_port
from host_tools.failure import Failure
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.pages import Pages, PowerCut
from passo.config.journal import MemorySlots
from passo.records import LEAD_TICKS, TICKS_PER_MS

KINDS = ("link", "process", "freeze", "power", "torn", "reset", "fail")
GONE = ("freeze", "power", "torn", "fail")  # the board begins anew
NEAR = 2  # steps: the most that rounding makes
START = (1500, 1200, -900)
LOST_MS = 1000
FREEZE_MS = 1000  # until the watchdog resets
HEARTBEAT_MS = 170  # until interrupts bring the machine to a stand
FEED_MS = 3
LASTS_MS = 15  # the capacitors
BAUD = 115_200


class Killed(Exception):
    """The PC's program is no more, or nothing that it says comes through."""


class Slots(MemorySlots):
    """Settings in memory that a power cut tears, as it does `pages`."""

    def __init__(self, pages):
        super().__init__()
        self._pages = pages

    def write(self, slot, data):
        self.data[slot] = b""
        for at in range(len(data)):
            self._pages.spend_power()
            self.data[slot] = data[: at + 1]


class Flash:
    """The memory that outlasts a power cut. `folder`: of stored jobs."""

    def __init__(self, folder):
        self.folder = folder
        self.pages = Pages()
        self.slots = Slots(self.pages)

    def after_cut(self):
        """The same, of the next start."""
        kept = Flash(self.folder)
        kept.pages.data[:] = self.pages.data
        kept.slots.data[:] = self.slots.data
        return kept


class Record:
    """In place of a trace: where the tool was while it was on, and where it was dragged while it was off.
    `depth`: steps of Z below which it is in the work; None: a laser."""

    def __init__(self, depth):
        self.rows = []  # (tick, x, y, z, tool)
        self.dragged = []
        self._depth = depth
        self._last = None

    def add_row(self, tick, position, tool):
        if tool:
            self.rows.append((tick, *position, tool))
        elif self._depth is not None and position[2] < self._depth and self._last and self._last != tuple(position[:2]):
            self.dragged.append((tick, *position))
        self._last = tuple(position[:2])


class Bench:
    """A machine, from one start of its board to the next."""

    def __init__(self, job, flash, start=START):
        self.job = job
        self.flash = flash
        self.first = 0  # of the record's rows: the first that is not judged yet
        self.resumed = False
        self.recorded = 0  # tick of the newest record that is whole
        write = flash.pages.write

        def written(*args):
            write(*args)
            self.recorded = self.machine.port.now

        flash.pages.write = written
        self.machine = VirtualMachine(
            job.board(), trace=None, flash=flash.folder, pages=flash.pages, slots=flash.slots, start=start[: job.axes]
        )
        self.record = self.machine.plant.trace = Record(job.depth)

    def zero(self):
        """The plant's place of the machine's zero. At a stand."""
        return [place - at for place, at in zip(self.machine.plant.position, self.machine.app.controller.position())]

    def cells(self, first=0, until=None):
        """Return {place: power} of the cuts, from machine zero."""
        zero = self.zero()
        depth = self.job.depth
        found = {}
        for tick, *place, tool in self.record.rows[first:]:
            place = tuple(at - by for at, by in zip(place, zero))
            if (until is None or tick <= until) and (depth is None or place[2] < depth):
                found.setdefault(place, tool)  # the power at the first pass
        return found

    def freeze(self):
        """The main loop stands; interrupts go on feeding, and come to a stand once they notice. Then the watchdog resets."""
        app = self.machine.app
        for at_ms in range(0, FREEZE_MS, FEED_MS):
            app.feeder.brake = at_ms > HEARTBEAT_MS
            if app.feeder.open:
                app.feeder.fill(app.player.words_played(), LEAD_TICKS)
                app.player.start()
            self.machine.port.advance(FEED_MS * TICKS_PER_MS)

    def alone(self):
        """Run the machine without a host, until it has done nothing for LOST_MS + 500."""
        machine = self.machine
        quiet_ms = machine.now_ms()
        while machine.now_ms() - quiet_ms < LOST_MS + 500:
            machine.cycle()
            if machine.port.pending(machine.app.controller.busy()):
                quiet_ms = machine.now_ms()

    def reboot(self):
        """The same machine after a power cut or the watchdog's reset: its carriages stand where they stood."""
        after = Bench(self.job, self.flash.after_cut(), self.machine.plant.position)
        after.machine.run_ms(50)
        return after


class Wire:
    """The PC's end of a serial port, in memory: reading it lets the machine's time pass."""

    baudrate = BAUD
    timeout = 0.02

    def __init__(self, pc, link):
        self._pc = pc
        self._link = link
        self._bench = pc.bench
        self._arrived = b""

    @property
    def in_waiting(self):
        return len(self._arrived)

    def read(self, size=1):
        if not self._arrived:
            self._pc.turn()
            if self._pc.dead:
                return b""
            self._arrived = self._bench.machine.take(self._link)
        data, self._arrived = self._arrived[:size], self._arrived[size:]
        return data

    def write(self, data):
        if self._pc.dead:
            return
        self._bench.machine.send(self._pc.torn(bytes(data)), self._link)
        if self._pc.dead:
            raise Killed

    def reset_input_buffer(self):
        self._arrived = b""
        self._bench.machine.take(self._link)

    def close(self):
        pass


class Pc:
    """The PC: its programs run in the time of `bench`'s machine. `kills`: [(at_ms, kill)], whose moments count from now on."""

    def __init__(self, bench):
        self.bench = bench
        self.dead = False
        self.kills = []
        self.strike = None  # called with the kill as its moment comes
        self._tear = None
        self._dead_s = 0.0
        self._patches = contextlib.ExitStack()

    def __enter__(self):
        for module, name, value in (
            (grbl, "time", self), (frames, "time", self), (stream, "time", self), (jobs, "time", self),
            (serial_port, "open_exclusively", lambda *_: Wire(self, self.bench.job.link)),
        ):  # fmt: skip
            self._patches.callback(setattr, module, name, getattr(module, name))
            setattr(module, name, value)
        return self

    def __exit__(self, *_):
        self._patches.close()

    # --- the module `time`

    def monotonic(self):
        return self.bench.machine.now_ms() / 1000 + self._dead_s

    time = monotonic

    def monotonic_ns(self):
        return int(self.monotonic() * 1e9)

    def sleep(self, seconds):
        end = self.monotonic() + seconds
        while self.monotonic() < end:
            self.turn()

    # ---

    def turn(self):
        """A while of waiting, in which the machine goes on."""
        if self.dead:
            self._dead_s += 0.02
            return
        self.bench.machine.cycle()
        while self.kills and self.bench.machine.now_ms() >= self.kills[0][0]:
            self.strike(self.kills.pop(0)[1])

    def tear(self, left):
        """Of the next write only `left` bytes come through, and nothing after them."""
        self._tear = left

    def torn(self, data):
        if self._tear is None:
            return data
        self.dead = True
        return data[: self._tear % max(1, len(data))]

    def die(self):
        self.dead = True
        raise Killed

    def revive(self, bench):
        """The PC's next program."""
        self.bench = bench
        self.dead = False
        self._tear = None
        self._dead_s = 0.0


# --- kills


class Course:
    """A program that is begun on a machine that has been homed."""

    def __init__(self, job, folder):
        self.job = job
        self.path = Path(folder) / "job.nc"
        self.path.write_bytes(job.text)
        self.bench = Bench(job, Flash(folder))
        self.pc = Pc(self.bench)

    def begin(self):
        with grbl.GrblClient("memory") as client:
            client.connect()
            client.command("$H", 600)
        self.job.prepare(self.path)

    def run(self):
        self.job.run(self.path)
        self.bench.machine.settle()


def whole(job):
    """(what is cut, places that are passed more than once, when it begins and ends, ms)."""
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        course = Course(job, folder)
        with course.pc:
            course.begin()
            first_ms = course.bench.machine.now_ms()
            course.run()
        bench = course.bench
        assert not bench.record.dragged and not bench.machine.plant.errors
        cells = bench.cells()
        zero, seen, last, again = bench.zero(), set(), None, set()
        for _, *place, _ in bench.record.rows:
            place = tuple(at - by for at, by in zip(place, zero))
            if place in seen and place != last:
                again.add(place)
            seen.add(place)
            last = place
        return cells, again, first_ms, bench.machine.now_ms()


def resume_file(path, **how):
    """`passo resume`, of the PC under way."""
    resume.resume(path, "memory", BAUD, **how)


def near(place, cells):
    """True if one of `cells` is this place, or as near as rounding may bring it."""
    steps = range(-NEAR, NEAR + 1)
    if len(place) == 2:
        return any((place[0] + x, place[1] + y) in cells for x in steps for y in steps)
    return any((place[0] + x, place[1] + y, place[2] + z) in cells for x in steps for y in steps for z in steps)


class Round:
    """One kill, or several, and the checks after it. Lives in a process of its own."""

    def __init__(self, course, wanted, kill):
        self.course = course
        self.pc = course.pc
        self.job = course.job
        self.cells, self.again, first_ms, last_ms = wanted
        self.lasts_ms = last_ms - first_ms
        self.kill = kill
        self.rng = random.Random(f"round {kill['seed']}")
        self.done = set()  # places cut, which may not be cut again
        self.seen = set()  # places cut
        self.places = []  # columns where the tool went down
        self.story = []

    def struck(self, kind):
        """The moment has come, within the PC's program."""
        pc, rng = self.pc, self.rng
        pc.kills = []
        if kind == "link":
            pc.tear(rng.randrange(1, 60))
            end_ms = pc.bench.machine.now_ms() + rng.choice((0, 50, 400))
            pc.kills = [(end_ms, "process")]
            pc.strike = lambda _: pc.die()
        elif kind == "torn":
            pc.bench.flash.pages.cut_after(rng.choice((rng.randrange(32), rng.randrange(200), rng.randrange(3000))), rng.random())
        else:
            pc.die()

    def fell(self, kind):
        """Let the machine react to the end of the PC. Outputs are safe then. Returns the bench from now on, and whether nothing was lost."""
        bench, rng = self.pc.bench, self.rng
        machine = bench.machine
        if kind in ("link", "process"):
            bench.alone()
        elif kind == "reset":
            machine.send(b"\x18", self.job.other)
            machine.run_ms(300)
        elif kind == "fail":
            machine.plant.set_input(machine.port.now, "power", True)
            machine.run_ms(LASTS_MS)
            self.check(machine.plant.tool == 0, "the tool is on while the capacitors last")
        elif kind == "freeze":
            bench.freeze()
        else:
            machine.port.advance(rng.randrange(8 * TICKS_PER_MS))
        self.judge_plant(bench)
        lost = kind in GONE
        self.settle(bench, bench.recorded if lost else None)
        if lost:
            bench = bench.reboot()
        if self.job.lost == "stop" or kind not in ("link", "process"):
            self.check(bench.machine.plant.tool == 0, f"the tool is on: {bench.machine.plant.tool}, {bench.machine.app.controller.state}")
        bench.first = len(bench.record.rows)
        return bench

    def settle(self, bench, until):
        """Judge the cuts since the machine was resumed; places that the journal has, up to tick `until`, may not be cut again."""
        cut = bench.cells(bench.first)
        if not cut:
            return
        if bench.resumed:
            place = next(iter(cut))[:2]
            self.places.append(place)
            self.check(near(place, {other[:2] for other in self.cells}), f"went down at {place}")
        twice = [place for place in cut if place in self.done and not near(place, self.again) and not self.beside(place)]
        self.check(not twice, f"cut twice: {len(twice)}, {twice[:2]}")
        extra = [place for place in cut if place not in self.cells and not near(place, self.cells) and not self.beside(place)]
        self.check(not extra, f"cut beside: {len(extra)}, {extra[:2]}")
        if self.job.depth is None:
            other = [place for place, tool in cut.items() if self.cells.get(place, tool) != tool and not self.close(place)]
            self.check(not other, f"other power: {len(other)}, {[(at, cut[at], self.cells[at]) for at in other[:2]]}")
        self.seen |= set(cut)
        self.done |= set(cut if until is None else bench.cells(bench.first, until))

    def beside(self, place):
        return any(abs(place[0] - x) <= NEAR and abs(place[1] - y) <= NEAR for x, y in self.places)

    def close(self, place):
        return any(abs(place[0] - x) + abs(place[1] - y) <= 160 for x, y in self.places)

    def judge_plant(self, bench):
        """A stop inside a word may end a pulse too soon: then its place is not sure to a step, and it homes."""
        found = [text for _, text in bench.machine.plant.errors if text != "STEP pulse too short"]
        self.check(not found, f"the plant: {found[:2]}")
        self.check(not bench.record.dragged, f"dragged through the work: {bench.record.dragged[:2]}")

    def check(self, right, text):
        if not right:
            raise AssertionError(text)

    def go_on(self, bench):
        """As an operator does: asks first, and homes if that is wanted. True if something was left to do."""
        self.pc.revive(bench)
        bench.resumed = True
        said = self.resume(yes=True)
        if said and "held" in said:
            bench.machine.send(b"\x18", self.job.link)
            bench.machine.run_ms(300)
            said = self.resume(yes=True)
        if said and "give --home" in said:
            self.story.append("home")
            self.check(bench.machine.plant.tool == 0 and len(bench.record.rows) == bench.first, "it moved before it was homed")
            said = self.resume(yes=True, home=True)
        if said and ("another file" in said or "is empty" in said) and not self.done:
            return self.begin_anew(bench)
        if said:
            self.check("done to its end" in said or self.job.forgotten and "is empty" in said, said)
            self.story.append("done")
            return False
        return True

    def begin_anew(self, bench):
        """The program had not begun."""
        self.story.append("anew")
        with grbl.GrblClient("memory") as client:
            client.connect()
            client.command("$H", 600)
        self.job.run(self.course.path)
        bench.machine.settle()
        return True

    def resume(self, **how):
        try:
            resume_file(self.course.path, **how)
        except Failure as failure:
            return str(failure)
        self.pc.bench.machine.settle()
        return ""


    def after(self):
        """Behind the first kill."""
        kind = self.kill["kind"]
        self.story.append(kind)
        bench = self.fell(kind)
        for again in self.kill["again"]:
            self.pc.kills = []
            begun_ms = bench.machine.now_ms()
            share, kind = again
            self.pc.revive(bench)
            self.pc.strike = self.struck
            self.pc.kills = [(begun_ms + share * ((1 - self.kill["at"]) * self.lasts_ms + 3000), kind)]
            try:
                more = self.go_on(bench)
                self.pc.kills = []
                if not more:
                    break
                self.story.append(f"{kind} behind the end")
            except (Killed, PowerCut):
                self.story.append(kind)
            bench.flash.pages.cut_after(1 << 30)
            bench = self.fell(kind)
        self.pc.kills = []
        self.go_on(bench)
        bench = self.pc.bench
        self.check(bench.machine.plant.tool == 0, "the tool is on at the end")
        self.judge_plant(bench)
        self.settle(bench, None)
        missing = [place for place in self.cells if place not in self.seen and not near(place, self.seen)]
        self.check(not missing, f"missing: {len(missing)}, {missing[:2]}")


def kill_of(seed, kind=None, kinds=KINDS):
    """A moment, and one of `kinds` unless it is given, by the seed; of every fourth the resumption is killed, too: `again`."""
    rng = random.Random(seed)
    again = [(rng.random(), rng.choice(kinds))] if rng.random() < 0.25 else []
    return {"seed": seed, "at": rng.random(), "kind": kind or rng.choice(kinds), "again": again}


def kills_of(count, seed, first=0):
    """`count` of them, of all kinds in turn from the kind `first` on."""
    return [kill_of(f"{seed} {number}", KINDS[(first + number) % len(KINDS)]) for number in range(count)]


def killed(job, kills):
    """Carry out `kills`, of kills_of(). Returns [(kill, "" or what went wrong, what happened)]."""
    wanted = whole(job)
    _, _, first_ms, last_ms = wanted
    results = []
    sys.stdout.flush()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        course = Course(job, folder)
        pc = course.pc
        with pc:
            course.begin()
            told = {}

            def strike(kill):
                reading, writing = os.pipe()
                child = os.fork()
                if child:
                    os.close(writing)
                    with os.fdopen(reading) as file:
                        results.append((kill, *json.loads(file.read() or '["the process ended", []]')))
                    os.waitpid(child, 0)
                    return
                told.update(pipe=writing, round=Round(course, wanted, kill))
                told["round"].struck(kill["kind"])

            pc.kills = [(first_ms + kill["at"] * (last_ms - first_ms), kill) for kill in sorted(kills, key=lambda kill: kill["at"])]
            pc.strike = strike
            try:
                course.run()
            except BaseException as error:
                if "round" not in told:
                    raise
                told["error"] = error
            if "round" in told:
                _end(told["round"], told["pipe"], told.get("error"))
    return results


def _end(around, pipe, error):
    """Judge in the child and end it; `error`: the exception that ended the PC's program."""
    said = ""
    try:
        if not isinstance(error, (Killed, PowerCut, type(None))):
            raise error
        around.after()
    except AssertionError as error:
        said = str(error)
    except BaseException:
        said = traceback.format_exc()
    finally:
        os.write(pipe, json.dumps([said, around.story]).encode()[:60_000])
        os._exit(0)
