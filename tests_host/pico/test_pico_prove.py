"""`passo prove` on the emulated Pico, directly and over a port as a real board: every row, its witness against the emulator's own log, and its rows for a
faulty board.
"""

import json
import os
from functools import lru_cache

import pytest
from emulated import uf2  # noqa: F401
from pico_on_a_port import PicoPort, on_a_port, running
from typer.testing import CliRunner

from host_tools import boards
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.cycles import CYCLES_PER_TICK
from host_tools.failure import Failure
from host_tools.cli.main import app
from host_tools.prove import connection, digests, facts, link, pins, proof
from host_tools.prove.connection import EmulatedBoard
from host_tools.prove.promises import BETTER, KEPT, WORSE
from host_tools.prove.proof import PARTS, Proof
from host_tools.prove.row import LEFT_OUT

BOARD = "router_3axis"
STOP_PIN, STEP_Y, DIR_Y, ENABLE = 27, 3, 6, 14

pytestmark = pytest.mark.xdist_group("prove")


@lru_cache
def _board():
    return EmulatedBoard(BOARD)


@pytest.fixture
def board(uf2):
    """Only for tests that work on a copy."""
    return _board()


@pytest.fixture(params=["directly", "port"])
def way(request, tmp_path):
    """None, or where the Pico's port shall be."""
    return tmp_path / "port" if request.param == "port" else None


def few_jobs(*jobs):
    kept = digests.jobs_of
    digests.jobs_of = lambda language: {name: job for name, job in kept(language).items() if name in jobs}


def rows_of(board, way, *parts, jobs=("helices",), fault=None):
    """Rows of some parts, measured on a copy: {key: (found, verdict, advice)}."""

    def measured():
        few_jobs(*jobs)
        if way is None:
            return rows(board)
        link.QUIET_MS = 3000  # a busy PC may come back late to a board that has begun to serve
        with on_a_port(board.pico, way) as over:
            return rows(over)

    def rows(board):
        if fault:
            fault(board)
        made = Proof(board, boards.load(BOARD), True)
        chosen = [row for row in PARTS if row[1] in parts]
        return {row.key: (row.found, row.verdict, row.advice) for what, part, moves in chosen for row in made._part(what, part, moves)}

    return on_a_copy(measured)


def on_make(board, before="", after=""):
    """Have code run on the board before and after the line that makes its machine."""
    start = board.start

    def with_more(code):
        start(f"{before}\n{code}\n{after}" if code.startswith(("make(", "words(")) else code)

    board.start = with_more


@pytest.mark.unmeasured
def test_the_rows_that_move_pins(board, way, show):
    rows = rows_of(board, way, pins.edges_of, pins.fastest, pins.stops)
    assert set(rows) == {"enable", "levels", "pulse_ns", "setup_ns", "edge_ns", "late_words", "fastest_khz", "stop_us", "halts_off"}
    assert {verdict for _, verdict, _ in rows.values()} == {KEPT, BETTER}
    show("edges on the pins", "; ".join(f"{key} {found}" for key, (found, *_) in rows.items()))


@pytest.mark.unmeasured
def test_an_interrupt_in_front_of_the_first_cycle_makes_no_word_late(board):
    """The feeder's comes each 3 ms: here it always finds lines that no cycle has seen, as if the machine had just been made."""
    code = """
_queue = queue_lines
def queue_lines(lines):
    port.wait(False, False)  # the main loop's heartbeat
    feeder.open = True
    _queue(lines)
    sleep_ms(7)
"""
    rows = rows_of(board, None, pins.edges_of, fault=lambda board: on_make(board, after=code))
    assert rows["levels"][1] == rows["late_words"][1] == rows["edge_ns"][1] == KEPT, rows


@pytest.mark.unmeasured
def test_the_rows_that_want_no_pins(board, way, show):
    rows = rows_of(board, way, facts.facts, facts.memory, digests.digests, facts.watchdog)
    assert {"chip", "stamp", "erase_ms", "page_ms", "clock_khz", "core_mv", "crystal_ppm", "collect_ms", "free_bytes", "piece_bytes", "digests", "watchdog_ms"} <= set(rows)
    assert WORSE not in {verdict for _, verdict, _ in rows.values()}, {key: row for key, row in rows.items() if row[1] == WORSE}
    show("without pins", "; ".join(f"{key} {found}" for key, (found, *_) in rows.items()))


@pytest.mark.slow
@pytest.mark.unmeasured
def test_the_link(board, way, show):
    rows = rows_of(board, way, link.link)
    assert set(rows) == {"bytes_lost", "ask_ms", "lines_s", "ask99_ms"}, rows
    assert WORSE not in {verdict for _, verdict, _ in rows.values()}, rows
    show("link", "; ".join(f"{key} {found}" for key, (found, *_) in rows.items()))


@pytest.mark.slow
@pytest.mark.unmeasured
def test_lines_in_frames_over_a_bad_wire(uf2, show):
    """laser_fast: two axes, and a link that has frames. Without them the row is red."""
    board = EmulatedBoard("laser_fast")

    def measured(frames):
        link.ASKS, link.LINES = 20, 100
        if not frames:
            from host_tools.clients.frames import FramedPort

            FramedPort.begin = lambda self, wait_s: True
            FramedPort.write = lambda self, data: self._port.write(data)
            FramedPort.read = lambda self, size: self._port.read(size)
        made = Proof(board, boards.load("laser_fast"), True)
        return {row.key: (row.found, row.verdict) for row in made._part("link", link.link, False)}

    rows, bare = on_a_copy(lambda: measured(True)), on_a_copy(lambda: measured(False))
    assert {"lines_s", "ask_ms", "framed_lost"} <= set(rows) and WORSE not in {verdict for _, verdict in rows.values()}, rows
    assert bare["framed_lost"][1] == WORSE, bare
    show("lines in frames", f"{rows['framed_lost'][0]}; without frames {bare['framed_lost'][0]}")


@pytest.mark.unmeasured
def test_the_witness_sees_what_the_emulator_sees(board, show):
    """Three axes at 480 kHz: every edge, within a tick; and the steps are the same without it."""

    def measured(witnessed):
        proof = Proof(board, boards.load(BOARD), True)
        logs = [board.pico.record_edges(pin) for pin in range(2, 8)]
        if not witnessed:
            start = board.start
            board.start = lambda code: start(code.replace("witness.start()", "pass"))
        axes = [dict(axis, **pins.FAST) for axis in proof.raw["axes"]]
        changes = {"axes": axes, "drive": dict(proof.raw["drive"], pulse_us=1)}
        lines = [([pins.FAST_STEPS] * 3, pins.FAST_STEPS * 12_500_000 // pins.FAST_HZ)]
        proof.begin("make", changes, more=("board_witness.py",))
        board.exec("witness = Witness(2, 6, RECORDS)\ngc.collect()")
        for log in logs:
            log.clear()
        (_, taken, _), records = pins.run_on_board(proof, f"play({lines!r}, witness)")
        seen = pins.edges.decode_records(pins.records_printed(records[:-1]), 6) if witnessed else []
        return seen, sorted((cycle, bit, state) for bit, log in enumerate(logs) for cycle, state in log), taken

    seen, log, _taken = on_a_copy(lambda: measured(True))
    _, alone, _ = on_a_copy(lambda: measured(False))
    edges, before = [], seen[0][1]
    for cycle, levels in seen[1:]:
        edges += [(cycle, bit, levels >> bit & 1) for bit in range(6) if (levels ^ before) >> bit & 1]
        before = levels
    assert [each[1:] for each in edges] == [each[1:] for each in log] and len(edges) > 5000
    # The log's cycles are of 8 ns, the witness's of the system clock.
    ns = [(5 * ours - 5 * edges[0][0]) - 8 * (theirs - log[0][0]) for (ours, *_), (theirs, *_) in zip(edges, log)]
    assert max(ns) - min(ns) <= 8 * CYCLES_PER_TICK
    assert [(cycle - alone[0][0], bit, state) for cycle, bit, state in alone] == [(cycle - log[0][0], bit, state) for cycle, bit, state in log]
    show("the witness against the emulator's log", f"{len(edges)} edges, {max(ns) - min(ns)} ns apart; the same edges without it")


# --- boards that are wrong


def wrong_clock(board):
    board.now_s = lambda: board.pico.now_us / 1e6 * 1.02


def late_interrupt(board):
    code = """
def _busy(timer):
    end = ticks_us() + 20000
    while ticks_diff(end, ticks_us()) > 0:
        pass
_make = queue_lines
def queue_lines(lines):
    _make(lines)
    machine.Timer(mode=machine.Timer.ONE_SHOT, period=5, callback=_busy, hard=True)
"""
    on_make(board, after=code)


def swapped_pin(board):
    other = {STEP_Y: DIR_Y, DIR_Y: STEP_Y}
    pads, chip = board.pico.pads, board.pico.chip
    plain = pads._set_input
    pads._set_input = lambda pin, level: plain(chip.gpio[other.get(pin.index, pin.index)], level)


def dead_dma(board):
    kind = type(board.pico.chip.dma.channels[0])
    start = kind.start
    kind.start = lambda self: None if self.index == 0 else start(self)


def slow_flash(board):
    board.pico.flash_times.set_times(erase_us=400_000, page_us=3000)


def changed_kernel(board):
    on_make(board, after="""
import passo.steps.feeder as _feeder
_make = _feeder.make
def _changed(*rows):
    what = _make(*rows)
    port._ring.words[0] ^= 1 << 20  # the word that comes first
    return what
_feeder.make = _changed
""")


def lost_bytes(board):
    write, seen = board.write, [0]

    def lossy(data):
        seen[0] += 1
        write(data[:-1] if seen[0] % 50 == 0 and len(data) > 32 else data)

    board.write = lossy


def stuck_enable(board):
    pads, chip = board.pico.pads, board.pico.chip
    plain = pads._set_input
    pads._set_input = lambda pin, level: plain(pin, False if pin.index == ENABLE else level)


def short_pulse(board):
    on_make(board, before="BOARD['drive']['pulse_us'] = 2")


def no_setup_time(board):
    on_make(board, before="BOARD['drive']['setup_us'] = 0\nBOARD['drive']['pulse_us'] = 1")


def little_memory(board):
    on_make(board, before="_hog = bytearray(32000)")


def slow_link(board):
    write = board.write

    def late(data):
        board.wait_s(0.03 if data == b"?" else 0)
        write(data)

    board.write = late


FAULTS = {
    wrong_clock: (facts.memory, "crystal_ppm", "ppm", "the crystal is wrong"),
    late_interrupt: (pins.edges_of, "edge_ns", "ns", "steps come late or early"),
    swapped_pin: (pins.edges_of, "levels", "GPIO3 and GPIO6", "check board file and wiring"),
    dead_dma: (pins.edges_of, "edges_of", "DMA", "flash the board again"),
    slow_flash: (facts.facts, "erase_ms", "400 ms", "another flash chip"),
    changed_kernel: (digests.digests, "digests", "helices", "a kernel was changed"),
    lost_bytes: (link.link, "bytes_lost", "to the board", "another cable"),
    stuck_enable: (pins.edges_of, "edges_of", "enable (GPIO14) is on", "flash the board again"),
    short_pulse: (pins.edges_of, "pulse_ns", "wanted 3", "pulse_us of the board file"),
    no_setup_time: (pins.edges_of, "setup_ns", "wanted 5", "setup_us of the board file"),
    little_memory: (facts.memory, "free_bytes", "bytes", "something else takes memory"),
    slow_link: (link.link, "ask_ms", "ms", "a slow link"),
}


@pytest.mark.slow
@pytest.mark.unmeasured
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_a_fault_is_named(board, way, fault, show):
    part, key, found, advice = FAULTS[fault]

    def faulty(board):
        link.BYTES, link.ASKS, link.LINES = 4096, 20, 100
        fault(board)

    rows = rows_of(board, way, part, fault=faulty)
    assert rows[key][1] == WORSE and found in rows[key][0] and advice in rows[key][2], rows
    show(fault.__name__.replace("_", " "), f"{key}: {rows[key][0]}")


# --- the command, over a port


def command(board, link, answer, *words, parts=(facts.facts, pins.edges_of)):
    """Return (exit status, output) of `passo prove --port`, with some of its parts, on a copy; `answer`: the text typed, None: no terminal."""

    def done():
        proof.PARTS = tuple(row for row in PARTS if row[1] in parts)
        few_jobs("helices")
        with running(board.pico, link) as made, pytest.MonkeyPatch.context() as patch:
            patch.setattr(connection, "PortBoard", lambda name: PicoPort(made, name))
            if answer is not None:
                patch.setattr("host_tools.cli.prove.is_terminal", lambda: True)
            result = CliRunner().invoke(app, ["prove", "--port", str(link), *words], input=answer)
        if result.exception and not isinstance(result.exception, SystemExit):
            raise result.exception
        return result.exit_code, result.output

    return on_a_copy(done)


@pytest.mark.unmeasured
def test_who_ends_it_while_the_link_is_measured_gives_the_board_back(board, tmp_path):
    """The board serves its link then, and takes Ctrl-C for a byte like others."""

    def ended():
        link = tmp_path / "port"
        with running(board.pico, link) as made:
            with pytest.raises(KeyboardInterrupt), PicoPort(made, str(link)) as over:
                Proof(over, boards.load(BOARD), False).begin("make")
                over.start("serve(700)")
                over.expect(b"ready")
                over.write(b"?")
                raise KeyboardInterrupt
            made.until(board.pico.now_us + 3_000_000)
            port = os.open(link, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            os.write(port, b"?\n")
            made.until(board.pico.now_us + 500_000)
            said = os.read(port, 4096)
            os.close(port)
        return said

    said = on_a_copy(ended)
    assert b"<Alarm" in said or b"<Idle" in said, said


@pytest.mark.unmeasured
def test_nothing_moves_before_somebody_has_said_yes(board, tmp_path):
    for answer, asks, drives in (("n\n", True, False), (None, False, False), ("y\n", True, True)):
        status, said = command(board, tmp_path / "port", answer)
        assert status == 0, said
        assert ("are the drivers unplugged" in said) == asks
        assert ("no pins are driven" in said) != drives and ("STEP pulse" in said) == drives, said


@pytest.mark.slow
@pytest.mark.unmeasured
def test_the_command_over_a_port_writes_its_reports(board, tmp_path):
    files = [word for name in ("report.txt", "json.json", "picture.png") for word in ("--" + name.partition(".")[0], str(tmp_path / name))]
    status, said = command(board, tmp_path / "port", None, "--yes-drivers", *files, parts=tuple(row[1] for row in PARTS))
    assert status == 0 and ", 0 worse" in said, said
    rows = json.loads((tmp_path / "json.json").read_text())["rows"]
    assert len(rows) >= 25 and all(row["found"] for row in rows)
    report = (tmp_path / "report.txt").read_text()
    assert all(row["what"].split()[0] in report for row in rows) and f"on {tmp_path / 'port'}" in report.replace("\n", "")
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.unmeasured
def test_a_cable_that_is_pulled_ends_the_proof_in_a_sentence(board, tmp_path):
    def measured():
        connection._PRESS_S = 0.5
        with on_a_port(board.pico, tmp_path / "port") as over:
            made = Proof(over, boards.load(BOARD), True)
            rows = []
            for _title, part in made.parts():
                rows += part
                over.running.plugged = False
            return [(row.key, row.found, row.verdict) for row in rows]

    rows = on_a_copy(measured)
    (where,) = (number for number, row in enumerate(rows) if row[2] == WORSE)
    assert where > 5 and "no MicroPython board answers" in rows[where][1]
    assert [row[1:] for row in rows[where + 1 :]] == [("the board is silent", LEFT_OUT)] * 6


def test_a_port_that_is_none():
    result = CliRunner().invoke(app, ["prove", "--port", "/dev/no_such_port"])
    assert isinstance(result.exception, Failure) and "there is no port /dev/no_such_port" in str(result.exception)
    result = CliRunner().invoke(app, ["prove"])
    assert isinstance(result.exception, Failure) and "--emulated BOARD" in str(result.exception)
