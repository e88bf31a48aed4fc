"""Kernels with the calls inlined compute the same as before, in the same order."""

import ast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host_tools.build.tree import compile_module
from host_tools.failure import Failure
from host_tools.kernels.inline import LARGEST, inline_kernels

HELPERS = '''
import micropython

LOW = 0x40000000

@micropython.viper
def sign(value: int) -> int:
    if value < 0:
        return -1
    if value:
        return 1
    return 0

@micropython.viper
def find(data: ptr32, count: int, wanted: int) -> int:
    at = 0
    while at < count:
        if data[at] == wanted:
            return at
        if data[at] > LOW:
            break
        at += 1
    return 0 - count

@micropython.viper
def deep(data: ptr32, count: int, wanted: int) -> int:
    for i in range(count):
        j = i
        while j < count:
            if data[i] + data[j] == wanted:
                if i == j:
                    return i
                return i * 100 + j
            j += 1
        if data[i] == 3:
            continue
        data[i] = data[i] + 1
    if wanted > 4:
        if data[0] == 2:
            return 7000
    else:
        data[1] = 5
    return 9000

@micropython.viper
def bump(data: ptr32, at: int) -> int:
    data[at] = data[at] + 1
    at += data[at]
    return at

@micropython.viper
def clear(data: ptr32, at: int):
    if at > 3:
        return
    data[at] = 0

@micropython.viper
def even(value: int) -> bool:
    return value & 1 == 0
'''

CALLERS = '''
import micropython
from passo.helpers import bump, clear, deep, even, find, sign

@micropython.viper
def work(numbers, data: ptr32, count: int, wanted: int) -> int:
    other = ptr32(numbers)
    x = find(data, count, wanted)
    x = int(sign(x)) + 3 * sign(int(bump(other, 0)) - sign(x))
    x += data[0] - bump(data, 0) * data[0] + bump(data, 0)
    data[1] += bump(data, 1)
    if x > 2 and bump(data, 2) > 4 or not even(x):
        x += 1000
    elif sign(x) < 0 and even(x + 4):
        x -= 2000
    turns = 0
    while turns < 5 and bump(data, 3) > 2:
        turns += 1
        if even(data[3]):
            continue
        clear(data, sign(data[2]) + 1)
    for i in range(bump(data, 0) & 3):
        x ^= deep(data, count, i + wanted)
    y = bump(data, 1) if even(x) else sign(x)
    clear(data, y)
    return x + sign(y) if wanted else deep(other, 3, data[bump(data, 0) & 1])
'''
TEXTS = {"passo/helpers.py": HELPERS, "passo/callers.py": CALLERS}
MADE = inline_kernels(TEXTS)


def run(texts, *arguments):
    """Run work(…) of the texts as ordinary Python; return its value and its arrays."""
    spaces = {}
    for path in TEXTS:
        text = texts[path].replace("@micropython.viper", "").replace("import micropython", "")
        lines = [line for line in text.split("\n") if not line.startswith("from passo")]
        space = {**spaces, "ptr32": lambda array: array}
        exec(compile("\n".join(lines), path, "exec"), space)
        spaces.update(space)
    return spaces["work"](*arguments), arguments


numbers = st.lists(st.integers(-3, 9), min_size=4, max_size=4)


@given(numbers, numbers, st.integers(0, 4), st.integers(-1, 9))
def test_the_same_is_computed_in_the_same_order(one, other, count, wanted):
    assert run(MADE, list(one), list(other), count, wanted) == run(TEXTS, list(one), list(other), count, wanted)


def test_what_goes_in_is_left_out_of_its_module():
    kept = inline_kernels(TEXTS, keep=True)["passo/helpers.py"]
    for each in "sign", "find", "bump", "clear", "even", "deep":
        assert f"{each}(" not in MADE["passo/callers.py"]
        assert f"def {each}" not in MADE["passo/helpers.py"]
        assert f"def {each}" in kept


def test_viper_compiles_it_for_every_chip(tmp_path):
    for path, text in MADE.items():
        (tmp_path / "m.py").write_text(text)
        for march in "armv6m", "armv7emsp", "xtensawin", "rv32imc":
            compile_module(tmp_path / "m.py", tmp_path / "m.mpy", march, path)


def test_what_python_calls_stays_and_lines_keep_their_numbers():
    texts = {**TEXTS, "passo/app.py": "from passo.helpers import sign\nprint(sign(3))\n"}
    texts["passo/callers.py"] += "\n\ndef last():\n    return work\n"
    made = inline_kernels(texts)
    assert "def sign" in made["passo/helpers.py"]
    assert made["passo/app.py"] == texts["passo/app.py"]
    lines = [
        next(node.lineno for node in ast.parse(text).body if getattr(node, "name", "") == "last")
        for text in (texts["passo/callers.py"], made["passo/callers.py"])
    ]
    assert lines[0] == lines[1]


LONG = "@micropython.viper\ndef long(x: int) -> int:\n" + "    x += 1\n" * 40 + "    return x\n"


def test_a_long_kernel_goes_in_where_only_one_calls_it():
    one = LONG + "@micropython.viper\ndef one(x: int) -> int:\n    return int(long(x))\n"
    assert "def long" not in inline_kernels({"passo/a.py": one})["passo/a.py"]
    many = one + "@micropython.viper\ndef two(x: int) -> int:\n    return int(long(x)) + int(long(x + 1))\n"
    assert inline_kernels({"passo/a.py": many})["passo/a.py"] == many
    assert inline_kernels({"passo/a.py": one, "passo/b.py": "from passo.a import long\nlong(3)\n"})["passo/a.py"] == one


def test_none_goes_in_that_is_large_with_what_is_in_it():
    """A board has to find memory for a function in one piece."""
    parts = "".join(LONG.replace("long", f"part_{part}") for part in range(LARGEST // 42))
    sums = " + ".join(f"part_{part}(x)" for part in range(LARGEST // 42))
    texts = {"passo/a.py": f"{parts}@micropython.viper\ndef whole(x: int) -> int:\n    return {sums}\n"}
    assert "def part_" not in inline_kernels(texts)["passo/a.py"]
    texts["passo/a.py"] += LONG + "@micropython.viper\ndef last(x: int) -> int:\n    return int(whole(x)) + int(long(x))\n"
    assert "def whole" not in inline_kernels(texts)["passo/a.py"]
    texts["passo/a.py"] = texts["passo/a.py"].replace("def whole(x: int) -> int:\n", "def whole(x: int) -> int:\n" + "    x += 1\n" * 42)
    made = inline_kernels(texts)["passo/a.py"]
    assert "def whole" in made and "def long" not in made and "def part_" not in made


def test_a_kernel_that_python_calls_too_goes_in_where_one_calls_it():
    short = LONG.replace("    x += 1\n" * 40, "    x += 1\n" * 20)
    one = short + "@micropython.viper\ndef one(x: int) -> int:\n    return int(long(x))\n"
    made = inline_kernels({"passo/a.py": one, "passo/b.py": "from passo.a import long\nlong(3)\n"})["passo/a.py"]
    assert "def long" in made and "long(x)" not in made


def test_a_private_constant_of_a_kernel_that_goes_elsewhere_is_a_number():
    texts = {
        "passo/a.py": "from micropython import const\n_2 = const(7)\n@micropython.viper\ndef seven(x: int) -> int:\n    return x + _2\n",
        "passo/b.py": "from passo.a import seven\n@micropython.viper\ndef one(x: int) -> int:\n    return int(seven(x))\n",
    }
    assert "7" in inline_kernels(texts)["passo/b.py"] and "_2" not in inline_kernels(texts)["passo/b.py"].replace("_int_2", "")


def test_a_call_that_stays_is_a_number():
    text = LONG + "@micropython.viper\ndef two(x: int) -> int:\n    y = long(x) + long(x + 1)\n    return y + long(long(y))\n"
    assert "y = int(long(x)) + int(long(x + 1))" in inline_kernels({"passo/a.py": text})["passo/a.py"]
    assert "y + int(long(int(long(y))))" in inline_kernels({"passo/a.py": text})["passo/a.py"]


REFUSED = {
    "a loop's else": "while x:\n        x -= 1\n    else:\n        x = twice(x)",
    "in a circle": "x = second(x)",
    "compare one after the other": "x = 1 if 0 < x < twice(x) else 2",
    "takes 1 arguments": "x = twice(x, x)",
    "returns nothing": "x = 1 + nothing(x)",
    "something else here": "x = borrowed(x)",
}


@pytest.mark.parametrize("reason", REFUSED)
def test_what_cannot_go_in_is_refused_with_its_place(reason):
    heads = "@micropython.viper\ndef twice(x: int) -> int:\n    return 2 * x\n@micropython.viper\ndef nothing(x: int):\n    x += 1\n"
    text = f"from passo.b import borrowed\nfrom passo.c import STRANGE\n{heads}@micropython.viper\ndef second(x: int) -> int:\n    {REFUSED[reason]}\n    return x\n"
    other = "STRANGE = object()\n@micropython.viper\ndef borrowed(x: int) -> int:\n    return x + int(STRANGE)\n"
    with pytest.raises(Failure, match=r"passo/[ab].py:\d+: \w+\(\): ") as failure:
        inline_kernels({"passo/a.py": text, "passo/b.py": other})
    assert reason in str(failure.value)
