"""Joins polylines whose ends meet.

    lines = join(lines, 0.05)             # join ends this close, in the lines' own unit

A line is a numpy array of complex numbers, x + yj. Lines that no other meets are found over arrays: of a hundred thousand lines only
those that meet take time.
"""

import math
from operator import itemgetter

import numpy

_CROWD = 16  # ends in a cell of the grid
_RINGS = 6  # rings of cells around a point to search, before searching all ends


class Ends:
    """The ends of the lines that are left, in a grid. `cell`: the grid's pitch, above 0."""

    def __init__(self, lines, cell):
        self._cell = cell
        self._places = numpy.array([end for line in lines for end in (line[0], line[-1])], dtype=complex)
        self._cells = {}
        self._left = set(range(len(lines)))
        self._first = 0  # none before it is left
        for end, position in enumerate(self._places):
            self._cells.setdefault(self._cell_of(position), []).append(end)

    def __len__(self):
        return len(self._left)

    def take_first(self):
        """Remove the first line that is left, and return its number."""
        while self._first not in self._left:
            self._first += 1
        self._take_line(self._first)
        return self._first

    def take_nearest(self, position, within=math.inf):
        """Remove the line whose end is nearest to `position`; return (line, turned round), or None if no end is `within`. Of two as near it takes
        the one that begins there, and of these the first."""
        found = self._nearest_end(position, within)
        if found is None:
            return None
        number, turned = divmod(found, 2)
        self._take_line(number)
        return number, bool(turned)

    def _cell_of(self, position):
        return math.floor(position.real / self._cell), math.floor(position.imag / self._cell)

    def _take_line(self, number):
        """Remove a line and both of its ends."""
        self._left.remove(number)
        for end in (2 * number, 2 * number + 1):
            key = self._cell_of(self._places[end])
            self._cells[key].remove(end)
            if not self._cells[key]:
                del self._cells[key]
            self._places[end] = complex(math.inf, 0)

    def _nearest_end(self, position, within):
        """Return the nearest end, or None. An end in ring r + 1 of cells is farther than r cells."""
        if not self._left:
            return None
        x, y = self._cell_of(position)
        best = None
        for ring in range(_RINGS):
            for key in _ring_cells(x, y, ring):
                for end in self._cells.get(key, ()):
                    candidate = abs(self._places[end] - position), end & 1, end
                    if best is None or candidate < best:
                        best = candidate
            reach = ring * self._cell
            if best is not None and best[0] <= reach or reach > within:
                break
        else:
            distances = abs(self._places - position)
            least = distances.min()
            best = min((least, end & 1, int(end)) for end in numpy.nonzero(distances == least)[0])
        return best[2] if best is not None and best[0] <= within else None


def _ring_cells(x, y, ring):
    """Return the cells `ring` columns or rows from the cell x, y, a square around it; for 0 the cell itself."""
    if not ring:
        return [(x, y)]
    side = range(-ring, ring + 1)
    inner = range(-ring + 1, ring)
    return [(x + i, y + j) for i in side for j in (-ring, ring)] + [(x + i, y + j) for i in (-ring, ring) for j in inner]


def join(lines, tolerance):
    """Join lines whose ends are at most `tolerance` apart; drops lines of less than two points.

    If several lines meet, the result lifts the pen as seldom as possible: half as many lines as there are nodes where an odd
    number meets, or one closed line (Euler, 1736; Hierholzer, 1873).
    """
    lines = [line for line in lines if len(line) > 1]
    alone = _find_alone(lines, tolerance)
    meet = numpy.flatnonzero(~alone).tolist()
    made = [(meet[first], line) for first, line in _join_met([lines[number] for number in meet], tolerance)]
    made += [(number, lines[number]) for number in numpy.flatnonzero(alone).tolist()]
    return [line for _, line in sorted(made, key=itemgetter(0))]


def _find_alone(lines, tolerance):
    """Return for each line whether no end of another line is within `tolerance` of its ends; False also if many ends are near."""
    if not lines:
        return numpy.zeros(0, bool)
    ends = numpy.array([end for line in lines for end in (line[0], line[-1])], dtype=complex)
    pitch = max(tolerance, 1e-9) * (1 + 1e-6)
    columns, rows = (numpy.floor((part - part.min()) / pitch).astype(numpy.int64) for part in (ends.real, ends.imag))
    width = int(columns.max()) + 3
    cells = rows * width + columns
    order = numpy.argsort(cells, kind="stable")
    sorted_cells = cells[order]
    alone = numpy.ones(len(lines), bool)
    for step in (0, 1, width - 1, width, width + 1):  # each pair of neighbouring cells once
        first = numpy.searchsorted(sorted_cells, sorted_cells + step)
        last = numpy.searchsorted(sorted_cells, sorted_cells + step, "right")
        alone[order[last - first > _CROWD] >> 1] = False  # not looked at one by one
        for more in range(min(int((last - first).max()), _CROWD)):
            here = numpy.flatnonzero(first + more < last)
            one, other = order[here], order[first[here] + more]
            near = (one >> 1 != other >> 1) & (abs(ends[one] - ends[other]) <= pitch)
            alone[one[near] >> 1] = alone[other[near] >> 1] = False
    return alone


def _join_met(lines, tolerance):
    """Join lines that meet others; return [(the least number of a line in it, line)]."""
    trails = _find_trails(lines, tolerance / 2)
    numbers = [min(number for number, _ in trail) for trail in trails]
    lines = [_chain_lines([(lines[number], turned) for number, turned in trail]) for trail in trails]
    # Ends that are near each other, but not near one place.
    ends = Ends(lines, max(tolerance, 1e-9))
    result = []
    while len(ends):
        parts = [(ends.take_first(), False)]
        for _ in range(2):  # at its end; turned round, at its beginning
            while (found := ends.take_nearest(_last_end(lines[parts[-1][0]], parts[-1][1]), tolerance)) is not None:
                parts.append(found)
            parts = [(number, not turned) for number, turned in reversed(parts)]
        result.append((min(numbers[number] for number, _ in parts), _chain_lines([(lines[number], turned) for number, turned in parts])))
    return result


def join_in_order(lines, tolerance):
    """Join lines in their order: one that begins where the one before ended continues it."""
    result = []
    for line in lines:
        if len(line) > 1 and result and abs(result[-1][-1] - line[0]) <= tolerance:
            result[-1] = numpy.concatenate((result[-1], line))
        elif len(line) > 1:
            result.append(line)
    return result


def _last_end(line, turned):
    return line[0] if turned else line[-1]


def _chain_lines(parts):
    """Return one line of [(line, turned round)]."""
    return numpy.concatenate([line[::-1] if turned else line for line, turned in parts])


def _find_trails(lines, radius):
    """Return lists of (line, turned round) that are connected, as few as possible. Ends within `radius` of each other are one node."""
    nodes = _number_nodes(lines, max(radius, 1e-9))
    edges = list(zip(nodes[::2], nodes[1::2]))
    around = {}  # node: numbers of the edges there; one that begins and ends there twice
    for number, pair in enumerate(edges):
        for node in pair:
            around.setdefault(node, []).append(number)
    count = len(edges)
    trails = []
    for component in _find_components(edges, around):
        odd = [node for node in component if len(around[node]) % 2]
        for pair in zip(odd[::2], odd[1::2]):  # edges of no line: there the pen is lifted
            for node in pair:
                around[node].append(len(edges))
            edges.append(pair)
        trail = _find_circuit(odd[0] if odd else component[0], edges, around)
        lifts = [index for index, (number, _) in enumerate(trail) if number >= count]
        if lifts:
            trail = trail[lifts[0] + 1 :] + trail[: lifts[0] + 1]
        part = []
        for step in trail:
            if step[0] < count:
                part.append(step)
            else:
                trails.append(part)
                part = []
        trails.append(part)
    return [_turn_forwards(trail) for trail in trails if trail]


def _turn_forwards(trail):
    """Return the trail from the end from which most of its lines run in their own direction."""
    if 2 * sum(turned for _, turned in trail) > len(trail):
        return [(number, not turned) for number, turned in reversed(trail)]
    return trail


def _number_nodes(lines, radius):
    """Return the node of each end, two for a line. Ends within `radius` of each other share a node."""
    cells = {}
    nodes = []
    centres = []
    for line in lines:
        for end in (complex(line[0]), complex(line[-1])):
            x, y = math.floor(end.real / radius), math.floor(end.imag / radius)
            near = [node for i in (-1, 0, 1) for j in (-1, 0, 1) for node in cells.get((x + i, y + j), ())]
            found = min(((abs(centres[node] - end), node) for node in near), default=(math.inf, 0))
            if found[0] > radius:
                found = 0.0, len(centres)
                centres.append(end)
                cells.setdefault((x, y), []).append(found[1])
            nodes.append(found[1])
    return nodes


def _find_components(edges, around):
    """Yield lists of nodes that lines connect."""
    seen = set()
    for first in around:
        if first in seen:
            continue
        seen.add(first)
        component = [first]
        for node in component:  # grows meanwhile
            for number in around[node]:
                for other in edges[number]:
                    if other not in seen:
                        seen.add(other)
                        component.append(other)
        yield component


def _find_circuit(start, edges, around):
    """Return all edges of a component once, as (number, turned round), back to `start` (Hierholzer, 1873). An even number meets at each node."""
    left = {}
    used = set()
    path = [(start, None)]
    circuit = []
    while path:
        node, arrived = path[-1]
        waiting = left.setdefault(node, list(reversed(around[node])))
        while waiting and waiting[-1] in used:
            waiting.pop()
        if waiting:
            number = waiting.pop()
            used.add(number)
            turned = edges[number][0] != node
            path.append((edges[number][0] if turned else edges[number][1], (number, turned)))
        else:
            path.pop()
            if arrived is not None:
                circuit.append(arrived)
    circuit.reverse()
    return circuit


def travel_length(lines, position):
    """Return the length that a pen travels from `position` to the first line, and between the lines."""
    if not lines:
        return 0.0
    starts, stops = (numpy.array([line[end] for line in lines]) for end in (0, -1))
    return float(abs(starts - numpy.concatenate([[position], stops[:-1]])).sum())
