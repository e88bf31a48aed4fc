"""Finds loops that never end, long before the program's bound: the state of the program at the end of a pass was there before.

    passes = Passes(state)
    passes.count_pass(7)         # at the end of each pass of the loop that begins in line 7; raises ProgramError

`state()` returns all that the next pass depends on, in plain values, or raises TypeError if it cannot. Brent's method (1980): a state is
kept at each power of two, and compared now and then, so that the usual loop costs nothing.
"""

import dataclasses

from host_tools.programs.program_errors import ENDLESS, ProgramError

_FIRST = 1024  # passes before the first state is kept
_EACH = 64  # passes from one comparison to the next


def plain_value(value):
    """Return a copy that does not change with the value given. Raises TypeError if it has parts that are no plain values."""
    if value is None or isinstance(value, (int, float, complex, str)):
        return value
    if isinstance(value, (list, tuple)):
        return tuple(map(plain_value, value))
    if isinstance(value, (set, frozenset)):
        return frozenset(value)
    if isinstance(value, dict):
        return tuple((key, plain_value(each)) for key, each in value.items())
    if dataclasses.is_dataclass(value):
        return plain_value(vars(value))
    raise TypeError(type(value).__name__)


class Passes:
    def __init__(self, state):
        self._state = state
        self._loops = {}  # first line: [passes, state kept]

    def count_pass(self, begin):
        """Count a pass of the loop that begins at `begin`. Raises ProgramError if the state was the same before (Brent, 1980)."""
        loop = self._loops.setdefault(begin, [0, None])
        loop[0] += 1
        if loop[0] % _EACH or loop[0] < _FIRST:
            return
        try:
            now = self._state()
        except TypeError:
            return
        if now == loop[1]:
            raise ProgramError(ENDLESS, "nothing has changed since an earlier pass of the loop")
        if not loop[0] & (loop[0] - 1):
            loop[1] = now
