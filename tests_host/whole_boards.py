"""Board files as modules of other interpreters: one that is "like" another is whole."""

import hashlib
import tempfile
from pathlib import Path

from host_tools import boards
from host_tools.resources import ROOT


def folder():
    """The path of a folder whose boards/ has all of them. Made once for each state of the board files, in build/boards."""
    files = {"__init__.py": b"", **{f"{name}.py": boards.board_py(name) for name in boards.names()}}
    state = hashlib.sha256(repr(sorted(files.items())).encode()).hexdigest()[:16]
    out = ROOT / "build" / "boards" / state
    if not out.exists():
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=out.parent) as temporary:
            made = Path(temporary) / "made"
            (made / "boards").mkdir(parents=True)
            for name, data in files.items():
                (made / "boards" / name).write_bytes(data)
            try:
                made.rename(out)  # whole, or another process was first
            except OSError:
                if not out.exists():
                    raise
    return out
