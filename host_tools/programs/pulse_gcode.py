"""A pulse file as G-code: straight runs and arcs recognised, waits, speeds and the tool in their places.

    text, counts = to_gcode(items, board)       # items as pulse_file.items() gives them
    text, counts = to_gcode(items, board, (LEFT, 1.5))      # the tool's centre 1.5 mm to the left of what was taught

pulse_file.Converter makes the same steps of the G-code: to_gcode() checks that itself. With a tool's radius each contour, from tool on
to tool off, is compensated (compensation.py); the motions between two contours lead from the end of one to the start of the next.

`+2000` becomes F2000, `$` rapid moves (G0), `@` the board file's speed, `*5000` G4 P5, `+0` M0, `(` and `)` M3 and M5. G-code
has no word for the drives: `[` and `]` become comments.
"""

import numpy as np

from host_tools.failure import Failure
from host_tools.programs import pulse_file
from host_tools.programs.recognition import pieces
from passo.options.step_program.commands import STEPS_ASK, STEPS_DEFAULT, STEPS_DRIVES, STEPS_SPEED, STEPS_TOOL, STEPS_WAIT


def to_gcode(found, board, beside=None):
    """Return (text, {"lines": …, "arcs": …, "steps": …}) of a file's items. `beside`: (LEFT or RIGHT, the tool's radius in mm); None: no
    compensation. Raises Failure if there is not a step in it, or a contour cannot be compensated."""
    writer = _Writer(board) if beside is None else _Compensated(board, *beside)
    for kind, value in _group_runs(found, len(board["axes"][:3])):
        writer.add_item(kind, value)
    if not writer.counts["steps"]:
        raise Failure("the file has no step")
    text = writer.gcode_text()
    if beside is None:
        _prove_steps(text, found, board)
    return text, writer.counts


def moves_of(items, axes):
    """Return the steps of items (of runs only) as an array of steps × axes, each −1, 0 or 1."""
    items = np.array(items, np.int64)
    counts = items >> 8
    rows = np.stack([((items >> axis) & 1) * (1 - 2 * ((items >> (4 + axis)) & 1)) for axis in range(axes)], axis=1)
    return np.repeat(rows.astype(np.int8), counts, axis=0)


def _group_runs(found, axes):
    """Yield ("steps", moves) and (kind, value) of marks, in their order. A code that changes neither a step's speed nor the tool does not part
    steps."""
    steps = []
    for item in found:
        if item & 15:
            steps.append(item)
            continue
        if steps:
            yield "steps", moves_of(steps, axes)
            steps = []
        yield item >> 4 & 15, item >> 8
    if steps:
        yield "steps", moves_of(steps, axes)


class _Writer:
    def __init__(self, board):
        axes = board["axes"][:3]
        self._names = "XYZ"[: len(axes)]
        self._scale = [axis["steps_per_m"] / 1000 for axis in axes]
        self._equal = len({axis["steps_per_m"] for axis in axes[:2]}) == 1
        self._default = board["step_program"]["default_mm_min"]
        self._speed = self._default  # None: as fast as it goes
        self._written = None  # F
        self._at = [0] * len(axes)
        self._lines = ["G21 G90 G94 G17"]
        self._plane = (0, 1)
        self.counts = {"lines": 0, "arcs": 0, "steps": 0}

    def add_item(self, kind, value):
        """Append the lines of steps, or of a mark: tool on or off (a value of 0), wait in ms, drives, a question as M0, or a speed in mm/min."""

        if kind == "steps":
            for piece in pieces(value, self._equal):
                self._add_piece(piece)
        elif kind == STEPS_TOOL:
            self._lines.append("M3 S1000" if value else "M5")
        elif kind == STEPS_WAIT:
            self._lines.append(f"G4 P{value / 1000:g}")
        elif kind == STEPS_DRIVES:
            self._lines.append("(drives on)" if value else "(drives off)")
        elif kind == STEPS_ASK:
            self._lines.append("M0")
        else:
            self._speed = {STEPS_SPEED: value, STEPS_DEFAULT: self._default}.get(kind)

    def _add_piece(self, piece):
        """Append G0, G1 or an arc to the end of a piece, and count its steps. G0 if there is no speed in force."""
        self._at = [at + delta for at, delta in zip(self._at, piece.deltas)]
        self.counts["steps"] += piece.count
        self.counts["arcs" if piece.centre else "lines"] += 1
        if piece.centre:
            self._add_arc(piece)
            return
        words = "".join(f" {name}{self._mm_text(axis)}" for axis, name in enumerate(self._names) if piece.deltas[axis])
        if self._speed is None:
            self._lines.append("G0" + words)
        else:
            self._lines.append("G1" + words + self._feed_word(self._speed))

    def _add_arc(self, piece):
        """Append G2 or G3, in mm, behind the word of its plane if that is another one. Without a speed in force the feed is 900 000 mm/min."""
        if piece.plane != self._plane:
            self._plane = piece.plane
            self._lines.append({(0, 1): "G17", (2, 0): "G18", (1, 2): "G19"}[piece.plane])
        words = "".join(f" {self._names[axis]}{self._mm_text(axis)}" for axis in sorted(piece.plane))
        centre = "".join(
            f" {'IJK'[axis]}{_number_text(steps / self._scale[axis])}" for axis, steps in sorted(zip(piece.plane, piece.centre))
        )
        speed = self._speed or 900_000  # there are no rapid arcs: the fastest that a file can ask for
        self._lines.append(("G2" if piece.clockwise else "G3") + words + centre + self._feed_word(speed))

    def _feed_word(self, speed):
        """Return the F word of a speed in mm/min, "" if it is in force already."""
        if speed == self._written:
            return ""
        self._written = speed
        return f" F{speed}"

    def _mm_text(self, axis):
        return _number_text(self._at[axis] / self._scale[axis])

    def gcode_text(self):
        return "\n".join([*self._lines, "M2"]) + "\n"


class _Compensated(_Writer):
    """Collects contours, and writes the path of the tool's centre beside them."""

    def __init__(self, board, side, radius):
        _Writer.__init__(self, board)
        if not self._equal or len(self._scale) < 2:
            raise Failure("X and Y differ in steps/mm: a tool's radius would be none")
        self._side, self._radius = side, radius
        self._contour = None  # [(Piece, speed)] while the tool is on
        self._travel = self._z = None  # lines with the last travel since the last contour, and the last move of Z

    def add_item(self, kind, value):
        """Add steps or a mark: with the tool on, steps are collected as a contour, which is written when it goes off. Raises Failure at a wait or a
        question for the speed amid a contour."""

        if kind == STEPS_TOOL and value:
            self._contour = self._contour or []
        elif kind == STEPS_TOOL:
            self._write_contour()
            _Writer.add_item(self, kind, value)
        elif self._contour and kind in (STEPS_WAIT, STEPS_ASK):
            raise Failure("a wait, or a question for the speed, in the middle of a contour: it cannot be compensated")
        else:
            _Writer.add_item(self, kind, value)

    def _add_piece(self, piece):
        """Add a line or an arc to the contour; outside of one it is a travel, of which the last position counts, or a move of Z. Raises Failure if Z
        moves amid a contour."""
        from host_tools.programs import compensation

        start = self._tool_xy()
        self._at = [at + delta for at, delta in zip(self._at, piece.deltas)]
        self.counts["steps"] += piece.count
        if any(piece.deltas[2:]) or piece.centre and piece.plane != (0, 1):
            if self._contour or self._contour is not None and any(piece.deltas[:2]):
                raise Failure("Z moves in the middle of a contour: it cannot be compensated")
            aside = any(piece.deltas[:2])
            self._travel, self._z = (None, None) if aside else (self._travel, len(self._lines))
            place = f" X{self._mm_text(0)} Y{self._mm_text(1)}" if aside else ""
            self._lines.append(f"G1{place} Z{self._mm_text(2)}" + self._feed_word(self._speed or 900_000))
            return
        if self._contour is None:
            if self._travel is None or self._z is not None and self._z > self._travel:
                self._travel = len(self._lines)
                self._lines.append("")
            self._lines[self._travel] = f"G0 X{self._mm_text(0)} Y{self._mm_text(1)}"  # unless the next contour sets out from here
            return
        centre = None
        if piece.centre:
            centre = start + complex(piece.centre[0] / self._scale[0], piece.centre[1] / self._scale[1])
        whole = centre is not None and start == self._tool_xy()
        self._contour.append((compensation.Piece(start, self._tool_xy(), centre, piece.clockwise, whole), self._speed))

    def gcode_text(self):
        """Write the contour under way, remove a last travel that leads nowhere, and return the G-code."""
        self._write_contour()  # the tool may be on to the last
        if self._travel is not None and (self._z is None or self._z < self._travel):
            del self._lines[self._travel]  # it leads nowhere
        return _Writer.gcode_text(self)

    def _put_lead(self, line):
        """Put the way to the next contour in place of the last travel, so that Z goes down where it did; without a travel, before Z's last move."""
        if self._travel is not None:
            self._lines[self._travel] = line
        else:
            self._lines.insert(len(self._lines) if self._z is None else self._z, line)
        self._travel = self._z = None

    def _tool_xy(self):
        return complex(self._at[0] / self._scale[0], self._at[1] / self._scale[1])

    def _write_contour(self):
        """Append the compensated contour, from M3 on, with the way to it in place of the last travel. Raises Failure if the tool does not fit, or
        would cut into the contour."""
        from host_tools.programs import compensation
        from host_tools.programs.program_errors import ProgramError
        from host_tools.programs.toolpath import round_end

        contour, self._contour = self._contour, None
        if not contour:
            return
        contour = _from_amid(contour)
        pieces = [piece for piece, _ in contour]
        try:
            path = list(compensation.offset_contour(pieces, self._side, self._radius))
        except ProgramError as error:
            raise Failure("a contour that begins at {}: {}", _xy_words(pieces[0].start), error) from error
        too_near = compensation.gouges([piece for piece, _ in path], pieces, self._radius)
        if too_near:
            near = path[too_near[0][0]][0].start
            raise Failure("the tool would cut into its own contour near {}: its radius of {:g} mm is too large", _xy_words(near), self._radius)
        first = path[0][0].start
        self._put_lead(f"G0 X{_number_text(first.real)} Y{_number_text(first.imag)}")
        self._lines.append("M3 S1000")
        here = _listing_units(first)
        for piece, number in path:
            word, centre, end = "G1", "", _listing_units(piece.end)
            if piece.centre is not None:
                middle = _listing_units(piece.centre - piece.start)
                last = round_end(here, end, middle, piece.clockwise, piece.sweep)
                if last is not None:
                    word, end = "G2" if piece.clockwise else "G3", last
                    centre = f" I{_number_text(middle[0] / 1e5)} J{_number_text(middle[1] / 1e5)}"
            self.counts["arcs" if centre else "lines"] += 1
            here = end
            self._lines.append(f"{word} X{_number_text(end[0] / 1e5)} Y{_number_text(end[1] / 1e5)}{centre}" + self._feed_word(contour[number][1] or 900_000))


def _from_amid(contour):
    """Return a closed contour that begins in the middle of its first line: there its ends meet without a corner. Other contours stay."""
    from host_tools.programs.compensation import SMALL, Piece

    piece, speed = contour[0]
    if abs(contour[-1][0].end - piece.start) > SMALL or piece.centre is not None or len(contour) < 3:
        return contour
    middle = (piece.start + piece.end) / 2
    return [(Piece(middle, piece.end), speed), *contour[1:], (Piece(piece.start, middle), speed)]


def _listing_units(place):
    return round(place.real * 1e5), round(place.imag * 1e5)


def _xy_words(place):
    return f"X{_number_text(place.real)} Y{_number_text(place.imag)}"


def _number_text(mm):
    return f"{round(mm, 5) + 0.0:.5f}".rstrip("0").rstrip(".")


def _prove_steps(text, found, board):
    """Raise Failure if the G-code would not make the same steps."""
    from host_tools.programs.program_lines import strip_line

    lines = [(number, strip_line(line)) for number, line in enumerate(text.encode().splitlines(), 1)]
    back = pulse_file.Converter(board).convert([row for row in lines if row[1]])
    axes = "xyz"[: len(board["axes"][:3])]
    made = pulse_file.read_items(back.encode(), axes, board["step_program"])
    if not same_steps(found, made, len(axes)):
        raise Failure("the G-code would not make the same steps: this is a fault of passo")


def same_steps(one, other, axes):
    """True if two files' items make the same steps in the same order."""
    one, other = (moves_of([item for item in items if item & 15], axes) for items in (one, other))
    return np.array_equal(one, other)
