"""A machine's memory over 100 000 orders, ten uploads and 200 resets, under MicroPython in a heap with little to spare."""

import re
import subprocess

import pytest
from test_micropython import CHECKS, MICROPYTHON, MODULE_PATH, needs_micropython

from host_tools import interpreter

HEAP = "1000k"  # for loading; soak_memory.py leaves a tenth of the memory in use free at the start, as on a Pico. Objects are twice as large
BLOCK_BYTES = 32
LEAST = 1_000  # bytes in one piece, at any time: no order wants as many
SETTLED = 10  # of the hundred times that it prints its memory: the log is full by then
TIMEOUT_S = 800


@needs_micropython
@pytest.mark.slow
@pytest.mark.unmeasured
@pytest.mark.parametrize("board", ["router_3axis", "laser_xy", "mill_2004"])
def test_memory_stays_in_as_large_a_piece(board, show):
    done = subprocess.run(
        [MICROPYTHON, "-X", "heapsize=" + HEAP, CHECKS / "soak_memory.py", board, "100000", "10", "200"],
        env=interpreter.environment(*MODULE_PATH),
        capture_output=True, text=True, timeout=TIMEOUT_S,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-500:] + done.stderr
    largest = [BLOCK_BYTES * int(blocks) for blocks in re.findall(r"max free sz: (\d+)", done.stdout)]
    free = [int(count) for count in re.findall(r"free: (\d+)", done.stdout)]
    said = done.stdout.splitlines()[-1]
    steps = " ".join(str(size) for size in largest[::10])
    show(f"{board}: memory over 100 000 orders", f"in one piece {steps} bytes; free {free[0]} and {free[-1]}; {said}")
    assert len(largest) > 100 and min(largest) >= LEAST
    assert not re.search(r"error:(7|159)\b", said), said
    assert free[-1] >= free[SETTLED] - 2_000, "nothing grows"
