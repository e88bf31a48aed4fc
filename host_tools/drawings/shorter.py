"""Shortens the pen's ways between lines: pieces of the drawing order are turned round or put elsewhere, and closed lines begin at the
vertex that suits, as long as that helps.

    lines = shortened(lines, 0j)            # in drawing order, from a place on

2-opt and or-opt (Croes, 1958; Or, 1976) over the nearest ends of each line. Then two neighbouring pieces change places, again and
again, and what follows of it is kept if it is shorter (Martin, Otto and Felten, 1991). The same lines give the same order every time: a
drawing that is gone on with is the one that was begun. 7000 and 20 000 lines take three seconds, 100 000 twelve.
"""

import random
from array import array

import numpy

_NEAR = 10  # ends tried around each
_ROUNDS = 6
_LONGEST = 8  # lines moved together
_FARTHEST = 25_000  # lines between two that change places: each of them is moved along
_FARTHEST_KICKED = 2000  # the same behind a kick, which many moves follow
_MOST_TRIED = 4_000_000  # comparisons in all
_MOST_KICKS = 3000  # of pieces that change places; none of more than _FARTHEST lines
_KICKS_A_LINE = 2
_MOST_KICKED = 20_000_000  # kicks times lines: among many lines a kick shortens little, and takes longer
_PIECE = 30  # lines in such a piece
_LEAST = 1e-9  # shorter by less is not shorter
_CELL = 4  # ends in a cell of the grid, on average


def shortened(lines, place, progress=None):
    """The lines, in an order and directions of less travel. A line is a complex array. Calls `progress(share)` now and then, 0…1."""
    if len(lines) < 2:
        return [_entered(line, place, None) for line in lines]
    progress = progress or (lambda share: None)
    tour = _Tour(lines, place)
    _settled(tour, progress)
    kicks = min(_KICKS_A_LINE * len(lines), _MOST_KICKS, _MOST_KICKED // len(lines))
    chance = random.Random(kicks)
    for number in range(kicks if 3 < len(lines) <= _FARTHEST else 0):
        if number % 64 == 0:
            progress(number / kicks)
        if tour.tried > _MOST_TRIED:
            break
        tour.kick(chance)
    _settled(tour, progress)
    tour.enter()
    return tour.lines()


def _settled(tour, progress):
    for _ in range(_ROUNDS):
        before = tour.length
        tour.enter()
        tour.improve(progress)
        if tour.tried > _MOST_TRIED or tour.length > before * (1 - 1e-3):
            break


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
    """`_order`: numbers of lines; a line is gone from its end `_flip` (0: its first point) to the other; `_at[line]`: its index.

    By index, `_starts` and `_stops` are the places where the pen comes to a line and leaves it (`_stops[-1]` is where it is at first), and
    `_ways` the way to the line, 0 behind the last. Moves of long pieces are slices, not loops: a hundred thousand lines take seconds.
    """

    def __init__(self, lines, place):
        self._lines = list(lines)
        self._count = count = len(lines)
        self._order, self._at, self._flip = array("q", range(count)), array("q", range(count)), array("b", bytes(count))
        self._orders, self._ats, self._flips = (numpy.frombuffer(each, each.typecode) for each in (self._order, self._at, self._flip))
        self._ends = [complex(end) for line in self._lines for end in (line[0], line[-1])]
        self._starts, self._stops = self._ends[::2], [*self._ends[1::2], complex(place)]
        self._ways = [0.0] * (count + 1)
        self.length = 0.0  # sum of _ways, kept up to date by the seams of each move
        self._near = None
        self._farthest = _FARTHEST
        self._changes = None  # what _arrange has changed, while it may be taken back
        self.tried = 0
        self._measure()

    def _measure(self):
        self._set_ways(0, self._count)
        self.length = sum(self._ways)

    def _set_ways(self, first, last):
        """Those to the lines of the indices `first` to `last`, after a change."""
        for index in range(first, min(last + 1, self._count)):
            self._ways[index] = abs(self._stops[index - 1] - self._starts[index])

    def lines(self):
        return [self._lines[k][::-1] if self._flip[k] else self._lines[k] for k in self._order]

    def enter(self):
        """Let closed lines begin where their neighbours want it."""
        for index, k in enumerate(self._order):
            if _is_closed(self._lines[k]):
                line = _entered(self._lines[k], self._stops[index - 1], self._starts[index + 1] if index + 1 < self._count else None)
                first = complex(line[0])
                if first != self._starts[index]:
                    self._near = None
                self._lines[k] = line
                self._ends[2 * k] = self._ends[2 * k + 1] = self._starts[index] = self._stops[index] = first
        self._measure()

    def improve(self, progress):
        """Until no end has a better neighbour among the nearest."""
        self._near = self._near or _nearest(self._ends)
        self._improve(range(len(self._ends)), progress)

    def kick(self, chance):
        """Let two neighbouring pieces change places, and take that back if the way does not get shorter by what follows."""
        low = chance.randrange(self._count - 1)
        middle = min(low + chance.randrange(_PIECE), self._count - 2)
        high = min(middle + 1 + chance.randrange(_PIECE), self._count - 1)
        before, self._changes, self._farthest = self.length, [], min(_FARTHEST, _FARTHEST_KICKED)
        self._arrange(low, [(middle + 1, high, False), (low, middle, False)])
        size = high - middle
        touched = self._seams(low - 1, low, low + size - 1, low + size, high, high + 1)
        self._improve([end for line in sorted(touched) for end in (2 * line, 2 * line + 1)], None)
        changes, self._changes, self._farthest = self._changes, None, _FARTHEST
        if self.length > before - _LEAST:
            for change in reversed(changes):
                self._take_back(*change)
            self.length = before

    def _take_back(self, low, order, flips, starts, stops, ways):
        high = low + len(order)
        self._orders[low:high] = order
        self._flips[order] = flips
        self._ats[order] = numpy.arange(low, high)
        self._starts[low:high], self._stops[low:high], self._ways[low : low + len(ways)] = starts, stops, ways

    def _improve(self, waiting, progress):
        near = self._near
        queued = dict.fromkeys(waiting, True)
        left = 1.0
        while waiting and self.tried <= _MOST_TRIED:
            following = []
            for index, end in enumerate(waiting):
                if progress and index % 1024 == 0:
                    progress(1 - left * (1 - index / len(waiting) / 2))
                queued[end] = False
                while True:
                    touched = self._better(end, near[end])
                    if not touched:
                        break
                    for each in touched:
                        for one in (2 * each, 2 * each + 1):
                            if not queued.get(one):
                                queued[one] = True
                                following.append(one)
            waiting = following
            left /= 2

    def _better(self, end, near):
        """Make one move that joins `end` to a near one; the lines at its seams, or nothing."""
        line = end >> 1
        at = self._at[line]
        leaving = (end & 1) != self._flip[line]  # the pen leaves the line here
        gap = at if leaving else at - 1
        now = self._ways[gap + 1]
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
            gain = now + self._ways[other_gap + 1] - way - self._cross(low, high, leaving)
            if gain > _LEAST and high - low <= self._farthest:
                return self._turn(low + 1, high)
        return self._move(gap, there, leaving, other_leaves, way, now)

    def _cross(self, low, high, leaving):
        """The way that turning low + 1 … high makes at the other seam."""
        if leaving:  # stops[low]–stops[high] is the one given; starts[low + 1]–starts[high + 1] the other
            return abs(self._starts[low + 1] - self._starts[high + 1]) if high + 1 < self._count else 0.0
        return abs(self._stops[low] - self._stops[high])

    def _move(self, gap, there, leaving, other_leaves, way, now):
        """Put up to _LONGEST lines that begin or end at the other end into the gap."""
        starts, stops, ways, count = self._starts, self._stops, self._ways, self._count
        if abs(there - gap) > self._farthest:
            return None
        beside = (starts[gap + 1] if gap + 1 < count else None) if leaving else stops[gap]
        # The piece goes on from `there` away from the end that is joined, and ends before the gap.
        if other_leaves:
            after = starts[there + 1] if there + 1 < count else None
            saved = now - way + ways[there + 1]
            for first in range(there, max(there - _LONGEST, gap + 1 if gap <= there else -1), -1):
                gain = saved + ways[first]
                if after is not None:
                    gain -= abs(stops[first - 1] - after)
                if gain > _LEAST and (beside is None or gain - abs(starts[first] - beside) > _LEAST):
                    return self._put(first, there, gap, leaving)
        else:
            before = stops[there - 1]
            saved = now - way + ways[there]
            for last in range(there, min(there + _LONGEST, gap if there <= gap + 1 else count)):
                gain = saved + ways[last + 1]
                if last + 1 < count:
                    gain -= abs(before - starts[last + 1])
                if gain > _LEAST and (beside is None or gain - abs(stops[last] - beside) > _LEAST):
                    return self._put(there, last, gap, not leaving)
        return None

    def _turn(self, first, last):
        self._arrange(first, [(first, last, True)])
        return self._seams(first - 1, first, last, last + 1)

    def _put(self, first, last, gap, turned):
        size = last - first + 1
        if gap < first:
            low, high = gap + 1, last
            self._arrange(low, [(first, last, turned), (low, first - 1, False)])
        else:
            low, high = first, gap
            self._arrange(low, [(last + 1, high, False), (first, last, turned)])
        return self._seams(low - 1, low, low + size - 1, low + size, high - size, high - size + 1, high, high + 1)

    def _arrange(self, low, pieces):
        """Put pieces, (first index, last, turned round or not), one behind the other from the index `low` on: they come from there."""
        if self._changes is not None:
            high = low + sum(last - first + 1 for first, last, _ in pieces)
            before = self._orders[low:high].copy()
            kept = self._starts[low:high], self._stops[low:high], self._ways[low : high + 1]
            self._changes.append((low, before, self._flips[before].copy(), *kept))
        order, starts, stops, ways = [], [], [], []
        seams = [first for first, _, _ in pieces] + [low + sum(last - first + 1 for first, last, _ in pieces)]
        self.length -= sum(self._ways[seam] for seam in seams)
        for first, last, turned in pieces:
            here = slice(first, last + 1)
            numbers, begins, ends, between = self._orders[here], self._starts[here], self._stops[here], self._ways[first + 1 : last + 1]
            if turned:
                self._flips[numbers] ^= 1
                numbers, begins, ends, between = numbers[::-1], ends[::-1], begins[::-1], between[::-1]
            order.append(numbers)
            starts += begins
            stops += ends
            ways += [0.0, *between]
        high = low + len(starts)
        self._orders[low:high] = order = numpy.concatenate(order)
        self._ats[order] = numpy.arange(low, high)
        self._starts[low:high], self._stops[low:high], self._ways[low:high] = starts, stops, ways
        seam = low
        for first, last, _ in [*pieces, (0, 0, False)]:
            self._set_ways(seam, seam)
            self.length += self._ways[seam]
            seam += last - first + 1

    def _seams(self, *indices):
        return {self._order[index] for index in indices if 0 <= index < self._count}


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
