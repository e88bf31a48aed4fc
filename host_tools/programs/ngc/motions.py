"""The motions of an NGC line: lines, arcs, probing, canned cycles."""

import math

from host_tools.programs.drilling import Cycle
from host_tools.programs.ngc.codes import CYCLES, PROBES
from host_tools.programs.ngc.modes import Modes
from host_tools.programs.program_errors import (
    ARC, MISSING, NO_FEED, NO_SPINDLE, NOT_ON_BOARD, PLANE, RANGE, ProgramError,
)  # fmt: skip
from host_tools.programs.toolpath import AXES, PLANES, centre_of, number, sweep_of


_SLACK = 0.02 * math.sqrt(2)  # mm: by so much LinuxCNC's arcs may be off; in inches a tenth of the number


class Motions(Modes):
    """The part of Interpreter that moves."""

    def target(self):
        """The position that the axis words name: mm of X, Y, Z; None where there is no word. Takes the words."""
        position = []
        for axis, name in enumerate("xyz"):
            value = self.words.pop(name, None)
            if value is not None:
                value *= self.scale
                if not self.absolute:
                    value += self.path.known(axis)
            position.append(value)
        if "@" in self.words or "^" in self.words:
            self._polar(position)
        return position

    def _polar(self, position):
        """@ and ^: distance from the program's zero, or with G91 from the circle through the position, and angle."""
        if position[0] is not None or position[1] is not None:
            raise ProgramError(RANGE, "@ and ^ in place of X and Y")
        distance, angle = (self.words.pop(letter, None) for letter in "@^")
        x, y = self.path.known(0) if None in (distance, angle) or not self.absolute else 0.0, 0.0
        if None in (distance, angle) or not self.absolute:
            y = self.path.known(1)
        before = math.hypot(x, y), math.degrees(math.atan2(y, x))
        if self.absolute:
            radius = before[0] if distance is None else distance * self.scale
            turned = before[1] if angle is None else angle
        else:
            radius = before[0] + (distance or 0.0) * self.scale
            turned = before[1] + (angle or 0.0)
        position[0], position[1] = radius * math.cos(math.radians(turned)), radius * math.sin(math.radians(turned))

    def move(self, motion, of_machine):
        """One line's motion; `of_machine`: G53."""
        if of_machine:
            self._move_machine(motion)
        elif motion in CYCLES:
            self._cycle(motion)
        elif motion in (20, 30):
            self._arc(motion == 20)
        elif motion in PROBES:
            self._probe(motion)
        else:
            before = self.path.place[:]
            target = self.target()
            if target != [None] * 3:
                self.path.move(target, motion == 0, 0.0 if motion == 0 else self._feed_of(self._distance(before, target)))

    @staticmethod
    def _distance(before, target):
        """Length of a straight line in mm; None if a start is not known."""
        ways = [(old, new) for old, new in zip(before, target) if new is not None]
        return None if any(old is None for old, _ in ways) else math.hypot(*(new - old for old, new in ways))

    def _feed_of(self, length):
        """mm/min of a motion of this length, in mm."""
        feed = self.feed
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
        if motion not in (0, 10):
            raise ProgramError(NOT_ON_BOARD, "G53 goes with G0 and G1")
        self.not_compensated("G53")
        if not self.absolute:
            raise ProgramError(RANGE, "G53 with G91")
        positions = self._axes()
        if motion == 10 and self.feed_mode != 940:
            raise ProgramError(NO_FEED, "G53 G1 wants G94")
        feed = "" if motion == 0 else f" F{number(self._feed_of(None), 3)}"
        self.path.word(f"G53 G{motion // 10} {self._text(positions)}{feed}")
        self.path.forget(positions)

    def _probe(self, code):
        self.not_compensated("G38")
        target = self.target()
        axes = [axis for axis, value in enumerate(target) if value is not None]
        if not axes:
            raise ProgramError(MISSING, "X, Y or Z")
        positions = " ".join(AXES[axis] + number(target[axis]) for axis in axes)
        self.path.word(f"G{code / 10:g} {positions} F{number(self._feed_of(None), 3)}")
        self.path.forget(axes)

    # --- arcs

    def _arc(self, clockwise):
        first, second, third = PLANES[self.plane]
        begin = [self.path.known(first), self.path.known(second)]
        height = self.path.place[third]
        target = self.target()
        turns = self.whole("p", 1) if "p" in self.words else 1
        end = [begin[0] if target[first] is None else target[first], begin[1] if target[second] is None else target[second]]
        if "r" in self.words:
            if target[first] is None and target[second] is None:
                raise ProgramError(MISSING, "{} or {}", AXES[first], AXES[second])
            radius = self.words.pop("r") * self.scale
            centre = centre_of(begin, end, radius, clockwise)
            sweep = sweep_of(begin, end, centre, clockwise, radius < 0)
        else:
            centre = self._centre(first, second, begin)
            sweep = sweep_of(begin, end, centre, clockwise)
        radius = math.hypot(*centre)
        rise = 0.0 if target[third] is None or height is None else target[third] - height
        feed = self._feed_of(math.hypot(radius * (sweep + math.tau * (turns - 1)), rise))
        target[first], target[second] = end
        self.path.arc(self.plane, clockwise, target, centre, feed, turns, sweep, _SLACK * self.scale / (10 if self.scale > 1 else 1))

    def _centre(self, first, second, begin):
        """The centre by I, J, K, in mm from the start."""
        letters = "ijk"[first], "ijk"[second]
        if not any(letter in self.words for letter in letters):
            raise ProgramError(ARC, "R, or {} and {}", letters[0].upper(), letters[1].upper())
        if self.arc_absolute:
            return [self.take(letter) * self.scale - start for letter, start in zip(letters, begin)]
        return [self.words.pop(letter, 0.0) * self.scale for letter in letters]

    # --- canned cycles

    def _cycle(self, code):
        self.not_compensated("a canned cycle")
        if self.plane != 17:
            raise ProgramError(PLANE, "canned cycles")
        if self.feed_mode == 930:
            raise ProgramError(NO_FEED, "a canned cycle with G93")
        kept = self.cycle or {}
        words = self.words
        for letter in "xyzrpq":
            if letter in words and letter not in "xy":
                kept[letter] = words.pop(letter) * (self.scale if letter in "zrq" else 1.0)
        for letter in "zr" + ("q" if code in (730, 830) else ""):
            if letter not in kept:
                raise ProgramError(MISSING, "{}", letter.upper())
        self.cycle = kept
        times = self.whole("l", 1) if "l" in words else 1
        height = self.path.known(2)
        above = kept["r"] if self.absolute else height + kept["r"]
        bottom = kept["z"] if self.absolute else above + kept["z"]
        if bottom > above:
            raise ProgramError(RANGE, "Z{} is above R{}", number(bottom), number(above))
        if kept.get("q", 1.0) <= 0:
            raise ProgramError(RANGE, "Q{:g}", kept["q"])
        if kept.get("p", 0.0) < 0:
            raise ProgramError(RANGE, "P{:g}", kept["p"])
        if code in (740, 840, 860, 880) and not self.spindle:
            raise ProgramError(NO_SPINDLE, "G{}", code // 10)
        cycle = Cycle(code // 10, above, bottom, self._feed_of(None), kept.get("p", 0.0), kept.get("q", 0.0))
        cycle.spindle = self.spindle
        cycle.back = height if self.initial and height > above else None
        position = [self.path.place[0], self.path.place[1]]
        for axis, letter in enumerate("xy"):
            if letter not in words:
                self.path.known(axis)
        way = [words.pop(letter, None) for letter in "xy"]
        if height < above:
            self.path.move([None, None, above], True)
        for turn in range(times):
            for axis, value in enumerate(way):
                if value is not None:
                    position[axis] = value * self.scale + (0.0 if self.absolute else self.path.known(axis))
            cycle.hole(self.path, position)
