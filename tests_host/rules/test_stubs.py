"""The ports against MicroPython's own type stubs: each use of a chip's modules exists, with these arguments.

`make test` puts the stubs, which would clash with each other and with CPython's in one folder, into .venv/typings;
without them these tests skip. Ticks are whole numbers here and types of their own in the stubs: the check leaves them out, and the names used by machine code
and PIO assembler.
"""

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from host_tools import interpreter

ROOT = Path(__file__).resolve().parents[2]
TYPINGS = Path(sys.prefix) / "typings"
SHARED = ("passo.ports.chip_port", "passo.ports.uart_line", "passo.ports.usb_line", "passo.ports.start")
CONFIGURATION = """[mypy]
ignore_missing_imports = True
follow_imports = silent
no_site_packages = True
check_untyped_defs = True
strict_optional = False
disable_error_code = var-annotated, name-defined, operator, type-var, assignment, misc, index
"""
GAPS = (  # of the stubs
    r'passo/ports/rp2/(programs|kernels)\.py',  # assembler
    r'passo/ports/esp32/frames_viper\.py.*ptr32',  # machine code's own type
    r'incompatible type "array\[(int|Any)\]"; expected "ptr32"',  # machine code takes any buffer
    r'"DMA" has no attribute "channel"',
    r'chip_port\.py.*"None" has no attribute',  # a part that an option brings
    r'"memoryview" has incompatible type "Flash"',  # it is a buffer
    r'(flash_code|pages)\.py.*(abstract class "VfsLfs2"|"VfsLfs2" has incompatible type)',  # any object with these methods will do
    r'No overload variant of "Timer" matches argument types "int", "int", "Callable.*"bool"',  # needs no number there
)

needs_stubs = pytest.mark.skipif(
    not ((TYPINGS / "stdlib").is_dir() and importlib.util.find_spec("mypy")),
    reason=f"no mypy, or no stubs in {TYPINGS}: run make test",
)


def complaints(chip, tmp_path, *modules):
    """Return mypy's errors for a chip's port, or for `modules`, with that chip's stubs."""
    configuration = tmp_path / "mypy.ini"
    configuration.write_text(CONFIGURATION)
    asked = modules or ("-p", f"passo.ports.{chip}", *[part for name in SHARED for part in ("-m", name)])
    done = subprocess.run(
        [
            *interpreter.python(), "-m", "mypy", "--config-file", configuration, "--custom-typeshed-dir", TYPINGS / "stdlib",
            "--cache-dir", tmp_path / "cache", *asked,
        ],
        cwd=ROOT / "firmware", env={**os.environ, "MYPYPATH": f"{TYPINGS / chip}:{TYPINGS / 'stdlib'}"},
        capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert "checked" in done.stdout or "no issues" in done.stdout, done.stdout + done.stderr
    lines = [line for line in done.stdout.splitlines() if ": error:" in line and str(TYPINGS) not in line]
    return [line for line in lines if not any(re.search(gap, line) for gap in GAPS)]


@needs_stubs
@pytest.mark.parametrize("chip", ("esp32", "rp2"))
def test_the_port_fits_the_stubs(tmp_path, chip):
    assert complaints(chip, tmp_path) == []


@needs_stubs
@pytest.mark.parametrize(
    "chip, line", [("esp32", "Pin(2).toggel()"), ("esp32", "Timer(0, hertz=3)"), ("rp2", "WDT(seconds=1)")]
)
def test_a_wrong_name_is_found(tmp_path, chip, line):
    wrong = tmp_path / "wrong.py"
    wrong.write_text(f"from machine import WDT, Pin, Timer\n\n{line}\n")
    assert complaints(chip, tmp_path, str(wrong))
