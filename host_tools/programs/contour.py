"""The motions between G41 or G42 and G40: collected, moved aside as a whole, then handed to the Toolpath.

The contour is the way of the tool's edge, from the end of the first motion to the last one before G40. The way in is the first motion.
A straight one ends square to the contour's start, a radius away: straight, or if that would cut into the contour, around its start. An
arc ends beside its own end, along it; so does a straight one if neither is free. The way out is the first motion in X or Y behind G40, straight, as the way in.

A path that cuts into an area that the contour leaves (uncut_areas.py) is refused; lead-ins, lead-outs and edges that lead beyond the part lie in
the air. A contour that encloses nothing has material behind each of its pieces. Its path is checked against the ten pieces before and
behind, as controllers look ahead; a piece too near beyond these is a warning, because several passes of a pocket may overlap.
"""

import math

from host_tools.language import _
from host_tools.programs.compensation import SMALL, TOUCH, Piece, lead_alongside, gouges, lead_around, offset_contour
from host_tools.programs.program_errors import (
    ARC, COMPENSATED, DOES_NOT_FIT, ENTRY, ENTRY_GOUGES, EXIT_GOUGES, GOUGES, ProgramError,
)  # fmt: skip

LOOK_AHEAD = 10
_RAPID_SAG = 0.001  # mm: arcs of a rapid are lines
_SHORTEST = 1e-4  # mm: less is a corner that the next piece takes along


class _Motion:
    """A piece of the contour, or a motion of Z alone, or a word: `piece` is None then."""

    def __init__(self, source, piece=None, heights=(None, None), rapid=False, feed=0.0, code=None):
        self.source, self.piece, self.heights = source, piece, heights
        self.rapid, self.feed, self.code = rapid, feed, code


class Contour:
    def __init__(self, path, side, radius, source, plane, axes):
        """`axes`: first and second of the plane, and the third."""
        self.side, self.radius = side, radius
        self.plane, self.axes = plane, axes
        self._path = path
        self._source = source
        self._motions = []
        self._told = []  # of them, the pieces of the contour itself
        self._end = None  # of the contour
        self._kept = {}  # by height: the areas that the contour leaves

    def add_word(self, code, source):
        self._motions.append(_Motion(source, code=code))

    def moves_in_plane(self, target):
        """True if a target is one in the contour's plane."""
        return target[self.axes[0]] is not None or target[self.axes[1]] is not None

    def _in_plane(self, place):
        return complex(place[self.axes[0]], place[self.axes[1]])

    def _target_of(self, first, second, height):
        """Return [X, Y, Z] of two coordinates in the plane and a height, mm; None: the axis stays."""
        target = [None] * 3
        for axis, value in zip(self.axes, (first, second, height)):
            target[axis] = value
        return target

    def add_line(self, begin, end, target, rapid, feed, source):
        """Add a straight motion of the program, from `begin` to `end`, in mm."""
        first, second, third = self.axes
        heights = begin[third], end[third]
        ends = begin[first], begin[second], end[first], end[second]
        if not self.moves_in_plane(target) or ends[:2] == ends[2:]:
            if target[third] is not None:
                self._motions.append(_Motion(source, None, heights, rapid, feed))
            return
        if None in ends:
            self._path.place = begin
            self._path.position(first), self._path.position(second)
        piece = Piece(self._in_plane(begin), self._in_plane(end))
        if piece.length > SMALL:
            self._motions.append(_Motion(source, piece, heights, rapid, feed))

    def add_arc(self, begin, end, plane, clockwise, centre, feed, sweep, turns, source):
        """Add an arc of the program, lengths in mm, `centre` from its start, `feed` in mm/min, `sweep` in radians. Raises ProgramError if it lies in
        another plane, has several turns, is a whole circle as the way in, or has no centre equally far from its ends."""
        if plane != self.plane:
            raise ProgramError(COMPENSATED, "another plane")
        if turns > 1:
            raise ProgramError(COMPENSATED, "arcs of several turns")
        start, last = self._in_plane(begin), self._in_plane(end)
        if sweep > math.pi and abs(last - start) < _SHORTEST:
            piece = Piece(start, start, start + complex(*centre), clockwise, True)
            if not any(motion.piece for motion in self._motions):
                raise ProgramError(ENTRY, "a whole circle")
        else:
            piece = Piece(start, last, start + complex(*centre), clockwise)
            if abs(last - start) < SMALL:
                piece = None
            elif sweep > math.pi and abs(piece.centre - start - complex(*centre)) > 2 * TOUCH:
                raise ProgramError(ARC, "its ends are not equally far from its centre, with radius compensation")
        self._motions.append(_Motion(source, piece, (begin[self.axes[2]], end[self.axes[2]]), False, feed))

    # --- the end

    def flush(self):
        """Append all motions to the listing. Returns False if nothing was moved in X or Y. Raises ProgramError."""
        pieces = [motion for motion in self._motions if motion.piece]
        if not pieces:
            for motion in self._motions:
                self._put_still(motion)
            return False
        entry, told = pieces[0], pieces[1:]
        self._told = told
        contour = [motion.piece for motion in told]
        path = []
        try:
            path = offset_contour(contour, self.side, self.radius)
        except ProgramError as error:
            first, second = (told[number].source for number in error.pieces)
            if error.args[0]:
                raise error.name_place(second) from None
            lines = first.line, second.line
            raise ProgramError(DOES_NOT_FIT, "a tool of radius {:g} between lines {} and {}", self.radius, *lines, place=second) from None
        if contour and not path:
            raise ProgramError(DOES_NOT_FIT, "a hole of the tool's own radius", place=told[0].source)
        self._end = contour[-1].end if contour else entry.piece.end
        way_in = self._way_in(entry, path)
        self._check_gouges(path, None, GOUGES)
        self._put_contour(entry, way_in, path)
        return True

    def _way_in(self, entry, path):
        """Return the pieces of the way in; shortens the beginning of `path` if that needs it. Raises ProgramError."""
        first = self._told[0].piece if path else None
        refused = None
        if entry.piece.centre is None and path:
            try:
                return self._lead_pieces(entry.piece.start, first.start, path[0][0].start, self.side, entry, ENTRY_GOUGES)
            except ProgramError as error:
                refused = error
        try:
            pieces = lead_alongside(entry.piece, first, path, self.side, self.radius)
            self._check_gouges([(piece, None) for piece in pieces], entry, ENTRY_GOUGES)
        except ProgramError as error:
            raise refused or error.name_place(entry.source) from None
        return pieces

    def _lead_pieces(self, place, corner, start, side, motion, error):
        """Return the pieces from `place` to `start`: a straight line if that cuts nothing, else around the contour's end. Raises ProgramError with
        the number `error`."""
        straight = [Piece(place, start)]
        around = lead_around(place, corner, start, side, self.radius)
        try:
            self._check_gouges([(straight[0], None)], motion, error)
            return straight
        except ProgramError:
            if around is None or len(around) == 1:
                raise
        self._check_gouges([(piece, None) for piece in around], motion, error)
        return around

    def _check_gouges(self, path, entry, error):
        """Raise ProgramError if the tool cuts into the contour, unless the cut area is wanted gone."""
        contour = [motion.piece for motion in self._told]
        warned = set()
        for at, against, far in gouges([piece for piece, _ in path], contour, self.radius):
            number = path[at][1]
            motion = entry or self._told[number]
            if _is_above(motion, self._told[against]) or entry and _leads_down(motion, self._told[against]):
                continue
            kept = self._remainder_under(motion)
            disputed = motion in (self._told[0], self._told[-1]) and kept.reaches_disputed(path[at][0], self.radius)
            if kept.known and not kept.reaches_area(path[at][0], self.radius) and not kept.doubtful and not disputed:
                continue
            line = self._told[against].source.line
            if kept.reaches_area(path[at][0], self.radius) if kept.known else entry or abs(number - against) <= LOOK_AHEAD:
                raise ProgramError(error, "{:.3f} mm from line {}, with a tool of radius {:g}", far, line, self.radius, place=motion.source)
            if (motion.source, self._told[against].source) not in warned:
                warned.add((motion.source, self._told[against].source))
                warning = _("{}: the tool comes to {:.3f} mm from line {}, with a tool of radius {:g}", motion.source, far, line, self.radius)
                self._path.listing.warnings.append(warning)

    def _remainder_under(self, motion):
        """Return the UncutAreas of those pieces that the motion is not above, computed once for each height."""
        from host_tools.programs.uncut_areas import UncutAreas  # which needs shapely

        heights = [height for height in motion.heights if height is not None]
        level = min(heights) if len(heights) == 2 else None
        if level not in self._kept:
            self._kept[level] = UncutAreas([told.piece for told in self._told if not _is_above(motion, told)], self.side)
        return self._kept[level]

    def put_way_out(self, begin, place, rapid, feed, source):
        """Append the motions before the straight way out from `begin` to `place`. Raises ProgramError if the way cuts into the contour."""
        here, there, third = self._in_plane(begin), self._in_plane(place), self.axes[2]
        if abs(here - there) < SMALL:
            return
        motion = _Motion(source, None, (begin[third], place[third]), rapid, feed)
        pieces = self._lead_pieces(there, self._end, here, -self.side, motion, EXIT_GOUGES)
        if len(pieces) == 2:
            arc = pieces[1]
            self._put_piece(Piece(arc.end, arc.start, arc.centre, not arc.clockwise), motion, begin[third])

    def _put_contour(self, entry, way_in, path):
        """Append the contour's motions in the program's order: `way_in` for the motion `entry`, for others the pieces of `path`, [(piece, number)]. A
        motion's Z changes along its last piece."""
        at = 0
        number = -1  # of the contour's piece under way
        for motion in self._motions:
            if not motion.piece:
                self._put_still(motion)
                continue
            if motion is entry:
                for piece in way_in:
                    self._put_piece(piece, motion, motion.heights[1])
                continue
            number += 1
            while at < len(path) and path[at][1] == number:
                piece, _ = path[at]
                last = at + 1 == len(path) or path[at + 1][1] != number
                self._put_piece(piece, motion, motion.heights[1] if last else motion.heights[0])
                at += 1
            self._path.put_line(self._target_of(None, None, motion.heights[1]), motion.rapid, motion.feed, motion.source)

    def _put_piece(self, piece, motion, height):
        """Append one piece of the path, which ends at `height` mm."""
        end = self._target_of(piece.end.real, piece.end.imag, height)
        if piece.centre is None:
            self._path.put_line(end, motion.rapid, motion.feed, motion.source)
        elif motion.rapid:
            for point in piece.chord_points(_RAPID_SAG)[1:]:
                self._path.put_line(self._target_of(point.real, point.imag, height), True, 0.0, motion.source)
        elif piece.length > _SHORTEST:
            centre = piece.centre - piece.start
            self._path.put_arc(self.plane, piece.clockwise, end, (centre.real, centre.imag), motion.feed, piece.sweep, 1, motion.source)

    def _put_still(self, motion):
        """Append a motion of Z alone, or a word."""
        if motion.code:
            self._path.listing.add_line(motion.code, motion.source)
        else:
            self._path.put_line(self._target_of(None, None, motion.heights[1]), motion.rapid, motion.feed, motion.source)


def _is_above(motion, told):
    """True if the whole motion is above the contour's piece."""
    heights = [height for height in motion.heights if height is not None]
    below = [height for height in told.heights if height is not None]
    return len(heights) == len(below) == 2 and min(heights) > max(below) + SMALL


def _leads_down(motion, told):
    """True if the contour's piece leads down from the height of the motion or from below it."""
    heights = [height for height in (*motion.heights, *told.heights) if height is not None]
    return len(heights) == 4 and min(motion.heights) > max(told.heights) - SMALL and min(motion.heights) > min(told.heights) + SMALL
