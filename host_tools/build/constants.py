"""Writes constants as numbers: after `X = const(5)` or `X = 5` in one module, all modules of a build have 5 instead of X.

    texts = fold_constants({"passo/a.py": "X = const(5)\n", "passo/b.py": "from passo.a import X\nprint(X)\n"})
    texts["passo/b.py"]          # "pass\nprint(5)\n"

A board keeps every public name it has loaded: its text, an entry in the module's dict, and a share of the table of names,
which doubles when it is full. MicroPython itself folds a constant only inside its module and if its name begins with an
underscore. Its machine code can index an array by numbers only, so MicroPython on a PC runs such texts too (`fold_in_place`).
Lines keep their numbers, so a traceback shows the line of the source.

A name is kept if it is more than a constant: bound twice, or in a module that is passed around as an object.
"""

import ast
import re
from functools import lru_cache

from host_tools.build.arguments import shorten_arguments
from host_tools.build.attributes import shorten_attributes
from host_tools.failure import Failure

SMALL = 1 << 30  # a larger number is an object on a board: keep one for all modules
_STAR = re.compile(r"(?m)^from (\S+) import \*")
_ASSIGNED = re.compile(r"(?m)^([A-Z][A-Z0-9_]*) = ")
_CAPITALS = re.compile(r"\b[A-Z][A-Z0-9_]*\b")
_ARITHMETIC = (ast.Constant, ast.Name, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop, ast.Load)

class _Module:
    """A module of a build: names bound, constants, edits to be made."""

    def __init__(self, path, text):
        """Read a text. Raises Failure with its line if it is not Python."""
        self.path = path
        self.name = path.removesuffix(".py").replace("/", ".").removesuffix(".__init__")
        self.text = text
        try:
            self.nodes, self.bound, self.constants, self.read, self.imports = _read_module(text)
        except SyntaxError as error:
            raise Failure("{}:{}: {}", path, error.lineno, error.msg) from None
        self.numbers = {}  # {name: number}: the constants found, own and imported
        self.edits = []  # (first line, column, last line, column, new text)
        self.kept = set()  # names that others read from here at run time

    def names_imported(self):
        """Return (local name, module, name in it) of each import by name."""
        return [(alias.asname or alias.name, node.module, alias.name) for node in self.imports for alias in node.names]


@lru_cache(maxsize=512)
def _read_module(text):
    """Return (nodes, {name: how many times it is bound}, {name: (statement, expression)} of possible public constants, names read, imports) of a
    text. Cached: do not change them. Raises SyntaxError."""
    tree = ast.parse(text)
    nodes = list(ast.walk(tree))
    bound, constants = {}, {}
    methods = {id(node) for owner in nodes if isinstance(owner, ast.ClassDef) for node in owner.body}
    for node in nodes:
        for name in () if id(node) in methods and isinstance(node, ast.FunctionDef) else _names_bound_by(node):
            bound[name] = bound.get(name, 0) + 1
    for node in tree.body:
        for name, expression in _constants_of(node):
            if name.isupper() and not name.startswith("_") and bound[name] == 1:
                constants[name] = node, expression
    read = {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
    return nodes, bound, constants, read, [node for node in nodes if isinstance(node, ast.ImportFrom) and not node.level]


def _write_out_stars(texts):
    """Return the texts with the names that they read of `from passo.records import *`, which has constants only."""
    public = {path.removesuffix(".py").replace("/", "."): set(_ASSIGNED.findall(text)) for path, text in texts.items()}

    def write_out(text):
        """Return a text with the names in place of its stars."""
        read = set(_CAPITALS.findall(text))
        return _STAR.sub(lambda star: f"from {star[1]} import {', '.join(sorted(public.get(star[1], set()) & read)) or '*'}", text)

    return {path: write_out(text) if _STAR.search(text) else text for path, text in texts.items()}


def _names_bound_by(node):
    """Return the names that a node binds; twice those of `global`, which are then no constants."""
    if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
        return [node.id]
    if isinstance(node, ast.arg):
        return [node.arg]
    if isinstance(node, (ast.Import, ast.ImportFrom)):
        return [(alias.asname or alias.name).split(".")[0] for alias in node.names]
    if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
        return [node.name]
    if isinstance(node, (ast.Global, ast.Nonlocal)):
        return node.names * 2
    if isinstance(node, ast.ExceptHandler) and node.name:
        return [node.name]
    return []


def _constants_of(node):
    """Return (name, expression) of an assignment of constants: `A = const(1)`, `A = 1`, `A, B = 1, 2`."""
    if not isinstance(node, ast.Assign) or len(node.targets) > 1:
        return []
    pairs = [(node.targets[0], node.value)]
    if isinstance(node.targets[0], ast.Tuple) and isinstance(node.value, ast.Tuple):
        pairs = list(zip(node.targets[0].elts, node.value.elts))
    found = []
    for target, value in pairs:
        if isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id == "const":
            value = value.args[0]
        if isinstance(target, ast.Name):
            found.append((target.id, value))
    return found


def _evaluate_constants(modules):
    """Fill in `numbers` of all modules. A constant may be computed from others, and imported by way of other modules."""
    found = True
    while found:
        found = False
        for module in modules.values():
            for name, source, original in module.names_imported():
                number = modules[source].numbers.get(original) if source in modules else None
                if number is not None and module.bound[name] == 1 and name not in module.numbers:
                    module.numbers[name] = number
                    found = True
            for name in module.constants.keys() - module.numbers.keys():
                number = _number_of(module.constants[name][1], module.numbers)
                if number is not None and abs(number) < SMALL:
                    module.numbers[name] = number
                    found = True


def _number_of(expression, numbers):
    """Return the value of an expression of integers; None if it is none, or has unknown names."""
    parts = list(ast.walk(expression))
    if not all(isinstance(part, _ARITHMETIC) for part in parts):
        return None
    if not all(type(part.value) is int for part in parts if isinstance(part, ast.Constant)):
        return None
    if not all(part.id in numbers for part in parts if isinstance(part, ast.Name)):
        return None
    return eval(compile(ast.Expression(expression), "constant", "eval"), {"__builtins__": {}}, dict(numbers))


def _fold_names(module, modules, keep_imports=False):
    """Replace names by numbers in a module's edits; note in `kept` the names that are still read from other modules."""
    known = {}  # local name: the module of the build that it stands for
    for name, source, original in module.names_imported():
        full = f"{source}.{original}"
        if full in modules:
            known.setdefault(name, []).append(modules[full])
    for node in module.nodes:
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name in modules:
                    modules[alias.name].kept.add("*")
    read = {}  # local name: how often it is still read
    bases = set()
    for node in module.nodes:
        if not isinstance(node, ast.Attribute) or not isinstance(node.value, ast.Name) or node.value.id not in known:
            continue
        bases.add(node.value)
        sources = known[node.value.id]
        number = sources[0].numbers.get(node.attr)
        if module.bound[node.value.id] == 1 and number is not None and isinstance(node.ctx, ast.Load):
            _add_edit(module, node, str(number) if number >= 0 else f"({number})")
            continue
        read[node.value.id] = read.get(node.value.id, 0) + 1
        for source in sources:
            source.kept.add(node.attr)
    for node in module.nodes:
        if not isinstance(node, ast.Name) or not isinstance(node.ctx, ast.Load) or node in bases:
            continue
        number = module.numbers.get(node.id)
        if number is not None:
            _add_edit(module, node, str(number) if number >= 0 else f"({number})")
            continue
        read[node.id] = read.get(node.id, 0) + 1
        for source in known.get(node.id, ()):
            source.kept.add("*")
    for node in () if keep_imports else module.imports:
        if node.module in modules or any(f"{node.module}.{alias.name}" in modules for alias in node.names):
            _trim_import(module, node, modules, read)


def _trim_import(module, node, modules, read):
    """Import only names that are still read: no constants, no modules that gave constants only. An import whose names are never read loads its
    module, and stays."""
    wanted = []
    for alias in node.names:
        name = alias.asname or alias.name
        if name in module.numbers and module.bound[name] == 1:
            continue
        if f"{node.module}.{alias.name}" in modules and name in module.read and not read.get(name):
            continue
        wanted.append(alias)
        if node.module in modules:
            modules[node.module].kept.add(alias.name)
    if len(wanted) == len(node.names):
        return
    names = [alias.name + (f" as {alias.asname}" if alias.asname else "") for alias in wanted]
    text = f"from {node.module} import {', '.join(names)}" if names else "pass"
    _add_edit(module, node, text + "\n" * (node.end_lineno - node.lineno))


def _add_edit(module, node, text):
    """Note that `text` replaces a node."""
    module.edits.append((node.lineno, node.col_offset, node.end_lineno, node.end_col_offset, text))


def _drop_unread(module):
    """Remove the module's definitions that no other module reads by name."""
    if "*" in module.kept:
        return
    unread = {}  # statement: how many of its names
    for name, (node, _) in module.constants.items():
        if name in module.numbers and name not in module.kept:
            unread[node] = unread.get(node, 0) + 1
    for node, count in unread.items():
        if count < max(len(_constants_of(node)), 1):
            continue
        inside = range(node.lineno, node.end_lineno + 1)
        module.edits = [edit for edit in module.edits if edit[0] not in inside]
        _add_edit(module, node, "pass" + "\n" * (node.end_lineno - node.lineno))


def _apply_edits(module):
    """Return the module's text with all its edits."""
    lines = [line.encode() for line in module.text.splitlines(keepends=True)]  # columns of `ast` are bytes
    for first, start, last, end, text in sorted(module.edits, reverse=True):
        tail = lines[last - 1][end:]
        lines[first - 1 : last] = [lines[first - 1][:start] + text.encode() + tail] + [b""] * (last - first)
    return b"".join(lines).decode()


def _load_modules(texts):
    """Return {name: _Module} of a build, with `numbers` filled in. Raises Failure if a text is not Python."""
    modules = {module.name: module for module in (_Module(path, text) for path, text in _write_out_stars(texts).items())}
    _evaluate_constants(modules)
    return modules


def fold_in_place(texts):
    """Return {path: text} with numbers instead of constants; definitions and imports stay, because tests read them. Raises Failure."""
    return _fold_in_place(_load_modules(texts))


def _fold_in_place(modules):
    """Return fold_in_place() of loaded modules, and leave these as they were."""
    for module in modules.values():
        _fold_names(module, modules, keep_imports=True)
    made = {module.path: _apply_edits(module) for module in modules.values()}
    for module in modules.values():
        module.edits.clear()
        module.kept.clear()
    return made


def fold_constants(texts):
    """Return {path: text} of the modules of a build, with numbers for constants, and private attributes and arguments under short names. Raises
    Failure if a text is not Python."""
    return shorten_names(fold_whole(texts))


def shorten_names(texts):
    """Return {path: text} with short names for private attributes and arguments."""
    return shorten_arguments(shorten_attributes(texts))


def fold_both_ways(texts):
    """Return (fold_in_place(texts), fold_whole(texts)), which is less work than each by itself. Raises Failure."""
    modules = _load_modules(texts)
    return _fold_in_place(modules), _fold_modules(modules)


def fold_whole(texts):
    """Return {path: text} with numbers for constants; all other names stay. Raises Failure."""
    return _fold_modules(_load_modules(texts))


def _fold_modules(modules):
    """Return fold_whole() of loaded modules."""
    for module in modules.values():
        _fold_names(module, modules)
    for module in modules.values():
        _drop_unread(module)
    return {module.path: _apply_edits(module) for module in modules.values()}
