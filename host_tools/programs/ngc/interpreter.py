"""Carries out an NGC program, line by line: modal state and motions, in the order of RS274/NGC (NIST IR 6556, table 8).

    compile_program("part.ngc", text, listing, tools={})

Lengths are mm inside, A is degrees in G20 and G21 alike; a linear A is a length. G20 and G21 hold for their whole line, its F too.
"""

from host_tools import interpreter
from host_tools.language import _
from host_tools.programs.ngc.blocks import read, whole_number
from host_tools.programs.ngc.codes import (
    ARC_DISTANCE, AXIS_COMMANDS, CALLING, CHANGE, COOLING, CUTTER, CYCLES, DISTANCE, FEED_MODE, G_GROUPS, LENGTH, M_GROUPS, MOTION,
    NON_MODAL, NOT_ON_BOARD, OVERRIDES, PATH, PLANE, PROBES, RETURN, SAVING, SPLINES, STOPPING, SWITCHING, SYSTEM, TURNING, UNITS,
)  # fmt: skip
from host_tools.programs.ngc.endless import plain_value
from host_tools.programs.ngc.flow import Flow
from host_tools.programs.ngc.motions import Motions
from host_tools.programs.ngc.saved_modes import SavedModes
from host_tools.programs.ngc.state import State
from host_tools.programs.program_errors import (
    COMPENSATED, MISSING, NO_FEED, NOT_IN_DIALECT, NOT_ON_BOARD as UNABLE, SAME_GROUP, TWO_COMMANDS, UNUSED, ProgramError,
)  # fmt: skip
from host_tools.programs.toolpath import Toolpath, number_text

INCH_MM = 25.4
_NO_STATE = ("path", "values", "saved", "flow", "words", "listing", "source", "_told", "_modes")  # parts of the interpreter, and of a line


def compile_program(name, text, listing, tools=None, start=(), bound=1_000_000, find=None, skip=False, linear=False):
    """Carry out a program into `listing`. Returns {file: its lines}. `tools`: {number: tool_table.Tool}; `start`: where the
    machine stands, mm of the program; `bound`: the most lines that are carried out; `find`: see Flow; `linear`: A is no rotary axis. Raises
    ProgramError with file and line."""
    path = Toolpath(listing, start)
    interpreter = Interpreter(path, dict(tools or {}), linear)
    flow = interpreter.flow = Flow(name, text, interpreter.values, interpreter.saved, interpreter.plain_state, bound, find, skip)
    for line in flow:
        path.source = line.source
        if listing.progress:
            listing.progress(line.source)
        try:
            if interpreter.carry_out(line.rest):
                flow.end()
        except ProgramError as error:
            raise error.name_place(line.source) from None
    try:
        path.uncompensate()
        path.end_inverse()
    except ProgramError as error:
        raise error.name_place(path.source) from None
    return flow.texts


class Interpreter(Motions):
    def __init__(self, path, tools, linear=False):
        Motions.__init__(self, path, tools, linear)
        self.values = State(self._readable_parameters())
        self.saved = SavedModes(self)
        self.flow = None

    def plain_state(self):
        """Return everything that the next lines depend on, in plain values. Raises TypeError while a contour is compensated."""
        parts = (self, self.path, self.values, self.saved)
        return tuple(plain_value({key: each for key, each in vars(part).items() if key not in _NO_STATE}) for part in parts)

    def _readable_parameters(self):
        """Return {number or name: function} of the parameters by which a program asks for its state."""
        told = {5220: lambda: self.system, 5400: lambda: self.tool, 5403: lambda: self.length[0] or 0.0}
        told[5410] = lambda: self.tools[self.tool].diameter / self.scale if self.tool in self.tools else 0.0
        for axis, name in enumerate("xyza"):
            told[5420 + axis] = told["_" + name] = lambda axis=axis: self.path.position(axis) / self.unit_mm(axis)
        told.update(
            _feed=lambda: self.feed / self.scale,
            _rpm=lambda: self.rpm,
            _metric=lambda: self.scale == 1,
            _imperial=lambda: self.scale != 1,
            _absolute=lambda: self.absolute,
            _incremental=lambda: not self.absolute,
            _current_tool=lambda: self.tool,
            _selected_tool=lambda: self.chosen,
            _coord_system=lambda: 530 + 10 * self.system,
            _plane=lambda: self.plane * 10,
            _line=lambda: self.path.source.line,
            _spindle_on=lambda: bool(self.spindle),
        )
        return told

    def carry_out(self, text):
        """Carry out one line; return True if it ends the program. Raises ProgramError."""
        block = read(text, self.values)
        words = self.words = block.words
        g, m = self._group_codes(block)
        for name, value in block.settings:
            self.values.set(name, value)
        if UNITS in g:
            self.scale = INCH_MM if g[UNITS] == 200 else 1.0
        non_modal = g.get(NON_MODAL)
        motion = self._motion_of(g, non_modal)
        if FEED_MODE in g:
            if g[FEED_MODE] != self.feed_mode:
                self.feed = self.typed = 0.0
            self.feed_mode = g[FEED_MODE]
        self.set_feed(motion)
        self.set_spindle(m.get(TURNING))
        self.set_tool(m.get(CHANGE))
        self.set_coolant(m.get(COOLING), m.get(SWITCHING))
        if SAVING in m:
            self.saved.carry_out(m[SAVING])
        if non_modal == 40:
            self.put_dwell()
        if PLANE in g:
            self.plane = g[PLANE] // 10
        if ARC_DISTANCE in g:
            self.arc_absolute = g[ARC_DISTANCE] == 901
        if DISTANCE in g:
            self.absolute = g[DISTANCE] == 900
        if CUTTER in g:
            self.set_cutter(g[CUTTER])
        if LENGTH in g:
            self.set_length(g[LENGTH])
        if SYSTEM in g:
            self.set_system(g[SYSTEM] // 10)
        for letter in "pq" if PATH in g else "":
            words.pop(letter, None)  # G64 P Q: how far corners may be rounded; the board keeps to the path
        if RETURN in g:
            self.initial = g[RETURN] == 980
        if non_modal not in (None, 40, 530):
            self.set_offsets(non_modal)
        elif motion is not None:
            self.put_motion(motion, non_modal == 530)
        called = (self.take_whole("p", 0, 99999), self.take_whole("l", 0, 9999) if "l" in self.words else 1) if m.get(CALLING) == 980 else None
        if self.words:
            raise ProgramError(UNUSED, "{}", " ".join(letter.upper() + number_text(value) for letter, value in self.words.items()))
        if called:
            self.flow.call_program(*called)
        elif CALLING in m:
            self.flow.end_program()
        return self._stop_program(m.get(STOPPING))

    def _group_codes(self, block):
        """Return ({group: code} of the G codes, the same of the M codes). Raises ProgramError."""
        found = {}, {}
        for letter, codes, groups, kept in (("g", block.g, G_GROUPS, found[0]), ("m", block.m, M_GROUPS, found[1])):
            for code in codes:
                text = f"{letter.upper()}{number_text(code / 10, 1)}"
                if code not in groups:
                    why = NOT_ON_BOARD[letter].get(code)
                    raise ProgramError(UNABLE, "{}: {}", text, _(why)) if why else ProgramError(NOT_IN_DIALECT, "{}", text)
                if groups[code] in kept and groups[code] != OVERRIDES:
                    raise ProgramError(SAME_GROUP, "{}", text)
                kept[groups[code]] = code
        return found

    def _motion_of(self, g, non_modal):
        """Return the motion for which the line has axis words, None if nothing moves, and keep the modal one."""
        commands = [code for code in g.values() if code in AXIS_COMMANDS]
        if len(commands) > 1:
            raise ProgramError(TWO_COMMANDS, "{}", " ".join(f"G{number_text(code / 10, 1)}" for code in commands))
        if MOTION in g:
            if g[MOTION] not in CYCLES or g[MOTION] != self.motion:
                self.cycle = None
            if g[MOTION] not in CYCLES:
                self.level = None
            self.motion = g[MOTION]
        other = commands and commands[0] not in MOTIONS_WITH_AXES
        axes = any(letter in self.words for letter in "xyza@^")
        if other or self.motion == 800 or MOTION not in g and not axes:
            if axes and not other and non_modal != 40 and self.motion == 800:
                raise ProgramError(UNUSED, "axis words, and no motion holds")
            return None
        return self.motion

    def set_feed(self, motion):
        """Take F: mm/min; with G93 and G95 the number as it stands. Raises ProgramError."""
        if "f" in self.words:
            value = self.words.pop("f")
            if value < 0:
                raise ProgramError(NO_FEED, "F{:g}", value)
            self.typed = value
            self.feed = value if self.feed_mode == 930 else value * self.scale
        elif self.feed_mode == 930 and motion in (10, 20, 30):
            raise ProgramError(NO_FEED, "with G93 each line has an F")

    def _stop_program(self, code):
        """Carry out M0, M1, M2, M30 and M60; return True at the program's end."""
        if code is None:
            return False
        if code in (0, 10, 600):
            self.path.put_word("M1" if code == 10 else "M0")
            return False
        self.path.uncompensate()
        self.path.put_word("M30" if code == 300 else "M2")
        return True

    def not_compensated(self, what):
        """Raise ProgramError while the radius is compensated."""
        if self.path.contour:
            raise ProgramError(COMPENSATED, "{}", what)

    def take_word(self, letter):
        """Take the value of a word that the command needs. Raises ProgramError if it is missing."""
        if letter not in self.words:
            raise ProgramError(MISSING, "{}", letter.upper())
        return self.words.pop(letter)

    def take_whole(self, letter, low=0, high=1_000_000):
        """Take the value of a word that is a whole number within `low` … `high`. Raises ProgramError."""
        if letter not in self.words:
            raise ProgramError(MISSING, "{}", letter.upper())
        value = whole_number(self.words, letter, low, high)
        del self.words[letter]
        return value


MOTIONS_WITH_AXES = {0, 10, 20, 30, *SPLINES, *PROBES, *CYCLES}
