"""`passo prove --analyser` on the emulated Pico: its samples against the emulator's own log, and its files opened by programs that are not ours."""

import re
import shutil
import subprocess
from functools import lru_cache

import pytest
from emulated import uf2  # noqa: F401
from pico_on_a_port import on_a_port
from vcd.reader import TokenKind, tokenize

from host_tools import boards
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.cycles import CYCLE_NS
from host_tools.failure import Failure
from host_tools.prove import analyser
from host_tools.prove.connection import EmulatedBoard
from host_tools.prove.proof import Proof

BOARD = "router_3axis"

pytestmark = pytest.mark.xdist_group("prove")


@lru_cache
def _board():
    return EmulatedBoard(BOARD)


@pytest.fixture
def board(uf2):
    """Only for tests that work on a copy."""
    return _board()


def levels_of(capture):
    """[(ns, bit, level)] of the edges in a capture, from its first sample on."""
    edges = []
    for number, (before, now) in enumerate(zip(capture.samples, capture.samples[1:]), 1):
        edges += [(number * capture.period_ps / 1000, bit, now >> bit & 1) for bit in range(8) if (before ^ now) >> bit & 1]
    return edges


def logged(logs):
    return sorted((cycle * CYCLE_NS, bit, state) for bit, log in enumerate(logs) for cycle, state in log if state in (0, 1))


def all_high(log):
    """When the first three channels are high for the first time for four samples of 80 ns."""
    levels, since = 0, None
    for ns, bit, state in log:
        if since is not None and ns - since > 320:
            return since
        levels = levels & ~(1 << bit) | state << bit
        since = (ns if since is None else since) if levels & 7 == 7 else None
    return since


TRIGGERS = {
    "rise:2": lambda log: next(ns for ns, bit, state in log if (bit, state) == (0, 1)),
    "fall:3": lambda log: next(ns for ns, bit, state in log if (bit, state) == (1, 0)),
    "word:111": all_high,
}


@pytest.mark.unmeasured
@pytest.mark.parametrize("trigger, mhz", [("rise:2", 25), ("word:111", 12.5), ("fall:3", 5)])
def test_it_samples_what_the_emulator_logs(board, trigger, mhz, show):
    """Three axes of the router: each edge within a sample of the log's, and none missed that lasts a sample."""

    def measured():
        wanted = analyser.Wanted.from_words(analyser.Path("a.vcd"), 2, mhz, trigger, True)
        proof = Proof(board, boards.load(BOARD), True)
        logs = [board.pico.record_edges(pin) for pin in range(2, 8)]
        start = board.start

        def cleared(code):
            if code.startswith("play("):
                for log in logs:
                    log.clear()
            start(code)

        board.start = cleared
        return wanted.capture_samples(proof), logged(logs)

    capture, log = on_a_copy(measured)
    assert capture.hz == mhz * 1e6 and len(capture.samples) == analyser.PLAYED
    seen, sample_ns = levels_of(capture), capture.period_ps / 1000
    first = next(number for number, row in enumerate(log) if row[1:] == seen[0][1:] and [each[1:] for each in log[number : number + 40]] == [each[1:] for each in seen[:40]])
    pairs = list(zip(seen, log[first:]))
    assert len(seen) > 60 and [each[1:] for each, _ in pairs] == [each[1:] for _, each in pairs]
    apart = [ours[0] - theirs[0] for ours, theirs in pairs]
    assert max(apart) - min(apart) <= sample_ns, (min(apart), max(apart), sample_ns)
    late = log[first][0] - seen[0][0] - TRIGGERS[trigger](log)
    assert 0 <= late <= 7 * sample_ns, "from the trigger to the first sample"
    show(f"{trigger}, {mhz} MHz", f"{len(seen)} edges, {max(apart) - min(apart):.0f} ns apart at a sample of {sample_ns:.0f}; {late:.0f} ns after the trigger")


@pytest.fixture(scope="module")
def capture():
    """Of 100 000 samples, with edges one sample apart and far apart."""
    samples = bytearray(100_000)
    for at in range(len(samples)):
        samples[at] = at & 1 | (at // 7 & 1) << 1 | (at // 1000 & 1) << 6 | (at > 99_990) << 7
    return analyser.Capture(200_000_000, 8, bytes(samples))


NAMES = ["step_x", "step_y", "step_z", "dir_x", "dir_y", "dir_z", "GPIO8", "GPIO9"]


def test_the_vcd_as_pyvcd_reads_it(capture, tmp_path):
    analyser.WRITERS[".vcd"](tmp_path / "a.vcd", capture, NAMES)
    names, levels, now, scale = {}, {}, 0, None
    made = bytearray()
    with open(tmp_path / "a.vcd", "rb") as file:
        for token in tokenize(file):
            if token.kind is TokenKind.TIMESCALE:
                scale = str(token.timescale)
            elif token.kind is TokenKind.VAR:
                names[token.var.id_code] = NAMES.index(token.var.reference)
            elif token.kind is TokenKind.CHANGE_TIME:
                made += bytes([sum(levels[bit] << bit for bit in levels)]) * ((token.time_change - now) // 4)
                now = token.time_change
            elif token.kind is TokenKind.CHANGE_SCALAR:
                levels[names[token.scalar_change.id_code]] = int(token.scalar_change.value)
    assert scale == "10 ns" and bytes(made) == capture.samples


def program(name):
    if shutil.which(name) is None:
        pytest.skip(f"NOT TRIED: there is no {name} (Debian: sigrok-cli, gtkwave)")
    return name


@pytest.mark.parametrize("suffix", [".vcd", ".sr"])
def test_sigrok_reads_the_same_samples(capture, tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    analyser.WRITERS[suffix](path, capture, NAMES)
    words = [program("sigrok-cli"), "-i", str(path), "-O", "binary", "-o", str(tmp_path / "bytes")]
    subprocess.run(words, check=True, capture_output=True, timeout=100)
    shown = subprocess.run(["sigrok-cli", "-i", str(path), "--show"], check=True, capture_output=True, text=True, timeout=100).stdout
    assert all(name in shown for name in NAMES)
    read = re.sub(rb"\AMETA samplerate: \d+\n", b"", (tmp_path / "bytes").read_bytes())
    each = len(read) // len(capture.samples)  # sigrok samples a VCD at its unit
    assert len(read) == each * len(capture.samples) and read[::each] == capture.samples
    assert suffix == ".vcd" or "25000000" in shown


def test_gtkwave_reads_the_vcd(capture, tmp_path):
    analyser.WRITERS[".vcd"](tmp_path / "a.vcd", capture, NAMES)
    subprocess.run([program("vcd2fst"), str(tmp_path / "a.vcd"), str(tmp_path / "a.fst")], check=True, capture_output=True, timeout=100)
    back = subprocess.run([program("fst2vcd"), str(tmp_path / "a.fst")], check=True, capture_output=True, timeout=100).stdout.decode()
    times = [int(line[1:]) for line in back.splitlines() if line.startswith("#")]
    changes = sum(before != now for before, now in zip(capture.samples, capture.samples[1:]))
    assert all(f" {name} " in back for name in NAMES) and len(set(times)) in (changes + 1, changes + 2) and max(times) // 4 in (99_999, 100_000)


@pytest.mark.unmeasured
def test_the_command_looks_at_pins_of_something_else(board, tmp_path, show):
    """A square wave from outside on GPIO22, over a port, with nothing moved; and a trigger that does not come."""

    def measured():
        pico = board.pico
        toggles = []

        def toggle():
            toggles.append(1)
            pico.drive_pin(22, len(toggles) & 1)
            pico.call_at(pico.cycle + 1250, toggle)  # 10 us

        pico.call_at(pico.cycle + 1250, toggle)
        with on_a_port(pico, tmp_path / "port") as over:
            wanted = analyser.Wanted.from_words(tmp_path / "a.sr", 15, 10, "rise:22", False)
            said = wanted.record_to_file(over, {}, False)
            capture = wanted.capture_samples(Proof(over, {}, False))
            wanted = analyser.Wanted.from_words(tmp_path / "b.sr", 15, 10, "rise:8", False)
            wanted.wait_s = 0.2
            with pytest.raises(Failure, match="the trigger did not come"):
                wanted.record_to_file(over, {}, False)
        return said, capture

    said, capture = on_a_copy(measured)
    edges = levels_of(capture)
    sample_ns = capture.period_ps / 1000
    gaps = {now[0] - before[0] for before, now in zip(edges, edges[1:])}
    assert {bit for _, bit, _ in edges} == {7} and all(abs(gap - 10_000) < sample_ns for gap in gaps)
    assert sample_ns == 104 and len(edges) in (len(capture.samples) * 104 // 10_000 - 1, len(capture.samples) * 104 // 10_000)
    assert f"{len(capture.samples)} samples" in said and (tmp_path / "a.sr").stat().st_size > 100
    show("pins of something else", said)


@pytest.mark.parametrize("path, trigger, told", [
    ("a.txt", None, "a capture is a file .vcd or .sr"), ("a.vcd", "rise:x", "a trigger is rise:PIN"), ("a.vcd", "word:012", "a trigger is"),
    ("a.vcd", "word:111111111", "a trigger is"), ("a.vcd", "rise:30", "a trigger is"), ("a.vcd", "high:3", "a trigger is"),
])
def test_what_makes_no_sense_is_said_before_the_board_is_asked(path, trigger, told):
    with pytest.raises(Failure, match=told):
        analyser.Wanted.from_words(analyser.Path(path), 2, 25, trigger, False)
