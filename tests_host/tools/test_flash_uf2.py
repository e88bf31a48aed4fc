"""`passo flash` and UF2s: the board's own build decides which files go over, and another UF2 keeps the board's files."""

import re
import struct
from functools import partial
from pathlib import Path

import pytest
from test_flash import board, folder, put, run_flash, small_firmware, wait_for  # noqa: F401

from host_tools import boards
from host_tools.build.frozen import CHIPS, MARK, stamp
from host_tools.build.uf2 import mend_frozen_code, label_of, uf2_of
from host_tools.cli import flash_uf2
from host_tools.emulator.filesystem import location_of
from host_tools.failure import Failure
from host_tools.uf2_format import BLOCK_BYTES, FAMILIES, FLASH, PAGE, blocks_of, is_whole
from passo.config.boardfile import check

IMAGE = "STAMP, CHIP, VERSION = '%s', 'rp2040', '0.1'\n"
KEPT = {"settings.0": "speeds", "jobs/PART.NC": "G1", "wifi.json": "{}"}


@pytest.fixture
def with_uf2(board):
    """A board that has the UF2 of this source."""
    port, files = board
    put(files, "passo_image.py", IMAGE % stamp("rp2040"))
    return port, files


def test_only_the_board_file_goes_over(folder, with_uf2):
    port, files = with_uf2
    for name in ("passo/app.mpy", "passo/stamp.txt", "stamp.txt", "source.txt", "main.py", *KEPT):
        put(files, name, KEPT.get(name, "old"))
    result = run_flash("--port", port)
    assert result.exit_code == 0, (result.output, result.exception)
    assert not (folder / "build").exists() and "not of this source" not in result.output
    assert (files / "board.py").read_bytes() == boards.board_py("plotter_2014")
    assert not (files / "passo").exists() and not (files / "source.txt").exists() and not (files / "main.py").exists()
    assert {name: (files / name).read_text() for name in KEPT} == KEPT
    assert wait_for(files / ".reset")


def test_another_build_is_told(folder, board):
    port, files = board
    put(files, "passo_image.py", IMAGE % "0123456789ab")
    result = run_flash("--port", port)
    assert result.exit_code == 0 and "build 0123456789ab of Passo 0.1, and not of this source: make uf2 CHIP=rp2040" in result.output


def test_modules_go_over_if_they_are_asked_for(folder, with_uf2, small_firmware):
    port, files = with_uf2
    assert run_flash("--port", port, "--source").exit_code == 0
    assert (files / "passo/__init__.mpy").is_file()
    assert (files / "source.txt").read_text() == (files / "stamp.txt").read_text() == (files / "passo/stamp.txt").read_text()


@pytest.mark.parametrize("chip, board, fits", [
    ("rp2040", "plotter_2014", True), ("rp2040_w", "plotter_2014", True), ("rp2040_w", "torch_pico_w", True),
    ("rp2040", "torch_pico_w", False), ("rp2350", "plotter_2014", False), ("rp2040", "plotter_esp32", False), ("other", "plotter_2014", False),
])  # fmt: skip
def test_a_uf2_of_another_chip_is_refused(chip, board, fits):
    has = flash_uf2.Has(chip, "", "", 0, [])
    if fits:
        flash_uf2.check_fits(has, check(boards.load(board)), board)
    else:
        with pytest.raises(Failure, match=f"the board has Passo's UF2 for the {chip}, and {board} wants that"):
            flash_uf2.check_fits(has, check(boards.load(board)), board)


@pytest.mark.parametrize("said", ["", "circuitpython 9.1.0\n-1\nboot.py\n", "Traceback\n"])
def test_something_else_is_one_sentence(said):
    with pytest.raises(Failure, match="runs .*, and no MicroPython"):
        flash_uf2.parse_answer(said, "/dev/ttyACM0")


# --- the file


def image(size=1000):
    return bytes(number * 7 & 0xFF for number in range(size))


def test_a_uf2_holds_the_image_and_what_it_comes_to():
    chip = CHIPS["rp2040"]
    data = uf2_of(chip, image())
    assert is_whole(data) and data == uf2_of(chip, image())
    pages = {}
    for at in range(0, len(data), BLOCK_BYTES):
        address, size = struct.unpack_from("<2I", data, at + 12)
        assert size == PAGE and struct.unpack_from("<I", data, at + 28)[0] == FAMILIES["rp2040"]
        pages[address] = data[at + 32 : at + 32 + PAGE]
    record = pages.pop(FLASH + chip.flash - chip.storage - PAGE)
    whole = b"".join(pages[FLASH + at] for at in range(0, len(pages) * PAGE, PAGE))
    total = 0
    for word in struct.unpack(f"<{len(whole) // 4}I", whole):
        total = (total * 31 + word) & 0x3FFFFFFF
    assert struct.unpack_from("<4I", record) == (MARK, FLASH, len(whole) // 4, total) and whole.startswith(image())


def test_an_image_that_is_too_large_is_refused():
    with pytest.raises(Failure, match="there is room for 1048320 before the file system"):
        uf2_of(CHIPS["rp2040"], bytes((1 << 20) - 255))


def test_a_cut_file_is_not_whole(tmp_path):
    data = uf2_of(CHIPS["rp2040"], image())
    for size in (0, 1, BLOCK_BYTES - 1, BLOCK_BYTES, len(data) - BLOCK_BYTES, len(data) - 1):
        (tmp_path / "cut.uf2").write_bytes(data[:size])
        with pytest.raises(Failure, match="is no whole UF2"):
            flash_uf2.check_file(tmp_path / "cut.uf2")


def test_a_file_tells_its_chip_and_build(tmp_path):
    path = tmp_path / "passo.uf2"
    path.write_bytes(uf2_of(CHIPS["rp2040"], image()))
    assert label_of(path) == ("rp2040", stamp("rp2040"))
    path.write_bytes(blocks_of([(FLASH, bytes(PAGE))], FAMILIES["rp2040"]))
    assert label_of(path) is None and is_whole(path.read_bytes())


def test_what_mpy_tool_writes_is_mended():
    section = b'__attribute__((section(".text,\\"ax\\",%progbits @ "))) __attribute__ ((aligned (2)))'
    function = b"// frozen native code for file passo/%b.py, scope passo_%b\nstatic const byte fun_data_x[4] "
    text = b"head\n"
    for name in ((b"a", b"app_App_poll"), (b"b", b"steps_feeder_Feeder_fill")):
        text += function % name + section + b" = {\n"
    assert mend_frozen_code(1, b"wrong") == (1, b"wrong")
    status, made = mend_frozen_code(0, text)
    assert status == 0 and made.count(b"aligned (4)") == 2 and b"aligned (2)" not in made
    assert made.count(b"time_critical") == 1 and made.index(b"time_critical") > made.index(b"Feeder_fill")
    assert made.count(b'(".text.fun_data_x,') == 1, "a section of its own"
    with pytest.raises(Failure, match="no such functions"):
        mend_frozen_code(0, b"head\n" + function % (b"a", b"app_App_poll") + section)


# --- the boot loader


@pytest.fixture
def drive(tmp_path, board, monkeypatch):
    """The boot loader's drive: there from the board's call on, gone once a UF2 has been copied to it."""
    place = tmp_path / "RPI-RP2"
    place.mkdir()
    (place / flash_uf2.INFO).write_text("UF2 Bootloader v3.0\n")
    there = board[1] / ".bootloader"
    monkeypatch.setattr(flash_uf2, "find_drive", lambda: place if there.exists() and not list(place.glob("*.uf2")) else None)
    for name in ("DRIVE_S", "START_S"):
        monkeypatch.setattr(flash_uf2, name, 20)
    return place


@pytest.fixture
def new_uf2(tmp_path):
    path = tmp_path / "new.uf2"
    path.write_bytes(uf2_of(CHIPS["rp2040"], image()))
    return path


def test_another_uf2_keeps_the_files(folder, with_uf2, drive, new_uf2):
    """The file system begins at another address, which the board reports: flash reads the files and puts them back."""
    port, files = with_uf2
    for name, text in KEPT.items():
        put(files, name, text)
    result = run_flash("--port", port, "--uf2", str(new_uf2))
    assert result.exit_code == 0, (result.output, result.exception)
    assert (drive / "new.uf2").read_bytes() == new_uf2.read_bytes()
    assert f"holds Passo's build {stamp('rp2040')} for the rp2040" in result.output and "are kept in" in result.output
    assert {name: (files / name).read_text() for name in KEPT} == KEPT
    assert (files / "board.py").is_file(), "and goes on with the board file"


def test_without_a_drive_it_says_what_to_do(folder, with_uf2, new_uf2, monkeypatch):
    monkeypatch.setattr(flash_uf2, "find_drive", lambda: None)
    monkeypatch.setattr(flash_uf2, "DRIVE_S", 0.5)
    put(with_uf2[1], "settings.0", "speeds")
    result = run_flash("--port", with_uf2[0], "--uf2", str(new_uf2))
    kept = re.search(r"the board's files are in (\S+);", result.output)
    assert kept and (Path(kept[1]) / "settings.0").read_text() == "speeds"
    assert isinstance(result.exception, Failure) and "hold BOOTSEL while you plug it in, then: passo flash --uf2" in str(result.exception)


def test_files_stay_where_the_file_system_stays(tmp_path, new_uf2):
    stays = flash_uf2.Has("rp2040", "", "", location_of(new_uf2)[0], ["settings.0"])
    assert flash_uf2.save_files("nowhere", new_uf2, stays) is None


def test_drives_are_found_by_what_is_on_them(tmp_path, monkeypatch):
    monkeypatch.setattr(flash_uf2, "Path", partial(_below, tmp_path))
    assert flash_uf2.find_drive() is None
    put(tmp_path, "media/somebody/RPI-RP2/INFO_UF2.TXT")
    monkeypatch.setenv("USER", "somebody")
    assert flash_uf2.find_drive() == tmp_path / "media/somebody/RPI-RP2"


def _below(root, path):
    return root / path.lstrip("/")
