"""MicroPython's qemu port as a machine for tests: the firmware, its checks and jobs as one file system in memory (ROMFS), compiled
for the core, and the raw REPL over qemu's serial line.

    image = image_of(CORES["rv32"], {"jobs/square.bin": data}, folder)
    print(Core(CORES["rv32"], image).run("import digest\\ndigest.main(['/rom/jobs/square.bin'])"))

The port is built from MicroPython's sources (ports/qemu/README.md there), version 1.27 or later, in ports/qemu:

    sed 's/LENGTH = 2M/LENGTH = 24M/' mcu/rv32/virt.ld > large.ld
    make BOARD=VIRT_RV32 LDSCRIPT=large.ld MICROPY_HEAP_SIZE=23000000 MICROPY_FLOAT_IMPL=double RV32_ARCH="rv32imc -misa-spec=2.2"
    make BOARD=MPS2_AN500 MICROPY_HEAP_SIZE=3600000

(double precision: properties compute their reference values in it). PASSO_QEMU_RV32 and PASSO_QEMU_ARM name the firmware.elf of
each; without them ~/.cache/passo/qemu-rv32.elf and qemu-arm.elf are looked for. qemu is Debian's
qemu-system-misc and qemu-system-arm.
"""

import os
import shutil
import subprocess
import threading
from collections import namedtuple
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import folders
import whole_boards
from mpremote.romfs import make_romfs

from host_tools.build.tree import compile_module, unix_tree
from host_tools.failure import Failure

TESTS = Path(__file__).resolve().parents[1]
CACHE = Path.home() / ".cache" / "passo"

# The port has no clock of the day.
TIME = "from utime import *\n\n\ndef time_ns():\n    return ticks_us() * 1000\n"

INSTRUCTION_CLOCK = ("-icount", "shift=0")

# program: qemu's; machine: its and mpy-cross's name; rom: address where nothing of the interpreter's lies
Kind = namedtuple("Kind", "name program machine march rom variable")
CORES = {
    "rv32": Kind("rv32", "qemu-system-riscv32", ("-machine", "virt", "-bios", "none"), "rv32imc", 0x84000000, "PASSO_QEMU_RV32"),
    "arm": Kind("arm", "qemu-system-arm", ("-machine", "mps2-an500"), "armv7emsp", 0x60000000, "PASSO_QEMU_ARM"),
}


def firmware_of(kind):
    """The interpreter's ELF, or None."""
    named = os.environ.get(kind.variable)
    path = Path(named) if named else CACHE / f"qemu-{kind.name}.elf"
    if named and not path.is_file():
        raise FileNotFoundError(f"{kind.variable}={named}: there is no such file")
    return path if path.is_file() else None


def missing(kind):
    """Why the core cannot run here, or an empty text."""
    if shutil.which(kind.program) is None:
        return f"there is no {kind.program} (Debian: qemu-system-misc, qemu-system-arm)"
    if firmware_of(kind) is None:
        return f"{kind.variable} names no build of MicroPython's qemu port, and {CACHE} holds none"
    return ""


def image_of(kind, jobs, folder, in_c=False):
    """A ROMFS of the firmware, checks, simulations and boards, compiled for the core, and of `jobs`: {path: bytes}; `in_c`: kernels
    compiled as C, instead of viper. A module's text lies beside it as NAME.txt, for the plain twins of kernels."""
    tree = folder / kind.name
    firmware = unix_tree(march=kind.march if in_c else None)
    for path in firmware.rglob("*.mpy"):
        (tree / path.relative_to(firmware)).parent.mkdir(parents=True, exist_ok=True)
        (tree / path.relative_to(firmware)).write_bytes(path.read_bytes())
    plain = unix_tree()
    for source, target in modules(firmware):
        place = tree / target
        try:
            compile_module(source, place.with_suffix(".mpy"), kind.march, target)
        except Failure:
            if TESTS not in source.parents and "rp2" not in target.parts:
                raise
            continue  # for pytest only, or with instructions of the RP2040: a module that imports it there gets ImportError
        text = plain / target if firmware in source.parents else source
        place.with_suffix(".txt").write_bytes(text.read_bytes())
    (tree / "time.py").write_text(TIME)
    return packed(jobs, tree)


def packed(files, tree):
    """Return a ROMFS of the folder `tree`, and of `files`: {path: bytes}."""
    for path, data in files.items():
        (tree / path).parent.mkdir(parents=True, exist_ok=True)
        (tree / path).write_bytes(data)
    image = tree.with_suffix(".romfs")
    with redirect_stdout(StringIO()):  # it lists every file
        image.write_bytes(make_romfs(str(tree), mpy_cross=None))
    return image


def modules(firmware):
    """(source, path on the core) of all that runs there. Files that MicroPython cannot compile (tests for pytest) are no modules of it."""
    for path in sorted((firmware / "passo").rglob("*.py")):
        yield path, path.relative_to(firmware)
    for path in sorted((whole_boards.folder() / "boards").glob("*.py")):
        yield path, Path("boards") / path.name
    for folder in (*folders.OF_CHECKS, TESTS / "sims"):
        for path in sorted(folder.glob("*.py")):
            if not path.name.startswith("test_"):
                yield path, Path(path.name)


class Core:
    def __init__(self, kind, image, elf=None):
        self.kind = kind
        self.image = image
        self.elf = elf or firmware_of(kind)

    def run(self, code, timeout_s=600, options=()):
        """Run `code` on a fresh interpreter; returns what it printed. Raises AssertionError with its traceback. With
        INSTRUCTION_CLOCK as `options` each instruction takes a nanosecond."""
        start = f"import uctypes, vfs, sys, gc\nvfs.mount(vfs.VfsRom(uctypes.bytearray_at({self.kind.rom}, {self.image.stat().st_size})), '/rom')\n"
        start += "sys.path.insert(0, '/rom')\n"
        sent = b"\x01" + (start + code).encode() + b"\x04"
        loader = f"loader,file={self.image},addr={self.kind.rom},force-raw=on"
        command = [self.kind.program, *self.kind.machine, "-display", "none", "-monitor", "none", "-semihosting", "-serial", "stdio"]
        command += ["-device", loader, "-kernel", str(self.elf), *options]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        late = threading.Timer(timeout_s, process.kill)
        late.start()
        try:
            self._until(process, b">")  # the raw REPL's prompt comes after the banner's
            process.stdin.write(sent)
            process.stdin.flush()
            self._until(process, b"raw REPL; CTRL-B to exit\r\n>OK")
            printed = self._until(process, b"\x04")
            error = self._until(process, b"\x04")
        finally:
            late.cancel()
            process.kill()
            process.wait()
        assert not error, error.decode(errors="replace")
        return printed.decode().replace("\r\n", "\n")

    @staticmethod
    def _until(process, mark):
        said = bytearray()
        while not said.endswith(mark):
            byte = process.stdout.read(1)
            assert byte, f"qemu ended: {said.decode(errors='replace')}"
            said += byte
        return bytes(said[: -len(mark)])
