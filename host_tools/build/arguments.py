"""Renames function arguments for a board: `steps`, if only the function itself uses the name, becomes `_0`.

    texts = shorten_arguments({"passo/a.py": "def twice(steps, by):\n    return 2 * steps + by\n"})
    texts["passo/a.py"]          # "def twice(_0, _1):\n    return 2 * _0 + _1\n"

A board keeps the text of every argument's name for ever, and its table of names doubles when it is full. Names like `_0` are
there already, for attributes (attributes.py). Kept are arguments that any call passes by keyword, names that are used for
something else too, and the arguments of assembler functions, which name registers.
"""

import ast


def shorten_arguments(texts):
    """Return {path: text} of the modules of a build, with short names for the arguments of the firmware's functions."""
    trees = {path: ast.parse(text) for path, text in texts.items()}
    kept = {"self"}
    for tree in trees.values():
        for node in ast.walk(tree):
            kept |= _names_to_keep(node)
    return {path: _rename_arguments(text, trees[path], kept) if path.startswith("passo/") else text for path, text in texts.items()}


def _names_to_keep(node):
    """Return the names in a node that must be kept: the board needs them anyway, or other code may use them."""
    if isinstance(node, ast.Attribute):
        return {node.attr}
    if isinstance(node, (ast.keyword, ast.alias)):
        return {node.arg if isinstance(node, ast.keyword) else node.asname or node.name}
    if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
        return {node.name}
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return {node.value}
    if isinstance(node, (ast.Global, ast.Nonlocal)):
        return set(node.names)
    if isinstance(node, ast.ExceptHandler):
        return {node.name}
    if isinstance(node, ast.JoinedStr):  # `ast` does not give the columns of the names in it
        return {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
    return set()


def _outermost_functions(node):
    """Yield the functions that are in no other function."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef):
            yield child
        elif not isinstance(child, ast.Lambda):
            yield from _outermost_functions(child)


def _rename_arguments(text, tree, kept):
    """Return the text with short names for the arguments of its functions, without those in `kept`."""
    lines = [line.encode() for line in text.splitlines(keepends=True)]  # columns of `ast` are bytes
    edits = []
    for function in _outermost_functions(tree):
        edits += _edits_of(function, kept)
    for line, start, end, name in sorted(edits, reverse=True):
        lines[line - 1] = lines[line - 1][:start] + name.encode() + lines[line - 1][end:]
    return b"".join(lines).decode()


def _edits_of(function, kept):
    """Return (line, from, to, name) of each use of an argument in a function and in those inside it."""
    inside = [node for statement in function.body for node in ast.walk(statement)]
    own = function.args.posonlyargs + function.args.args
    short = {}
    for number, argument in enumerate(own):
        if argument.arg not in kept:
            short[argument.arg] = f"_{number}"
    places = [(node, node.arg) for node in own + [node for node in inside if isinstance(node, ast.arg)]]
    places += [(node, node.id) for node in inside if isinstance(node, ast.Name)]
    return [
        (node.lineno, node.col_offset, node.col_offset + len(name.encode()), short[name])
        for node, name in places
        if name in short
    ]
