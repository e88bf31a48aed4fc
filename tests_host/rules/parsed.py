"""Sources as trees of Python's syntax. Each is parsed once in a process, and only if a rule asks for it: files whose rules ask for
all of them belong to the `xdist_group` "sources", which one worker runs.
"""

import ast
import functools
from collections.abc import Mapping

parse = functools.cache(ast.parse)  # of a text


class Trees(Mapping):
    """{name: tree} of {name: path}."""

    def __init__(self, paths):
        self._paths = paths

    def __getitem__(self, name):
        return parse(self._paths[name].read_text(encoding="utf-8"))

    def __iter__(self):
        return iter(self._paths)

    def __len__(self):
        return len(self._paths)
