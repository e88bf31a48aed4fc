"""Orders lines so that the pen's ways between them get short: lines are turned round, and closed lines begin at the vertex that suits.

    lines = shorten(lines, 0j)            # in drawing order, from a place on

It begins by the nearest end, again and again, or by the order that is given, if that is shorter. 2-opt and or-opt (Croes, 1958; Or, 1976)
follow, over the nearest ends of each line. Then two neighbouring pieces are swapped and the seams improved, again and again; a tour that
got shorter is kept (Martin, Otto and Felten, 1991). The same lines give the same order every time: a drawing that is gone on with is the one
that was begun. The kernels of order_viper.py run as C if there is a compiler; without one there are a hundred times fewer tries.
"""

from array import array

import numpy

from host_tools.build.pc_kernels import kernels_of
from host_tools.drawings import order_viper
from host_tools.drawings.line_order import travel_length

_KERNELS = "add_nearest", "apart", "improve", "kick_often"
_SIDE = 32_767  # units of the longer side
_ROUNDS = 6
_FEW, _STARTS = 100, 8  # so few lines are begun so often, each time otherwise
_FARTHEST = 25_000  # lines that one move takes along
_FARTHEST_KICKED = 1000  # the same behind a kick, which many moves follow
_MOST_TRIED = 60_000_000  # comparisons in all
_KICKS_A_LINE = 50
_KICKS = 80_000
_MOST_KICKED = 1_000_000_000  # kicks times lines: among many lines a kick shortens little, and takes longer
_PLAIN = 100  # without a compiler starts, comparisons and kicks are divided by this, the lines of a move are not
_CHUNK = 2_000_000  # comparisons between two calls of progress()
_MORTON = 8  # neighbours on a curve that are tried, in each direction
_SHIFTED = 0, 9157  # of the two curves: units


def shorten(lines, place, progress=None):
    """Return the lines in an order and directions of less travel. A line is a complex array. Calls `progress(share)` now and then, 0…1."""
    lines = list(lines)
    if not lines:
        return []
    progress = progress or (lambda share: None)
    share = 1 if kernels_of(order_viper.__name__, *_KERNELS).compiled else _PLAIN
    made, starts = lines, max(1, _STARTS // share) if len(lines) <= _FEW else 1
    for number in range(starts):
        tour = _Tour(list(lines), place)
        tour.start(number)
        tour.improve_tour(lambda share: progress((number + share * 0.6) / starts))
        tour.kick_tour(lambda share: progress((number + 0.6 + share * 0.4) / starts))
        tour.improve_tour(lambda share: None)
        made = min(made, tour.lines_in_order(), key=lambda each: travel_length(each, place))
    return made


class _Tour:
    """The lines in the arrays of the kernels, which order_viper.py describes."""

    def __init__(self, lines, place):
        self._lines, self._place, self._count = lines, complex(place), len(lines)
        self._kernels = kernels_of(order_viper.__name__, *_KERNELS)
        self._share = 1 if self._kernels.compiled else _PLAIN
        self._ends = numpy.array([end for line in lines for end in (line[0], line[-1])] + [place, place], dtype=complex)
        self._closed = _Closed(lines)
        points = numpy.concatenate([self._ends, self._closed.points])
        self._low = complex(points.real.min(), points.imag.min())
        size = max(numpy.ptp(points.real), numpy.ptp(points.imag), 1e-9)
        self._unit = _SIDE / size
        self._state = _zero_array(order_viper.STATE)
        self._state[order_viper.COUNT], self._state[order_viper.LOGGED] = self._count, -1
        self._tour, self._at = _zero_array(self._count + 2), _zero_array(self._count + 1)
        self._queue, self._log = _zero_array(4 * self._count + 4), _zero_array(order_viper.LOG)
        self._locate_ends()

    def _locate_ends(self):
        """Compute the positions of ends, in units of the kernels, and the ends near each other."""
        places = (self._ends - self._low) * self._unit
        xs, ys = (numpy.clip(numpy.rint(part), 0, _SIDE).astype(numpy.int32) for part in (places.real, places.imag))
        self._xs, self._ys = _int_array(xs), _int_array(ys)
        self._near = _int_array(_nearest_ends(xs, ys))

    @property
    def _grid_arrays(self):
        return self._state, self._xs, self._ys

    @property
    def _move_arrays(self):
        return *self._grid_arrays, self._near, self._tour, self._at, self._log, self._queue

    def start(self, number=0):
        """Order the lines by the nearest end, or as in the file, whichever is shorter; an odd `number` takes the other one. From `number` 2 on
        closed lines begin at random."""
        count, state = self._count, self._state
        if number > 1:
            self._closed.shuffle_starts(self._ends, number)
            self._locate_ends()
        self._set_tour(2 * numpy.arange(count))
        given = self.lines_in_order()
        chain, state[order_viper.SHIFT] = _chain_ends(self._xs, self._ys, count)
        left = _int_array(numpy.concatenate([numpy.arange(count), numpy.arange(count)]))
        state[order_viper.LEFT] = count
        self._kernels.add_nearest(*self._grid_arrays, self._near, self._tour, chain, _zero_array(count + 1), left, count)
        self._set_tour(numpy.array(self._tour[1 : count + 1]))
        if (travel_length(given, self._place) < travel_length(self.lines_in_order(), self._place)) != number % 2:
            self._set_tour(2 * numpy.arange(count))

    def _set_tour(self, ends):
        """Set the tour to `ends` (numpy array, 2 × line + side) between its two guards, and the position of each line in it."""
        self._tour = _int_array(numpy.concatenate([[2 * self._count + 1], ends, [-1]]))
        at = numpy.zeros(self._count + 1, numpy.int32)
        at[ends >> 1] = numpy.arange(1, self._count + 1)
        self._at = _int_array(at)

    def _tour_order(self):
        return numpy.frombuffer(self._tour, numpy.int32)[1:-1]

    def lines_in_order(self):
        """Return the lines in the order of the tour."""
        self._closed.turn_lines(self._lines)
        return [self._lines[end >> 1][:: -1 if end & 1 else 1] for end in self._tour_order().tolist()]

    def improve_tour(self, progress):
        """Move and turn lines until no end has a better neighbour among the nearest; between rounds choose where closed lines begin."""
        state, size = self._state, 2 * self._count
        for number in range(_ROUNDS):
            progress(number / _ROUNDS)
            before = self._travel_length()
            if self._closed.choose_starts(self._ends, self._tour_order()):
                self._locate_ends()
            self._queue[: size + 1] = array("i", [*range(size), 0])
            self._queue[size + 1 :] = array("i", [1] * size + [0] * (len(self._queue) - 2 * size - 1))
            state[order_viper.HEAD], state[order_viper.TAIL] = 0, size
            state[order_viper.FARTHEST] = _FARTHEST
            while state[order_viper.TRIED] < _MOST_TRIED // self._share and self._kernels.improve(*self._move_arrays, _CHUNK // self._share):
                progress(number / _ROUNDS)
            if self._travel_length() > before * (1 - 1e-3):
                return

    def _travel_length(self):
        ends = self._ends[self._tour_order()]
        stops = numpy.concatenate([[self._place], self._ends[self._tour_order()[:-1] ^ 1]])
        return float(abs(ends - stops).sum())

    def kick_tour(self, progress):
        """Swap neighbouring pieces of the tour at random, and keep what makes it shorter (order_viper.kick_once)."""
        state, tried = self._state, order_viper.TRIED
        kicks = min(_KICKS_A_LINE * self._count, _KICKS, _MOST_KICKED // self._count) // self._share
        state[order_viper.FARTHEST] = _FARTHEST_KICKED
        for number in range(20 if self._count > 3 else 0):
            progress(number / 20)
            self._kernels.kick_often(*self._move_arrays, kicks // 20, _MOST_TRIED // self._share)


class _Closed:
    """Chooses the vertex at which each closed line begins."""

    def __init__(self, lines):
        self._numbers = numpy.array([number for number, line in enumerate(lines) if len(line) > 3 and line[0] == line[-1]], dtype=int)
        parts = [lines[number][:-1] for number in self._numbers]
        sizes = numpy.array([len(part) for part in parts], dtype=int)
        self.points = numpy.concatenate(parts) if parts else numpy.zeros(0, complex)
        self._firsts = numpy.cumsum(sizes) - sizes
        self._owner = numpy.repeat(numpy.arange(len(parts)), sizes)
        self._chosen = numpy.zeros(len(parts), int)  # vertices
        self._turned = self._chosen.copy()  # as the lines have them

    def shuffle_starts(self, ends, seed):
        """Choose the first vertices at random."""
        if len(self._numbers):
            sizes = numpy.diff([*self._firsts, len(self.points)])
            self._chosen = numpy.random.default_rng(seed).integers(0, sizes)
            ends[2 * self._numbers] = ends[2 * self._numbers + 1] = self.points[self._firsts + self._chosen]

    def choose_starts(self, ends, order):
        """Choose the vertices that make the ways to a line and on from it shortest, of every other line in turn. Return whether `ends` have changed."""
        if not len(self._numbers):
            return False
        old = self._chosen.copy()
        at = numpy.empty(len(ends) // 2, int)
        at[order >> 1] = numpy.arange(len(order))
        index = at[self._numbers]
        for parity in (0, 1):
            before = ends[numpy.where(index > 0, order[index - 1] ^ 1, len(ends) - 1)]
            ways = abs(self.points - before[self._owner])
            more = numpy.flatnonzero(index + 1 < len(order))
            after = numpy.zeros(len(index), complex)
            after[more] = ends[order[index[more] + 1]]
            ways += numpy.where((index + 1 < len(order))[self._owner], abs(self.points - after[self._owner]), 0.0)
            least = numpy.minimum.reduceat(ways, self._firsts)
            found = numpy.flatnonzero(ways <= least[self._owner])
            first = found[numpy.searchsorted(self._owner[found], numpy.arange(len(index)))]
            here = index % 2 == parity
            self._chosen[here] = (first - self._firsts)[here]
            ends[2 * self._numbers[here]] = ends[2 * self._numbers[here] + 1] = self.points[first[here]]
        return bool((old != self._chosen).any())

    def turn_lines(self, lines):
        """Change the lines so that they begin at the chosen vertices."""
        for number, first, size in zip(self._numbers.tolist(), self._chosen - self._turned, numpy.diff([*self._firsts, len(self.points)])):
            if first:
                line, first = lines[number], first % size
                lines[number] = numpy.concatenate((line[first:-1], line[: first + 1]))
        self._turned = self._chosen.copy()


def _zero_array(count):
    return array("i", bytes(4 * count))


def _int_array(numbers):
    made = array("i")
    made.frombytes(numpy.ascontiguousarray(numbers, numpy.int32).tobytes())
    return made


def _nearest_ends(xs, ys):
    """Return for each end the order_viper.NEAR nearest ends of other lines, among those that are near on two space-filling curves (Morton, 1966): a
    grid would have most of a drawing in a few cells. The pen's first place, the last two ends, has none."""
    count = len(xs) - 2
    found = numpy.full((count + 2, order_viper.NEAR), -1, numpy.int32)
    steps = numpy.array([each for each in range(-_MORTON, _MORTON + 1) if each])
    curves = []
    for shift in _SHIFTED:
        order = numpy.argsort(_spread_bits(xs[:-2] + shift) | _spread_bits(ys[:-2] + shift) << 1, kind="stable").astype(numpy.int32)
        rank = numpy.empty(count, numpy.int32)
        rank[order] = numpy.arange(count)
        curves.append((order, rank))
    (first, rank), (second, rank2) = curves
    wide, high = xs.astype(numpy.float32), ys.astype(numpy.float32)
    for begin in range(0, count, 20_000):  # bounds the memory
        rows = numpy.arange(begin, min(begin + 20_000, count), dtype=numpy.int32)
        there, there2 = rank[rows][:, None] + steps, rank2[rows][:, None] + steps
        others = numpy.concatenate([first[numpy.clip(there, 0, count - 1)], second[numpy.clip(there2, 0, count - 1)]], axis=1)
        ways = (wide[rows][:, None] - wide[others]) ** 2 + (high[rows][:, None] - high[others]) ** 2
        bad = others >> 1 == rows[:, None] >> 1
        bad |= numpy.concatenate([(there < 0) | (there >= count), (there2 < 0) | (there2 >= count)], axis=1)
        bad[:, len(steps) :] |= abs(rank[others[:, len(steps) :]] - rank[rows][:, None]) <= _MORTON  # the first curve has it
        ways[bad] = numpy.inf
        some = numpy.argpartition(ways, order_viper.NEAR, axis=1)[:, : order_viper.NEAR]
        best = numpy.take_along_axis(some, numpy.argsort(numpy.take_along_axis(ways, some, 1), axis=1, kind="stable"), 1)
        found[rows] = numpy.where(numpy.isfinite(numpy.take_along_axis(ways, best, 1)), numpy.take_along_axis(others, best, 1), -1)
    return found.ravel()


def _spread_bits(numbers):
    """Return numbers below 2^16 with a gap behind each bit."""
    spread = numbers.astype(numpy.int64)
    for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        spread = (spread | spread << shift) & mask
    return spread


def _chain_ends(xs, ys, count):
    """Chain the ends in the cells of a grid: of each end the next one of its cell, and behind them the first of each cell. Returns (chains, the
    grid's shift)."""
    shift = 14
    while shift > 6 and (32768 >> shift) ** 2 < 2 * count:
        shift -= 1
    side = 32768 >> shift
    size = 2 * count
    cells = (numpy.frombuffer(ys, numpy.int32)[:size] >> shift) * side + (numpy.frombuffer(xs, numpy.int32)[:size] >> shift)
    order = numpy.argsort(cells, kind="stable")
    chain = numpy.full(size + 2 + side * side, -1, numpy.int32)
    same = cells[order[1:]] == cells[order[:-1]]
    chain[order[:-1][same]] = order[1:][same]
    heads = numpy.flatnonzero(numpy.append(True, ~same))
    chain[size + 2 + cells[order[heads]]] = order[heads]
    return _int_array(chain), shift
