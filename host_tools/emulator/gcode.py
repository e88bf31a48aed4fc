"""Gives G-code to the emulated Pico as fast as it takes it: lines from the board's own memory instead of a serial line.

    machine = fast_router()                                     # booted, and waiting for its lines
    run = on_a_copy(lambda: run_lines(machine, 0.2, 100, 600))
    run["lines_s"], run["least"], run["late"]
    run_raster(fast_router(laser=True), 0.1, 100, 600)          # the same figures of a picture's dots
    lines_over(machine, "pc", 0.2, 490, 600, 1000)              # lines a second over USB; the PC takes a millisecond
    late_words(boot_router(), ["G21G91", "F600", "G2X1Y1I1"])        # axes as the board file has them, a programme to its end
    talk_to(machine)                                            # or it is as flashed, on USB
    time_first_steps(machine), time_holds(machine)

The firmware is that of the board file as it is flashed, with two more lines in main.py: they replace its first link by the
memory. The sender counts characters, with at most 127 bytes under way. The lines are chords of a circle in space, absolute, to
the micrometre, CHORDS of them again and again; or dots of a picture, each with another power, in rows of ROW, back and forth.
"""

import tempfile
from math import cos, pi, sin
from pathlib import Path

from host_tools import boards
from host_tools.build.tree import compile_module
from host_tools.emulator.cycles import CYCLES_PER_TICK, CYCLES_PER_US
from host_tools.emulator.load import Load
from host_tools.emulator.machine import EmulatedMachine, files_of
from host_tools.emulator.profile import Profile
from host_tools.emulator.queries import Asking
from passo.config.journal import Journal, MemorySlots
from passo.config.setting_numbers import JERK
from passo.steps.wiring import word_times
from passo.steps.word import TICKS_PER_S

CHORDS = 64
LINE_BYTES = 24
DOT_BYTES = 12  # a line of a picture
DOTS = 32  # different ones in a row
LINES_A_READ = 4  # as a serial line gives what is there
DOTS_A_CHUNK = LINES_A_READ
ROW = 4 * DOTS + 3
LASER_PIN = 22
CYCLES_PER_MS = 1000 * CYCLES_PER_US
_RUN = b"    main(Start, STAMP)\n"
_ATTACH = b"""    def run(self, app, port, real=Start.run):
        import memory_line
        memory_line.attach(app, port)
        real(self, app, port)
    Start.run = run
"""
_LINE = """
import gc, micropython, sys
from micropython import const
from time import ticks_us, ticks_diff

_WINDOW = const(127)
_LINES = const(4)  # a read

class Memory:  # its attributes have names that the firmware has anyway: a new one takes room in the table of names
    def __init__(self, app, chunks, again, lines, warm, width):
        self.rows, self.target, self.at = chunks, again, 0
        self.left, self.taken, self.size, self.count = lines * width, 0, width, _LINES * width
        self.most, self.limit, self.accepted, self.open = lines, warm, 0, 0
        self.planner, self.feeder = app.planner, app.feeder
        self.least = 999

    def close(self):
        pass

    @micropython.native
    def any(self):
        return self.left and self.taken + self.count <= _WINDOW

    @micropython.native
    def read(self):
        if not self.any():
            return b""
        if self.accepted > self.limit:
            ahead = self.planner.ahead()
            if ahead < self.least:
                self.least = ahead
        data = self.rows[self.at]
        self.at += 1
        if self.at == len(self.rows):
            self.at = self.target
        self.left -= self.count
        self.taken += self.count
        return data

    @micropython.native
    def write(self, data):
        count = data.count(b"ok")
        self.accepted += count
        self.taken -= count * self.size
        if not self.open and self.accepted >= self.limit:
            self.open, self.start = ticks_us(), self.accepted
            print("warm")
        if self.accepted == self.most:
            print("done", self.accepted - self.start, ticks_diff(ticks_us(), self.open), self.least, self.feeder.late)

def attach(app, port):
    def go(path, head, lines, warm, width, order):
        count = _LINES * width
        again = len(head) // count
        chunks = [head[at : at + count] for at in range(0, len(head), count)]
        if order:
            with open(path, "rb") as file:
                read = [file.read(count) for _ in range(max(order) + 1)]
            chunks += [read[place] for place in order]
        gc.collect()
        print("free", gc.mem_free())
        app.links[0].serial = port._lines[0] = Memory(app, chunks, again, lines, warm, width)
    gc.collect()
    print("ready", gc.mem_free())
    exec(sys.stdin.readline(), {"go": go, "app": app, "port": port})
"""


def chords(length_mm):
    """Return (X of the beginning, the bytes of CHORDS lines of this length, a closed path from there, Y50Z-20)."""
    radius = length_mm / 2 / sin(pi / CHORDS)

    def point_text(chord):
        turn = 2 * pi * chord / CHORDS
        return f"X{50 + radius * cos(turn):.3f}Y{50 + 0.8 * radius * sin(turn):.3f}Z{-20 + 0.6 * radius * sin(turn):.3f}"

    return round(50 + radius, 3), pad_lines(*[point_text(chord + 1) for chord in range(CHORDS)])


def raster(dot_mm):
    """Return (the bytes of two rows of dots, relative, forth and back, in which DOTS repeat; the order of their chunks). Every seventh dot is dark."""

    def dots(sign, first, count):
        powers = [(dot * 397 % 999 + 1) if dot % 7 else 0 for dot in range(first, first + count)]
        return [f"X{sign * dot_mm:.1f}S{power}" for power in powers]

    lines = []
    for sign in (1, -1):
        before, *others = dots(sign, 1, 3)
        lines += [f"G0Y{sign * dot_mm:.1f}", "G1" + before, *others, *dots(sign, 4, DOTS)]
    chunks = 1 + DOTS // DOTS_A_CHUNK
    row = [0] + 4 * list(range(1, chunks))
    return pad_lines(*lines, width=DOT_BYTES), bytes(row + [chunks + chunk for chunk in row])


def pad_lines(*lines, width=LINE_BYTES):
    """Return lines of `width` bytes each."""
    text = b"".join(line.encode().ljust(width - 1) + b"\n" for line in lines)
    assert len(text) == width * len(lines)
    return text


def fast_router(lengths_mm=(0.2, 0.75), name="router_3axis", laser=False, clock_mhz=125, mm_s=250, mm_s2=20_000):
    """Boot an EmulatedMachine of the board file that waits for run_lines(); with a `laser` instead of a spindle for run_raster(). Its axes take 250
    mm/s and 20 m/s², so that the processor is the limit; or what the drive's pulses leave room for."""
    return boot_router(*fast_board(lengths_mm, name, laser, clock_mhz, mm_s, mm_s2))


def fast_board(lengths_mm, name="router_3axis", laser=False, clock_mhz=125, mm_s=250, mm_s2=20_000):
    """Return (board, texts) of fast_router()."""
    board = {**boards.load(name), "clock_mhz": clock_mhz}
    pulses_s = TICKS_PER_S // word_times(board)[1]
    for axis in board["axes"]:
        axis.update(max_mm_min=min(60 * mm_s, 60_000 * pulses_s // axis["steps_per_m"]), accel_mm_s2=mm_s2)
    if laser:
        board["spindle"] = {"max_rpm": 1000, "min_rpm": 0, "pwm": True, "pin": LASER_PIN, "pwm_hz": 5000, "laser": True}
    return board, {f"{length}.txt": raster(length)[0] if laser else chords(length)[1] for length in lengths_mm}


def boot_router(board=None, texts=(), jerk=0):
    """Boot a machine that waits for run_lines(), of a board, a dict; default router_3axis. `texts`: files for run_lines(), late_words() wants none.
    `jerk`: mm/s³, kept in its settings."""
    board = board or boards.load("router_3axis")
    files = {**files_of(board)}
    assert files["main.py"].count(_RUN) == 1
    files["main.py"] = files["main.py"].replace(_RUN, _ATTACH + _RUN)
    files.update(line_of_memory())
    files.update(texts)
    if jerk:
        slots = MemorySlots()
        Journal(slots).write(f"{JERK}={jerk * 1000}")
        files.update({f"settings.{slot}": slots.read(slot) for slot in range(2) if slots.read(slot)})
    machine = EmulatedMachine(board, files, trace=None).boot()
    machine.pico.console.expect(b"ready")
    machine.free_bytes = int(machine.pico.console.expect(b"\n").split()[-1])
    return machine


def line_of_memory():
    """Return {name: bytes} of the module that stands for a link."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "memory_line.py", Path(folder) / "memory_line.mpy"
        source.write_text(_LINE)
        compile_module(source, target, "armv6m", "memory_line")
        return {target.name: target.read_bytes()}


def talk_to(machine):
    """Put the machine's first link on USB, as it is flashed."""
    machine.pico.console.send(b"pass\n")
    machine.run_ms(100)


def time_first_steps(machine, count=10):
    """Return the milliseconds from the last byte of a command to a machine at rest, over USB, to the first step, of each trial. Its drivers have
    been switched on before: that takes 20 ms more."""
    _send_and_wait(machine, b"$X\nG21G91F6000\nG1X1\n", 3)
    machine.run_ms(300)
    edges = machine.pico.record_edges(machine.board["axes"][0]["pins"][0])
    taken = []
    for trial in range(count):
        machine.run_ms(120 + 0.37 * trial)  # at no fixed place of the firmware's turns
        edges.clear()
        sent = machine.pico.cycle
        machine.pico.console.send(b"G1X%d\n" % (1 - trial % 2 * 2))
        machine.run_ms(60)
        taken.append((edges[0][0] - sent) / CYCLES_PER_MS)
    return taken


def time_holds(machine, count=5):
    """Return the milliseconds from the byte of a feed hold to the first step that comes later than at full speed, of each trial."""
    _send_and_wait(machine, b"$X\nG21G91\n", 2)
    edges = machine.pico.record_edges(machine.board["axes"][0]["pins"][0])
    taken = []
    for trial in range(count):
        _send_and_wait(machine, b"G1X%dF6000\n" % (30 - trial % 2 * 60), 1)
        machine.run_ms(120 + 0.37 * trial)
        rises = [cycle for cycle, state in edges if state == 1]
        even = max(after - before for before, after in zip(rises[-100:], rises[-99:]))
        edges.clear()
        sent = machine.pico.cycle
        machine.pico.console.send(b"!")
        machine.run_ms(150)
        rises = [cycle for cycle, state in edges if state == 1]
        slower = [before for before, after in zip(rises, rises[1:]) if after - before > even + CYCLES_PER_TICK]
        taken.append((slower[0] - sent) / CYCLES_PER_MS)
        machine.pico.console.send(b"~")
        machine.run_ms(600)
        edges.clear()
    return taken


def _send_and_wait(machine, data, answers):
    """Send bytes to the console and wait for `answers` times "ok". Raises TimeoutError after 2 s of emulated time."""
    console = machine.pico.console
    console.take_output()
    console.send(data)
    if not machine.pico.run_until(lambda: console.text.count(b"ok\r\n") >= answers, 2_000_000):
        raise TimeoutError(f"{data!r} was answered by {console.take_output()!r}")


def run_lines(machine, length_mm, feed_mm_s, count, limit_ms=60_000, profiled=False):
    """Stream `count` lines from the board's memory; return the figures of the last three quarters of them. `profiled`: with their cycles by
    function, a `profile.Spent`."""
    start, _ = chords(length_mm)
    head = pad_lines("$X", "G21G90G94", f"G92X{start}Y50Z-20", f"G1F{60 * feed_mm_s:.0f}")
    return _run_from_memory(machine, length_mm, head, count, LINE_BYTES, bytes(range(CHORDS // LINES_A_READ)), limit_ms, profiled)


def run_raster(machine, dot_mm, feed_mm_s, count, mode="M4", limit_ms=60_000, profiled=False):
    """Stream `count` lines of raster(dot_mm) from the board's memory; return the figures of run_lines()."""
    head = pad_lines("$X", "G21G91G94", f"{mode}S0F{60 * feed_mm_s:.0f}", "G0", width=DOT_BYTES)
    return _run_from_memory(machine, dot_mm, head, count, DOT_BYTES, raster(dot_mm)[1], limit_ms, profiled)


def lines_over(machine, link, length_mm, feed_mm_s, count, think_us=0):
    """Return the lines a second, of the last three quarters of `count`, over this link of the board file, at most 127 bytes under way."""
    start, text = chords(length_mm)
    head = b"$X\nG21G90G94\nG92X%.3fY50Z-20\nG1F%d\n" % (start, 60 * feed_mm_s)
    return _run_over_link(machine, link, head, text, count, think_us)


def dots_over(machine, link, dot_mm, feed_mm_s, count, think_us=0, mode="M4"):
    """Return the lines of raster(dot_mm) a second, of the last three quarters of `count`, over this link."""
    text, order = raster(dot_mm)
    each = LINES_A_READ * DOT_BYTES
    head = b"$X\nG21G91G94\n%sS0F%d\nG0\n" % (mode.encode(), 60 * feed_mm_s)
    return _run_over_link(machine, link, head, b"".join(text[each * at : each * (at + 1)] for at in order), count, think_us)


def _run_over_link(machine, link, head, text, count, think_us):
    """Stream `head`, then `count` lines of `text` over `link`. Returns lines a second, measured from a quarter of them on."""
    talk_to(machine)
    asking = Asking(machine, link, think_us)
    lines = [line.rstrip() + b"\n" for line in text.splitlines()]
    head = b"$LINK=0\n" * (link != machine.board["links"][0]["name"]) + head  # the first link has the command
    asking.stream_lines(head.splitlines(keepends=True) + (lines * (count // len(lines) + 1))[:count])
    begun = []
    for wanted in (count // 4, count):
        wanted += head.count(b"\n")
        machine.run_until(lambda: asking.said.count(b"ok\r\n") >= wanted, slice_us=100)
        begun.append(machine.pico.cycle)
    assert b"error" not in asking.said
    return (count - count // 4) * 1000 * CYCLES_PER_MS / (begun[1] - begun[0])


def _run_from_memory(machine, name, head, count, width, order, limit_ms, profiled):
    """Let the board run `count` lines of `width` bytes out of its own memory. Returns a dict: lines/s, fewest words ahead, late words, shares of main
    loop, timers and sleep, and the profile if `profiled`."""
    total = count + len(head) // width
    console = machine.pico.console
    console.send(f"go('{name}.txt',{head!r},{total},{count // 4},{width},{order!r})\n".encode())
    console.expect(b"warm", limit_ms * 1000)
    load = Load(machine.pico)
    profile = Profile(machine.pico) if profiled else None
    console.expect(b"done", limit_ms * 1000)
    shares = load.end()
    spent = profile and profile.end()
    answered, took_us, least, late = map(int, console.expect(b"\n").split())
    return {
        "lines_s": answered * 1e6 / took_us,
        "least": least,
        "late": late,
        "main": shares.get("main", 0),
        "asleep": shares.get("asleep", 0),
        "timers": shares.get("timers", 0),
        "lines": answered,
        "spent": spent,
    }


def late_words(machine, lines, limit_ms=60_000):
    """Carry out a programme to its end; return how often the player ran dry inside a block."""
    lines = ["$X", *lines, "G4P0.01"]
    head = pad_lines(*lines, *[""] * (-len(lines) % LINES_A_READ))
    machine.pico.console.send(f"go('',{head!r},{len(head) // LINE_BYTES},0,{LINE_BYTES},b'')\n".encode())
    machine.pico.console.expect(b"done", limit_ms * 1000)
    return int(machine.pico.console.expect(b"\n").split()[-1])
