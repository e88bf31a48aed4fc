"""Make kernels of one random expression each, and compute their values in Python: for tests of the translator on every target.

    kernels_text()                      # a module of viper functions: one for each operator, and expressions at random
    expected([(1, 2, 3)])               # what they give for a, b, c: in 32 bits, as docs/inside/kernels.md defines it
    unit, data = module_for("rv32imc")  # the same on a target: target_code() prints checksums()
"""

import ast
import random
from array import array
from binascii import crc32

from host_tools.kernels import module
from host_tools.kernels.build import RUNTIME
from host_tools.kernels.program import Program
from host_tools.kernels.unit import Unit

OPERATORS = ("+", "-", "*", "//", "%", "<<", ">>", "&", "|", "^")
COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")
EDGES = (0, 1, -1, 2, -2, 3, -7, 31, 32, 33, 255, 256, 65535, -65536, (1 << 30) - 1, 1 << 30, (1 << 31) - 1, -(1 << 31), -(1 << 30))
NAMES = "a", "b", "c"
CONSTANTS = (*EDGES, 7, 10, 1000, -3, 0x55555555, 40)
EXPRESSIONS = 48


def wrapped(value):
    return (value + (1 << 31)) % (1 << 32) - (1 << 31)


def python_of(sign, a, b):
    """Return the operator's value as Python computes it, wrapped to 32 bits. Division by 0 gives 0; a shift by a number below 0 or above 31 counts as one
    by 32.
    """
    if sign in ("//", "%") and b == 0:
        return 0
    if sign in ("<<", ">>"):
        b = b if 0 <= b < 32 else 32
    return wrapped(int(eval(f"a {sign} b", {"a": a, "b": b})))


def _value(node, names):
    """Return the value of a node of an expression; a condition gives 1 or 0."""
    if isinstance(node, ast.Constant):
        return wrapped(int(node.value))
    if isinstance(node, ast.Name):
        return names[node.id]
    if isinstance(node, ast.Call):  # int(…)
        return _value(node.args[0], names)
    if isinstance(node, ast.BinOp):
        return python_of(_sign(node), _value(node.left, names), _value(node.right, names))
    if isinstance(node, ast.UnaryOp):
        operand = _value(node.operand, names)
        return int(not operand) if isinstance(node.op, ast.Not) else wrapped(-operand if isinstance(node.op, ast.USub) else ~operand)
    if isinstance(node, ast.BoolOp):
        parts = [bool(_value(part, names)) for part in node.values]
        return int(all(parts) if isinstance(node.op, ast.And) else any(parts))
    if isinstance(node, ast.IfExp):
        return _value(node.body if _value(node.test, names) else node.orelse, names)
    values = [_value(part, names) for part in (node.left, *node.comparators)]
    signs = [ast.unparse(ast.Compare(ast.Name("x"), [each], [ast.Name("y")])).split()[1] for each in node.ops]
    return int(all(python_of(sign, left, right) for sign, left, right in zip(signs, values, values[1:])))


def _sign(node):
    return ast.unparse(ast.BinOp(ast.Name("x"), node.op, ast.Name("y"))).split()[1]


def _number(draw, depth):
    """The text of a number."""
    kind = draw.randrange(8 if depth else 2)
    if kind == 0:
        return draw.choice(NAMES)
    if kind == 1:
        return f"({draw.choice(CONSTANTS)})"
    if kind == 2:
        return f"({draw.choice('-~')}{_number(draw, depth - 1)})"
    if kind == 3:
        return f"({_number(draw, depth - 1)} if {_condition(draw, depth - 1)} else {_number(draw, depth - 1)})"
    return f"({_number(draw, depth - 1)} {draw.choice(OPERATORS)} {_number(draw, depth - 1)})"


def _condition(draw, depth):
    kind = draw.randrange(4 if depth > 0 else 1)
    if kind == 1:
        return f"not {_condition(draw, depth - 1)}"
    if kind == 2:
        return f"({_condition(draw, depth - 1)} {draw.choice(['and', 'or'])} {_condition(draw, depth - 1)})"
    if kind == 3:
        return f"({_number(draw, 0)} {draw.choice(COMPARISONS)} {draw.choice(NAMES)} {draw.choice(COMPARISONS)} {_number(draw, 0)})"
    return f"({_number(draw, max(depth, 0))} {draw.choice(COMPARISONS)} {_number(draw, max(depth, 0))})"


def expressions():
    """[expression]: every operator and comparison alone, also by itself and by constants, and many together."""
    found = [f"a {sign} b" for sign in OPERATORS] + [f"(1 if a {sign} b else 0)" for sign in COMPARISONS]
    found += [f"a {sign} a" for sign in OPERATORS] + ["-a", "~a", "(1 if not a else 2)", "(1 if a and b or not c else 0)"]
    found += [f"a {sign} {by}" for sign in ("//", "%") for by in ("7", "8", "(-3)", "(-8)", "1", "(-1)", "0")]
    found += [f"a {sign} {by}" for sign in ("<<", ">>") for by in ("0", "1", "31", "32", "40", "(-1)")]
    draw = random.Random(30)
    return found + [_number(draw, 4) for _ in range(EXPRESSIONS)]


KERNEL = "\n@micropython.viper\ndef e{}(a: int, b: int, c: int) -> int:\n    return int({})\n"
# Each answer goes into an array, not out as an object: so that heap_lock() shows that nothing is allocated.
INTO = "\n@micropython.viper\ndef all_of(numbers: ptr32, count: int, answers: ptr32):\n    at = 0\n    while at < count:\n{}        at += 1\n"


def kernels_text():
    """The module's text: kernels e0, e1 …, and all_of(numbers, count, answers) that runs them all on `count` triples of numbers."""
    found = expressions()
    text = "import micropython\n" + "".join(KERNEL.format(number, each) for number, each in enumerate(found))
    row = "        answers[at * {0} + {1}] = e{1}(numbers[at * 3], numbers[at * 3 + 1], numbers[at * 3 + 2])\n"
    return text + INTO.format("".join(row.format(len(found), number) for number in range(len(found))))


def expected(triples):
    """Return an array of Python's values: for each triple, one of each expression."""
    parsed = [ast.parse(each, mode="eval").body for each in expressions()]
    return array("i", [_value(node, dict(zip(NAMES, triple))) for triple in triples for node in parsed])


# For a target with `kernels_tried.mpy`, whose all_of it calls while nothing may be allocated; prints a checksum for each triple.
TARGET = """
import gc, micropython
from array import array
from binascii import crc32
from kernels_tried import {all_of} as all_of
for numbers in {triples!r}:
    numbers, answers = array("i", numbers), array("i", [0] * {count})
    gc.collect()
    before = gc.mem_alloc()
    micropython.heap_lock()
    all_of(numbers, 1, answers)
    micropython.heap_unlock()
    print(crc32(answers))
"""


def module_for(march):
    """(unit, bytes of kernels_tried.mpy) for a target."""
    program = Program({"tried.py": kernels_text()})
    unit = Unit(program, list(program.kernels.values()))
    return unit, module.make_module(unit.text(RUNTIME), unit.names, march).data


def target_code(unit, triples):
    """Return the code for a target that has kernels_tried.mpy: it prints the lines of checksums()."""
    name = next(unit.python_name(each.kernel) for each in unit.called if each.kernel.name == "all_of")
    return TARGET.format(all_of=name, triples=[tuple(each) for each in triples], count=len(expressions()))


def checksums(triples):
    """Return the lines that the target has to print."""
    return "".join(f"{crc32(expected([triple]))}\n" for triple in triples)
