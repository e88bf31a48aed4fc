"""Passo's UF2 on an emulated RP2350: the start, steps on the pins, the emergency stop, digests. How to repeat it: rp2350.py.

Without the emulator, or a UF2 of this source (make uf2 CHIP=rp2350), these tests skip and say so.
"""

from collections import Counter

import pytest
from rp2350 import CYCLES_PER_US, Rp2350, emulator, image
from test_digest import CHECKS, HEX_JOBS, golden_of_gcode, golden_of_hex, hex_job

from host_tools import boards
from host_tools.build.frozen import compile_beside
from host_tools.emulator.binary import Unavailable
from host_tools.emulator.frozen import board_file
from host_tools.prove.gcode_jobs import all_jobs

pytestmark = [pytest.mark.slow, pytest.mark.unmeasured, pytest.mark.xdist_group("rp2350")]
TICK = 12  # cycles of 150 MHz in 80 ns
STEPS, DIRS, STOP = (2, 3, 4), (5, 6, 7), "p27"
# Before the app runs: the free heap.
SAYS_ROOM = b"""
import sys
sys.path.remove(".frozen")
sys.path.insert(0, ".frozen")
from passo.ports.rp2.start import Start
def run(self, app, port, real=Start.run):
    import gc
    gc.collect()
    print("free", gc.mem_free())
    real(self, app, port)
Start.run = run
"""


def router(**more):
    board = boards.load("router_3axis")
    del board["clock_mhz"]
    return {**board, "chip": "rp2350", **more}


@pytest.fixture
def make():
    """make(files): an Rp2350, closed at the end of the test; the test skips where there is none."""
    try:
        emulator()
        image()
    except Unavailable as reason:
        pytest.skip(f"NOT TESTED ON AN EMULATED RP2350: {reason}")
    made = []

    def one(files, **options):
        made.append(Rp2350(files, **options))
        return made[-1]

    yield one
    for chip in made:
        chip.close()


def at_rest(chip, board):
    chip.drive(**{f"p{item['pin']}": item["active"] ^ 1 for item in board["inputs"]})
    return chip


@pytest.fixture
def started(make):
    """A router that has answered, switches at rest, unlocked; STEP and DIR are watched."""
    board = router()
    chip = at_rest(make({**board_file(board), "boot.py": SAYS_ROOM}), board)
    chip.said = chip.until(b"<Alarm", b"?")
    chip.answered_ms = chip.ms
    chip.watch(STEPS + DIRS)
    chip.send(b"$X\n")
    chip.until(b"ok")
    return chip


def rises(chip, pin):
    return [cycle for cycle, at, level in chip.edges if at == pin and level == 1]


def steps_of(chip):
    """Steps of each axis, by the edges: forwards while DIR is high; it is low at the start."""
    levels, count = Counter(), Counter()
    for _, pin, level in chip.edges:
        levels[pin] = level
        if pin in STEPS and level == 1:
            count[pin] += 1 if levels[pin + 3] == 1 else -1
    return [count[pin] for pin in STEPS]


def test_answers(started, show):
    free = int(started.said.partition(b"free ")[2].split()[0])
    show("RP2350, router_3axis, frozen", f"first answer after {started.answered_ms:.0f} ms, {free} bytes of heap free")
    assert started.answered_ms <= 700 and free >= 300_000
    started.send_uart(b"?", 115_200)
    started.run(30_000)
    assert started.uart.endswith(b">\r\n") and b"<Idle|MPos:0.000,0.000,0.000" in started.uart


def test_steps(started, show):
    """Lines, an arc, Z: every step on a tick of 80 ns, every pulse of one length, the end exact."""
    started.send(b"G91 G1 X10 Y4 F3000\nG2 X2 Y2 I2 F1200\nG1 Z-1 F600\nG4 P0.01\n")
    started.until(b"ok\r\n" * 4, most_ms=3000)
    started.run(20_000)
    assert steps_of(started) == [12 * 320, 6 * 320, -400]
    first = rises(started, STEPS[0])[0]
    assert all((cycle - first) % TICK == 0 for pin in STEPS for cycle in rises(started, pin))
    lengths = set()
    for pin in STEPS:
        falls = [cycle for cycle, at, level in started.edges if at == pin and level == 0 and cycle > first]
        lengths |= {fall - rise for rise, fall in zip(rises(started, pin), falls[-len(rises(started, pin)) :])}
    show("RP2350, pulses", f"{sorted(lengths)} cycles of 150 MHz")
    assert len(lengths) == 1 and 3 * CYCLES_PER_US <= min(lengths) <= 3.1 * CYCLES_PER_US


def test_stop(started, show):
    """The emergency stop: no step later than 25 µs, and the position is what was stepped."""
    started.send(b"G91 G1 X50 F4800\n")
    started.run(400_000)
    before, pressed = len(rises(started, STEPS[0])), started.cycle
    started.drive(**{STOP: 1})
    started.run(20_000)
    stepped = rises(started, STEPS[0])
    show("RP2350, stop", f"last step {(stepped[-1] - pressed) / CYCLES_PER_US:.1f} µs after it, of {len(stepped)}")
    assert before > 1000 and stepped[-1] <= pressed + 25 * CYCLES_PER_US
    started.until(b"ALARM")
    place = started.until(b"<Alarm", b"?") + started.until(b">", b"?")
    said = place.partition(b"MPos:")[2].partition(b",")[0]
    assert float(said) == pytest.approx(len(stepped) / 320, abs=0.0006)


def digest_files(**files):
    named = {f"boards/{name}.py": boards.board_py(name) for name in boards.names()}
    return {**compile_beside("rp2350", {"digest.py": (CHECKS / "digest.py").read_text()}), "boards/__init__.py": b"", **named, **files}


def prompt(chip):
    chip.until(b">>> ")
    return chip


@pytest.mark.parametrize("name", ["pico", "arcs"])
def test_words_of_gcode(make, name, show):
    board, lines = all_jobs()[name]
    chip = prompt(make(digest_files(**{"job.gcode": "".join(f"{line}\n" for line in lines).encode()})))
    begun = chip.ms
    said = chip.exec(f"import digest\ndigest.show_lines('job.gcode', {board!r}, counts=False)", most_ms=60_000).decode().split()
    golden = golden_of_gcode()[name]
    assert [*said[:2], *said[3:]] == [*golden[:2], *golden[3:]]
    show(f"RP2350, digest of {name}", f"{said[1]} words in {chip.ms - begun:.0f} ms")


@pytest.mark.parametrize("name", ["keys", "torch"])
def test_words_of_other_languages(make, name):
    chip = prompt(make(digest_files(**{"job.hex": hex_job(name).encode()})))
    said = chip.exec(f"import digest\ndigest.main(['job.hex', {HEX_JOBS[name][1]!r}])", most_ms=60_000).decode().split()
    assert said == golden_of_hex()[name]


def test_a_counter_that_does_not_answer(make):
    """The start ends in a sentence, at the prompt, outputs safe."""
    chip = at_rest(make(board_file(router()), counter=False), router())
    assert b"RuntimeError: clock_mhz: the chip's frequency counter does not answer" in chip.until(b">>> ")
