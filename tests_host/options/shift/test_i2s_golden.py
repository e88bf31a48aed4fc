"""Every golden job on an ESP32 whose motors hang on shift registers: its words as frames of a fake I2S, latched by a model of the
registers, against the words themselves. CPython only: some of the jobs last for minutes."""

import io

import check_i2s
import digest
import pytest
from check_i2s import assert_edges, bench, put, run
from fake_esp32 import chip
from host_tools.prove.gcode_jobs import all_jobs
from test_digest import HEX_JOBS, PICO_PULSES, PULSES, hex_job, hex_of, job_of

from passo.records import COUNT_MASK

from host_tools import boards
from host_tools.drawings.objects import objects

pytestmark = pytest.mark.unmeasured
RING = 4096
PULSE_JOBS = {"pulses": PULSES, "pico_pulses": PICO_PULSES}
# Short ones of each kind; the others take a minute together.
COMMON = ("triangle", "helices", "laser_raster", "pico_pulses", "keys", "torch_ramps")


class Spy(digest.Sink):
    """Keeps the words of a job: (ticks, levels)."""

    min_word_ticks = 2 * check_i2s.FRAME  # a pulse of one frame, and one between two

    def __init__(self):
        digest.Sink.__init__(self)
        self.words_seen = []

    def start(self):
        ring = self._ring
        for number in range(self._played, self._played + ((ring.head - self._played) & COUNT_MASK)):
            word = ring.words[number & ring.mask]
            self.words_seen.append((word >> self._layout.bits, word & self._layout.levels_mask))
        digest.Sink.start(self)


def job(name):
    """(layout, words) that the firmware makes of a golden job for a board whose drivers take what registers give."""
    spy = Spy()
    if name in objects():
        digest.digest(board("plotter_2014"), io.BytesIO(job_of([objects()[name]])), spy)
    elif name in all_jobs():
        where, lines = all_jobs()[name]
        digest.digest_lines(board(where), io.BytesIO("".join(f"{line}\n" for line in lines).encode()), spy)
    elif name in PULSE_JOBS:
        digest.digest_hex(board("lpt_router"), io.StringIO(hex_of(PULSE_JOBS[name])), spy)
    else:
        _, where, *ramps = HEX_JOBS[name]
        digest.digest_hex(board(where, bool(ramps)), io.StringIO(hex_job(name)), spy)
    return spy._layout, spy.words_seen


def board(name, ramps=False):
    data = digest.board_named(name, boards.load(name.partition("+")[0]))
    if data["drive"]["kind"] == "step_dir":
        data["drive"] = dict(data["drive"], pulse_us=4, setup_us=8, step_active=1)
    if ramps:
        data["planning"] = dict(data["planning"], independent_ramps=True)
    return data


def names():
    return [*objects(), *all_jobs(), *PULSE_JOBS, *HEX_JOBS]


@pytest.mark.parametrize("name", [n if n in COMMON else pytest.param(n, marks=pytest.mark.slow) for n in names()])
def test_a_golden_job_on_registers(name):
    """Each edge of STEP, DIR, coils and tool within half a frame of its word, none left out, none sooner than asked; so the path and
    the place at the end are those of the words."""
    layout, words = job(name)
    assert len(words) > 100
    ring, player, _, world = bench(50, layout=layout, outputs=list(range(layout.bits)), size=RING)
    world.attach = world.edges = lambda *rest: None
    chip.edges = chip.edges[:1]
    given = 0
    while given < len(words) or player.busy():
        count = min(len(words) - given, RING - 1 - (ring.head - player.words_played()))
        put(ring, layout, words[given : given + count])
        given += count
        player.start()
        player.pump()
        chip.stall(2000)
    run(player, 24_000)
    assert player.under_runs == 0 and player.words_played() == len(words)
    assert_edges(name, words, layout, player.min_word_ticks)
