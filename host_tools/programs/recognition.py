"""Recognises straight lines and arcs in a run of single steps: those that the firmware's walkers make, step by step.

    for piece in pieces(moves, arcs=True):      # moves: array of steps × axes, each −1, 0 or 1
        piece.count, piece.deltas, piece.centre, ...

A piece is a line or an arc whose walk is exactly these steps, so what is made of them moves exactly as before.

Lines: with n dominant steps a minor axis has made ceil(s·i + ½) − 1 of its steps after the i-th (line_viper.py), s being its share.
So each step bounds s, (c − ½)/i < s ≤ (c + ½)/i, and the first n steps are a line if their own share lies within all bounds.
Of the ends that are possible the one is taken from which the next line leads farthest: a corner that a line could pass by a step stays
a corner.

Arcs: a circle is fitted to as many steps as lie on one (least squares, through the first point); the whole centres near to its
centre are tried with the firmware's own walker; the one that follows longest counts, if it follows farther than two lines.
"""

from array import array
from dataclasses import dataclass

import numpy as np

_WINDOW = 64  # steps looked at first
_ENDS = 8  # possible ends of a line that are tried
_LEAST_ARC = 16  # steps; a shorter one is as well two lines
_OFF = 1.0  # steps that a point of an arc may lie off the fitted circle
_SAGITTA = 2.0  # steps; flatter than that is straight
_TANGENT = 6  # steps between the end of a line and the foot of the arc's centre on it
_TAIL = 4  # steps by which an arc's end may lie behind the last step on the circle


@dataclass
class Piece:
    count: int  # steps
    deltas: tuple  # signed steps of each axis
    plane: tuple = ()  # of an arc: its two axes
    centre: tuple = ()  # from the start, in steps
    clockwise: bool = False


def pieces(moves, arcs=True):
    """Yield the Pieces of `moves`, in their order. `arcs`: False if axes differ in steps/mm, so that there are no arcs."""
    moves = np.asarray(moves, np.int8)
    finder = _Finder(moves, arcs)
    at = 0
    while at < len(moves):
        piece = finder.next_piece(at)
        yield piece
        at += piece.count


class _Finder:
    def __init__(self, moves, arcs):
        self._moves = moves
        self._places = np.concatenate([np.zeros((1, moves.shape[1]), np.int64), np.cumsum(moves, axis=0, dtype=np.int64)])
        self._arcs = arcs and moves.shape[1] > 1
        self._known = {}  # ends of lines, by their beginning

    def next_piece(self, at):
        """Return the Piece that begins at step `at`: an arc if one longer than the line fits, else the line."""
        count, two = self._find_line(at)
        if self._arcs:
            found = self._find_arc(at, max(two, _LEAST_ARC))
            if found:
                return found
            count = self._before_an_arc(at, count)
        return Piece(count, self._deltas_of(at, at + count))

    def _deltas_of(self, begin, end):
        return tuple(int(delta) for delta in self._places[end] - self._places[begin])

    # --- lines

    def _find_line(self, at):
        """Return (steps of the line from `at`, steps of it and the next one)."""
        ends = self._line_ends(at)
        if at + ends[-1] == len(self._moves):
            return ends[-1], ends[-1]
        best = max((count + self._line_reach(at + count), count) for count in ends[-_ENDS:])
        return best[1], best[0]

    def _line_reach(self, at):
        return self._line_ends(at)[-1] if at < len(self._moves) else 0

    def _line_ends(self, at):
        """Return the possible numbers of steps of a line from `at`, in order."""
        if at not in self._known:
            if len(self._known) > 64:
                self._known.clear()
            window = _WINDOW
            while True:
                found, open_end = self._ends_within(at, window)
                if not open_end or at + window >= len(self._moves):
                    break
                window *= 4
            self._known[at] = found
        return self._known[at]

    def _ends_within(self, at, window):
        """Return (the possible numbers of steps of a line from `at` within `window` steps, whether a line could lead beyond)."""
        moves = self._moves[at : at + window]
        signs = [_first_sign(moves[:, axis]) for axis in range(moves.shape[1])]
        same = (moves * np.array(signs, np.int8) >= 0).all(axis=1)
        length = _count_leading(same)
        counts = np.abs(np.cumsum(moves[:length], axis=0, dtype=np.int64))
        index = np.arange(1, length + 1)
        ends, goes_on = set(), False
        for dominant in range(moves.shape[1]):
            full = _count_leading(counts[:, dominant] == index)
            if not full:
                continue
            possible, i = np.ones(full, bool), index[:full]
            feasible = np.ones(full, bool)
            for axis in range(moves.shape[1]):
                if axis != dominant:
                    made = counts[:full, axis]
                    low = np.maximum.accumulate((made - 0.5) / i)
                    high = np.minimum.accumulate((made + 0.5) / i)
                    share = made / i
                    possible &= (low < share) & (share <= high)
                    feasible &= low < high
            ends.update((np.flatnonzero(possible) + 1).tolist())
            goes_on = goes_on or full == len(moves) == window and bool(feasible[-1])
        return sorted(ends), goes_on

    # --- arcs

    def _before_an_arc(self, at, count):
        """Return where the line of `count` steps from `at` ends: if an arc goes on from it without a corner, the arc's first steps lie on the line
        too, and belong to the arc."""
        for plane in ((0, 1), (2, 0), (1, 2)):
            if max(plane) >= self._moves.shape[1]:
                continue
            fitted = self._fit_circle(at + count, plane)
            if fitted is None or fitted[0] < _LEAST_ARC:
                continue
            _, centre, clockwise = fitted
            start, end = self._places[at][list(plane)], self._places[at + count][list(plane)]
            way = end - start
            foot = float(((end - start) + centre) @ way) / float(way @ way or 1) * count
            ends = [each for each in self._line_ends(at) if abs(each - foot) <= _TANGENT]
            best = count, 0
            for each in sorted(ends, key=lambda each: abs(each - foot))[: 2 * _ENDS]:
                x, y = self._places[at + count][list(plane)] - self._places[at + each][list(plane)] + centre
                follows = max(self._count_followed(at + each, whole, clockwise, plane) for whole in near_centres((x, y), 1))
                if follows > count - each + _LEAST_ARC and each + follows > sum(best):
                    best = each, follows
            if best[1]:
                return best[0]
        return count

    def _find_arc(self, at, least):
        """Return the arc from `at`, if there is one of more than `least` steps; else None."""
        best = None
        for plane in ((0, 1), (2, 0), (1, 2)):
            if max(plane) < self._moves.shape[1]:
                fitted = self._fit_circle(at, plane)
                if fitted and (best is None or fitted[0] > best[0]):
                    best = (*fitted, plane)
        if best is None or best[0] <= least:
            return None
        _, centre, clockwise, plane = best
        found = max((self._count_followed(at, each, clockwise, plane), -index, each) for index, each in enumerate(near_centres(centre)))
        if found[0] <= least:
            return None
        return self._end_arc(at, found[0], found[2], clockwise, plane, least)

    def _fit_circle(self, at, plane):
        """Return (steps, centre, clockwise) of the circle through the point at `at` on which the most steps lie, or None."""
        others = [axis for axis in range(self._moves.shape[1]) if axis not in plane]
        still = _count_leading(~self._moves[at:, others].any(axis=1)) if others else len(self._moves) - at
        points = self._places[at : at + still + 1][:, list(plane)] - self._places[at][list(plane)]
        found, count, beyond = None, _WINDOW // 4, still
        while True:
            count = min(count, still)
            fitted = fit_circle(points[: count + 1])
            if fitted is not None and fitted[1] <= _OFF:
                found, beyond = (count, fitted[0]), still
            elif found:
                beyond = min(beyond, count)
            if count == still:
                break
            count *= 2
        if found is None:
            return None
        low, high = found[0], beyond
        while high - low > 8:
            middle = (low + high) // 2
            fitted = fit_circle(points[: middle + 1])
            if fitted is None or fitted[1] > _OFF:
                high = middle
            else:
                low, found = middle, (middle, fitted[0])
        count, (x, y) = found
        radius = float(np.hypot(x, y))
        chord = float(np.hypot(*points[: count + 1].T).max())
        if chord * chord / (8 * radius) < _SAGITTA:
            return None
        far = points[min(count, max(2, int(radius / 2)))]
        clockwise = bool(-x * far[1] + y * far[0] < 0)
        return count, (x, y), clockwise

    def _count_followed(self, at, centre, clockwise, plane):
        """Count the steps from `at` that the walk of the full circle about `centre` makes, too."""
        return self._walk_arc(at, centre, clockwise, plane, [0] * self._moves.shape[1], True)[0]

    def _walk_arc(self, at, centre, clockwise, plane, deltas, over_half):
        """Return (steps that the walk of an arc shares with those from `at`, whether that is all of the walk)."""
        from passo.motion import arc
        from passo.motion.circle import Circle
        from passo.motion.line import MAX_RUN
        from passo.records import ARC_FIELDS

        axes = self._moves.shape[1]
        plan = array("i", [0] * ARC_FIELDS)
        third = 3 - sum(plane) if axes > 2 else -1
        try:
            arc.plan(plan, (*plane, third), centre, list(deltas), clockwise, 0, over_half)
        except ValueError:
            return 0, False
        circle = Circle(axes)
        circle.load(plan)
        out = array("I", [0] * MAX_RUN)
        done = 0
        while circle.left:
            count = min(circle.left, MAX_RUN)
            negative = circle.negative
            circle.walk(out, 0, count)
            masks = np.frombuffer(out, np.uint32)[:count]
            wanted = self._moves[at + done : at + done + count]
            made = np.stack([((masks >> axis) & 1).astype(np.int8) * (-1 if negative >> axis & 1 else 1) for axis in range(axes)], axis=1)
            if len(wanted) < count or not np.array_equal(made, wanted):
                same = made[: len(wanted)] == wanted
                return done + _count_leading(same.all(axis=1)), False
            done += count
        return done, True

    def _end_arc(self, at, follows, centre, clockwise, plane, least):
        """Return the arc that ends at the end of the circle, or a little behind or before it: the longest whose walk is exactly these steps."""
        radius = int(np.hypot(*centre))
        possible = []
        first = min(follows + _TAIL, len(self._moves) - at)
        last = max(follows - 2 * _TAIL - int(2 * radius**0.5), least)
        for count in range(first, last, -1):
            deltas = self._deltas_of(at, at + count)
            x, y = -centre[0], -centre[1]
            end_x, end_y = deltas[plane[0]] + x, deltas[plane[1]] + y
            cross = (x * end_y - y * end_x) * (-1 if clockwise else 1)
            over_half = cross < 0 or cross == 0 and x * end_x + y * end_y > 0
            if self._walk_arc(at, centre, clockwise, plane, deltas, over_half) == (count, True):
                piece = Piece(count, deltas, plane, centre, clockwise)
                if at + count == len(self._moves):
                    return piece
                possible.append((count + self._line_reach(at + count), -self._bend_at(at + count, plane, (end_x, end_y)), count, piece))
        return max(possible, key=lambda row: row[:3])[3] if possible else None

    def _bend_at(self, at, plane, radius):
        """Return how far the line that goes on from `at` is from the arc's tangent there: 0 along it, 1 across it."""
        way = self._places[at + self._line_reach(at)][list(plane)] - self._places[at][list(plane)]
        return round(abs(float(way @ radius)) / float(np.hypot(*way) * np.hypot(*radius) or 1), 3)


def _first_sign(column):
    moving = np.flatnonzero(column)
    return int(column[moving[0]]) if len(moving) else 1


def _count_leading(flags):
    """Count the `flags` that are true before the first that is not."""
    wrong = np.flatnonzero(~np.asarray(flags, bool))
    return int(wrong[0]) if len(wrong) else len(flags)


def fit_circle(points):
    """Fit the circle through 0;0 nearest to `points`; return (centre, how far the farthest point lies off), in steps; None if they lie in a row."""
    x, y = points[:, 0].astype(float), points[:, 1].astype(float)
    square = (x * x + y * y) / 2
    xx, xy, yy = x @ x, x @ y, y @ y
    determinant = xx * yy - xy * xy
    if determinant < 1e-9 * max(xx, yy) ** 2 + 1e-9:
        return None
    right = x @ square, y @ square
    centre = np.array([right[0] * yy - right[1] * xy, right[1] * xx - right[0] * xy]) / determinant
    for _ in range(4):  # of squared distances the short arcs come out too small: on with the distances themselves
        radius = np.hypot(*centre)
        if not 1 < radius < 1 << 20:
            return None
        to_x, to_y = centre[0] - x, centre[1] - y
        far = np.maximum(np.hypot(to_x, to_y), 1e-9)
        off = far - radius
        slope_x, slope_y = to_x / far - centre[0] / radius, to_y / far - centre[1] / radius
        a, b, c = slope_x @ slope_x, slope_x @ slope_y, slope_y @ slope_y
        if a * c - b * b < 1e-12 * max(a, c) ** 2:
            break
        f, g = slope_x @ off, slope_y @ off
        centre = centre - np.array([f * c - g * b, g * a - f * b]) / (a * c - b * b)
    radius = np.hypot(*centre)
    if not 1 < radius < 1 << 20:
        return None
    return (float(centre[0]), float(centre[1])), float(np.abs(np.hypot(x - centre[0], y - centre[1]) - radius).max())


def near_centres(centre, reach=None):
    """Return whole centres around `centre` and along the radius, where a short arc says least; the nearest first. `reach`: how far along, in steps."""
    x, y = centre
    radius = max(float(np.hypot(x, y)), 1.0)
    found = {}
    reach = max(2, min(24, int(radius / 40))) if reach is None else reach
    for along in range(-2 * reach, 2 * reach + 1):
        middle_x, middle_y = x + x / radius * along / 2, y + y / radius * along / 2
        for dx in (-1, 0, 1):
            for dy in (-1, 0, 1):
                whole = round(middle_x) + dx, round(middle_y) + dy
                found.setdefault(whole, (whole[0] - x) ** 2 + (whole[1] - y) ** 2)
    return sorted((each for each in found if each != (0, 0)), key=found.get)
