"""`passo build`: what goes to a board and what does not."""

import pytest
import typer
from typer.testing import CliRunner

from host_tools import boards, build
from host_tools.failure import Failure
from host_tools.virtual_machine import VirtualMachine
from passo.control import boardfile

MODULES = {
    "main.py": "import passo.app\n",
    "passo/__init__.py": "",
    "passo/app.py": "from passo.motion.line import line\nfrom passo.protocols import errors\n",
    "passo/control/track.py": "",
    "passo/languages/plotter.py": "from passo.protocols.plotter import sum\n",
    "passo/languages/torch.py": "from passo.control import track\n",
    "passo/motion/line.py": "def line():\n    return 1\n",
    "passo/ports/virtual.py": "",
    "passo/ports/pins.py": "",
    "passo/ports/rp2_pio.py": "",
    "passo/ports/esp32.py": "",
    "passo/protocols/__init__.py": "",
    "passo/protocols/errors.py": "",
    "passo/protocols/plotter.py": "from passo.protocols.packets import sum\n",
    "passo/protocols/packets.py": "def sum():\n    return 0\n",
    "passo/protocols/torch.py": "",
    "passo/protocols/grbl/words.py": "",
}


@pytest.fixture
def firmware(tmp_path):
    folder = tmp_path / "firmware"
    for name, source in MODULES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(source)
    return folder


def board_file(tmp_path, chip="rp2040", protocol="plotter"):
    path = tmp_path / "bench.py"
    path.write_text(f'"""A board."""\n\nBOARD = {{"chip": "{chip}", "links": [{{"protocol": "{protocol}"}}]}}\n')
    return str(path)


def built_files(out):
    return sorted(path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file())


ALWAYS = ["board.py", "main.py", "passo/__init__.mpy", "passo/app.mpy", "passo/files.txt", "passo/motion/line.mpy"]
ROOMS = ["passo/ports/pins.mpy", "passo/protocols/__init__.mpy", "passo/protocols/errors.mpy"]
TORCH = ["passo/control/track.mpy", "passo/languages/torch.mpy", "passo/protocols/torch.mpy"]
PLOTTER = ["passo/languages/plotter.mpy", "passo/protocols/packets.mpy", "passo/protocols/plotter.mpy"]


@pytest.mark.parametrize(
    "chip, protocol, more",
    [
        ("rp2040", "plotter", ["passo/ports/rp2_pio.mpy"] + PLOTTER),
        ("rp2350", "torch", ["passo/ports/rp2_pio.mpy"] + TORCH),
        ("esp32", "grbl", ["passo/ports/esp32.mpy", "passo/protocols/grbl/words.mpy"]),
        ("esp32c3", "torch", ["passo/ports/esp32.mpy"] + TORCH),
    ],
)
def test_only_what_the_board_needs(tmp_path, firmware, chip, protocol, more):
    out = tmp_path / "out"
    build.build_tree(board_file(tmp_path, chip, protocol), out, firmware=firmware)
    assert built_files(out) == sorted(ALWAYS + ROOMS + more)


def test_the_file_list_names_every_module(tmp_path, firmware):
    out = tmp_path / "out"
    build.build_tree(board_file(tmp_path), out, firmware=firmware)
    listed = (out / "passo" / "files.txt").read_text().split()
    assert listed == [name for name in built_files(out) if name.endswith(".mpy")]


def test_an_older_build_is_cleared(tmp_path, firmware):
    out = tmp_path / "out"
    (out / "passo").mkdir(parents=True)
    (out / "passo" / "gone.mpy").write_text("old")
    (out / "notes.txt").write_text("mine")
    build.build_tree(board_file(tmp_path), out, firmware=firmware)
    assert "passo/gone.mpy" not in built_files(out)
    assert "notes.txt" in built_files(out)


def test_tracebacks_will_name_the_module(tmp_path, firmware):
    out = tmp_path / "out"
    build.build_tree(board_file(tmp_path), out, firmware=firmware)
    assert b"passo/motion/line.mpy" in (out / "passo" / "motion" / "line.mpy").read_bytes()


def test_faults_are_one_line(tmp_path, firmware):
    out = tmp_path / "out"
    with pytest.raises(Failure, match="unknown chip 'z80'; known are rp2040"):
        build.build_tree(board_file(tmp_path, chip="z80"), out, firmware=firmware)
    with pytest.raises(Failure, match="there is no protocol morse"):
        build.build_tree(board_file(tmp_path, protocol="morse"), out, firmware=firmware)
    with pytest.raises(Failure, match="unknown board 'nosuch'"):
        build.build_tree("nosuch", out, firmware=firmware)
    (firmware / "passo" / "app.py").write_text("x = \n")
    with pytest.raises(Failure, match="passo/app.py:1: invalid syntax"):
        build.build_tree(board_file(tmp_path), out, firmware=firmware)


def test_a_module_that_does_not_compile_is_named(tmp_path, firmware):
    (firmware / "passo" / "app.py").write_text("import micropython\n\n\n@micropython.viper\ndef f(x: str):\n    pass\n")
    with pytest.raises(Failure, match="passo/app.py does not compile for armv6m: .*unknown type"):
        build.build_tree(board_file(tmp_path), tmp_path / "out", firmware=firmware)


@pytest.mark.parametrize(
    "name, architecture",  # numbers of MicroPython's py/persistentcode.h
    [("plotter_2014", 4), ("plotter_pico_w", 4), ("plotter_pico_2", 7), ("plotter_esp32", 10)],
)
def test_machine_code_is_the_chips(tmp_path, name, architecture):
    build.build_tree(name, tmp_path)
    assert (tmp_path / "passo" / "motion" / "line_viper.mpy").read_bytes()[2] >> 2 == architecture
    families = {path.name for path in (tmp_path / "passo" / "ports").iterdir() if path.is_dir()}
    assert families == {"esp32" if name == "plotter_esp32" else "rp2"}


def test_every_chip_of_a_board_file_has_an_instruction_set():
    assert set(build.MARCH) == set(boardfile._BOARD["chip"])


@pytest.mark.parametrize("name", boards.names())
def test_every_board_starts(name):
    machine = VirtualMachine(name)
    machine.run_ms(20)
    assert machine.app.controller.state in ("idle", "alarm") and not machine.plant.errors


@pytest.mark.parametrize("name", boards.names())
def test_every_board_builds(tmp_path, name):
    app = typer.Typer()
    app.command()(build.build)
    result = CliRunner().invoke(app, ["--board", name, "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert "bytes in all" in result.output
    assert not list(tmp_path.rglob("virtual*"))
    assert (tmp_path / "board.py").read_text() == boards.path(name).read_text()
