"""C to code that runs at any address, and that as an .mpy which stock MicroPython loads.

    made = make_module(text, names, "armv6m")    # bytes, from what is shipped, kept or compiled here; None: there is no compiler
    made.data, made.by, made.pointers       # the .mpy, "gcc 12.2.1", and how many words look like pointers

The code is linked at two addresses: equal bytes prove that nothing in it depends on where it lies, so nothing has to be relocated,
and no header, linker or library of MicroPython's is wanted. Compilers are arm-none-eabi-gcc, or `python -m ziglang cc` of PyPI's
ziglang (the extra `kernels`). PASSO_KERNELS=gcc, zig or viper asks for one.

The collector takes words of code for pointers if they look like addresses of its heap, and keeps what lies there: so functions that
have such words are moved by half a word (shift.py), and other options are tried, until there are none.
"""

import hashlib
import importlib.util
import os
import platform
import shutil
import struct
import subprocess
import tempfile
from collections import namedtuple
from functools import lru_cache
from pathlib import Path

from host_tools import interpreter
from host_tools.failure import Failure
from host_tools.kernels.shift import functions_at, sections, shift_functions

CACHE = Path.home() / ".cache" / "passo" / "kernels"
SHIPPED = Path(__file__).parent / "modules"
COMMON = (
    "-std=gnu11 -fwrapv -fno-strict-aliasing -ffreestanding -fno-builtin -fpic -fno-common -fno-jump-tables -fno-exceptions "
    "-fno-unwind-tables -fno-asynchronous-unwind-tables -fno-stack-protector -ffunction-sections -nostdlib -static -w"
)
GCC_ONLY = "-fno-tree-loop-distribute-patterns"
ZIG_ONLY = "-fno-sanitize=all"
GCC = {
    "armv6m": "arm-none-eabi-gcc -mthumb -mcpu=cortex-m0plus",
    "armv7emsp": "arm-none-eabi-gcc -mthumb -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard",
    "x64": "gcc -m64 -mno-red-zone -O2",
}
ZIG = {
    "armv6m": "-target thumb-freestanding-eabi -mcpu=cortex_m0plus",
    "armv7emsp": "-target thumb-freestanding-eabi -mcpu=cortex_m4",
    "rv32imc": "-target riscv32-freestanding-none -mcpu=generic_rv32+m+c",
    "x64": "-target x86_64-freestanding-none",
}
ARCHITECTURE = {"armv6m": 4, "armv7emsp": 7, "rv32imc": 11, "x64": 2}  # the last one is MicroPython's on a PC
HEAPS = {"armv6m": (0x20000000, 0x20042000), "armv7emsp": (0x20000000, 0x20082000), "rv32imc": (0x3FC80000, 0x3FCE0000)}
OPTIONS = "-Os -fno-reorder-blocks", "-Os", "-O2"  # the first made a line 3 % cheaper than -Os
ZIG_OPTIONS = (  # without -g it leaves the names of functions out
    "-g -Os", "-g -Os -mllvm -disable-block-placement", "-g -Os -mllvm -disable-lsr", "-g -Os -mllvm -disable-machine-sink",
    "-g -Os -mllvm -disable-block-placement -mllvm -regalloc=basic", "-g -Os -mllvm -disable-lsr -mllvm -disable-cgp",
)  # fmt: skip
ROUNDS = 5  # of moving functions
KEEPS = 1000  # bytes that a word which looks like a pointer is taken to keep
SCRIPT = """
SECTIONS {{ . = {base:#x}; .text : {{ *(.text.start) *(.text.once) . = ALIGN(4); code_begin = .; *(.text .text.*) *(.rodata .rodata.*) code_end = .; }}
.other : {{ *(.got .got.plt) *(.data .data.*) *(.bss .bss.*) }}
/DISCARD/ : {{ *(.comment .ARM.* .note* .debug* .eh_frame* .riscv.attributes .dyn* .gnu.hash .hash .interp) }} }}
"""
Made = namedtuple("Made", "data by pointers")


def find_compiler(march):
    """Return (name, command, options to try, version), or None."""
    return _find_compiler(march, os.environ.get("PASSO_KERNELS"))


@lru_cache(maxsize=16)
def _find_compiler(march, asked):
    """Return (name, command, options to try, version) of gcc, else of zig; `asked`: only the one of this name. None if there is none for `march`."""
    gcc = GCC.get(march, "").split()
    if march == "x64" and platform.machine() not in ("x86_64", "AMD64"):
        return None
    if asked in (None, "gcc") and gcc and shutil.which(gcc[0]):
        return "gcc", [*gcc, *GCC_ONLY.split()], OPTIONS, _version_of([gcc[0], "-dumpfullversion"])
    if asked in (None, "zig") and march in ZIG and importlib.util.find_spec("ziglang"):
        command = [*interpreter.python(), "-m", "ziglang"]
        return "zig", [*command, "cc", *ZIG[march].split(), *ZIG_ONLY.split()], ZIG_OPTIONS, _version_of([*command, "version"])
    return None


def _version_of(command):
    return subprocess.run(command, capture_output=True, text=True).stdout.strip()


def make_module(text, names, march):
    """Return the module of a text of C, or None if nothing makes it here."""
    asked = os.environ.get("PASSO_KERNELS")
    if march not in ARCHITECTURE or asked == "viper":
        return None
    shipped = SHIPPED / file_name_of(text, names, march)
    if not asked and shipped.is_file():
        return _result_of(shipped.read_bytes(), "what came with Passo", names, march)
    return compile_here(text, names, march)


def origin_of(march):
    """Return everything on which a chip's modules depend beside their C: the compiler, PASSO_KERNELS, and the names of the shipped modules."""
    return find_compiler(march), os.environ.get("PASSO_KERNELS"), sorted(path.name for path in SHIPPED.glob("*.mpy"))


def file_name_of(text, names, march):
    """Return the name of the file that has the module of a text of C."""
    return _hash_text(text, names, march)[:24] + ".mpy"


def compile_here(text, names, march):
    """Compile the module on this PC, or take it from the cache of an earlier call; None if there is no compiler."""
    found = find_compiler(march)
    if found is None:
        return None
    name, command, options, version = found
    identity = _hash_text(command[1:], options, version, COMMON, SCRIPT)[:8]
    kept = CACHE / f"{_hash_text(text, names, march)[:24]}-{name}-{identity}.mpy"
    if not kept.is_file():
        data = mpy_of(best_code(text, march, command, options), names, march)
        kept.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=kept.parent, delete=False) as file:
            file.write(data)
        os.replace(file.name, kept)
    return _result_of(kept.read_bytes(), f"{name} {version}", names, march)


def _hash_text(*given):
    return hashlib.sha256(repr(given).encode()).hexdigest()


def _result_of(data, by, names, march):
    return Made(data, by, len(pointer_positions(code_of(data, names, march), march)))


def best_code(text, march, command, options):
    """Return the first code in which no word looks like a pointer; if there is none, the one that takes the least memory."""
    found = []
    for option in options:
        moved = set()
        for _round in range(ROUNDS):
            code, elf = _link_twice(shift_functions(text, moved), [*command, *option.split()])
            positions = pointer_positions(code, march)
            if not positions:
                return code
            found.append((len(code) + KEEPS * len(positions), code))
            moved ^= functions_at(elf, 0, positions)  # one moved already is put back: those before it have moved it, too
    return min(found)[1]


def compile_c(text, command):
    """Return the code of a text of C. Raises Failure if it does not compile, or depends on its address."""
    return _link_twice(text, command)[0]


def _link_twice(text, command):
    """Return (code, the ELF that has it at address 0). Raises Failure if the code at another address differs."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "k.c").write_text(text, encoding="utf-8")
        _run_command([*command, *COMMON.split(), "-c", "-o", "k.o", "k.c"], folder)
        elfs, codes = [], []
        for base in (0, 0x1000010):
            (folder / "k.ld").write_text(SCRIPT.format(base=base))
            _run_command([*command, *COMMON.split(), "-Wl,-T,k.ld", "-Wl,--build-id=none", "-Wl,-e,start", "-o", "k.elf", "k.o"], folder)
            elfs.append((folder / "k.elf").read_bytes())
            codes.append(bytes_in_memory(elfs[-1], base))
    if codes[0] != codes[1]:
        raise Failure("the machine code of kernels depends on its address")
    return codes[0], elfs[0]


def _run_command(command, folder):
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        raise Failure("{} does not compile kernels: {}", " ".join(command[:4]), next((line for line in done.stdout.splitlines() if "error" in line or "undefined" in line), done.stdout))


def bytes_in_memory(elf, base):
    """Return the bytes of an ELF that are loaded from `base` on. Raises Failure if there is data that can be written."""
    found = b""
    for kind, flags, address, position, length, _ in sections(elf):
        if flags & 2 and length:
            if flags & 1 or kind == 8:
                raise Failure("the machine code of kernels has data that is written")
            found = found.ljust(address - base, b"\0") + elf[position : position + length]
    return found


def pointer_positions(code, march):
    """Return the byte offsets of words in the code that the collector would take for addresses of its heap."""
    low, high = HEAPS.get(march, (0, 0))
    words = struct.unpack(f"<{len(code) // 4}I", code[: len(code) & ~3])
    return [4 * number for number, word in enumerate(words) if low <= word < high and word % 16 == 0]


def encode_number(value):
    """Return a number of 0 or more as .mpy files have it: 7 bits a byte, the highest first, bit 7 set in all but the last."""
    out = bytes([value & 0x7F])
    while value := value >> 7:
        out = bytes([0x80 | value & 0x7F]) + out
    return out


def _mpy_head(names, march):
    """Return the bytes before the code of an .mpy (version 6.3): names, and one object, the table of the interpreter's functions."""
    table = b"".join(encode_number(len(name) << 1) + name.encode() + b"\0" for name in names)
    return bytes([ord("M"), 6, ARCHITECTURE[march] << 2 | 3, 31]) + encode_number(len(names)) + encode_number(1) + table + b"\0"


def mpy_of(code, names, march):
    """Return the .mpy of one function of viper's kind."""
    return _mpy_head(names, march) + encode_number(len(code) << 3 | 2) + code + encode_number(0)


def code_of(data, names, march):
    """Return the machine code in the bytes of mpy_of(), made with the same `names` and `march`."""
    at = len(_mpy_head(names, march))
    while data[at] & 0x80:
        at += 1
    return data[at + 1 : -1]
