"""Renames what is private for a board: `self._something` becomes `self._3`, and a module's `_something` `_19`; and so do public functions and classes
of a module that others use under the imported name only.

    texts = shorten_attributes({"passo/a.py": "class A:\n    def __init__(self):\n        self._much = 1\n"})
    texts["passo/a.py"]          # "class A:\n    def __init__(self):\n        self._0 = 1\n"

A board keeps the text of every name for ever, and its table of names doubles when it is full: one name too many costs
thousands of bytes. All modules use the same short names. Those of attributes and methods are distinct in each module and those that its
classes derive from, those of a module's functions, classes and variables in each module. A traceback still shows
file and line. These names stay: those in strings, attributes of other objects than `self`, private names that another module imports, variables of
a class, and ASKED_FOR, which tests and benches read on the board.
"""

import ast
import re
from functools import cache

from host_tools.resources import MAIN

ASKED_FOR = {"_bytes", "_lines", "_redirect", "_timer", "_trip", "UsbLine", "measure_khz", "load_all", "port_byte", "show_lines"}
_FIRST_OF_MODULE = 16  # short names of a module's own; arguments.py gives those before to a function's


class _Module:
    """A module's text, its nodes, and its private methods."""

    def __init__(self, text):
        self.text = text
        self.tree = ast.parse(text)
        self.nodes = list(ast.walk(self.tree))
        classes = [node for node in self.nodes if isinstance(node, ast.ClassDef)]
        self.methods = {each for node in classes for each in node.body if isinstance(each, ast.FunctionDef) and _is_private(each.name)}


def shorten_attributes(texts):
    """Return {path: text} of the modules of a build, with short names for private functions, classes and attributes."""
    modules = {path: _Module(text) for path, text in texts.items()}
    taken = ASKED_FOR.union(*(_names_that_stay(module) for module in modules.values()))
    short = _short_names(modules, {path: _of_self(module) - taken for path, module in modules.items()})
    own = {path: _short_globals(module, taken) for path, module in modules.items()}
    _add_imported_names(modules, own)
    return {path: _rename_private(module, short[path], own[path]) for path, module in modules.items()}


def _short_names(modules, names):
    """Return {path: {name: short name}} of `names`, {path: names of attributes and methods}: attributes of classes that share no object get the same
    short name."""
    related = _modules_that_share_objects(modules)
    groups = {}  # (path, name): set of all that are the same attribute
    for path in modules:
        for name in sorted(names[path]):
            group = groups.setdefault((path, name), {(path, name)})
            for other in [(near, name) for near in related[path] if name in names[near]]:
                group |= groups.get(other, {other})
            groups.update(dict.fromkeys(group, group))
    numbers = {}
    for group in sorted({id(group): group for group in groups.values()}.values(), key=lambda group: (-len(group), min(group))):
        near = set().union(*(related[path] for path, _ in group))
        used = {numbers.get((path, name)) for path in near for name in names[path]}
        numbers.update(dict.fromkeys(group, next(number for number in range(len(used) + 1) if number not in used)))
    return {path: {name: f"_{numbers[path, name]}" for name in names[path]} for path in modules}


def _is_private(name):
    """True if a name begins with one underscore and is not short already."""
    return name.startswith("_") and not name.startswith("__") and name != "_" and not name[1:].isdigit()


def _is_of_self(node):
    """True if an expression is a private attribute of `self`."""
    return isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "self" and _is_private(node.attr)


def _of_self(module):
    """Return the names of a module's private attributes and methods."""
    return {node.attr for node in module.nodes if _is_of_self(node)} | {method.name for method in module.methods}


def _names_that_stay(module):
    """Return the names that must stay: a module uses them in a way that renaming does not follow."""
    found = set()
    for node in module.nodes:
        if isinstance(node, ast.Attribute) and not _is_of_self(node):
            found.add(node.attr)
        elif isinstance(node, ast.ImportFrom):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, (ast.arg, ast.keyword)):
            found.add(node.arg)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.add(node.value)
        elif isinstance(node, ast.ClassDef):
            found |= {each.id for part in _class_scope(node) for each in ast.walk(part) if isinstance(each, ast.Name)}
    return found


def _class_scope(node):
    """Yield the parts of a class that are evaluated among its own variables."""
    for each in node.body:
        yield from each.decorator_list + [each.args] if isinstance(each, ast.FunctionDef) else [each]


def _short_globals(module, taken):
    """Return {name: short name} of a module's private functions, classes and variables. `taken`: names that stay."""
    own = set()
    for node in module.tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            own.add(node.name)
        else:
            own |= {each.id for each in ast.walk(node) if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)}
            own |= {each.asname for each in ast.walk(node) if isinstance(each, ast.alias) and each.asname}
    inner = {method.name for method in module.methods}
    names = sorted(name for name in own if _is_private(name) and name not in taken and name not in inner)
    return {name: f"_{_FIRST_OF_MODULE + number}" for number, name in enumerate(names)}


def _add_imported_names(modules, short):
    """Add to `short`, {path: {name: short name}}, public functions and classes of a module that it and its importers use by their bare name only. A
    name gets one short name in all of them."""
    paths = _paths_of_modules(modules)
    seen_in = {(path, name): [path] for path, module in modules.items() for name in _public_names(module)}
    for path, module in modules.items():
        for node in module.nodes:
            for alias in node.names if isinstance(node, ast.ImportFrom) else ():
                users = seen_in.get((paths.get(node.module), alias.name))
                if users is not None and not alias.asname and path not in users:
                    users.append(path)
    homes = [name for _, name in seen_in]
    staying = ASKED_FOR.union(_names_of_main(), *(_names_used_otherwise(module) for module in modules.values()))
    staying |= {name for name in homes if homes.count(name) > 1}
    for (_, name), users in seen_in.items():
        if name not in staying:
            used = {each for path in users for each in short[path].values()}
            number = next(number for number in range(_FIRST_OF_MODULE, _FIRST_OF_MODULE + len(used) + 1) if f"_{number}" not in used)
            for path in users:
                short[path][name] = f"_{number}"


@cache
def _names_of_main():
    """Return the names in main.py, which a board gets as it is."""
    return set(re.findall(r"\w+", MAIN.read_text(encoding="utf-8")))


def _public_names(module):
    """Return the names of a module's public functions and classes that are plain Python: kernels have theirs in machine code, too."""
    return [node.name for node in module.tree.body if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.decorator_list and not node.name.startswith("_")]


def _names_used_otherwise(module):
    """Return the names that a module uses in another way than as its own or an imported function or class."""
    found = set()
    for node in module.nodes:
        if isinstance(node, ast.Attribute):
            found.add(node.attr)
        elif isinstance(node, (ast.arg, ast.keyword)):
            found.add(node.arg)
        elif isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
            found.add(node.id)
        elif isinstance(node, ast.alias) and node.asname:
            found |= {node.name, node.asname}
        elif isinstance(node, (ast.FunctionDef, ast.ClassDef)) and node not in module.tree.body:
            found.add(node.name)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found |= set(re.findall(r"\w+", node.value))
        elif isinstance(node, (ast.Global, ast.Nonlocal)):
            found |= set(node.names)
        if isinstance(node, ast.ClassDef):
            found |= {each.id for part in _class_scope(node) for each in ast.walk(part) if isinstance(each, ast.Name)}
    return found


def _paths_of_modules(paths):
    """Return {module's name: path}."""
    return {path.removesuffix(".py").removesuffix("/__init__").replace("/", "."): path for path in paths}


def _modules_that_share_objects(modules):
    """Return {path: modules, itself included, whose classes may be those of one object, through inheritance}."""
    paths = _paths_of_modules(modules)
    lines = {path: {path} for path in modules}  # a module, and those that its classes are derived from
    for path, module in modules.items():
        known = {}  # local name: the module that it is, or is from
        for node in module.nodes:
            for alias in node.names if isinstance(node, ast.ImportFrom) else ():
                source = f"{node.module}.{alias.name}"
                known[alias.asname or alias.name] = paths.get(source) or paths.get(node.module)
        for base in [base for node in module.nodes if isinstance(node, ast.ClassDef) for base in node.bases]:
            other = known.get(base.value.id if isinstance(base, ast.Attribute) else base.id)
            lines[path] |= {other} if other else set()
    grown = True
    while grown:
        longer = {path: set().union(*(lines[other] for other in line)) for path, line in lines.items()}
        grown, lines = longer != lines, longer
    return {path: set().union(*(line for line in lines.values() if path in line)) for path in modules}


def _rename_private(module, attributes, own):
    """Return the module's text with short names. `attributes`, `own`: {name: short name} of attributes and methods; of functions, classes and
    variables."""
    lines = [line.encode() for line in module.text.splitlines(keepends=True)]  # columns of `ast` are bytes
    indices = []  # (line, column where the old name begins, old name, new name)
    for node in module.nodes:
        if _is_of_self(node):
            indices.append((node.end_lineno, node.end_col_offset - len(node.attr), node.attr, attributes.get(node.attr)))
        elif isinstance(node, ast.Name):
            indices.append((node.lineno, node.col_offset, node.id, own.get(node.id)))
        elif isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            begin = node.col_offset + len("def " if isinstance(node, ast.FunctionDef) else "class ")
            indices.append((node.lineno, begin, node.name, (attributes if node in module.methods else own).get(node.name)))
        elif isinstance(node, ast.alias):
            name = node.asname or node.name
            indices.append((node.end_lineno, node.end_col_offset - len(name), name, own.get(name)))
        elif isinstance(node, ast.Global):
            line, at = lines[node.lineno - 1], node.col_offset
            for name in node.names:
                at = line.index(name.encode(), at)
                indices.append((node.lineno, at, name, own.get(name)))
    for number, at, old, new in sorted((index for index in indices if index[3]), reverse=True):
        line = lines[number - 1]
        assert line[at : at + len(old)] == old.encode()
        lines[number - 1] = line[:at] + new.encode() + line[at + len(old) :]
    return b"".join(lines).decode()
