"""Kernels that order lines: always the nearest end next, then 2-opt and or-opt moves, then kicks. shorter.py makes the arrays.

Line n has the ends 2n and 2n + 1; `xs` and `ys` say where they lie, 0 to 32 767. `tour[index]` is the end at which the pen comes to
the index-th line, from 1 on. It leaves the line at `tour[index] ^ 1`. Index 0 stands for the pen's first place; behind the last line is
-1, to which no way leads. `at[line]` is its index.

    tour[g]                 gap g                 tour[g + 1]
       o────────────────o · · · · · · o────────────────o
                 tour[g] ^ 1     tour[g + 1]     tour[g + 1] ^ 1

`near[NEAR * end]` and the next ones are ends near that one, the nearest first; -1 behind the last. `state` has the numbers below.
Ways are in sixteenths of a unit, 0.3 µm in a drawing of 180 mm. A move is made if the sum of ways gets less, so each search ends.
"""

from math import isqrt

import micropython
from micropython import const

COUNT = const(0)  # of lines
LENGTH = const(1)  # of all ways, modulo 2^32: differences count
TRIED = const(2)  # comparisons up to now
HEAD = const(3)  # of the queue of ends: the next one to look at
TAIL = const(4)  # behind the last one
FARTHEST = const(5)  # lines that one move may take along
LOGGED = const(6)  # numbers in the log of turns; -1: no log is written
CHANCE = const(7)  # the last random number
SHIFT = const(8)  # a cell of the grid has 2^SHIFT units
LEFT = const(9)  # lines that are in no tour yet
STATE = const(10)  # numbers in all

NEAR = const(10)
RINGS = const(8)  # rings of cells around an end to search, before searching all that are left
LONGEST = const(8)  # lines moved together
PIECE = const(30)  # lines in each of two pieces that change places
LOG = const(2000)


@micropython.viper
def apart(xs: ptr32, ys: ptr32, a: int, b: int) -> int:
    """Return the way between two ends, in sixteenths of a unit; 0 if one is -1. Squares stay below 2^31."""
    if a < 0 or b < 0:
        return 0
    x = xs[a] - xs[b]
    y = ys[a] - ys[b]
    if -2048 < x < 2048 and -2048 < y < 2048:
        return isqrt((x * x + y * y) << 8)
    return isqrt(x * x + y * y) << 4


@micropython.viper
def next_random(state: ptr32, below: int) -> int:
    """Return the next random number, 0 to `below` - 1, by a linear congruence."""
    state[CHANCE] = (state[CHANCE] * 1103515245 + 12345) & 0x7FFFFFFF
    return (state[CHANCE] >> 8) % below


# --- greedy


@micropython.viper
def search_cell(xs: ptr32, ys: ptr32, chain: ptr32, taken: ptr32, place: int, end: int, best: int) -> int:
    """Return the nearest to `end` of `best` and the ends chained from `place` on; those of taken lines leave the chain."""
    least = apart(xs, ys, end, best) if best >= 0 else 0x7FFFFFFF
    other = chain[place]
    while other >= 0:
        if taken[other >> 1]:
            chain[place] = chain[other]
        else:
            way = apart(xs, ys, end, other)
            if way < least:
                least = way
                best = other
            place = other
        other = chain[other]
    return best


@micropython.viper
def search_grid(state: ptr32, xs: ptr32, ys: ptr32, chain: ptr32, taken: ptr32, end: int) -> int:
    """Return the nearest end in the rings of cells around an end, or -1. An end in ring r + 1 is farther than r cells."""
    shift = state[SHIFT]
    side = 32768 >> shift
    first = 2 * state[COUNT] + 2  # the chains of cells lie behind those of ends
    column = xs[end] >> shift
    row = ys[end] >> shift
    best = -1
    for ring in range(RINGS):
        for y in range(row - ring, row + ring + 1):
            step = 1
            if row - ring < y < row + ring:
                step = 2 * ring
            x = column - ring
            while x <= column + ring:
                if 0 <= x < side and 0 <= y < side:
                    best = search_cell(xs, ys, chain, taken, first + y * side + x, end, best)
                x += step
        if best >= 0 and apart(xs, ys, end, best) <= (ring << shift) << 4:
            return best
    return best


@micropython.viper
def search_all(state: ptr32, xs: ptr32, ys: ptr32, left: ptr32, end: int) -> int:
    """Return the nearest end of all lines that are left."""
    best = 2 * left[0]
    least = apart(xs, ys, end, best)
    for index in range(state[LEFT]):
        other = 2 * left[index]
        way = apart(xs, ys, end, other)
        if way < least:
            least = way
            best = other
        way = apart(xs, ys, end, other + 1)
        if way < least:
            least = way
            best = other + 1
    return best


@micropython.viper
def find_nearest(state: ptr32, xs: ptr32, ys: ptr32, near: ptr32, chain: ptr32, taken: ptr32, left: ptr32, end: int) -> int:
    """Return the end of a line that is left nearest to `end`."""
    row = end * NEAR
    for index in range(row, row + NEAR):
        if near[index] < 0:
            break
        if taken[near[index] >> 1] == 0:
            return near[index]
    found = search_grid(state, xs, ys, chain, taken, end)
    return found if found >= 0 else search_all(state, xs, ys, left, end)


@micropython.viper
def add_nearest(state: ptr32, xs: ptr32, ys: ptr32, near: ptr32, tour: ptr32, chain: ptr32, taken: ptr32, left: ptr32, most: int):
    """Add up to `most` lines to the tour, each time the one whose end is nearest. `left`: lines, and behind them where each stands there."""
    count = state[COUNT]
    while most > 0 and state[LEFT] > 0:
        index = count - state[LEFT]
        end = find_nearest(state, xs, ys, near, chain, taken, left, tour[index] ^ 1)
        tour[index + 1] = end
        line = end >> 1
        taken[line] = 1
        last = left[state[LEFT] - 1]
        left[left[count + line]] = last
        left[count + last] = left[count + line]
        state[LEFT] -= 1
        most -= 1


# --- moves


@micropython.viper
def reverse_lines(state: ptr32, tour: ptr32, at: ptr32, log: ptr32, low: int, high: int):
    """Turn round the lines of the indices `low` to `high`."""
    if state[LOGGED] >= 0:
        log[state[LOGGED]] = low
        log[state[LOGGED] + 1] = high
        state[LOGGED] += 2
    while low < high:
        a = tour[low]
        b = tour[high]
        tour[low] = b ^ 1
        tour[high] = a ^ 1
        at[b >> 1] = low
        at[a >> 1] = high
        low += 1
        high -= 1
    if low == high:
        tour[low] ^= 1


@micropython.viper
def queue_end(state: ptr32, queue: ptr32, end: int):
    """Put an end into the queue, once. Behind the 2n + 1 places of the ring lies a mark for each end."""
    size = 2 * state[COUNT] + 1
    if queue[size + end] == 0:
        queue[size + end] = 1
        tail = state[TAIL]
        queue[tail] = end
        state[TAIL] = tail + 1 if tail + 1 < size else 0


@micropython.viper
def queue_line(state: ptr32, tour: ptr32, queue: ptr32, index: int):
    """Put both ends of the line of an index into the queue, if there is one."""
    if 0 < index <= state[COUNT]:
        queue_end(state, queue, tour[index])
        queue_end(state, queue, tour[index] ^ 1)


@micropython.viper
def queue_gap(state: ptr32, tour: ptr32, queue: ptr32, gap: int):
    queue_line(state, tour, queue, gap)
    queue_line(state, tour, queue, gap + 1)


@micropython.viper
def put_lines(state: ptr32, tour: ptr32, at: ptr32, log: ptr32, queue: ptr32, first: int, last: int, gap: int, turned: int):
    """Put the lines of the indices `first` to `last` into a gap. The lines in between move along, in their direction."""
    size = last - first + 1
    low = first
    high = gap
    if gap < first:
        low = gap + 1
        high = last
    reverse_lines(state, tour, at, log, low, high)
    if gap < first:
        reverse_lines(state, tour, at, log, low + size, high)
        if not turned:
            reverse_lines(state, tour, at, log, low, low + size - 1)
        queue_gap(state, tour, queue, low + size - 1)
    else:
        reverse_lines(state, tour, at, log, low, high - size)
        if not turned:
            reverse_lines(state, tour, at, log, high - size + 1, high)
        queue_gap(state, tour, queue, high - size)
    queue_gap(state, tour, queue, low - 1)
    queue_gap(state, tour, queue, high)


@micropython.viper
def move_before(
    state: ptr32, xs: ptr32, ys: ptr32, tour: ptr32, at: ptr32, log: ptr32, queue: ptr32, gap: int, there: int, leaving: int, saved: int
) -> int:
    """Put up to LONGEST lines, the last of them that of the index `there`, into a gap, if that saves way. Return whether it did."""
    beside = tour[gap + 1] if leaving else tour[gap] ^ 1
    after = tour[there + 1]
    saved += apart(xs, ys, tour[there] ^ 1, after)
    first = there
    while first > 0 and first > there - LONGEST and (gap > there or first > gap + 1):
        before = tour[first - 1] ^ 1
        gain = saved + apart(xs, ys, before, tour[first]) - apart(xs, ys, before, after)
        if gain > 0:
            gain -= apart(xs, ys, tour[first], beside)
            if gain > 0:
                state[LENGTH] -= gain
                put_lines(state, tour, at, log, queue, first, there, gap, leaving)
                return 1
        first -= 1
    return 0


@micropython.viper
def move_behind(
    state: ptr32, xs: ptr32, ys: ptr32, tour: ptr32, at: ptr32, log: ptr32, queue: ptr32, gap: int, there: int, leaving: int, saved: int
) -> int:
    """Put up to LONGEST lines, the first of them that of the index `there`, into a gap, if that saves way. Return whether it did."""
    beside = tour[gap + 1] if leaving else tour[gap] ^ 1
    before = tour[there - 1] ^ 1
    saved += apart(xs, ys, before, tour[there])
    last = there
    while last <= state[COUNT] and last < there + LONGEST and (gap + 1 < there or last < gap):
        after = tour[last + 1]
        gain = saved + apart(xs, ys, tour[last] ^ 1, after) - apart(xs, ys, before, after)
        if gain > 0:
            gain -= apart(xs, ys, tour[last] ^ 1, beside)
            if gain > 0:
                state[LENGTH] -= gain
                put_lines(state, tour, at, log, queue, there, last, gap, 1 - leaving)
                return 1
        last += 1
    return 0


@micropython.viper
def join(
    state: ptr32, xs: ptr32, ys: ptr32, tour: ptr32, at: ptr32, log: ptr32, queue: ptr32, end: int, other: int, way: int, now: int
) -> int:
    """Make a move by which the pen goes from `end` to `other` or back, if that saves way. Return whether it did. `now`: the way from or to
    `end` as yet."""
    here = at[end >> 1]
    there = at[other >> 1]
    if here == there or state[LOGGED] > LOG - 20:
        return 0
    leaving = 1 if tour[here] ^ 1 == end else 0
    gap = here - 1 + leaving
    other_leaves = 1 if tour[there] ^ 1 == other else 0
    if leaving == other_leaves:  # both ends of lines, or both beginnings: turn the lines in between
        low = gap
        high = there - 1 + leaving
        if high < low:
            low = high
            high = gap
        far = apart(xs, ys, tour[there] ^ 1, tour[there + 1]) if leaving else apart(xs, ys, tour[there - 1] ^ 1, tour[there])
        gain = now + far - way
        gain -= apart(xs, ys, tour[low + 1], tour[high + 1]) if leaving else apart(xs, ys, tour[low] ^ 1, tour[high] ^ 1)
        if gain > 0 and high - low <= state[FARTHEST]:
            state[LENGTH] -= gain
            reverse_lines(state, tour, at, log, low + 1, high)
            queue_gap(state, tour, queue, low)
            queue_gap(state, tour, queue, high)
            return 1
    if there - gap > state[FARTHEST] or gap - there > state[FARTHEST]:
        return 0
    if other_leaves:
        return move_before(state, xs, ys, tour, at, log, queue, gap, there, leaving, now - way)
    return move_behind(state, xs, ys, tour, at, log, queue, gap, there, leaving, now - way)


@micropython.viper
def make_one_move(state: ptr32, xs: ptr32, ys: ptr32, near: ptr32, tour: ptr32, at: ptr32, log: ptr32, queue: ptr32, end: int) -> int:
    """Make one move that joins an end to a near one. Return whether there was one."""
    here = at[end >> 1]
    now = apart(xs, ys, end, tour[here + 1]) if tour[here] ^ 1 == end else apart(xs, ys, tour[here - 1] ^ 1, end)
    row = end * NEAR
    for index in range(row, row + NEAR):
        if near[index] < 0:
            return 0
        way = apart(xs, ys, end, near[index])
        if way >= now:
            return 0
        state[TRIED] += 1
        if join(state, xs, ys, tour, at, log, queue, end, near[index], way, now):
            return 1
    return 0


@micropython.viper
def improve(state: ptr32, xs: ptr32, ys: ptr32, near: ptr32, tour: ptr32, at: ptr32, log: ptr32, queue: ptr32, most: int) -> int:
    """Look at the ends of the queue, until it is empty or `most` comparisons have been made. Return the ends that are left."""
    size = 2 * state[COUNT] + 1
    begun = state[TRIED]
    while state[HEAD] != state[TAIL] and state[TRIED] - begun < most:
        end = queue[state[HEAD]]
        state[HEAD] = state[HEAD] + 1 if state[HEAD] + 1 < size else 0
        queue[size + end] = 0
        while make_one_move(state, xs, ys, near, tour, at, log, queue, end):
            pass
        state[TRIED] += 1
    left = state[TAIL] - state[HEAD]
    return left if left >= 0 else left + size


@micropython.viper
def kick_once(state: ptr32, xs: ptr32, ys: ptr32, near: ptr32, tour: ptr32, at: ptr32, log: ptr32, queue: ptr32):
    """Swap two neighbouring pieces of the tour, improve the ends at the three seams, and undo both if the tour is not shorter. Wants three lines."""
    count = state[COUNT]
    low = 1 + next_random(state, count - 1)
    middle = low + next_random(state, PIECE)
    if middle > count - 1:
        middle = count - 1
    high = middle + 1 + next_random(state, PIECE)
    if high > count:
        high = count
    length = state[LENGTH]
    state[LOGGED] = 0
    seam = low + high - middle
    was = apart(xs, ys, tour[low - 1] ^ 1, tour[low]) + apart(xs, ys, tour[middle] ^ 1, tour[middle + 1]) + apart(xs, ys, tour[high] ^ 1, tour[high + 1])
    reverse_lines(state, tour, at, log, low, high)
    reverse_lines(state, tour, at, log, low, seam - 1)
    reverse_lines(state, tour, at, log, seam, high)
    state[LENGTH] -= was - apart(xs, ys, tour[low - 1] ^ 1, tour[low]) - apart(xs, ys, tour[seam - 1] ^ 1, tour[seam])
    state[LENGTH] += apart(xs, ys, tour[high] ^ 1, tour[high + 1])
    queue_gap(state, tour, queue, low - 1)
    queue_gap(state, tour, queue, seam - 1)
    queue_gap(state, tour, queue, high)
    improve(state, xs, ys, near, tour, at, log, queue, 0x3FFFFFFF)
    changes = state[LOGGED]
    state[LOGGED] = -1
    if state[LENGTH] - length >= 0:
        while changes > 0:
            changes -= 2
            reverse_lines(state, tour, at, log, log[changes], log[changes + 1])
        state[LENGTH] = length


@micropython.viper
def kick_often(state: ptr32, xs: ptr32, ys: ptr32, near: ptr32, tour: ptr32, at: ptr32, log: ptr32, queue: ptr32, times: int, most: int):
    """Kick `times` times, or until `most` comparisons have been made in all."""
    while times > 0 and state[TRIED] < most:
        kick_once(state, xs, ys, near, tour, at, log, queue)
        times -= 1
