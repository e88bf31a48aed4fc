"""Machine code on other cores than the Pico's: the digests of jobs of every language, and the properties, on MicroPython's qemu
port for RV32IMC (the ESP32-C3's instructions) and for Thumb-2 (near the RP2350's), kernels compiled as C and by viper. How to build
it: qemu.py."""

import pytest
import tiers
from expressions import EDGES, checksums, module_for, target_code
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from qemu import CORES, INSTRUCTION_CLOCK, TESTS, Core, image_of, missing, packed

from host_tools.prove.gcode_jobs import MACHINES, all_jobs
from host_tools.drawings.objects import objects
from host_tools.kernels import module
from test_pico_frames import PREPARE
from test_digest import GOLDEN, HEX_JOBS, PICO_PULSES, PULSES, golden_of_gcode, golden_of_hex, hex_job, hex_of, job_of

pytestmark = pytest.mark.unmeasured
MODULES = sorted(path.stem for path in (TESTS / "properties").glob("check_*.py"))
# Bytes of heap that what a check writes down wants, where it is more than 1.5 MB.
HEAP = {"check_chords": 8_000_000, "check_feed": 3_000_000, "check_grbl_tool": 8_000_000, "check_hold": 8_000_000}
HEAP.update({"check_backlash": 8_000_000, "check_corexy": 8_000_000, "check_four_axes": 8_000_000, "check_motion": 8_000_000, "check_s_curve": 8_000_000})
WITHOUT = dict.fromkeys(("check_board_jobs", "check_board_page", "check_pages", "check_radio"), "sockets") | {"check_http": "os.urandom"}  # not on the core
WITHOUT |= {f"check_panel_{name}": "host_tools, which is not on the core" for name in ("keys", "plotter", "torch")}
FRAMES_MODULE = "from passo.ports.esp32 import frames_viper as kernel\n"
BLOCK, BLOCKS = 256, 4000
ESP32_CYCLES = 240_000_000 // 250_000  # a frame
PULSE_JOBS = {"pulses": PULSES, "pico_pulses": PICO_PULSES}


def jobs():
    """{path: bytes} of every job of which there is a golden digest but the corpus."""
    files = {f"jobs/{name}.bin": job_of([points]) for name, points in objects().items()}
    files |= {f"jobs/{name}.gcode": "".join(f"{line}\n" for line in lines).encode() for name, (_, lines) in all_jobs().items()}
    files |= {f"jobs/{name}.hex": hex_job(name).encode() for name in HEX_JOBS}
    return files | {f"jobs/{name}.hex": hex_of(lines).encode() for name, lines in PULSE_JOBS.items()}


SLOW_CORES = [pytest.param(name, marks=pytest.mark.slow) for name in ("arm-c", "rv32-viper", "arm-viper")]


@pytest.fixture(scope="module", params=("rv32-c", *SLOW_CORES))
def core(request, tmp_path_factory):
    """A core, with kernels compiled as C or by viper."""
    name, _, by = request.param.partition("-")
    kind = CORES[name]
    why = missing(kind) or (by == "c" and module.find_compiler(kind.march) is None and "there is no compiler for kernels: pip install ziglang")
    if why:
        pytest.skip(why)
    made = Core(kind, image_of(kind, jobs(), tmp_path_factory.mktemp("core"), by == "c"))
    made.in_c = by == "c"
    return made


def digest(core, *arguments):
    return core.run(f"import digest\ndigest.main({list(arguments)!r})").split()


def golden(name):
    rows = dict(line.split(" ", 1) for line in GOLDEN.read_text().splitlines())
    if name in rows:
        return rows[name].split()
    return golden_of_hex()[name] if name in HEX_JOBS else golden_of_gcode()[name]


@pytest.mark.xdist_group("qemu")
def test_a_programme_of_each_language(core):
    """Drawings, G-code (lines, arcs, S-curves, a laser, canned cycles …), pulse files, frames of the torch and keys; with a commit every
    third of the drawings and of G-code, and four axes, CoreXY and lost motion."""
    left_out = 0
    for path in jobs():
        name, _, kind = path.removeprefix("jobs/").partition(".")
        left_out += kind in ("bin", "gcode")
        if tiers.current != "all" and kind in ("bin", "gcode") and left_out % 3 and name not in MACHINES:
            continue
        arguments = [f"/rom/{path}"]
        if kind == "gcode":
            arguments.append(all_jobs()[name][0])
        elif name in PULSE_JOBS:
            arguments.append("lpt_router")
        elif kind == "hex":
            arguments += HEX_JOBS[name][1:]
        assert digest(core, *arguments) == golden(name), name


@pytest.mark.xdist_group("qemu")
def test_kernels_are_machine_code(core):
    """Not the text as bytecode: on a core that had refused it, digests would say nothing of it."""
    said = core.run("from passo.motion import line_viper\nprint(type(line_viper.walk) is type(lambda: 0), type(line_viper.walk))")
    assert said.startswith("False"), said
    assert core.run("import os\nprint('kernels_steps.mpy' in os.listdir('/rom/passo'))") == f"{core.in_c}\n"


@pytest.mark.xdist_group("qemu")
@pytest.mark.parametrize("core", ["rv32-viper", pytest.param("arm-viper", marks=pytest.mark.slow)], indirect=True)
def test_three_axes_at_60_khz_fit_an_esp32(core, show):
    """Instructions of the kernel that makes frames for the I2S, by viper: an ESP32 has nothing else. An instruction of Xtensa is assumed to do as much, in two cycles
    at most: its loads and taken branches have two or three, all else one, and RAM has no wait states."""
    found = []
    for what, ticks in (("at rest", 0), ("three axes in step, 60 kHz", 208), ("a word every other frame, the most", 100)):
        code = FRAMES_MODULE + PREPARE.replace("import frames_viper as kernel\n", "") + f"begin({ticks})\ntook({BLOCK})"
        took_us = int(core.run(code.replace("range(40)", f"range({BLOCKS})"), options=INSTRUCTION_CLOCK))
        found.append((what, took_us * 1000 / BLOCKS / BLOCK))
    lines = ["%-36s %6.1f instructions a frame, %4.1f %% of an ESP32" % (what, n, 200 * n / ESP32_CYCLES) for what, n in found]
    show(f"frames of the I2S, on {core.kind.machine[1]}", "\n".join(lines))
    assert 2 * found[1][1] < ESP32_CYCLES / 3


# The result of a module that looks for the address of an array's numbers: none that it knows.
STRANGE_ARRAYS = """
import array, sys
class Strange:
    @staticmethod
    def array(code, numbers):
        return array.array(code, numbers)
sys.modules["array"] = Strange
import kernels_tried
sys.modules["array"] = array
"""
EDGE_PAIRS = [(a, b, 0) for a in EDGES for b in EDGES]
triples = st.lists(st.tuples(*[st.integers(-(1 << 31), (1 << 31) - 1)] * 3), min_size=60, max_size=60)


@pytest.mark.xdist_group("qemu")
@pytest.mark.parametrize("name", [pytest.param(name, marks=() if name == "rv32" else pytest.mark.slow) for name in CORES])
def test_operators_of_compiled_kernels(name, tmp_path_factory):
    """At each pair of edges, and of numbers at random, as CPython has it, while nothing may be allocated; also if arrays are not what
    the module knows."""
    kind = CORES[name]
    if missing(kind) or module.find_compiler(kind.march) is None:
        pytest.skip(missing(kind) or f"there is no compiler of kernels for {kind.march}")
    unit, data = module_for(kind.march)
    core = Core(kind, packed({"kernels_tried.mpy": data}, tmp_path_factory.mktemp("operators")))

    @settings(max_examples=4 if tiers.current == "all" else 1, suppress_health_check=list(HealthCheck))
    @example(EDGE_PAIRS)
    @given(triples)
    def run(triples):
        assert core.run(target_code(unit, triples)) == checksums(triples)

    run()
    assert core.run(STRANGE_ARRAYS + target_code(unit, EDGE_PAIRS[:9])) == checksums(EDGE_PAIRS[:9])


@pytest.mark.slow
@pytest.mark.xdist_group("qemu")
@pytest.mark.parametrize("checks", MODULES)
def test_properties(core, checks):
    """Few examples of each: it runs some hundred times slower than the chip."""
    if checks in WITHOUT:
        pytest.skip(f"{checks} wants {WITHOUT[checks]}")
    free = int(core.run("gc.collect()\nprint(gc.mem_free())"))
    if free < HEAP.get(checks, 0):
        pytest.skip(f"{checks} wants {HEAP[checks]} bytes of heap, the build has {free}")
    said = core.run(f"import micro_runner\nprint(micro_runner.main(['--few', '--most={tiers.FEW}', {checks!r}]))")
    assert " 0 failed" in said, said
