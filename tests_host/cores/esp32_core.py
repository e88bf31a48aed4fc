"""MicroPython's qemu port with the memory of an ESP32: its heap in pieces, machine code in what is left (modules/chip/chip.c). The start of a board
file's firmware, in main.py's order, says what it wants of them.

    core = Esp32(frozen=False)          # built from MicroPython's sources (MICROPYTHON); raises Unavailable
    counted = core.started("router_esp32", folder)          # nothing bounded: Counted
    core.started("plotter_esp32", folder, MODULES["esp32"]) # in its pieces; `counted.error`: where it ended

Kernels are viper, because there is no compiler of C for Xtensa here; RV32's code is about as long. The chip's own modules are
fake_machine.py's, whose memory is subtracted.
"""

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections import namedtuple
from pathlib import Path

from qemu import CORES, Core, packed

from host_tools import boards
from host_tools.build.frozen import compile_beside, frozen_tree
from host_tools.build.tree import build_tree, compile_module
from host_tools.build.esp32_image import manifest_text as manifest_of
from host_tools.emulator.binary import CACHE, Unavailable
from host_tools.resources import FIRMWARE
from passo.config.boardfile import check

HERE = Path(__file__).parent
MARCH = "rv32imc"
FIRST_HEAP = 56 * 1024  # ports/esp32/mpconfigport.h, ESP32
Counted = namedtuple("Counted", "steady peak code left error")
_RUN = "    main(Start, STAMP)\n"
# Modules that start.py wants to be files or frozen, through a file system that gives no memory of its own, as littlefs.
_START = """
import chip, gc, io, json, os, sys, vfs
class Stream(io.IOBase):
    def __init__(self, file):
        self.file = file
    def readinto(self, data):
        return self.file.readinto(data)
    def ioctl(self, request, argument):
        if request == 4:
            self.file.close()
        return 0
class Files:
    def mount(self, readonly, mkfs):
        pass
    def umount(self):
        pass
    def chdir(self, path):
        pass
    def getcwd(self):
        return "/"
    def stat(self, path):
        return os.stat("/rom/" + path.lstrip("/"))
    def open(self, path, mode):
        if "w" in mode:
            raise OSError(30)
        return Stream(open("/rom/" + path.lstrip("/"), mode))
sys.path[:] = ["/rom"]
import fake_machine
sys.path[:] = [".frozen", "/files"] if {frozen} else ["/files", ".frozen"]
vfs.mount(Files(), "/files")
import builtins
plain = __import__
most = [0]
def counting(*arguments):
    made = plain(*arguments)
    gc.collect()
    most[0] = max(most[0], gc.mem_alloc())
    return made
with open("/rom/start.txt") as file:
    text = compile(file.read(), "main.py", "exec")
file = None
gc.collect()
base = gc.mem_alloc()
def told(error=None):
    if most[0] == 0:
        most[0] = gc.mem_alloc()
    gc.collect()
    most[0] = max(most[0], gc.mem_alloc())
    print(json.dumps([gc.mem_alloc() - base, most[0] - base, chip.code(), chip.left(), error]))
    raise SystemExit
pieces = {pieces}
if pieces:
    chip.pieces(pieces[0] + base, *pieces[1:])
else:
    builtins.__import__ = counting
error = None
for size in {drivers}:
    if not chip.take(size):
        told("no memory for the radio or I2S")
exec(text, {{"__name__": "main", "__file__": "main.mpy", "told": told}})
told("it has not started")
"""


def build(frozen):
    """Return the interpreter's ELF, built once for each set of frozen modules. Raises Unavailable."""
    source = Path(os.environ.get("MICROPYTHON", "")).expanduser()
    if not (source / "ports" / "qemu").is_dir():
        raise Unavailable("MICROPYTHON names no source of MicroPython for its qemu port")
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "frozen"
        tree.mkdir()
        if frozen:
            _of_viper(lambda: frozen_tree("esp32", tree, march=MARCH))
        state = [path.read_bytes() for path in sorted([*(HERE / "modules" / "chip").iterdir(), *tree.rglob("*.mpy"), Path(__file__)])]
        made = CACHE / f"qemu-esp32-{hashlib.sha256(b''.join(state)).hexdigest()[:12]}.elf"
        if made.is_file():
            return made
        manifest = Path(folder) / "manifest.py"
        manifest.write_text(manifest_of(tree) if frozen else "# nothing\n")
        script = Path(folder) / "large.ld"
        script.write_text((source / "ports" / "qemu" / "mcu" / "rv32" / "virt.ld").read_text().replace("LENGTH = 2M", "LENGTH = 24M"))
        options = {
            "BOARD": "VIRT_RV32", "PYTHON": sys.executable, "BUILD": f"{folder}/made", "LDSCRIPT": script, "MICROPY_HEAP_SIZE": FIRST_HEAP, "MICROPY_FLOAT_IMPL": "float",
            "RV32_ARCH": "rv32imc -misa-spec=2.2", "USER_C_MODULES": HERE / "modules", "FROZEN_MANIFEST": manifest,
            "QEMU_MACHINE": "ESP32", "CFLAGS_EXTRA": f"-Wno-pointer-arith -include {HERE / 'modules' / 'chip' / 'chip.h'}",
        }  # fmt: skip
        command = ["make", "-C", str(source / "ports" / "qemu"), f"-j{os.cpu_count()}", *(f"{key}={value}" for key, value in options.items())]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise Unavailable("MicroPython's qemu port is not built: {}", (done.stdout + done.stderr)[-3000:])
        CACHE.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(Path(folder) / "made" / "firmware.elf", made)
    return made


def _of_viper(work):
    before = os.environ.get("PASSO_KERNELS")
    os.environ["PASSO_KERNELS"] = "viper"
    try:
        work()
    finally:
        if before is None:
            del os.environ["PASSO_KERNELS"]
        else:
            os.environ["PASSO_KERNELS"] = before


class Esp32:
    def __init__(self, frozen):
        self.frozen = frozen
        self.elf = build(frozen)

    def printed(self, code, files, folder):
        """Return the output of `code`; `files` beside the frozen modules: {path: bytes}, {path: text} of modules."""
        texts = {path: text for path, text in files.items() if isinstance(text, str)}
        others = {path: data for path, data in files.items() if path not in texts}
        made = {}
        _of_viper(lambda: made.update(compile_beside("esp32", texts, march=MARCH)))
        return self.core({**others, **made}, folder / "digest").run("import sys\nsys.path.insert(1, '.frozen')\n" + code)

    def core(self, files, folder):
        """A Core on which the files of {path: bytes} lie in /rom."""
        folder.mkdir(parents=True, exist_ok=True)
        compile_module(HERE / "fake_machine.py", folder / "fake_machine.mpy", MARCH, "fake_machine.py")
        image = packed(files, folder)
        return Core(CORES["rv32"], image, self.elf)

    def started(self, board, folder, pieces=(), drivers=()):
        """Counted of the start of a board file, by name or as a dict; `drivers`: bytes they take before anything is imported."""
        loaded = board if isinstance(board, dict) else boards.load(board)
        check(loaded)
        folder = folder / ("frozen" if self.frozen else "files")
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        if not self.frozen:
            (folder.parent / "board.py").write_text(f"BOARD = {loaded!r}\n")
            _of_viper(lambda: build_tree(str(folder.parent / "board.py"), folder, march=MARCH))
        text = (FIRMWARE / "main.py").read_text()
        assert text.count(_RUN) == 1 and text.count('% sys.platform') == 1
        text = text.replace(_RUN, "    Start.run = lambda *_: told()\n" + _RUN).replace('% sys.platform', '% "esp32"')
        files = {"board.py": f"BOARD = {loaded!r}\n".encode(), "start.txt": text.encode()}
        code = _START.format(frozen=self.frozen, pieces=tuple(pieces), drivers=tuple(drivers))
        said = self.core(files, folder).run(code)
        try:
            return Counted(*json.loads(said.strip().splitlines()[-1]))
        except ValueError:
            raise AssertionError(said) from None
