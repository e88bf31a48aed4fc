"""The memory of the chip that each ESP32 board file needs, counted as it starts on a 32-bit MicroPython with the chip's heap in its pieces: as files,
and frozen by the manifest that freezes it into an ESP32's image. `passo build` refuses by these figures (host_tools/build/budget.py).

MICROPYTHON names MicroPython's sources, of which the qemu port is built; without them, or without qemu and a compiler for RV32, these tests
skip and say so. Not run on an ESP32.
"""

import shutil

import pytest
from esp32_core import Esp32
from host_tools.prove.gcode_jobs import all_jobs

from host_tools import boards
from host_tools.build.budget import ESP32_KB, esp32_needs
from host_tools.emulator.binary import Unavailable
from passo.config.boardfile import check
from test_digest import CHECKS, HEX_JOBS, golden_of_gcode, golden_of_hex, hex_job

pytestmark = [pytest.mark.slow, pytest.mark.unmeasured, pytest.mark.xdist_group("qemu")]
# Beside the first heap of 56 kB: the largest piece of the plain ESP32, two smaller ones, and a piece for machine code only.
PIECES = 112_000, 24_500, 15_000, 10_800
I2S, OF_TIMERS, RADIO = 17_000, 2_000, 40_000
SLACK_KB = 4  # between what was counted when the table was made and now
LEAST = 20_000  # bytes that have to be left, as on a Pico
NETWORK = {"network": {"host": "passo"}}


def torch():
    board = boards.load("torch_pico_w")
    for axis, pins in zip(board["axes"], ([16, 17], [18, 19])):
        axis.update(pins=pins, max_mm_min=3000)
    for output, pin in zip(board["outputs"], (22, 23, 25)):
        output["pin"] = pin
    board["links"][0].update(port="uart2", tx=27, rx=14)
    return {**board, "chip": "esp32", "tool": {"pin": 21}, "speed": {**board["speed"], "max": 5000},
            "inputs": [{"name": "admit", "pin": 32, "active": 0, "pull": "up"}]}  # fmt: skip


def plain(name):
    """A machine on a module without PSRAM: with it the heap is elsewhere, and the I2S has 33 kB."""
    return {**boards.load(name), "psram": False}


def networked(name, port, protocol):
    board = plain(name)
    return {**board, **NETWORK, "links": [*board["links"], {"name": "other", "port": port, "protocol": protocol}]}


MACHINES = {
    "plotter_esp32": plain("plotter_esp32"), "router_esp32": plain("router_esp32"), "mks_dlc32": plain("mks_dlc32"),
    "plotter with page": networked("plotter_esp32", "page", "plotter"), "torch with Wi-Fi": torch(),
    "router by TCP": networked("router_esp32", "tcp", "grbl"), "router with page": networked("router_esp32", "page", "grbl"),
}  # fmt: skip


@pytest.fixture(scope="module", params=[False, True], ids=["files", "frozen"])
def core(request):
    if shutil.which("qemu-system-riscv32") is None:
        pytest.skip("NOT TESTED: there is no qemu-system-riscv32")
    try:
        return Esp32(request.param)
    except Unavailable as reason:
        pytest.skip(f"NOT TESTED: {reason}")


def drivers(board):
    return I2S if board.get("shift") else OF_TIMERS, RADIO if board.get("network") else 0


@pytest.mark.parametrize("name", MACHINES)
def test_what_it_wants(core, name, tmp_path, show):
    board = MACHINES[name]
    counted = core.started(board, tmp_path)
    assert counted.error is None
    wanted = (counted.peak + counted.code + sum(drivers(board))) / 1000
    show(
        f"{name} on an ESP32, {'frozen' if core.frozen else 'files'}",
        f"heap {counted.steady / 1000:.0f} kB, {counted.peak / 1000:.0f} at its peak; machine code {counted.code / 1000:.0f}; with drivers {wanted:.0f}",
    )
    assert abs(wanted - esp32_needs(check(board))[core.frozen]) <= SLACK_KB


@pytest.mark.parametrize("name", MACHINES)
def test_it_starts_in_pieces_if_it_fits(core, name, tmp_path):
    """The radio's memory is taken before anything is imported, and so is the rest. A refused board does not start, or with less than LEAST left."""
    board = MACHINES[name]
    fits = esp32_needs(check(board))[core.frozen] <= ESP32_KB["esp32"][core.frozen]
    counted = core.started(board, tmp_path, PIECES, drivers(board))
    starts = counted.error is None and counted.left >= LEAST
    assert starts == fits, counted


@pytest.fixture
def digest_files():
    named = {f"boards/{name}.py": boards.board_py(name) for name in boards.names()}
    return {"digest.py": (CHECKS / "digest.py").read_text(), "boards/__init__.py": b"", **named}


@pytest.mark.parametrize("name", ["keys", "torch"])
def test_words_of_other_languages(core, name, digest_files, tmp_path):
    """Frozen modules make the words of every other interpreter."""
    if core.frozen:
        files = {**digest_files, "job.hex": hex_job(name).encode()}
        said = core.printed(f"import digest\ndigest.main({['/rom/job.hex', *HEX_JOBS[name][1:]]!r})", files, tmp_path)
        assert said.split() == golden_of_hex()[name]


def test_words_of_gcode(core, digest_files, tmp_path):
    if core.frozen:
        board, lines = all_jobs()["pico"]
        files = {**digest_files, "job.gcode": "".join(f"{line}\n" for line in lines).encode()}
        said = core.printed(f"import digest\ndigest.main(['/rom/job.gcode', {board!r}])", files, tmp_path)
        assert said.split() == golden_of_gcode()["pico"]
