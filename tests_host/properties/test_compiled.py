"""Kernels as C on a PC hold what plain Python and viper hold: the digests, and the properties, under CPython by ctypes, and under
MicroPython as machine code of the PC."""

import math
import subprocess
import sys

import pytest
import tiers
from test_digest import CPYTHON, GOLDEN, HEX_JOBS, PULSES, digest, golden_of_gcode, golden_of_hex, hex_job, hex_of, job_of
from test_micropython import CHECKS, MICROPYTHON, MODULE_PATH, MODULES, ROOT

from host_tools import interpreter
from host_tools.prove.gcode_jobs import MACHINES, all_jobs
from host_tools.build import pc_kernels
from host_tools.build.pc_kernels import Library, compile_library, use_compiled
from host_tools.build.tree import unix_tree
from host_tools.drawings import order_viper
from host_tools.drawings.objects import objects
from host_tools.failure import Failure
from host_tools.kernels import module
from host_tools.kernels.program import Program

pytestmark = [
    pytest.mark.unmeasured, pytest.mark.xdist_group("compiled"),
    pytest.mark.skipif(pc_kernels.compiler_command() is None, reason="there is no C compiler for this PC"),
]  # fmt: skip
COMPILED = CHECKS / "compiled.py"
# Properties of kernels; the others are slow.
OF_KERNELS = (
    "check_arcs", "check_block", "check_circle", "check_dots", "check_drives", "check_following", "check_gantry", "check_gcode_parse", "check_grbl_motion",
    "check_hold", "check_independent", "check_kernels", "check_laser", "check_line", "check_motion", "check_plotter", "check_s_curve", "check_steps",
)  # fmt: skip
QUICK = ("check_block", "check_gcode_parse", "check_kernels", "check_line", "check_steps")
FEW = ["--few", f"--most={tiers.FEW}"]


def modules(quick=(), tried=OF_KERNELS):
    """Each module of properties, marked: slow, but for those that are `tried` with a commit."""
    marks = {name: [] if name in tried else pytest.mark.slow for name in MODULES} | dict.fromkeys(quick, pytest.mark.quick)
    return [pytest.param(name, marks=marks[name]) for name in MODULES]


@pytest.fixture
def in_c(monkeypatch):
    monkeypatch.setenv(pc_kernels.CHOICE, "c")


def jobs(folder):
    """(arguments of digest.py, golden digest) of a job of each language, short ones first."""
    golden = dict(line.split(" ", 1) for line in GOLDEN.read_text().splitlines())
    made = []

    def job(name, data, want, *more):
        (folder / name).write_bytes(data)
        made.append(([folder / name, *more], want))

    for name, (board, lines) in all_jobs().items():
        job(f"{name}.gcode", "".join(f"{line}\n" for line in lines).encode(), golden_of_gcode()[name], board)
    job("pulses.hex", hex_of(PULSES).encode(), golden_of_gcode()["pulses"], "lpt_router")
    for name in HEX_JOBS:
        job(f"{name}.hex", hex_job(name).encode(), golden_of_hex()[name], *HEX_JOBS[name][1:])
    for name, points in objects().items():
        job(f"{name}.bin", job_of([points]), golden[name].split())
    return made


@pytest.mark.quick
def test_digests_under_cpython(in_c, tmp_path):
    for arguments, want in jobs(tmp_path)[:: 9 if tiers.current == "check" else 1]:
        assert digest(CPYTHON, "digest.py", *arguments, script=COMPILED) == want, arguments[0].name


@pytest.mark.parametrize("checks", modules(QUICK))
def test_properties_under_cpython(in_c, checks):
    python = interpreter.python(ROOT / "firmware", *MODULE_PATH[1:], ROOT / "host_tools" / "shims")
    command = [*python, COMPILED, "micro_runner.py", *FEW, checks]
    done = subprocess.run(command, env=interpreter.environment(), capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def machine_code():
    """The firmware for MicroPython on this PC, its kernels compiled as C."""
    if not MICROPYTHON.exists() or module.find_compiler("x64") is None:
        pytest.skip("MicroPython here takes no machine code, or there is no compiler for it")
    return unix_tree(march="x64")


def test_digests_under_micropython(machine_code, tmp_path):
    for number, (arguments, want) in enumerate(jobs(tmp_path)):
        if number % 4 and arguments[0].stem not in MACHINES:
            continue
        assert digest(MICROPYTHON, *arguments, firmware=machine_code) == want, arguments[0].name


@pytest.mark.parametrize("checks", modules(tried=QUICK))
def test_properties_under_micropython(machine_code, checks):
    command = [MICROPYTHON, "-X", "heapsize=64m", CHECKS / "micro_runner.py", *FEW, checks]
    done = subprocess.run(command, env=interpreter.environment(machine_code, *MODULE_PATH[1:]), capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


# --- what C asks Python for

TEXT = """
import micropython
# `action` is usually passo.tried.usual

@micropython.viper
def usual(words: ptr32, number: int):
    words[0] = number

@micropython.viper
def kernel(thing, words, action, other) -> int:
    numbers = ptr32(words)
    action(numbers, int(thing.number) + 1)
    other(words, numbers[0])
    more = ptr32(thing.words)
    return int(thing.method(numbers[0], more[1])) + more[1]
"""


@pytest.fixture
def tried(tmp_path, monkeypatch):
    """(the text's kernel in C, as plain Python), and `usual` of each."""
    program = Program({"passo/tried.py": TEXT})
    monkeypatch.setattr(pc_kernels, "TAKEN", {"passo.tried.kernel", "passo.tried.usual"})
    monkeypatch.setattr(pc_kernels, "Program", lambda texts: program)
    pc_kernels._make_library({}, set(), pc_kernels.compiler_command(), tmp_path / "k.so", tmp_path / "k.json")
    made = Library(tmp_path / "k.so", pc_kernels.json.loads((tmp_path / "k.json").read_text()))
    space = {"ptr32": lambda numbers: numbers}
    exec(TEXT.replace("@micropython.viper", "").replace("import micropython", ""), space)
    functions = {name: made.caller_of(f"passo.tried.{name}", space[name]) for name in ("usual", "kernel")}
    return functions, space


class Thing:
    def __init__(self):
        self.number, self.words, self.seen = 41, pc_kernels.array.array("i", [7, 8, 9]), []

    def method(self, *values):
        self.seen.append(values)
        return sum(values)


@pytest.mark.quick
def test_objects_and_callbacks(tried):
    results = []
    for functions in tried:
        for action in (functions["usual"], lambda words, number: words.__setitem__(0, number * 2)):
            thing, words, seen = Thing(), pc_kernels.array.array("i", [1, 2, 3]), []
            for _ in range(400):  # more than are remembered
                result = functions["kernel"](thing, words, action, lambda *given: seen.append((list(given[0]), given[1])))
            words.extend([0] * 5000)  # it may lie elsewhere now
            result += functions["kernel"](thing, words, action, lambda *given: None)
            results.append((result, list(words), seen, thing.seen))
    assert results[:2] == results[2:]
    assert results[0][0] == 2 * (42 + 8 + 8) and results[1][1][0] == 84


@pytest.mark.quick
def test_what_a_callback_raises_comes_out_of_the_call(tried):
    thing, words = Thing(), pc_kernels.array.array("i", [1, 2, 3])
    with pytest.raises(ZeroDivisionError):
        tried[0]["kernel"](thing, words, tried[0]["usual"], lambda *given: 1 // 0)
    del thing.words
    with pytest.raises(AttributeError):
        tried[0]["kernel"](thing, words, tried[0]["usual"], lambda *given: None)
    thing.words = words
    assert tried[0]["kernel"](thing, words, tried[0]["usual"], lambda *given: None) == 42 + 2 + 2


@pytest.mark.quick
def test_without_a_compiler_kernels_stay_python(monkeypatch):
    monkeypatch.setattr(pc_kernels, "compiler_command", lambda: None)
    monkeypatch.setattr(pc_kernels.sys, "meta_path", list(sys.meta_path))
    for choice, wanted in (("plain", False), ("", False)):
        monkeypatch.setenv(pc_kernels.CHOICE, choice)
        use_compiled.cache_clear()
        assert use_compiled() == wanted
    monkeypatch.setenv(pc_kernels.CHOICE, "c")
    use_compiled.cache_clear()
    with pytest.raises(Failure, match="no C compiler"):
        use_compiled()
    use_compiled.cache_clear()
    assert compile_library() is None


@pytest.mark.quick
def test_each_kernel_that_is_taken_exists():
    texts = {path: (ROOT / "firmware" / path).read_text() for path in {full.rpartition(".")[0].replace(".", "/") + ".py" for full in pc_kernels.TAKEN}}
    assert pc_kernels.TAKEN <= Program(texts).kernels.keys()


@pytest.mark.parametrize("first, second", [(("apart",), ("apart", "improve")), (("apart", "improve"), ("apart",))])
def test_what_others_have_asked_for_before_changes_nothing(in_c, tmp_path, monkeypatch, first, second):
    monkeypatch.setattr(pc_kernels.modules, "CACHE", tmp_path)
    pc_kernels._kernels_of.cache_clear()
    for names in (first, second):
        made = pc_kernels.kernels_of(order_viper.__name__, *names)
        assert [name for name in names if getattr(made, name) is getattr(order_viper, name)] == []
    pc_kernels._kernels_of.cache_clear()


@pytest.mark.quick
def test_a_root_is_exact(in_c):
    """isqrt() of kernels for a PC: that of a double, cut off."""
    apart = pc_kernels.kernels_of("host_tools.drawings.order_viper", "apart").apart
    xs, ys = pc_kernels.array.array("i", [0, 0]), pc_kernels.array.array("i", [0, 0])
    for x in (0, 1, 2, 3, 46_340, 32_767, 2048, 4096, *range(2049, 32_767, 997)):
        for y in (0, 1, 2, x):
            xs[1], ys[1] = x, y
            if 2048 <= x <= 32_767:
                assert apart(xs, ys, 0, 1) == math.isqrt(x * x + y * y) << 4
            elif x < 2048:
                assert apart(xs, ys, 0, 1) == math.isqrt(x * x + y * y << 8)
