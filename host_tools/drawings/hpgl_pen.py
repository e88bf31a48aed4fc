"""HPGL's instructions, carried out by a pen: lines of each pen, in plotter units (1/40 mm), y up.

    pen = Pen(deviation)            # of curves from their chords
    pen.do("PA", [100, 200])
    pen.finish().inks             # {pen: [Ink]}
"""

import cmath
import math

import numpy

from host_tools.drawings import hpgl_encoded, svg_area
from host_tools.drawings.hpgl_letters import Letters
from host_tools.drawings.hpgl_sheet import Sheet
from host_tools.drawings.page import Ink
from host_tools.drawings.svg_geometry import cubic
from host_tools.language import N_

_MOST_CHORDS = 10_000  # of an arc
_MOST_IN_ALL = 1_000_000


class TooMany(ValueError):
    """Chords of all arcs."""


def _of_sheet(set_up):
    """An instruction that says where later ones lie."""

    def do(pen, given):
        pen._lift()
        set_up(pen.sheet, given)

    return do


def _of_letters(set_up):
    return lambda pen, given: set_up(pen._letters, given)


class Pen:
    def __init__(self, deviation):
        self._deviation = deviation
        self.curved = False  # whether the deviation has counted
        self.inks = {}
        self.sheet = Sheet()
        self.left_out = self.sheet.left_out
        self._number = 1
        self._chords = 0
        self._line = []
        self._reset()

    def _reset(self):
        self._down, self._absolute = False, True
        self._place = 0j  # in plotter units
        self._letters = Letters(self.sheet, self._ink)
        self._polygon = None  # [[places], ...] while one is defined
        self._rings = []
        self._ticks = 0.5, 0.5

    def do(self, name, given):
        """Carry out an instruction of WORDS."""
        self.WORDS[name](self, given)

    def finish(self):
        """Itself, the last line ended."""
        self._lift()
        return self

    # --- lines

    def _lift(self):
        line, self._line = self._line, []
        if len(line) > 1:
            self._ink([numpy.array(line)])

    def _ink(self, lines, areas=()):
        lines, areas = self.sheet.cut_to_window(lines, areas)
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
            self._go(self.sheet.units(x, y) if self._absolute else self._place + self.sheet.units(x, y, True))
            self._mark()

    def _mark(self):
        if self._letters.symbol and self._polygon is None:
            self._letters.mark(self._place)

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

    def _draw_encoded(self, moves):
        """PE: down unless a move says otherwise, and as it was before, behind it."""
        absolute, down = self._absolute, self._down
        for move in moves:
            if isinstance(move, int):
                self._select([move])
                continue
            self._pen(move[0])
            self._absolute = move[1]
            self._moves(move[2:])
        self._absolute = absolute
        self._pen(down)

    def _initialize(self, given):
        self._lift()
        self.sheet.initialize()
        self._reset()

    def _default(self, given):
        self._lift()
        place = self._place
        self.sheet.reset()
        self._reset()
        self._place = place

    # --- curves

    def _swept(self, centre, start, degrees, chord=None, factors=None):
        """Places behind `start` on an arc around `centre`; `chord`: degrees that the file asks for. It is round in the file's own units:
        an ellipse, if a scale differs by axis."""
        self.curved = True
        factors = factors or self.sheet.factors
        way = complex((start - centre).real / factors[0], (start - centre).imag / factors[1])
        radius = abs(way) * max(map(abs, factors))
        if chord:
            step = min(max(abs(chord), 0.36), 180.0)
        else:
            step = math.degrees(2 * math.acos(max(0.0, 1 - min(self._deviation, radius) / radius))) if radius else 360.0
        count = min(max(1, math.ceil(abs(degrees) / max(step, 1e-3) - 1e-6)), _MOST_CHORDS)
        self._chords += count
        if self._chords > _MOST_IN_ALL:
            raise TooMany(_MOST_IN_ALL)
        turned = way * numpy.exp(1j * numpy.radians(numpy.linspace(0.0, degrees, count + 1)))[1:]
        return list(centre + turned.real * factors[0] + 1j * turned.imag * factors[1])

    def _around(self, radius, degrees=0.0):
        """A way from a centre."""
        way = radius * cmath.exp(1j * math.radians(degrees))
        return self.sheet.units(way.real, way.imag, True)

    def _circle(self, given):
        if not given or not given[0]:
            return
        self._lift()
        start = self._place + self._around(given[0])
        self._shape([[start, *self._swept(self._place, start, 360.0, given[1] if len(given) > 1 else None)]])

    def _arc(self, given, relative):
        if len(given) < 3:
            return
        centre = self._place + self.sheet.units(*given[:2], True) if relative else self.sheet.units(*given[:2])
        for place in self._swept(centre, self._place, given[2], given[3] if len(given) > 3 else None):
            self._go(place)

    def _three_points(self, given, relative):
        if len(given) < 4:
            return
        a = self._place
        b, c = (a + self.sheet.units(*given[at : at + 2], True) if relative else self.sheet.units(*given[at : at + 2]) for at in (0, 2))
        u, v = b - a, c - a
        size = 2 * (u.real * v.imag - u.imag * v.real)
        if not size:
            self._go(c)
            return
        middle = a + complex(v.imag * abs(u) ** 2 - u.imag * abs(v) ** 2, u.real * abs(v) ** 2 - v.real * abs(u) ** 2) / size
        sweep = math.degrees(cmath.phase((c - middle) / (a - middle))) % 360
        # Round on the paper: three places make one circle.
        for place in self._swept(middle, a, sweep if size > 0 else sweep - 360, given[4] if len(given) > 4 else None, (1.0, 1.0)):
            self._go(place)

    def _bezier(self, given, relative):
        """BZ and BR: three places a curve; BR's are measured from the curve's begin."""
        self.curved = True
        for at in range(0, len(given) - 5, 6):
            a = self._place
            b, c, d = (self.sheet.units(*given[each : each + 2], relative) + (a if relative else 0) for each in range(at, at + 6, 2))
            for place in cubic(a, b, c, d, self._deviation):
                self._go(place)
            self._mark()

    # --- shapes: `filled` adds the area

    def _shape(self, rings, filled=False):
        if self._polygon is not None:
            whole = [[(place, True) for place in ring] for ring in rings]
            self._polygon[-1:] = [*([self._polygon[-1]] if self._polygon[-1] else []), *whole, []]
            return
        rings = [numpy.array(ring) for ring in rings]
        self._ink(rings, [svg_area.fill_area(rings, "evenodd")] if filled else ())

    def _rectangle(self, given, relative, filled):
        if len(given) < 2:
            return
        self._lift()
        there = self._place + self.sheet.units(*given[:2], True) if relative else self.sheet.units(*given[:2])
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
            self._ink([numpy.array(line) for line in lines], [svg_area.fill_area(rings, "evenodd")] if filled else ())

    # --- text and ticks

    def _label(self, text):
        self._lift()
        self._place = self._letters.label(self._place, text)

    def _cells(self, given):
        self._lift()
        self._place = self._letters.cells(self._place, given)

    def _tick(self, given):
        return [share * self.sheet.span / 100 for share in self._ticks]

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
        "IP": _of_sheet(Sheet.input_ends), "IR": _of_sheet(Sheet.relative_ends), "SC": _of_sheet(Sheet.scale),
        "RO": _of_sheet(Sheet.rotate), "IW": _of_sheet(Sheet.clip), "PS": _of_sheet(Sheet.paper), "PE": _draw_encoded, "CI": _circle,
        "BZ": lambda self, given: self._bezier(given, False), "BR": lambda self, given: self._bezier(given, True),
        "AA": lambda self, given: self._arc(given, False), "AR": lambda self, given: self._arc(given, True),
        "AT": lambda self, given: self._three_points(given, False), "RT": lambda self, given: self._three_points(given, True),
        "EA": lambda self, given: self._rectangle(given, False, False), "ER": lambda self, given: self._rectangle(given, True, False),
        "RA": lambda self, given: self._rectangle(given, False, True), "RR": lambda self, given: self._rectangle(given, True, True),
        "EW": lambda self, given: self._wedge(given, False), "WG": lambda self, given: self._wedge(given, True),
        "PM": _mode, "EP": lambda self, given: self._edges(given, False), "FP": lambda self, given: self._edges(given, True),
        "LB": _label, "CP": _cells, "SI": _of_letters(Letters.absolute_size), "SR": _of_letters(Letters.relative_size),
        "DI": _of_letters(Letters.direction), "DR": _of_letters(Letters.relative_direction), "SL": _of_letters(Letters.set_slant),
        "SM": _of_letters(Letters.set_symbol), "LO": _of_letters(Letters.set_origin),
        "XT": _x_tick, "YT": _y_tick, "TL": _tick_length, "LT": _line_type, "UC": _user_letter, "ES": _of_letters(Letters.set_space),
    }  # fmt: skip
