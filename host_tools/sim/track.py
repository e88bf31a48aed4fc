"""Follows the motors of a board through its step words, taken in whole arrays.

    track = Track(layout, drive, steps_per_mm, by_height=True)
    track.add_words(tick, words)            # numpy's uint32: words that begin at `tick`, one behind the other
    track.low, track.high, track.fastest, track.strokes, track.samples

Positions at each step come from sums over an array; computations that need the position before (points of the path, windows of a speed) leap over
the steps that cannot matter. Memory does not grow with the job: when the path or the speeds become too
many, every second one of them is dropped, and from then on they are taken half as densely. Strokes that are too many become fewer:
the shortest are drawn as the ones before them.
"""

import numpy as np

TICKS_PER_S = 12_500_000
SPEED_TICKS = TICKS_PER_S // 50  # speeds are measured over 20 ms
SPACING_MM = 0.1  # between two positions of the path drawn
MOST_PLACES = 1 << 16
MOST_STROKES = 1 << 14
MOST_SAMPLES = 1 << 14


class Rows:
    """A table that grows, of at most about `most` rows: past it, every second row that may go is dropped."""

    def __init__(self, columns, kind, most):
        self._most = most
        self._room = np.zeros((1024, columns), kind)
        self._count = 0
        self.stride = 1  # how sparsely rows are to be taken

    def add_rows(self, rows):
        """Append `rows`; True if the table has been thinned."""
        while self._count + len(rows) > len(self._room):
            self._room = np.concatenate([self._room, np.zeros_like(self._room)])
        self._room[self._count : self._count + len(rows)] = rows
        self._count += len(rows)
        return self._count > self._most

    def thin_rows(self, keep):
        """Keep the rows of the mask `keep`. If they are still too many, more room is granted."""
        kept = self.all_rows()[keep]
        self._count = len(kept)
        self._room[: self._count] = kept
        self.stride *= 2
        self._most = max(self._most, 2 * self._count)

    def all_rows(self):
        """Return the rows so far, a view."""
        return self._room[: self._count]


class Track:
    def __init__(self, layout, drive, steps_per_mm, by_height, drawn=True, belt=False):
        """`by_height`: path below Z0 of the program, `surface` in mm, is drawn as cut, whether the tool is on or not;
        `drawn`: False keeps no path; `belt`: the first two motors hold one belt (CoreXY)."""
        self._belt = belt
        self.by_height = by_height
        self.surface = 0.0
        self._layout = layout
        self._drive = drive
        self._scale = np.array(steps_per_mm)
        self._levels = drive.levels() if drive else 0
        self._axes = layout.axes
        self.steps = 0
        self.fastest = [0.0] * layout.axes  # mm/min
        self._drawn = drawn
        self._apart = [max(1, int(np.ceil(SPACING_MM * scale - 1e-9))) for scale in steps_per_mm]
        self.begin(0, [0] * layout.axes)

    def begin(self, tick, position):
        """Begin the job at `tick` and `position`, in steps."""
        self._zero = tick
        self.last_tick = tick
        self.position = np.array(position, np.int64)
        self._motors = self.position.copy()
        if self._belt:
            self._motors[:2] = self.position[0] + self.position[1], self.position[0] - self.position[1]
        self._low, self._high = self.position.copy(), self.position.copy()
        self._measured = Rows(1 + self._axes, np.int64, MOST_SAMPLES)
        self._latest = np.array([0, *position])  # the last row that was measured
        self._measured.add_rows(self._latest[None])
        self._window = tick
        self._windows = 0
        self._path = Rows(2 + self._axes, np.int32, MOST_PLACES)  # begins, lowered, position
        self._path.add_rows(np.array([[1, 0, *position]]))
        self._lowered = False
        self._last = list(position)
        self._leap = 0  # steps that cannot be drawn
        self._shortest = SPACING_MM  # mm of a stroke that has not been joined

    @property
    def seconds(self):
        return (self.last_tick - self._zero) / TICKS_PER_S

    @property
    def low(self):
        """Lowest position of each axis in mm."""
        return [float(position) for position in self._low / self._scale]

    @property
    def high(self):
        """Highest position of each axis, mm."""
        return [float(position) for position in self._high / self._scale]

    # --- the words

    def add_words(self, tick, words):
        """Take words that begin at `tick`. Their total is below 2⁶² ticks."""
        layout = self._layout
        levels = words & layout.levels_mask
        lasts = (words >> layout.bits).astype(np.int64)
        moves = self._axis_moves(levels)
        steps = np.flatnonzero(moves.any(axis=1))
        if not len(steps):
            return
        ticks = tick + np.cumsum(lasts)[steps] - lasts[steps]
        positions = self._motors + np.cumsum(moves[steps], axis=0, dtype=np.int64)
        self._motors = positions[-1].copy()
        if self._belt:
            a, b = positions[:, 0].copy(), positions[:, 1].copy()
            positions[:, 0], positions[:, 1] = (a + b) // 2, (a - b) // 2
        self.steps += len(steps)
        self.position = positions[-1]
        self.last_tick = int(ticks[-1])
        self._low = np.minimum(self._low, positions.min(axis=0))
        self._high = np.maximum(self._high, positions.max(axis=0))
        if self._drawn:
            if self.by_height:
                lowered = positions[:, 2] / self._scale[2] < self.surface
            else:
                lowered = (levels[steps] & layout.tool_mask) != 0
            self._draw_path(positions, lowered)
        self._measure_speeds(ticks, positions)

    def _axis_moves(self, levels):
        """Return −1, 0 or 1 of each axis in each word."""
        layout = self._layout
        moves = np.zeros((len(levels), self._axes), np.int8)
        if self._drive is None:
            for axis in range(self._axes):
                up = (levels >> (layout.motors + axis)) & 1
                moves[:, axis] = ((levels >> axis) & 1).astype(np.int8) * (2 * up.astype(np.int8) - 1)
            return moves
        coils = levels & (layout.tool_mask - 1)
        before = np.concatenate(([self._levels], coils[:-1])).astype(np.uint32)
        self._levels = int(coils[-1])
        pairs, index = np.unique(before.astype(np.uint64) << np.uint64(32) | coils, return_inverse=True)
        for axis in range(self._axes):
            table = [self._drive.step_between(axis, int(pair) >> 32, int(pair) & 0xFFFFFFFF) for pair in pairs]
            moves[:, axis] = np.array(table, np.int8)[index]
        return moves

    # --- the path, each tenth of a millimetre

    def _draw_path(self, positions, lowered):
        """Add the points of a path to the picture: `positions` (n × axes, steps) and `lowered` (n), cut where the tool is lowered or raised."""
        ends = [*(np.flatnonzero(lowered[1:] != lowered[:-1]) + 1).tolist(), len(positions)]
        columns = [memoryview(np.ascontiguousarray(positions[:, axis])) for axis in range(self._axes)]  # quicker than arrays, one by one
        found = []
        begun = 0
        for end in ends:
            kind = bool(lowered[begun])
            if kind != self._lowered:
                here = [column[begun] for column in columns]
                found += [(1, kind, *self._last), (0, kind, *here)]
                self._lowered, self._last = kind, here
                self._leap = begun + min(self._apart)
            self._follow_run(columns, end, kind, found)
            begun = end
        self._leap -= len(positions)
        if found and self._path.add_rows(np.array(found)):
            self._thin_path()

    def _follow_run(self, columns, end, kind, found):
        """Append the positions of a run that ends before the index `end`. A step moves an axis by one at most, so as many as are
        missing to the next position need not be looked at."""
        at = self._leap
        last = self._last
        apart = self._apart
        least = min(apart)
        axes = range(self._axes)
        while at < end:
            missing = min(apart[axis] - abs(columns[axis][at] - last[axis]) for axis in axes)
            if missing > 0:
                at += missing
                continue
            last = [column[at] for column in columns]
            found.append((0, kind, *last))
            at += least
        self._last = last
        self._leap = at

    def _thin_path(self):
        """Drop every second position but the ends of strokes."""
        rows = self._path.all_rows()
        self._join_strokes(rows)
        keep = np.arange(len(rows)) % 2 == 0
        keep[rows[:, 0] == 1] = True
        keep[:-1][rows[1:, 0] == 1] = True
        keep[-1] = True
        self._path.thin_rows(keep)
        self._apart = [2 * apart for apart in self._apart]

    def _join_strokes(self, rows):
        """If there are too many strokes, draw the shortest as the ones before them, until half as many as there may be are left. The first
        stays, and the last, which goes on."""
        begins = np.flatnonzero(rows[:, 0])
        if len(begins) <= MOST_STROKES:
            return
        while len(begins) > MOST_STROKES // 2:
            self._shortest *= 2
            steps = np.abs(np.diff(rows[:, 2:] / self._scale, axis=0, prepend=rows[:1, 2:] / self._scale)).max(axis=1)
            stays = np.add.reduceat(steps, begins) >= self._shortest
            stays[[0, -1]] = True
            of_row = np.maximum.accumulate(np.where(stays, np.arange(len(begins)), 0))
            kinds = rows[begins, 1][of_row]
            rows[:, 1] = np.repeat(kinds, np.diff([*begins, len(rows)]))
            rows[begins[1:], 0] = kinds[1:] != kinds[:-1]
            begins = np.flatnonzero(rows[:, 0])

    @property
    def strokes(self):
        """[(cut, positions in mm)]: the path, in its order."""
        rows = self._path.all_rows()
        begins = [*np.flatnonzero(rows[:, 0]).tolist(), len(rows)]
        positions = rows[:, 2:] / self._scale
        return [(bool(rows[begun, 1]), positions[begun:end]) for begun, end in zip(begins, begins[1:])]

    # --- speeds

    def _measure_speeds(self, ticks, positions):
        """Note speeds from the positions at the ends of windows of 20 ms, longer while the machine stands."""
        found = []
        at = int(np.searchsorted(ticks, self._window + SPEED_TICKS))
        while at < len(ticks):
            found.append(at)
            self._window = int(ticks[at])
            at = int(np.searchsorted(ticks, self._window + SPEED_TICKS))
        if not found:
            return
        rows = np.column_stack([ticks[found] - self._zero, positions[found]])
        ways = np.diff(rows, axis=0, prepend=[self._latest])
        speeds = np.abs(ways[:, 1:] / self._scale) / (ways[:, :1] / TICKS_PER_S / 60)
        self.fastest = [float(fastest) for fastest in np.maximum(self.fastest, speeds.max(axis=0))]
        self._latest = rows[-1]
        numbers = np.arange(self._windows + 1, self._windows + 1 + len(rows))
        self._windows += len(rows)
        if self._measured.add_rows(rows[numbers % self._measured.stride == 0]):
            self._measured.thin_rows(np.arange(len(self._measured.all_rows())) % 2 == 0)

    @property
    def samples(self):
        """Rows (seconds, mm/min along the path, mm/min of each axis) over 20 ms or more up to then."""
        rows = self._measured.all_rows()
        minutes = np.diff(rows[:, :1], axis=0) / TICKS_PER_S / 60
        speeds = np.diff(rows[:, 1:], axis=0) / self._scale / minutes
        return np.column_stack([rows[1:, 0] / TICKS_PER_S, np.sqrt((speeds**2).sum(axis=1)), speeds])

    def accelerations(self):
        """Return rows (seconds, mm/s² of each axis), from each sample to the next."""
        samples = self.samples
        times = np.concatenate([[0.0], samples[:, 0]])
        middles = (times[2:] - times[:-2]) / 2  # from the middle of each sample to that of the next
        return np.column_stack([samples[:-1, 0], np.diff(samples[:, 2:], axis=0) / 60 / middles[:, None]])
