"""Estimates how long the lines of a G-code file take, roughly, before anything has moved.

    limits = Limits.of_settings(["$110=5000.000", …])
    seconds = estimate_seconds(lines, limits)       # [(number, bytes)] → one figure a line

A line takes its length at its feed rate, bounded by the axes' highest speeds and accelerations. At corners of 10° or
more the machine is assumed to stop; between two stops it speeds up and slows down over as many lines as it takes. Offsets, probing,
homing and pauses are ignored: the measured pace corrects for them (see `Remaining`).
"""

import math
import re
from dataclasses import dataclass

from host_tools.programs.toolpath import sweep_of

_WORD = re.compile(rb"([A-Z])([-+]?\d*\.?\d*)")
_ALONG_X = re.compile(rb"(?:G([01]))?X(-?\d+(?:\.\d*)?)(?:S[\d.]*)?")  # a dot of a picture: most lines of large files are such
_LEFT, _RIGHT = (-1.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
_STRAIGHT = math.cos(math.radians(10))
_DEFAULT_SPEED, _DEFAULT_ACCELERATION = 1000.0, 200.0
_AXES = b"XYZA"
_PLANES = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0)}
_CENTRES = {b"I": 0, b"J": 1, b"K": 2}


@dataclass
class Limits:
    """Of each axis: mm/s and mm/s²."""

    speeds: list
    accelerations: list

    @classmethod
    def of_settings(cls, lines):
        """Make Limits of the answer to $$; assumes defaults for missing settings."""
        values = settings_of(lines)
        return cls(
            [values.get(110 + axis, _DEFAULT_SPEED) / 60 for axis in range(4)],
            [values.get(120 + axis, _DEFAULT_ACCELERATION) for axis in range(4)],
        )

    @classmethod
    def of_board(cls, board):
        """Make Limits of a board file's dict. An axis that it does not have gets the limits of the last one."""
        axes = [board["axes"][min(axis, len(board["axes"]) - 1)] for axis in range(4)]
        return cls([axis["max_mm_min"] / 60 for axis in axes], [axis["accel_mm_s2"] for axis in axes])


def settings_of(lines):
    """Return {number: value} of the answer to $$."""
    return {int(number): float(value) for number, value in re.findall(r"\$(\d+)=([\d.]+)", "\n".join(lines))}


class _State:
    """The state that stays from line to line."""

    def __init__(self):
        self.motion = 0
        self.plane = _PLANES[17]
        self.scale = 1.0
        self.relative = False
        self.inverse = False  # G93
        self.feed = 0.0  # mm/min
        self.place = [0.0] * 4

    def is_plain(self):
        """True if X is a position in mm, and a line of X alone is straight."""
        return self.motion < 2 and self.scale == 1.0 and not self.relative and not self.inverse


def estimate_seconds(lines, limits):
    """Return the seconds that each of [(number, bytes)] takes."""
    state = _State()
    seconds = []
    run = []  # (index, length, speed, acceleration) of lines between two stands
    before = None  # direction at the end of the previous line
    for index, (_, line) in enumerate(lines):
        plain = _ALONG_X.fullmatch(line) if state.is_plain() else None
        dwell, move = _along_x(plain, state) if plain else _read_line(line.upper(), state)
        seconds.append(dwell)
        if dwell:
            before = None
        if move and move[0]:
            length, deltas, into, out, rapid, per_min = move
            speed, acceleration = (limits.speeds[0], limits.accelerations[0]) if plain else _path_limits(deltas, length, limits)
            if per_min:
                speed = min(speed, length * per_min / 60)
            elif not rapid and state.feed:
                speed = min(speed, state.feed / 60)
            if not before or before is not into and sum(a * b for a, b in zip(before, into)) <= _STRAIGHT:
                _add_run(seconds, run)
                run = []
            run.append((index, length, speed, acceleration))
            before = out
    _add_run(seconds, run)
    return seconds


def _add_run(seconds, run):
    """Add the times of lines that are passed from one stand to the next: speeds at their ends from both sides, then a ramp up, an even
    stretch and a ramp down each."""
    ends = [0.0, *(min(one[2], next_[2]) for one, next_ in zip(run, run[1:])), 0.0]
    for at in range(len(run) - 1, 0, -1):
        ends[at] = min(ends[at], math.sqrt(ends[at + 1] ** 2 + 2 * run[at][3] * run[at][1]))
    for at, (index, length, speed, acceleration) in enumerate(run):
        begin = ends[at]
        end = ends[at + 1] = min(ends[at + 1], math.sqrt(begin**2 + 2 * acceleration * length))
        peak = min(speed, math.sqrt((begin**2 + end**2) / 2 + acceleration * length))
        ramps = (2 * peak**2 - begin**2 - end**2) / (2 * acceleration)
        seconds[index] += (2 * peak - begin - end) / acceleration + max(0.0, length - ramps) / peak


def _path_limits(deltas, length, limits):
    """Return the highest speed (mm/s) and acceleration (mm/s²) along a path with these axis distances."""
    shares = [abs(delta) / length for delta in deltas]
    return tuple(
        min(bound / share for bound, share in zip(bounds, shares) if share > 1e-9)
        for bounds in (limits.speeds, limits.accelerations)
    )


def _along_x(match, state):
    """Read a line that moves X alone; return the same as _read_line()."""
    if match[1]:
        state.motion = int(match[1])
    x, begun = float(match[2]), state.place[0]
    if x == begun:
        return 0.0, None
    state.place = [x, *state.place[1:]]
    direction = _RIGHT if x > begun else _LEFT
    return 0.0, (abs(x - begun), None, direction, direction, state.motion == 0, 0.0)


def _read_line(line, state):
    """Read one line; return (seconds of dwell, None or (length, way of each axis, direction in, direction out, rapid, moves a minute)), in mm."""
    if line.startswith(b"$"):
        return 0.0, None
    words = [(letter, float(value)) for letter, value in _WORD.findall(line) if value.strip(b"+-.")]
    values = dict(words)
    codes = [round(value * 10) for letter, value in words if letter == b"G"]
    for code in codes:
        if code in (0, 10, 20, 30):
            state.motion = code // 10
        elif code in (170, 180, 190):
            state.plane = _PLANES[code // 10]
        elif code in (200, 210):
            state.scale = 25.4 if code == 200 else 1.0
        elif code in (900, 910):
            state.relative = code == 910
        elif code in (930, 940):
            state.inverse = code == 930
    if values.get(b"F", 0.0) < 0 or values.get(b"P", 0.0) < 0:
        return 0.0, None  # a machine refuses the line
    if b"F" in values and not state.inverse:
        state.feed = values[b"F"] * state.scale
    if 40 in codes:
        return values.get(b"P", 0.0), None
    if {100, 280, 300, 530, 920, 921} & set(codes):
        return 0.0, None
    target = state.place[:]
    for axis, letter in enumerate((b"X", b"Y", b"Z", b"A")):
        if letter in values:
            target[axis] = values[letter] * state.scale + (state.place[axis] if state.relative else 0.0)
    arc = state.motion in (2, 3) and (values.keys() & (_CENTRES.keys() | {b"R"}))
    if target == state.place and not arc:
        return 0.0, None
    begun, state.place = state.place, target
    per_min = values.get(b"F", 0.0) if state.inverse and state.motion else 0.0
    if arc:
        return 0.0, (*_arc_length(begun, target, values, state), False, per_min)
    deltas = [to - at for to, at in zip(target, begun)]
    length = math.dist(target, begun)
    direction = [delta / length for delta in deltas]
    return 0.0, (length, deltas, direction, direction, state.motion == 0, per_min)


def _arc_length(begun, target, values, state):
    """Return (length, way of each axis, direction in, direction out) of an arc or a helix, in mm."""
    first, second, third = state.plane
    across = target[first] - begun[first], target[second] - begun[second]
    clockwise = state.motion == 2
    if b"R" in values:
        radius = values[b"R"] * state.scale
        chord = math.hypot(*across)
        height = math.sqrt(max(0.0, radius * radius - chord * chord / 4)) / max(chord, 1e-9)
        side = -1 if clockwise != (radius < 0) else 1
        centre = across[0] / 2 - side * across[1] * height, across[1] / 2 + side * across[0] * height
    else:
        by_axis = {axis: values.get(letter, 0.0) * state.scale for letter, axis in _CENTRES.items()}
        centre = by_axis[first], by_axis[second]
    radius = math.hypot(*centre)
    start = math.atan2(-centre[1], -centre[0])
    end = math.atan2(across[1] - centre[1], across[0] - centre[0])
    sweep = sweep_of((0.0, 0.0), across, centre, clockwise, values[b"R"] < 0 if b"R" in values else None)
    sweep += 2 * math.pi * max(0.0, values.get(b"P", 1.0) - 1)
    way = radius * sweep
    rise = target[third] - begun[third]
    length = math.hypot(way, rise)
    deltas = [0.0] * 4
    deltas[first] = deltas[second] = way  # somewhere on the arc one axis has all of the speed
    deltas[third] = rise
    turn = -1 if clockwise else 1

    def direction_at(angle):
        found = [0.0] * 4
        found[first], found[second] = -turn * math.sin(angle), turn * math.cos(angle)
        return found

    return length, deltas, direction_at(start), direction_at(end)


class Remaining:
    """The time left of a job, from the estimate of its lines and the time that the finished ones have taken.

    remaining = Remaining(estimate_seconds(lines, limits))
    remaining.seconds_left(index, gone_s)         # seconds left in line `index` of the list, `gone_s` after the start
    remaining.share                     # of the job that is done, 0 … 1
    """

    def __init__(self, seconds):
        self._seconds = seconds
        self._until = [0.0]  # estimated beginning of each line, and end of the last
        for taken in seconds:
            self._until.append(self._until[-1] + taken)
        self._index = 0
        self._entered_s = 0.0  # when the line under way began
        self.share = 0.0

    def seconds_left(self, index, gone_s):
        """Return the seconds left in line `index` of the list, `gone_s` after the start. Sets `share`."""
        total = self._until[-1]
        index = min(index, len(self._seconds))
        if index != self._index:
            self._index, self._entered_s = index, gone_s
        thought = self._until[index]
        # Up to a tenth of the job the estimate counts for more than the measurement.
        trust = max(total / 10, 1e-9)
        pace = (self._entered_s + trust) / (thought + trust)
        here = self._seconds[index] if index < len(self._seconds) else 0.0
        inside = min(gone_s - self._entered_s, here * pace)
        left = max(0.0, (total - thought) * pace - inside)
        if total:
            share = 1.0 if index == len(self._seconds) else min(1.0, (thought + inside / pace) / total)
        else:
            share = index / max(1, len(self._seconds))
        self.share = max(self.share, share)  # rounding may say a little less than before
        return left
