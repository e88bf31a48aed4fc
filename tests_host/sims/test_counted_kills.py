"""Pulse programs interrupted at random, by everything that may fail: `passo resume` ends them with the same picture."""

import tempfile
from collections import Counter
from pathlib import Path

import pytest

from counted_kills import EVERY_MS, LOST_MS, Job, kill, resumed, whole
from host_tools import boards
from host_tools.cli import jobs, pulses

# Down, an outline with diagonals, a wait, another speed, up. It begins and ends elsewhere, and crosses nothing.
CODES = (
    "[+2400 " + "F" * 80 + "(" + "A" * 700 + "G" * 400 + "C" * 300 + "*120 " + "I" * 350 + "+1500 " + "B" * 700 + "J" * 200 + ")"
    + "E" * 80 + "A" * 9 + "]"
)  # fmt: skip


class Pulses(Job):
    name = "pulses"
    near = False
    twice = 0
    steps_s = 3200
    start = (4000, 4000, 3000)

    def __init__(self, folder, way):
        self.file = folder / "part.txt"
        self.file.write_text(CODES)
        self.way = way
        self.alone = way == "job"
        self.name = f"pulses {way}"

    def board(self):
        made = boards.load("lpt_router")
        made["journal"] = {"every_ms": EVERY_MS}
        made["links"][0].update(lost="stop", lost_ms=LOST_MS)
        if self.way == "job":
            made["jobs"] = {"language": "pulses"}
        return made

    def begin(self, machine, rng):
        where = {"port": "virtual", "baud": 115200}
        if self.way == "job":
            jobs.store(self.file, protocol="pulses", name="PART", language=None, **where)
            jobs.run("PART", home=False, wait=True, protocol="pulses", **where)
        else:
            pulses.play(self.file, 1, None, self.way == "stream", None, False, wait=True, log=None, **where)

    def resume(self, home, unverified):
        resumed(self, home, unverified)


@pytest.mark.parametrize("way", ("stream", "stored", "job"))
def test_pulse_programs_are_gone_on_with(way, tmp_path):
    job = Pulses(tmp_path, way)
    facts = whole(job)
    for seed in range(2):
        kill(job, seed, *facts)


@pytest.mark.slow
@pytest.mark.parametrize("way", ("stream", "stored", "job"))
def test_pulse_programs_fifty_times(way, tmp_path):
    job = Pulses(tmp_path, way)
    facts = whole(job)
    kinds = Counter(kill(job, seed, *facts)[0] for seed in range(100, 150))
    assert len(kinds) == 4, kinds
