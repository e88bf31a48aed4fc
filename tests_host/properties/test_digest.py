"""The step words of drawings and programmes: the same digest under CPython and MicroPython, and the same as ever.

tests_host/golden/digests.txt holds `name digest words stepping` of the five objects of `make run`; gcode_digests.txt
holds `name digest words stepping marks refused` of host_tools/prove/gcode_jobs.py and of the corpus; hex_digests.txt, as digests.txt, of
bytes sent to machines of other languages. If a change of the words is meant,
write the new lines there: PASSO_GOLDEN=write does it for the G-code. To see what changed, compare `passo plot` of two
traces, or print the words in `Sink.start`.
"""

import os
import subprocess
from pathlib import Path

import pytest

from host_tools import interpreter
from host_tools.build.constants import fold_constants
from host_tools.build.tree import FIRMWARE, module_files
from host_tools.drawings.objects import objects
from host_tools.kernels.inline import inline_kernels
from host_tools.prove.gcode_jobs import all_jobs, backlash_job, star
from test_micropython import CHECKS, MICROPYTHON, MODULE_PATH, ROOT, TESTS, needs_micropython

pytestmark = pytest.mark.unmeasured
GOLDEN = TESTS / "golden" / "digests.txt"
HEX_GOLDEN = TESTS / "golden" / "hex_digests.txt"
GCODE_GOLDEN = TESTS / "golden" / "gcode_digests.txt"
CORPUS_STEPS_MM = 10  # instead of the router's 320: its files are large
SHIMS = ROOT / "host_tools" / "shims"
CPYTHON = "CPython"


def job_of(drawings):
    """The packets that draw a list of objects at the speed of `make run`."""
    from passo.protocols.plotter.host import COMMANDS, packet

    data = packet(COMMANDS["SPEED"], 1000)
    for points in drawings:
        for pen, x, y in points:
            data += packet(COMMANDS["LINE" if pen else "MOVE"], x, y)
        data += packet(COMMANDS["END"])
    return data


def golden_of_gcode():
    """{name: [digest, words, stepping, marks, refused]}"""
    return {line.split()[0]: line.split()[1:] for line in GCODE_GOLDEN.read_text().splitlines()}


def compare_gcode(name, *job):
    """The programme's digest on both interpreters, and in the golden file."""
    made = digest(CPYTHON, *job)
    if os.environ.get("PASSO_GOLDEN") == "write":
        golden = {**(golden_of_gcode() if GCODE_GOLDEN.exists() else {}), name: made}
        GCODE_GOLDEN.write_text("".join(f"{name} {' '.join(golden[name])}\n" for name in sorted(golden)))
    assert made == golden_of_gcode()[name]
    if MICROPYTHON.exists():
        assert digest(MICROPYTHON, *job) == made


def digest(program, *job, firmware=None, script=CHECKS / "digest.py"):
    """(hex digest, words, stepping words …) of a job (see digest.py's arguments), as `program` computes them."""
    firmware = firmware or (MODULE_PATH[0] if program == MICROPYTHON else ROOT / "firmware")
    folders = firmware, *MODULE_PATH[1:]
    program = [MICROPYTHON, "-X", "heapsize=64m"] if program == MICROPYTHON else interpreter.python(*folders, SHIMS)
    done = subprocess.run([*program, script, *job], env=interpreter.environment(*folders), capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.split()


@pytest.fixture(scope="module")
def jobs(tmp_path_factory):
    """{name: file of packets} of everything that `make run` draws."""
    from host_tools.cli import run

    folder = tmp_path_factory.mktemp("jobs")
    files = {}
    for name, drawings in run.create_jobs(folder).items():
        files[name] = folder / f"{name}.bin"
        files[name].write_bytes(job_of(drawings))
    return files


@pytest.mark.quick
def test_digests_are_those_of_the_golden_file(jobs):
    lines = [" ".join([name, *digest(CPYTHON, jobs[name])]) for name in objects()]
    assert lines == GOLDEN.read_text().split("\n")[:-1]


@needs_micropython
def test_both_interpreters_make_the_same_words(jobs):
    assert len(jobs) > len(objects())
    for name, job in jobs.items():
        assert digest(MICROPYTHON, job) == digest(CPYTHON, job), name


def test_what_a_board_gets_makes_the_same_words(jobs, tmp_path):
    """With numbers for constants, short names for attributes and arguments, and short kernels where others call them."""
    sources = {path.as_posix(): FIRMWARE / path for path in module_files()}
    sources["digest.py"] = CHECKS / "digest.py"
    for path, text in inline_kernels(fold_constants({path: source.read_text(encoding="utf-8") for path, source in sources.items()})).items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text, encoding="utf-8")
    board, lines = all_jobs()["pico"]
    job = tmp_path / "job.gcode"
    job.write_text("".join(f"{line}\n" for line in lines))
    where = {"firmware": tmp_path, "script": tmp_path / "digest.py"}
    assert digest(CPYTHON, job, board, **where) == golden_of_gcode()["pico"]
    triangle = digest(CPYTHON, jobs["triangle"], **where)
    assert " ".join(["triangle", *triangle]) in GOLDEN.read_text().splitlines()


def test_a_job_that_differs_by_one_step_has_another_digest(tmp_path):
    digests = set()
    for x in (100, 101):
        job = Path(tmp_path / "job.bin")
        job.write_bytes(job_of([[(True, x, 50)]]))
        digests.add(digest(CPYTHON, job)[0])
    assert len(digests) == 2


@pytest.mark.quick
@pytest.mark.parametrize("name", all_jobs())
def test_gcode(tmp_path, name):
    board, lines = all_jobs()[name]
    job = tmp_path / "job.gcode"
    job.write_text("".join(f"{line}\n" for line in lines))
    compare_gcode(name, job, board)


@pytest.mark.quick
def test_two_motors_on_one_belt(tmp_path):
    job = tmp_path / "job.gcode"
    job.write_text("".join(f"{line}\n" for line in star()))
    compare_gcode("star", job, "corexy_plotter")


@pytest.mark.quick
def test_lost_motion(tmp_path):
    job = tmp_path / "job.gcode"
    job.write_text("".join(f"{line}\n" for line in backlash_job()))
    compare_gcode("play", job, "router_ballscrew")


# Played forward, back from the middle and forward again, twice, and then streamed.
PULSES = [
    "{load}\n[+1000(" + "A" * 90 + "*7" + "GHIJ" * 20 + ")+2200", "KLMNOPQR" * 20 + "($STUVWXYZ" * 10 + "@)" + "CD" * 40,
    "+333" + "E" * 30 + "]{end}", "{run 2}", "{back}", "{step}", "{step}", "{jog x 40 y -30}", "{return}",
    "{stream}\n+1500(" + "AC" * 120 + ")" + "B" * 200 + "{end}",
]  # fmt: skip


PICO_PULSES = ["{load}\n[+2000(" + "AGHIJ" * 6 + ")" + "K" * 30 + "*3S{end}", "{run}", "{back}"]


def hex_of(lines):
    return "".join(line.encode().hex() + "\n" for line in lines)


@pytest.mark.quick
@pytest.mark.parametrize("name, lines", [("pulses", PULSES), ("pico_pulses", PICO_PULSES)])
def test_pulses(tmp_path, name, lines):
    job = tmp_path / "job.hex"
    job.write_text(hex_of(lines))
    compare_gcode(name, job, "lpt_router")


@pytest.mark.slow
def test_gcode_of_the_corpus(corpus):
    files = sorted(corpus.glob("*.gcode"))
    assert files
    for file in files:
        compare_gcode(file.name, file, "router_3axis", str(CORPUS_STEPS_MM))


def frames_of_torch():
    """Moves of unlike axes, jogs held, a configuration, a stop on the way; each line as digest.py takes it."""
    from passo.protocols.torch import protocol as torch

    jog = [(torch.frame("JOG_Y-"), 60)] * 5
    return [
        (torch.frame("CONNECT"), None), (torch.move(700, 480, 2000, -833), None), (torch.move(0, 0, 31, 7), None),
        (torch.move(5000, -11_999, 9000, 20_000), 150), (torch.frame("STOP"), None), *jog,
        (torch.configure(100, 333, 2001, -999), None), (torch.frame("JOG_X+"), 20), (torch.frame("JOG_X+"), None),
        (torch.move(1, 1, 1, -1), None),
    ]  # fmt: skip


def keys_of_the_kit():
    """Both motors at unlike speeds, live changes, one off and on again while the other turns."""
    return [
        (b"C", 30), (b"A\x05", 20), (b"D", 7), (b"B\x7f", 10), (b"G", 11), (b"HG", 9), (b"E", 13), (b"B\x02\x00z", 12),
        (b"CB\x03", 25), (b"F", 8), (b"I", 15), (b"J", None), (b"I", 6), (b"J", None),
    ]  # fmt: skip


HEX_JOBS = {
    "keys": (keys_of_the_kit, "two_motor_kit"),
    "torch": (frames_of_torch, "torch_manipulator"),
    "torch_ramps": (frames_of_torch, "torch_manipulator", "ramps"),
}


def hex_job(name):
    """The file of a job, as digest.py takes it."""
    return "".join(data.hex(" ") + (f" @{turns}" if turns else "") + "\n" for data, turns in HEX_JOBS[name][0]())


def golden_of_hex():
    """{name: [digest, words, stepping]}"""
    return {line.split()[0]: line.split()[1:] for line in HEX_GOLDEN.read_text().splitlines()}


@pytest.mark.quick
@pytest.mark.parametrize("name", HEX_JOBS)
def test_bytes_of_other_languages(tmp_path, name):
    _, *options = HEX_JOBS[name]
    job = tmp_path / "job.hex"
    job.write_text(hex_job(name))
    made = digest(CPYTHON, job, *options)
    assert made == golden_of_hex()[name]
    if MICROPYTHON.exists():
        assert digest(MICROPYTHON, job, *options) == made
