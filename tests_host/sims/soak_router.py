"""The router of the soak: G-code in frames over a noisy wire, in plain text, and as stored jobs, while everything fails.

    router = Router(seed=1)
    for _ in range(100):
        router.round()          # raises Wrong

A round is a program at random, over one of the two links or as a stored job. While it runs: noise on the wire, a cable that is cut and
plugged in again, holds, overrides, the door, the other link that wants to command, garbage on it, jobs that it wants stored or
deleted; and at most one event that ends a program: a reset, the emergency stop, which may bounce, a line out of the travel, a board that
is reset, a power cut that tears what is being written. Then the operator finds his way out, and the next round begins.

These must hold, seen from the wire, the pins and the plant:

- the path is that of the lines sent, in their order, each once, step by step; its end, by any stop, lies on the path;
- of all lines that were answered with ok nothing is missing, unless something has ended the program;
- one answer a line, in order, and none that is not of the language;
- no alarm that nothing has caused; after a stop, and while the door is open, nothing moves and the tool is off;
- the place the board tells is the plant's, and a board that cannot know it refuses to move until it is homed;
- no interval shorter than an axis may step, no word late;
- stored jobs are there whole or not at all; a full memory says so;
- the journal, after a power cut at any byte, names the program and a place that its path has passed; `passo resume` goes on there: with its cuts none is
missing, none is elsewhere, and only those since that place are made twice;
- the board's objects do not grow.
"""

import base64
import re
import tempfile
from math import atan2, cos, hypot, pi, sin
from pathlib import Path

import numpy as np

from host_tools import boards
from host_tools.cli import resume
from host_tools.clients.frames import FramedPort
from host_tools.failure import Failure
from host_tools.programs import stored_job
from host_tools.programs.resume_line import number_of
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.pages import Pages, PowerCut
from noisy_wire import BAUD
from soak_bench import Cabled, Wrong
from soak_flash import Flash
from soak_witness import VOXEL, Arc, Line, cut_by, far_from, follow

LOW, HIGH = (0, 0, -6000), (19_000, 16_000, 0)  # steps of each axis that programs use
STEPS_MM = (320, 320, 400)
FAST_MM_MIN = (5000, 5000, 1500)
LEAST_TICKS = [12_500_000 * 60 / (mm_min * steps) for mm_min, steps in zip(FAST_MM_MIN, STEPS_MM)]
LOST_MS = 1500
LONGEST_MS = 900_000  # of a round
CUT_SHORT = "STEP pulse too short"  # a stop at once cuts it short; the step counts
PLAIN_BYTES = 100  # of lines that are not answered
FRAMED_BYTES = 500
FLASH = 56 * 1024
LAST = 20  # rounds between two measures of the heap
DOOR_MS = 800  # after which an open door has brought it to a stand, tool off
MOST_RESUMES = 4  # of a program
TWICE = 16_000  # steps of 0.6 s at the fastest: every_ms, what lies ahead, and the tool's way down
REFUSES = ("another file", "is empty", "done to its end", "passo stream --from")  # the texts of passo resume if it does not go on
OUTSIDE = "G90G0X5000"  # a line out of the travel
SLOWEST_S = 3  # that a line or a chain takes
FASTEST = 9e8  # mm/min: a number has nine digits, and a chip's integers hold less
ASKED, SENT = 1, 2
OF_LANGUAGE = re.compile(r"ok|error:\d+|ALARM:\d+|<[^<>]*>|\[[^\[\]]*\]|Grbl 1\.1.*|")
HARMLESS = ("hold", "override", "question", "door", "fight", "garbage", "cut", "noise", "store", "delete", "hand over")
ENDS = ("reset", "other reset", "stop", "stop bounces", "outside", "board", "power", "power", "long cut")


def board():
    made = boards.load("router_3axis")
    made["journal"] = {"every_ms": 200}
    made["jobs"] = {"language": "grbl"}
    made["spindle"] = {**made["spindle"], "spin_up_ms": 300, "coolant_ms": 100}
    made["homing"] = {**made["homing"], "seek_steps_s": 20_000}
    made["links"][0].update(frames=True, lost_ms=LOST_MS)
    return made


def mm(steps, axis):
    return "%.4f" % (steps / STEPS_MM[axis])


class Program:
    """Lines of G-code and the moves they mean: `lines` are (text, Line, Arc or None)."""

    def __init__(self, dice, start, count):
        self.dice, self.place, self.lit = dice, list(start), False
        self.lines = [("G90G21G17G94G54M5M9", None)]
        makers = (self.far, self.far, self.far, self.chain, self.arc, self.relative, self.tool, self.dwell)
        while len(self.lines) < count:
            dice.choice(makers)()
        self.lines += [("M5M9", None), ("G4P0", None)]

    def add(self, text, move=None):
        self.lines.append((text, move))
        if move:
            self.place = list(move.target)

    def feed(self, low, high, target):
        """F of a way to `target`."""
        return f"F{self.dice.randint(low, high) if low < high else low}"

    def to(self, target, word):
        axes = [axis for axis in range(3) if target[axis] != self.place[axis] or self.dice.random() < 0.2]
        text = "".join("XYZ"[axis] + mm(target[axis], axis) for axis in axes)
        target = [target[axis] if axis in axes else self.place[axis] for axis in range(3)]
        if text:
            self.add(word + text, Line(target, self.lit))

    def far(self):
        target = [self.dice.randint(low, high) for low, high in zip(LOW, HIGH)]
        if self.dice.random() < 0.9:
            target[2] = self.place[2]
        self.to(target, "G0" if self.dice.random() < 0.3 else "G1" + self.feed(2000, 6000, target))

    def chain(self):
        self.add("G1" + self.feed(500, 5000, [at + 1000 for at in self.place]))
        for _ in range(self.dice.randint(3, 20)):
            self.to([min(max(at + self.dice.randint(-200, 200), 0), high) for at, high in zip(self.place[:2], HIGH)] + [self.place[2]], "")

    def arc(self):
        radius = self.dice.randint(200, 4000)
        centre = [self.dice.randint(radius + 10, HIGH[axis] - radius - 10) for axis in (0, 1)]
        first = self.dice.uniform(0, 2 * pi)
        start = [round(centre[0] + radius * cos(first)), round(centre[1] + radius * sin(first)), self.place[2]]
        self.to(start, "G1" + self.feed(1000, 5000, [start[0] + round(radius * 6), start[1], start[2]]))
        start = self.place
        clockwise = self.dice.random() < 0.5
        turn = self.dice.uniform(0.3, 5.5) * (-1 if clockwise else 1)
        radius, first = hypot(start[0] - centre[0], start[1] - centre[1]), atan2(start[1] - centre[1], start[0] - centre[0])
        end = [round(centre[0] + radius * cos(first + turn)), round(centre[1] + radius * sin(first + turn)), start[2]]
        i, j = (mm(centre[axis] - start[axis], axis) for axis in (0, 1))
        self.add(f"G{2 if clockwise else 3}X{mm(end[0], 0)}Y{mm(end[1], 1)}I{i}J{j}", Arc(end, centre, clockwise, self.lit))
        self.add("G1")

    def relative(self):
        by = [self.dice.randint(-100, 100) * 8 for _ in range(2)]
        target = [at + each for at, each in zip(self.place, by)]
        if all(0 <= at <= high for at, high in zip(target, HIGH)):
            self.add(f"G91G1X{mm(by[0], 0)}Y{mm(by[1], 1)}{self.feed(3000, 3000, target + [self.place[2]])}", Line(target + [self.place[2]], self.lit))
            self.add("G90")

    def tool(self):
        self.lit = not self.lit
        self.add(self.dice.choice(("M3S9000", "M4S5000M8", "M3S12000M7")) if self.lit else self.dice.choice(("M5", "M5M9")))

    def dwell(self):
        self.add(f"G4P0.{self.dice.randint(0, 30):02d}")


class AnyFeed(Program):
    def feed(self, low, high, target):
        """Of any size, as far as the way takes no more than SLOWEST_S."""
        slow = max(hypot(*[(to - at) / scale for to, at, scale in zip(target, self.place, STEPS_MM)]) * 60 / SLOWEST_S, 0.1)
        return "F%.4f" % (slow * (FASTEST / slow) ** (self.dice.random() ** self.dice.choice((1, 3))))


class Link:
    """One of the board's links as a program on the PC sees it: lines sent, and their answers."""

    def __init__(self, bench, name):
        self.bench, self.name = bench, name
        self.port = None  # a FramedPort; None: plain text
        self.waiting = []  # lines sent that are not answered
        self.told = []  # [(line, answer)]
        self.said = []  # everything else
        self.stale = 0  # lines that were on their way as the board began anew: they may be answered
        self._text = b""

    def send(self, line):
        self.waiting.append(line)
        self.bench.actions += 1
        data = line.encode() + b"\n"
        if self.port:
            self.port.write(data)
        else:
            self.bench.to_board(self.name, data)

    def real_time(self, byte):
        self.bench.note(f"{self.name} <- {byte!r}")
        self.bench.actions += byte != b"?"
        if not self.port:
            self.bench.to_board(self.name, byte)
        else:
            self.port.urgent(byte, byte == b"\x18")

    def hear(self):
        """Read the bytes that have come."""
        if self.port:
            data = self.port.read(4096) if self.port.in_waiting else b""
        else:
            data = self.bench.from_board(self.name)
        if not data:
            return
        *lines, self._text = (self._text + data).split(b"\r\n")
        for line in lines:
            self._understand(line.decode("latin-1"))

    def _understand(self, line):
        if not OF_LANGUAGE.fullmatch(line):
            raise Wrong(f"{self.name}: the board says {line!r}")
        if line == "ok" or line.startswith("error:"):
            if not self.waiting and self.stale:
                self.stale -= 1
                return
            if not self.waiting:
                raise Wrong(f"{self.name}: an answer to nothing: {line}")
            asked = self.waiting.pop(0)
            self.told.append((asked, line))
            if line != "ok":
                self.bench.note(f"{self.name}: {asked!r} -> {line}")
        elif line:
            if line[0] != "<":
                self.bench.note(f"{self.name}: {line}")
            self.said.append(line)
            if line.startswith("Grbl"):
                self.stale += len(self.waiting)
                self.waiting.clear()

    def under_way(self):
        return sum([len(line) + 1 for line in self.waiting])

    def forget(self):
        """Forget the lines read; a line that is still coming stays."""
        self.waiting, self.told, self.said, self.stale = [], [], [], 0

    def begin(self, port=None):
        """A new session: in frames over `port`, or in plain text."""
        self.forget()
        self.port, self._text = port, b""


class Router(Cabled):
    NAME = "router"
    PROGRAM = Program

    def __init__(self, seed):
        super().__init__(seed)
        self.board = board()
        self.board["links"][0]["lost"] = self.policy = self.dice.choice(("go_on", "go_on", "pause", "stop"))
        self.flash = Flash(FLASH)
        self.folder = tempfile.TemporaryDirectory(prefix="passo-")
        self.jobs = {}  # name: (program, lines) of the stored job
        self.torn = None  # name of a job whose upload a power cut has torn
        self.links = {name: Link(self, name) for name in ("pc", "serial")}
        self.note(f"seed {seed}, lost host: {self.policy}")
        self.boot((9000, 7000, -1800), Pages())

    def close(self):
        self.flash.unmount()
        self.folder.cleanup()

    # --- wires

    def to_board(self, link, data):
        if link == "pc":
            self.line.wires[0].put(data)
        else:
            self.machine.send(data, link)

    def from_board(self, link):
        if link == "pc":
            data, self.line.arrived = self.line.arrived, b""
            return data
        return self.machine.take(link)

    # --- the board

    def boot(self, start, pages):
        self.pages = pages
        self.flash = Flash(FLASH, self.flash.files)
        self.flash.mount()
        self.forget()
        machine = VirtualMachine(self.board, trace=None, pages=pages, start=start, seed=self.dice.randrange(1 << 30))
        self.switch_on(machine, LEAST_TICKS)
        self.line.renew(self.now_ms())
        self.run_ms(100)
        for link in self.links.values():
            self.from_board(link.name)
            link.begin()
        self.known = self.homed = False  # whether the machine knows its position; whether its travel counts
        if machine.plant.position != list(start) or machine.plant.tool:
            raise Wrong("a board that has just been switched on moves")

    def open_frames(self):
        link = self.links["pc"]
        port = FramedPort(self.wire, lambda: int(self.now_ms()))
        for _ in range(5):
            if port.begin(1):
                link.begin(port)
                return
        raise Wrong("no session of frames")

    def plain(self):
        """The PC's link without frames."""
        link = self.links["pc"]
        self.line.set(0)
        self.run_ms(50)
        if link.port:
            try:
                link.port.close()
            except OSError:
                pass
        self.to_board("pc", b"\n")
        self.run_ms(100)
        self.from_board("pc")
        link.begin()

    def ask(self, link, line, limit_ms=200_000):
        """Send a line and wait for its answer: (answer, the other lines)."""
        link.said.clear()
        self.note(f"{link.name} <- {line}")
        link.send(line)
        end = self.now_ms() + limit_ms
        while link.waiting:
            self.hear(link)
            if self.now_ms() > end:
                raise Wrong(f"{link.name}: no answer to {line!r}")
        return link.told[-1][1], link.said

    def hear(self, link):
        if not link.port:
            self.cycle()
        link.hear()

    def do(self, link, *lines):
        for line in lines:
            answer, said = self.ask(link, line)
            if answer != "ok":
                raise Wrong(f"{link.name}: {line!r} is answered with {answer}, {said}")

    def status(self, link):
        link.said.clear()
        link.real_time(b"?")
        end = self.now_ms() + 5000
        while not any(line[0] == "<" for line in link.said):
            self.hear(link)
            if self.now_ms() > end:
                raise Wrong(f"{link.name}: no status")
        text = [line for line in link.said if line[0] == "<"][-1]
        state = re.match(r"<(\w+)", text)[1]
        place = [float(each) for each in re.search(r"MPos:([-.\d,]+)", text)[1].split(",")]
        return state, place

    # --- a round

    def round(self):
        self.rounds += 1
        self.forget()
        self.machine.plant.errors.clear()
        link = self.begin()
        start = self.place()
        program = self.PROGRAM(self.dice, start, self.dice.randint(8, 60))
        program.lines = [(f"N{number}{text}", move) for number, (text, move) in enumerate(program.lines, 1)]
        self.ended = ""
        self.outside, self.door = 0, False
        if self.carrier == "stream":
            self.journal = number_of([(0, text.encode()) for text, _ in program.lines])
            self.do(link, f"$JR={self.journal:08X}")
        self.witness.take()
        if self.carrier == "job":
            self.store_job(link, program)
            self.plan(link, program)
            self.run_job(link, program)
        else:
            if link.port:
                share = self.dice.choice((0, 0.003, 0.01, 0.02))
                self.line.set(share)
                self.note(f"noise {share}")
            self.plan(link, program)
            self.stream(link, program)
        self.count_noise()
        self.judge(link, program, start)
        if self.ended in ("power", "board"):
            self.check_journal(start)
            if self.dice.random() < 0.5:
                self.resume(program, start)
        self.recover(link)
        if not self.rounds % 5 and self.known:
            self.drain()
            self.jump()
        if not self.rounds % LAST and self.known:
            self.check_heap()

    def place(self):
        return list(self.machine.plant.position)

    def begin(self):
        """Homed, idle, a link that commands; and which way the program will come."""
        self.line.set(0)
        link = self.links[self.dice.choice(("pc", "pc", "pc", "serial"))]
        self.carrier = self.dice.choice(("stream", "stream", "stream", "job"))
        framed = link.name == "pc" and self.dice.random() < 0.85
        if bool(self.links["pc"].port) != framed and (link.name == "pc"):
            self.plain() if not framed else self.open_frames()
        self.note(f"round {self.rounds}: {self.carrier} over {link.name}{', frames' if link.port else ''}")
        link.told.clear()
        number = list(self.links).index(link.name) + 1
        self.ask(link, f"$LINK={number}")
        state, _ = self.status(link)
        if not self.known:
            if state != "Alarm":
                raise Wrong(f"the board cannot know where it is, and is {state}")
            answer, _ = self.ask(link, "G0X1")
            if answer != "error:9":
                raise Wrong(f"the board cannot know where it is, and answers {answer}")
            self.home(link)
        elif state == "Alarm":
            if self.dice.random() < 0.4:
                self.home(link)
            else:
                self.do(link, "$X")
                self.homed = False
        self.do(link, "G10L2P1X0Y0Z0", "G92.1", "G90G21G17G94G54M5M9")
        self.check_place(link)
        self.drain()
        return link

    def drain(self):
        """Hear all that the board still says, and forget it."""
        for link in self.links.values():
            end_ms = self.now_ms() + (400 if link.port else 60)
            while self.now_ms() < end_ms:
                self.hear(link)
            link.forget()

    def home(self, link):
        self.do(link, "$H")
        self.settle()
        self.known = self.homed = True
        if any(self.place()):
            raise Wrong(f"homed, it stands at {self.place()}")
        self.machine.plant.errors.clear()

    def check_place(self, link):
        state, place = self.status(link)
        there = [round(at * steps) for at, steps in zip(place, STEPS_MM)]
        if any(abs(told - at) > 1 for told, at in zip(there, self.place())):
            raise Wrong(f"the board says it is at {there}, and it is at {self.place()}")
        return state

    # --- faults

    def plan(self, link, program):
        """Plan the faults of a program's run."""
        lasts_ms = 400 + 120 * len(program.lines)
        for _ in range(self.dice.randint(0, 8)):
            kind = self.dice.choice(HARMLESS)
            self.after(self.dice.uniform(0, lasts_ms), lambda kind=kind: self.harmless(kind, link))
        if self.dice.random() < 0.5:
            kind = self.dice.choice(ENDS)
            if kind == "power":
                at = self.dice.randrange(0, 600)
                self.after(self.dice.uniform(0, lasts_ms), lambda: self.tear(at))
            self.after(self.dice.uniform(0, lasts_ms), lambda: self.end(kind, link))

    def other(self, link):
        return self.links["serial" if link.name == "pc" else "pc"]

    def harmless(self, kind, link):
        if self.ended or not self.line.plugged:
            return
        other = self.other(link)
        machine = self.machine
        if kind == "hold":
            self.fault("hold")
            (link if self.dice.random() < 0.7 or other.port else other).real_time(b"!")
            self.after(self.dice.uniform(1, 900), lambda: self.go_on(link))
        elif kind == "override":
            self.fault("override")
            link.real_time(bytes([self.dice.choice((0x90, 0x91, 0x91, 0x92, 0x93, 0x95, 0x96, 0x97))]))
        elif kind == "question":
            for _ in range(self.dice.randint(1, 20)):
                link.real_time(b"?")
        elif kind == "door" and not self.door:
            self.fault("door")
            self.open_door(self.dice.uniform(30, 1500), link)
        elif kind == "fight" and not other.port:
            self.fault("fight")
            for line in ("G91G0X5", "M3S1000", "$X", "$H", "G92X0", "$J=G91X1F100"):
                other.send(line)
        elif kind == "garbage" and not other.port:
            self.fault("garbage")
            data = bytes(self.dice.choice([byte for byte in range(256) if byte not in b"\x18!~?\r\n$\x84\x85\0"]) for _ in range(50))
            self.to_board(other.name, bytes(byte for byte in data if byte < 0x80) + b"\n")
            other.waiting.append("garbage")
        elif kind == "cut" and link.port:
            self.fault("short cut")
            self.unplug(self.dice.uniform(5, 700))
        elif kind == "noise" and link.port:
            self.line.set(self.dice.choice((0, 0.003, 0.01, 0.02)))
        elif kind in ("store", "delete") and not other.port:
            self.fault("job amid a program")
            for name in list(self.jobs)[:1] + ["NONE"]:
                other.send(f"$FD={name}" if kind == "delete" else f"$FS={name},grbl,10,0,10")
        elif kind == "hand over" and not other.port:
            self.fault("wants to command")
            other.send(f"$LINK={list(self.links).index(other.name) + 1}")

    def go_on(self, link):
        """Until it does: `~` may come before the stand, and `!` may still be on its way."""
        coming = link.port and link.port._urgents
        if not self.ended and (self.machine.app.controller.machine.hold or coming):
            link.real_time(b"~")
            self.after(100, lambda: self.go_on(link))

    def press(self, name, active):
        self.machine.plant.set_input(self.machine.port.now, name, active)

    def open_door(self, ms, link):
        self.door = True
        self.press("door", True)
        seen = []
        if ms > DOOR_MS + 100:
            self.after(DOOR_MS, lambda: seen.append(self.place()))
        self.after(ms, lambda: self.close_door(link, seen))

    def close_door(self, link, seen):
        if seen and not self.ended and (seen[0] != self.place() or self.machine.plant.tool):
            raise Wrong(f"the door has been open for {DOOR_MS} ms, and it still moves or cuts")
        self.door = False
        self.press("door", False)
        self.after(20, lambda: self.go_on(link))

    def tear(self, count):
        if not self.ended:
            self.pages.cut_after(count)

    def end(self, kind, link):
        machine = self.machine
        if self.ended:
            return
        if kind == "long cut" and link.name != "pc" or kind == "outside" and not self.homed:
            kind = "reset"
        if kind == "long cut" and (self.door or machine.app.controller.machine.hold):
            self.after(300, lambda: self.end(kind, link))
            return
        self.ended = kind
        self.fault(kind)
        if kind == "reset":
            link.real_time(b"\x18")
        elif kind == "other reset":
            other = self.other(link)
            if other.port:
                self.ended = ""
                self.faults[kind] -= 1
                return
            other.real_time(b"\x18")
        elif kind == "stop":
            self.press("stop", True)
        elif kind == "stop bounces":
            tick = machine.port.now
            machine.plant.inject_noise("stop", sorted({tick + self.dice.randint(1, 400_000) for _ in range(7)})[:5])
        elif kind == "outside":
            self.ended, self.outside = "", ASKED
        elif kind == "long cut":
            self.unplug(1e9)
        elif kind in ("board", "power"):
            raise PowerCut

    # --- programs on their way

    def stream(self, link, program):
        """As senders do that count characters, until nothing is under way any more."""
        pending = list(program.lines)
        most = FRAMED_BYTES if link.port else PLAIN_BYTES
        end_ms = self.now_ms() + LONGEST_MS
        asked_ms = 0
        self.sent = []
        link.said.clear()
        try:
            while (pending or link.waiting or self.moving() or self._ahead) and not self.ended:
                while pending and link.under_way() + len(pending[0][0]) < most and not self.outside:
                    self.sent.append(pending.pop(0))
                    link.send(self.sent[-1][0])
                if self.now_ms() - asked_ms > 300:
                    asked_ms = self.now_ms()
                    link.real_time(b"?")
                self.hear(link)
                self.hear_other(link)
                self.check_answers(link)
                if self.now_ms() > end_ms:
                    raise Wrong(f"no end; {len(pending)} lines to send, {len(link.waiting)} to be answered")
            self.await_end(link)
        except PowerCut:
            self.reboot()
        except OSError as error:
            if self.ended != "long cut":
                raise Wrong(f"the link is lost: {error}") from None
            self.await_end(link)

    def hear_other(self, link):
        other = self.other(link)
        if other.port:
            return
        other.hear()
        for line, answer in other.told:
            if answer == "ok" and line.startswith("$LINK=") and not self.ended:
                self.ended = "handed over"
            elif answer == "ok" and line != "garbage":
                raise Wrong(f"{other.name} does not command, and {line!r} is done")
        other.told.clear()

    def check_answers(self, link):
        if self.ended:
            return
        if self.outside == ASKED:
            self.outside = SENT
            link.send(OUTSIDE)
        if (OUTSIDE, "error:15") in link.told:
            self.ended = "outside"
            return
        wrong = [told for told in link.told if told[1] != "ok"]
        alarms = [line for line in link.said if line.startswith(("ALARM", "Grbl")) and not (self.outside and line == "ALARM:2")]
        if wrong or alarms:
            raise Wrong(f"{link.name}: {wrong} {alarms} though nothing has happened")

    def await_end(self, link):
        """Handle the end of the program."""
        if not self.ended:
            return
        self.forget()
        if self.ended == "long cut":
            self.run_ms(LOST_MS + 1000)
            if self.carrier == "job" or self.policy == "go_on":
                self.settle()
        else:
            self.line.plugged = True
            if self.ended == "reset":
                self.await_banner(link)
            self.run_ms(300)
            self.await_stand()

    def await_banner(self, link):
        """A reset may have to be sent again, in frames over a noisy wire."""
        end_ms = self.now_ms() + 5000
        while not any(line.startswith("Grbl") for line in link.said) or link.port and link.port._urgents:
            self.hear(link)
            if self.now_ms() > end_ms:
                raise Wrong("no banner after a reset")

    def await_stand(self):
        """Wait for the stand: a stop lets the machine brake, at most; a hold may stand."""
        before = None
        end_ms = self.now_ms() + 20_000
        while before != self.place():
            before = self.place()
            self.run_ms(200)
            if self.now_ms() > end_ms:
                raise Wrong(f"it goes on behind: {self.ended}")

    def reboot(self):
        """The board was without power, or was reset: memory gone, flash as far as it was written."""
        self.ended = self.ended or "power"
        self.faults["torn page"] += self.pages._left == 0
        self.note("the board is switched off, and on again")
        self.last_steps = self.witness.take()
        self.boot(self.place(), Pages(data=self.pages.data))

    def check_journal(self, start):
        """After a power cut: check that the program was at the line and place that the journal has."""
        answer, said = self.ask(self.links["pc"], "$JR")
        found = [re.fullmatch(r"\[JOURNAL:([0-9A-Fa-f]+)\|(\d+)\|(\d+)\|([-\d,]+)\]", line) for line in said]
        found = [match for match in found if match]
        if answer != "ok" or not found:
            raise Wrong(f"$JR is answered with {answer}, {said}")
        job, line, _, place = found[0].groups()
        if int(job, 16) != self.journal:
            return  # nothing has been written since it began
        self.fault("journal after a power cut")
        place = tuple(int(at) for at in place.split(","))
        if int(line) > len(self.sent) or place not in {tuple(start), *map(tuple, self.last_steps.places.tolist())}:
            raise Wrong(f"the journal says line {line} of {len(self.sent)}, {place}, which the path has not passed")

    def resume(self, program, start):
        """As an operator does, who homes the machine; the power may go again. Raises Wrong if something is missing, or cut elsewhere."""
        moves = [move for _, move in program.lines if move]
        wanted = cut_by(moves, start)
        cuts = [self.lit_of(self.last_steps)]
        Path(self.folder.name, "part.nc").write_text("".join(text + "\n" for text, _ in program.lines))
        columns = []
        for number in range(MOST_RESUMES):
            self.ended, said = "", ""
            self.fault("resume")
            if number < MOST_RESUMES - 1 and self.dice.random() < 0.4:
                self.after(self.dice.uniform(0, 40_000), lambda: self.end("board", self.links["pc"]))
            self.line.set(self.dice.choice((0, 0.003)))
            try:
                with self.passo(self.dice.choice((True, False)) if not self.line.wires[0].share else True):
                    resume.resume(Path(self.folder.name, "part.nc"), "pc", BAUD, "grbl", home=True, unverified=False, yes=True)
            except Failure as failure:
                said = str(failure)
                self.note(f"passo resume: {said}")
            except PowerCut:
                self.reboot()
            if not self.ended:
                self.forget()
                self.settle()
                self.last_steps = self.witness.take()
            cuts.append(self.lit_of(self.last_steps))
            if len(cuts[-1]):
                columns.append(cuts[-1][0])
            if not self.ended:
                break
        if self.ended:
            return
        self.line.set(0)
        self.machine.plant.errors.clear()
        self.known = self.homed = bool(self.machine.app.controller.machine.homed)
        self.open_frames()
        self.links["serial"].hear()  # the banner of a board that was switched on
        if said and not any(text in said for text in REFUSES):
            raise Wrong(f"passo resume: {said}")
        if said and "done to its end" not in said:
            return
        self.fault("resumed to the end")
        missing = far_from(wanted, np.vstack(cuts))
        if len(missing):
            raise Wrong(f"{len(missing)} places are missing behind passo resume: {missing[0].tolist()} …")
        extra = far_from(np.vstack(cuts[1:]), wanted)
        for column in columns:  # the tool goes down
            extra = extra[(np.abs(extra[:, :2] - column[:2]) > VOXEL).any(axis=1)]
        if len(extra):
            raise Wrong(f"{len(extra)} places are cut by passo resume that are none of the program's: {extra[0].tolist()} …")
        twice = sum(map(len, cuts)) - len(wanted)
        if twice > len(columns) * TWICE:
            raise Wrong(f"{twice} steps are cut twice")

    @staticmethod
    def lit_of(steps):
        return steps.places[steps.tools > 0]

    # --- stored jobs

    def listed(self, link):
        """{name: (bytes, CRC-32)} as the board lists them."""
        answer, said = self.ask(link, "$F")
        if answer != "ok":
            raise Wrong(f"$F is answered with {answer}")
        found = re.findall(r"\[FILE:(.+)\|SIZE:(\d+)\|STORED:\d+\|CRC:([0-9a-f]+)", "\n".join(said))
        return {name: (int(size), int(crc, 16)) for name, size, crc in found}

    def check_jobs(self, link):
        found = self.listed(link)
        if found != self.jobs:
            raise Wrong(f"stored jobs: {found}, and not {self.jobs}")

    def store_job(self, link, program):
        """Until there is room for it. Raises nothing if the power goes: then another round begins."""
        data = b"".join(text.encode() + b"\n" for text, _ in program.lines)
        packed = stored_job.pack_job(data)
        self.name = f"J{self.dice.randrange(8)}"
        self.check_jobs(link)
        while not self.upload(link, data, packed):
            name = self.dice.choice(list(self.jobs))
            self.do(link, f"$FD={name}")
            del self.jobs[name]
            self.check_jobs(link)
        self.journal = stored_job.crc_of(data)
        self.jobs[self.name] = len(data), self.journal
        self.check_jobs(link)

    def upload(self, link, data, packed):
        """False if the memory is full. Jobs stored before stay."""
        lines = [f"$FS={self.name},grbl,{len(data)},{stored_job.crc_of(data):08x},{len(packed)}"]
        lines += ["$F:" + base64.b64encode(packed[at : at + 54]).decode() for at in range(0, len(packed), 54)]
        lines.append("$FE")
        trouble = self.dice.choice(("", "", "torn", "wrong", "short"))
        if trouble == "wrong":
            lines[-2] = "$F:" + base64.b64encode(bytes(byte ^ 1 for byte in packed[len(packed) // 54 * 54 :])).decode()
        elif trouble == "short":
            del lines[self.dice.randrange(1, len(lines) - 1)]
        elif trouble == "torn":
            del lines[self.dice.randrange(1, len(lines)) :]
        for line in lines:
            answer, _ = self.ask(link, line)
            if answer == "error:152":
                self.fault("full flash")
                self.check_jobs(link)
                return False
            if answer != "ok":
                break
        if not trouble:
            if answer != "ok":
                raise Wrong(f"{line} is answered with {answer}")
            return True
        if answer == "ok" and trouble != "torn":
            raise Wrong(f"an upload that is {trouble} is taken")
        self.fault(f"upload {trouble}")
        self.check_jobs(link)
        return self.upload(link, data, packed)

    def run_job(self, link, program):
        self.sent = list(program.lines)
        done = f"[MSG:Job {self.name} done]"
        try:
            self.do(link, f"$F={self.name}")
            end_ms = self.now_ms() + LONGEST_MS
            while (self.moving() or self._ahead or done not in link.said) and not self.ended:
                self.hear(link)
                self.hear_other(link)
                if self.outside:
                    self.outside, self.ended = 0, "reset"
                    link.real_time(b"\x18")
                alarms = [line for line in link.said if line.startswith(("ALARM", "Grbl", "[MSG:Job")) and line != done]
                if alarms and not self.ended:
                    raise Wrong(f"job: {alarms} though nothing has happened")
                if self.now_ms() > end_ms:
                    raise Wrong("the job does not end")
            self.await_end(link)
        except PowerCut:
            self.reboot()

    # --- what has been done

    def judge(self, link, program, start):
        moves = [move for _, move in self.sent if move]
        stopped = self.ended and not (self.ended == "long cut" and (self.carrier == "job" or self.policy == "go_on"))
        if self.ended in ("power", "board"):
            steps = self.last_steps
        else:
            if stopped:
                self.check_stands(tool_off=self.ended != "long cut" or self.policy == "stop")
            else:
                self.settle()
            steps = self.witness.take()
            self.check_late()
        steps.check_intervals(strict=not self.ended)
        done, begun, place = follow(steps, start, moves)
        self.note(f"{self.ended or 'ended'}: {done} of {len(moves)} moves, {len(steps)} steps")
        if not self.ended or self.ended == "long cut" and self.carrier == "job":
            if done != len(moves):
                raise Wrong(f"only {done} of {len(moves)} moves have been done")
        elif not stopped:
            told = sum([1 for text, answer in link.told if answer == "ok" and text[0] == "N"])  # not $JR
            wanted = sum([1 for _, move in self.sent[:told] if move])
            if begun or done < wanted:
                raise Wrong(f"the link is lost: {done} of {wanted} moves that were answered, and {'a part' if begun else 'no part'} of another")
        if place != self.place() and len(steps):
            raise Wrong(f"it stands at {self.place()}, and its path ends at {place}")
        self.check_plant((CUT_SHORT,) if self.ended else ())

    def recover(self, link):
        """The operator's way out."""
        self.forget()
        self.line.set(0)
        self.line.plugged = True
        for name in ("stop", "door"):
            noise = self.machine.plant.noise.get(name)
            if noise and noise.flipped:
                self.machine.plant.inject_noise(name, [self.machine.port.now + 10])
            self.press(name, False)
        self.run_ms(60)
        if not self.known or self.ended in ("power", "board"):
            self.check_plant()
            return
        if not self.ended:
            self.check_place(link)
            return
        if self.links["pc"].port and self.ended == "long cut":
            stale = len(link.waiting)  # which the board may still answer, to whoever listens
            self.open_frames()
            link.stale = stale
        link.said.clear()
        link.real_time(b"\x18")
        self.await_banner(link)
        self.drain()
        state = self.check_place(link)
        if state not in ("Alarm", "Idle"):
            raise Wrong(f"after a reset the board is {state}")
        self.check_stands()
        self.check_plant((CUT_SHORT,))


class Feeds(Router):
    """The same with feeds of every size."""

    NAME = "feeds"
    PROGRAM = AnyFeed
