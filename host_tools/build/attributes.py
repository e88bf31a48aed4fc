"""Renames private attributes for a board: `self._something`, if only its class uses it, becomes `self._3`.

    texts = shortened({"passo/a.py": "class A:\n    def __init__(self):\n        self._much = 1\n"})
    texts["passo/a.py"]          # "class A:\n    def __init__(self):\n        self._0 = 1\n"

A board keeps the text of every name for ever, and its table of names doubles when it is full: one name too many costs
thousands of bytes. All modules use the same short names; modules whose classes are derived from each other count as one.
Kept are methods (tracebacks show them), names that another module or a string has too, attributes that are not read from `self`
only, and those that tests and benches read on the board.
"""

import ast

ASKED_FOR = {"_bytes", "_lines", "_timer", "_trip"}


def shortened(texts):
    """{path: text} of the modules of a build, with short names for private attributes."""
    trees = {path: ast.parse(text) for path, text in texts.items()}
    where, taken = {}, set(ASKED_FOR)  # {attribute: modules}
    for path, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute) and _private(node):
                where.setdefault(node.attr, set()).add(path)
            else:
                taken |= _names(node)
    short = {}
    for family in _families(trees):
        names = sorted(name for name, paths in where.items() if paths <= family and name not in taken)
        short.update({name: f"_{number}" for number, name in enumerate(names)})
    return {path: _renamed(text, trees[path], short) for path, text in texts.items()}


def _private(node):
    """Whether an attribute is one of `self`, and private."""
    own = isinstance(node.value, ast.Name) and node.value.id == "self"
    return own and node.attr.startswith("_") and not node.attr.startswith("__")


def _names(node):
    """Names in a node that are no private attributes of `self`."""
    if isinstance(node, ast.Attribute):
        return {node.attr}
    if isinstance(node, ast.Name):
        return {node.id}
    if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
        return {node.name}
    if isinstance(node, (ast.arg, ast.keyword)):
        return {node.arg}
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return {node.value}
    return set()


def _families(trees):
    """Sets of modules whose classes are derived from each other's."""
    modules = {path.removesuffix(".py").replace("/", "."): path for path in trees}
    family = {path: {path} for path in trees}
    for path, tree in trees.items():
        nodes = list(ast.walk(tree))
        known = {}  # local name: the module that it is, or is from
        for node in nodes:
            for alias in node.names if isinstance(node, ast.ImportFrom) else ():
                source = f"{node.module}.{alias.name}"
                known[alias.asname or alias.name] = modules.get(source) or modules.get(node.module)
        for base in [base for node in nodes if isinstance(node, ast.ClassDef) for base in node.bases]:
            other = known.get(base.value.id if isinstance(base, ast.Attribute) else base.id)
            if other:
                both = family[path] | family[other]
                for each in both:
                    family[each] = both
    return list({id(each): each for each in family.values()}.values())


def _renamed(text, tree, short):
    lines = [line.encode() for line in text.splitlines(keepends=True)]  # columns of `ast` are bytes
    found = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute) and _private(node) and node.attr in short]
    for node in sorted(found, key=lambda node: (node.end_lineno, node.end_col_offset), reverse=True):
        line, end = lines[node.end_lineno - 1], node.end_col_offset
        lines[node.end_lineno - 1] = line[: end - len(node.attr)] + short[node.attr].encode() + line[end:]
    return b"".join(lines).decode()
