"""HPGL's labels and symbols as single lines: their size, direction, slant and origin."""

import re

import numpy

from host_tools.drawings import stroke_font
from host_tools.language import N_

_CM = 400.0  # in plotter units


class Letters:
    """Draws labels. `place`, the pen's position, is an argument and a result: the letters move it."""

    def __init__(self, sheet, ink):
        """`ink(lines)` is called with the lines to draw."""
        self._sheet, self._ink = sheet, ink
        self._size = None  # of a letter, relative to P1 and P2
        self._letter = 0.19 * _CM, 0.27 * _CM
        self._along, self._slant, self._origin = 1 + 0j, 0.0, 1
        self._space = 0.0, 0.0  # ES: more between letters and lines, in cells
        self.symbol = ""  # SM: a letter at each place
        self._return, self._labelled = 0j, None  # targets of a carriage return; end of the last label

    def draw_label(self, place, text):
        """Draw `text` and return where the pen is behind it. A line feed goes one line down, a carriage return to where labels have
        begun since the pen was moved, or DI turned them; a backspace goes back by a letter, as to strike out a zero."""
        width, height = self._size_of_letters()
        advance, down = self._cell_size()
        if place != self._labelled:
            self._return = place
        row, column = (self._origin - 1) % 10 % 3, (self._origin - 1) % 10 // 3
        for line in re.split("([\r\n])", text):
            if line == "\r":
                place = self._return
            elif line == "\n":
                place -= self._along * 1j * down
                self._return -= self._along * 1j * down
            elif line:
                cells, behind = _cells_of(line)
                long = (max([behind, *(cell + 1 for _, cell in cells)])) * advance - (advance - width)
                back = complex(-(long / 2, long)[column - 1] if column else 0.0, -height * row / 2)
                if self._origin > 10:
                    back += complex((0.5, 0.0, -0.5)[column] * width, (0.5, 0.0, -0.5)[row] * height)
                for each, cell in cells:
                    self._write_letter(each, place, back + cell * advance, width, height)
                place += self._along * (back + behind * advance)
        self._labelled = place
        return place

    def move_cells(self, place, given):
        """CP: move by cells of letters; without numbers to the next line. Returns where."""
        place = self.draw_label(place, "" if given else "\r\n")
        advance, down = self._cell_size()
        across, up = (given + [0, 0])[:2]
        place += self._along * complex(across * advance, up * down)
        self._return += self._along * 1j * up * down
        self._labelled = place
        return place

    def draw_symbol(self, place):
        """Draw the symbol of SM with its middle on the pen's position, also the symbols of low and slanted letters."""
        width, height = self._size_of_letters()
        heights = numpy.concatenate(stroke_font.letter_strokes(self.symbol) or [numpy.zeros(1, complex)]).imag
        middle = height * (heights.min() + heights.max()) / 2
        self._write_letter(self.symbol, place, complex(-width / 2 - self._slant * middle, -middle), width, height)

    def _write_letter(self, each, at, shift, width, height):
        """Draw one letter: `at`, the pen's position, `shift` along and above the line, `width` and `height` in plotter units. A letter that the font
        has not goes to `left_out`."""
        strokes = stroke_font.letter_strokes(each)
        if strokes is None:
            self._sheet.left_out[N_("letter that the pen's font has not")] += 1
            return
        for stroke in strokes:
            x = stroke.real * width + width / 2 + stroke.imag * height * self._slant
            self._ink([at + self._along * (shift + x + 1j * stroke.imag * height)])

    def _cell_size(self):
        """Return (distance to the next letter, distance to the next line), in plotter units."""
        width, height = self._size_of_letters()
        return 1.5 * width * (1 + self._space[0]), 2 * height * (1 + self._space[1])

    def _size_of_letters(self):
        """Return (width, height) of a letter in plotter units: those of SI, or of SR as parts of the way from P1 to P2."""
        if self._size is None:
            return self._letter
        span = self._sheet.span
        return abs(span.real) * self._size[0] / 100, abs(span.imag) * self._size[1] / 100

    # --- instructions

    def set_absolute_size(self, given):
        self._size, self._letter = None, (0.19 * _CM, 0.27 * _CM) if len(given) < 2 else (given[0] * _CM, given[1] * _CM)

    def set_relative_size(self, given):
        self._size = tuple(given[:2]) if len(given) > 1 else (0.75, 1.5)

    def set_relative_direction(self, given):
        """DR: set the direction, in per cent of the way from P1 to P2."""
        span = self._sheet.span
        self.set_direction([given[0] * span.real, given[1] * span.imag] if len(given) > 1 else [span.real, 0.0])

    def set_direction(self, given):
        along = complex(*given[:2]) if len(given) > 1 else 1 + 0j
        self._along = along / abs(along) if along else 1 + 0j
        self._labelled = None

    def set_symbol(self, symbol):
        self.symbol = symbol.strip()

    def set_space(self, given):
        self._space = tuple((given + [0.0, 0.0])[:2])

    def set_slant(self, given):
        self._slant = given[0] if given else 0.0

    def set_origin(self, given):
        self._origin = int(given[0]) if given else 1


def _cells_of(line):
    """Return ([(letter, its cell)] of a line with backspaces, the cell behind them)."""
    found, cell = [], 0
    for each in line:
        if each == "\b":
            cell -= 1
        else:
            found.append((each, cell))
            cell += 1
    return found, cell
