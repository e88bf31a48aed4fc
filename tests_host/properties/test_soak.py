"""The soaks of soak_*.py and fuzz_grbl.py, shorter than `make bench` runs them, under MicroPython."""

import subprocess
from importlib.util import find_spec

import pytest
from soak_motion import MACHINES
from test_micropython import CHECKS, MICROPYTHON, MODULE_PATH, needs_micropython

from host_tools import interpreter

pytestmark = [pytest.mark.slow, pytest.mark.unmeasured, needs_micropython]
TIMEOUT_S = 800


@pytest.mark.parametrize(
    "script, arguments",
    [
        *[("soak_motion.py", (first, first + 200)) for first in range(0, 800, 200)],
        *[("soak_motion.py", (0, 200, machine)) for machine, check in MACHINES.items() if machine != "cartesian" and find_spec(check)],
        *[("soak_circle.py", (first, first + 249)) for first in range(1, 1001, 250)],
        *[("fuzz_grbl.py", (5000, seed)) for seed in range(1, 5)],
    ],
)
def test_soak(script, arguments, show):
    done = subprocess.run(
        [MICROPYTHON, "-X", "heapsize=64m", CHECKS / script, *map(str, arguments)],
        env=interpreter.environment(*MODULE_PATH), capture_output=True, text=True, timeout=TIMEOUT_S,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    show(f"{script} {' '.join(map(str, arguments))}", done.stdout.strip())
