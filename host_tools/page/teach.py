"""Teach-in: manual moves, written down as a program that makes them again.

    teach = Teach(recognise)
    teach.begin()               # from where the machine stands
    teach.add_report(state)     # with each report
    text = teach.program_text()         # G-code

A manual move of the page is straight, from rest to rest: so the positions where it rests are its path. Moves that go on in one line are
one line of the program. `recognise(points, ways)` may do better: it gives the lines of G-code for a list of positions, with the positions
seen on the way to each but the first. A PC's finds arcs (host_tools/panel/hand_path.py).
"""

from passo import errors

_NEAR_MM = 0.0015  # off the straight line: more than the rounding to three decimals
_MOST = 5000  # positions
_MOST_SEEN = 100_000  # on the way: an hour of motion


class Teach:
    def __init__(self, recognise=None):
        self._recognise = recognise
        self._points = None
        self._full = False  # more than it keeps
        self._on = ""
        self._feed = 0
        self._lines = []

    def count_positions(self):
        """The number of positions recorded; −1: it does not record."""
        return -1 if self._points is None else self._count

    def begin(self):
        """Begin to record from where the machine stands, and forget an older record. Returns 0."""
        self._points = []
        self._ways = []  # to each of the points behind the first
        self._way = []
        self._count = self._seen = 0
        self._full = False
        self._lines = []
        self._on = ""
        self._feed = 0
        return 0

    def drop(self):
        self._points = None
        return 0

    def add_report(self, state):
        """Take a report of the machine, a page's state: a position at rest is recorded, positions in motion show the way to it."""
        if self._points is None:
            return
        self._feed = max(self._feed, state.get("feed", 0))
        position = list(state["w"])
        points = self._points
        if state["state"] != "Idle":
            if self._recognise and points:
                self._way.append(position)
            return
        way, self._way = self._way, []
        if not points:
            self._on = state.get("on", "")
            points.append(position)
            self._count = max(self._count, 1)
        elif [other for other in way + [position] if not same_position(other, points[-1])]:
            self._seen += len(way)
            self._full = self._full or len(points) >= _MOST or self._seen > _MOST_SEEN
            if not self._full:
                points.append(position)
                self._ways.append(way)
                self._count += 1
        if state.get("on", "") != self._on:
            self._on = state["on"]
            self._flush_points()
            self._lines.append("M3" if "S" in self._on else "M4" if "C" in self._on else "M5")

    def program_text(self):
        """End recording and return the program's text, or the number of an error."""
        if self._points is None:
            return errors.NO_SUCH_JOB
        if self._full:
            return errors.JOB_SIZE
        self._flush_points()
        lines = ["G21 G90 G94 G54", "F%.0f" % (self._feed or 500)] + self._lines + ["M2"]
        self._points = None
        return "\n".join(lines) + "\n"

    def _flush_points(self):
        """Turn the points gathered into lines of G-code, and keep only the last point."""
        if len(self._points) > 1:
            self._lines += self._recognise(self._points, self._ways) if self._recognise else lines_of(self._points)
            self._points = self._points[-1:]
            self._ways = []


def same_position(one, other):
    """True if two positions differ by 0.5 µm at most in each axis: reports have three decimals."""
    return max([abs(one[axis] - other[axis]) for axis in range(len(one))]) <= 0.0005


def lines_of(points):
    """G1 lines from points[0] on, positions in mm; moves straight behind one another become one line."""
    kept = points[:1]
    for at in range(1, len(points)):
        if len(kept) > 1 and is_straight(kept[-2], kept[-1], points[at]):
            kept[-1] = points[at]
        else:
            kept.append(points[at])
    return [line_to(point, kept[at]) for at, point in enumerate(kept[1:])]


def line_to(point, before):
    return "G1 " + " ".join(["XYZA"[axis] + "%.3f" % point[axis] for axis in range(len(point)) if abs(point[axis] - before[axis]) > 0.0004])


def is_straight(first, middle, last):
    """True if `middle` lies between first and last, within _NEAR_MM of the straight line, in mm."""
    way = [last[axis] - first[axis] for axis in range(len(first))]
    part = [middle[axis] - first[axis] for axis in range(len(first))]
    length = sum([each * each for each in way])
    along = sum([way[axis] * part[axis] for axis in range(len(way))])
    if not 0 < along < length:
        return False
    off = [part[axis] - way[axis] * along / length for axis in range(len(way))]
    return max([abs(each) for each in off]) <= _NEAR_MM
