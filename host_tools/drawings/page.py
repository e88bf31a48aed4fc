"""The result of the readers of drawings: lines and filled areas, layer by layer, in px of 1/96 inch, y down.

    page = Page((width_px, height_px))
    page.add_inks(1, "cut", [Ink("#ff0000", lines, areas)])
    page.layers             # {1: [complex array, ...], ...}: x + iy
"""

from collections import Counter
from dataclasses import dataclass, field, replace

import numpy

from host_tools.drawings import svg_area
from host_tools.language import N_

LONGEST_TEXT = 10_000  # letters of one text: a second
TOO_LONG = N_("text of more than 10000 letters")


@dataclass
class Ink:
    """Lines and areas of one colour, as the file names it."""

    colour: str
    lines: list  # complex arrays
    areas: list = field(default_factory=list)  # shapely geometries
    rule: str = ""  # "nonzero" or "evenodd": the lines are closed, and the edge of an area without a stroke
    under: "Ink | None" = None  # that edge, if its stroke is drawn instead


@dataclass
class Page:
    size_px: tuple[float, float]
    layers: dict = field(default_factory=dict)  # number: lines
    names: dict = field(default_factory=dict)  # number: name of its groups
    fills: dict = field(default_factory=dict)  # number: areas
    left_out: Counter = field(default_factory=Counter)
    notes: list = field(default_factory=list)  # sentences about the whole file
    unseen: int = 0  # shapes without stroke and without a fill that has an area, of width or opacity 0
    backgrounds: int = 0  # white shapes over the whole page
    drawn: int = 0  # shapes so far
    covered: int = 0  # of them below a white one over the whole page: no viewer shows them
    lost_mm: float = 0.0  # of lines outside the page
    by_colour: bool = False  # a layer is a colour, in the order in which the file comes to them

    def add_inks(self, number, name, inks):
        """Add inks to a layer; `by_colour`: each to the layer of its colour instead, numbered from 1. Inks without lines and areas are ignored."""
        for ink in inks:
            if not ink.lines and not ink.areas:
                continue
            if self.by_colour:
                name = ink.colour
                number = next((known for known, each in self.names.items() if each == name), len(self.names) + 1)
            self.layers.setdefault(number, []).extend(ink.lines)
            self.fills.setdefault(number, []).extend(ink.areas)
            if name:
                self.names.setdefault(number, name)

    def keep_layers(self, numbers):
        """Keep only the layers with these numbers."""
        self.layers = {number: self.layers[number] for number in numbers}
        self.fills = {number: self.fills.get(number, []) for number in numbers}


def move_lines(lines, change):
    """Return the lines after `change(positions)`, which gets the positions of all lines as one array."""
    return numpy.split(change(numpy.concatenate(lines)), numpy.cumsum([len(line) for line in lines[:-1]])) if lines else []


def cut_inks(inks, area, left_out):
    """Cut inks to an area: lines end at its edge, and areas get a new edge there. `left_out` counts a new edge that is not drawn, because the area
    has a stroke and a part of that is left."""
    return [_cut_ink(ink, area, left_out) for ink in inks]


def _cut_ink(ink, area, left_out):
    """Return an Ink cut to an area. The edge of an area without a stroke is drawn anew along the cut; if nothing of a stroke is left, the area below
    it is drawn by its edge."""
    lines = svg_area.clip_lines(ink.lines, area) if ink.lines else []
    whole = len(lines) == len(ink.lines) and all(kept is line for kept, line in zip(lines, ink.lines))
    areas = [each.intersection(area) for each in ink.areas]
    if whole:
        return replace(ink, areas=areas)
    if ink.rule:
        lines = svg_area.edge_lines(svg_area.fill_area(ink.lines, ink.rule).intersection(area))
    elif ink.under and not lines:
        return _cut_ink(ink.under, area, left_out)
    under = ink.under and _cut_ink(ink.under, area, left_out)
    if under and under.lines:
        left_out[N_("new edge of an area at its clip path (its stroke is drawn)")] += 1
    return Ink(ink.colour, lines, areas, ink.rule, under)
