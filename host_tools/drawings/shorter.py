"""Shortens the pen's ways between lines: pieces of the drawing order are turned round or put elsewhere, and closed lines begin at the
vertex that suits, as long as that helps.

    lines = shortened(lines, 0j)            # in drawing order, from a place on

2-opt and or-opt (Croes, 1958; Or, 1976) over the nearest ends of each line. The same lines give the same order every time: a
drawing that is gone on with is the one that was begun. 7000 lines take some seconds.
"""

import numpy

_NEAR = 10  # ends tried around each
_ROUNDS = 6
_LONGEST = 20  # lines moved together
_MOST_TRIED = 4_000_000  # comparisons in all
_CELL = 4  # ends in a cell of the grid, on average


def shortened(lines, place):
    """The lines, in an order and directions of less travel. A line is a complex array."""
    if len(lines) < 2:
        return [_entered(line, place, None) for line in lines]
    tour = _Tour(lines, place)
    for _ in range(_ROUNDS):
        before = tour.length()
        tour.enter()
        tour.improve()
        if tour.tried > _MOST_TRIED or tour.length() > before * (1 - 1e-4):
            break
    tour.enter()
    return tour.lines()


def _is_closed(line):
    return len(line) > 3 and line[0] == line[-1]


def _entered(line, before, after):
    """A closed line from the vertex that makes the ways to it and on from it shortest; any other as it is."""
    if not _is_closed(line):
        return line
    ways = abs(line[:-1] - before) + (abs(line[:-1] - after) if after is not None else 0.0)
    first = int(numpy.argmin(ways))
    return numpy.concatenate((line[first:-1], line[: first + 1]))


class _Tour:
    """`_order`: numbers of lines; a line is gone from its end `_flip` (0: its first point) to the other; `_at[line]`: its index."""

    def __init__(self, lines, place):
        self._lines = list(lines)
        self._place = complex(place)
        self._order = list(range(len(lines)))
        self._at = list(range(len(lines)))
        self._flip = [0] * len(lines)
        self.tried = 0
        self._set_ends()

    def _set_ends(self):
        self._ends = [complex(end) for line in self._lines for end in (line[0], line[-1])]

    def lines(self):
        return [self._lines[k][::-1] if self._flip[k] else self._lines[k] for k in self._order]

    def _start(self, index):
        k = self._order[index]
        return self._ends[2 * k + self._flip[k]]

    def _end(self, index):
        if index < 0:
            return self._place
        k = self._order[index]
        return self._ends[2 * k + 1 - self._flip[k]]

    def _link(self, index):
        """The way behind a line; 0 behind the last."""
        return abs(self._end(index) - self._start(index + 1)) if index + 1 < len(self._order) else 0.0

    def length(self):
        return sum(self._link(index) for index in range(-1, len(self._order) - 1))

    def enter(self):
        """Let closed lines begin where their neighbours want it."""
        last = len(self._order) - 1
        for index, k in enumerate(self._order):
            if _is_closed(self._lines[k]):
                line = _entered(self._lines[k], self._end(index - 1), self._start(index + 1) if index < last else None)
                self._lines[k] = line
                self._ends[2 * k] = self._ends[2 * k + 1] = complex(line[0])

    def improve(self):
        """Until no end has a better neighbour among the nearest."""
        near = _nearest(self._ends)
        waiting = list(range(len(self._ends)))
        queued = [True] * len(waiting)
        while waiting and self.tried <= _MOST_TRIED:
            following = []
            for end in waiting:
                queued[end] = False
                while True:
                    touched = self._better(end, near[end])
                    if not touched:
                        break
                    for each in touched:
                        for one in (2 * each, 2 * each + 1):
                            if not queued[one]:
                                queued[one] = True
                                following.append(one)
            waiting = following

    def _better(self, end, near):
        """Make one move that joins `end` to a near one; the lines at its seams, or nothing."""
        line = end >> 1
        at = self._at[line]
        leaving = (end & 1) != self._flip[line]  # the pen leaves the line here
        gap = at if leaving else at - 1
        now = self._link(gap)
        place = self._ends[end]
        for other in near:
            way = abs(place - self._ends[other])
            if way >= now:
                return None
            self.tried += 1
            touched = self._join(at, gap, leaving, other, way, now)
            if touched:
                return touched
        return None

    def _join(self, at, gap, leaving, other, way, now):
        """Try the moves that put the end at a gap beside `other`."""
        there = self._at[other >> 1]
        if there == at:
            return None
        other_leaves = (other & 1) != self._flip[other >> 1]
        if leaving == other_leaves:  # two ends that the pen leaves, or two that it comes to: turn the lines between them
            other_gap = there if leaving else there - 1
            low, high = min(gap, other_gap), max(gap, other_gap)
            gain = now + self._link(other_gap) - way - self._cross(low, high, leaving)
            if gain > 1e-9:
                return self._turn(low + 1, high)
        return self._move(gap, there, leaving, other_leaves, way, now)

    def _cross(self, low, high, leaving):
        """The way that turning low + 1 … high makes at the other seam."""
        if leaving:  # E[low]–E[high] is the one given; S[low + 1]–S[high + 1] the other
            return abs(self._start(low + 1) - self._start(high + 1)) if high + 1 < len(self._order) else 0.0
        return abs(self._end(low) - self._end(high))

    def _move(self, gap, there, leaving, other_leaves, way, now):
        """Put up to _LONGEST lines that begin or end at the other end into the gap."""
        count = len(self._order)
        for size in range(1, _LONGEST + 1):
            # The piece goes on from `there` away from the end that is joined.
            first = there - size + 1 if other_leaves else there
            last = first + size - 1
            if first < 0 or last >= count or first <= gap + 1 and gap <= last:
                continue
            removed = now + self._link(first - 1) + self._link(last)
            closed = abs(self._end(first - 1) - self._start(last + 1)) if last + 1 < count else 0.0
            far = self._start(first) if other_leaves else self._end(last)
            if leaving:
                beyond = abs(far - self._start(gap + 1)) if gap + 1 < count else 0.0
            else:
                beyond = abs(far - self._end(gap))
            if removed - closed - way - beyond > 1e-9:
                return self._put(first, last, gap, leaving == other_leaves)
        return None

    def _turn(self, first, last):
        order = self._order
        piece = order[first : last + 1]
        piece.reverse()
        order[first : last + 1] = piece
        for index, k in enumerate(piece, first):
            self._at[k] = index
            self._flip[k] ^= 1
        return self._seams(first - 1, first, last, last + 1)

    def _put(self, first, last, gap, turned):
        order = self._order
        piece = order[first : last + 1]
        if turned:
            piece.reverse()
            for k in piece:
                self._flip[k] ^= 1
        if gap < first:
            low, high = gap + 1, last
            order[low : high + 1] = piece + order[low:first]
        else:
            low, high = first, gap
            order[low : high + 1] = order[last + 1 : high + 1] + piece
        for index in range(low, high + 1):
            self._at[order[index]] = index
        size = len(piece)
        return self._seams(low - 1, low, low + size - 1, low + size, high - size, high - size + 1, high, high + 1)

    def _seams(self, *indices):
        return {self._order[index] for index in indices if 0 <= index < len(self._order)}


def _nearest(ends):
    """Of each end the _NEAR nearest ones of other lines, the nearest first; fewer, if they are far."""
    places = numpy.array(ends)
    left, bottom = places.real.min(), places.imag.min()
    width, height = places.real.max() - left, places.imag.max() - bottom
    cell = max((width * height * _CELL / len(ends)) ** 0.5, max(width, height) * _CELL / len(ends), 1e-9)
    columns = ((places.real - left) / cell).astype(int)
    rows = ((places.imag - bottom) / cell).astype(int)
    cells = {}
    for index, key in enumerate(zip(columns.tolist(), rows.tolist())):
        cells.setdefault(key, []).append(index)
    found = [()] * len(ends)
    for (column, row), members in cells.items():
        around = [each for i in (-1, 0, 1) for j in (-1, 0, 1) for each in cells.get((column + i, row + j), ())]
        around = numpy.array(sorted(around))
        for begun in range(0, len(members), 256):
            some = numpy.array(members[begun : begun + 256])
            ways = abs(places[some][:, None] - places[around][None, :])
            ways[(some[:, None] >> 1) == (around[None, :] >> 1)] = numpy.inf
            count = min(_NEAR, len(around))
            best = numpy.argsort(ways, axis=1, kind="stable")[:, :count]
            for each, chosen, lengths in zip(some.tolist(), best, numpy.take_along_axis(ways, best, 1)):
                found[each] = around[chosen[numpy.isfinite(lengths)]].tolist()
    return found
