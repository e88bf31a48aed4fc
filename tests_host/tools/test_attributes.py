"""Private attributes have short names in what a board gets, each its own where one object can have both."""

import ast

import pytest

from host_tools import boards
from host_tools.build.arguments import shorten_arguments
from host_tools.build.attributes import shorten_attributes
from host_tools.build.tree import FIRMWARE, module_files, select_modules
from host_tools.resources import ROOT

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
    assert made["_21"]() == (None, 0) and made["_19"] == 2


HOME = "def find(a): return a\nclass Found: pass\n_own = find(Found)\n"
USER = "from passo.a import Found, find\n_first = find(Found())\n"


def test_what_others_only_import_is_shortened():
    texts = shorten_attributes({"passo/a.py": HOME, "passo/b.py": USER, "passo/c.py": "def seek(): return 1\n"})
    assert texts["passo/a.py"] == "def _17(a): return a\nclass _18: pass\n_16 = _17(_18)\n"
    assert texts["passo/b.py"] == "from passo.a import _18, _17\n_16 = _17(_18())\n"
    assert texts["passo/c.py"] == "def _16(): return 1\n"


@pytest.mark.parametrize(
    "other",
    [
        "from passo import a\na.find(1)\n", "find = 1\n", "def f(find): pass\n", "f(find=1)\n", "x = 'a find'\n", "class A:\n    def find(self): pass\n",
        "from passo.a import find as seek\n", "def find(): pass\n", "class A:\n    find = 1\n", "def f():\n    global find\n    find = 2\n",
    ],
)  # fmt: skip
def test_a_function_that_is_used_in_another_way_keeps_its_name(other):
    texts = shorten_attributes({"passo/a.py": HOME, "passo/b.py": USER, "passo/c.py": other})
    assert texts["passo/a.py"].startswith("def find(a)") and "import _17, find\n" in texts["passo/b.py"] and "find" in texts["passo/c.py"]


def test_kernels_and_names_of_main_stay():
    text = "@micropython.viper\ndef walk(a: int) -> int: return a\n" + "".join(f"def {name}(): pass\n" for name in ("safe", "Start"))
    text += "def quick(): return 1\n"
    made = shorten_attributes({"passo/a.py": text})["passo/a.py"]
    assert "def walk(" in made and "def safe(" in made and "def Start(" in made and "def quick" not in made


PROGRAMS = sorted(path for room in ("prove", "experiments") for path in (ROOT / "host_tools" / room).glob("board_*.py"))  # which run on a board


@pytest.mark.parametrize("board", [None, "router_3axis", "lpt_router", "mill_2004", "plotter_2014", "torch_pico_w"])
def test_all_that_is_imported_is_there(board):
    """Of all modules, and of those that a board has; by the firmware, and by programs that run on a board."""
    files = select_modules(boards.load(board)) if board else module_files()
    texts = shorten_attributes({path.as_posix(): (FIRMWARE / path).read_text() for path in files})
    trees = {path.removesuffix(".py").removesuffix("/__init__").replace("/", "."): ast.parse(text) for path, text in texts.items()}
    bound = {}
    for module, tree in trees.items():
        names = {each.id for each in ast.walk(tree) if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)}
        names |= {each.name for each in tree.body if isinstance(each, (ast.FunctionDef, ast.ClassDef))}
        bound[module] = names | {each.asname or each.name for node in ast.walk(tree) if isinstance(node, (ast.Import, ast.ImportFrom)) for each in node.names}
    programs = [ast.parse(path.read_text(encoding="utf-8")) for path in PROGRAMS]
    imported = {
        (node.module, each.name)
        for tree in [*trees.values(), *programs] for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module in bound
        for each in node.names if f"{node.module}.{each.name}" not in trees and each.name != "*"
    }  # fmt: skip
    assert len([name for _, name in imported if name[1:].isdigit()]) > 30
    assert not [(module, name) for module, name in imported if name not in bound[module]]


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
