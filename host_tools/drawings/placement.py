"""Positions and scales a drawing's page on the machine's table.

    place = Placement(page, board, Options(center=True))
    place.factor, place.origin_mm           # of the real size; where place.corner_px stands

The page's lower left corner lies at 0;0, in its real size. A page with lines beyond the table is reduced. All layers count,
also those that are not drawn, so each layer has the same position.
"""

from dataclasses import dataclass

import numpy

from host_tools import boards
from host_tools.failure import Failure
from host_tools.language import _

MM_PER_PX = 25.4 / 96


@dataclass
class Options:
    """Options of position and size. Lengths in mm; `scale` is a factor of the real size."""

    margin: float = 10.0  # kept free on the table by `fit`
    fit: bool = False
    center: bool = False
    scale: float | None = None
    origin: tuple[float, float] | None = None  # of the lower left corner of the page, or of the outlines
    place: str = "page"  # or "outlines": use the box around all lines instead of the page
    tolerance: float = 0.1
    crop: bool = True
    layers: tuple[int, ...] = ()
    pens: str = "none"  # "layers" or "colours": each is a pen, and the machine waits for the next
    hatch: tuple[str, ...] = ()  # rules of hatch.py
    copies: str = ""  # columns and rows, as 3x2
    gap: float = 5.0  # between copies, and between drawings on one sheet
    turn: bool = True  # drawings on one sheet may be turned
    nesting: int = 0  # the order in which they are placed, see nesting.nest()
    marks: bool = False  # crosses at the corners, of each pen
    repeat: int = 1  # how often each line is gone along
    keep_order: bool = False
    unseen: bool = False  # draw what nobody sees, too: shapes without stroke and fill, a background


def box_of(layers):
    """Return left, least y, right, largest y of lists of lines, in their unit."""
    places = numpy.concatenate([line for lines in layers for line in lines if len(line)])
    return float(places.real.min()), float(places.imag.min()), float(places.real.max()), float(places.imag.max())


def table_mm(board):
    return tuple(steps / per_mm for steps, per_mm in zip(boards.travel_steps(board), boards.steps_per_mm(board)))


def percent_text(factor):
    """Return a factor in per cent, as text; 100 only if it is exactly 1, and never 0."""
    if factor < 1e-3:
        return f"{factor * 100:.2g}"
    text = f"{factor * 100:.1f}"
    return text if text != "100.0" or factor == 1 else f"{factor * 100:.4f}".rstrip("0").rstrip(".")


def fit_factor(box_px, board, options):
    """Return the factor that makes a box, px of the file, fill the table within the margin. Raises Failure if the margin leaves no room."""
    room = [table - 2 * options.margin for table in table_mm(board)]
    if min(room) <= 0:
        raise Failure("a margin of {:g} mm leaves no room on the table", options.margin)
    size = [(high - low) * MM_PER_PX for low, high in (box_px[::2], box_px[1::2])]
    return min(space / length for space, length in zip(room, size) if length > 1e-9) if max(size) > 1e-6 else 1.0


class Alone:
    """Position of one of several drawings: its outlines' corner at 0;0."""

    def __init__(self, page, options):
        left, _, _, bottom = box_of(page.layers.values())
        self.corner_px, self.origin_mm, self.factor, self.notes = (left, bottom), (0.0, 0.0), options.scale or 1.0, []

    def on_table(self, box_px):
        mm_per_px = MM_PER_PX * self.factor
        (left, bottom), (x1, y1, x2, y2) = self.corner_px, box_px
        return (x1 - left) * mm_per_px, (bottom - y2) * mm_per_px, (x2 - left) * mm_per_px, (bottom - y1) * mm_per_px


class Placement:
    """Position and size on the table of the page, or of the box around all lines, layers that are not drawn included."""

    def __init__(self, page, board, options):
        self.notes = []
        self._board = board
        self._table = table_mm(board)
        outlines_px = box_of(page.layers.values())
        box_px = (0.0, 0.0, *page.size_px) if options.place == "page" else outlines_px
        self._box_px = box_px
        self.corner_px = (box_px[0], box_px[3])
        self.factor = options.scale or (fit_factor(box_px, board, options) if options.fit else 1.0)
        self._place_origin(options)
        free = options.origin is None and options.scale is None and not options.fit
        if free and not self._has_room(outlines_px):
            size = [(high - low) * MM_PER_PX for low, high in (box_px[::2], box_px[1::2])]
            self.factor = min([1.0] + [table / length for table, length in zip(self._table, size) if length > 1e-9])
            self._place_origin(options)
            if self.factor < 1:
                if options.place == "page":
                    text = _("the page of {:.1f} × {:.1f} mm does not fit the table of {:g} × {:g} mm: drawn at {} %")
                else:
                    text = _("the outlines of {:.1f} × {:.1f} mm do not fit the table of {:g} × {:g} mm: drawn at {} %")
                self.notes.append(text.format(*size, *self._table, percent_text(self.factor)))
        if not self._has_room(outlines_px):
            left, low, right, high = self.on_table(outlines_px)
            raise Failure(
                "the drawing, {:.1f} × {:.1f} mm with its corner at {:.1f}, {:.1f}, leaves the table of {:g} × {:g} mm; use --fit, "
                "--place outlines, or another --scale or --origin",
                right - left, high - low, left, low, self._table[0], self._table[1],
            )

    def _place_origin(self, options):
        """Set `origin_mm`, the position of the box's lower left corner: 0;0, centred on the table by `fit` or `center`, or `origin`, which goes
        before both."""
        size = [(high - low) * MM_PER_PX * self.factor for low, high in (self._box_px[::2], self._box_px[1::2])]
        self.origin_mm = (0.0, 0.0)
        if options.fit or options.center:
            self.origin_mm = tuple((table - length) / 2 for table, length in zip(self._table, size))
        if options.origin is not None:
            self.origin_mm = options.origin

    def on_table(self, box_px):
        """Return a box of the file on the machine: left, bottom, right, top in mm."""
        mm_per_px = MM_PER_PX * self.factor
        x, y = self.origin_mm
        left, bottom = self.corner_px
        return (
            x + (box_px[0] - left) * mm_per_px, y + (bottom - box_px[3]) * mm_per_px,
            x + (box_px[2] - left) * mm_per_px, y + (bottom - box_px[1]) * mm_per_px,
        )  # fmt: skip

    def _has_room(self, box_px):
        """True if a box is on the table. Half a step beyond its edge counts as on it: rounding removes that."""
        left, bottom, right, top = self.on_table(box_px)
        slack = [0.5 / per_mm for per_mm in boards.steps_per_mm(self._board)]
        return (
            left > -slack[0] and bottom > -slack[1]
            and right < self._table[0] + slack[0] and top < self._table[1] + slack[1]
        )  # fmt: skip
