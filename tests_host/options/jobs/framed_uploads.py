"""Stored jobs in frames over a noisy wire, in each language, by `passo jobs` itself.

    round_of("pulses", folder, seed)    # stores, lists, runs and deletes; raises whatever went wrong, Stalled if it has no end
    killed_in("pulses", folder, seed)   # the PC is killed amid an upload, and begins again
"""

import contextlib
import io
import random

from host_tools import boards
from host_tools.cli import jobs, pulses
from host_tools.clients.refusal import Refused
from host_tools.programs import drawing_progress, stored_job
from host_tools.sim.machine import VirtualMachine
from passo.options.jobs import config as job_store
from virtual_wire import Killed, plugged

SHARE = 0.01
BOARDS = {"grbl": "router_3axis", "pulses": "lpt_router", "plotter": "plotter_2014"}
BAUD = 115_200


def board(language):
    made = boards.load(BOARDS[language])
    made["links"][0].update(frames=True, lost="go_on")
    made["jobs"] = {"language": language}
    if language == "plotter":
        made["homing"].update(seek_steps_s=4000, locate_steps_s=500)
        made["speed"].update(overhead_us=0, default=100, min=50)
    if language == "grbl":
        made["homing"].update(seek_steps_s=20_000)
    return made


def text(language, dice, lines):
    """Return a job of `lines` lines, codes or points, which deflate badly."""
    if language == "grbl":
        places = ("G1X%.3fY%.3f" % (dice.uniform(1, 6), dice.uniform(1, 6)) for _ in range(lines))
        return ("G21G90F5000\n" + "\n".join(places) + "\nM30\n").encode()
    if language == "pulses":
        return ("[+600 " + "".join(dice.choice("ABCDEFGHIJKL") for _ in range(40 * lines)) + "]").encode()
    return drawing_progress.packets_of([[(True, dice.randint(10, 200), dice.randint(10, 200)) for _ in range(lines)]], True)


class Round:
    def __init__(self, language, folder, seed, share=SHARE, framed=True):
        self.dice = random.Random(f"{language} {seed}")
        self.language = language
        self.seed = seed
        self.wire = framed, share
        self.machine = VirtualMachine(board(language), start=(400, 300, -200)[: 2 if language == "plotter" else 3])
        self.machine.cycle()
        self.machine.take()
        self.file = folder / f"{seed}.job"
        self.file.write_bytes(text(language, self.dice, self.dice.randint(4, 60)))
        self.at = {"port": "virtual", "baud": BAUD, "protocol": language}

    def store(self, cycles=None, name="PART"):
        with self.pc(cycles):
            jobs.store(self.file, name, language=None, card=None, check=False, **self.at)

    @contextlib.contextmanager
    def pc(self, cycles=None):
        self.seed += 1000
        with contextlib.redirect_stdout(io.StringIO()), plugged(self.machine, cycles, *self.wire, self.seed) as wire:
            yield wire
        self.machine.run_ms(20)

    def check(self):
        """The file on the board is the job, whole."""
        store = job_store.JobStore(self.machine.port.folder)
        assert [entry[0] for entry in store.list_jobs()] == ["PART"], store.list_jobs()
        job = store.open("PART")
        view, found = memoryview(bytearray(512)), b""
        while count := job.readinto(view):
            found += bytes(view[:count])
        job.close()
        assert found == stored_job.KINDS[self.language][0](self.file)


def round_of(language, folder, seed):
    made = Round(language, folder, seed)
    made.store()
    made.check()
    with made.pc():
        jobs.list_(**made.at)
    with made.pc():
        jobs.run("PART", home=language != "pulses", wait=True, **made.at)
    made.machine.settle()
    with made.pc():
        jobs.delete("PART", **made.at)
    assert not job_store.JobStore(made.machine.port.folder).list_jobs()
    with made.pc():
        try:
            jobs.run("PART", home=False, wait=True, **made.at)
        except Refused as refused:
            assert "150" in str(refused)
        else:
            raise AssertionError("a job that is not there has run")
    made.machine.close()


def played(language, folder, seed):
    """A pulse file is loaded and played, then a longer one is streamed, which waits for room: step by step as over a clean wire."""
    assert language == "pulses"
    paths = []
    for framed, share in ((False, 0.0), (True, SHARE)):
        made = Round(language, folder, seed, share, framed)
        for stream in (False, True):
            with made.pc():
                pulses.play(made.file, 1, None, stream, None, False, wait=True, log=None, port="virtual", baud=BAUD)
            made.file.write_bytes(text(language, made.dice, 400))
        paths.append([row[1:] for row in made.machine.trace.rows()])
        made.machine.close()
    assert len(paths[0]) > 10_000, len(paths[0])
    assert paths[0] == paths[1], [(at, *rows) for at, rows in enumerate(zip(*paths)) if rows[0] != rows[1]][:3]


def killed_in(language, folder, seed):
    """True if it was amid the upload."""
    made = Round(language, folder, seed)
    try:
        made.store(made.dice.randrange(400))
        amid = False
    except Killed:
        amid = True
    made.machine.run_ms(made.dice.choice((0, 30, 300, 3000)))
    made.store()
    made.check()
    made.machine.close()
    return amid
