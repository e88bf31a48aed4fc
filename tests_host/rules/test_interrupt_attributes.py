"""Attributes that an interrupt sets exist before: an attribute that is new to its object allocates, which no interrupt may."""

import ast

import pytest
from parsed import parse

from host_tools.build.tree import FIRMWARE, module_files

pytestmark = [pytest.mark.quick, pytest.mark.xdist_group("sources")]

ISR = "# ISR"


def classes():
    """Return {class: [(path, class node, lines)]}; classes of one name count together with their bases."""
    found = {}
    for path in module_files():
        text = (FIRMWARE / path).read_text(encoding="utf-8")
        for node in parse(text).body:
            if isinstance(node, ast.ClassDef):
                found.setdefault(node.name, []).append((path, node, text.splitlines()))
    return found


def stored(node):
    """Attributes of `self` that a node assigns."""
    return {
        each.attr
        for each in ast.walk(node)
        if isinstance(each, ast.Attribute) and isinstance(each.ctx, ast.Store)
        and isinstance(each.value, ast.Name) and each.value.id == "self"
    }  # fmt: skip


def made_by(family, methods):
    """Attributes that are there once an object of the classes has been made."""
    made = set()
    queue = [method for each in family for method in each.body if getattr(method, "name", "") == "__init__"]
    seen = set()
    while queue:
        method = queue.pop()
        made |= stored(method)
        called = {
            node.func.attr
            for node in ast.walk(method)
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
            and isinstance(node.func.value, ast.Name) and node.func.value.id == "self"
        } - seen  # fmt: skip
        seen |= called
        queue += [methods[name] for name in called if name in methods]
    return made


def faults(found):
    said = []
    for name, places in found.items():
        for path, node, lines in places:
            family = [node] + [other for base in _bases(node, found) for _, other, _ in found[base]]
            methods = {}
            for each in reversed(family):
                methods.update({method.name: method for method in each.body if isinstance(method, ast.FunctionDef)})
            made = made_by(family, methods)
            for method in node.body:
                if isinstance(method, ast.FunctionDef) and ISR in lines[method.body[0].lineno - 2]:
                    missing = stored(method) - made
                    if missing:
                        said.append(f"{path}: {name}.{method.name}() sets {', '.join(sorted(missing))}")
    return said


def _bases(node, found):
    known = set()
    queue = [base.id for base in node.bases if isinstance(base, ast.Name)]
    while queue:
        name = queue.pop()
        if name in found and name not in known:
            known.add(name)
            queue += [base.id for _, other, _ in found[name] for base in other.bases if isinstance(base, ast.Name)]
    return known


def test_what_interrupts_set_is_made_before():
    assert faults(classes()) == []


def test_what_is_not_is_found():
    text = "class A:\n    def __init__(self):\n        self.b()\n    def b(self):\n        self.c = 1\n"
    text += "class B(A):\n    def d(self):  # ISR: no allocation\n        self.c = self.e = 2\n"
    found = {node.name: [("a.py", node, text.splitlines())] for node in ast.parse(text).body}
    assert faults(found) == ["a.py: B.d() sets e"]
