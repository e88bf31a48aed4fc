"""No stored job is lost by a power cut: job_power.py under MicroPython, with its own file systems."""

import subprocess
from importlib import import_module
from pathlib import Path

import pytest
from test_micropython import MICROPYTHON, MODULE_PATH, needs_micropython

from host_tools import interpreter

pytestmark = [pytest.mark.unmeasured, needs_micropython]


@pytest.mark.parametrize("system", ["lfs", "fat"])
def test_a_power_cut_at_any_write_loses_no_job(system, show):
    if system == "fat":
        import_module("passo.options.card")
    done = subprocess.run(
        [MICROPYTHON, "-X", "heapsize=256m", Path(__file__).with_name("job_power.py"), system],
        env=interpreter.environment(*MODULE_PATH), capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    show(f"jobs on {system}", done.stdout.strip())
