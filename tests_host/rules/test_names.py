"""Names of functions: one that does is a verb and its object, one that returns is a noun or a question.

A past participle (`told`, `kept`) says neither; one word alone says little outside its file. Both are counted in each tree, and their shares may
only fall.
"""

import ast
import functools
import re
from collections import namedtuple
from pathlib import Path

import pytest
from parsed import parse

pytestmark = [pytest.mark.quick, pytest.mark.xdist_group("sources")]

ROOT = Path(__file__).resolve().parents[2]
Shares = namedtuple("Shares", "participles one_word")
MOST = {"firmware": Shares(0.01, 0.30), "host_tools": Shares(0.01, 0.15)}  # lower a number after you have renamed some

# Names that others' interfaces have, or that each option, feature or walker answers to (docs/inside/architecture.md).
INTERFACES = set("""
    read write open close flush any send run main start stop poll
    check create extend claims handlers look begin end ready busy report halt guard join load drop walk feed
""".split())  # fmt: skip

PARTICIPLES = set("""
    asked begun borne bought bound brought built caught chosen drawn fed found given gone grown heard held hidden kept known laid left lent lost
    made meant met paid said seen sent shown shrunk spent spoken stood taken thought thrown told wanted won worn torn written
""".split())  # fmt: skip
NO_PARTICIPLES = {"embed", "feed", "heed", "led", "need", "red", "seed", "shed", "speed"}  # they end in -ed


@functools.cache
def functions(tree):
    """Return [(path, line, name)] of a tree's functions but for those of Python's own names."""
    found = []
    for path in sorted((ROOT / tree).rglob("*.py")):
        for node in ast.walk(parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and not node.name.startswith("__"):
                found.append((path.relative_to(ROOT), node.lineno, node.name))
    return found


def is_participle(name):
    word = name.strip("_").split("_")[0]
    return word not in NO_PARTICIPLES and (word in PARTICIPLES or bool(re.search("ed$", word)))


def is_one_word(name):
    return "_" not in name.strip("_")


def found_in(tree):
    """Return (number of functions, participles, names of one word), the latter as ["path:line: name"]."""
    counted = [each for each in functions(tree) if each[2] not in INTERFACES]
    participles, one_word = [[f"{path}:{line}: {name}" for path, line, name in counted if kind(name)] for kind in (is_participle, is_one_word)]
    return len(counted), participles, one_word


@pytest.mark.parametrize("tree", MOST)
def test_functions_are_named_by_what_they_do(tree):
    number, participles, one_word = found_in(tree)
    most = MOST[tree]
    assert len(participles) <= most.participles * number, "\n".join([*participles, f"{len(participles)} of {number} functions are named by a participle"])
    assert len(one_word) <= most.one_word * number, "\n".join([*one_word, f"{len(one_word)} of {number} functions have a name of one word"])


def test_interfaces_are_few_and_used():
    """A name that fewer than three classes or modules have is no interface."""
    names = [name for tree in MOST for _, _, name in functions(tree)]
    assert len(INTERFACES) <= 30
    assert not [name for name in INTERFACES if names.count(name) < 3]


def test_names_are_told_apart():
    assert [name for name in ("told", "_kept_pieces", "stopped", "feed", "is_kept", "read_bed", "_need") if is_participle(name)] == ["told", "_kept_pieces", "stopped"]
    assert [name for name in ("_look", "look_up", "tell") if is_one_word(name)] == ["_look", "tell"]
