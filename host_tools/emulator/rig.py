"""The firmware's App on an emulated Pico, under a main loop of the caller's, with every edge on record.

    rig = Rig(router_board(3), uf2=None)
    run = rig.play([((4000, 4000, 4000), 100_000)], loop="gc.collect()")
    run.off, run.late, run.shares

`play` draws lines of (deltas, steps a second) through planner, feeder, interrupt and player, while the main loop turns
the App and does what `loop` says, and compares the edges on the pins with the words that the same firmware makes of
the same lines under CPython.
"""

import copy

from host_tools.emulator.cycles import CYCLES_PER_TICK
from host_tools.emulator.load import Load
from host_tools.emulator.machine import files_of
from host_tools.emulator.pico import EmulatedPico
from passo.config.boardfile import check
from passo.machine_builder import make_drive
from passo.motion.planner import Planner
from passo.steps.feeder import Feeder
from passo.steps.ring import Ring
from passo.steps.wiring import inversion_mask, word_pins, word_times
from passo.steps.word import COUNT_MASK, TICKS_PER_S, us_to_ticks

START = """
import gc
gc.threshold(16000)
from passo.ports.rp2.stock import flash_code
flash_code.begin()
from passo.app import App
from passo.config.boardfile import check
from passo.ports.rp2 import clock
from passo.ports.rp2.port import Port, load
from passo.machine_builder import load_all
from time import ticks_us, ticks_diff, ticks_ms, sleep_ms
from board import BOARD
def set_up():
    global port, app, planner, feeder, player, controller
    clock.set_mhz(board["clock_mhz"])
    port = Port(board)
    app = App(board, port)
    planner, feeder, player, controller = app.planner, app.feeder, app.player, app.controller
def pending():
    return [link for link in app.links if link.serial.any() or link.protocol._bytes]
board = check(BOARD)
load(board)
load_all(board)
flash_code.code.finish()
set_up()
gc.collect()
"""
FIT = """
app.stop()
port.close()
board = port = app = planner = feeder = player = controller = None
gc.collect()
board = check({board!r})
set_up()
gc.collect()
"""
PLAY = """
for deltas, ticks in {lines!r}:
    planner.line(deltas, ticks, False)
planner.flush()
controller.machine.awake = True
turns = 0
while not planner.empty() or player.busy():
    app.cycle()
    {loop}
    turns += 1
print(feeder.late, turns, feeder.position(player.words_played()))
"""
FIRST_PIN, ENABLE_PIN = 2, 15
_LEAD_TICKS = 150_000
_TIMER_LEAST_TICKS = 500  # SHORTEST_TICKS of options/player_timer: that module is for a board only


def router_board(axes=3, **changes):
    """Return a board dict: STEP/DIR, pulses of 1 µs, so that words may follow each other every 2.08 µs."""
    board = {
        "name": "bench",
        "chip": "rp2040",
        "drive": {"kind": "step_dir", "pulse_us": 1, "setup_us": 5},
        "axes": [
            {"name": "xyza"[axis], "pins": [FIRST_PIN + axis, FIRST_PIN + axes + axis],
             "steps_per_m": 400000, "travel_steps": 65000, "max_mm_min": 72000, "accel_mm_s2": 500}
            for axis in range(axes)
        ],
        "tool": {"pin": FIRST_PIN + 2 * axes},
        "inputs": [],
        "outputs": [{"name": "enable", "pin": ENABLE_PIN, "active": 0}],
        "speed": {"unit": "steps_per_s", "default": 10000, "min": 100, "max": 25000},
        "jog": {"steps": 400, "up": "y+" if axes > 1 else "x+"},
        "idle_release_ms": 0,
        "store_points": 500,
        "links": [
            {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "plotter", "idle_gap_ms": 5},
        ],
    }
    board.update(copy.deepcopy(changes))
    return board


def ticks_of(deltas, steps_s):
    """Return the ticks of a line whose dominant axis steps `steps_s` times a second."""
    return max(map(abs, deltas)) * TICKS_PER_S // steps_s


def words_of(board, lines):
    """Return [(ticks, levels)] of the words that the firmware makes of `lines` here, under CPython."""
    layout, drive, _ = make_drive(board)
    _, least = word_times(board)
    if board["player"] == "timer":
        least = max(least, _TIMER_LEAST_TICKS)
    planner, ring = Planner(layout.axes), Ring()
    setup = us_to_ticks(board["drive"]["setup_us"]) if drive is None else 0
    feeder = Feeder(ring, layout, planner, drive, setup and max(setup, least), least)
    words, played = [], 0
    for deltas, ticks in lines:
        planner.line(deltas, ticks, False)
    planner.flush()
    while not planner.empty():
        feeder.fill(played, _LEAD_TICKS)
        while played != ring.head:
            word = ring.words[played & ring.mask]
            words.append((word >> layout.bits, word & layout.levels_mask))
            played = played + 1 & COUNT_MASK
        feeder.retire(played)
    return words


class Run:
    """The result of `play`. Cycles are of 8 ns; `off` is the largest distance of an edge from where its word puts it."""

    def __init__(self):
        self.steps = self.off = self.late = self.turns = self.span = self.span_off = 0
        self.widths = set()  # of the pulses, in cycles
        self.setups = []  # cycles from each edge of a DIR pin to the next STEP
        self.lateness = []  # of the STEP edges after the first, in cycles
        self.shares = {}
        self.position = []

    def share_left(self):
        """Return the share of the processor that interrupts leave."""
        return self.shares.get("main", 0) + self.shares.get("asleep", 0)


class Rig:
    def __init__(self, board, uf2=None, start=START):
        self.board = check(copy.deepcopy(board))
        files = {path: data for path, data in files_of(board).items() if path != "main.py"}
        self.pico = EmulatedPico(files=files, uf2=uf2).boot()
        self._record_edges()
        self.pico.exec(start)

    def load_board(self, board):
        """Make the App anew, for another board. Only on a copy, and once: the player's first program stays where it is."""
        self.board = check(copy.deepcopy(board))
        self._record_edges()
        self.pico.exec(FIT.format(board=board))

    def _record_edges(self):
        self.axes = len(self.board["axes"])
        self.edges = [self.pico.record_edges(pin) for pin in word_pins(self.board)]
        self.step_edges, self.dir_edges = self.edges[: self.axes], self.edges[self.axes : 2 * self.axes]

    def wire(self):
        """Return the wire of UART0."""
        return self.pico.uart(0)

    def clear_edges(self):
        """Forget the edges so far, and count steps anew."""
        for log in self.edges:
            log.clear()
        pins = word_pins(self.board)
        self._levels = sum((self.pico.pads.state_of(pin) == 1) << bit for bit, pin in enumerate(pins))

    def _inversions(self):
        return inversion_mask(self.board, make_drive(self.board)[0])

    def count_steps(self):
        """Count the steps of each axis since the last clear_edges(), signed, as a STEP/DIR driver would: by edges alone."""
        invert = self._inversions()
        positions = []
        for axis, (steps, turns) in enumerate(zip(self.step_edges, self.dir_edges)):
            rise, back = 1 - (invert >> axis & 1), invert >> self.axes + axis & 1
            position = 0
            for cycle, state in steps:
                if state == rise:
                    direction = [level for at, level in turns if at <= cycle][-1:] or [back]
                    position += 1 if direction[0] != back else -1
            positions.append(position)
        return positions

    def play(self, lines, loop="pass", limit_us=3_000_000, meanwhile=None):
        """Play lines, [(deltas, steps a second of the dominant axis)], to their end; return a Run. `loop`: code of the main loop; `meanwhile()` is
        called before each slice."""
        timed = [(deltas, ticks_of(deltas, steps_s)) for deltas, steps_s in lines]
        self.clear_edges()
        self.pico.console.start(PLAY.format(lines=timed, loop=loop))
        run, end = Run(), self.pico.cycle + limit_us * 125
        while not any(self.step_edges):
            self.pico.run(200)
        load = Load(self.pico)
        while not self.pico.console.text.count(b"\x04") >= 2:
            if self.pico.cycle > end:
                raise TimeoutError(f"still playing after {limit_us} µs")
            if meanwhile:
                meanwhile()
            self.pico.run(500)
        run.shares = load.end()
        said, error = self.pico.console.take_output().split(b"\x04")[:2]
        assert not error, error.decode()
        late, turns, position = said.decode().split(" ", 2)
        run.late, run.turns, run.position = int(late), int(turns), eval(position)
        compare = self._compare_steps if self.board["drive"]["kind"] == "step_dir" else self._compare_levels
        compare(run, words_of(self.board, timed))
        return run

    def _compare_levels(self, run, words):
        """Compare the levels of coils with the words: every change must be there, and no other since the motors woke up."""
        tick, last, wanted = 0, make_drive(self.board)[1].levels(), []
        for ticks, levels in words:
            if levels != last:
                wanted.append((tick, levels))
            tick, last = tick + ticks, levels
        levels, found = self._levels, []
        for cycle, bit, state in sorted((cycle, bit, state) for bit, log in enumerate(self.edges) for cycle, state in log):
            levels = levels & ~(1 << bit) | state << bit
            if found and found[-1][0] == cycle:
                found.pop()
            found.append((cycle, levels))
        found = found[-len(wanted) :]
        assert [seen for _, seen in found] == [levels for _, levels in wanted]
        origin = found[0][0] - wanted[0][0] * CYCLES_PER_TICK
        run.steps = len(found)
        run.lateness = [cycle - origin - due * CYCLES_PER_TICK for (cycle, _), (due, _) in zip(found, wanted)]
        run.off = max(map(abs, run.lateness))

    def _compare_steps(self, run, words):
        """Compare the edges with the words: every one must be there, and no other."""
        invert = self._inversions()
        tick, wanted = 0, [[] for _ in range(self.axes)]
        for ticks, levels in words:
            for axis in range(self.axes):
                if levels >> axis & 1:
                    wanted[axis].append(tick)
            tick += ticks
        rises = [[cycle for cycle, state in log if state == 1 - (invert >> axis & 1)]
                 for axis, log in enumerate(self.step_edges)]
        origin = min(log[0] - ticks[0] * CYCLES_PER_TICK for log, ticks in zip(rises, wanted) if log and ticks)
        for axis in range(self.axes):
            assert len(rises[axis]) == len(wanted[axis]), f"{len(rises[axis])} steps for {len(wanted[axis])} words"
            run.steps += len(rises[axis])
            late = [cycle - origin - CYCLES_PER_TICK * due for cycle, due in zip(rises[axis], wanted[axis])]
            run.lateness += late
            log = self.step_edges[axis]
            run.widths |= {b[0] - a[0] for a, b in zip(log, log[1:]) if a[1] == 1 - (invert >> axis & 1)}
            for at, _ in self.dir_edges[axis]:
                after = [cycle for cycle in rises[axis] if cycle >= at]
                if after:
                    run.setups.append(after[0] - at)
        run.off = max(map(abs, run.lateness))
        first, last = min(log[0] for log in rises if log), max(log[-1] for log in rises if log)
        due = [ticks for log in wanted for ticks in log]
        run.span, run.span_off = last - first, last - first - (max(due) - min(due)) * CYCLES_PER_TICK
