"""A map of heights that a probe has touched, and jobs that follow it.

    grid = Grid(0, 0, 100, 80, 5, 4)
    lines = grid.probing_lines(safe=5, deep=3, feed=100)      # a job: one touch a point
    grid.heights = [z, …]                               # work coordinates, in the order of grid.probe_points()
    text = level_job("G1 X10 Z-1\\n…", grid)                # the same job, its Z moved by the map's height

Between points the height is bilinear, beyond the grid that of its edge. Lines and arcs (G17) become pieces of a quarter of a cell. Lines
that it cannot follow (G91, cycles, arcs of other planes, an unknown position) raise Unfollowed: a job is levelled whole or not at all. It
runs under MicroPython too, in a browser's tab.
"""

import math

from host_tools.programs.program_lines import WrongLetter, program_lines, raw_lines_of

MOST_POINTS = 400
_LEAST_PIECE_MM = 0.5
_CLOSED = 5e-7  # radians: an end this near closes the circle
_MOST_LINES = 1_000_000
_ELSEWHERE = (28, 30, 53)  # the place is another one behind them
_REFUSED = (10, 38.2, 38.3, 38.4, 38.5, 73, 81, 82, 83, 92, 92.1, 93, 43.1)


class Unfollowed(Exception):
    """A job cannot be levelled: args are the line's number, and why: relative, cycle, plane, place, arc or length."""


class Grid:
    def __init__(self, x0, y0, x1, y1, columns, rows):
        """Two columns and rows at least; mm of the work."""
        self.x0, self.y0 = x0, y0
        self.dx, self.dy = (x1 - x0) / (columns - 1), (y1 - y0) / (rows - 1)
        self.columns, self.rows = columns, rows
        self.heights = []

    def probe_points(self):
        """Return the points (x, y), mm, in the order in which they are touched: row after row, to and fro."""
        found = []
        for row in range(self.rows):
            columns = range(self.columns) if row % 2 == 0 else range(self.columns - 1, -1, -1)
            found += [(self.x0 + column * self.dx, self.y0 + row * self.dy) for column in columns]
        return found

    def probing_lines(self, safe, deep, feed):
        """Return the lines of a job that touches every point, from `safe` mm above zero of Z to `deep` mm below it, at `feed` mm/min."""
        lines = ["G21 G90 G94", "G0 Z%.3f" % safe]
        for x, y in self.probe_points():
            lines += ["G0 X%.3f Y%.3f" % (x, y), "G38.2 Z%.3f F%.1f" % (-deep, feed), "G0 Z%.3f" % safe]
        return lines

    def is_whole(self):
        """True if every point has a height."""
        return len(self.heights) == self.columns * self.rows

    def height_of(self, column, row):
        """Return the height of a point in mm, by its column and row."""
        return self.heights[row * self.columns + (column if row % 2 == 0 else self.columns - 1 - column)]

    def height_at(self, x, y):
        """Return the height of the surface at x, y in mm: bilinear between the four points around it, at the edge that of the edge."""
        across, column = _cell_part((x - self.x0) / self.dx, self.columns)
        along, row = _cell_part((y - self.y0) / self.dy, self.rows)
        low = self.height_of(column, row) * (1 - across) + self.height_of(column + 1, row) * across
        high = self.height_of(column, row + 1) * (1 - across) + self.height_of(column + 1, row + 1) * across
        return low * (1 - along) + high * along

    def longest_piece(self):
        """Return the length of the longest piece of a levelled move, in mm."""
        return max(_LEAST_PIECE_MM, min(abs(self.dx), abs(self.dy)) / 4)


def _cell_part(value, count):
    """Return (part of a cell, its number) of a coordinate in cells."""
    value = min(max(value, 0.0), count - 1.0)
    cell = min(int(value), count - 2)
    return value - cell, cell


def _words_of(line):
    """Return [(letter, number)] of a line of program_lines(). Raises ValueError."""
    found = []
    text = line.upper().replace(" ", "")
    at = 0
    while at < len(text):
        end = at + 1
        while end < len(text) and text[end] in "+-.0123456789":
            end += 1
        found.append((text[at], float(text[at + 1 : end])))
        at = end
    return found


class _Levelled:
    def __init__(self, grid):
        self._grid = grid
        self._place = [None, None, None]  # mm of the job
        self._motion = 0
        self._scale = 1.0
        self._plane = 17
        self.lines = []

    def take_line(self, number, text):
        """Append the levelled lines of one line of the job to `lines`. Raises Unfollowed if it cannot be levelled, or the job gets longer than
        _MOST_LINES."""
        if text[:1] == "$":
            self.lines.append(text)
            return
        try:
            words = _words_of(text)
        except ValueError:
            raise Unfollowed(number, "length")
        codes = [value for letter, value in words if letter == "G"]
        self._check_codes(number, codes)
        values = {letter: value for letter, value in words if letter not in "GMN"}
        axes = [letter for letter in "XYZ" if letter in values]
        if [code for code in codes if code in _ELSEWHERE]:
            if self._scale != 1:
                raise Unfollowed(number, "place")
            self._place = [None, None, None]
            self.lines.append(text)
        elif not axes and not (self._motion in (2, 3) and ("I" in values or "J" in values)) or 4 in codes:
            self.lines.append(text if self._scale == 1 else self._other_words(words).rstrip())
        else:
            self._put_move(number, words, values)
        if len(self.lines) > _MOST_LINES:
            raise Unfollowed(number, "length")

    def _check_codes(self, number, codes):
        """Follow the G codes of motion, units and plane. Raises Unfollowed at G91, work offsets and the codes of _REFUSED."""
        for code in codes:
            if code == 91:
                raise Unfollowed(number, "relative")
            if code in _REFUSED or 54 <= code < 60:
                raise Unfollowed(number, "cycle")
            if code in (0, 1, 2, 3):
                self._motion = int(code)
            elif code in (20, 21):
                self._scale = 25.4 if code == 20 else 1.0
            elif code in (17, 18, 19):
                self._plane = int(code)

    def _put_move(self, number, words, values):
        """Append the lines of a motion, split so that Z follows the map. Raises Unfollowed if a cut's position is not known, or an arc lies outside
        of XY."""
        begun = self._place
        to = [values[letter] * self._scale if letter in values else begun[n] for n, letter in enumerate("XYZ")]
        others = self._other_words(words)
        points = [to]
        if self._motion in (2, 3):
            if self._plane != 17:
                raise Unfollowed(number, "plane")
            if None in begun:
                raise Unfollowed(number, "place")
            points = self._arc_points(number, begun, to, values)
        elif self._motion == 1 and None not in begun:
            points = self._split_move(begun, to)
        elif self._motion == 1 and None in to:
            raise Unfollowed(number, "place")  # it cuts, and nobody knows where
        self._place = to
        code = "G0" if self._motion == 0 else "G1"
        for point in points:
            self.lines.append(others + code + self._point_text(point))
            others = ""

    def _other_words(self, words):
        """Return the words that stay as they are. Those of the motion are made anew, because units become mm."""
        told = ""
        for letter, value in words:
            if letter == "G" and value in (0, 1, 2, 3):
                continue
            if letter == "G" and value == 20:
                value = 21
            if letter == "F":
                value *= self._scale
            if letter not in "XYZIJKRN":
                told += "%s%s " % (letter, ("%.4f" % value).rstrip("0").rstrip("."))
        return told

    def _point_text(self, point):
        """Return the words of a point in mm, Z raised by the map's height there, by the map's highest if X or Y is not known; None: no word."""
        x, y, z = point
        text = "".join([" %s%.3f" % (letter, value) for letter, value in (("X", x), ("Y", y)) if value is not None])
        if z is None:
            return text
        return text + " Z%.3f" % (z + self._grid.height_at(x, y) if x is not None and y is not None else z + max(self._grid.heights))

    def _split_move(self, begun, to):
        length = math.sqrt((to[0] - begun[0]) ** 2 + (to[1] - begun[1]) ** 2)
        count = max(1, -int(-length / self._grid.longest_piece() // 1))
        return [[a + (b - a) * n / count for a, b in zip(begun, to)] for n in range(1, count)] + [to]

    def _arc_points(self, number, begun, to, values):
        """Return the points of an arc or helix behind its start `begun`, mm, `to` included: by R, or I and J. Chords are at most 0.01 mm off and as
        short as the map wants. Raises Unfollowed if no arc fits."""
        clockwise = self._motion == 2
        if "R" in values:
            x, y, radius = to[0] - begun[0], to[1] - begun[1], values["R"] * self._scale
            far = math.sqrt(x * x + y * y)
            if far < 1e-6 or 4 * radius * radius < far * far * 0.9999:
                raise Unfollowed(number, "arc")
            aside = math.sqrt(max(0.0, 4 * radius * radius - far * far)) / far
            if clockwise == (radius > 0):
                aside = -aside
            i, j = (x - y * aside) / 2, (y + x * aside) / 2
        else:
            i, j = values.get("I", 0) * self._scale, values.get("J", 0) * self._scale
        cx, cy = begun[0] + i, begun[1] + j
        radius = math.sqrt(i * i + j * j)
        if radius < 1e-6:
            raise Unfollowed(number, "arc")
        first, last = math.atan2(-j, -i), math.atan2(to[1] - cy, to[0] - cx)
        sweep = (first - last if clockwise else last - first) % (2 * math.pi)
        if sweep < _CLOSED:
            sweep = 2 * math.pi
        # Pieces as short as the map wants them, and no farther than a hundredth of a millimetre from the arc.
        most = min(self._grid.longest_piece() / radius, 2 * math.acos(max(-1.0, 1 - 0.01 / radius)) if radius > 0.01 else 1.0)
        count = max(1, -int(-sweep / most // 1))
        points = []
        for n in range(1, count):
            angle = first + sweep * n / count * (-1 if clockwise else 1)
            points.append([cx + radius * math.cos(angle), cy + radius * math.sin(angle), begun[2] + (to[2] - begun[2]) * n / count])
        return points + [to]


def level_job(text, grid):
    """Return a job's text with Z moved by the map's heights. Raises Unfollowed."""
    levelled = _Levelled(grid)
    levelled.lines.append("G21 G90")
    try:
        for number, line in program_lines(raw_lines_of(text.encode())):
            levelled.take_line(number, "".join([" " + letter if "@" < letter < "{" else letter for letter in line.decode()]).strip())
    except WrongLetter as wrong:
        raise Unfollowed(wrong.number, "length")
    return "\n".join(levelled.lines) + "\n"
