"""Kernels as C: each that is accepted computes as CPython does with 32 bits that wrap, under gcc's sanitiser; all others are refused."""

import ast
import builtins
import ctypes
import re
import shutil
import signal
import struct
import subprocess
import symtable
from array import array
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from expressions import EDGES, expected, expressions, kernels_text, wrapped
from host_tools import boards, interpreter
from host_tools.build import frozen, mpy, ship, tree
from host_tools.failure import Failure
from host_tools.kernels import build, module, translate
from host_tools.kernels.build import RUNTIME, compile_kernels
from host_tools.kernels.program import Program
from host_tools.kernels.unit import Unit
from passo.config.boardfile import check

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
EXPRESSIONS = expressions()
MARCHES = [march for march in module.ARCHITECTURE if module.find_compiler(march)]
numbers = st.one_of(st.sampled_from(EDGES), st.integers(-(1 << 31), (1 << 31) - 1))

TEXT = '''
import micropython

@micropython.viper
def elements(bytes_: ptr8, halves: ptr16, words: ptr32, value: int) -> int:
    bytes_[0] = value
    halves[1] = value
    words[2] = value
    words[1] += bytes_[0]
    words[0] -= halves[1]
    return bytes_[0] + halves[1] + words[2]

@micropython.viper
def add(words: ptr32, at: int) -> int:
    words[at] = words[at] + 1
    return words[at]

@micropython.viper
def flow(words: ptr32, count: int, wanted: int) -> int:
    found = 0 - 1
    for i in range(count):
        if words[i] == wanted and found < 0:
            found = i
            continue
        elif words[i] > wanted or not words[i]:
            words[i] -= add(words, i) * 2 + words[i]
    for i in range(add(words, 0) & 1, add(words, 0) & 7):
        if i >= count:
            break
        words[i] += i * add(words, i)
    for i in range(1, count):
        if i > 3:
            break
        words[0] ^= i
    left = count
    while left > 0:
        left -= 1
        if left == 2:
            break
        words[left] = words[left] - add(words, left) * words[left]
    a = b = left
    return found * 1000 + a * 10 + b if found != 5 else 7
'''


def unit_of(text):
    program = Program({"passo/tried.py": text})
    return Unit(program, list(program.kernels.values()))


@pytest.fixture(scope="module")
def native(tmp_path_factory):
    """Return the text's kernels, compiled for this PC; behaviour that C leaves undefined ends the process."""
    folder = tmp_path_factory.mktemp("kernels")
    (folder / "k.c").write_text(unit_of(TEXT + kernels_text()).text(RUNTIME).replace("static int32_t tried", "int32_t tried").replace("static void tried", "void tried"))
    options = "-std=gnu11 -fwrapv -fno-strict-aliasing -O2 -w -shared -fPIC -fsanitize=undefined,signed-integer-overflow -fsanitize-undefined-trap-on-error"
    subprocess.run(["gcc", *options.split(), "-o", folder / "k.so", folder / "k.c"], check=True)
    return ctypes.CDLL(str(folder / "k.so"))


def buffer(values):
    return (ctypes.c_int32 * len(values)).from_buffer(values)


@needs_gcc
@given(numbers, numbers, numbers)
@example(-(1 << 31), -1, 0)
@example(7, -(1 << 31), 32)
def test_operators(native, a, b, c):
    answers = array("i", [0] * len(EXPRESSIONS))
    native.tried_all_of(buffer(array("i", [a, b, c])), 1, buffer(answers))
    assert dict(zip(EXPRESSIONS, answers)) == dict(zip(EXPRESSIONS, expected([(a, b, c)])))


@needs_gcc
def test_operators_at_every_pair_of_edges(native):
    pairs = [(a, b, 0) for a in EDGES for b in EDGES]
    answers = array("i", [0] * len(pairs) * len(EXPRESSIONS))
    native.tried_all_of(buffer(array("i", [each for pair in pairs for each in pair])), len(pairs), buffer(answers))
    assert answers == expected(pairs)


@needs_gcc
@given(numbers)
def test_elements_of_arrays(native, value):
    bytes_, halves, words = bytearray(4), array("H", [0] * 2), array("i", [5, 6, 7])
    given = (ctypes.c_uint8 * 4).from_buffer(bytes_), (ctypes.c_uint16 * 2).from_buffer(halves), buffer(words)
    result = native.tried_elements(*given, value)
    assert (bytes_[0], halves[1], words[2]) == (value & 255, value & 65535, value)
    assert (words[0], words[1]) == (5 - (value & 65535), 6 + (value & 255))
    assert result == wrapped((value & 255) + (value & 65535) + value)


@needs_gcc
@given(st.lists(st.integers(-9, 9), min_size=6, max_size=6), st.integers(0, 6), st.integers(-9, 9))
def test_flow_and_order(native, values, count, wanted):
    space = {"ptr8": None, "ptr16": None, "ptr32": None}
    exec(TEXT.replace("@micropython.viper", "").replace("import micropython", ""), space)
    mine, theirs = array("i", values), array("i", values)
    assert native.tried_flow(buffer(theirs), count, wanted) == space["flow"](mine, count, wanted)
    assert mine == theirs


@needs_gcc
@pytest.mark.parametrize("bytes_off, ends", [(0, 0), (4, 0), (1, -signal.SIGILL), (2, -signal.SIGILL)])
def test_an_unaligned_access_ends_the_process(native, bytes_off, ends):
    """Under the sanitiser; on the emulated Pico it is a fault, as on the chip (test_pico_kernels.py)."""
    code = f"import ctypes\nk = ctypes.CDLL({native._name!r})\nb = (ctypes.c_int32 * 8)()\n"
    code += f"k.tried_add(ctypes.c_void_p(ctypes.addressof(b) + {bytes_off}), 1)"
    assert subprocess.run([*interpreter.python(), "-c", code]).returncode == ends


REFUSED = {
    "x = 1.5": "whole numbers only",
    "x = y = n + 1": "assign a number or a name",
    "x = [n]": "numbers, arrays, calls and attributes only",
    "x = 'a'": "whole numbers only",
    "x = n / 2": "operators are",
    "x = n ** 2": "operators are",
    "x = n and 3": "as a value",
    "x = 1 << 40 if n else 0x100000000": "more than 32 bits",
    "x = what": "no local, no argument and no constant",
    "x = n\n    x = o.name": "is int",
    "x = o + 1": "write int(…)",
    "if o:\n        n += 1": "is an object",
    "for x in o:\n        n += 1": "range",
    "try:\n        n += 1\n    except ValueError:\n        n = 2": "statements are",
    "x = n[0]": "is no array",
    "x = len(w)": "kernels call kernels",
    "x = other(n)": "takes 2 arguments",
    "x = other(n, n)": "write ptr32(…)",
    "x = other(n, w=w)": "by their places",
    "x = 1 if 0 < other(n, w) < 3 else 0": "between two comparisons",
    "x = n in w": "comparisons are of numbers",
    "x = n is None": "comparisons are of numbers",
    "x = o if n else 3": "one is a number, the other an object",
    "x = n.high": "give it as an argument without a type",
    "o.high = n": "for each variable",
    "x = w[1:2]": "numbers, arrays, calls and attributes only",
    "x = lambda: n": "numbers, arrays, calls and attributes only",
    "x, y = n, n": "for each variable",
    "w[other(n, w)] += 1": "use a variable",
    "w[w[n]] += other(n, w)": "use a variable",
    "k = other\n    x = k + 1": "write int(…)",
    "k = other\n    o(k)": "is a kernel: call it",
    "while n:\n        n -= 1\n    else:\n        n = 3": "statements are",
    "for x in range(0, n, 2):\n        n += 1": "with one number or two",
    "global N": "statements are",
    "del n": "statements are",
    "assert n": "statements are",
    "raise n": "statements are",
    "def inner():\n        pass": "statements are",
    "with o:\n        n += 1": "statements are",
    "yield n": "numbers, arrays, calls and attributes only",
}
REFUSED_HEADS = {
    "n: int, w: float": "w: float; arguments are int",
    "n: int, w: ptr32 = 3": "no defaults",
    "n: int, *w": "no defaults",
    "n: int, w: ptr32, *, o=1": "no defaults",
    "n: int, w: ptr32) -> ptr32 (": "write -> int",
    "n: int, w: ptr32) -> None (": "write -> int",
    "n: int, w: ptr32) -> (": "returns a value: write -> int",
}
CASES = [("n: int, w: ptr32, o", statement, text) for statement, text in REFUSED.items()]
CASES += [(head, "n += 1", text) for head, text in REFUSED_HEADS.items()]


def refused(head, statement):
    """The failure of a kernel with these arguments and this statement."""
    other = "@micropython.viper\ndef other(a: int, w: ptr32) -> int:\n    return w[a]\n"
    given = f"{head}) -> int".removesuffix("() -> int").removesuffix("-> ") if head.endswith("(") else f"{head}) -> int"
    text = f"import micropython\n{other}\n@micropython.viper\ndef kernel({given}:\n    {statement}\n    return n\n"
    with pytest.raises(Failure) as failure:
        unit_of(text).text("")
    return failure


@pytest.mark.parametrize("head, statement, text", CASES)
def test_what_is_not_understood_is_refused_with_its_place(head, statement, text):
    said = str(refused(head, statement).value)
    assert re.match(r"passo/tried.py:\d+: kernel\(\): ", said) and text in said


def test_every_refusal_is_tried():
    """Each place of the translator that refuses something, but for arrays shared with interrupts: see below."""
    source = Path(translate.__file__).read_text(encoding="utf-8")
    calls = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call) and ast.unparse(node.func) == "self.refuse"]
    places = {node.lineno for node in calls if "shared with interrupts" not in ast.unparse(node)}
    met = {each.lineno + 1 for head, statement, _ in CASES for each in refused(head, statement).traceback if each.path.name == "translate.py"}
    assert not places - met


def test_what_interrupts_share_is_read_and_written_each_time():
    text = "import micropython\n# Shared with interrupts: state\n@micropython.viper\ndef wait(state: ptr32, own: ptr32):\n    own[0] = 3\n    state[0] = 1\n    while state[0]:\n        pass\n"
    made = unit_of(text).text("")
    assert "volatile int32_t *v_state" in made and "int32_t *v_own" in made and "volatile int32_t *v_own" not in made
    assert "settled(); v_state[0] = next" in made and "while (looked(v_state[0]))" in made
    hardware = "import micropython\n@micropython.viper\ndef high() -> int:\n    pins = ptr32(0xD0000004)\n    return pins[0] | ptr32(0xD0000008)[0]\n"
    assert "volatile int32_t *v_pins" in unit_of(hardware).text("") and unit_of(hardware).text("").count("looked(") == 2
    told = {
        "passo/a.py": text + "    look(state)\n    look(own)\n" + "from passo.b import look\n",
        "passo/b.py": "import micropython\n@micropython.viper\ndef look(words: ptr32):\n    words[0] = 1\n",
    }
    program = Program(told)
    with pytest.raises(Failure, match="state is shared with interrupts"):
        Unit(program, [program.kernels["passo.a.wait"]]).text("")


@pytest.mark.parametrize("march", MARCHES)
def test_a_module_needs_no_data_and_no_address(march):
    unit = unit_of(TEXT)
    made = module.make_module(unit.text(RUNTIME), unit.names, march)
    functions, end, *_ = mpy.functions_of(made.data)
    assert len(functions) == 1 and end == len(made.data) and functions[0].kind == mpy.VIPER
    assert not module.pointer_positions(module.code_of(made.data, unit.names, march), march)
    assert module.make_module(unit.text(RUNTIME), unit.names, march) == made
    with pytest.raises(Failure, match="undefined"):
        text = RUNTIME + "int f(int);\nvoid define_all(context_t at, object_t o, intptr_t away) { f(1); }"
        module.compile_c(text, module.find_compiler(march)[1] + ["-Os"])
    writes = "static int kept;\nstatic void define_all(context_t at, object_t o, intptr_t away) { kept++; if (kept > 3) wrong_count(at, 1, kept); }"
    with pytest.raises(Failure, match="data|address"):
        module.compile_c(RUNTIME + writes, module.find_compiler(march)[1] + ["-O1"])


def test_a_text_without_its_kernels_keeps_its_lines(monkeypatch):
    texts = {"passo/steps/a.py": TEXT + "\nLAST = 1\n", "passo/use.py": "from passo.steps.a import elements, flow\nflow(elements)\n"}
    made = compile_kernels(texts, texts, {"axes": []}, "armv6m")
    text = made.texts["passo/steps/a.py"]
    if MARCHES:
        assert "as flow\n" in text and "as elements\n" in text
        assert all(f"def {name}(" not in text for name in ("flow", "elements", "add"))  # `add`: only kernels call it
        assert text.split("\n").index("LAST = 1") == texts["passo/steps/a.py"].split("\n").index("LAST = 1")
        assert list(made.modules) == ["passo/kernels_steps_a.mpy"]
    monkeypatch.setenv("PASSO_KERNELS", "viper")
    assert compile_kernels(texts, texts, {"axes": []}, "armv6m") == (texts, {}, [], 0)
    assert compile_kernels(texts, texts, {"axes": []}, "xtensawin") == (texts, {}, [], 0)


CALLED = """
import micropython
@micropython.viper
def deep(words: ptr32):
    words[0] = 1
@micropython.viper
def called(words: ptr32):
    deep(words)
@micropython.viper
def gone(words: ptr32):
    called(words)
"""
CALLING = """
import micropython
from passo.called import called, gone
@micropython.viper
def calling(words: ptr32):
    called(words)
    gone(words)
"""
USING = "from passo.called import called\nfrom passo.calling import calling\nprint(called, calling)\n"


def unknown(text):
    """Names that compiled functions of a text read, and nobody defines."""
    known = set(dir(builtins)) | {"ptr", "ptr8", "ptr16", "ptr32", "uint"}
    table = symtable.symtable(text, "text", "exec")
    known |= {each.get_name() for each in table.get_symbols() if each.is_assigned() or each.is_imported() or each.is_namespace()}
    kernels = {node.name for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef) and any("micropython." in ast.unparse(each) for each in node.decorator_list)}
    tables, found = [table], set()
    while tables:
        table = tables.pop()
        tables += table.get_children()
        if table.get_name() in kernels:
            found |= {each.get_name() for each in table.get_symbols() if each.is_global() and each.is_referenced()}
    return found - known


def test_what_stays_with_viper_keeps_what_it_calls(monkeypatch):
    """A kernel that another module's compiled code has a copy of, too."""
    monkeypatch.setattr(build, "make_module", lambda *_: module.Made(b"", "a compiler", 0))
    texts = {"passo/called.py": CALLED, "passo/calling.py": CALLING, "passo/using.py": USING}
    made = compile_kernels(texts, texts, {"axes": []}, "armv6m", ["passo/called.py"]).texts
    assert "def called(" in made["passo/called.py"] and "def deep(" in made["passo/called.py"] and "def gone(" not in made["passo/called.py"]
    assert unknown(CALLED.replace("def deep", "def other")) == {"deep"}


@pytest.mark.parametrize("chip", ["rp2040_w", "esp32"])
def test_what_is_frozen_reads_no_name_that_is_gone(chip, monkeypatch):
    monkeypatch.setattr(build, "make_module", lambda *_: module.Made(b"", "a compiler", 0))
    texts, _ = frozen.texts_of(chip)
    assert {path: names for path, text in texts.items() if (names := unknown(text))} == {}


@pytest.mark.skipif("armv6m" not in MARCHES, reason="there is no compiler of kernels for armv6m")
@pytest.mark.parametrize("player", ["pio", "timer"])
def test_all_kernels_of_a_build_are_c(player):
    """Private ones, too, which have other names in a build. The exceptions: kernels left to viper, and those that only these call."""
    board = check({**boards.load("router_3axis"), "player": player})
    sources = {path.as_posix(): (tree.FIRMWARE / path).read_text(encoding="utf-8") for path in tree.select_modules(board)}
    program = Program(tree._compile_sources(sources, board, "armv6m")[0])
    left = {full for full, kernel in program.kernels.items() if kernel.path in tree._viper_modules(board)}
    called = {full for kernel in left for full in program.imported[kernel.rpartition(".")[0]].values()}
    assert left and {full for full, (_, others) in program.uses.items() if others} <= left | called


@pytest.mark.skipif("armv6m" not in MARCHES, reason="there is no compiler of kernels for armv6m")
def test_what_a_release_ships_is_taken_where_there_is_no_compiler(tmp_path, monkeypatch):
    program, _ = tree.kernels_of("two_motor_kit")

    def made():
        left = [path for path in tree.COLD if path not in tree.QUICK]
        return compile_kernels(program.texts, program.texts, boards.load("two_motor_kit"), "armv6m", left)

    here = made()
    (tmp_path / "old.mpy").write_bytes(b"")
    shipped = ship.ship_modules(["two_motor_kit"], tmp_path, ("rp2040",))
    assert here.by == sorted(set(shipped.values())) and {path.name for path in tmp_path.glob("*.mpy")} == shipped.keys()
    assert sorted(here.modules.values()) == sorted(path.read_bytes() for path in tmp_path.glob("*.mpy"))
    monkeypatch.setattr(module, "find_compiler", lambda march: None)
    assert made() == (program.texts, {}, [], 0)
    monkeypatch.setattr(module, "SHIPPED", tmp_path)
    assert made() == here._replace(by=["what came with Passo"])
    with pytest.raises(Failure, match="nothing here compiles kernels for armv6m"):
        ship.ship_modules(["two_motor_kit"], tmp_path, ("rp2040",))


@pytest.mark.parametrize("chip", ship.CHIPS)
def test_a_release_has_the_kernels_of_a_board_with_a_network(chip):
    """On every chip, though it may refuse the board's pins or clock."""
    board = boards.load("router_pico_w")
    assert board["network"] and board["clock_mhz"] and tree.kernels_of("router_pico_w", chip)[1]


@pytest.mark.parametrize("by", ["gcc", "zig"])
def test_no_word_of_a_router_looks_like_a_pointer(by, monkeypatch):
    monkeypatch.setenv("PASSO_KERNELS", by)
    if module.find_compiler("armv6m") is None:
        pytest.skip(f"no {by} for kernels")
    program, groups = tree.kernels_of("router_3axis")
    assert groups
    for _, kernels in groups:
        unit = Unit(program, kernels)
        assert module.make_module(unit.text(RUNTIME), unit.names, "armv6m").pointers == 0


def masks(code):
    """Return the offsets in Thumb code of instructions that change or read the interrupts' mask or wait for an interrupt: CPS, MRS, MSR, WFE, WFI. A
    literal that looks like one would be found, too."""
    halves = struct.unpack(f"<{len(code) // 2}H", code[: len(code) & ~1])
    found, at = [], 0
    while at < len(halves):
        half = halves[at]
        long = half >> 11 in (0b11101, 0b11110, 0b11111)
        system = half & 0xFFE0 in (0xF380, 0xF3E0) and at + 1 < len(halves) and halves[at + 1] & 0xD000 == 0x8000
        if half & 0xFFE8 == 0xB660 or half in (0xBF20, 0xBF30) or system:
            found.append(2 * at)
        at += 2 if long else 1
    return found


@pytest.mark.parametrize("march", [march for march in MARCHES if march.startswith("armv")])
def test_no_kernel_of_a_router_masks_interrupts(march):
    program, groups = tree.kernels_of("router_3axis")
    for name, kernels in groups:
        unit = Unit(program, kernels)
        made = module.make_module(unit.text(RUNTIME), unit.names, march)
        assert masks(module.code_of(made.data, unit.names, march)) == [], name


@pytest.mark.parametrize("instruction", ["cpsid i", "cpsie i", "mrs r0, PRIMASK", "msr PRIMASK, r0", "wfi"])
def test_that_one_who_masks_them_is_seen(instruction):
    text = RUNTIME + f'static void define_all(context_t at, object_t o, intptr_t away) {{ __asm volatile("{instruction}" ::: "r0"); }}'
    for march in MARCHES:
        if march.startswith("armv"):
            assert masks(module.compile_c(text, module.find_compiler(march)[1] + ["-O1"]))


@pytest.mark.parametrize("board", [pytest.param("router_3axis", marks=pytest.mark.slow), "router_esp32"])
def test_viper_compiles_all_kernels(board, monkeypatch, tmp_path):
    monkeypatch.setenv("PASSO_KERNELS", "viper")
    assert len(tree.build_tree(board, tmp_path)) > 100


def test_the_build_says_how_many_words_look_like_pointers(monkeypatch, tmp_path):
    word = (0x20001230).to_bytes(4, "little")
    assert module.pointer_positions(b"1234" + word + word + b"4321", "armv6m") == [4, 8]
    assert module.pointer_positions(b"12" + word + b"43", "armv6m") == []
    assert module.pointer_positions((0x20001234).to_bytes(4, "little"), "armv6m") == []
    made = compile_kernels({}, {}, {"axes": []}, "armv6m")._replace(by=["gcc 1"], pointers=3)
    monkeypatch.delenv("PASSO_BUILDS", raising=False)  # the modules made here are no build
    monkeypatch.setattr(tree.kernels, "compile_kernels", lambda numbered, texts, *more: made._replace(texts=texts))
    by = []
    tree.build_tree("two_motor_kit", tmp_path, by=by)
    assert by == ["gcc 1", "and 3 words look like pointers: the collector may keep garbage for them"]
