"""Programs with Z for machines of two axes: Z is left out, or lifts a pen.

    rows = without_z(program.rows())            # Raises Failure if the tool stays on while Z rises
    rows = without_z(program.rows(), 0.0)       # Z above 0.0 mm: tool off, at 0.0 and below: as the program switches it

The firmware's parser says where Z goes; lines that it refuses are left to the machine.
"""

import re
from functools import partial

from host_tools.failure import Failure
from host_tools.programs.replay_machine import NM, Board, Machine, Memory, commands_of
from passo.protocols.gcode.offsets import TOOL_AXIS, Offsets
from passo.protocols.gcode.parser import GCode

_STEPS_PER_MM = 1000
_Z = re.compile(rb"[Zz][-+\d. ]+")
_TOOL = re.compile(rb"[Mm]0*[345](?![\d.])")
_OTHERS = re.compile(rb"[XYAxya]")
_OFF = 5  # M5


class _Heights:
    """Follows Z and the tool of a program."""

    def __init__(self):
        machine = Machine([_STEPS_PER_MM] * 4, 0.0, True, False, 1e6)
        self._board = Board(machine)
        self._gcode = GCode("xyza", Offsets(4, Memory(machine)), self._board)
        self._gcode.turns = 1

    def z_mm(self):
        """Return Z of the program, in mm."""
        return self._board.target[TOOL_AXIS] / _STEPS_PER_MM - self._gcode.offsets.offset_of(self._gcode.system, TOOL_AXIS) / NM

    def spindle(self):
        """Return 3, 4 or 5, the spindle's state by the program; 5 without S."""
        return self._gcode.spindle if self._gcode.rpm else _OFF

    def carry_out(self, line):
        """Carry out a line. Returns True if Z rises at any moment of it."""
        if line[:1] == b"$" or self._gcode.interpret_line(line):
            return False
        rises = False
        for command in commands_of(self._gcode.commands):
            if command.target is not None:
                rises = rises or command.target[TOOL_AXIS] > self._board.target[TOOL_AXIS]
                self._board.target = list(command.target)
        return rises


def without_z(rows, pen=None):
    """Yield rows (number, bytes) without Z. `pen`: Z above this height, mm of the program, lifts the pen, else it is down; None: Z means nothing.
    Raises Failure at the first line in which Z rises with the tool on, if there is no pen, and at the end if there is a pen that no line
    switches."""
    heights = _Heights()
    shown = _OFF
    switched = False
    for number, line in rows:
        before = heights.z_mm()
        rises = heights.carry_out(line)
        spindle = heights.spindle()
        if pen is None:
            if rises and spindle != _OFF:
                raise Failure(
                    "line {}, {}: the tool stays on while Z rises, and would go on without Z; if Z lifts a pen, give --z-pen 0: above 0 mm it is up",
                    number, line.decode("ascii", "replace"),
                )  # fmt: skip
            yield from _rows_of(number, _drop_z(line))
            continue
        switched = switched or spindle != _OFF
        text = _drop_z(line if line[:1] == b"$" else _TOOL.sub(b"", line))
        for height, row in ((max(before, heights.z_mm()), text), (heights.z_mm(), b"")):
            wanted = spindle if height <= pen else _OFF
            if wanted != shown:
                yield number, b"M%d" % wanted
                shown = wanted
            yield from _rows_of(number, row)
    if pen is not None and not switched:
        raise Failure("the program switches no tool on (M3 S…), so that no pen comes down")


def leave_out_z(program, drop, pen):
    """Make a program's rows come without Z, if `drop` or a `pen` asks for that."""
    if drop or pen is not None:
        program.flat = partial(without_z, pen=pen)


def refuse_z(program, has_z):
    """Raise Failure if Z is left out for a machine that has it."""
    if program.flat and has_z:
        raise Failure("the machine has a Z axis: --drop-z and --z-pen are for machines without one")


def _drop_z(line):
    """Return a line without Z; where a command wants an axis word, with Z0, which moves nothing."""
    if line[:1] == b"$" or not _Z.search(line):
        return line
    text = _Z.sub(b"", line)
    return text if _OTHERS.search(text) else _Z.sub(b"Z0", line)


def _rows_of(number, text):
    return [(number, text)] if text else []
