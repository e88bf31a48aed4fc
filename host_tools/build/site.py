"""The firmware for a browser's tab: MicroPython as WebAssembly, the firmware and its virtual machine as texts.

    package()["micropython.wasm"], texts()["passo/app.py"]

MicroPython comes from npm, a version of one checksum, and stays in ~/.cache/passo. The firmware is what MicroPython on a PC runs
(tree.py: constants of other modules as numbers), without the marks of machine code: WebAssembly has none, and its plain text makes
the same words.
"""

import base64
import hashlib
import io
import os
import re
import tarfile
import urllib.error
import urllib.request
from pathlib import Path

from host_tools import boards
from host_tools.build.constants import numbered_only
from host_tools.build.tree import module_files
from host_tools.failure import Failure
from host_tools.resources import FIRMWARE, HOST_TOOLS

PACKAGE = "micropython-webassembly-pyscript"
VERSION = "1.27.0"
INTEGRITY = "DnXx4EqxgkeaFESrS3uKrL7mLMk4mRTd0mMzaOd3HUSiZUOAE7t11uLnjf3ftF87N2xm4knHnWEKcVK4IYIUDA=="  # SHA-512
TAKEN = ("micropython.mjs", "micropython.wasm")
OWN = HOST_TOOLS / "site"
TAB = ("host_tools/sim/plant.py", "host_tools/sim/parts.py", "host_tools/sim/decoders.py", "host_tools/sim/faults.py")
SHIMS = ("random.py",)
BOARDS = ("router_3axis", "plotter_2014")  # the first one is shown
_LEFT_OUT = ("passo/ports/rp2/", "passo/ports/esp32/", "passo/web/server.py")
_MACHINE_CODE = re.compile(r"(?m)^[ ]*@micropython\.(viper|native)$")
_MOST_PACKAGE = 4 << 20
_FETCH_S = 60


def package(cache=None):
    """{name: bytes} of MicroPython's two files: from ~/.cache/passo, else from npm's registry. Raises Failure."""
    kept = (cache or Path("~/.cache/passo").expanduser()) / f"{PACKAGE}-{VERSION}.tgz"
    if kept.is_file():
        data = kept.read_bytes()
    else:
        data = _fetched()
        kept.parent.mkdir(parents=True, exist_ok=True)
        fresh = kept.with_suffix(f".{os.getpid()}")
        fresh.write_bytes(data)
        os.replace(fresh, kept)
    try:
        return unpacked(data)
    except Failure:
        kept.unlink(missing_ok=True)
        raise


def _fetched():
    registry = os.environ.get("NPM_CONFIG_REGISTRY", "https://registry.npmjs.org").rstrip("/")
    address = f"{registry}/@micropython/{PACKAGE}/-/{PACKAGE}-{VERSION}.tgz"
    try:
        with urllib.request.urlopen(address, timeout=_FETCH_S) as answer:
            return answer.read(_MOST_PACKAGE)
    except (OSError, urllib.error.URLError) as error:
        raise Failure(f"cannot fetch MicroPython for the browser, {address}: {error}") from error


def unpacked(data):
    """The files that are taken of npm's archive. Raises Failure if it is not the one that is known."""
    found = base64.b64encode(hashlib.sha512(data).digest()).decode()
    if found != INTEGRITY:
        raise Failure(f"{PACKAGE} {VERSION} is not what it was: SHA-512 {found} instead of {INTEGRITY}; it is not used")
    with tarfile.open(fileobj=io.BytesIO(data)) as archive:
        return {name: archive.extractfile(f"package/{name}").read() for name in TAKEN}


def texts():
    """{path: text} of all that Python imports in the tab."""
    found = {path.as_posix(): FIRMWARE / path for path in module_files() if not path.as_posix().startswith(_LEFT_OUT)}
    found |= {name: HOST_TOOLS.parent / name for name in TAB}
    read = numbered_only({name: path.read_text(encoding="utf-8") for name, path in found.items()})
    read |= {name: (OWN / name).read_text(encoding="utf-8") for name in SHIMS}
    read |= {f"boards/{name}.py": boards.path(name).read_text(encoding="utf-8") for name in BOARDS}
    return {name: _MACHINE_CODE.sub("", text) for name, text in read.items()}
