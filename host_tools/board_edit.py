"""Values of a board file changed where they stand, so that its comments and its order stay.

    text = set_values(text, {"step_program.interval_us": 250, "axes.x.steps_per_m": 80000, "inputs.stop": None})

A key is a path of dict keys; within a list of things that have names, such as axes or inputs, it is their name. A new key goes behind its
neighbours. None removes: in a file that is like another one, and has the key from there, it is written, for merge_changes() to take that key away.
"""

import ast
import re

from host_tools import boards
from host_tools.failure import Failure

STEP = 4  # columns that each level of a board file is further in


def set_values(text, values):
    """Return the text of a board file with these values {path: value}. Raises Failure."""
    for path, value in values.items():
        text = _set_value(text, path.split("."), value)
    return text


def parse_pair(pair):
    """Return (path, value) of KEY=VALUE. A value is written as in a board file; a word that is none there is a string. Raises Failure."""
    path, equals, value = pair.partition("=")
    if not equals or not re.fullmatch(r"[\w-]+(\.[\w-]+)*", path):
        raise Failure("{!r} is not KEY=VALUE, such as axes.x.steps_per_m=80000", pair)
    try:
        return path, ast.literal_eval(value.strip())
    except (ValueError, SyntaxError, MemoryError, RecursionError):
        return path, value.strip()


def _set_value(text, path, value):
    """Return the text with one value. Raises Failure if a part of the path is no dict and no list of named things."""
    place = _Text(text)
    node, depth, holder = place.board, 0, None
    while depth < len(path):
        if not isinstance(node, (ast.Dict, ast.List)):
            raise Failure("{}: {} is a plain value, and has no {}", ".".join(path), ".".join(path[:depth]), path[depth])
        found = _find_item(node, path[depth])
        if found is None:
            return place.add_item(node, path[depth:], value)
        node, holder, depth = found, node, depth + 1
    if value is None and not (isinstance(holder, ast.Dict) and _base_has(place.board, path)):
        return place.remove_item(holder, node)
    return place.replace_value(node, depth, value)


def _base_has(board, path):
    """True if the board of boards/ that this one is like, if any, has a value of that path."""
    like = getattr(_find_item(board, boards.LIKE), "value", None)
    if like not in boards.names():
        return False
    node = _Text(boards.read(boards.path(like))).board
    for key in path:
        node = _find_item(node, key) if isinstance(node, (ast.Dict, ast.List)) else None
        if node is None:
            return False
    return True


def _find_item(node, key):
    """Return the node of a dict's value, or of a list's thing, by its key or name; None if there is none."""
    if isinstance(node, ast.Dict):
        return next((value for name, value in zip(node.keys, node.values) if getattr(name, "value", None) == key), None)
    return next((each for each in node.elts if isinstance(each, ast.Dict) and getattr(_find_item(each, "name"), "value", None) == key), None)


class _Text:
    """A board file's text, and where its nodes stand in it."""

    def __init__(self, text):
        """Parse a board file's text. Raises SyntaxError."""
        self._bytes = text.encode()
        self._lines = [0]
        for line in self._bytes.splitlines(keepends=True):
            self._lines.append(self._lines[-1] + len(line))
        self.board = next(each.value for each in ast.parse(text).body if isinstance(each, ast.Assign))

    def _start_of(self, node):
        """Return the offset in bytes at which a node begins."""
        return self._lines[node.lineno - 1] + node.col_offset

    def _end_of(self, node):
        """Return the offset in bytes at which a node ends."""
        return self._lines[node.end_lineno - 1] + node.end_col_offset

    def _replace_ranges(self, *changes):
        """Return the text with (start, end, new bytes) of each change, from the first to the last."""
        pieces, at = [], 0
        for start, end, new in changes:
            pieces += [self._bytes[at:start], new]
            at = end
        return b"".join([*pieces, self._bytes[at:]]).decode()

    def replace_value(self, node, depth, value):
        """Return the text with another value in a node's place. `depth`: of dicts and lists around it."""
        return self._replace_ranges((self._start_of(node), self._end_of(node), boards.text_of_value(value, STEP * depth).encode()))

    def add_item(self, node, path, value):
        """Return the text with `value` under `path`, as the last item of `node`. Raises Failure."""
        for key in reversed(path[1:]):
            value = {key: value}
        named = isinstance(node, ast.List)
        if named and not isinstance(value, dict):
            raise Failure("{}: there is none", path[0])
        items = node.elts if named else node.values
        at, close = self._end_of(items[-1]) if items else self._start_of(node) + 1, self._end_of(node) - 1
        behind = re.sub(rb"#[^\n]*", b"", self._bytes[at:close])
        comma = b"," if items and b"," not in behind else b""
        line = self._lines[node.end_lineno - 1]
        indent = close - line + STEP if b"\n" in behind else STEP
        text = (boards.text_of_value({"name": path[0], **value}, indent) if named else f'"{path[0]}": {boards.text_of_value(value, indent)}').encode()
        if b"\n" in behind:
            return self._replace_ranges((at, at, comma), (line, line, b" " * indent + text + b",\n"))
        return self._replace_ranges((at, close, (b", " if items else b"") + text))

    def remove_item(self, holder, node):
        """Return the text without an item of `holder`, its comma, and its line if nothing else stands there."""
        first = holder.keys[holder.values.index(node)] if isinstance(holder, ast.Dict) else node
        start, end = self._start_of(first), self._end_of(node)
        line = self._lines[first.lineno - 1]
        alone = re.match(rb"[ \t]*,?[ \t]*(#[^\n]*)?\n", self._bytes[end:])
        if alone and not self._bytes[line:start].strip():
            return self._replace_ranges((line, end + alone.end(), b""))
        if comma := re.match(rb"\s*,[ \t]*", self._bytes[end:]):
            return self._replace_ranges((start, end + comma.end(), b""))
        return self._replace_ranges((len(self._bytes[:start].rstrip(b", \t")), end, b""))
