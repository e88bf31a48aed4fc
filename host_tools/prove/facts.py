"""Rows of `passo prove` about the board: chip, clocks, flash, memory and watchdog. Functions of a Proof that yield rows."""

import statistics

from host_tools.failure import Failure
from host_tools.language import _
from host_tools.prove.promises import KEPT, MEMORY, PROMISES
from host_tools.prove.row import Row, equality_row, number_text, program_text

READINGS = 9
LEAST_MV = 800  # of the RP2040's regulator, levels 0 to 5; 50 more with each further


def facts(proof):
    """Yield rows about chip, flash, interpreter, unique number and build, and the times of erasing and programming in ms."""
    board = proof.board
    board.restart_interpreter()
    said = {}
    for line in board.exec(program_text("board_facts.py")).splitlines():
        name, _space, rest = line.partition(" ")
        said[name] = rest
    proof.frozen = "uf2" in said
    chip = f"{said['chip']}, B{said['revision']}"
    interpreter = _("Passo's UF2 {}", said["uf2"]) if proof.frozen else said["interpreter"]
    yield Row("chip", _("chip"), chip, figures={"chip": chip, "id": said["id"]})
    yield Row("flash", _("flash"), f"{int(said['flash']) // 1024} kB", figures={"flash_bytes": int(said["flash"])})
    yield Row("interpreter", _("interpreter"), interpreter)
    yield Row("id", _("unique number"), said["id"])
    yield equality_row("stamp", _("build"), said["stamp"] or _("not whole"), bool(said["stamp"]), _("copying was cut short, or it is of two builds: flash it again"))
    erases, pages = ([int(each) / 1000 for each in said[name].split()] for name in ("erases", "pages"))
    if erases and pages:
        yield proof.judge("erase_ms", statistics.median(erases), found=_("{} ms, at most {}", number_text(statistics.median(erases)), number_text(max(erases))))
        yield proof.judge("page_ms", statistics.median(pages), found=_("{} ms, at most {}", number_text(statistics.median(pages)), number_text(max(pages))))


def memory(proof):
    """Yield rows about clock (kHz), core voltage (mV), crystal, collection time (ms) and free memory (bytes) with the app loaded."""
    board = proof.board
    board.restart_interpreter()
    board.exec(program_text("board_session.py"))
    board.exec("make({'journal': None}, ['inputs', 'homing', 'outputs'])")
    said = board.exec(
        "from passo.ports.rp2 import clock\nprint(machine.freq(), clock.measure_khz())\nfrom time import ticks_us\nprint(*time_collection())"
    )
    (freq, counted), (took_us, free, piece) = (map(int, line.split()) for line in said.splitlines())
    wanted = proof.raw.get("clock_mhz", 125) * 1000
    off = max(abs(freq // 1000 - wanted), abs(counted - wanted))
    yield proof.judge("clock_khz", off, found=_("{} kHz counted, {} kHz said", counted, freq // 1000))
    if proof.raw["chip"] == "rp2040":
        level = int(board.exec("from passo.ports.rp2 import chip\nprint(machine.mem32[chip.REGULATOR] >> 4 & 15)"))
        yield proof.judge("core_mv", LEAST_MV + 50 * max(0, level - 5), 1150 if wanted > 133_000 else 1100)
    yield judge_crystal(proof)
    yield proof.judge("collect_ms", took_us / 1000)
    known = MEMORY.get(proof.raw.get("name"))
    if known is None:
        yield Row("free_bytes", _(PROMISES["free_bytes"].what), _("{} bytes, {} in one piece", number_text(free), number_text(piece)))
        return
    free_known, piece_known = known[proof.frozen]
    yield proof.judge("free_bytes", free, free_known)
    yield proof.judge("piece_bytes", piece, piece_known)


def judge_crystal(proof):
    """Compare the chip's microseconds with the PC's, over two seconds: of several readings the one that came back first, because a busy PC, and not
    the chip, makes the others late. Returns a Row."""
    board = proof.board
    board.start("import sys\nwhile sys.stdin.read(1) == 't': print(ticks_us())")

    def read_clocks():
        """Return (seconds that the question took, the PC's time in its middle, the board's answer)."""
        before = board.now_s()
        board.write(b"t")
        said = int(board.expect(b"\n"))
        after = board.now_s()
        return after - before, (before + after) / 2, said

    def best_reading():
        return min(read_clocks() for _again in range(READINGS))[1:]

    first_s, first = best_reading()
    board.wait_s(2)
    second_s, second = best_reading()
    board.write(b"e")
    board.wait_for_end()
    ticks = (second - first) % (1 << 30)
    return proof.judge("crystal_ppm", abs(ticks / 1e6 / (second_s - first_s) - 1) * 1e6)


def watchdog(proof):
    """Yield a row: the time in ms from an endless loop until the board is back. Raises Failure without a reset within 12 s, or with another cause of
    it."""
    board = proof.board
    board.restart_interpreter()
    begun = board.now_s()
    board.start("import machine, micropython\nfrom time import sleep_ms\nsleep_ms(50)\nmicropython.kbd_intr(-1)\nmachine.WDT(timeout=1000)\nwhile True: pass")
    try:
        board.await_reset(12)
    except TimeoutError:
        raise Failure("the watchdog did not bite within 12 s: a program that hangs is not ended") from None
    took = (board.now_s() - begun) * 1000
    board.restart_interpreter()
    cause = board.exec("import machine\nprint(machine.reset_cause() == machine.WDT_RESET)").strip()
    if cause != "True":
        raise Failure("the board did reset, but not by its watchdog")
    yield Row("watchdog_ms", _(PROMISES["watchdog_ms"].what), _("bites: the board was back after {} ms", number_text(took)), verdict=KEPT, figures={"watchdog_ms": took})
