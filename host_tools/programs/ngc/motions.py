"""The motions of an NGC line: lines, arcs, probing, canned cycles."""

import math

from host_tools.programs.drilling import Cycle
from host_tools.programs.ngc.codes import CYCLES, PROBES, SPLINES
from host_tools.programs.ngc.modes import Modes
from host_tools.programs.ngc.splines import bezier, flatten_curve, nurbs
from host_tools.programs.program_errors import (
    ARC, MISSING, NO_FEED, NO_SPINDLE, NOT_ON_BOARD, PLANE, RANGE, ProgramError,
)  # fmt: skip
from host_tools.programs.toolpath import AXES, PLANES, centre_of, number_text, sweep_of


_SPLINE_SAG_MM = 0.002
_SLACK = 0.02 * math.sqrt(2)  # mm: tolerance of LinuxCNC's arcs; in inches a tenth of the number


class Motions(Modes):
    """The part of Interpreter that moves."""

    def take_target(self):
        """Take the axis words; return the position that they name: mm of X, Y, Z, degrees of A; None where there is no word."""
        position = []
        for axis, name in enumerate("xyza"):
            value = self.words.pop(name, None)
            if value is not None:
                value *= self.unit_mm(axis)
                if not self.absolute:
                    value += self.path.position(axis)
            position.append(value)
        if "@" in self.words or "^" in self.words:
            self._apply_polar(position)
        return position

    def _apply_polar(self, position):
        """@ and ^: change `position` to this distance and angle from the program's zero, or with G91 relative to the tool's."""
        if position[0] is not None or position[1] is not None:
            raise ProgramError(RANGE, "@ and ^ in place of X and Y")
        distance, angle = (self.words.pop(letter, None) for letter in "@^")
        x, y = self.path.position(0) if None in (distance, angle) or not self.absolute else 0.0, 0.0
        if None in (distance, angle) or not self.absolute:
            y = self.path.position(1)
        before = math.hypot(x, y), math.degrees(math.atan2(y, x))
        if self.absolute:
            radius = before[0] if distance is None else distance * self.scale
            turned = before[1] if angle is None else angle
        else:
            radius = before[0] + (distance or 0.0) * self.scale
            turned = before[1] + (angle or 0.0)
        position[0], position[1] = radius * math.cos(math.radians(turned)), radius * math.sin(math.radians(turned))

    def put_motion(self, motion, of_machine):
        """Append one line's motion; `of_machine`: G53. Raises ProgramError."""
        if self.nurbs and motion not in (52, 53):
            raise ProgramError(MISSING, "G5.3")
        if "a" in self.words and motion not in (0, 10, *PROBES):
            raise ProgramError(NOT_ON_BOARD, "A with G{}: lines alone move it", number_text(motion / 10, 1))
        leaving, self.leaving = self.leaving, None
        if of_machine:
            self._move_machine(motion)
        elif motion in (*SPLINES, 53):
            self._put_spline(motion, leaving)
        elif motion in CYCLES:
            self._put_cycle(motion)
        elif motion in (20, 30):
            self._put_arc(motion == 20)
        elif motion in PROBES:
            self._put_probe(motion)
        else:
            self._put_line(self.take_target(), motion == 0)

    def _put_line(self, target, rapid):
        """Append a straight line to `target`, mm of X, Y, Z, degrees of A; nothing if it has no axis. With G93 the feed stays inverse time if A moves
        along with others. Raises ProgramError if there is no feed."""
        if target == [None] * 4:
            return
        if rapid:
            self.path.move_to(target, True, relative=not self.absolute)
            return
        moved = self.path.axes_to_move(target)
        turns = self.moves_a_alone(moved)
        length = self._line_length(self.path.place, target, moved)
        # F counts otherwise where A turns and where it is linear, and a feed of next to nothing says badly how long A takes: G93 stays.
        inverse = self.feed_mode == 930 and 3 in moved and (length is None or not turns)
        self.path.move_to(target, False, self._feed_of(1.0 if inverse else length, turns), inverse, not self.absolute)

    @staticmethod
    def _line_length(before, target, moved):
        """Return the length of a straight line that moves these axes, in mm, of A alone in degrees; None if a start is not known."""
        return None if any(before[axis] is None for axis in moved) else math.hypot(*(target[axis] - before[axis] for axis in moved))

    def _feed_of(self, length, turns=False):
        """Return the feed of a motion of this length, in mm/min; if A alone `turns`, length and feed are degrees. Raises ProgramError."""
        feed = self.typed if turns else self.feed
        if self.feed_mode == 930:
            if length is None:
                raise ProgramError(NO_FEED, "G93, and where the line begins is not known")
            feed *= length
        elif self.feed_mode == 950:
            if not self.spindle or not self.rpm:
                raise ProgramError(NO_SPINDLE, "G95")
            feed *= self.rpm
        if not self.feed:
            raise ProgramError(NO_FEED)
        return max(feed, 0.001)

    def _move_machine(self, motion):
        """Carry out G53 with G0 or G1 (`motion` 0 or 10): the board gets the line, and the axes' positions are not known afterwards. Raises
        ProgramError with another motion, G91, G93 or compensation."""
        if motion not in (0, 10):
            raise ProgramError(NOT_ON_BOARD, "G53 goes with G0 and G1")
        self.not_compensated("G53")
        if not self.absolute:
            raise ProgramError(RANGE, "G53 with G91")
        positions = self._axis_values()
        if motion == 10 and self.feed_mode != 940:
            raise ProgramError(NO_FEED, "G53 G1 wants G94")
        feed = "" if motion == 0 else f" F{number_text(self._feed_of(None, self.moves_a_alone(positions)), 3)}"
        self.path.put_word(f"G53 G{motion // 10} {self._position_words(positions)}{feed}")
        self.path.forget_axes(positions)

    def _put_probe(self, code):
        """Carry out G38.2 to G38.5, `code` 382 to 385; the axes' positions are not known afterwards. Raises ProgramError if no axis is named, or amid
        compensation or turned coordinates."""
        self.not_compensated("G38")
        if self.turned.get(self.system):
            raise ProgramError(NOT_ON_BOARD, "G38 in turned coordinates")
        target = self.take_target()
        axes = [axis for axis, value in enumerate(target) if value is not None]
        if not axes:
            raise ProgramError(MISSING, "X, Y, Z or A")
        here = self.path.place
        relative = not self.absolute and target[3] is not None
        positions = " ".join(AXES[axis] + number_text(target[axis] - (here[axis] if relative else 0.0)) for axis in axes)
        feed = number_text(self._feed_of(None, self.moves_a_alone(self.path.axes_to_move(target))), 3)
        self.path.put_word(f"{'G91 ' * relative}G{code / 10:g} {positions} F{feed}")
        if relative:
            self.path.put_word("G90")
        self.path.forget_axes(axes)

    # --- splines

    def _put_spline(self, code, leaving):
        """Carry out G5, G5.1, G5.2 or G5.3 (`code` 50 to 53) as chords. `leaving`: the direction of the G5 before, mm, if I and J are missing. Raises
        ProgramError outside of XY."""
        if self.plane != 17:
            raise ProgramError(PLANE, "splines")
        here = complex(self.path.position(0), self.path.position(1))
        if code == 50:
            way = self._take_pair("i", "j", leaving)
            back = self._take_pair("p", "q")
            end = self._spline_end(here)
            self.leaving = -back
            self._follow_curve(bezier([here, here + way, end + back, end]), 1)
        elif code == 51:
            way = self._take_pair("i", "j")
            end = self._spline_end(here)
            self._follow_curve(bezier([here, here + way, end]), 1)
        elif code == 52:
            self._add_control(here)
        else:
            self._close_nurbs()

    def _take_pair(self, first, second, otherwise=None):
        """Take the values of two words, in mm; `otherwise` if there is neither. Raises ProgramError."""
        if otherwise is not None and first not in self.words and second not in self.words:
            return otherwise
        return complex(self.take_word(first), self.take_word(second)) * self.scale

    def _spline_end(self, here):
        """Take the axis words; return the end of a spline, x + y·j in mm. Raises ProgramError if it has Z, or neither X nor Y."""
        target = self.take_target()
        if target[2] is not None:
            raise ProgramError(RANGE, "splines lie in XY")
        if target[0] is None and target[1] is None:
            raise ProgramError(MISSING, "X or Y")
        return complex(*(old if new is None else new for old, new in zip((here.real, here.imag), target)))

    def _add_control(self, here):
        """Carry out G5.2: add a control point of the weight P; without axis words set the weight of the last one. The first line sets the order, L, 2
        to 10, by default 3. Raises ProgramError if a number is out of range."""
        weight = self.words.pop("p", 1.0)
        if weight <= 0:
            raise ProgramError(RANGE, "P{:g}", weight)
        if self.nurbs is None:
            self.order = self.take_whole("l", 2, 10) if "l" in self.words else 3
            self.nurbs = [(here, 1.0)]
        if any(letter in self.words for letter in "xyz@^"):
            self.nurbs.append((self._spline_end(self.nurbs[-1][0]), weight))
        else:
            self.nurbs[-1] = self.nurbs[-1][0], weight

    def _close_nurbs(self):
        """Carry out G5.3: append the chords of the NURBS. Raises ProgramError if it was not begun, or has fewer points than its order."""
        points, self.nurbs = self.nurbs, None
        self.motion = 800
        if not points:
            raise ProgramError(MISSING, "G5.2")
        if len(points) < self.order:
            raise ProgramError(RANGE, "{} control points, L{}", len(points), self.order)
        self._follow_curve(*nurbs([point for point, _ in points], [weight for _, weight in points], self.order))

    def _follow_curve(self, curve, end):
        """Append the chords of a function of 0 … `end`, at most _SPLINE_SAG_MM off, all at the feed of the whole length. Raises ProgramError if there
        is no feed."""
        points = flatten_curve(curve, end, _SPLINE_SAG_MM)
        ends = [curve(0), *points]
        feed = self._feed_of(sum(abs(b - a) for a, b in zip(ends, points)))
        for point in points:
            self.path.move_to([point.real, point.imag, None], False, feed)

    # --- arcs

    def _put_arc(self, clockwise):
        """Carry out G2 or G3: an arc or helix by R, or I, J, K, of P turns. Raises ProgramError if words are missing, or no arc fits them."""
        first, second, third = PLANES[self.plane]
        begin = [self.path.position(first), self.path.position(second)]
        height = self.path.place[third]
        target = self.take_target()
        turns = self.take_whole("p", 1) if "p" in self.words else 1
        end = [begin[0] if target[first] is None else target[first], begin[1] if target[second] is None else target[second]]
        if "r" in self.words:
            if target[first] is None and target[second] is None:
                raise ProgramError(MISSING, "{} or {}", AXES[first], AXES[second])
            radius = self.words.pop("r") * self.scale
            centre = centre_of(begin, end, radius, clockwise)
            sweep = sweep_of(begin, end, centre, clockwise, radius < 0)
        else:
            centre = self._take_centre(first, second, begin)
            sweep = sweep_of(begin, end, centre, clockwise)
        radius = math.hypot(*centre)
        rise = 0.0 if target[third] is None or height is None else target[third] - height
        feed = self._feed_of(math.hypot(radius * (sweep + math.tau * (turns - 1)), rise))
        target[first], target[second] = end
        self.path.arc_to(self.plane, clockwise, target, centre, feed, turns, sweep, _SLACK * self.scale / (10 if self.scale > 1 else 1))

    def _take_centre(self, first, second, begin):
        """Take I, J, K; return the centre in mm from the start. Raises ProgramError."""
        letters = "ijk"[first], "ijk"[second]
        if not any(letter in self.words for letter in letters):
            raise ProgramError(ARC, "R, or {} and {}", letters[0].upper(), letters[1].upper())
        if self.arc_absolute:
            return [self.take_word(letter) * self.scale - start for letter, start in zip(letters, begin)]
        return [self.words.pop(letter, 0.0) * self.scale for letter in letters]

    # --- canned cycles

    def _put_cycle(self, code):
        """Carry out a canned cycle (`code`: ten times its G number) at L positions, in the plane in force; Z, R, P and Q hold until it ends. Raises
        ProgramError if a word is missing or out of range, or there is no feed or spindle."""
        self.not_compensated("a canned cycle")
        if self.feed_mode == 930:
            raise ProgramError(NO_FEED, "a canned cycle with G93")
        first, second, third = PLANES[self.plane]
        across, along = (AXES[first].lower(), AXES[second].lower()), AXES[third].lower()
        kept = self.cycle or {}
        if kept.get("unit", self.scale) != self.scale:  # R and Z of the other unit
            kept = {letter: value for letter, value in kept.items() if letter == "p"}
        kept["unit"] = self.scale
        words = self.words
        for letter in along + "rpq":
            if letter in words:
                kept[letter] = words.pop(letter) * (self.scale if letter in "xyzrq" else 1.0)
        for letter in along + "r" + ("q" if code in (730, 830) else ""):
            if letter not in kept:
                raise ProgramError(MISSING, "{}", letter.upper())
        self.cycle = kept
        times = self.take_whole("l", 1) if "l" in words else 1
        height = self.path.position(third)
        self.level = height if self.level is None else self.level
        above = kept["r"] if self.absolute else self.level + kept["r"]
        bottom = kept[along] if self.absolute else above + kept[along]
        if bottom > above:
            raise ProgramError(RANGE, "{}{} is above R{}", along.upper(), number_text(bottom), number_text(above))
        if kept.get("q", 1.0) <= 0:
            raise ProgramError(RANGE, "Q{:g}", kept["q"])
        if kept.get("p", 0.0) < 0:
            raise ProgramError(RANGE, "P{:g}", kept["p"])
        if code in (740, 840, 860, 880) and not self.spindle:
            raise ProgramError(NO_SPINDLE, "G{}", code // 10)
        cycle = Cycle(code // 10, above, bottom, self._feed_of(None), kept.get("p", 0.0), kept.get("q", 0.0))
        cycle.axes, cycle.spindle = (first, second, third), self.spindle
        cycle.back = self.level if self.initial and self.level > above else None
        for axis, letter in zip((first, second), across):
            if letter not in words:
                self.path.position(axis)
        way = {letter: words.pop(letter) for letter in (*across, "@", "^") if letter in words}
        if height < above:
            target = [None] * 3
            target[third] = above
            self.path.move_to(target, True)
        cycle.over = cycle.back if cycle.back is not None and cycle.back > height else None
        for turn in range(times):
            words.update(way)
            to = self.take_target()
            cycle.put_hole(self.path, [self.path.place[axis] if to[axis] is None else to[axis] for axis in (first, second)])
