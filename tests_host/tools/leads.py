"""Random contours with lead-ins and lead-outs as CAM programs and textbooks write them, as NGC programs, for tests.

    case = Case(random.Random(7), "arc")
    case.text, case.num, case.gouge(points), case.missed(points)
"""

import math

import numpy as np
from shapely import LineString, Point, Polygon

LEFT, RIGHT = 1, -1
KINDS = ("arc", "edge", "first arc", "square")


def _unit(way):
    return way / abs(way)


def outline(draw):
    """Corners of a polygon without crossings, counterclockwise."""
    while True:
        count = draw.randrange(3, 10)
        angles = sorted(draw.uniform(0, math.tau) for _ in range(count))
        if max(b - a for a, b in zip(angles, angles[1:] + [angles[0] + math.tau])) < 3:
            corners = [draw.uniform(15, 40) * complex(math.cos(angle), math.sin(angle)) for angle in angles]
            turned = corners[-1:] + corners[:-1]
            if Polygon([(each.real, each.imag) for each in corners]).is_valid and min(abs(a - b) for a, b in zip(corners, turned)) > 4:
                return corners


class Case:
    """`text`: the program; `num`: the same for NUM; `part`: the milled part (outside) or the hole in it (inside), as a polygon."""

    def __init__(self, draw, kind):
        self.kind = kind
        self.inside, clockwise = draw.random() < 0.5, draw.random() < 0.5
        self.radius = draw.choice((0.5, 1.0, 2.0, 3.0))
        self.side = LEFT if self.inside != clockwise else RIGHT
        corners = outline(draw)
        if clockwise:
            corners.reverse()
        self._draw = draw
        self._start(corners)
        self._rows = []
        self._pieces()
        self.part = Polygon([(each.real, each.imag) for each in self._points])
        self._program()

    def _start(self, corners):
        """Begin in the middle of the longest side, or at a corner if edges are to lead beyond the part."""
        longest = max(range(len(corners)), key=lambda at: abs(corners[at] - corners[at - 1]))
        corners = corners[longest:] + corners[:longest]
        self.at_corner = self.kind == "edge" and not self.inside
        self._corners = corners if self.at_corner else [(corners[0] + corners[-1]) / 2, *corners]

    def _pieces(self):
        """[("line", end) or ("arc", end, centre, clockwise)] from the first corner around to it; some corners are rounded."""
        corners = [*self._corners, self._corners[0]]
        self._points, self.pieces = [corners[0]], []
        here = corners[0]
        for before, corner, after in zip(corners, corners[1:], corners[2:]):
            into, out = _unit(corner - before), _unit(after - corner)
            turn = math.atan2((into.conjugate() * out).imag, (into.conjugate() * out).real)
            room = min(abs(corner - here), abs(after - corner) / 2)
            round_ = self._draw.uniform(0.5, 6.0)
            cut = round_ * abs(math.tan(turn / 2))
            if self._draw.random() < 0.5 and 0.1 < cut < 0.9 * room:
                begin, end = corner - into * cut, corner + out * cut
                centre = begin + into * 1j * math.copysign(round_, turn)
                self.pieces += [("line", begin), ("arc", end, centre, turn < 0)]
                for share in np.linspace(0, 1, 200):
                    self._points.append(centre + (begin - centre) * complex(math.cos(turn * share), math.sin(turn * share)))
                here = end
            else:
                self.pieces.append(("line", corner))
                self._points.append(corner)
                here = corner
        self.pieces.append(("line", corners[-1]))

    # --- the program

    def _line(self, place, before=""):
        self._rows.append(f"{before}g1 x{place.real:.5f} y{place.imag:.5f}")
        self._num.append(self._rows[-1])
        self._here = place

    def _arc(self, place, centre, clockwise, before=""):
        words = f"{before}g{2 if clockwise else 3} x{place.real:.5f} y{place.imag:.5f}"
        way = centre - self._here
        self._rows.append(f"{words} i{way.real:.5f} j{way.imag:.5f}")
        self._num.append(f"{words} i{centre.real:.5f} j{centre.imag:.5f}")
        self._here = place

    def _program(self):
        start, first, last = self._corners[0], self._corners[1], self._corners[-1]
        into, out = _unit(first - start), _unit(start - last)  # along the contour at its start and its end
        away = 1j * self.side * into
        lead, round_ = self._draw.uniform(1.0, 6.0), self.radius + self._draw.uniform(0.5, 4.0)
        word = f"g4{1 if self.side == LEFT else 2} d1 "
        far = self.radius + self._draw.uniform(0.5, 3.0)
        if self.kind == "arc":
            begin, end = start + (away - into) * round_, start + (away + into) * round_
            self._from(begin + away * far)
            self._line(begin, word)
            self._arc(start, start + away * round_, self.side != LEFT)
            self._around()
            self._arc(end, start + away * round_, self.side != LEFT)
            self._line(end + away * far, "g40 ")
        elif self.kind == "edge":
            begin, end = start - into * lead, start + out * lead
            self._from(begin + 1j * self.side * into * (self.radius + far))
            self._line(begin, word)
            self._line(start)
            self._around()
            self._line(end)
            self._line(end + 1j * self.side * out * (self.radius + far), "g40 ")
        elif self.kind == "first arc":
            begin, end = start + (away - into) * round_, start + (away + into) * round_
            self._from(begin)
            self._arc(start, start + away * round_, self.side != LEFT, word)
            self._around()
            self._arc(end, start + away * round_, self.side != LEFT)
            self._line(end + away * far, "g40 ")
        else:
            begin = start + away * (self.radius + lead)
            self._from(begin + away * far)
            self._line(begin, word)
            self._line(start)
            self._around()
            self._line(begin)
            self._line(begin + away * far, "g40 ")
        self.text = "\n".join([*self._rows, "m2", ""])
        self.num = "\n".join(["%1", "g71 g17 g90", *self._num, "m02", ""]).upper()

    def _from(self, place):
        self._num = [f"g0 x{place.real:.5f} y{place.imag:.5f}", "f600"]
        self._rows += ["g21 g17 g90", *self._num]
        self._here = self._first = place

    def _around(self):
        for piece in self.pieces:
            if piece[0] == "line":
                self._line(piece[1])
            else:
                self._arc(*piece[1:])

    # --- what a path does to the part

    def crowded(self):
        """True if there is little room for the lead-in or lead-out itself."""
        kept = self.part if not self.inside else self.part.envelope.buffer(100).difference(self.part)
        ends = (self._first, self._here)
        return min(Point(each.real, each.imag).distance(kept) for each in ends) < 2 * self.radius

    def gouge(self, points):
        """How deep, in mm, a tool whose centre goes along these points cuts into what should be left."""
        way = LineString(points)
        kept = self.part if not self.inside else self.part.envelope.buffer(100).difference(self.part)
        return self.radius - way.distance(kept)

    def missed(self, points):
        """How many mm of its way around the contour the path leaves out; at the place where it is entered it may."""
        wanted = self.part.buffer(-self.radius if self.inside else self.radius, quad_segs=200).boundary
        free = {"arc": 0.0, "first arc": 0.0, "edge": 0.0 if self.inside else 1.02, "square": 1.5}[self.kind] * self.radius
        start = Point(self._corners[0].real, self._corners[0].imag)
        return wanted.difference(LineString(points).buffer(0.01)).difference(start.buffer(free, quad_segs=100)).length
