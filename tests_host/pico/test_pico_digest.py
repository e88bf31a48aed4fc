"""The step words of a job made on the emulated Pico: the same digest as under CPython, with the heap to spare."""

import tempfile
from pathlib import Path

import pytest
from emulated import uf2  # noqa: F401

from host_tools import boards
from host_tools.build import mpy
from host_tools.build.constants import fold_both_ways, shorten_names
from host_tools.build.tree import COLD, compile_module, select_modules
from host_tools.drawings import objects
from host_tools.emulator.pico import EmulatedPico
from host_tools.kernels import build as kernels
from host_tools.kernels import module
from host_tools.kernels.inline import inline_kernels
from host_tools.prove.gcode_jobs import MACHINES, all_jobs
import every_number
from digest import board_named
from test_digest import CHECKS, GOLDEN, HEX_JOBS, ROOT, golden_of_gcode, golden_of_hex, hex_job, job_of

LIMIT_US = 30_000_000
# A router has no memory for its code.
IN_FLASH = "from passo.ports.rp2.stock import flash_code\nflash_code.begin()\n"


def compiled(sources, board="router_3axis"):
    """{path.mpy: bytes} of {path: source file}, compiled for the RP2040 as `passo build` does it."""
    texts = {path: source.read_text() for path, source in sources.items()}
    made = kernels.compile_kernels(*fold_both_ways(texts), boards.load(board), "armv6m", COLD)
    files = {path: mpy.in_place(data) for path, data in made.modules.items()}
    with tempfile.TemporaryDirectory() as folder:
        for path, text in inline_kernels(shorten_names(made.texts)).items():
            source, target = Path(folder) / "module.py", Path(folder) / "module.mpy"
            source.write_text(text)
            compile_module(source, target, "armv6m", Path(path).with_suffix(".mpy"))
            files[str(Path(path).with_suffix(".mpy"))] = mpy.in_place(target.read_bytes(), path in COLD)
    return files


def with_digest(board, job, data, *more, changes=None):
    """The files of digest.py, of the firmware that `board` with its `changes` needs, of one job, and of more programs of the checks."""
    sources = {path.as_posix(): ROOT / "firmware" / path for path in select_modules({**boards.load(board), **(changes or {})})}
    files = compiled({**sources, **{name: CHECKS / name for name in ("digest.py", *more)}}, board)
    files["boards/__init__.py"] = b""
    files[f"boards/{board}.py"] = boards.board_py(board)
    files[job] = data
    return files


@pytest.mark.slow
@pytest.mark.parametrize("name", ["triangle"])
def test_the_pico_makes_the_words_of_the_golden_file(uf2, name, show):
    files = with_digest("plotter_2014", "job.bin", job_of([objects.objects()[name]]))
    pico = EmulatedPico(files=files, uf2=uf2).boot()
    before = pico.cycle
    # Collecting often while the modules load keeps the heap in one piece: the store wants 50 000 bytes of it.
    code = "import gc\ngc.threshold(16000)\nimport digest\ndigest.main(['job.bin'])"
    said = pico.exec(code, limit_us=LIMIT_US).split()
    golden = dict(line.split(" ", 1) for line in GOLDEN.read_text().splitlines())
    assert " ".join(said) == golden[name]
    show(f"digest of {name} on the Pico", f"{said[1]} words in {(pico.cycle - before) / 125e6:.2f} emulated s")


@pytest.mark.parametrize("by", [pytest.param("viper", marks=pytest.mark.slow), "gcc", pytest.param("zig", marks=pytest.mark.slow)])
def test_the_pico_makes_the_words_of_gcode(uf2, by, show, monkeypatch):
    """The beginnings of a relief, an engraving, a helix and a laser's raster: generated, not played."""
    monkeypatch.setenv("PASSO_KERNELS", by)
    if by != "viper" and module.find_compiler("armv6m") is None:
        pytest.skip(f"no {by} for kernels")
    board, lines = all_jobs()["pico"]
    job = "".join(f"{line}\n" for line in lines).encode()
    files = with_digest(board.partition("+")[0], "job.gcode", job, changes={"spindle": board_named(board)["spindle"]})
    pico = EmulatedPico(files=files, uf2=uf2).boot()
    before = pico.cycle
    code = "import gc\ngc.threshold(16000)\n" + IN_FLASH + "import digest\n"
    said = pico.exec(code + f"digest.show_lines('job.gcode', {board!r}, counts=False)", limit_us=LIMIT_US).split()
    show(f"digest of G-code on the Pico, {by}", f"{said[1]} words in {(pico.cycle - before) / 125e6:.2f} emulated s")
    golden = golden_of_gcode()["pico"]
    assert [*said[:2], *said[3:]] == [*golden[:2], *golden[3:]]


@pytest.mark.parametrize("name", MACHINES)
def test_the_pico_makes_the_words_of_other_machines(uf2, name, show):
    """Four axes of which one turns, two motors on one belt, axes with lost motion."""
    board, lines = all_jobs()[name]
    pico = EmulatedPico(files=with_digest(board, "job.gcode", "".join(f"{line}\n" for line in lines).encode()), uf2=uf2).boot()
    before = pico.cycle
    code = "import gc\ngc.threshold(16000)\n" + IN_FLASH + f"import digest\ndigest.show_lines('job.gcode', {board!r}, counts=False)"
    said = pico.exec(code, limit_us=LIMIT_US).split()
    show(f"digest of {name} on the Pico", f"{said[1]} words in {(pico.cycle - before) / 125e6:.2f} emulated s")
    golden = golden_of_gcode()[name]
    assert [*said[:2], *said[3:]] == [*golden[:2], *golden[3:]]


@pytest.mark.parametrize("name", ["keys"])
def test_the_pico_makes_the_words_of_other_languages(uf2, name, show):
    _, board = HEX_JOBS[name]
    pico = EmulatedPico(files=with_digest(board, "job.hex", hex_job(name).encode()), uf2=uf2).boot()
    before = pico.cycle
    code = "import gc\ngc.threshold(16000)\nimport digest\n"
    said = pico.exec(code + f"digest.main(['job.hex', {board!r}])", limit_us=LIMIT_US).split()
    show(f"digest of {name} on the Pico", f"{said[1]} words in {(pico.cycle - before) / 125e6:.2f} emulated s")
    assert said == golden_of_hex()[name]


@pytest.mark.slow
@pytest.mark.parametrize(
    "language, step",
    [("keys", 31), ("plotter", 41), ("pulses", 61), ("torch", 151), ("grbl", 23)],
)
def test_the_pico_answers_to_numbers_as_cpython_does(uf2, language, step, show):
    """Powers of two and ten in every word, setting and packet: every_number.py."""
    board = every_number.BOARDS[language]
    files = with_digest(board, "job.txt", b"", "every_number.py")
    pico = EmulatedPico(files=files, uf2=uf2).boot()
    code = "import gc\ngc.threshold(16000)\n" + IN_FLASH + f"import every_number\nevery_number.main([{language!r}, '3', '{step}'])"
    said = pico.exec(code, limit_us=20 * LIMIT_US).split()
    assert " ".join(said) == "%08x %d %d" % every_number.run(language, 3, step)
    show(f"numbers of {language} on the Pico", f"{said[1]} sent, {said[2]} refused, as under CPython")
