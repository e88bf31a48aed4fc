"""Teach-in of pulse codes: moves by hand, written down as the steps that they were.

    teach = PulsesTeach("xyz")
    teach.begin()
    teach.add_moves([(0, 100), (1, 50)], [100, 20], 1200)   # said; steps of each axis that came of it; mm/min
    text = teach.program_text()                         # "[\n+1200\nAAAA…CCCC…\n]\n"

The file makes the same steps in the same order, at the same speed. A move that was cut counts as far as it came.
"""

from micropython import const

from passo import errors

_CODES = ("AB", "CD", "EF")  # forward and backward of x, y, z
_WIDTH = const(60)
_MOST = const(2_000_000)  # steps


class PulsesTeach:
    def __init__(self, axes):
        self._axes = axes
        self._parts = None  # (code, count), and marks with a count of 0
        self._tool = False

    def count_moves(self):
        """The number of moves recorded; −1: it does not record."""
        return -1 if self._parts is None else len([1 for _, count in self._parts if count])

    def begin(self):
        """Begin to record, and forget an older record. Returns 0."""
        self._parts = []
        self._speed = 0
        self._steps = 0
        self._lit = False  # as the file has it
        return 0

    def drop(self):
        self._parts = None
        return 0

    def note_tool(self, tool, drives):
        """Note from a report whether the tool is on, and mark a change in the file."""
        self._tool = tool
        if self._parts is not None and tool != self._lit:
            self._lit = tool
            self._parts.append(("(" if tool else ")", 0))

    def add_moves(self, runs, made, speed):
        """Add moves by hand. `runs`: (axis, steps) in their order; `made`: the steps that each axis really made; `speed`: mm/min."""
        if self._parts is None:
            return
        left = list(made)
        for axis, steps in runs:
            count = min(abs(steps), abs(left[axis])) if steps * left[axis] > 0 else 0
            if not count or self._steps + count > _MOST:
                continue
            left[axis] -= count if steps > 0 else -count
            self._steps += count
            if round(speed) != self._speed:
                self._speed = round(speed)
                self._parts.append(("+%d" % self._speed, 0))
            self._add_code(_CODES[axis][0 if steps > 0 else 1], count)

    def _add_code(self, code, count):
        if self._parts and self._parts[-1][0] == code:
            count += self._parts.pop()[1]
        self._parts.append((code, count))

    def program_text(self):
        """End recording and return the file's text, or the number of an error."""
        if self._parts is None:
            return errors.NO_SUCH_JOB
        lines = ["["]
        row = ""
        for code, count in self._parts + [(")", 0)] * self._lit + [("]", 0)]:
            if not count:
                lines += [row, code] if row else [code]
                row = ""
                continue
            while count:
                part = min(count, _WIDTH - len(row))
                row += code * part
                count -= part
                if len(row) == _WIDTH:
                    lines.append(row)
                    row = ""
        self._parts = None
        return "\n".join(lines) + "\n"
