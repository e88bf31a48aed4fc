"""The path that lines of G-code ask for, in floats and by another reader than the firmware's, and the distance of the firmware's steps from it.

    python tests_host/properties/true_path.py part.gcode 320000     # with so many steps a metre on every axis

Prints the lines that move, the words with a step, and the farthest that one of them is off the true line or arc: in
millimetres, in steps, and in which line. Understands what motion needs: G0–G3 with I J K, R and P, planes, units, G90, G91,
G92. Lines that the firmware refuses count for nothing.
"""

import sys
from math import atan2, pi, sqrt

EPSILON = 5e-7  # grbl's ARC_ANGULAR_TRAVEL_EPSILON
PLANES = {17: (0, 1), 18: (2, 0), 19: (1, 2)}


class Arc:
    """Lies in a plane, begins at 0;0 there, and rises evenly."""

    def __init__(self, end, centre, clockwise, turns=1, sweep=None):
        """`sweep` in radians, without full turns; None: grbl's sweep of end and centre."""
        self.end, self.centre, self.turns = end, centre, turns
        self.sign = -1 if clockwise else 1
        self.radius = sqrt(centre[0] ** 2 + centre[1] ** 2)
        if sweep is None:
            sweep = self._angle(end[0], end[1])
            if sweep <= EPSILON:
                sweep += 2 * pi
        self.sweep = sweep
        self.wholly = sweep + 2 * pi * (turns - 1)

    def _angle(self, x, y):
        """From the start to (x, y), −π … π, the arc's sense positive."""
        i, j = -self.centre[0], -self.centre[1]
        u, w = x - self.centre[0], y - self.centre[1]
        return atan2((i * w - j * u) * self.sign, i * u + j * w)

    def distance(self, x, y):
        """(how far (x, y) is off the arc, its angle from the start, 0 … 2π)."""
        angle = self._angle(x, y) % (2 * pi)
        if self.turns > 1 or angle <= self.sweep:
            u, w = x - self.centre[0], y - self.centre[1]
            return abs(sqrt(u * u + w * w) - self.radius), angle
        return min(sqrt(x * x + y * y), sqrt((x - self.end[0]) ** 2 + (y - self.end[1]) ** 2)), angle


def centre_by_radius(x, y, radius, clockwise):
    """The centre of the arc from 0;0 to (x, y): the short way round for a positive radius."""
    chord = sqrt(x * x + y * y)
    away = sqrt(max(radius * radius - chord * chord / 4, 0)) * (1 if clockwise == (radius < 0) else -1)
    return x / 2 - away * y / chord, y / 2 + away * x / chord


class Reader:
    """Lines of G-code to [(start, end, arc or None, plane)], in millimetres."""

    def __init__(self):
        self.motion, self.plane, self.unit, self.absolute = 0, 17, 1.0, True
        self.place = [0.0] * 3  # in the machine's coordinates
        self.offset = [0.0] * 3

    def read(self, line):
        """Return the motion of the line, or None."""
        words, codes, shifts = {}, [], False
        for letter, value in split(line):
            if letter == "G":
                codes.append(value)
            else:
                words[letter] = value
        for code in codes:
            if code in (0, 1, 2, 3):
                self.motion = int(code)
            elif code in PLANES:
                self.plane = int(code)
            elif code in (20, 21):
                self.unit = 25.4 if code == 20 else 1.0
            elif code in (90, 91):
                self.absolute = code == 90
            elif code == 92:
                shifts = True
        for letter in "XYZIJKR":
            if letter in words:
                words[letter] *= self.unit
        if shifts:
            for axis in range(3):
                if "XYZ"[axis] in words:
                    self.offset[axis] = self.place[axis] - words["XYZ"[axis]]
            return None
        start, end = self.place, self.place[:]
        for axis in range(3):
            if "XYZ"[axis] in words:
                end[axis] = words["XYZ"[axis]] + (self.offset[axis] if self.absolute else start[axis])
        turns = self.motion in (2, 3) and [letter for letter in "IJKR" if letter in words]
        if end == start and not turns:
            return None
        self.place = end
        return start, end, self._arc(words, start, end) if self.motion in (2, 3) else None, self.plane

    def _arc(self, words, start, end):
        a, b = PLANES[self.plane]
        x, y = end[a] - start[a], end[b] - start[b]
        clockwise = self.motion == 2
        sweep = None
        if "R" in words:
            radius = words["R"]
            centre = centre_by_radius(x, y, radius, clockwise)
            sweep = 2 * atan2(sqrt(x * x + y * y) / 2, sqrt(max(radius * radius - (x * x + y * y) / 4, 0)))
            if radius < 0:
                sweep = 2 * pi - sweep
        else:
            centre = words.get("IJK"[a], 0.0), words.get("IJK"[b], 0.0)
        return Arc((x, y), centre, clockwise, int(words.get("P", 1)), sweep)


def split(line):
    """[(letter, value)]"""
    found = []
    digits = letter = ""
    for character in line.upper() + " ":
        if character.isdigit() or character in ".+-":
            digits += character
        elif character != " ":
            if letter and digits:
                found.append((letter, float(digits)))
            letter, digits = character, ""
    if letter and digits:
        found.append((letter, float(digits)))
    return found


def farthest(path, move, per_mm):
    """How far the farthest of the places in `path`, in steps, is off `move`, in steps of the coarsest axis."""
    start, end, arc, plane = move
    coarse = min(per_mm)
    worst = 0.0
    if arc is None:
        along = [to - at for at, to in zip(start, end)]
        square = sum([by * by for by in along])
        for place in path:
            off = [at / per - begin for at, per, begin in zip(place, per_mm, start)]
            share = sum([by * to for by, to in zip(off, along)]) / square if square else 0
            share = min(max(share, 0), 1)
            worst = max(worst, sum([(by - share * to) ** 2 for by, to in zip(off, along)]))
        return sqrt(worst) * coarse
    a, b = PLANES[plane]
    third = 3 - a - b
    turned = before = None
    for place in path:
        off, angle = arc.distance(place[a] / per_mm[a] - start[a], place[b] / per_mm[b] - start[b])
        if arc.radius * coarse > 8:
            if turned is None:
                before = turned = angle if angle <= pi else angle - 2 * pi
            turned += (angle - before + 3 * pi) % (2 * pi) - pi
            before = angle
            share = min(max(turned / arc.wholly, 0), 1)
            rise = place[third] / per_mm[third] - start[third] - share * (end[third] - start[third])
            off = sqrt(off * off + rise * rise)
        worst = max(worst, off)
    return worst * coarse


def compare(lines, steps_per_m):
    """(lines that move, words with a step, the farthest in steps, its line) of [(number, text)]."""
    from gcode_walk import Bench

    bench = Bench(steps_per_m)
    reader = Reader()
    per_mm = [per_m / 1000 for per_m in steps_per_m]
    moves = words = at = 0
    worst = 0.0
    for number, text in lines:
        path = bench.attempt(text)
        if path is None:
            continue
        move = reader.read(text)
        if move is None:
            assert len(path) == 1, (number, text)
            continue
        moves += 1
        words += len(path) - 1
        off = farthest(path, move, per_mm)
        if off > worst:
            worst, at = off, number
    return moves, words, worst, at


def compare_file(file, steps_per_m):
    from host_tools.programs import gcode_file

    return compare([(number, line.decode()) for number, line in gcode_file.read(file)], [steps_per_m] * 3)


def report(file, steps_per_m, found):
    moves, words, worst, at = found
    return "%-45s %4d steps/mm: %5d lines move, %7d words, farthest %.4f mm = %.2f steps, line %d" % (
        file, steps_per_m // 1000, moves, words, worst * 1000 / steps_per_m, worst, at
    )


if __name__ == "__main__":
    from pathlib import Path

    root = Path(__file__).resolve().parents[2]
    sys.path[:0] = [str(folder) for folder in (root, root / "firmware", root / "host_tools" / "shims")]
    per_m = int(sys.argv[-1])
    for name in sys.argv[1:-1]:
        print(report(Path(name).name, per_m, compare_file(name, per_m)))
