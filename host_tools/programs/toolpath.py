"""Motions of a program, in mm, to lines of plain G-code; radius compensation between the two.

    path = Toolpath(listing)
    path.source = Source("part.ngc", 3)
    path.move_to([1.0, 2.0, None], True)               # a rapid; None: the axis stays
    path.move_to([5.0, None, None], False, 600.0)
    path.arc_to(17, True, [5.0, 4.0, None], (0.0, 2.0), 600.0)
    path.put_word("M8")

An axis is not known (None) until a program moves it in its own coordinates: a program is written without knowing where the
machine stands. The listing says each axis that changes, absolute, in mm to five decimals; A, the fourth, in degrees, or in mm if it is linear.
"""

import cmath
import math

from host_tools.programs.contour import Contour
from host_tools.programs.listing import Stroke
from host_tools.programs.program_errors import ARC, COMPENSATED, NO_FEED, PLANE, RANGE, UNKNOWN_PLACE, ProgramError
from passo.control.arcs import over_half

PLANES = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0)}
AXES = "XYZA"
_CENTRES = "IJK"
_FARTHEST_MM = 1_000_000
_SHORTEST_ARC_MM = 0.005
_FASTEST = 1_000_000  # mm/min
_HALF_TURN = 18_000_000  # of A, in units of the listing
_RADIUS_MM = 0.005  # an arc's two radii may differ by this, or by a thousandth of the radius
_MOST_RADIUS_MM = 0.5  # but never by more than this


class Toolpath:
    def __init__(self, listing, start=()):
        """`start`: where the axes stand, of the program; those that it leaves out, or are None, are not known."""
        start = _all_axes(start)
        self.listing = listing
        self.source = None  # the program's line under way
        self.place = start  # of the program
        self.contour = None  # while the radius is compensated
        self._there = [_to_units(value) for value in start]  # of the machine, as the listing has it
        self._feed = None
        self._inverse = False  # the listing is in G93
        self._turned = None  # of the work coordinates in XY, as a unit vector; None: they are not
        self._beside = None  # behind G40: the contour that the tool is still beside

    # --- what programs ask for

    def position(self, axis):
        """Return the position of an axis, in mm, A in degrees. Raises ProgramError if it is not known."""
        if self.place[axis] is None:
            raise ProgramError(UNKNOWN_PLACE, "{}", AXES[axis])
        return self.place[axis]

    def forget_axes(self, axes=(0, 1, 2, 3)):
        """Note that the machine has moved these axes to a position which the program cannot know."""
        for axis in axes:
            self.place[axis] = self._there[axis] = None
        if self._beside and None in [self._there[axis] for axis in self._beside.axes[:2]]:  # how it gets away from the contour is not known either
            self._beside = None

    def now_at(self, axis, value):
        """Note that the coordinate of an axis, which has not moved, is `value` from now on: an offset changed."""
        self.place[axis] = value
        self._there[axis] = _to_units(value)

    def turn_place(self):
        """Turn a place that now_at() took in the board's coordinates into the program's."""
        self.place = self._to_program(self.place)

    def turn_coordinates(self, degrees):
        """Turn the program's coordinates in XY around the board's zero, by `degrees` from the X axis."""
        here = self._to_board(self.place)
        self._turned = cmath.rect(1.0, math.radians(degrees)) if degrees % 360 else None
        self.place = here if self._turned is None else self._to_program(here)

    def _to_board(self, place):
        """Return a position of the program in the board's coordinates, which are not turned; unknown if one of X and Y is."""
        if self._turned is None:
            return place[:]
        if None in place[:2]:
            return [None, None, *place[2:]]
        moved = complex(*place[:2]) * self._turned
        return [moved.real, moved.imag, *place[2:]]

    def _to_program(self, place):
        """Return a position of the board in the program's coordinates, which may be turned; unknown if one of X and Y is."""
        if self._turned is None or None in place[:2]:
            return place[:] if self._turned is None else [None, None, *place[2:]]
        moved = complex(*place[:2]) / self._turned
        return [moved.real, moved.imag, *place[2:]]

    def put_word(self, code):
        """Append a line that moves nothing."""
        if self.contour:
            self.contour.add_word(code, self.source)
            return
        if not code.startswith(("S", "G4 ")):
            self.end_inverse()
        if " F" in code:  # of G53 and G38: it holds on the board
            self._feed = None
        self.listing.add_line(code, self.source)

    def end_inverse(self):
        """Return the listing to G94, if it is in G93."""
        if self._inverse:
            self._inverse, self._feed = False, None
            self.listing.add_line("G94", self.source)

    def axes_to_move(self, target):
        """Return the axes that a straight line to `target` moves, as far as the listing tells positions apart."""
        return [axis for axis, value in enumerate(target) if value is not None and (self.place[axis] is None or _to_units(value) != _to_units(self.place[axis]))]

    def move_to(self, target, rapid, feed=0.0, inverse=False, relative=False):
        """Append a straight line to `target`, mm; axes that are None or left out stay. `feed`: mm/min; `inverse`: the feed is that of G93, 1/min;
        `relative`: the program has G91, in which A turns by more than half a turn on every board. Raises ProgramError."""
        target = _all_axes(target)
        if target[3] is not None and self.contour and 3 in self.axes_to_move(target):
            raise ProgramError(COMPENSATED, "A")
        before = self.place[:]
        self.place = [old if new is None else new for old, new in zip(self.place, target)]
        if self._turned is not None and (target[0] is not None or target[1] is not None):
            self.position(0), self.position(1)
            target = [*self._to_board(self.place)[:2], *target[2:]]
        if self.contour:
            self.contour.add_line(self._to_board(before), self._to_board(self.place), target, rapid, feed, self.source)
            return
        if self._beside and self._beside.moves_in_plane(target):
            if inverse:
                raise ProgramError(NO_FEED, "G93 and A in the first motion behind G40")
            self._leave_contour(rapid, feed)
        self.put_line(target, rapid, feed, None, inverse, relative)

    def arc_to(self, plane, clockwise, target, centre, feed, turns=1, sweep=None, slack=0.0):
        """Append an arc to `target` around `centre`, (first, second axis of the plane) in mm from its start; a helix if the third axis changes.
        `sweep`: by default sweep_of(); `slack`: of circle_through(). Raises ProgramError if the ends do not lie on one circle."""
        first, second, _ = PLANES[plane]
        target = _all_axes(target)
        begin = [self.position(first), self.position(second)]
        end = [old if new is None else new for old, new in zip(self.place, target)]
        centre = circle_through(begin, (end[first], end[second]), centre, slack)
        if sweep is None:
            sweep = sweep_of(begin, (end[first], end[second]), centre, clockwise)
        before, self.place = self.place, end
        if self._turned is not None:
            if plane != 17:
                raise ProgramError(PLANE, "arcs in turned coordinates")
            turned = complex(*centre) * self._turned
            before, end, centre = self._to_board(before), self._to_board(end), (turned.real, turned.imag)
        if self.contour:
            self.contour.add_arc(before, end, plane, clockwise, centre, feed, sweep, turns, self.source)
            return
        if self._beside:
            raise ProgramError(ARC, "the first motion behind G40 is straight")
        self.put_arc(plane, clockwise, end, centre, feed, sweep, turns)

    def compensate(self, side, radius, plane=17):
        """Go beside the contour from the next motion on. `side`: compensation.LEFT or RIGHT."""
        if plane != 17 and self._turned is not None:
            raise ProgramError(PLANE, "radius compensation in turned coordinates")
        if self.contour and (self.contour.side, self.contour.radius, self.contour.plane) == (side, radius, plane):
            return
        self.uncompensate()
        if radius:
            self.contour = Contour(self, side, radius, self.source, plane, PLANES[plane])

    def uncompensate(self):
        """End the contour. The tool stays beside it until the next motion in X or Y."""
        contour, self.contour = self.contour, None
        if contour and contour.flush():
            self._beside = contour
            # G91 counts on from where the tool is, and a motion of Z alone leaves it there.
            here = [None if each is None else each / 1e5 for each in self._there]
            for axis in contour.axes[:2]:
                self.place[axis] = here[axis]
            if self._turned is not None:
                self.place[:2] = self._to_program(here)[:2]

    def _leave_contour(self, rapid, feed):
        contour, self._beside = self._beside, None
        here = [None if each is None else each / 1e5 for each in self._there]
        contour.put_way_out(here, self._to_board(self.place), rapid, feed, self.source)

    # --- to the listing

    def put_line(self, target, rapid, feed, source=None, inverse=False, relative=False):
        """Append a line to `target`, mm; axes that are None stay. `feed`: mm/min; `inverse`, `relative`: of move_to()."""
        begin = self._there[:]
        words = []
        if relative and target[3] is not None and abs(_to_units(target[3]) - begin[3]) > _HALF_TURN:
            self._put_relative(target, rapid, feed, source, inverse)
            return
        for axis, value in enumerate(target):
            if value is not None and _to_units(value) != self._there[axis]:
                self._there[axis] = _to_units(value)
                words.append(AXES[axis] + number_text(self._there[axis] / 1e5))
        if words:
            self._put_words(words, begin, rapid, feed, source, inverse)

    def _put_relative(self, target, rapid, feed, source, inverse):
        """Append a line in G91, for A by more than half a turn, and G90 behind it."""
        begin = self._there[:]
        words = ["G91"]
        for axis, value in enumerate(target):
            if value is not None and _to_units(value) != begin[axis]:
                self._there[axis] = _to_units(value)
                words.append(AXES[axis] + number_text((self._there[axis] - begin[axis]) / 1e5))
        self._put_words(words, begin, rapid, feed, source, inverse)
        self.listing.add_line("G90", source or self.source)

    def _put_words(self, words, begin, rapid, feed, source, inverse):
        """Append a line of these words; it has no stroke if A alone moves."""
        if not rapid and inverse != self._inverse:
            words.insert(0, "G93" if inverse else "G94")
            self._inverse, self._feed = inverse, None
        code = f"G{0 if rapid else 1} {' '.join(words)}"
        if not rapid:
            code += f" F{number_text(min(feed, _FASTEST), 3)}" if inverse else self._feed_word(feed)
        if begin[:3] == self._there[:3]:
            self.listing.add_line(code, source or self.source)
        else:
            self._add_stroke(code, source, rapid, [_picture_point(begin, self._there), _picture_point(self._there, self._there)])

    def put_arc(self, plane, clockwise, end, centre, feed, sweep, turns=1, source=None):
        """Append an arc of `sweep` radians, and `turns` - 1 whole ones; a line in place of one that is so short that its rounded ends
        would make a whole turn of it."""
        first, second, third = PLANES[plane]
        begin = self._there[:]
        ends = [_to_units(each) for each in end]
        around = _to_units(centre[0]), _to_units(centre[1])
        chord = math.hypot(end[first] - begin[first] / 1e5, end[second] - begin[second] / 1e5)
        last = round_end((begin[first], begin[second]), (ends[first], ends[second]), around, clockwise, sweep)
        if last is None and turns > 1:
            sweep, turns = math.tau, turns - 1
            last = begin[first], begin[second]
        if last is None or chord < _SHORTEST_ARC_MM and turns == 1 and sweep < math.pi:
            self.put_line(end, False, feed, source)
            return
        ends[first], ends[second] = last
        middle = [begin[first] + around[0], begin[second] + around[1]]
        words = []
        for axis in range(3):
            if axis in (first, second) or ends[axis] is not None and ends[axis] != self._there[axis]:
                self._there[axis] = ends[axis]
                words.append(AXES[axis] + number_text(ends[axis] / 1e5))
        words += [_CENTRES[first] + number_text(around[0] / 1e5), _CENTRES[second] + number_text(around[1] / 1e5)]
        if turns > 1:
            words.append(f"P{turns}")
        if plane != self.listing.plane:
            self.listing.plane = plane
            words.insert(0, f"G{plane}")
        if self._inverse:
            self._inverse, self._feed = False, None
            words.insert(0, "G94")
        code = f"G{2 if clockwise else 3} {' '.join(words)}" + self._feed_word(feed)
        points = arc_points(_picture_point(begin, self._there), _picture_point(self._there, self._there), plane, clockwise,
                            [each / 1e5 for each in middle], sweep + math.tau * (turns - 1))  # fmt: skip
        self._add_stroke(code, source, False, points)

    def _feed_word(self, feed):
        """Return the F word of a feed in mm/min, at most _FASTEST; "" if it is in force already."""
        feed = min(feed, _FASTEST)  # the machine goes as fast as it can, as with plain G-code
        if feed == self._feed:
            return ""
        self._feed = feed
        return f" F{number_text(feed, 3)}"

    def _add_stroke(self, code, source, rapid, points):
        source = source or self.source
        self.listing.add_line(code, source, Stroke(source, rapid, points))


def sweep_of(begin, end, centre, clockwise, long=None):
    """Return the radians of the arc around `centre` (from `begin`), a whole turn at most, by the words of the program before any rounding. The
    firmware's rule: an end that is less than 5·10⁻⁷ rad ahead of the start closes the circle. `long`: whether the arc is over half a turn, if the
    program says that by the sign of R."""
    x, y = end[0] - begin[0], end[1] - begin[1]
    before, after = (-centre[0], -centre[1]), (x - centre[0], y - centre[1])
    cross, dot = before[0] * after[1] - before[1] * after[0], before[0] * after[0] + before[1] * after[1]
    turn = math.atan2(-cross if clockwise else cross, dot)
    if dot <= 0:
        return turn % math.tau
    if over_half(x, y, *centre, clockwise) if long is None else long:
        return math.tau + min(turn, 0.0)
    return max(turn, 0.0)


def round_end(begin, end, centre, clockwise, sweep):
    """The end of an arc of `sweep` radians, in units of the listing: `end`, or up to three units before it, if rounding has brought the
    end of a nearly whole turn ahead of its start. None: a short arc that would become a whole turn."""
    if sweep == math.tau and math.dist(begin, end) < 1.5:
        return begin
    spoke = -centre[0], -centre[1]
    back = (1 if clockwise else -1) / math.hypot(*spoke)
    for by in range(4):
        moved = end[0] - round(spoke[1] * back * by), end[1] + round(spoke[0] * back * by)
        if abs(sweep_of(begin, moved, centre, clockwise) - sweep) < math.pi:
            return moved
        if sweep < math.pi:
            return None
    return begin


def circle_through(begin, end, centre, slack=0.0):
    """The centre, from the start, of an arc whose ends need not be equally far from it, by grbl's rule. With `slack` (mm) LinuxCNC's counts as
    well: up to `slack`, or a thousandth of the radius, but not 100 times `slack`; an arc that only LinuxCNC takes gets the nearest centre
    that is equally far from both. Raises ProgramError."""
    radius = math.hypot(*centre)
    other = math.hypot(end[0] - begin[0] - centre[0], end[1] - begin[1] - centre[1])
    wrong = abs(other - radius)
    if radius < 1e-5 or wrong > _MOST_RADIUS_MM or wrong > _RADIUS_MM and wrong > radius / 1000:
        across, along = end[0] - begin[0], end[1] - begin[1]
        off = (centre[0] * across + centre[1] * along) / (across * across + along * along or 1.0) - 0.5  # of the chord, from its middle
        moved = abs(off) * math.hypot(across, along)
        if moved > wrong or wrong > 100 * slack or wrong > slack and wrong > max(radius, other) / 1000:
            raise ProgramError(ARC, "radius {:.4f} at its start, {:.4f} at its end", radius, other)
        return centre[0] - across * off, centre[1] - along * off
    return centre


def centre_of(begin, end, radius, clockwise):
    """Return the centre, from the start, of an arc of this radius; a negative one means the longer way. Raises ProgramError."""
    across, along = end[0] - begin[0], end[1] - begin[1]
    chord = math.hypot(across, along)
    if chord < 1e-9 or chord / 2 > abs(radius) + _RADIUS_MM:
        raise ProgramError(ARC, "radius {:g} between places {:.4f} mm apart", abs(radius), chord)
    height = math.sqrt(max(0.0, radius * radius - chord * chord / 4)) / chord
    if clockwise != (radius < 0):
        height = -height
    return across / 2 - along * height, along / 2 + across * height


def arc_points(begin, end, plane, clockwise, middle, sweep, sag=0.01):
    """Return points on an arc or helix of `sweep` radians, for a picture or a check; chords are at most `sag` mm from it."""
    first, second, third = PLANES[plane]
    spoke = begin[first] - middle[0], begin[second] - middle[1]
    radius = math.hypot(*spoke)
    start = math.atan2(spoke[1], spoke[0])
    count = max(2, math.ceil(sweep / max(0.02, 2 * math.acos(max(-1.0, 1 - sag / max(radius, sag))))))
    points = []
    for each in range(count + 1):
        angle = start + (-1 if clockwise else 1) * sweep * each / count
        point = list(begin)
        point[first], point[second] = middle[0] + radius * math.cos(angle), middle[1] + radius * math.sin(angle)
        point[third] = begin[third] + (end[third] - begin[third]) * each / count
        points.append(tuple(point))
    points[-1] = tuple(end)
    return points


def number_text(value, decimals=5):
    """Return a value as G-code has it, without zeros at the end."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def _to_units(value):
    """Return a position in units of the listing, 10 nm. Raises ProgramError if no machine reaches it."""
    if value is None:
        return None
    if not -_FARTHEST_MM <= value <= _FARTHEST_MM:
        raise ProgramError(RANGE, "a place {:g} mm from zero", value)
    return round(value * 1e5)


def _all_axes(target):
    """Return a position of all four axes; the axes left out are None."""
    return [*target, None, None, None, None][:4]


def _picture_point(place, otherwise):
    """Return X, Y and Z in mm; axes that are not known do not change in a picture."""
    return tuple((next_ if here is None else here) / 1e5 if (here, next_) != (None, None) else 0.0
                 for here, next_ in zip(place[:3], otherwise))  # fmt: skip
