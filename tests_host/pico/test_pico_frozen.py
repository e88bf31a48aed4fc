"""Passo's UF2 on the emulated Pico: memory and time of a start, digests, and images that are not whole.

`make uf2 CHIP=rp2040` builds it; without one of this source these tests skip, and say so.
"""

import sys

import pytest
from emulated import uf2  # noqa: F401
from host_tools.prove.gcode_jobs import all_jobs
from test_pico_flash import safe_us
from test_digest import CHECKS, HEX_JOBS, golden_of_gcode, golden_of_hex, hex_job

from host_tools import boards
from host_tools.build.frozen import compile_beside, stamp
from host_tools.emulator import gcode
from host_tools.emulator.binary import Unavailable
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.frozen import Started, boot_for_lines, find_frozen, frozen_machine
from host_tools.emulator.heap import Heap
from host_tools.emulator.pico import EmulatedPico
from host_tools.uf2_format import BLOCK_BYTES, FLASH, PAGE

LIMIT_US = 30_000_000
ALL = {"journal": {"every_ms": 500}, "jobs": {"language": "grbl"}}
PLOTTER = b"r\0\0\0\0r", b"k"
QUESTION = b"?", b"<"


@pytest.fixture(scope="session")
def frozen(uf2):
    """The UF2. The test skips, loudly, where there is none."""
    try:
        return find_frozen("rp2040")
    except Unavailable as reason:
        print(f"\nNOT TESTED WITH PASSO'S UF2: {reason}", file=sys.__stderr__)
        pytest.skip(f"NOT TESTED WITH PASSO'S UF2: {reason}")


def with_all(name):
    """A board file with stored jobs, journal, and frames on each link."""
    board = boards.load(name)
    board.update(ALL, links=[dict(link, frames=True) for link in board["links"]])
    return board


def started_again(started, question, answer):
    """(ms from the reset button to the first answer, the heap then): the first start of all erases the journal's blocks."""
    machine = started.machine
    begun = machine.now_ms()
    machine.pico.press_reset()
    machine.run_ms(1)
    link = next(iter(machine.uart_links()), None)
    machine.take(link)
    while answer not in machine.take(link):
        assert machine.now_ms() < begun + 5000
        machine.send(question, link)
        machine.run_ms(10)
    return machine.now_ms() - begun, Heap(machine.pico, True)


@pytest.mark.parametrize("board, free, largest, limit_ms", [
    ("router_3axis", 105_000, 64_000, 600),
    pytest.param("mill_2004", 80_000, 64_000, 1050, marks=pytest.mark.slow),
    pytest.param("laser_xy", 105_000, 64_000, 610, marks=pytest.mark.slow),
])  # fmt: skip
def test_room_and_time_with_everything(frozen, board, free, largest, limit_ms, show):
    started = Started(with_all(board), frozen, *QUESTION)
    assert started.answered_ms, started.said
    took_ms, heap = started_again(started, *QUESTION)
    show(f"{board} with everything, frozen", f"{heap.free} bytes free, {heap.largest} in one piece, first answer after {took_ms:.0f} ms")
    assert f"code in the UF2, build {stamp('rp2040')}" in started.said or started.machine.board["links"][0]["port"] == "usb"
    assert heap.free >= free and heap.largest >= largest and took_ms <= limit_ms
    assert b"passo.control." not in bytes(started.machine.pico.chip.sram)  # names of modules are in flash


def test_outputs_are_safe_at_once(frozen, show):
    took_us = safe_us(frozen_machine("router_3axis", frozen, trace=None), boards.load("router_3axis"))
    show("safe outputs, frozen", f"{took_us / 1000:.0f} ms after power")
    assert took_us <= 100_000


@pytest.mark.slow
@pytest.mark.parametrize("board", [name for name in boards.names() if boards.load(name)["chip"] == "rp2040" and not boards.load(name).get("network")])
def test_every_machine_starts(frozen, board, show):
    machine = frozen_machine(board, frozen, trace=None).boot()
    machine.run_ms(2500)
    said = bytes(machine.pico.console.text).decode(errors="replace")
    heap = Heap(machine.pico, True)
    assert "Traceback" not in said and "board.py" not in said and "memory" not in said, said
    show(f"{board}, frozen", f"{heap.free} bytes free, {heap.largest} in one piece")
    assert heap.free >= 80_000


# --- digests


def digest_files(**files):
    texts = {"digest.py": (CHECKS / "digest.py").read_text()}
    named = {f"boards/{name}.py": boards.board_py(name) for name in boards.names()}
    return {**compile_beside("rp2040", texts), "boards/__init__.py": b"", **named, **files}


def test_words_of_gcode(frozen, show):
    board, lines = all_jobs()["pico"]
    files = digest_files(**{"job.gcode": "".join(f"{line}\n" for line in lines).encode()})
    pico = EmulatedPico(files=files, uf2=frozen).boot()
    said = pico.exec(f"import digest\ndigest.show_lines('job.gcode', {board!r}, counts=False)", limit_us=LIMIT_US).split()
    golden = golden_of_gcode()["pico"]
    assert [*said[:2], *said[3:]] == [*golden[:2], *golden[3:]]
    show("digest of G-code, frozen", f"{said[1]} words")


@pytest.mark.parametrize("name", ["keys"])
def test_words_of_other_languages(frozen, name):
    files = digest_files(**{"job.hex": hex_job(name).encode()})
    pico = EmulatedPico(files=files, uf2=frozen).boot()
    said = pico.exec(f"import digest\ndigest.main(['job.hex', {HEX_JOBS[name][1]!r}])", limit_us=LIMIT_US).split()
    assert said == golden_of_hex()[name]


# --- lines


@pytest.mark.slow
def test_lines_dots_and_answers(frozen, show):
    board, texts = gcode.fast_board((0.2,))
    machine = boot_for_lines(board, frozen, texts)
    run = on_a_copy(lambda: gcode.run_lines(machine, 0.2, 245, 200))
    gcode.talk_to(machine)
    steps, holds = on_a_copy(lambda: (gcode.time_first_steps(machine, 3), gcode.time_holds(machine, 3)))
    board, texts = gcode.fast_board((0.1,), laser=True)
    laser = boot_for_lines(board, frozen, texts)
    dots = on_a_copy(lambda: gcode.run_raster(laser, 0.1, 200, 200))
    show("lines, frozen", f"{run['lines_s']:.0f} lines/s, {dots['lines_s']:.0f} dots/s, first step {max(steps):.1f} ms, hold {max(holds):.1f} ms")
    assert run["late"] == dots["late"] == 0 and max(steps) <= 20 and max(holds) <= 20


# --- images that are not whole


def torn(frozen, whole_blocks, spoil=()):
    """A machine whose flash has the first blocks of the UF2, and nothing else; `spoil`: bytes of the flash with another bit."""
    machine = frozen_machine("plotter_2014", frozen, trace=None)
    flash, data = machine.pico.chip.flash, frozen.read_bytes()
    files = bytes(machine.pico.image())
    flash[: len(flash)] = b"\xff" * len(flash)
    start = machine.pico._files_at
    flash[start : start + len(files)] = files
    for at in range(0, whole_blocks * BLOCK_BYTES, BLOCK_BYTES):
        address = int.from_bytes(data[at + 12 : at + 16], "little") - FLASH
        flash[address : address + PAGE] = data[at + 32 : at + 32 + PAGE]
    for at in spoil:
        flash[at] ^= 1
    return machine


def outcome(machine, limit_ms=700):
    """Return the text up to `limit_ms`, or the fault that ended it."""
    try:
        machine.pico.boot(limit_ms * 1000)
        machine.run_ms(limit_ms - machine.now_ms())
    except Exception as fault:  # code that is not there
        return f"fault: {type(fault).__name__}"
    return bytes(machine.pico.console.text).decode(errors="replace")


def test_a_torn_image_is_not_run(frozen):
    """Without its last blocks it does not come up, or it says what is wrong: the last one says what the others come to."""
    blocks = len(frozen.read_bytes()) // BLOCK_BYTES
    for missing in (20, 2, 1):
        machine = torn(frozen, blocks - missing)
        said = outcome(machine, 250)
        assert not machine.wiring.edge_count and not machine.is_listening() and "code in the UF2" not in said, (missing, said)
    assert "the UF2 here is not whole" in said


@pytest.mark.slow
def test_cut_anywhere_it_starts_no_motion(frozen):
    blocks = len(frozen.read_bytes()) // BLOCK_BYTES
    for there in range(1, blocks, 97):
        machine = torn(frozen, there)
        said = outcome(machine, 250)
        assert not machine.wiring.edge_count and not machine.is_listening() and "code in the UF2" not in said, (there, said)


def test_a_bit_that_has_changed_is_found(frozen):
    machine = torn(frozen, len(frozen.read_bytes()) // BLOCK_BYTES, [600_000])
    said = outcome(machine)
    assert "the UF2 here is not whole" in said and not machine.wiring.edge_count


# --- packages on the file system


@pytest.mark.parametrize("marked", [False, True])
def test_a_package_on_the_file_system(frozen, marked):
    """It is not run, and a message names its build; unless `passo flash --source` has laid it there."""
    late = b"import time\ntime.sleep_ms(200)\nprint('of the file system')\n"  # when somebody listens
    files = {"passo/__init__.py": late, "passo/stamp.txt": b"0123456789ab\n", "stamp.txt": b"0123456789ab\n"}
    if marked:
        files["source.txt"] = b"0123456789ab\n"
    machine = frozen_machine("plotter_2014", frozen, files, trace=None)
    said = outcome(machine)
    assert ("of the file system" in said) == marked
    assert ("the package in /passo, build 0123456789ab, is not run" in said) == ("code in the UF2" in said) == (not marked)


def test_a_board_file_that_cannot_be_read(frozen):
    said = outcome(frozen_machine("plotter_2014", frozen, {"board.py": b"BOARD = {"}, trace=None))
    assert "board.py cannot be read" in said and "code in the UF2" not in said
