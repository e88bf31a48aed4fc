"""HPGL's instructions, carried out by a pen: lines of each pen, in plotter units (1/40 mm), y up.

    pen = Pen(deviation)            # of curves from their chords
    pen.set_up_sheet("PA", [100, 200])
    pen.finish_line().inks             # {pen: [Ink]}
"""

import cmath
import math

import numpy

from host_tools.drawings import hpgl_encoded, svg_area
from host_tools.drawings.hpgl_letters import Letters
from host_tools.drawings.hpgl_sheet import Sheet
from host_tools.drawings.page import Ink
from host_tools.drawings.svg_geometry import flatten_cubic
from host_tools.language import N_

_MOST_CHORDS = 10_000  # of an arc
_MOST_IN_ALL = 1_000_000


class TooMany(ValueError):
    """The chords of all arcs are too many."""


def _of_sheet(set_up):
    """Return a handler of an instruction that sets up the sheet."""

    def set_up_sheet(pen, given):
        pen._lift_pen()
        set_up(pen.sheet, given)

    return set_up_sheet


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
        self._reset_state()

    def _reset_state(self):
        """Set the defaults of the pen: up, absolute positions, at 0;0, letters of the usual size, no polygon."""
        self._down, self._absolute = False, True
        self._place = 0j  # in plotter units
        self._letters = Letters(self.sheet, self._add_ink)
        self._polygon = None  # [[places], ...] while one is defined
        self._rings = []
        self._ticks = 0.5, 0.5

    def run_instruction(self, name, given):
        """Carry out an instruction of WORDS."""
        self.WORDS[name](self, given)

    def finish_line(self):
        """End the line under way, and return the pen itself."""
        self._lift_pen()
        return self

    # --- lines

    def _lift_pen(self):
        line, self._line = self._line, []
        if len(line) > 1:
            self._add_ink([numpy.array(line)])

    def _add_ink(self, lines, areas=()):
        lines, areas = self.sheet.cut_to_window(lines, areas)
        self.inks.setdefault(self._number, []).append(Ink(str(self._number), lines, list(areas)))

    def _move_to(self, place):
        """Move the pen to a position, in plotter units: add the position to the polygon under way, or to the line if the pen is down; with the pen up
        end the line."""
        if self._polygon is not None:
            self._polygon[-1].append((place, self._down))
        elif self._down:
            if len(self._line) < 3:  # none, or the dot of a pen that came down
                self._line = self._line[:1] if len(set(self._line)) == 1 else self._line or [self._place]
            self._line.append(place)
        else:
            self._lift_pen()
        self._place = place

    def _move_through(self, given):
        for x, y in zip(given[::2], given[1::2]):
            self._move_to(self.sheet.to_plotter_units(x, y) if self._absolute else self._place + self.sheet.to_plotter_units(x, y, True))
            self._mark_symbol()

    def _mark_symbol(self):
        if self._letters.symbol and self._polygon is None:
            self._letters.draw_symbol(self._place)

    def _set_pen(self, down):
        """Raise or lower the pen. Raised it ends the line under way; lowered outside of a polygon it begins a new one."""
        if not down:
            self._lift_pen()
        elif self._polygon is None and not self._down:
            self._line = []
        self._down = down

    def _pen_up(self, given):
        self._set_pen(False)
        self._move_through(given)

    def _pen_down(self, given):
        """PD: lower the pen and draw to the positions; without numbers leave a dot."""
        self._set_pen(True)
        if not given and self._polygon is None:
            self._line = self._line or [self._place, self._place]
        self._move_through(given)

    def _plot_absolute(self, given):
        self._absolute = True
        self._move_through(given)

    def _plot_relative(self, given):
        self._absolute = False
        self._move_through(given)

    def _select_pen(self, given):
        self._lift_pen()
        self._number = int(given[0]) if given else 0

    def _draw_encoded(self, moves):
        """PE: draw with the pen down unless a move says otherwise. Behind it the pen is as it was before."""
        absolute, down = self._absolute, self._down
        for move in moves:
            if isinstance(move, int):
                self._select_pen([move])
                continue
            self._set_pen(move[0])
            self._absolute = move[1]
            self._move_through(move[2:])
        self._absolute = absolute
        self._set_pen(down)

    def _initialize_all(self, given):
        self._lift_pen()
        self.sheet.initialize()
        self._reset_state()

    def _set_defaults(self, given):
        """DF: reset the sheet and the pen's state; the pen stays at its position."""
        self._lift_pen()
        place = self._place
        self.sheet.reset()
        self._reset_state()
        self._place = place

    # --- curves

    def _arc_positions(self, centre, start, degrees, chord=None, factors=None):
        """Return the positions behind `start` on an arc around `centre`; `chord`: degrees that the file asks for. The arc is round in the file's
        units, and an ellipse if the scale differs by axis."""
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

    def _offset_from_centre(self, radius, degrees=0.0):
        """Return the vector from a centre to a point at this radius and angle, in plotter units."""
        way = radius * cmath.exp(1j * math.radians(degrees))
        return self.sheet.to_plotter_units(way.real, way.imag, True)

    def _draw_circle(self, given):
        """CI: draw a circle around the pen's position: radius in the file's units, then the degrees of a chord, if given. The pen stays."""
        if not given or not given[0]:
            return
        self._lift_pen()
        start = self._place + self._offset_from_centre(given[0])
        self._draw_shape([[start, *self._arc_positions(self._place, start, 360.0, given[1] if len(given) > 1 else None)]])

    def _draw_arc(self, given, relative):
        """AA and AR: draw an arc around a centre: its two numbers, the degrees, then the degrees of a chord, if given. `relative`: the centre counts
        from the pen."""
        if len(given) < 3:
            return
        centre = self._place + self.sheet.to_plotter_units(*given[:2], True) if relative else self.sheet.to_plotter_units(*given[:2])
        for place in self._arc_positions(centre, self._place, given[2], given[3] if len(given) > 3 else None):
            self._move_to(place)

    def _draw_three_point_arc(self, given, relative):
        """AT and RT: draw the arc from the pen through one position to another; a straight line to the latter if the three lie in a row. `relative`:
        both count from the pen."""
        if len(given) < 4:
            return
        a = self._place
        b, c = (a + self.sheet.to_plotter_units(*given[at : at + 2], True) if relative else self.sheet.to_plotter_units(*given[at : at + 2]) for at in (0, 2))
        u, v = b - a, c - a
        size = 2 * (u.real * v.imag - u.imag * v.real)
        if not size:
            self._move_to(c)
            return
        middle = a + complex(v.imag * abs(u) ** 2 - u.imag * abs(v) ** 2, u.real * abs(v) ** 2 - v.real * abs(u) ** 2) / size
        sweep = math.degrees(cmath.phase((c - middle) / (a - middle))) % 360
        # Round on the paper: three places make one circle.
        for place in self._arc_positions(middle, a, sweep if size > 0 else sweep - 360, given[4] if len(given) > 4 else None, (1.0, 1.0)):
            self._move_to(place)

    def _draw_bezier(self, given, relative):
        """BZ and BR: draw Bézier curves of three positions each. BR measures them from the curve's begin."""
        self.curved = True
        for at in range(0, len(given) - 5, 6):
            a = self._place
            b, c, d = (self.sheet.to_plotter_units(*given[each : each + 2], relative) + (a if relative else 0) for each in range(at, at + 6, 2))
            for place in flatten_cubic(a, b, c, d, self._deviation):
                self._move_to(place)
            self._mark_symbol()

    # --- shapes: `filled` adds the area

    def _draw_shape(self, rings, filled=False):
        """Draw closed rings of positions, in plotter units, with their area by the even-odd rule if `filled`. While a polygon is defined, append them
        to it."""
        if self._polygon is not None:
            whole = [[(place, True) for place in ring] for ring in rings]
            self._polygon[-1:] = [*([self._polygon[-1]] if self._polygon[-1] else []), *whole, []]
            return
        rings = [numpy.array(ring) for ring in rings]
        self._add_ink(rings, [svg_area.fill_area(rings, "evenodd")] if filled else ())

    def _draw_rectangle(self, given, relative, filled):
        """EA, ER, RA and RR: draw the rectangle whose diagonal goes from the pen to a position, which counts from the pen if `relative`. The pen
        stays."""
        if len(given) < 2:
            return
        self._lift_pen()
        there = self._place + self.sheet.to_plotter_units(*given[:2], True) if relative else self.sheet.to_plotter_units(*given[:2])
        a, c = self._place, there
        self._draw_shape([[a, complex(c.real, a.imag), c, complex(a.real, c.imag), a]], filled)

    def _draw_wedge(self, given, filled):
        """EW and WG: draw a wedge with its tip at the pen: radius, degrees of its start, degrees that it sweeps, then degrees of a chord, if given.
        The pen stays."""
        if len(given) < 3:
            return
        self._lift_pen()
        start = self._place + self._offset_from_centre(given[0], given[1])
        arc = self._arc_positions(self._place, start, given[2], given[3] if len(given) > 3 else None)
        self._draw_shape([[self._place, start, *arc, self._place]], filled)

    def _set_polygon_mode(self, given):
        """PM: 0 begins a polygon at the pen; 1 closes its ring and begins the next; 2 closes it, and the pen goes back. Rings of less than three
        positions are dropped."""
        mode = int(given[0]) if given else 0
        if mode == 0:
            self._lift_pen()
            self._polygon, self._begun = [[(self._place, False)]], (self._place, self._down)
        elif self._polygon is not None:
            if self._polygon[-1]:
                self._polygon[-1].append((self._polygon[-1][0][0], self._down))
            if mode == 1:
                self._polygon.append([])
            else:
                self._rings = [ring for ring in self._polygon if len(ring) > 2]
                self._polygon, (self._place, self._down) = None, self._begun

    def _draw_polygon(self, given, filled):
        """Draw the polygon that was defined: its area if `filled`, and those edges along which the pen was down."""
        self._lift_pen()
        lines = []
        for ring in self._rings:
            for (start, _), (end, down) in zip(ring, ring[1:]):
                if down and lines and lines[-1][-1] == start:
                    lines[-1].append(end)
                elif down:
                    lines.append([start, end])
        rings = [numpy.array([place for place, _ in ring]) for ring in self._rings]
        if lines or filled and rings:
            self._add_ink([numpy.array(line) for line in lines], [svg_area.fill_area(rings, "evenodd")] if filled else ())

    # --- text and ticks

    def _draw_label(self, text):
        self._lift_pen()
        self._place = self._letters.draw_label(self._place, text)

    def _move_cells(self, given):
        self._lift_pen()
        self._place = self._letters.move_cells(self._place, given)

    def _tick_lengths(self, given):
        return [share * self.sheet.span / 100 for share in self._ticks]

    def _draw_x_tick(self, given):
        up, down = self._tick_lengths(given)
        self._add_ink([numpy.array([self._place - 1j * down.imag, self._place + 1j * up.imag])])

    def _draw_y_tick(self, given):
        up, down = self._tick_lengths(given)
        self._add_ink([numpy.array([self._place - down.real, self._place + up.real])])

    def _set_tick_lengths(self, given):
        self._ticks = ((given + [0.0])[:2]) if given else (0.5, 0.5)

    def _count_line_type(self, given):
        if given:
            self.left_out[N_("line type (drawn without gaps)")] += 1

    def _count_user_letter(self, given):
        self.left_out[N_("letter of the file's own")] += 1

    WORDS = {
        "IN": _initialize_all, "DF": _set_defaults, "PU": _pen_up, "PD": _pen_down, "PA": _plot_absolute, "PR": _plot_relative, "SP": _select_pen,
        "IP": _of_sheet(Sheet.set_ends), "IR": _of_sheet(Sheet.set_relative_ends), "SC": _of_sheet(Sheet.set_scale),
        "RO": _of_sheet(Sheet.set_rotation), "IW": _of_sheet(Sheet.set_window), "PS": _of_sheet(Sheet.set_size), "PE": _draw_encoded, "CI": _draw_circle,
        "BZ": lambda self, given: self._draw_bezier(given, False), "BR": lambda self, given: self._draw_bezier(given, True),
        "AA": lambda self, given: self._draw_arc(given, False), "AR": lambda self, given: self._draw_arc(given, True),
        "AT": lambda self, given: self._draw_three_point_arc(given, False), "RT": lambda self, given: self._draw_three_point_arc(given, True),
        "EA": lambda self, given: self._draw_rectangle(given, False, False), "ER": lambda self, given: self._draw_rectangle(given, True, False),
        "RA": lambda self, given: self._draw_rectangle(given, False, True), "RR": lambda self, given: self._draw_rectangle(given, True, True),
        "EW": lambda self, given: self._draw_wedge(given, False), "WG": lambda self, given: self._draw_wedge(given, True),
        "PM": _set_polygon_mode, "EP": lambda self, given: self._draw_polygon(given, False), "FP": lambda self, given: self._draw_polygon(given, True),
        "LB": _draw_label, "CP": _move_cells, "SI": _of_letters(Letters.set_absolute_size), "SR": _of_letters(Letters.set_relative_size),
        "DI": _of_letters(Letters.set_direction), "DR": _of_letters(Letters.set_relative_direction), "SL": _of_letters(Letters.set_slant),
        "SM": _of_letters(Letters.set_symbol), "LO": _of_letters(Letters.set_origin),
        "XT": _draw_x_tick, "YT": _draw_y_tick, "TL": _set_tick_lengths, "LT": _count_line_type, "UC": _count_user_letter, "ES": _of_letters(Letters.set_space),
    }  # fmt: skip
