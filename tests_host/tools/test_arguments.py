"""Arguments have short names in what a board gets, where nobody says them from elsewhere."""

import ast

import pytest

from host_tools.build.arguments import shorten_arguments
from host_tools.build.tree import FIRMWARE, module_files


def of(text, others=""):
    return shorten_arguments({"passo/a.py": text, "passo/b.py": others})["passo/a.py"]


@pytest.mark.parametrize(
    "text, wanted",
    [
        ("def f(steps, by):\n    return steps ** by\n", "def f(_0, _1):\n    return _0 ** _1\n"),
        ("def f(n: int, m: int = 3) -> int:\n    m = n\n", "def f(_0: int, _1: int = 3) -> int:\n    _1 = _0\n"),
        ("n = 2\ndef f(n=n):\n    return n\n", "n = 2\ndef f(_0=n):\n    return _0\n"),
        ("class A:\n    def f(self, n):\n        self.m = n\n", "class A:\n    def f(self, _1):\n        self.m = _1\n"),
        ("def f(n):\n    def g(m, n=n):\n        return n\n", "def f(_0):\n    def g(m, _0=_0):\n        return _0\n"),
        ("def f(n):\n    return [n for n in n], lambda m: n\n", "def f(_0):\n    return [_0 for _0 in _0], lambda m: _0\n"),
        ("def f(über, n): return über + n\n", "def f(_0, _1): return _0 + _1\n"),
        ("def f(n):\n    return f'{n}'\n", None),
        ("def f(n):\n    def g():\n        nonlocal n\n", None),
        ("def f(n, *more, k=1):\n    return n.more.k\n", "def f(_0, *more, k=1):\n    return _0.more.k\n"),
        ("key = lambda n: n\n", None),
    ],
)
def test_numbers_for_names(text, wanted):
    assert of(text) == (text if wanted is None else wanted)


@pytest.mark.parametrize("other", ["f(n=1)\n", "from c import n\n", "x.n = 1\n", "def n(): pass\n", "x = {'n': 1}\n"])
def test_a_name_that_is_kept_anyway_or_said_stays(other):
    assert of("def f(n, m):\n    return n + m\n", other) == "def f(n, _1):\n    return n + _1\n"


def test_only_the_firmware_is_changed():
    text = "def f(n):\n    return n\n"
    assert shorten_arguments({"digest.py": text})["digest.py"] == text


def test_the_firmware_stays_what_it_is():
    """Apart from the names every module has the same structure, and its lines stay where they are."""
    texts = {path.as_posix(): (FIRMWARE / path).read_text(encoding="utf-8") for path in module_files()}
    renamed = 0
    for path, text in shorten_arguments(texts).items():
        before, after = (list(ast.walk(ast.parse(each))) for each in (texts[path], text))
        assert [(type(node), getattr(node, "lineno", 0)) for node in before] == [
            (type(node), getattr(node, "lineno", 0)) for node in after
        ]
        renamed += sum(a.arg != b.arg for a, b in zip(before, after) if isinstance(a, ast.arg))
    assert renamed > 150
