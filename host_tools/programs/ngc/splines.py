"""Splines as points whose chords stay near them: Bézier curves of G5 and G5.1, NURBS of G5.2.

    points = flatten_curve(bezier([0, 1 + 1j, 2 + 1j, 3]), 1, 0.002)     # a function of 0 … 1

Points are complex numbers, x + y·j, in mm.
"""

_DEEPEST = 16  # halvings of a piece
_PIECES = 8  # that a curve has at least: a wave may cross its chord in the middle


def bezier(controls):
    """Return the Bézier curve of these control points, a function of 0 … 1 (de Casteljau)."""

    def point_at(share):
        """Return the point, mm, at a share of 0 … 1 of the curve."""
        row = list(controls)
        while len(row) > 1:
            row = [a + (b - a) * share for a, b in zip(row, row[1:])]
        return row[0]

    return point_at


def nurbs(controls, weights, order):
    """Return (function of 0 … n, n): the curve of `order` (degree + 1) with knots 0 … 0 1 2 … n … n, which begins and ends at its outer control
    points (de Boor)."""
    count = len(controls) - order + 1
    knots = [0] * order + list(range(1, count)) + [count] * order
    weighted = [(control * weight, weight) for control, weight in zip(controls, weights)]

    def point_at(at):
        """Return the point, mm, at the parameter `at`, 0 … n, by de Boor's algorithm with homogeneous coordinates."""
        span = min(int(at), count - 1) + order - 1
        row = weighted[span - order + 1 : span + 1]
        for level in range(1, order):  # de Boor
            made = []
            for number in range(order - level):
                low, high = knots[span - order + 1 + level + number], knots[span + 1 + number]
                share = (at - low) / (high - low)
                made.append(tuple(a + (b - a) * share for a, b in zip(row[number], row[number + 1])))
            row = made
        return row[0][0] / row[0][1]

    return point_at, count


def flatten_curve(point, end, sag):
    """Return points of the curve from 0 to `end`, without its start, whose chords are at most about `sag` mm away from it."""
    found = []
    pieces = _PIECES * end
    for number in range(pieces):
        low, high = number * end / pieces, (number + 1) * end / pieces
        _halve_span(point, low, high, point(low), point(high), sag, found, 0)
    return found


def _halve_span(point, low, high, begin, last, sag, found, depth):
    """Append the points behind `begin` of the span `low` … `high` to `found`: halve the span until its middle is at most `sag` mm off the chord, or
    _DEEPEST times."""
    middle = (low + high) / 2
    half = point(middle)
    if depth == _DEEPEST or _distance_off(half, begin, last) <= sag:
        found.append(last)
        return
    _halve_span(point, low, middle, begin, half, sag, found, depth + 1)
    _halve_span(point, middle, high, half, last, sag, found, depth + 1)


def _distance_off(place, begin, end):
    """Return the distance of `place` from the line between two others."""
    chord = end - begin
    if not chord:
        return abs(place - begin)
    share = min(1.0, max(0.0, ((place - begin) * chord.conjugate()).real / abs(chord) ** 2))
    return abs(place - begin - chord * share)
