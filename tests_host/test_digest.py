"""The step words of `make run`'s drawings: the same digest under CPython and MicroPython, and the same as ever.

tests_host/golden/digests.txt holds `name digest words stepping` of the five objects. If a change of the words is meant,
write the new lines there; to see what changed, compare `passo plot` of two traces, or print the words in `Sink.start`.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from host_tools import run
from host_tools.objects import objects
from passo.protocols.plotter import COMMANDS, packet
from test_micropython import MICROPYTHON, MODULE_PATH, ROOT, TESTS, needs_micropython

GOLDEN = TESTS / "golden" / "digests.txt"
SHIMS = ROOT / "host_tools" / "shims"


def job_of(drawings):
    """The packets that draw a list of objects at the speed of `make run`."""
    data = packet(COMMANDS["SPEED"], 1000)
    for points in drawings:
        for pen, x, y in points:
            data += packet(COMMANDS["LINE" if pen else "MOVE"], x, y)
        data += packet(COMMANDS["END"])
    return data


def digest(program, job):
    """(hex digest, words, stepping words) of a job's file, as `program` computes them."""
    path = os.pathsep.join(str(folder) for folder in MODULE_PATH)
    environment = {**os.environ, "MICROPYPATH": path, "PYTHONPATH": os.pathsep.join([path, str(SHIMS)])}
    command = [program, TESTS / "digest.py", job]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.split()


@pytest.fixture(scope="module")
def jobs(tmp_path_factory):
    """{name: file of packets} of everything that `make run` draws."""
    folder = tmp_path_factory.mktemp("jobs")
    files = {}
    for name, drawings in run.jobs(folder).items():
        files[name] = folder / f"{name}.bin"
        files[name].write_bytes(job_of(drawings))
    return files


def test_digests_are_those_of_the_golden_file(jobs):
    lines = [" ".join([name, *digest(sys.executable, jobs[name])]) for name in objects()]
    assert lines == GOLDEN.read_text().split("\n")[:-1]


@needs_micropython
def test_both_interpreters_make_the_same_words(jobs):
    assert len(jobs) > len(objects())
    for name, job in jobs.items():
        assert digest(MICROPYTHON, job) == digest(sys.executable, job), name


def test_a_job_that_differs_by_one_step_has_another_digest(tmp_path):
    digests = set()
    for x in (100, 101):
        job = Path(tmp_path / "job.bin")
        job.write_bytes(job_of([[(True, x, 50)]]))
        digests.add(digest(sys.executable, job)[0])
    assert len(digests) == 2
