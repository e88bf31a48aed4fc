"""LinuxCNC's interpreter (`rs274` of Debian's linuxcnc-uspace) and a Passo board, each asked for the path of one program.

    path = of_linuxcnc("part.ngc", "tools.tbl")     # None: refused
    path = of_board(listing.codes)
    differs(path, other)        # "", or what differs

A path is [(rapid, points, minutes)]: one row for each motion, points in mm of the machine, A, their fourth entry, in degrees; `minutes`
that F wants of a line, None for others.
"""

import math
import os
import re
import shutil
import subprocess

import numpy as np

from host_tools.programs.replay_machine import Board, Machine, Memory, commands_of
from passo import commands
from passo.protocols.gcode.offsets import Offsets
from passo.protocols.gcode.parser import GCode

RS274 = shutil.which("rs274")
WITHIN_MM = 0.03  # rs274 prints inches with four decimals, and takes arcs whose ends differ by 0.028 mm
STEPS_PER_MM = 10000
_CALL = re.compile(r"^\s*\d+\s+N\S*\s+(\w+)\((.*)\)")
_SAG_MM = 0.002


def chords(begin, end, centre, plane, clockwise, turns=1):
    """Points on an arc or helix, its start left out."""
    first, second, third = plane
    spoke = begin[first] - centre[0], begin[second] - centre[1]
    out = end[first] - centre[0], end[second] - centre[1]
    start, stop = math.atan2(spoke[1], spoke[0]), math.atan2(out[1], out[0])
    sweep = (start - stop if clockwise else stop - start) % math.tau
    if sweep < 1e-6 or sweep > math.tau - 1e-6:
        sweep = math.tau
    sweep += math.tau * (turns - 1)
    radii = math.hypot(*spoke), math.hypot(*out)
    count = max(4, math.ceil(sweep / (2 * math.acos(max(0.0, 1 - _SAG_MM / max(radii[0], _SAG_MM))))))
    share = np.linspace(0, 1, count + 1)[1:]
    angle = start + (-1 if clockwise else 1) * sweep * share
    radius = radii[0] + (radii[1] - radii[0]) * share
    points = np.empty((count, 4))
    points[:, 3] = begin[3]
    points[:, first], points[:, second] = centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)
    points[:, third] = begin[third] + (end[third] - begin[third]) * share
    points[-1] = end
    return points


def minutes(begin, end, feed, turning):
    """Return the minutes that a line takes: `feed`, mm/min, counts for X, Y and Z; `turning`, degrees/min, counts if only A moves by more than rounding.
    None: no feed.
    """
    length, angle = np.linalg.norm(end[:3] - begin[:3]), abs(end[3] - begin[3])
    far, fast = (length, feed) if length > 0.01 else (angle, turning)
    return far / fast if fast else None


class _Canon:
    """Carry out the calls that rs274 prints."""

    def __init__(self):
        self.scale, self.plane = np.ones(4), (0, 1, 2)
        self.system, self.shift, self.tool, self.turned = np.zeros(4), np.zeros(4), np.zeros(4), 0.0
        self.here = np.zeros(4)
        self.feeds = 0.0, 0.0  # mm/min, degrees/min
        self.path = []

    def machine(self, place):
        x, y, *others = np.array(place) + self.shift
        cos, sin = math.cos(self.turned), math.sin(self.turned)
        return np.array([x * cos - y * sin, x * sin + y * cos, *others]) + self.system + self.tool

    def call(self, name, values):
        if name == "USE_LENGTH_UNITS":
            self.scale = np.array([*[25.4 if "INCHES" in values else 1.0] * 3, 1.0])
        elif name == "SET_FEED_RATE":
            self.feeds = float(values) * self.scale[0], float(values)
        elif name == "SELECT_PLANE":
            self.plane = {"XY": (0, 1, 2), "XZ": (2, 0, 1), "YZ": (1, 2, 0)}[values[-2:]]
        elif name == "SET_G5X_OFFSET":
            self._move_origin("system", values.split(",")[1:5])
        elif name == "SET_G92_OFFSET":
            self._move_origin("shift", values.split(",")[:4])
        elif name == "USE_TOOL_LENGTH_OFFSET":
            self._move_origin("tool", [*values.split(",")[0].split(), 0])
        elif name == "SET_XY_ROTATION":
            self.turned = math.radians(float(values))
        elif name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED", "STRAIGHT_PROBE"):
            numbers = [float(each) for each in values.split(",")[:4]]
            rapid, to = name == "STRAIGHT_TRAVERSE", self.machine(np.array(numbers) * self.scale)
            self._go(rapid, to[None], None if rapid else minutes(self.here, to, *self.feeds))
        elif name == "ARC_FEED":
            self._arc([float(each) for each in values.split(",")])
        elif name == "NURBS_FEED":
            raise ValueError("rs274 prints no points of a spline")

    def _move_origin(self, which, values):
        setattr(self, which, np.array([float(each) for each in values]) * self.scale)

    def _arc(self, values):
        end, centre, turns, height = values[:2], values[2:4], int(values[4]), values[5]
        first, second, third = self.plane
        places = np.zeros((2, 4))  # in the program's coordinates: only XY arcs may be turned
        places[0, [first, second, third]] = [*end, height]
        places[1, [first, second, third]] = [*centre, height]
        places[:, 3] = values[6]
        to, middle = (self.machine(place * self.scale) for place in places)
        points = chords(self.here, to, (middle[first], middle[second]), self.plane, turns < 0, abs(turns))
        self._go(False, points)

    def _go(self, rapid, points, time=None):
        self.path.append((rapid, np.vstack([self.here[None], points]), time))
        self.here = points[-1]


def of_linuxcnc(program, table=None, skip=False, cwd=None):
    """The path of a program's file; None if rs274 refuses it."""
    words = [RS274, *(["-t", str(table)] if table else []), *(["-b"] if skip else []), "-g", str(program)]
    try:
        folder = cwd or program.parent
        own = {**os.environ, "HOME": str(folder)}  # rs274 keeps its table of tools there: two at once spoil each other's
        found = subprocess.run(words, capture_output=True, timeout=60, cwd=folder, env=own, stdin=subprocess.DEVNULL)
    except subprocess.TimeoutExpired:
        return None
    errors = [line for line in found.stderr.decode("latin-1").splitlines() if line and line != "executing"]
    if found.returncode or errors:
        return None
    canon = _Canon()
    for line in found.stdout.decode("latin-1").splitlines():
        call = _CALL.match(line)
        if call:
            canon.call(*call.groups())
    return canon.path


def of_board(codes, short_way=False, linear=False):
    """The path of lines of plain G-code, as the firmware's parser understands them; `short_way`: the board file's; `linear`: A is. Raises
    ValueError if it refuses one."""
    machine = Machine([STEPS_PER_MM] * 4, 0.0, True, False, 1e6)
    board = Board(machine)
    board.target = [0, 0, 0, 0]
    gcode = GCode("xyza", Offsets(4, Memory(machine)), board)
    gcode.turns = 0 if linear else 3 if short_way else 1
    path, here = [], np.zeros(4)
    for code in codes:
        error = gcode.interpret_line(code.replace(" ", "").encode())
        if error:
            raise ValueError(f"{code}: error {error}")
        for command in commands_of(gcode.commands):
            if command.target is None:
                continue
            board.target = list(command.target)
            to = np.array(command.target) / STEPS_PER_MM
            points = to[None]
            if command.kind == commands.ARC:
                plane = command.first, command.second, 3 - command.first - command.second
                centre = [here[axis] + by / STEPS_PER_MM for axis, by in zip(plane, command.centre)]
                points = chords(here, to, centre, plane, command.clockwise, command.turns)
            rapid = command.kind == commands.LINE and not command.feed and not command.per_min
            time = None
            if command.kind != commands.ARC and not rapid:
                time = 1000 / command.per_min if command.per_min else minutes(here, to, *[command.feed * 60 / 1e6] * 2)
            path.append((rapid, np.vstack([here[None], points]), time))
            here = to
    return path


def _flat(path):
    """(points, lengths up to each, rapid or not of each step) without motions of no length."""
    points = [path[0][1][:1]] + [rows[1:] for _, rows, _ in path] if path else [np.zeros((1, 4))]
    rapid = np.concatenate([[each] * (len(rows) - 1) for each, rows, _ in path] or [[]])
    points = np.vstack(points)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    keep = steps > 1e-6
    return np.vstack([points[:1], points[1:][keep]]), np.concatenate([[0.0], np.cumsum(steps[keep])]), rapid[keep]


def differs(path, other, within=WITHIN_MM):
    """Return the difference between two paths as text; "" if they are equal."""
    (one, gone, rapid), (two, went, fast) = _flat(path), _flat(other)
    if abs(gone[-1] - went[-1]) > within + 2e-4 * gone[-1]:
        return f"lengths {gone[-1]:.3f} and {went[-1]:.3f}"
    if not gone[-1] or not went[-1]:
        return ""
    at, along = 0, np.linspace(0, 1, 20001)
    places = [np.stack([np.interp(along * far[-1], far, rows[:, axis]) for axis in range(4)], 1) for rows, far in ((one, gone), (two, went))]
    # Lengths that differ a little shift the two along the path: a point counts as the same if the other path passes it nearby.
    apart = np.linalg.norm(places[0] - places[1], axis=1)
    if apart.max() > within + 2 * abs(gone[-1] - went[-1]) + 1e-4 * gone[-1]:
        at = int(apart.argmax())
        return f"{apart.max():.3f} mm apart at {np.round(places[0][at], 3)} and {np.round(places[1][at], 3)}"
    kinds = [kind[np.minimum(np.searchsorted(far, along[1:] * far[-1] - 1e-9, "left") - 1, len(kind) - 1)] for kind, far in ((rapid, gone), (fast, went))]
    unlike = (kinds[0] != kinds[1]).mean()
    return f"rapid and feed differ on {unlike:.1%} of the way" if unlike > 0.01 else ""
