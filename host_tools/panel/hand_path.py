"""The path of moves by hand as straight lines and arcs of G-code that stay within a step of it.

    lines = fit_program([(0, 0), (10, 0)], [[(5, 0)]], (320, 320))      # positions in mm, what was seen on the way to each, steps/mm
    # ["G1 X10.000"]

A way whose positions lie on its chord is straight; all others go where they were seen. From each position on, the line or arc that leads
farthest is taken. An arc's third axis goes along with its angle, as in a helix. If axes differ in scale, a step is the longer one.
"""

import math

from host_tools.page.teach import line_to

_OFF = 1.0  # steps that a position may lie off its line or arc
_LEAST_ARC = 4  # positions
_SAGITTA = 2.0  # steps; flatter than that is straight
_PLANES = ((0, 1, 17, "IJ"), (2, 0, 18, "KI"), (1, 2, 19, "JK"))


def fit_program(points, ways, scales):
    """Return the lines of G-code that lead from points[0] on. `points`: positions at rest in mm; `ways`: the positions seen on the way to each but
    the first; `scales`: steps/mm. Needs numpy."""
    path = _Path(points, ways, scales)
    lines, plane, at = [], 17, 0
    while at < len(path.steps) - 1:
        line = path.line_end(at)
        arc = path.arc_from(at, line)
        if arc is None:
            lines.append(line_to(path.position_mm(line), path.position_mm(at)))
            at = line
            continue
        end, code, centre, letters, clockwise = arc
        if code != plane:
            lines.append(f"G{code}")
            plane = code
        words = "".join(f" {letter}{by:.4f}" for letter, by in zip(letters, centre))
        target = " ".join(f"{'XYZA'[axis]}{value:.3f}" for axis, value in enumerate(path.position_mm(end)))
        lines.append(f"G{2 if clockwise else 3} {target}{words}")
        at = end
    return [line for line in lines if line != "G1 "] + (["G17"] if plane != 17 else [])


class _Path:
    """Positions in steps, from the first rest to the last: rests, what was seen on the way, and the middles of straight ways."""

    def __init__(self, points, ways, scales):
        self._scales = scales[: len(points[0])]
        self._positions = [points[0]]
        self._rests = {0}  # positions in it at which the machine stood
        for at, way in enumerate(ways):
            before, after = points[at], points[at + 1]
            if self._is_straight([self._in_steps(position) for position in (before, *way, after)]):
                way = [[(a + b) / 2 for a, b in zip(before, after)]]
            self._positions += [*way, after]
            self._rests.add(len(self._positions) - 1)
        self.steps = [self._in_steps(position) for position in self._positions]

    def position_mm(self, at):
        return self._positions[at]

    def _in_steps(self, position):
        return [value * scale for value, scale in zip(position, self._scales)]

    def _farthest_fit(self, first, fits):
        """The index of the last position up to which fits(end) holds; fits(first) is taken for granted. Searches by doubling, then halving. Prefers
        a position at which the machine stood, because another move begins there."""
        last = len(self.steps) - 1
        good, step = first, 1
        while good < last and fits(min(good + step, last)):
            good = min(good + step, last)
            step *= 2
        bad = min(good + step, last + 1)
        while bad - good > 1:
            middle = (good + bad) // 2
            good, bad = (middle, bad) if fits(middle) else (good, middle)
        return next((at for at in range(good, first - 1, -1) if at in self._rests), good)

    def line_end(self, at):
        """The index at which the straight line from index `at` ends."""
        return self._farthest_fit(at + 1, lambda end: self._is_straight(self.steps[at : end + 1]))

    @staticmethod
    def _is_straight(positions):
        """True if positions, in steps, lie on the straight line from the first to the last, one behind the other."""
        first, last = positions[0], positions[-1]
        way = [b - a for a, b in zip(first, last)]
        length = math.hypot(*way)
        if length == 0:
            return all(math.dist(position, first) <= _OFF for position in positions)
        before = 0.0
        for position in positions[1:]:
            part = [b - a for a, b in zip(first, position)]
            along = sum(a * b for a, b in zip(part, way)) / length
            off = max(abs(a - along * b / length) for a, b in zip(part, way))
            if off > _OFF or along < before - _OFF or along > length + _OFF:
                return False
            before = max(before, along)
        return True

    def arc_from(self, at, line):
        """(end, plane's code, centre from the start in mm, its letters, clockwise) of the arc from `at` that leads beyond `line`, or
        None."""
        best = None
        for first, second, code, letters in _PLANES:
            if max(first, second) < len(self._scales):
                found = self._arc_in(at, max(line + 1, at + _LEAST_ARC), (first, second))
                if found and (best is None or found[0] > best[0]):
                    end, centre, clockwise = found
                    best = end, code, centre, letters, clockwise
        return best

    def _arc_in(self, at, least, plane):
        """(end, centre in mm from the start, clockwise) of the longest arc in the plane of two axes from index `at` to `least` or beyond; None:
        none fits."""
        last = len(self.steps) - 1
        count = least - at
        while at + count <= last:
            found = self._fit_arc(at, at + count, plane)
            if found is None:
                return None
            if found[2] >= _SAGITTA:
                break
            count = min(2 * count, last - at) if at + count < last else last + 1
        else:
            return None
        end = self._farthest_fit(at + count, lambda end: self._fit_arc(at, end, plane) is not None)
        return (end, *self._fit_arc(at, end, plane)[:2])

    def _fit_arc(self, at, end, plane):
        """(centre in mm from the start, clockwise, sagitta in steps) of the arc on which the positions lie, or None."""
        import numpy as np

        from host_tools.programs.recognition import fit_circle, near_centres

        fine, coarse = [pick([self._scales[axis] for axis in plane]) for pick in (max, min)]
        flat = np.array(self._positions[at : end + 1])[:, list(plane)] * fine
        flat -= flat[0]
        most = _OFF * fine / coarse
        found = fit_circle(flat)
        if found is None:
            return None
        off, centre = min((_distance_off(flat, each), each) for each in near_centres(found[0], 1))
        if off > most:
            return None
        spokes = flat - np.array(centre)
        angles = np.unwrap(np.arctan2(spokes[:, 1], spokes[:, 0]))
        turned = angles - angles[0]
        radius = float(np.hypot(*centre))
        slack = 2 * most / radius
        clockwise = bool(turned[-1] < 0)
        turned = -turned if clockwise else turned
        if (np.diff(turned) < -slack).any() or turned[-1] > 2 * math.pi + 1e-7:  # beyond a whole turn G-code would turn by the excess
            return None
        positions = np.array(self.steps[at : end + 1])
        for axis in range(positions.shape[1]):
            if axis not in plane:
                along = positions[0, axis] + (positions[-1, axis] - positions[0, axis]) * turned / turned[-1]
                if np.abs(positions[:, axis] - along).max() > _OFF:
                    return None
        return [by / fine for by in centre], clockwise, radius * (1 - math.cos(min(turned[-1], math.pi) / 2))


def _distance_off(flat, centre):
    """The distance of the farthest position from the circle through 0;0 about `centre`, in steps."""
    import numpy as np

    return float(np.abs(np.hypot(*(flat - np.array(centre)).T) - np.hypot(*centre)).max())
