"""Words of an NGC line for spindle, tool, coolant, outputs, offsets and compensation; many go to the board unchanged."""

import cmath
import math

from host_tools.language import _
from host_tools.programs.compensation import LEFT, RIGHT
from host_tools.programs.program_errors import (
    MISSING, NOT_ON_BOARD, RANGE, TOOL, UNUSED, ProgramError,
)  # fmt: skip
from host_tools.programs.tool_table import Tool
from host_tools.programs.toolpath import AXES, number


class Modes:
    """The part of Interpreter that has the modal state."""

    def __init__(self, path, tools, linear=False):
        self.path = path
        self.tools = tools
        self.linear = linear  # A counts inches in G20, and F along it mm
        self.motion = 800
        self.plane = 17
        self.scale = 1.0  # mm a unit
        self.absolute = True
        self.arc_absolute = False
        self.feed_mode = 940
        self.feed = 0.0  # mm/min; mm a turn with G95
        self.typed = 0.0  # F as it stands: degrees, where A alone moves
        self.rpm = 0.0
        self.spindle = ""
        self.tool = self.chosen = 0
        self.length = None, None  # of the tool, mm, if it is known, and the word that sets it
        self.coolant = set()
        self.initial = True  # G98
        self.system = 1
        self.turned = {}  # degrees, of each system that is
        self.shifted = False  # G92
        self.nurbs = None  # [position, weight] of the control points of G5.2
        self.order = 3  # of it
        self.leaving = None  # how the G5 before ended: the way from its second control point to its end
        self.cycle = None  # words of the cycle that holds
        self.level = None  # Z before the first of the cycles that follow each other
        self.words = {}  # of the line, as far as nothing has taken them

    def set_spindle(self, code):
        turned = self.words.pop("s", None)
        if turned is not None and turned < 0:
            raise ProgramError(RANGE, "S{:g}", turned)
        rpm = self.rpm if turned is None else turned
        if code is not None:
            self.spindle = {30: "M3", 40: "M4", 50: ""}[code]
        if rpm != self.rpm or code is not None:
            self.rpm = rpm
            words = [f"S{number(rpm, 3)}"] if turned is not None else []
            self.path.word(" ".join(words + ([f"M{code // 10}"] if code is not None else [])))

    def turn_spindle(self, rpm, spindle):
        """As it turned before."""
        self.rpm, self.spindle = rpm, spindle
        self.path.word(f"S{number(rpm, 3)} {spindle or 'M5'}")

    def set_tool(self, code):
        if "t" in self.words:
            self.chosen = self.whole("t", 0, 255)
        if code == 60:
            self.not_compensated("M6")
            self.tool = self.chosen
            self.path.word(f"M6 T{self.tool}")
        elif code == 610:
            self.tool = self.whole("q", 0, 255)

    def set_coolant(self, code, output):
        if code is not None:
            self.path.word(f"M{code // 10}")
            self.coolant = {*self.coolant, f"M{code // 10}"} if code != 90 else set()
        if output == 660:
            self.wait()
        elif output in (100, 110):
            self.path.word(f"M{output // 10}")
        elif output is not None:
            self.path.word(f"M{output // 10} P{self.whole('p', 0, 9)}")

    def wait(self):
        """M66: the board waits for an input. Its result, #5399, is known to the machine only."""
        if "e" in self.words:
            raise ProgramError(NOT_ON_BOARD, "M66 E: {}", _("analogue inputs"))
        port = self.whole("p", 0, 9)
        what = self.whole("l", 0, 4) if "l" in self.words else 0
        seconds = self.words.pop("q", 0)
        if what and seconds <= 0:
            raise ProgramError(RANGE, "Q{:g}", seconds)
        self.path.word(f"M66 P{port} L{what}" + (f" Q{number(seconds)}" if what else ""))

    def dwell(self):
        seconds = self.take("p")
        if seconds < 0:
            raise ProgramError(RANGE, "P{:g}", seconds)
        self.path.word(f"G4 P{number(seconds)}")

    def set_cutter(self, code):
        if code == 400:
            self.path.uncompensate()
            return
        if code in (411, 421):
            diameter = self.take("d") * self.scale
            self.words.pop("l", None)
        else:
            none = self.words.get("d") == 0
            tool = self.whole("d", 0, 255) if "d" in self.words else self.tool
            if tool not in self.tools and not none:
                raise ProgramError(TOOL, "D{}", tool)
            diameter = 0.0 if none else self.tools[tool].diameter
        side = LEFT if code in (410, 411) else RIGHT
        # A negative radius, of a tool that is smaller than the one the path was made for, goes to the other side.
        self.path.compensate(side if diameter >= 0 else -side, abs(diameter) / 2, self.plane)

    def set_length(self, code):
        if code == 490:
            self.lengthen(0.0, "G49")
        elif code == 430:
            tool = self.whole("h", 0, 255) if "h" in self.words else self.tool
            if tool in self.tools:
                self.lengthen(self.tools[tool].length)
            else:
                self.lengthen(None, f"G43 H{tool}")
        elif code == 431:
            self.lengthen(self.take("z") * self.scale)
        else:
            tool = self.whole("h", 0, 255)
            if self.length[0] is None or tool not in self.tools:
                raise ProgramError(TOOL, "H{}", tool)
            self.lengthen(self.length[0] + self.tools[tool].length)

    def lengthen(self, mm, word=None):
        """Take a length of the tool, None if only the board knows it, by a word, G43.1 by default."""
        self.length = mm, word or f"G43.1 Z{number(mm)}"
        self.path.word(self.length[1])
        self.path.forget((2,))

    def set_system(self, system):
        self.not_compensated(f"G{system}")
        self.path.word(f"G{system}")
        if system - 53 != self.system:
            self.path.forget()
        self.system = system - 53
        self.path.turn(self.turned.get(self.system, 0.0))

    def offsets(self, code):
        """G10, G28, G30, G92 and what belongs to them."""
        self.not_compensated(f"G{number(code / 10, 1)}")
        if code == 100:
            self._set_table()
        elif code in (281, 301):
            self.path.word(f"G{number(code / 10, 1)}")
        elif code in (280, 300):
            self._go_home(code // 10)
        elif code == 920:
            if self.turned.get(self.system):
                raise ProgramError(NOT_ON_BOARD, "G92 in turned coordinates")
            self.shifted = True
            positions = self._axes()
            self.path.word("G92 " + self._text(positions))
            for axis, value in positions.items():
                self.path.now_at(axis, value)
        else:
            self.shifted = False
            self.path.word("G92.1")
            self.path.forget()

    def unit(self, axis):
        """mm, of A degrees, that a word's number counts."""
        if axis < 3 or self.linear:
            return self.scale
        if self.scale != 1.0:
            self.path.listing.turns_in_inches = True
        return 1.0

    def turns(self, axes):
        """True if A alone moves, and counts degrees."""
        return list(axes) == [3] and not self.linear

    def _axes(self):
        """{axis: mm, of A degrees} of the axis words."""
        found = {axis: self.words.pop(name.lower()) * self.unit(axis) for axis, name in enumerate(AXES) if name.lower() in self.words}
        if not found:
            self.take("x")
        return found

    @staticmethod
    def _text(positions):
        return " ".join(AXES[axis] + number(value) for axis, value in positions.items())

    def _go_home(self, code):
        if not any(letter in self.words for letter in "xyza"):
            self.path.word(f"G{code}")
            self.path.forget()
            return
        between = self.target()
        self.path.move(between, True, relative=not self.absolute)
        axes = [axis for axis, value in enumerate(between) if value is not None]
        self.path.word(f"G91 G{code} " + " ".join(AXES[axis] + "0" for axis in axes))
        self.path.word("G90")
        self.path.forget(axes)

    def _set_table(self):
        table = self.whole("l")
        if table in (1, 10, 11):
            self._set_tool_table(self.whole("p", 1, 255), table)
            return
        if table not in (2, 20):
            raise ProgramError(NOT_ON_BOARD, "G10 L{}", table)
        system = self.whole("p", 0, 6)
        self._turn(system or self.system, table)
        degrees = self.turned.get(system or self.system, 0.0)
        if table == 2 and not any(letter in self.words for letter in "xyza"):
            return
        positions = self._axes()
        if table == 20 and degrees and (0 in positions or 1 in positions):
            self._set_turned(positions, system or self.system, degrees)
        self.path.word(f"G10 L{table} P{system} {self._text(positions)}")
        if system in (0, self.system):
            if degrees and (0 in positions or 1 in positions):
                self.path.forget((0, 1))
            for axis, value in positions.items():
                if table == 20:
                    self.path.now_at(axis, value)
                else:
                    self.path.forget((axis,))
            if table == 20 and degrees:
                self.path.turn_place()

    def _turn(self, system, table):
        """R of G10: how far a system is turned."""
        if "r" not in self.words:
            return
        degrees = self.words.pop("r")
        if table != 2:
            raise ProgramError(UNUSED, "R{:g}", degrees)
        if degrees and self.shifted:
            raise ProgramError(NOT_ON_BOARD, "turned coordinates with G92")
        self.turned[system] = degrees
        if system == self.system:
            self.path.turn(degrees)

    def _set_turned(self, positions, system, degrees):
        """G10 L20 in a system that is turned: the board's are not, so it gets both of X and Y."""
        for axis in (0, 1):
            if axis not in positions:
                if system != self.system:
                    raise ProgramError(MISSING, "{}", AXES[axis])
                positions[axis] = self.path.position(axis)
        moved = complex(positions[0], positions[1]) * cmath.rect(1.0, math.radians(degrees))
        positions[0], positions[1] = moved.real, moved.imag

    def _set_tool_table(self, tool, table):
        if table != 1:
            raise ProgramError(NOT_ON_BOARD, "G10 L{}: only the machine knows where it touches", table)
        old = self.tools.get(tool, Tool())
        length = self.words.pop("z") * self.scale if "z" in self.words else old.length
        diameter = 2 * self.words.pop("r") * self.scale if "r" in self.words else old.diameter
        self.tools[tool] = Tool(diameter, length)
