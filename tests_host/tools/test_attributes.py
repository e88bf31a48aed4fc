"""Private attributes have short names in what a board gets, each its own where one object can have both."""

import ast

import pytest

from host_tools.build.attributes import shortened
from host_tools.build.tree import FIRMWARE, module_files

pytestmark = pytest.mark.quick

A = """class A:
    def __init__(self):
        self._much = self._more = 1
        self.seen = "_more"

    def _work(self):
        return self._much + self._timer
"""


def test_what_one_module_keeps_is_shortened():
    texts = shortened({"passo/a.py": A, "passo/b.py": "class B:\n    def f(self): self._other = 2\n"})
    assert "self._0 = self._more = 1" in texts["passo/a.py"], "a string names _more"
    assert "def _work" in texts["passo/a.py"] and "return self._0 + self._timer" in texts["passo/a.py"]
    assert "self._0 = 2" in texts["passo/b.py"], "another object's"


def test_what_others_ask_for_is_left_alone():
    for other in ("x = a._much\n", "def f(self): return self._much\n", "_much = 1\n"):
        assert "self._much" in shortened({"passo/a.py": A, "passo/b.py": other})["passo/a.py"]


def test_derived_classes_share_no_name():
    b = "from passo.a import A\nclass B(A):\n    def f(self): self._other = 2\n"
    c = "from passo import b\nclass C(b.B):\n    def f(self): self._third = 3\n"
    texts = shortened({"passo/a.py": A, "passo/b.py": b, "passo/c.py": c})
    names = {texts["passo/a.py"].split(" = ")[0][-2:], texts["passo/b.py"][-7:-5], texts["passo/c.py"][-7:-5]}
    assert names == {"_0", "_1", "_2"}


def test_the_firmware_stays_what_it_is():
    """Apart from the names every module has the same structure, and its lines stay where they are."""
    texts = {path.as_posix(): (FIRMWARE / path).read_text() for path in module_files()}
    short = shortened(texts)
    renamed = 0
    for path, text in texts.items():
        before, after = (list(ast.walk(ast.parse(each))) for each in (text, short[path]))
        assert [type(node) for node in before] == [type(node) for node in after]
        assert [getattr(node, "lineno", 0) for node in before] == [getattr(node, "lineno", 0) for node in after]
        renamed += sum(a.attr != b.attr for a, b in zip(before, after) if isinstance(a, ast.Attribute))
    assert renamed > 300
