"""HPGL's numbers on the paper: P1 and P2, scales, rotation, window, the sheet's size. All in plotter units (1/40 mm), y up."""

import cmath
import math
from collections import Counter

import shapely
from shapely import affinity

from host_tools.drawings import svg_area
from host_tools.language import N_

_P2 = 10365 + 7962j  # of an A4 sheet, as HP's plotters have it


class Sheet:
    def __init__(self):
        self.size = None  # (width, height), if the file says so
        self.left_out = Counter()
        self.initialize()

    def initialize(self):
        """IN: reset P1 and P2, the rotation, and everything that DF resets."""
        self._ends, self._turn = (0j, _P2), 0
        self.reset()

    def reset(self):
        """DF: no scale, no window."""
        self._user = self._scale = self._window = None

    @property
    def span(self):
        """The vector from P1 to P2, in plotter units."""
        return self._ends[1] - self._ends[0]

    @property
    def factors(self):
        """The plotter units of one unit of the file, across and up."""
        return self._scale[1:] if self._scale else (1.0, 1.0)

    def to_plotter_units(self, x, y, relative=False):
        """Return a pair of the file's numbers in plotter units; `relative`: they are a distance."""
        place = complex(x, y)
        if self._scale:
            origin, across, up = self._scale
            place = complex(x * across, y * up) + (0 if relative else origin)
        return place

    def cut_to_window(self, lines, areas):
        """Return (lines, areas) cut by the window and turned with the sheet."""
        if self._window:
            lines = svg_area.clip_lines(lines, self._window)
            areas = [area.intersection(self._window) for area in areas]
        if self._turn:
            lines = [line * self._turn_factor for line in lines]
            areas = [affinity.rotate(area, self._turn, origin=(0, 0)) for area in areas]
        return lines, areas

    @property
    def _turn_factor(self):
        return cmath.exp(1j * math.radians(self._turn))

    def corners(self):
        """Return two opposite corners of the sheet as it is drawn; 0 and 0 if the file does not say how large it is."""
        return 0j, complex(*self._page_size()) * self._turn_factor

    def _page_size(self):
        """Return (width, height) by the sheet's rotation but without RO: its long side is x."""
        size = sorted(self.size or (0.0, 0.0), reverse=True)
        return size[::-1] if self._turn % 180 else size

    # --- instructions

    def set_ends(self, given):
        """IP: set P1 and P2, in plotter units. Two numbers move P1, and P2 with it; without numbers both get their defaults."""
        if len(given) >= 4:
            self._ends = complex(*given[:2]), complex(*given[2:4])
        elif len(given) >= 2:
            self._ends = complex(*given[:2]), complex(*given[:2]) + self.span
        else:
            self._ends = 0j, _P2
        self._compute_scale()

    def set_relative_ends(self, given):
        """IR: set P1 and P2, in per cent of the sheet."""
        width, height = self._page_size() if self.size else (_P2.real, _P2.imag)
        self.set_ends([share * (height if at % 2 else width) / 100 for at, share in enumerate(given)])

    def set_scale(self, given):
        self._user = given if len(given) >= 4 else None
        self._compute_scale()

    def _compute_scale(self):
        """Set `_scale` by SC's numbers: (position of the file's 0;0, plotter units of its unit across, and up). SC's kind 0 stretches both axes to P1
        and P2, kind 1 has equal units, kind 2 gives the units as factors. None without SC; an empty range goes to `left_out`."""
        self._scale = None
        if not self._user:
            return
        (left, right, bottom, top), kind = self._user[:4], self._user[4] if len(self._user) > 4 else 0
        first, span = self._ends[0], self.span
        if kind == 2:  # xmin, factor, ymin, factor
            across, up = right, top
            self._scale = first - complex(left * across, bottom * up), across, up
            return
        if right == left or top == bottom:
            self.left_out[N_("scale without size")] += 1
            return
        across, up = span.real / (right - left), span.imag / (top - bottom)
        if kind == 1:
            share_x, share_y = (self._user[5:7] + [50, 50])[:2] if len(self._user) > 6 else (50, 50)
            least = min(abs(across), abs(up))
            spare = complex(abs(span.real) - least * abs(right - left), abs(span.imag) - least * abs(top - bottom))
            across, up = math.copysign(least, across), math.copysign(least, up)
            first += complex(math.copysign(spare.real, span.real) * share_x / 100, math.copysign(spare.imag, span.imag) * share_y / 100)
        self._scale = first - complex(left * across, bottom * up), across, up

    def set_rotation(self, given):
        self._turn = int(given[0]) if given else 0

    def set_window(self, given):
        """IW: set the window; without numbers the window is the sheet."""
        if len(given) < 4 and not self.size:
            self._window = None
            return
        a, b = (self.to_plotter_units(*given[:2]), self.to_plotter_units(*given[2:4])) if len(given) >= 4 else (0j, complex(*self._page_size()))
        self._window = shapely.box(min(a.real, b.real), min(a.imag, b.imag), max(a.real, b.real), max(a.imag, b.imag))

    def set_size(self, given):
        if given:
            self.size = given[0], given[1] if len(given) > 1 else given[0]
