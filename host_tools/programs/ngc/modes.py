"""Words of an NGC line for spindle, tool, coolant, outputs, offsets and compensation; many go to the board unchanged."""

import cmath
import math

from host_tools.language import _
from host_tools.programs.compensation import LEFT, RIGHT
from host_tools.programs.program_errors import (
    MISSING, NOT_ON_BOARD, RANGE, TOOL, UNUSED, ProgramError,
)  # fmt: skip
from host_tools.programs.tool_table import Tool
from host_tools.programs.toolpath import AXES, number_text


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
        """Carry out S, and M3, M4 or M5 by `code` 30, 40 or 50; None: S alone. Raises ProgramError if S is negative."""
        turned = self.words.pop("s", None)
        if turned is not None and turned < 0:
            raise ProgramError(RANGE, "S{:g}", turned)
        rpm = self.rpm if turned is None else turned
        if code is not None:
            self.spindle = {30: "M3", 40: "M4", 50: ""}[code]
        if rpm != self.rpm or code is not None:
            self.rpm = rpm
            words = [f"S{number_text(rpm, 3)}"] if turned is not None else []
            self.path.put_word(" ".join(words + ([f"M{code // 10}"] if code is not None else [])))

    def turn_spindle(self, rpm, spindle):
        """Set speed and direction of the spindle to what they were before."""
        self.rpm, self.spindle = rpm, spindle
        self.path.put_word(f"S{number_text(rpm, 3)} {spindle or 'M5'}")

    def set_tool(self, code):
        """Carry out T, M6 (code 60) and M61 Q (610); tools are 0 to 255. Raises ProgramError if a number is out of range, or M6 comes amid
        compensation."""
        if "t" in self.words:
            self.chosen = self.take_whole("t", 0, 255)
        if code == 60:
            self.not_compensated("M6")
            self.tool = self.chosen
            self.path.put_word(f"M6 T{self.tool}")
        elif code == 610:
            self.tool = self.take_whole("q", 0, 255)

    def set_coolant(self, code, output):
        """Carry out M7, M8 or M9 (`code` 70, 80, 90), and an output's code, ten times its M number: 660 waits for an input; all but M10 and M11 want
        P, 0 to 9. Raises ProgramError."""
        if code is not None:
            self.path.put_word(f"M{code // 10}")
            self.coolant = {*self.coolant, f"M{code // 10}"} if code != 90 else set()
        if output == 660:
            self.wait_for_input()
        elif output in (100, 110):
            self.path.put_word(f"M{output // 10}")
        elif output is not None:
            self.path.put_word(f"M{output // 10} P{self.take_whole('p', 0, 9)}")

    def wait_for_input(self):
        """M66: have the board wait for an input. The result, #5399, is known to the machine only."""
        if "e" in self.words:
            raise ProgramError(NOT_ON_BOARD, "M66 E: {}", _("analogue inputs"))
        port = self.take_whole("p", 0, 9)
        what = self.take_whole("l", 0, 4) if "l" in self.words else 0
        seconds = self.words.pop("q", 0)
        if what and seconds <= 0:
            raise ProgramError(RANGE, "Q{:g}", seconds)
        self.path.put_word(f"M66 P{port} L{what}" + (f" Q{number_text(seconds)}" if what else ""))

    def put_dwell(self):
        """Carry out G4: append a pause of P seconds. Raises ProgramError if P is missing or negative."""
        seconds = self.take_word("p")
        if seconds < 0:
            raise ProgramError(RANGE, "P{:g}", seconds)
        self.path.put_word(f"G4 P{number_text(seconds)}")

    def set_cutter(self, code):
        """Carry out G40 (code 400), G41 and G42 by the tool table (410, 420), G41.1 and G42.1 by the diameter D (411, 421). Raises ProgramError if
        the tool is not in the table."""
        if code == 400:
            self.path.uncompensate()
            return
        if code in (411, 421):
            diameter = self.take_word("d") * self.scale
            self.words.pop("l", None)
        else:
            none = self.words.get("d") == 0
            tool = self.take_whole("d", 0, 255) if "d" in self.words else self.tool
            if tool not in self.tools and not none:
                raise ProgramError(TOOL, "D{}", tool)
            diameter = 0.0 if none else self.tools[tool].diameter
        side = LEFT if code in (410, 411) else RIGHT
        # A negative radius, of a tool that is smaller than the one the path was made for, goes to the other side.
        self.path.compensate(side if diameter >= 0 else -side, abs(diameter) / 2, self.plane)

    def set_length(self, code):
        """Carry out G49, G43, G43.1 and G43.2 (codes 490, 430, 431, 432). Of a tool outside of the table only the board knows the length. Raises
        ProgramError if G43.2 cannot be added up."""
        if code == 490:
            self.set_tool_length(0.0, "G49")
        elif code == 430:
            tool = self.take_whole("h", 0, 255) if "h" in self.words else self.tool
            if tool in self.tools:
                self.set_tool_length(self.tools[tool].length)
            else:
                self.set_tool_length(None, f"G43 H{tool}")
        elif code == 431:
            self.set_tool_length(self.take_word("z") * self.scale)
        else:
            tool = self.take_whole("h", 0, 255)
            if self.length[0] is None or tool not in self.tools:
                raise ProgramError(TOOL, "H{}", tool)
            self.set_tool_length(self.length[0] + self.tools[tool].length)

    def set_tool_length(self, mm, word=None):
        """Set the tool's length in mm, None if only the board knows it, by a word, default G43.1."""
        self.length = mm, word or f"G43.1 Z{number_text(mm)}"
        self.path.put_word(self.length[1])
        self.path.forget_axes((2,))

    def set_system(self, system):
        """Choose a work system, `system` 54 to 59: its turn holds, and positions are not known until axes move. Raises ProgramError amid
        compensation."""
        self.not_compensated(f"G{system}")
        self.path.put_word(f"G{system}")
        if system - 53 != self.system:
            self.path.forget_axes()
        self.system = system - 53
        self.path.turn_coordinates(self.turned.get(self.system, 0.0))

    def set_offsets(self, code):
        """Carry out G10, G28, G30, G92 and the codes that set or forget their positions."""
        self.not_compensated(f"G{number_text(code / 10, 1)}")
        if code == 100:
            self._set_table()
        elif code in (281, 301):
            self.path.put_word(f"G{number_text(code / 10, 1)}")
        elif code in (280, 300):
            self._go_home(code // 10)
        elif code == 920:
            if self.turned.get(self.system):
                raise ProgramError(NOT_ON_BOARD, "G92 in turned coordinates")
            self.shifted = True
            positions = self._axis_values()
            self.path.put_word("G92 " + self._position_words(positions))
            for axis, value in positions.items():
                self.path.now_at(axis, value)
        else:
            self.shifted = False
            self.path.put_word("G92.1")
            self.path.forget_axes()

    def unit_mm(self, axis):
        """Return the mm, of A the degrees, of one unit of an axis word."""
        if axis < 3 or self.linear:
            return self.scale
        if self.scale != 1.0:
            self.path.listing.turns_in_inches = True
        return 1.0

    def moves_a_alone(self, axes):
        """True if A alone moves, and counts degrees."""
        return list(axes) == [3] and not self.linear

    def _axis_values(self):
        """Take the axis words; return {axis: mm, of A degrees}."""
        found = {axis: self.words.pop(name.lower()) * self.unit_mm(axis) for axis, name in enumerate(AXES) if name.lower() in self.words}
        if not found:
            self.take_word("x")
        return found

    @staticmethod
    def _position_words(positions):
        return " ".join(AXES[axis] + number_text(value) for axis, value in positions.items())

    def _go_home(self, code):
        """Carry out G28 or G30, `code`: by way of the position of the axis words, if there are any. Afterwards these axes' positions are not
        known."""
        if not any(letter in self.words for letter in "xyza"):
            self.path.put_word(f"G{code}")
            self.path.forget_axes()
            return
        between = self.take_target()
        self.path.move_to(between, True, relative=not self.absolute)
        axes = [axis for axis, value in enumerate(between) if value is not None]
        self.path.put_word(f"G91 G{code} " + " ".join(AXES[axis] + "0" for axis in axes))
        self.path.put_word("G90")
        self.path.forget_axes(axes)

    def _set_table(self):
        """Carry out G10: L2 and L20 set a work system (P0: the one in force) and its turn, L1 the tool table. Raises ProgramError if there is another
        L, or a number is out of range."""
        table = self.take_whole("l")
        if table in (1, 10, 11):
            self._set_tool_table(self.take_whole("p", 1, 255), table)
            return
        if table not in (2, 20):
            raise ProgramError(NOT_ON_BOARD, "G10 L{}", table)
        system = self.take_whole("p", 0, 6)
        self._turn_system(system or self.system, table)
        degrees = self.turned.get(system or self.system, 0.0)
        if table == 2 and not any(letter in self.words for letter in "xyza"):
            return
        positions = self._axis_values()
        if table == 20 and degrees and (0 in positions or 1 in positions):
            self._set_turned(positions, system or self.system, degrees)
        self.path.put_word(f"G10 L{table} P{system} {self._position_words(positions)}")
        if system in (0, self.system):
            if degrees and (0 in positions or 1 in positions):
                self.path.forget_axes((0, 1))
            for axis, value in positions.items():
                if table == 20:
                    self.path.now_at(axis, value)
                else:
                    self.path.forget_axes((axis,))
            if table == 20 and degrees:
                self.path.turn_place()

    def _turn_system(self, system, table):
        """R of G10: turn a work system, by degrees."""
        if "r" not in self.words:
            return
        degrees = self.words.pop("r")
        if table != 2:
            raise ProgramError(UNUSED, "R{:g}", degrees)
        if degrees and self.shifted:
            raise ProgramError(NOT_ON_BOARD, "turned coordinates with G92")
        self.turned[system] = degrees
        if system == self.system:
            self.path.turn_coordinates(degrees)

    def _set_turned(self, positions, system, degrees):
        """G10 L20 in a turned system: fill in both of X and Y, because the board's systems are not turned."""
        for axis in (0, 1):
            if axis not in positions:
                if system != self.system:
                    raise ProgramError(MISSING, "{}", AXES[axis])
                positions[axis] = self.path.position(axis)
        moved = complex(positions[0], positions[1]) * cmath.rect(1.0, math.radians(degrees))
        positions[0], positions[1] = moved.real, moved.imag

    def _set_tool_table(self, tool, table):
        """Carry out G10 L1: set length (Z) and radius (R) of a tool, in the program's unit; the one that is missing stays. Raises ProgramError of L10
        and L11."""
        if table != 1:
            raise ProgramError(NOT_ON_BOARD, "G10 L{}: only the machine knows where it touches", table)
        old = self.tools.get(tool, Tool())
        length = self.words.pop("z") * self.scale if "z" in self.words else old.length
        diameter = 2 * self.words.pop("r") * self.scale if "r" in self.words else old.diameter
        self.tools[tool] = Tool(diameter, length)
