"""Constants become numbers in what a board gets, and nothing else does."""

import ast

import pytest

from host_tools.build.constants import fold_constants, fold_in_place
from host_tools.build.tree import FIRMWARE, module_files
from host_tools.failure import Failure

A = """from micropython import const

FIVE = const(5)
BELOW = const(-FIVE)  # below
_PRIVATE = const(7)
HALF = const(_PRIVATE)
WORDS = (
    FIVE,
    BELOW,
)
"""


def both(text, a=A):
    texts = fold_constants({"passo/a.py": a, "passo/b.py": text})
    return texts["passo/a.py"], texts["passo/b.py"]


@pytest.mark.parametrize(
    "text, wanted",
    [
        ("from passo.a import FIVE, WORDS\nx = FIVE + WORDS[0]\n", "from passo.a import WORDS\nx = 5 + WORDS[0]\n"),
        ("from passo.a import *\nx = FIVE + WORDS[0]\n", "from passo.a import WORDS\nx = 5 + WORDS[0]\n"),
        ("from passo import a\nx = a.FIVE ** a.BELOW\n", "pass\nx = 5 ** (-5)\n"),
        ("from passo import a as n\nx = (n.FIVE, n.WORDS)\n", "from passo import a as n\nx = (5, n.WORDS)\n"),
        ("from passo.a import (\n    FIVE,\n    WORDS,\n)\n", "from passo.a import WORDS\n\n\n\n"),
        ("def load():\n    from passo import a\n", "def _16():\n    from passo import a\n"),
        ("from passo.a import FIVE\nFIVE = 6\n", "from passo.a import FIVE\nFIVE = 6\n"),
        ("from passo.a import FIVE\ndef f(FIVE):\n    return FIVE\n", "from passo.a import FIVE\ndef _16(FIVE):\n    return FIVE\n"),
        ("from passo import a\ndef f(a):\n    return a.FIVE\n", "from passo import a\ndef _16(a):\n    return a.FIVE\n"),
        ("from passo import a\ndef f():\n    return a\n", "from passo import a\ndef _16():\n    return a\n"),
        ("from passo.a import HALF\nx = HALF\n", None),
        ("x.FIVE = y.FIVE\n", None),
        ("from passo import a\nclass B:\n    def a(self): return a.FIVE\n", "pass\nclass _16:\n    def a(self): return 5\n"),
        ("TWO, SIX = 2, 6\nx = TWO * SIX\n", "pass\nx = 2 * 6\n"),
        ("ON = True\nx = ON\n", None),
        ("HUGE = 1 << 32\nx = HUGE\n", None),
    ],
)
def test_numbers_for_names(text, wanted):
    assert both(text)[1] == (text if wanted is None else wanted)


def test_what_nobody_reads_is_not_defined():
    assert both("x = 1\n")[0].splitlines()[2:5] == ["pass", "pass  # below", "_16 = const(7)"]
    assert "FIVE = const(5)" in both("from passo import a\ndef f():\n    return a\n")[0]
    assert "FIVE = const(5)" in both("from passo import a\ndef f(a):\n    return a.FIVE\n")[0]
    assert both("x = 1\n")[0].splitlines()[5] == "HALF = const(_16)"


def test_a_constant_passes_through_modules():
    through = {"passo/b.py": "from passo.a import FIVE\n", "passo/c.py": "from passo.b import FIVE\nx = FIVE\n"}
    texts = fold_constants({"passo/a.py": A, **through})
    assert texts["passo/c.py"] == "pass\nx = 5\n"


def test_only_numbers_differ_in_the_firmware():
    """Every line stays in its place, and no public constant is left to be looked up."""
    texts = {path.as_posix(): (FIRMWARE / path).read_text(encoding="utf-8") for path in module_files()}
    defined = 0
    for path, text in fold_constants(texts).items():
        assert text.count("\n") == texts[path].count("\n"), path
        defined += sum(isinstance(node, ast.Name) and node.id == "const" for node in ast.walk(ast.parse(text)))
        assert not [line for line in text.splitlines() if " = const(" in line and line[0].isupper()], path
    assert defined > 100


def test_a_module_that_is_not_python_is_named():
    with pytest.raises(Failure, match="passo/b.py:1: invalid syntax"):
        both("x = \n")


def test_numbers_alone_leave_imports_and_definitions():
    texts = fold_in_place({"passo/a.py": A, "passo/b.py": "from passo.a import FIVE, HALF\nx = FIVE\n"})
    assert texts["passo/b.py"] == "from passo.a import FIVE, HALF\nx = 5\n"
    assert "FIVE = const(5)" in texts["passo/a.py"]
