"""Measures a drawing in a trace: its steps, its time, and its distance from the ideal lines.

    rows = read_trace("out/square.csv")
    result = measure_drawing(rows, [(False, 1000, 1000), (True, 1400, 1000), ...])
    result.deviation <= 0.5 and not result.faults

The drawing is the end of the trace: its last sum(max(|dx|, |dy|)) stepping rows, as each of them steps the dominant
axis of its line by one. Distances are taken on the minor axis, as Bresenham's rule does.
"""

import csv
from dataclasses import dataclass, field

from host_tools.failure import Failure, reason
from host_tools.language import _

_HEADER = ["t_us", "x", "y", "z", "a", "tool"]


@dataclass
class Row:
    t_us: float
    x: int
    y: int
    tool: int


@dataclass
class Result:
    steps: int  # stepping words of the drawing
    time_s: float  # from its first step to the last row, the pen's arrivals included
    first: int  # index of the row before the drawing's first step
    deviation: float  # largest distance from the ideal line, in steps on the minor axis
    faults: list = field(default_factory=list)  # differences from the commanded points, sentences


def read_trace(path):
    """Read the rows of a trace CSV. Raises Failure with the line that is wrong."""
    try:
        with open(path, newline="", encoding="utf-8", errors="replace") as file:
            reader = csv.reader(file)
            if next(reader, None) != _HEADER:
                raise Failure("{} is not a trace: its first line should be {}", path, ",".join(_HEADER))
            return [_parse_row(path, reader.line_num, fields) for fields in reader]
    except OSError as error:
        raise Failure("cannot read trace {}: {}", path, reason(error)) from error


def _parse_row(path, line, fields):
    """Return the Row of a line's fields: time in µs, x and y in steps, tool. Raises Failure with path and line."""
    try:
        t_us, x, y, _, _, tool = fields
        return Row(float(t_us), int(x), int(y), int(tool))
    except ValueError as error:
        raise Failure("{}, line {}: not a row of a trace", path, line) from error


def measure_drawing(rows, points, start=(0, 0)):
    """Compare the end of a trace with the object [(pen_down, x, y), ...] drawn from `start`; return a Result, in steps. A trace that is too short is
    one of its faults."""
    legs = []
    position = start
    for pen_down, x, y in points:
        legs.append((position, (x, y), pen_down))
        position = (x, y)
    steps = sum(_dominant_steps(a, b) for a, b, _ in legs)
    walk = [index for index in range(1, len(rows)) if _position_of(rows[index]) != _position_of(rows[index - 1])]
    if len(walk) < steps:
        return Result(len(walk), 0.0, 0, 0.0, [_("{} steps in the trace, {} commanded", len(walk), steps)])
    walk = walk[len(walk) - steps :]
    result = Result(steps, 0.0, 0, 0.0)
    if walk:
        result.first = walk[0] - 1
        before = _position_of(rows[result.first])
        if before != start:
            result.faults.append(_("begins at {}, not at {}", before, start))
        result.time_s = (rows[-1].t_us - rows[walk[0]].t_us) / 1e6
    if _position_of(rows[-1]) != position:
        result.faults.append(_("ends at {}, not at {}", _position_of(rows[-1]), position))
    if rows[-1].tool:
        result.faults.append(_("ends with the pen down"))
    done = 0
    for number, (a, b, pen_down) in enumerate(legs, 1):
        count = _dominant_steps(a, b)
        _check_line([rows[index] for index in walk[done : done + count]], a, b, pen_down, number, result)
        done += count
    return result


def _check_line(rows, a, b, pen_down, number, result):
    """Check the rows of one line, from a to b."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    longer = max(abs(dx), abs(dy))
    for row in rows:
        across = abs((row.y - a[1]) * dx - (row.x - a[0]) * dy)
        result.deviation = max(result.deviation, across / longer)
        if bool(row.tool) != pen_down:
            text = _("point {}: the pen is up at {}") if pen_down else _("point {}: the pen is down at {}")
            result.faults.append(text.format(number, _position_of(row)))
            return
    if rows and _position_of(rows[-1]) != b:
        result.faults.append(_("point {}: reached {}, not {}", number, _position_of(rows[-1]), b))


def _dominant_steps(a, b):
    return max(abs(b[0] - a[0]), abs(b[1] - a[1]))


def _position_of(row):
    return row.x, row.y
