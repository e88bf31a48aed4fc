"""`passo stream` as a process of its own, killed at a random place of a program, and `passo resume` as another one."""

import random
import subprocess

import pytest

from running_router import Running

from host_tools import interpreter

MM = 320  # steps
LINES = 300
ROWS = [(5 + (row % 2) * 4 + 0.2 * column * (1 - 2 * (row % 2)), 5 + row * 0.5) for row in range(LINES // 20) for column in range(20)]
PROGRAM = "G21G90\nG1Z-1F1500\nM3S1000\n" + "".join(f"G1X{x:.2f}Y{y:.2f}F4000\n" for x, y in ROWS) + "M5\nM30\n"
KILLS = 12


def passo(*arguments):
    return [*interpreter.passo(), *map(str, arguments)]


def running():
    made = Running("fast", journal={"every_ms": 200})
    made.world.path = []
    return made


def cut(world):
    """Places in the order in which they were passed at full depth with the spindle on."""
    cutting = [row[1:4] for row in world.path if row[4]]
    depth = min([row[2] for row in cutting], default=0)
    return [row[:2] for row in cutting if row[2] == depth]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "part.nc"
    path.write_text(PROGRAM)
    board = running()
    try:
        subprocess.run(passo("stream", path, "--home", "--port", board.line.name), check=True, capture_output=True)
        passed = cut(board.world)
        assert len(passed) > 10_000
        return passed
    finally:
        board.close()


def killed(path, whole, seed):
    path.write_text(PROGRAM)
    row = random.Random(seed).uniform(5.2, ROWS[-1][1] - 2.0)
    board = running()
    try:
        process = subprocess.Popen(passo("stream", path, "--home", "--port", board.line.name), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        board.until(lambda: board.position()[1] > row * MM or process.poll() is not None)
        process.kill()
        killed_amid = process.wait() != 0
        before = len(cut(board.world))
        said = subprocess.run(passo("resume", path, "--yes", "--port", board.line.name), capture_output=True, text=True)
        passed = cut(board.world)
        assert said.returncode == 0, said.stderr
        assert board.position()[1] == round(ROWS[-1][1] * MM)
        assert set(whole) <= set(passed)
        again = len(passed) - len(set(passed)) - (len(whole) - len(set(whole)))
        assert set(passed) == set(whole) and again < 10, again
        return killed_amid and before < len(whole), said.stdout
    finally:
        board.close()


@pytest.mark.unmeasured
def test_a_killed_program(tmp_path, whole):
    amid, said = killed(tmp_path / "part.nc", whole, 1)
    assert not amid or "interrupted" in said


@pytest.mark.slow
def test_killed_programs(tmp_path, whole, show):
    found = [killed(tmp_path / "part.nc", whole, seed) for seed in range(2, 2 + KILLS)]
    show("passo stream killed", f"{sum(amid for amid, _ in found)} of {KILLS} amid the program")
    assert sum(amid for amid, _ in found) > KILLS // 2
