"""Private attributes have short names in what a board gets, each its own where one object can have both."""

import ast

from host_tools.build.arguments import shorten_arguments
from host_tools.build.attributes import shorten_attributes
from host_tools.build.tree import FIRMWARE, module_files

A = """class A:
    def __init__(self):
        self._much = self._more = 1
        self.seen = "_more"

    def _work(self):
        return self._much + self._timer
"""


def test_what_one_module_keeps_is_shortened():
    texts = shorten_attributes({"passo/a.py": A, "passo/b.py": "class B:\n    def f(self): self._other = 2\n"})
    assert "self._0 = self._more = 1" in texts["passo/a.py"], "a string names _more"
    assert "def _1(self)" in texts["passo/a.py"] and "return self._0 + self._timer" in texts["passo/a.py"]
    assert "self._0 = 2" in texts["passo/b.py"], "another object's"


def test_what_others_ask_for_is_left_alone():
    others = ["x = a._much\n", "def f(self): return g(_much=1)\n", "from passo.a import _much\n", "class B:\n    _much = 1\n"]
    for other in others + ["x = '_much'\n"]:
        assert "self._much" in shorten_attributes({"passo/a.py": A, "passo/b.py": other})["passo/a.py"]
    texts = shorten_attributes({"passo/a.py": A, "passo/b.py": "def f(self): return self._much\n"})
    assert "self._0" in texts["passo/a.py"] and "self._0" in texts["passo/b.py"], "another object's, which has nothing to do with it"


def test_derived_classes_share_no_name():
    b = "from passo.a import A\nclass B(A):\n    def f(self): self._other = 2\n"
    c = "from passo import b\nclass C(b.B):\n    def f(self): self._third = self._much\n"
    texts = shorten_attributes({"passo/a.py": A, "passo/b.py": b, "passo/c.py": c})
    much = texts["passo/a.py"].split(" = ")[0][-2:]
    assert texts["passo/c.py"].strip().endswith("self." + much)
    names = {much, texts["passo/b.py"][-7:-5], texts["passo/c.py"].split(" = ")[0][-2:]}
    assert len(names) == 3


def test_a_module_s_own():
    text = """_COUNT = 3
_far = [n for n in range(_COUNT)]
def _work(_arg):
    global _state
    _state = _far[_arg]
class _Shown: pass
def seen(): return _work(_Shown), _kept
_state = _kept = 0
"""
    other = "from passo.a import _kept\n_state = 2\n"
    texts = shorten_attributes({"passo/a.py": text, "passo/b.py": other})
    assert "def _20(_arg):" in texts["passo/a.py"] and "global _19\n    _19 = _18[_arg]" in texts["passo/a.py"], texts["passo/a.py"]
    assert "class _17: pass" in texts["passo/a.py"] and "_19 = _kept = 0" in texts["passo/a.py"]
    assert texts["passo/b.py"].endswith("_16 = 2\n")
    made = {}
    exec(texts["passo/a.py"].replace("_20(_17)", "_20(2)"), made)
    assert made["seen"]() == (None, 0) and made["_19"] == 2


def test_no_argument_has_a_name_of_the_module():
    for path, text in shorten_arguments(shorten_attributes({path.as_posix(): (FIRMWARE / path).read_text() for path in module_files()})).items():
        tree = ast.parse(text)
        own = {node.name for node in tree.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
        own |= {each.id for node in tree.body if isinstance(node, ast.Assign) for each in node.targets if isinstance(each, ast.Name)}
        arguments = {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)}
        assert not [name for name in own & arguments if name[1:].isdigit()], path


def test_the_firmware_stays_what_it_is():
    """Apart from the names every module has the same structure, and its lines stay where they are."""
    texts = {path.as_posix(): (FIRMWARE / path).read_text() for path in module_files()}
    short = shorten_attributes(texts)
    renamed = 0
    for path, text in texts.items():
        before, after = (list(ast.walk(ast.parse(each))) for each in (text, short[path]))
        assert [type(node) for node in before] == [type(node) for node in after]
        assert [getattr(node, "lineno", 0) for node in before] == [getattr(node, "lineno", 0) for node in after]
        renamed += sum(a.attr != b.attr for a, b in zip(before, after) if isinstance(a, ast.Attribute))
    assert renamed > 1500
