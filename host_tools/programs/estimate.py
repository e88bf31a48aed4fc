"""Estimates how long a drawing takes: the lines at their speed, plus the pen's delays.

    times = Estimate(board, speed=None)     # None: the board file's default speed
    sum(times.object_s(points))             # seconds, one figure a point

A speed in half periods sets the pace of the longer axis, as the table of 2014 did; a speed in steps/s holds along the path, in
steps of X.
"""

import math

import numpy

from host_tools import boards


class Estimate:
    def __init__(self, board, speed=None):
        rule = board["speed"]
        value = rule["default"] if speed is None else speed
        self._half_periods = rule["unit"] == "half_period_us"
        self._step_s = (2 * value + rule.get("overhead_us", 0)) / 1e6 if self._half_periods else 1 / value
        x_per_mm, y_per_mm = boards.steps_per_mm(board)
        self._y_in_x = x_per_mm / y_per_mm
        tool = board["tool"]
        self._delay_s = {True: tool.get("on_ms", 0) / 1000, False: tool.get("off_ms", 0) / 1000}

    def object_s(self, points, start=(0, 0), pen=False):
        """Return the seconds that each of [(pen_down, x, y), ...] takes from the point before it, beginning at `start`."""
        seconds = []
        x, y = start
        for down, to_x, to_y in points:
            delay = self._delay_s[down] if down != pen else 0.0
            seconds.append(self._path_length(to_x - x, to_y - y) * self._step_s + delay)
            pen, x, y = down, to_x, to_y
        return seconds

    def lines_s(self, lines):
        """Return the seconds of lines of (x, y) steps, each drawn with the pen down, beginning at 0;0 with the pen up."""
        if not lines:
            return 0.0
        points = numpy.array([(0, 0), *(point for line in lines for point in line)], dtype=float)
        ways = abs(numpy.diff(points, axis=0))
        lengths = ways.max(axis=1) if self._half_periods else numpy.hypot(ways[:, 0], ways[:, 1] * self._y_in_x)
        delays = len(lines) * self._delay_s[True] + (len(lines) - 1) * self._delay_s[False]
        return float(lengths.sum()) * self._step_s + delays

    def _path_length(self, dx, dy):
        return max(abs(dx), abs(dy)) if self._half_periods else math.hypot(dx, dy * self._y_in_x)


def clock_text(seconds):
    """Return a duration as h:mm:ss or m:ss."""
    whole = max(0, round(seconds))
    hours, minutes = divmod(whole // 60, 60)
    return f"{hours}:{minutes:02d}:{whole % 60:02d}" if hours else f"{minutes}:{whole % 60:02d}"
