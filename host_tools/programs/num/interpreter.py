"""Carries out a NUM program, block by block.

    compile_program("part.num", text, listing, tools={})

Positions are those of the program plus the offset of G59. Arcs have their centre, I and J, as a position with G90 and from the start with
G91, or a radius.
"""

import math

from host_tools import interpreter
from host_tools.language import _
from host_tools.programs.compensation import LEFT, RIGHT
from host_tools.programs.drilling import Cycle
from host_tools.programs.num.blocks import Variables, read
from host_tools.programs.num.flow import Flow
from host_tools.programs.num.pocket import Pocket
from host_tools.programs.program_errors import (
    ARC, COMPENSATED, MISSING, NO_FEED, NOT_IN_DIALECT, PLANE, POCKET, RANGE, SAME_GROUP, TOOL, TWO_COMMANDS, UNUSED, WHOLE, ProgramError,
)  # fmt: skip
from host_tools.programs.toolpath import PLANES, Toolpath, centre_of, number_text, sweep_of

_INCH_MM = 25.4
_AXES = "XYZ"
_GROUPS = (
    (0, 1, 2, 3), (17, 18, 19), (40, 41, 42), (45, 80, 81), (70, 71), (90, 91), (4, 59, 77, 79), (9,), (94,), (97,),
)  # fmt: skip
_M = ((0, 1, 2), (3, 4, 5), (6,), (7, 8, 9), (10, 11))


def compile_program(name, text, listing, tools=None, start=(), bound=1_000_000, find=None, skip=False):
    """Carry out a program into `listing`; return {file: its lines}. Arguments as of ngc.interpreter; subprograms are in the file. Raises
    ProgramError."""
    flow = Flow(name, text, bound, skip)
    path = Toolpath(listing, start)
    interpreter = Interpreter(path, flow, tools or {})
    for source, row in flow:
        path.source = source
        if listing.progress:
            listing.progress(source)
        try:
            interpreter.carry_out(row)
        except ProgramError as error:
            raise error.name_place(source) from None
    try:
        path.uncompensate()
    except ProgramError as error:
        raise error.name_place(path.source) from None
    return flow.texts


class Interpreter:
    def __init__(self, path, flow, tools):
        self.path = path
        self._flow = flow
        self._tools = tools
        self._variables = Variables()
        self._motion = 0
        self._plane = 17
        self._scale = 1.0
        self._absolute = True
        self._feed = 0.0
        self._rpm = None
        self._tool = None  # D
        self._chosen = 0  # T
        self._offset = [0.0, 0.0, 0.0]  # G59
        self._cycle = None  # (code, words)
        self._words = {}

    def carry_out(self, text):
        """Carry out one block. Raises ProgramError."""
        block = read(text, self._variables)
        words = self._words = block.words
        g, m = self._group_codes(block.g, _GROUPS, "G"), self._group_codes(block.m, _M, "M")
        if 77 in g or 79 in g:
            self._carry_out_branch(g, m, block)
            return
        if block.targets:
            raise ProgramError(UNUSED, "N{}", block.targets[0])
        self._set_modes(g)
        if 4 in g:
            self._put_dwell()
        self._set_machine(m)
        if "F" in words:
            self._feed = self._take_word("F") * self._scale
            if self._feed <= 0:
                raise ProgramError(NO_FEED, "F0")
        if 59 in g:
            self._set_offset()
        else:
            self._put_motion(g)
        if words:
            raise ProgramError(UNUSED, "{}", " ".join(f"{name}{number_text(value)}" for name, value in words.items()))
        self._stop_program(m)

    @staticmethod
    def _group_codes(codes, groups, letter):
        """Return the codes as a set. Raises ProgramError if one is not known, or two exclude each other."""
        taken = set()
        for code in codes:
            group = next((group for group in groups if code in group), None)
            if group is None:
                raise ProgramError(NOT_IN_DIALECT, "{}{:02}", letter, code)
            if taken & set(group):
                raise ProgramError(SAME_GROUP, "{}{:02}", letter, code)
            taken.add(code)
        return taken

    def _take_word(self, name, default=None):
        """Take the value of a word. Raises ProgramError if it is missing and there is no default."""
        if name not in self._words and default is None:
            raise ProgramError(MISSING, "{}", name)
        return self._words.pop(name, default)

    def _take_whole(self, name, default=None, most=99999):
        """Take the value of a word as a whole number, 0 … `most`. Raises ProgramError if it is another one, or missing without a default."""
        value = self._take_word(name, default)
        if value % 1:
            raise ProgramError(WHOLE, "{}{:g}", name, value)
        if not 0 <= value <= most:
            raise ProgramError(RANGE, "{}{:g}", name, value)
        return int(value)

    # --- what comes next

    def _carry_out_branch(self, g, m, block):
        """Carry out G77 and G79. Raises ProgramError."""
        if g - {77, 79} or m or len(g) > 1:
            raise ProgramError(TWO_COMMANDS, "G77 and G79 stand alone")
        if 79 in g:
            if self._words:
                raise ProgramError(UNUSED, "{}", next(iter(self._words)))
            if len(block.targets) != 1:
                raise ProgramError(MISSING, "N")
            if block.condition is not False:
                self._flow.jump_to(block.targets[0])
            return
        program = self._take_whole("H") if "H" in self._words else None
        times = self._take_whole("S", 1, 9999)
        if program is None and not block.targets or len(block.targets) > 2:
            raise ProgramError(MISSING, "H, or N and N")
        if self._words:
            raise ProgramError(UNUSED, "{}", next(iter(self._words)))
        if times:
            self._flow.call_program(program, block.targets, times)

    def _stop_program(self, m):
        """Carry out M00 and M01, a pause, and M02, the program's end, by the set of codes `m`."""
        if m & {0, 1}:
            self.path.put_word("M0" if 0 in m else "M1")
        if 2 in m:
            self.path.uncompensate()
            self.path.put_word("M2")
            self._flow.end()

    # --- modes

    def _set_modes(self, g):
        """Set plane, unit, G90 or G91, motion, tool and compensation by the set of codes `g`. Raises ProgramError if the tool is not known."""
        for code in g & {17, 18, 19}:
            self._plane = code
        for code in g & {70, 71}:
            self._scale = _INCH_MM if code == 70 else 1.0
        for code in g & {90, 91}:
            self._absolute = code == 90
        for code in g & {0, 1, 2, 3} if 45 not in g else ():  # of a pocket it is the direction
            self._motion = code
        if "D" in self._words:
            self._tool = self._take_whole("D", most=255)
        if 80 in g or g & {0, 1, 2, 3}:
            self._cycle = None
        if 40 in g:
            self.path.uncompensate()
        elif g & {41, 42}:
            self.path.compensate(LEFT if 41 in g else RIGHT, self._tool_radius(), self._plane)

    def _tool_radius(self):
        """Return the radius of the tool that D names, in mm. Raises ProgramError."""
        if self._tool == 0:
            return 0.0
        if self._tool not in self._tools:
            raise ProgramError(TOOL, "{}", "D" if self._tool is None else f"D{self._tool}")
        return self._tools[self._tool].radius

    def _put_dwell(self):
        """Append a pause of F seconds. Raises ProgramError if F is missing, or not 0 to 99.99."""
        seconds = self._take_word("F")
        if not 0 <= seconds <= 99.99:
            raise ProgramError(RANGE, "F{:g}: seconds, 99.99 at most", seconds)
        self.path.put_word(f"G4 P{number_text(seconds)}")

    def _set_machine(self, m):
        """Carry out T and M06, S in rpm, and the M codes of spindle, coolant and outputs, 3 to 5 and 7 to 11. Raises ProgramError if a number is out
        of range, or M06 comes amid compensation."""
        if "T" in self._words:
            self._chosen = self._take_whole("T", most=255)
        if 6 in m:
            self._not_compensated("M06")
            self.path.put_word(f"M6 T{self._chosen}")
        said = []
        if "S" in self._words:
            rpm = self._take_word("S")
            if rpm < 0:
                raise ProgramError(RANGE, "S{:g}", rpm)
            said.append(f"S{number_text(rpm, 3)}")
        said += [f"M{code}" for code in sorted(m & {3, 4, 5})]
        if said:
            self.path.put_word(" ".join(said))
        for code in sorted(m & {7, 8, 9, 10, 11}):
            self.path.put_word(f"M{code}")

    def _not_compensated(self, what):
        if self.path.contour:
            raise ProgramError(COMPENSATED, "{}", what)

    def _set_offset(self):
        """G59: with G90 in place of the offset before, with G91 in addition to it."""
        self._not_compensated("G59")
        found = [(axis, name) for axis, name in enumerate(_AXES) if name in self._words]
        if not found:
            raise ProgramError(MISSING, "X, Y or Z")
        for axis, name in found:
            value = self._take_word(name) * self._scale
            self._offset[axis] = value + (0.0 if self._absolute else self._offset[axis])

    # --- motions

    def _put_motion(self, g):
        """Append the block's motion, by the codes `g` or those in force: a cycle, an arc or a straight line; nothing without axis words. Raises
        ProgramError if there is no feed."""
        words = self._words
        positions = any(name in words for name in _AXES)
        if g & {45, 81}:
            self._not_compensated(_("a cycle"))
            self._cycle = (min(g & {45, 81}), {})
        if self._cycle and (positions or g & {45, 81}):
            self._carry_out_cycle(2 in g)
        elif self._motion in (2, 3) and (positions or "I" in words or "J" in words or "K" in words):
            self._put_arc(self._motion == 2)
        elif positions:
            if self._motion and not self._feed:
                raise ProgramError(NO_FEED)
            self.path.move_to(self._take_target(), not self._motion, self._feed if self._motion else 0.0)

    def _take_target(self):
        """Take the axis words; return the position that they name, mm; None where there is no word."""
        position = []
        for axis, name in enumerate(_AXES):
            value = self._words.pop(name, None)
            if value is not None:
                value = value * self._scale + (self._offset[axis] if self._absolute else self.path.position(axis))
            position.append(value)
        return position

    def _put_arc(self, clockwise):
        """Append an arc by R, or I, J, K: positions with G90, from the start with G91. Raises ProgramError if there is no feed, words are missing, or
        no arc fits."""
        if not self._feed:
            raise ProgramError(NO_FEED)
        first, second, _ = PLANES[self._plane]
        begin = [self.path.position(first), self.path.position(second)]
        target = self._take_target()
        end = [begin[0] if target[first] is None else target[first], begin[1] if target[second] is None else target[second]]
        if "R" in self._words:
            radius = self._take_word("R") * self._scale
            if radius <= 0:
                raise ProgramError(RANGE, "R{:g}", radius)
            centre = centre_of(begin, end, radius, clockwise)
            sweep = sweep_of(begin, end, centre, clockwise, False)
        else:
            names = "IJK"[first], "IJK"[second]
            if not any(name in self._words for name in names):
                raise ProgramError(ARC, "R, or {} and {}", names[0], names[1])
            if self._absolute:
                middle = [self._take_word(name) * self._scale + self._offset[axis] for name, axis in zip(names, (first, second))]
                centre = [middle[0] - begin[0], middle[1] - begin[1]]
            else:
                centre = [self._take_word(name, 0.0) * self._scale for name in names]
            sweep = sweep_of(begin, end, centre, clockwise)
        target[first], target[second] = end
        self.path.arc_to(self._plane, clockwise, target, centre, self._feed, 1, sweep)

    # --- cycles

    def _carry_out_cycle(self, clockwise):
        """Carry out G81 or G45 at the block's position; ER, Z and a pocket's words hold until the cycle ends. Raises ProgramError outside of XY, or
        if a word is missing or out of range."""
        if self._plane != 17:
            raise ProgramError(PLANE, "cycles")
        code, kept = self._cycle
        for name in ("EX", "EY", "EB", "P", "Q", "I", "J", "EP", "EQ", "EI", "EJ") if code == 45 else ():
            if name in self._words:
                kept[name] = self._take_word(name) * self._scale
        if "ER" in self._words:
            value = self._take_word("ER") * self._scale
            kept["above"] = value + (self._offset[2] if self._absolute else self.path.position(2))
        above = kept.setdefault("above", self.path.place[2])
        if above is None:
            self.path.position(2)
        if "Z" in self._words:
            value = self._take_word("Z") * self._scale
            kept["bottom"] = value + (self._offset[2] if self._absolute else above)
        if "bottom" not in kept:
            raise ProgramError(MISSING, "Z")
        target = self._take_target()
        position = [self.path.position(axis) if target[axis] is None else target[axis] for axis in (0, 1)]
        if kept["bottom"] >= above:
            raise ProgramError(RANGE, "Z{} is above ER{}", number_text(kept["bottom"]), number_text(above))
        if self.path.place[2] is not None and self.path.place[2] < above:
            self.path.move_to([None, None, above], True)
        if code == 81:
            if not self._feed:
                raise ProgramError(NO_FEED)
            Cycle(81, above, kept["bottom"], self._feed).put_hole(self.path, position)
        else:
            if clockwise:
                kept["clockwise"] = True
            self._put_pocket(kept, position, above)

    def _put_pocket(self, kept, position, above):
        """Append G45's pocket around `position`, from the height `above`, all in mm; feeds that are missing are F's. Raises ProgramError if the
        pocket's size is missing or wrong, or there is no feed."""
        length, width, corner = (kept.get(name) for name in ("EX", "EY", "EB"))
        radius = self._tool_radius()
        if any(value is not None and value <= 0 for value in (length, width, corner)):
            raise ProgramError(POCKET, "EX, EY or EB")
        if length and width:
            half, corner = (length / 2, width / 2), radius if corner is None else corner
        elif corner:
            half = (length / 2 if length else corner, width / 2 if width else corner)
        else:
            raise ProgramError(MISSING, "EX and EY, or EB")
        if min(half) < corner - 1e-9:
            raise ProgramError(POCKET, "corners of radius EB{:g} in {:g} × {:g} mm", corner, 2 * half[0], 2 * half[1])
        feeds = [kept.get("EP", self._feed), kept.get("EQ", self._feed)]
        feeds += [kept.get("EI", feeds[0]), kept.get("EJ", feeds[1])]
        if min(feeds) <= 0:
            raise ProgramError(NO_FEED, "EP and EQ, or F")
        depth = kept.get("P", math.inf)
        Pocket(
            tuple(position), half, corner, above, kept["bottom"], depth, kept.get("Q", radius), kept.get("I", 0.0), kept.get("J", 0.0),
            kept.get("clockwise", False), tuple(feeds),
        ).put_motions(self.path, radius)
