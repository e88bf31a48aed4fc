"""The router of pulse files of the soak: streamed, stored in RAM and run from flash, by `passo` itself, in frames over a noisy wire or plain.

A round is a program at random. While it runs: noise, a cable that is cut and plugged in again, another link that wants to command, garbage on
it; and at most one event that ends a program: a stop, the stop of the other link, the button that halts, a cable that stays cut, a board that is
reset, a power cut that tears what is being written. Some of those programs are gone on with by `passo resume`, and that is cut, too.

These must hold, seen from the pins and the plant: the steps are those of the program, in their order, each once, with the tool as asked; all of
them, unless something has ended it; after the end nothing moves and the tool is off; the place that the board tells is the plant's;
jobs are there whole or not at all; the journal names a place that has been passed; and with the cuts of `passo resume` none is missing, and
only the cuts since the newest record are made twice.
"""

import re
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from counted_kills import AHEAD_MS
from host_tools import boards
from host_tools.cli import jobs, pulses, resume
from host_tools.clients.pulses import PulsesClient
from host_tools.failure import Failure
from host_tools.programs import stored_job
from host_tools.programs.long_pulses import LongFile
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.pages import Pages, PowerCut
from passo.protocols.pulses.codes import CODES
from passo.protocols.pulses.protocol import frame
from soak_bench import Cabled, Wrong
from soak_flash import Flash

START = (16_000, 16_000, 4000)
REACH = 1500  # steps from there
INTERVAL_US = 312
SETUP_US = 10  # twice, where tool and direction change: the next interval pays it back
LEAST_TICKS = [(INTERVAL_US - 2 * SETUP_US) * 12.5] * 3
LOST_MS = 4000  # longer than answers may be on their way over a noisy wire
EVERY_MS = 100
FLASH = 48 * 1024
LAST = 20
ENOUGH = 1 << 40  # bytes of flash: no power cut any more
CUT_SHORT = "STEP pulse too short"  # a stop at once cuts it short; the step counts
HARMLESS = ("fight", "garbage", "noise", "cut", "question")
ENDS = ("stop", "other stop", "button", "long cut", "board", "power", "power")
GONE = ("power", "board")
LETTERS = {
    chr(65 + letter): tuple((code >> axis & 1) * (-1 if code >> 4 + axis & 1 else 1) for axis in range(3)) for letter, code in enumerate(CODES) if code & 7
}  # fmt: skip


def board():
    made = boards.load("lpt_router")
    made["journal"] = {"every_ms": EVERY_MS}
    made["jobs"] = {"language": "pulses"}
    made["links"][0].update(frames=True, lost_ms=LOST_MS)
    made["links"].append({"name": "panel", "port": "uart1", "tx": 20, "rx": 21, "baud": 57_600, "protocol": "pulses"})
    return made


class Program:
    """A pulse file, and its steps as rows of (x, y, z, tool) from `place` on."""

    def __init__(self, dice, place, zero, times):
        self.dice, self._zero = dice, zero
        self.text, self._moves, self._lit = "[)+2400 ", [], 0
        self._at = list(place)
        makers = (self.run, self.run, self.run, self.burst, self.tool, self.wait, self.speed)
        for _ in range(dice.randint(4, 40)):
            dice.choice(makers)()
        self.text += ")]"
        moves = np.array(self._moves or [(0, 0, 0, 0)][:0], dtype=np.int64).reshape(-1, 4)
        self.whole = np.vstack([moves] * times)
        self.whole[:, :3] = np.cumsum(self.whole[:, :3], axis=0) + np.array(place)

    def _add(self, letter, count):
        step = LETTERS[letter]
        self.text += letter * count
        self._moves += [(*step, self._lit)] * count
        for axis in range(3):
            self._at[axis] += count * step[axis]

    def run(self):
        """Towards the middle, if it is far from there."""
        letter = self.dice.choice(sorted(LETTERS))
        away = any(abs(self._at[axis] - self._zero[axis]) > REACH // 2 and LETTERS[letter][axis] * (self._at[axis] - self._zero[axis]) > 0 for axis in range(3))
        if not away:
            self._add(letter, self.dice.randint(1, 300))

    def burst(self):
        letters = self.dice.sample(sorted(LETTERS), 3)
        for _ in range(self.dice.randint(5, 60)):
            letter = self.dice.choice(letters)
            if all(abs(self._at[axis] - self._zero[axis]) < REACH for axis in range(3)):
                self._add(letter, self.dice.randint(1, 4))

    def tool(self):
        self._lit = 1 - self._lit
        self.text += ")("[self._lit]

    def wait(self):
        self.text += f"*{self.dice.randint(0, 200)} "

    def speed(self):
        self.text += f"+{self.dice.randint(300, 2400)} "


class Pulses(Cabled):
    NAME = "pulses"

    def __init__(self, seed):
        super().__init__(seed)
        self.board = board()
        self.board["links"][0]["lost"] = self.policy = self.dice.choice(("go_on", "go_on", "pause", "stop"))
        self.folder = tempfile.TemporaryDirectory(prefix="passo-")
        self.flash = Flash(FLASH)
        self.jobs = {}  # name: CRC-32 of the stored job
        self.note(f"seed {seed}, lost host: {self.policy}")
        self.boot(START, Pages())

    def close(self):
        self.machine.close()
        self.flash.unmount()
        self.folder.cleanup()

    def boot(self, start, pages):
        """Switched on where its carriages have been put."""
        self.pages = pages
        self.flash = Flash(FLASH, self.flash.files)
        self.flash.mount()
        self.forget()
        self.switch_on(VirtualMachine(self.board, trace=None, pages=pages, start=start, seed=self.dice.randrange(1 << 30)), LEAST_TICKS)
        self.zero = list(start)
        self.line.renew(self.now_ms())
        self.run_ms(100)
        self.line.arrived = b""
        if self.place() != list(start) or self.machine.plant.tool:
            raise Wrong("a board that has just been switched on moves")

    def place(self):
        return list(self.machine.plant.position)

    # --- a round

    def round(self):
        self.rounds += 1
        self.forget()
        self.machine.plant.errors.clear()
        self.ended = ""
        self.way = self.dice.choice(("stream", "stored", "job"))
        self.framed = self.dice.random() < 0.7
        times = self.dice.choice((1, 1, 2)) if self.way != "job" else 1
        program = Program(self.dice, self.place(), self.zero, times)
        self.note(f"round {self.rounds}: {self.way}{', frames' if self.framed else ''}, {len(program.whole)} steps")
        path = Path(self.folder.name) / "part.txt"
        path.write_text(program.text)
        begun = self.place()
        self.witness.take()
        self.told = ""
        try:
            self.play(path, times, program)
            if self.ended:
                self.await_end()
        except PowerCut:
            self.gone()
        self.forget()
        self.pages.cut_after(ENOUGH)
        self.count_noise()
        self.judge(program)
        goes_on = self.dice.random() < 0.6 and (len(self.rows) or times == 1)  # the number of passes is sent as it begins
        if goes_on and (self.ended in GONE or self.ended == "long cut" and not self.alone()):
            self.resume(path, program, begun)
        elif self.ended in GONE:
            self.boot(self.place(), Pages(data=self.pages.data))
        self.recover()
        if not self.rounds % 5:
            self.jump()
        if not self.rounds % LAST:
            self.check_heap()

    def play(self, path, times, program):
        if self.framed:
            self.line.set(self.dice.choice((0, 0.003, 0.01)))
        where = {"port": "pc", "baud": 115_200}
        try:
            with self.passo(self.framed):
                if self.way == "job":
                    self.store(path, where)
                    self.plan(program)
                    jobs.run(self.name, home=False, wait=True, protocol="pulses", **where)
                else:
                    self.plan(program)
                    pulses.play(path, times, None, self.way == "stream", None, False, wait=True, log=None, **where)
        except Failure as failure:
            self.told = str(failure)
            self.note(f"passo: {failure}")
            if not self.ended:
                raise Wrong(f"passo has failed though nothing has happened: {failure}") from None

    def store(self, path, where):
        """A job; others are deleted until there is room for it."""
        self.name = f"J{self.dice.randrange(6)}"
        while True:
            try:
                jobs.store(path, self.name, None, None, False, protocol="pulses", **where)
                break
            except Failure as failure:
                if "free" not in str(failure) or not self.jobs:
                    raise
                self.fault("full flash")
                name = self.dice.choice(sorted(self.jobs))
                jobs.delete(name, protocol="pulses", **where)
                del self.jobs[name]
        self.jobs[self.name] = stored_job.crc_of(stored_job.KINDS["pulses"][0](path))

    def plan(self, program):
        lasts_ms = 500 + len(program.whole)
        for _ in range(self.dice.randint(0, 5)):
            kind = self.dice.choice(HARMLESS)
            self.after(self.dice.uniform(0, lasts_ms), lambda kind=kind: self.harmless(kind))
        if self.dice.random() < 0.6:
            kind = self.dice.choice(ENDS)
            if kind == "power":
                at = self.dice.randrange(0, 600)
                self.after(self.dice.uniform(0, lasts_ms), lambda: self.ended or self.pages.cut_after(at))
            self.after(self.dice.uniform(0, lasts_ms), lambda: self.end(kind))

    def harmless(self, kind):
        if self.ended or not self.line.plugged:
            return
        if kind == "fight":
            self.fault("fight")
            for words in (("jog", "x", 50), ("tool", "on"), ("run",), ("back",), ("speed", 60), ("load",), ("$FD=J0",), ("drives", "off")):
                self.machine.send(frame(*words), "panel")
        elif kind == "garbage":
            self.fault("garbage")
            self.machine.send(bytes(self.dice.choice([byte for byte in range(256) if byte != 0x7B]) for _ in range(40)), "panel")
        elif kind == "question":
            self.machine.send(frame("?") + frame("log"), "panel")
        elif kind == "noise" and self.framed:
            self.line.set(self.dice.choice((0, 0.003, 0.01)))
        elif kind == "cut" and self.framed:
            self.fault("short cut")
            self.unplug(self.dice.uniform(5, 700))

    def end(self, kind):
        if self.ended:
            return
        if kind == "stop" and (self.framed or not self.line.plugged):
            kind = "other stop"  # the session of frames is another program's
        self.ended = kind
        self.fault(kind)
        if kind == "stop":
            self.line.wires[0].put(frame("stop"))
        elif kind == "other stop":
            self.machine.send(frame("stop"), "panel")
        elif kind == "button":
            self.press(True)
        elif kind == "long cut":
            self.unplug(1e9)
        else:
            raise PowerCut

    def press(self, active):
        self.machine.plant.set_input(self.machine.port.now, "stop", active)

    def alone(self):
        """True if a lost host changes nothing."""
        return self.way == "job" or self.policy == "go_on" and self.way == "stored"

    def await_end(self):
        self.forget()
        if self.ended == "long cut":
            self.line.plugged = False
            self.run_ms(LOST_MS + 1000)
        else:
            self.run_ms(400)
        self.await_stand()

    def await_stand(self):
        """A stream whose host is lost may wait for more for ever."""
        before, end_ms = None, self.now_ms() + 60_000
        while before != self.place() or self.moving() and not self.ended == "long cut":
            before = self.place()
            self.run_ms(500)
            if self.now_ms() > end_ms:
                raise Wrong(f"it goes on behind: {self.ended}")

    def gone(self):
        """The power is gone; the board is not on again."""
        self.ended = self.ended or "power"
        self.faults["torn page"] += self.pages._left == 0
        self.note("the board is switched off")

    # --- what has been done

    def judge(self, program):
        if self.ended not in GONE:
            if not self.ended:
                self.settle()
            if self.ended and not (self.ended == "long cut" and self.alone()):
                self.check_stands(tool_off=self.ended != "long cut" or self.policy == "stop")
            self.check_late()
        steps = self.witness.take()
        steps.check_intervals(strict=False)
        rows = np.column_stack((steps.places, steps.tools > 0))
        count = len(rows)
        self.rows = rows
        self.note(f"{self.ended or 'ended'}: {count} of {len(program.whole)} steps")
        self.check_path(rows, program.whole[:count])
        if count < len(program.whole) and (not self.ended or count and self.ended == "long cut" and self.alone()):
            raise Wrong(f"only {count} of {len(program.whole)} steps are made")
        if count and rows[-1, :3].tolist() != self.place():
            raise Wrong(f"it stands at {self.place()}, and its path ends at {rows[-1].tolist()}")
        self.check_plant((CUT_SHORT,) if self.ended else ())

    def check_path(self, rows, wanted):
        if len(wanted) < len(rows) or (rows != wanted).any():
            same = (rows[: len(wanted)] == wanted).all(axis=1)
            at = int(np.argmin(same)) if not same.all() else len(wanted)
            raise Wrong(f"step {at} leads to {rows[at].tolist()}, not {wanted[at].tolist() if at < len(wanted) else 'anywhere'}")

    def resume(self, path, program, begun):
        """As an operator does: the carriages are put where they were switched on, if the board cannot know where they are."""
        cuts = [self.rows]
        before = Counter(map(tuple, self.rows[self.rows[:, 3] > 0].tolist()))
        spent = EVERY_MS + AHEAD_MS
        times = 1
        while True:
            known = self.ended not in GONE
            if not known:
                self.boot(self.zero, Pages(data=self.pages.data))
                self.check_journal(path, begun, cuts)
            self.restore()
            self.ended = ""
            self.fault("resume")
            if times < 4 and self.dice.random() < 0.3:
                times += 1
                self.after(self.dice.uniform(0, 12_000), lambda: self.end(self.dice.choice(GONE)))
            try:
                with self.passo(self.framed):
                    resume.resume(path, "pc", 115_200, "pulses", home=False, unverified=not known, yes=True)
                self.forget()
                said = ""
            except Failure as failure:
                said = str(failure)
                self.note(f"passo resume: {said}")
            except PowerCut:
                self.gone()
            if not self.ended:
                self.settle()
            cuts.append(self.taken())
            if not self.ended:
                break
        made = sum([Counter(map(tuple, rows[rows[:, 3] > 0].tolist())) for rows in cuts[1:]], Counter(before))
        wanted = Counter(map(tuple, program.whole[program.whole[:, 3] > 0].tolist()))
        if ("another" in said or "is empty" in said) and not any(len(rows) for rows in cuts):
            return  # it had not begun
        if said and "done to its end" not in said:
            raise Wrong(f"passo resume: {said}")
        missing, extra, twice = wanted - made, set(made) - set(wanted), sum((made - wanted).values())
        if missing or extra:
            raise Wrong(f"missing: {sum(missing.values())}, {list(missing)[:2]}; not asked for: {len(extra)}, {list(extra)[:2]}")
        if twice > times * spent * 1000 // INTERVAL_US:
            raise Wrong(f"{twice} steps are cut twice")
        self.check_plant((CUT_SHORT,))

    def taken(self):
        steps = self.witness.take()
        return np.column_stack((steps.places, steps.tools > 0))

    def check_journal(self, path, begun, cuts):
        """Check that the program was at the place that the journal has."""
        with self.passo(False), PulsesClient("pc") as client:
            said = client.ask("$JR")
        found = [re.fullmatch(r"\[JOURNAL:([0-9a-f]+)\|(\d+)\|(\d+)\|([-\d,]+)\]", line) for line in said]
        if len(found) != 1 or not found[0]:
            raise Wrong(f"$JR is answered with {said}")
        if int(found[0][1], 16) != LongFile(path, "xyz").job_number() or not int(found[0][2]):
            return
        place = tuple(int(at) + zero for at, zero in zip(found[0][4].split(","), self.zero))
        if place not in {tuple(begun), *(tuple(row[:3]) for rows in cuts for row in rows.tolist())}:
            raise Wrong(f"the journal says {found[0][0]}, which the path has not passed")

    # --- the operator's way out

    def restore(self):
        """The cable is in, and quiet; no button is pressed."""
        self.forget()
        self.line.set(0)
        self.line.plugged = True
        self.press(False)
        self.run_ms(60)

    def recover(self):
        self.restore()
        self.machine.take("panel")
        with self.passo(True), PulsesClient("pc") as client:
            client.command("stop")
            if client.status()["state"] == "alarm":
                client.command("unlock")
            status = client.status()
            if status["state"] != "idle" or status["tool"] != "0":
                raise Wrong(f"after a stop the board is {status}")
            there = [int(at) + zero for at, zero in zip(status["place"].split(","), self.zero)]
            if max(abs(told - at) for told, at in zip(there, self.place())) > (1 if self.ended else 0):
                raise Wrong(f"the board says it is at {there}, and it is at {self.place()}")
            self.zero = [zero + at - told for zero, at, told in zip(self.zero, self.place(), there)]
            found = {name: crc for name, (_, _, crc, _) in jobs._list_jobs(client)[0].items()}
            if found != self.jobs:
                raise Wrong(f"stored jobs: {found}, and not {self.jobs}")
        self.check_stands()
        self.check_plant()
