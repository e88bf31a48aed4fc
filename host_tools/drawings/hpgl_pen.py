"""What HPGL's instructions make of a pen: lines of each pen, in plotter units (1/40 mm), y up.

    pen = Pen(deviation)            # of curves from their chords
    pen.do("PA", [100, 200])
    pen.finished().inks             # {pen: [Ink]}
"""

import cmath
import math
import re
from collections import Counter

import numpy
import shapely
from shapely import affinity

from host_tools.drawings import stroke_font, svg_area
from host_tools.drawings.page import Ink
from host_tools.language import N_

_P2 = 10365 + 7962j  # of an A4 sheet, as HP's plotters have it
_CM = 400.0
_MOST_CHORDS = 10_000


class Pen:
    def __init__(self, deviation):
        self._deviation = deviation
        self.inks = {}
        self.page = None  # (width, height), if the file says so
        self.left_out = Counter()
        self._number = 1
        self._ends = 0j, _P2
        self._turn = 0
        self._line = []
        self._reset()

    def _reset(self):
        self._down, self._absolute = False, True
        self._place = 0j  # in plotter units
        self._scale = None
        self._window = None
        self._size = None  # of a letter, relative to P1 and P2
        self._letter = 0.19 * _CM, 0.27 * _CM
        self._along, self._slant, self._origin = 1 + 0j, 0.0, 1
        self._symbol = ""  # SM: a letter at each place
        self._return, self._labelled = 0j, None  # where a carriage return goes, and where the last label ended
        self._polygon = None  # [[places], ...] while one is defined
        self._rings = []

    def do(self, name, given):
        """Carry out an instruction of WORDS."""
        self.WORDS[name](self, given)

    def finished(self):
        """Itself, the last line ended."""
        self._lift()
        return self

    # --- lines

    def _units(self, x, y, relative=False):
        """A pair of the file's numbers in plotter units; `relative`: a distance."""
        place = complex(x, y)
        if self._scale:
            origin, across, down = self._scale
            place = complex(x * across, y * down) + (0 if relative else origin)
        return place

    def _lift(self):
        line, self._line = self._line, []
        if len(line) > 1:
            self._ink([numpy.array(line)])

    def _ink(self, lines, areas=()):
        if self._turn:
            turned = cmath.exp(1j * math.radians(self._turn))
            lines = [line * turned for line in lines]
            areas = [affinity.rotate(area, self._turn, origin=(0, 0)) for area in areas]
        if self._window:
            lines = svg_area.clipped(lines, self._window)
            areas = [area.intersection(self._window) for area in areas]
        self.inks.setdefault(self._number, []).append(Ink(str(self._number), lines, list(areas)))

    def _go(self, place):
        if self._polygon is not None:
            self._polygon[-1].append((place, self._down))
        elif self._down:
            if len(self._line) < 3:  # none, or the dot of a pen that came down
                self._line = self._line[:1] if len(set(self._line)) == 1 else self._line or [self._place]
            self._line.append(place)
        else:
            self._lift()
        self._place = place

    def _moves(self, given):
        for x, y in zip(given[::2], given[1::2]):
            self._go(self._units(x, y) if self._absolute else self._place + self._units(x, y, True))
            if self._symbol and self._polygon is None:
                self._mark()

    def _pen(self, down):
        if not down:
            self._lift()
        elif self._polygon is None and not self._down:
            self._line = []
        self._down = down

    def _up(self, given):
        self._pen(False)
        self._moves(given)

    def _downs(self, given):
        self._pen(True)
        if not given and self._polygon is None:
            self._line = self._line or [self._place, self._place]
        self._moves(given)

    def _absolutes(self, given):
        self._absolute = True
        self._moves(given)

    def _relatives(self, given):
        self._absolute = False
        self._moves(given)

    def _select(self, given):
        self._lift()
        self._number = int(given[0]) if given else 0

    # --- coordinates

    def _initialize(self, given):
        self._lift()
        self._ends, self._turn = (0j, _P2), 0
        self._reset()

    def _default(self, given):
        self._lift()
        place = self._place
        self._reset()
        self._place = place

    def _input_ends(self, given):
        span = self._ends[1] - self._ends[0]
        if len(given) >= 4:
            self._ends = complex(*given[:2]), complex(*given[2:4])
        elif len(given) >= 2:
            self._ends = complex(*given[:2]), complex(*given[:2]) + span
        else:
            self._ends = 0j, _P2
        self._rescale()

    def _relative_ends(self, given):
        """IR: in per cent of the sheet."""
        width, height = self.page or (_P2.real, _P2.imag)
        if len(given) >= 4:
            x1, y1, x2, y2 = given[:4]
            self._ends = complex(x1 * width, y1 * height) / 100, complex(x2 * width, y2 * height) / 100
        self._rescale()

    def _user(self, given):
        self._user_scale = given if len(given) >= 4 else None
        self._rescale()

    _user_scale = None

    def _rescale(self):
        self._scale = None
        if not self._user_scale:
            return
        (left, right, bottom, top), kind = self._user_scale[:4], self._user_scale[4] if len(self._user_scale) > 4 else 0
        first, span = self._ends[0], self._ends[1] - self._ends[0]
        if kind == 2:  # xmin, factor, ymin, factor
            across, down = right, top
            self._scale = first - complex(left * across, bottom * down), across, down
            return
        if right == left or top == bottom:
            self.left_out[N_("scale without size")] += 1
            return
        across, down = span.real / (right - left), span.imag / (top - bottom)
        if kind == 1:
            share_x, share_y = (self._user_scale[5:7] + [50, 50])[:2] if len(self._user_scale) > 6 else (50, 50)
            least = min(abs(across), abs(down))
            spare = complex(abs(span.real) - least * abs(right - left), abs(span.imag) - least * abs(top - bottom))
            across, down = math.copysign(least, across), math.copysign(least, down)
            first += complex(math.copysign(spare.real, span.real) * share_x / 100, math.copysign(spare.imag, span.imag) * share_y / 100)
        self._scale = first - complex(left * across, bottom * down), across, down

    def _rotate(self, given):
        self._lift()
        self._turn = int(given[0]) if given else 0

    def _clip(self, given):
        self._lift()
        if len(given) < 4:
            self._window = None
            return
        a, b = self._units(*given[:2]), self._units(*given[2:4])
        self._window = shapely.box(min(a.real, b.real), min(a.imag, b.imag), max(a.real, b.real), max(a.imag, b.imag))

    def _sheet(self, given):
        if given:
            self.page = given[0], given[1] if len(given) > 1 else given[0]

    # --- curves

    def _swept(self, centre, start, degrees, chord=None):
        """Places behind `start` on an arc around `centre`; `chord`: degrees that the file asks for. It is round in the file's own units:
        an ellipse, if a scale differs by axis."""
        factors = self._scale[1:] if self._scale else (1.0, 1.0)
        way = complex((start - centre).real / factors[0], (start - centre).imag / factors[1])
        radius = abs(way) * max(map(abs, factors))
        if chord:
            step = min(max(abs(chord), 0.36), 180.0)
        else:
            step = math.degrees(2 * math.acos(max(0.0, 1 - min(self._deviation, radius) / radius))) if radius else 360.0
        count = min(max(1, math.ceil(abs(degrees) / max(step, 1e-3) - 1e-6)), _MOST_CHORDS)
        turned = way * numpy.exp(1j * numpy.radians(numpy.linspace(0.0, degrees, count + 1)))[1:]
        return list(centre + turned.real * factors[0] + 1j * turned.imag * factors[1])

    def _around(self, radius, degrees=0.0):
        """A way from a centre."""
        way = radius * cmath.exp(1j * math.radians(degrees))
        return self._units(way.real, way.imag, True)

    def _circle(self, given):
        if not given or not given[0]:
            return
        self._lift()
        start = self._place + self._around(given[0])
        self._shape([[start, *self._swept(self._place, start, 360.0, given[1] if len(given) > 1 else None)]])

    def _arc(self, given, relative):
        if len(given) < 3:
            return
        centre = self._place + self._units(*given[:2], True) if relative else self._units(*given[:2])
        for place in self._swept(centre, self._place, given[2], given[3] if len(given) > 3 else None):
            self._go(place)

    def _three_points(self, given, relative):
        if len(given) < 4:
            return
        a = self._place
        b, c = (a + self._units(*given[at : at + 2], True) if relative else self._units(*given[at : at + 2]) for at in (0, 2))
        u, v = b - a, c - a
        size = 2 * (u.real * v.imag - u.imag * v.real)
        if not size:
            self._go(c)
            return
        middle = a + complex(v.imag * abs(u) ** 2 - u.imag * abs(v) ** 2, u.real * abs(v) ** 2 - v.real * abs(u) ** 2) / size
        sweep = math.degrees(cmath.phase((c - middle) / (a - middle))) % 360
        scale, self._scale = self._scale, None  # round on the paper: three places make one circle
        arc = self._swept(middle, a, sweep if size > 0 else sweep - 360, given[4] if len(given) > 4 else None)
        self._scale = scale
        for place in arc:
            self._go(place)

    # --- shapes: `filled` adds the area

    def _shape(self, rings, filled=False):
        if self._polygon is not None:
            whole = [[(place, True) for place in ring] for ring in rings]
            self._polygon[-1:] = [*([self._polygon[-1]] if self._polygon[-1] else []), *whole, []]
            return
        rings = [numpy.array(ring) for ring in rings]
        self._ink(rings, [svg_area.filled(rings, "evenodd")] if filled else ())

    def _rectangle(self, given, relative, filled):
        if len(given) < 2:
            return
        self._lift()
        there = self._place + self._units(*given[:2], True) if relative else self._units(*given[:2])
        a, c = self._place, there
        self._shape([[a, complex(c.real, a.imag), c, complex(a.real, c.imag), a]], filled)

    def _wedge(self, given, filled):
        if len(given) < 3:
            return
        self._lift()
        start = self._place + self._around(given[0], given[1])
        arc = self._swept(self._place, start, given[2], given[3] if len(given) > 3 else None)
        self._shape([[self._place, start, *arc, self._place]], filled)

    def _mode(self, given):
        mode = int(given[0]) if given else 0
        if mode == 0:
            self._lift()
            self._polygon, self._begun = [[(self._place, False)]], (self._place, self._down)
        elif self._polygon is not None:
            if self._polygon[-1]:
                self._polygon[-1].append((self._polygon[-1][0][0], self._down))
            if mode == 1:
                self._polygon.append([])
            else:
                self._rings = [ring for ring in self._polygon if len(ring) > 2]
                self._polygon, (self._place, self._down) = None, self._begun

    def _edges(self, given, filled):
        """The polygon that was defined; of its edges those that were gone with the pen down."""
        self._lift()
        lines = []
        for ring in self._rings:
            for (start, _), (end, down) in zip(ring, ring[1:]):
                if down and lines and lines[-1][-1] == start:
                    lines[-1].append(end)
                elif down:
                    lines.append([start, end])
        rings = [numpy.array([place for place, _ in ring]) for ring in self._rings]
        if lines or filled and rings:
            self._ink([numpy.array(line) for line in lines], [svg_area.filled(rings, "evenodd")] if filled else ())

    # --- text

    def _label(self, text):
        """A line feed goes one line down, a carriage return to where labels have begun since the pen was moved, or DI turned them."""
        self._lift()
        width, height = self._size_of_letters()
        if self._place != self._labelled:
            self._return = self._place
        row, column = (self._origin - 1) % 10 % 3, (self._origin - 1) % 10 // 3
        for line in re.split("([\r\n])", text):
            if line == "\r":
                self._place = self._return
            elif line == "\n":
                self._place -= self._along * 2j * height
                self._return -= self._along * 2j * height
            elif line:
                long = len(line) * 1.5 * width - 0.5 * width
                back = complex(-(long / 2, long)[column - 1] if column else 0.0, -height * row / 2)
                if self._origin > 10:
                    back += complex((0.5, 0.0, -0.5)[column] * width, (0.5, 0.0, -0.5)[row] * height)
                for number, each in enumerate(line):
                    self._write(each, self._place, back + number * 1.5 * width, width, height)
                self._place += self._along * (back + len(line) * 1.5 * width)
        self._labelled = self._place

    def _write(self, each, at, shift, width, height):
        strokes = stroke_font.letter(each)
        if strokes is None:
            self.left_out[N_("letter that the pen's font has not")] += 1
            return
        for stroke in strokes:
            x = stroke.real * width + width / 2 + stroke.imag * height * self._slant
            self._ink([at + self._along * (shift + x + 1j * stroke.imag * height)])

    def _mark(self):
        """The symbol of SM, its middle on the pen's place, also of low and slanted letters."""
        width, height = self._size_of_letters()
        heights = numpy.concatenate(stroke_font.letter(self._symbol) or [numpy.zeros(1, complex)]).imag
        middle = height * (heights.min() + heights.max()) / 2
        self._write(self._symbol, self._place, complex(-width / 2 - self._slant * middle, -middle), width, height)

    def _size_of_letters(self):
        if self._size is None:
            return self._letter
        span = self._ends[1] - self._ends[0]
        return abs(span.real) * self._size[0] / 100, abs(span.imag) * self._size[1] / 100

    def _absolute_size(self, given):
        self._size, self._letter = None, (0.19 * _CM, 0.27 * _CM) if len(given) < 2 else (given[0] * _CM, given[1] * _CM)

    def _relative_size(self, given):
        self._size = tuple(given[:2]) if len(given) > 1 else (0.75, 1.5)

    def _direction(self, given, relative=False):
        along = complex(*given[:2]) if len(given) > 1 else 1 + 0j
        if relative:
            span = self._ends[1] - self._ends[0]
            along = complex(along.real * span.real, along.imag * span.imag)
        self._along = along / abs(along) if along else 1 + 0j
        self._labelled = None

    def _set_symbol(self, symbol):
        self._symbol = symbol.strip()

    def _set_slant(self, given):
        self._slant = given[0] if given else 0.0

    def _set_origin(self, given):
        self._origin = int(given[0]) if given else 1

    def _cells(self, given):
        """CP: move by cells of letters; without numbers to the next line."""
        self._label("" if given else "\r\n")
        width, height = self._size_of_letters()
        across, up = (given + [0, 0])[:2]
        self._place += self._along * complex(across * 1.5 * width, up * 2 * height)
        self._return += self._along * 2j * up * height
        self._labelled = self._place

    def _tick(self, given):
        length = getattr(self, "_ticks", (0.5, 0.5))
        span = self._ends[1] - self._ends[0]
        return [share * span / 100 for share in length]

    def _x_tick(self, given):
        up, down = self._tick(given)
        self._ink([numpy.array([self._place - 1j * down.imag, self._place + 1j * up.imag])])

    def _y_tick(self, given):
        up, down = self._tick(given)
        self._ink([numpy.array([self._place - down.real, self._place + up.real])])

    def _tick_length(self, given):
        self._ticks = ((given + [0.0])[:2]) if given else (0.5, 0.5)

    def _line_type(self, given):
        if given:
            self.left_out[N_("line type (drawn without gaps)")] += 1

    def _user_letter(self, given):
        self.left_out[N_("letter of the file's own")] += 1

    WORDS = {
        "IN": _initialize, "DF": _default, "PU": _up, "PD": _downs, "PA": _absolutes, "PR": _relatives, "SP": _select,
        "IP": _input_ends, "IR": _relative_ends, "SC": _user, "RO": _rotate, "IW": _clip, "PS": _sheet, "CI": _circle,
        "AA": lambda self, given: self._arc(given, False), "AR": lambda self, given: self._arc(given, True),
        "AT": lambda self, given: self._three_points(given, False), "RT": lambda self, given: self._three_points(given, True),
        "EA": lambda self, given: self._rectangle(given, False, False), "ER": lambda self, given: self._rectangle(given, True, False),
        "RA": lambda self, given: self._rectangle(given, False, True), "RR": lambda self, given: self._rectangle(given, True, True),
        "EW": lambda self, given: self._wedge(given, False), "WG": lambda self, given: self._wedge(given, True),
        "PM": _mode, "EP": lambda self, given: self._edges(given, False), "FP": lambda self, given: self._edges(given, True),
        "LB": _label, "SI": _absolute_size, "SR": _relative_size, "DI": _direction,
        "DR": lambda self, given: self._direction(given, True), "SL": _set_slant, "SM": _set_symbol, "LO": _set_origin, "CP": _cells,
        "XT": _x_tick, "YT": _y_tick, "TL": _tick_length, "LT": _line_type, "UC": _user_letter, "ES": lambda self, given: None,
    }  # fmt: skip
