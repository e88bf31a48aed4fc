"""Weaving: a seam, line or arc, walked from side to side; handed to the planner piece by piece as it has room.

    spec = shape, amplitude_um, pitch_um, left_ms, right_ms, along              # ms at the edges; 1: the speed is that along the seam
    woven = Woven(deltas, plane, None, spec, nm_s, tool, tag, steps_per_m)
    while woven.left and planner.room():
        woven.add(planner)

One pitch of each shape, amplitude to the left and to the right of the seam; d: the dwells at the edges:

    zigzag   /d\\           triangle  /|           trapezoid  /--d\\            sine, by chords
            /   \\    /              / |                     /     \\      /    within ¼ step
                 \\d/                   | /                          \\--d/
                                       |/

A whole number of pitches goes into the seam, so a pitch is a little longer or shorter than asked for. The speed is that along the
path; with `along` that along the seam: the path's speed is then higher by the ratio of the path of a pitch to the pitch. On an arc a point
lies its offset inside or outside of the circle, and lines that are straight beside a line are bent with it, by chords within ¼ step.
A dwell stops at the edge for exactly its time, beside the time of the path.

Integers only: positions in nanometres, angles by CORDIC. Big integers, once a piece.
"""

from micropython import const

from passo.motion.cordic import TURN, arc_length, rotate, vector
from passo.motion.integers import isqrt, length_nm
from passo.records import COUNT_MASK, NM_PER_M, TICKS_PER_MS, TICKS_PER_S

ZIGZAG = const(1)
TRIANGLE = const(2)
TRAPEZOID = const(3)
SINE = const(4)
NAMES = ("none", "zigzag", "triangle", "trapezoid", "sine")

MOST_AMPLITUDE_UM = const(100_000)
LEAST_PITCH_UM = const(100)
MOST_PITCH_UM = const(1_000_000)
MOST_DWELL_MS = const(60_000)
_NM_PER_UM = const(1000)
_PEAK = const(1 << 16)  # an edge

# Points of a pitch: (eighths of it, side: up to _PEAK left, 0 the seam, down to -_PEAK right, dwell there).
_POINTS = {
    ZIGZAG: ((2, _PEAK, True), (6, -_PEAK, True), (8, 0, False)),
    TRIANGLE: ((4, _PEAK, True), (4, -_PEAK, True), (8, 0, False)),
    TRAPEZOID: ((1, _PEAK, False), (3, _PEAK, True), (5, -_PEAK, False), (7, -_PEAK, True), (8, 0, False)),
}


def is_out_of_range(spec):
    """Return True if a value of the spec is out of its range."""
    shape, amplitude, pitch, left, right, along = spec
    return not (
        ZIGZAG <= shape <= SINE and 0 < amplitude <= MOST_AMPLITUDE_UM and LEAST_PITCH_UM <= pitch <= MOST_PITCH_UM
        and 0 <= left <= MOST_DWELL_MS and 0 <= right <= MOST_DWELL_MS and 0 <= along <= 1
    )  # fmt: skip


class Woven:
    """`left`: 0 when all has been handed on. The counterpart of Chords of control/stream_queue.py for an arc."""

    def __init__(self, deltas, plane, circle, spec, nm_s, tool, tag, steps_per_m):
        """`deltas`: the seam's, steps of all axes; `plane`: its two axes; `circle`: None, or (centre in steps from here, clockwise,
        turns on top, over half a turn) of an arc. Raises ValueError if the seam has no length in the plane, the arc is none or too
        narrow for the amplitude, or a piece would last longer than the planner can say."""
        self.left = 1
        self.flush = False  # when the last has been added, the planner is to be flushed
        self._deltas = deltas
        self._a, self._b = plane
        self._steps_per_m = steps_per_m
        self._tool = tool
        self._tag = tag
        shape, amplitude, pitch, self._left_ms, self._right_ms, along = spec
        self._amplitude = amplitude * _NM_PER_UM
        across = [deltas[axis] * NM_PER_M // steps_per_m[axis] for axis in plane]
        if circle is None:
            self._radius = 0
            self._way = across
            length = isqrt(across[0] * across[0] + across[1] * across[1])
        else:
            length = self._take_arc(across, *circle)
        if not length:
            raise ValueError("no seam in the plane")
        self._length = length
        pitch *= _NM_PER_UM
        self._pitches = max((length + pitch // 2) // pitch, 1)
        self._points = self._sine_points() if shape == SINE else _POINTS[shape]
        self._of_pitch = self._points[-1][0]
        self._nm_s = self._path_speed(nm_s) if along else nm_s or 1  # along the path
        longest = max(length // self._pitches, 4 * self._amplitude) * TICKS_PER_S // self._nm_s
        if longest > COUNT_MASK:
            raise ValueError("pieces of more than 43 s")
        self._pitch = 0  # the pitch under way,
        self._point = 0  # the point that is led to,
        self._part = 0  # and the chord on the way there
        self._dwell = 0  # ms that are to be waited before it goes on
        self._from = 0, 0  # (parts of the whole seam, offset) of the point before
        self._before = [0] * len(deltas)

    def _take_arc(self, end, centre, clockwise, turns, over_half):
        """Take the arc's centre, radius and sweep. Returns its length in nm. Raises ValueError."""
        steps_per_m = self._steps_per_m
        plane = self._a, self._b
        self._centre = [centre[index] * NM_PER_M // steps_per_m[plane[index]] for index in (0, 1)]
        x, y = -self._centre[0], -self._centre[1]
        start, radius = vector(x, y)
        to_x, to_y = end[0] + x, end[1] + y
        sweep = (vector(to_x, to_y)[0] - start) % TURN
        if clockwise:
            sweep = (TURN - sweep) % TURN
        if over_half is not False and not any([self._deltas[axis] for axis in plane]) or over_half and sweep < TURN >> 8:
            sweep = TURN
        elif over_half is False and sweep > TURN - (TURN >> 8):
            sweep = 0
        sweep += turns * TURN
        if radius <= self._amplitude:
            raise ValueError("an arc narrower than the amplitude")
        self._clockwise = clockwise
        self._radius = radius
        self._sweep = sweep
        self._arm = x, y
        last_x, last_y = self._turn_arm(sweep)
        self._off = to_x - last_x, to_y - last_y
        return arc_length(radius, sweep)

    def _turn_arm(self, angle):
        """Return the start, seen from the arc's centre and turned by `angle`, in nm."""
        return rotate(self._arm[0], self._arm[1], -angle if self._clockwise else angle)

    def _sine_points(self):
        """Return the points of a sine's pitch: enough to keep chords within ¼ step of it."""
        finest = max(self._steps_per_m[self._a], self._steps_per_m[self._b])
        steps = self._amplitude * finest // NM_PER_M + 1
        count = 4 * (isqrt(2 * steps) * 2 // 3 + 4)  # 2π·√(A/2) chords and more, a multiple of four
        points = []
        for number in range(1, count + 1):
            height = rotate(_PEAK << 8, 0, TURN * number // count)[1] >> 8
            points.append((number, height, number == count // 4 or number == 3 * count // 4))
        points[-1] = count, 0, False
        return points

    def _offset_nm(self, side):
        """Return the nm to the left of the seam of a point's second field."""
        return self._amplitude * side // _PEAK

    def _path_speed(self, nm_s):
        """Return the speed along the path, nm/s, for `nm_s` along the seam."""
        pitch = self._length // self._pitches
        path = at = beside = 0
        for along, side, _ in self._points:
            way = (along - at) * pitch // self._of_pitch
            over = self._offset_nm(side) - beside
            path += isqrt(way * way + over * over)
            at, beside = along, self._offset_nm(side)
        return nm_s * path // pitch or 1

    def edge_points(self):
        """Yield the positions that the seam's edges reach, in steps of all axes from its start: for the travel's limits."""
        whole = self._pitches * self._of_pitch
        for pitch in range(self._pitches):
            for along, side, _ in self._points:
                yield self._position_at(pitch * self._of_pitch + along, whole, self._offset_nm(side))

    def add(self, planner):
        """Queue the next piece: a chord, or the dwell behind it. A chord too short for a step queues nothing."""
        if self._dwell:
            ms, self._dwell = self._dwell, 0
            planner.wait(ms * TICKS_PER_MS, self._tool, self._tag)
        else:
            self._queue_chord(planner)
        if self._pitch == self._pitches and not self._dwell:
            self.left = 0
            if self.flush:
                planner.flush()

    def _queue_chord(self, planner):
        """Queue the next chord."""
        along, side, dwells = self._points[self._point]
        to = self._pitch * self._of_pitch + along
        offset = self._offset_nm(side)
        since, beside = self._from
        parts = self._count_chords(to - since)
        self._part += 1
        here = self._position_at(
            since * parts + (to - since) * self._part, self._pitches * self._of_pitch * parts,
            beside + (offset - beside) * self._part // parts,
        )  # fmt: skip
        deltas = [now - then for now, then in zip(here, self._before)]
        self._before = here
        ticks = length_nm(deltas, self._steps_per_m) * TICKS_PER_S // self._nm_s
        planner.line(deltas, ticks, self._tool, self._tag)
        if self._part == parts:
            self._next_point(to, offset, dwells and side)

    def _next_point(self, to, offset, side):
        """Go to the next point of the pitch; note the dwell at this one."""
        self._part = 0
        self._from = to, offset
        if side:
            self._dwell = self._left_ms if side > 0 else self._right_ms
        self._point += 1
        if self._point == len(self._points):
            self._point = 0
            self._pitch += 1

    def _count_chords(self, way):
        """Return the number of chords to the next point: 1, on an arc enough to keep them within ¼ step of the bent line."""
        if not self._radius or not way:
            return 1
        angle = arc_length(1 << 20, self._sweep * way // (self._pitches * self._of_pitch))
        finest = max(self._steps_per_m[self._a], self._steps_per_m[self._b])
        steps = (self._radius + self._amplitude) * finest // NM_PER_M + 1
        return (isqrt(angle * angle * steps // 2) >> 20) + 1

    def _position_at(self, part, whole, offset):
        """Return the steps of all axes from the seam's start, `part` of `whole` along it and `offset` nm to its left."""
        found = [(2 * delta * part // whole + 1) >> 1 for delta in self._deltas]
        if part == whole and not offset:
            return list(self._deltas)
        if self._radius:
            x, y = self._turn_arm(self._sweep * part // whole)
            out = offset if self._clockwise else -offset
            near_x = self._centre[0] + x + x * out // self._radius + self._off[0] * part // whole
            near_y = self._centre[1] + y + y * out // self._radius + self._off[1] * part // whole
        else:
            way = self._way
            near_x = way[0] * part // whole - way[1] * offset // self._length
            near_y = way[1] * part // whole + way[0] * offset // self._length
        for axis, near in ((self._a, near_x), (self._b, near_y)):
            found[axis] = (2 * near * self._steps_per_m[axis] // NM_PER_M + 1) >> 1
        return found
