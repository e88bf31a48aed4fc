"""Rows of `passo prove` that move pins: edges against words, three axes at their fastest, the emergency input and the position behind it."""

import base64
import statistics
import struct

from host_tools.failure import Failure
from host_tools.language import _
from host_tools.prove import edges
from host_tools.prove.board_words import Words, run_until_still
from host_tools.prove.promises import KEPT, PROMISES
from host_tools.prove.row import LEFT_OUT, Row, equality_row, number_text
from passo.steps.word import TICKS_PER_S

ROOM = 2048  # records of the witness
WIDEST = 12  # pins that it looks at
HALTS = 20
OWN_S, FAST_STEPS, FAST_HZ = 0.012, 900, 480_000
FAST = {"steps_per_m": 400_000, "max_mm_min": 72_000, "accel_mm_s2": 900_000}
COILS_HZ = 5000
# Has the pull's resistor hold the input at its inactive level before the machine moves.
_LOOK = """
witness = Witness({base}, {width}, RECORDS)
other = Witness({pin}, 1, bytearray(256), 5)
set_pull({pin}, {rest})
sleep_ms(5)
clear_stop()
gc.collect()
"""


class Shape:
    """The machine of a session as the PC sees it."""

    def __init__(self, proof, changes):
        from passo.machine_builder import make_drive
        from passo.steps.wiring import inversion_mask, word_pins, word_times

        self.board = proof.machine(changes)
        self.layout, _drive, _rest = make_drive(self.board)
        pins = word_pins(self.board)
        self.base, self.width = pins[0], min(len(pins) - 1, WIDEST)
        self._invert = inversion_mask(self.board, self.layout) & (1 << self.width) - 1
        self.pulse_ticks, self.least_ticks = word_times(self.board)

    def levels_seen(self, records):
        """Return [(cycle, levels as words have them)] of the witness's records."""
        return [(cycle, levels ^ self._invert) for cycle, levels in edges.decode_records(records, self.width)]

    def changes_of(self, lines):
        """Return [(tick, levels)] that the words of `lines`, [(deltas, ticks)], ask of the pins."""
        from passo.app import App

        words = []
        app = App(self.board, Words(words, self.least_ticks))
        for deltas, ticks in lines:
            app.planner.line(deltas, ticks, False)
        app.planner.flush()
        app.controller.machine.awake = True
        run_until_still(app)
        return edges.changes_in_words(words, self.layout.bits, self.width, self.layout.pulse_mask, self.pulse_ticks)


def check_enable(proof):
    """Raise Failure if an output that switches the motors' current is not off, as the pin itself says."""
    for item in proof.raw.get("outputs", ()):
        if item["name"] == "enable" and int(proof.board.exec(f"print(pin_level({item['pin']}))")) == item.get("active", 1):
            raise Failure("enable (GPIO{}) is on though the board switches it off: something else holds it, and motors have current. Nothing was moved", item["pin"])


def chip_mhz(proof):
    """Return the system clock of the board's chip, in MHz."""
    return int(proof.board.exec("print(machine.freq())")) / 1e6


def run_on_board(proof, code, *limit_s):
    """Run code on the board; returns (numbers of the first line behind "= ", lines of records). Output of the machine's link comes before."""
    first, *rest = proof.board.exec(code, *limit_s).rpartition("\n= ")[2].splitlines()
    return [int(each) for each in first.split()], rest


def position_of(proof):
    return [int(each) for each in proof.board.exec("print(*feeder.position(player.words_played()))").split()]


def play_lines(proof, changes, lines):
    """Play lines while the witness records; returns (Found, words late, shape, [(cycle, levels)]). Raises Failure if nothing moved or was
    recorded."""
    shape = Shape(proof, changes)
    proof.begin("make", changes, more=("board_witness.py",))
    check_enable(proof)
    proof.board.exec(f"witness = Witness({shape.base}, {shape.width}, RECORDS)\ngc.collect()")
    (late, taken, finished), records = run_on_board(proof, f"play({lines!r}, witness)")
    check_enable(proof)
    if not finished:
        raise Failure("the player does not play: its DMA or its state machine stands still, and the queue stays full")
    if not taken:
        raise Failure("the witness has seen nothing: its DMA carries nothing")
    seen = shape.levels_seen(records_printed(records[:-1]))
    if len(seen) < 2:
        raise Failure("no pin has changed, though the player says it played: its DMA hands nothing over, or the pins are held")
    changes = shape.changes_of(lines)
    if taken >= ROOM:
        changes = changes[: len(seen) - 1]
    motors = shape.layout.motors if shape.pulse_ticks else 0
    return edges.compare_edges(seen, changes, shape.width, shape.layout.axes, motors, chip_mhz(proof)), late, shape, seen


def difference_text(found, shape):
    """Return the sentence about pins that differ from the words, with the two GPIOs if they are swapped."""
    if found.swapped:
        a, b = (shape.base + bit for bit in found.swapped)
        return _("GPIO{} and GPIO{} do what the other should: the pins are swapped", a, b)
    return _("the pins do not do what the words say")


def without_ramps(proof):
    """Return changes to the board: its own machine, but without ramps that would fill the witness's memory."""
    return {"axes": [dict(axis, accel_mm_s2=900_000) for axis in proof.raw["axes"]]}


def there_and_back(board, seconds):
    """Return lines, [(deltas, ticks)], at which every axis goes as fast as it may."""
    rates = [axis["max_mm_min"] * axis["steps_per_m"] // 60_000 for axis in board["axes"]]
    if board["drive"]["kind"] != "step_dir":
        rates = [min(rate, COILS_HZ) for rate in rates]
    deltas = [max(1, int(rate * seconds)) for rate in rates]
    ticks = round(seconds * TICKS_PER_S)
    return [(deltas, ticks), ([-each for each in deltas], ticks)]


def edges_of(proof):
    """Yield the rows of moves at the board's own speed: every edge as the words have it, pulse length, setup time (ns) and late words."""
    changes = without_ramps(proof)
    board = proof.machine(changes)
    found, late, shape, seen = play_lines(proof, changes, there_and_back(board, OWN_S))
    note_timings(proof, "own", found, seen)
    yield Row("enable", _("motors' current"), _("off all along"), verdict=KEPT)
    if not found.same:
        yield equality_row("levels", _("edges on the pins"), difference_text(found, shape), False, _("check board file and wiring before anything moves"))
        if found.swapped:
            return
    else:
        yield equality_row("levels", _("edges on the pins"), _("{} steps, every edge there and none else", found.steps), True, "")
    drive = board["drive"]
    if found.pulse_ns:
        low, high = (number_text(each / 1000) for each in found.pulse_ns)
        off_ns = max(abs(each - 1000 * drive["pulse_us"]) for each in found.pulse_ns)
        yield proof.judge("pulse_ns", off_ns, found=_("{} to {} µs, wanted {}", low, high, drive["pulse_us"]))
    if found.setup_ns is not None:
        short_ns = max(0, 1000 * drive["setup_us"] - found.setup_ns)
        yield proof.judge("setup_ns", short_ns, found=_("{} µs, wanted {}", number_text(found.setup_ns / 1000), drive["setup_us"]))
    if found.same:
        yield proof.judge("edge_ns", found.off_ns)
    yield proof.judge("late_words", late)


def fastest(proof):
    """Yield a row: all axes at FAST_HZ steps/s with 1 µs pulses; kept if all edges come in time. Left out for coils and the timer player."""
    if proof.raw["drive"]["kind"] != "step_dir" or proof.raw.get("player", "pio") == "timer":
        yield Row("fastest", _("three axes at their fastest"), _("not for coils, nor for the timer player"), verdict=LEFT_OUT)
        return
    axes = [dict(axis, **FAST) for axis in proof.raw["axes"]]
    changes = {"axes": axes, "drive": dict(proof.raw["drive"], pulse_us=1)}
    lines = [([FAST_STEPS] * len(axes), FAST_STEPS * TICKS_PER_S // FAST_HZ)]
    found, late, shape, seen = play_lines(proof, changes, lines)
    note_timings(proof, "fastest", found, seen)
    steady_ns = found.interval_ns[len(found.interval_ns) // 4 :]
    kept = found.same and found.off_ns <= PROMISES["edge_ns"].bound and late == 0
    told = difference_text(found, shape)
    if found.same:
        told = _("{} kHz, edges within {} ns of their words, {} late", number_text(1e6 / statistics.mean(steady_ns)), number_text(found.off_ns), late)
    yield proof.judge("fastest_khz", FAST_HZ // 1000 if kept else 0, found=told, edge_ns=found.off_ns)


def note_timings(proof, name, found, seen):
    proof.timings[name] = {"lateness_ns": found.lateness_ns, "interval_ns": found.interval_ns, "seen": seen}


def stops(proof):
    """Yield rows: the longest time from the emergency input's edge to the last step in µs, and how many of HALTS positions are wrong."""
    what = _("emergency input and position")
    halting = [item for item in proof.raw.get("inputs", ()) if item.get("halt")]
    if not halting or proof.raw["drive"]["kind"] != "step_dir":
        yield Row("stops", what, _("the board file has no halting input"), verdict=LEFT_OUT)
        return
    pin, active = halting[0]["pin"], halting[0].get("active", 1)
    changes = {**without_ramps(proof), "inputs": halting[:1]}
    shape = Shape(proof, changes)
    proof.begin("make", changes, more=("board_witness.py",))
    proof.board.exec(_LOOK.format(base=shape.base, width=shape.width, pin=pin, rest=1 - active))
    check_enable(proof)
    mhz = chip_mhz(proof)
    lines = there_and_back(shape.board, 0.5)
    waits, wrong = [], 0
    for trial in range(HALTS):
        found = measure_halt(proof, shape, f"halt({lines!r}, witness, other, {pin}, {active}, {4 + trial % 8})", active)
        if found is None:
            yield Row("stops", what, _("input {} (GPIO{}) does not follow the chip's own resistor: something is wired to it", halting[0]["name"], pin), verdict=LEFT_OUT)
            return
        waits.append(found[0] / mhz)
        wrong += not found[1]
    check_enable(proof)
    proof.timings["stops"] = waits
    yield proof.judge("stop_us", max(waits), found=_("{} µs at most, {} in the middle, {} stops", number_text(max(waits)), number_text(statistics.median(waits)), HALTS))
    yield proof.judge("halts_off", wrong, found=_("{} of {} positions exact", HALTS - wrong, HALTS))


def measure_halt(proof, shape, code, active):
    """Have an input halt the machine; returns (cycles from its edge to the last step, whether the position is that of the steps), None if the input
    did not follow."""
    before = position_of(proof)
    (reached, *position), rest = run_on_board(proof, code)
    if not reached:
        return None
    cut = rest.index("-")
    seen = shape.levels_seen(records_printed(rest[:cut]))
    pressed = [cycle for cycle, level in edges.decode_records(records_printed(rest[cut + 1 : -1]), 1)[1:] if level == active]
    steps = [cycle for (_at, old), (cycle, levels) in zip(seen, seen[1:]) if levels & ~old & shape.layout.pulse_mask]
    if not pressed or not steps:
        raise Failure("the witness has seen no stop: {} steps, {} edges of the input", len(steps), len(pressed))
    went = [now - then for now, then in zip(position, before)]
    return max(0, steps[-1] - pressed[0]), went == edges.count_steps(seen, shape.layout.axes, shape.layout.motors)


def bytes_printed(lines):
    """Decode the base64 lines that the board printed."""
    return b"".join(base64.b64decode(line) for line in lines)


def records_printed(lines):
    """Decode the records that the board printed."""
    data = bytes_printed(lines)
    return struct.unpack(f"<{len(data) // 4}I", data)
