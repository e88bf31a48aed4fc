"""Finding the MicroPython binary that the emulated Pico runs.

    path = find_uf2()      # raises Unavailable with what to do

Looked for in this order: the file that PASSO_UF2 names; the newest ~/.cache/passo/*.uf2; what rp2040py has downloaded
before; and, unless PASSO_OFFLINE is set, the official release, which rp2040py's own resolver fetches.
"""

import os
from pathlib import Path

from host_tools.failure import Failure

CACHE = Path("~/.cache/passo").expanduser()
RELEASE = "1.27.0"  # the firmware needs 1.26 or later
BOARD, FAMILY = "pico", "micropython"


class Unavailable(Failure):
    """The emulator cannot run here; the text says why, and what would help."""


def load_emulator():
    """The package rp2040py, with its compiled part. Raises Unavailable."""
    try:
        import rp2040py
        from rp2040py.rp2040 import RP2040
    except ImportError:
        raise Unavailable("rp2040py is not installed: pip install 'passo[emulate]'") from None
    if not RP2040.__module__.startswith("rp2040py.native"):
        raise Unavailable("rp2040py has no compiled part here and is too slow without: it has wheels for other systems")
    return rp2040py


def find_uf2():
    """Path of a MicroPython UF2 for the Pico. Raises Unavailable."""
    named = os.environ.get("PASSO_UF2")
    if named:
        path = Path(named).expanduser()
        if not path.is_file():
            raise Unavailable(f"PASSO_UF2 names {named}, which is no file")
        return path
    cached = sorted(CACHE.glob("*.uf2"), key=lambda path: path.stat().st_mtime)
    if cached:
        return cached[-1]
    return _resolved()


def _resolved():
    from rp2040py.utils.firmware_retrieve import MICROPYTHON, retrieve

    hint = f"set PASSO_UF2 to one, or put it into {CACHE} (micropython.org/download/RPI_PICO, v1.26 or later)"
    if os.environ.get("PASSO_OFFLINE"):
        raise Unavailable(f"no MicroPython UF2 for the Pico: {hint}")
    try:
        path = retrieve(MICROPYTHON, RELEASE, BOARD)
    except OSError as error:
        raise Unavailable(f"no MicroPython UF2 for the Pico, and none can be downloaded ({error}): {hint}") from None
    if path is None:
        raise Unavailable(f"no MicroPython UF2 for the Pico, and none can be downloaded: {hint}")
    return path
