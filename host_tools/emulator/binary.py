"""Finding the MicroPython binary that the emulated Pico runs.

    path = find_uf2()      # raises Unavailable with what to do

Order of search: the file that PASSO_UF2 names; the newest ~/.cache/passo/*.uf2, but those with Passo in them (passo-*.uf2); earlier downloads of rp2040py; and, unless
PASSO_OFFLINE is set, the official release, which rp2040py's own resolver fetches. The file is checked to be a UF2 for the
RP2040: the emulator would run anything else too, and spin for ever.
"""

import os
import struct
import sys
from pathlib import Path

from host_tools.failure import Failure
from host_tools.language import _
from host_tools.uf2_format import BLOCK_BYTES, CACHE, FAMILIES, FAMILY_PRESENT, MAGIC_END, MAGIC_SECOND, MAGIC_START

RELEASE = "1.27.0"  # the firmware needs 1.26 or later
BOARD, FAMILY = "pico", "micropython"

class Unavailable(Failure):
    """The emulator cannot run here; the text says why, and how to mend it."""


def load_emulator():
    """Import and return the package rp2040py, with its compiled part. Raises Unavailable."""
    try:
        import rp2040py
        from rp2040py.rp2040 import RP2040
    except ImportError:
        raise Unavailable("rp2040py is not installed: in the project's folder, pip install '.[emulate]'") from None
    if not RP2040.__module__.startswith("rp2040py.native"):
        raise Unavailable("rp2040py has no compiled part here and is too slow without: it has wheels for other systems")
    return rp2040py


def find_uf2():
    """Return the path of a MicroPython UF2 for the Pico; may download one. Raises Unavailable."""
    named = os.environ.get("PASSO_UF2")
    if named:
        path = Path(named).expanduser()
        if not path.is_file():
            raise Unavailable("PASSO_UF2 names {}, which is no file", named)
        return check_uf2(path)
    cached = sorted((path for path in CACHE.glob("*.uf2") if not path.name.startswith("passo-")), key=lambda path: path.stat().st_mtime)
    return check_uf2(cached[-1] if cached else _fetch_uf2())


def check_uf2(path):
    """Return `path`, if it is a whole UF2 with MicroPython for the RP2040. Raises Unavailable, with the reason, if it is not."""
    data = Path(path).read_bytes()
    if len(data) < BLOCK_BYTES or len(data) % BLOCK_BYTES:
        raise Unavailable("{} is no UF2 file: {} bytes are not whole blocks of {}", path, len(data), BLOCK_BYTES)
    blocks = len(data) // BLOCK_BYTES
    for number in range(blocks):
        first, second, flags, _, _, _, total, family = struct.unpack_from("<8I", data, number * BLOCK_BYTES)
        last = struct.unpack_from("<I", data, (number + 1) * BLOCK_BYTES - 4)[0]
        if (first, second, last) != (MAGIC_START, MAGIC_SECOND, MAGIC_END):
            raise Unavailable("{} is no UF2 file: block {} of {} has not the numbers of one", path, number, blocks)
        if not flags & FAMILY_PRESENT or family != FAMILIES["rp2040"]:
            raise Unavailable("{} is not for the RP2040 of a Pico: its family is {:#010x}", path, family)
        if total != blocks:
            raise Unavailable("{} is not whole: {} of {} blocks", path, blocks, total)
    if b"MicroPython" not in data:
        raise Unavailable("{} holds no MicroPython", path)
    return path


def _fetch_uf2():
    """Download MicroPython RELEASE for the Pico from micropython.org and return its path. Raises Unavailable with PASSO_OFFLINE set, or if the
    download fails."""
    from rp2040py.utils.firmware_retrieve import MICROPYTHON, retrieve

    hint = _("set PASSO_UF2 to one, or put it into {} (micropython.org/download/RPI_PICO, v1.26 or later)", CACHE)
    if os.environ.get("PASSO_OFFLINE"):
        raise Unavailable("no MicroPython UF2 for the Pico: {}", hint)
    print(_("fetching MicroPython {} for the Pico from micropython.org, once", RELEASE), file=sys.stderr, flush=True)
    try:
        path = retrieve(MICROPYTHON, RELEASE, BOARD)
    except OSError as error:
        raise Unavailable("no MicroPython UF2 for the Pico, and none can be downloaded ({}): {}", error, hint) from None
    if path is None:
        raise Unavailable("no MicroPython UF2 for the Pico, and none can be downloaded: {}", hint)
    return path
