"""Every number of every word, setting and packet, at the powers of two and ten: MicroPython answers and moves as CPython does."""

import subprocess

import pytest
import tiers

import every_number
from test_micropython import MICROPYTHON, MODULE_PATH, needs_micropython

from host_tools import interpreter

STEPS = {"check": {"grbl": 401, "laser": 101, "torch": 41}, "test": {"grbl": 17, "laser": 3, "torch": 5}}
TIMEOUT_S = 1500


@needs_micropython
@pytest.mark.quick
@pytest.mark.unmeasured
@pytest.mark.parametrize("language", sorted(every_number.TRAFFIC))
def test_micropython_does_the_same(language, show):
    step = STEPS.get(tiers.current, {}).get(language, 1)
    told = every_number.run(language, 3 % step, step)
    words = [MICROPYTHON, "-X", "heapsize=64m", every_number.__file__, language, str(3 % step), str(step)]
    result = subprocess.run(words, env=interpreter.environment(*MODULE_PATH), capture_output=True, text=True, timeout=TIMEOUT_S)
    assert result.stdout == "%08x %d %d\n" % told, result.stdout + result.stderr
    show(f"numbers of {language}", f"{told[1]} sent, {told[2]} refused, the same under MicroPython")


def test_what_is_sent_reaches_beyond_every_field():
    numbers = list(every_number.texts())
    assert len(set(numbers)) > 150
    for power in range(31, 41):
        assert str(1 << power) in numbers and str((1 << power) - 1) in numbers
    assert sum(1 for _ in every_number.grbl()) > 20_000
