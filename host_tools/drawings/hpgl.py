"""HPGL and HP-GL/2 files (.plt, .hpgl), the language of pen plotters, as a drawing: a layer is a pen.

    file = HpglFile("map.plt")
    page = file.outlines(deviation_px=0.1)

Coordinates are the file's: its zero is the lower left corner of the page, unless it draws below zero; a unit is 1/40 mm. Scaling by IP,
SC, IR and SR, text in single-line letters, arcs, circles, Bézier curves, wedges, rectangles, polygons, windows, rotation and HP-GL/2's
encoded polylines are followed.
Chords that the file asks for are kept, all other curves are as fine as the drawing's tolerance. Instructions that leave no ink say
nothing; others are counted in `left_out`.
"""

import math
import re
from collections import Counter

import numpy

from host_tools.drawings import hpgl_encoded
from host_tools.drawings.hpgl_pen import Pen, TooMany
from host_tools.drawings.hpgl_symbols import SymbolSets
from host_tools.drawings.page import LONGEST_TEXT, TOO_LONG, Ink, Page, move_lines
from host_tools.failure import Failure, reason
from host_tools.language import N_

UNITS_PER_MM = 40.0
UNIT_PX = 96 / 25.4 / UNITS_PER_MM
_LEAST_PX = 1.0  # of a page
_FARTHEST_MM = 1e6
_MOST = 10_000_000  # bytes
_ESCAPE = re.compile(r"\x1b(?:\.[@-Z()](?:[\d;,]*:)?|%-?\d*[A-Z]|[&*()][a-z]?[-\d]*[A-Z@]|E|\.[@-Z])")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_INSTRUCTION = re.compile(r"[A-Za-z]{2}")
_TERMINATOR = re.compile(r"([^;])(?:\s*,\s*([01])(?![\d.]))?|", re.DOTALL)  # of DT; with 0 it is drawn, too
# Ignored: they draw nothing, or change only what a pen cannot: speeds, forces, widths, pauses, answers to a PC.
_SILENT = frozenset(
    "VS FS AS VA VN PW WU PT FT NP NR PS EC MG OA OC OD OE OF OG OH OI OK OL OO OP OS OT OW IM RP BP MC SB SA SS CS CA AP CC "
    "GM GP DC DP CV LA TR ST SV RF AC UL BL PB CF AD SD TD FI FN IV LM QL AF AH CT CR PC".split()
)


def is_hpgl(data):
    """True if a file's first bytes are HPGL."""
    text = _ESCAPE.sub("", data[:400].decode("latin-1")).strip("; \r\n\t\0\x03").upper()
    return bool(re.match(r"(IN|DF|PU|PD|PA|PR|SP\d*|VS\d*|IP|SC|PS|PG|RO|NP|BP|CO|LT)\s*(;|[-\d.\s]|[A-Z]{2}|$)", text))


class HpglFile:
    def __init__(self, path):
        """Raises Failure if the file is not there, or has no instruction."""
        self._path = path
        try:
            data = open(path, "rb").read(_MOST + 1)
        except FileNotFoundError as error:
            raise Failure("no file {}", path) from error
        except OSError as error:
            raise Failure("{} cannot be read: {}", path, reason(error)) from error
        if len(data) > _MOST:
            raise Failure("{} has more than {} bytes", path, _MOST)
        self._left_out = Counter()
        self._instructions = list(self._parse_text(data.decode("latin-1")))
        if not self._instructions:
            raise Failure("{} has no instruction of HPGL", path)
        pen = self._draw_pens(1.0)
        self._straight = None if pen.curved else pen  # then it is as fine as any
        farthest = abs(self._fit_page(pen)).max() / UNITS_PER_MM
        if not farthest < _FARTHEST_MM:
            raise Failure("{}: {} mm is too far away for a drawing", path, farthest)

    def _fit_page(self, pen):
        """Make the page as large as what a pen drew, and its sheet; returns the places."""
        places = numpy.concatenate([line for inks in pen.inks.values() for ink in inks for line in ink.lines] or [numpy.zeros(1, complex)])
        places = numpy.append(places, pen.sheet.corners())
        self._left, self._bottom = min(0.0, places.real.min()), min(0.0, places.imag.min())
        self.size_px = (
            max(_LEAST_PX, (places.real.max() - self._left) * UNIT_PX),
            max(_LEAST_PX, (places.imag.max() - self._bottom) * UNIT_PX),
        )
        return places

    def outlines(self, deviation_px, progress=None, by_colour=False, fills=False, unseen=False):
        """Return the page; chords are at most `deviation_px` from their curves. A pen is a layer and a colour."""
        pen = self._straight or self._draw_pens(deviation_px / UNIT_PX)
        self._fit_page(pen)
        page = Page(self.size_px, by_colour=by_colour)
        page.left_out = self._left_out + pen.left_out
        for number in sorted(pen.inks):
            lines = move_lines([line for ink in pen.inks[number] for line in ink.lines], self._place_line)
            areas = [self._place_area(area) for ink in pen.inks[number] for area in ink.areas] if fills else []
            page.add_inks(max(1, number), None, [Ink(str(number), lines, areas)])
        return page

    def _place_line(self, line):
        """Return a line's positions in px of the page, y down."""
        return (line.real - self._left) * UNIT_PX + 1j * (self.size_px[1] - (line.imag - self._bottom) * UNIT_PX)

    def _place_area(self, area):
        from shapely.affinity import affine_transform

        return affine_transform(area, [UNIT_PX, 0, 0, -UNIT_PX, -self._left * UNIT_PX, self.size_px[1] + self._bottom * UNIT_PX])

    def _draw_pens(self, deviation):
        """Carry out the file's instructions; return the Pen with the inks of the first sheet that has lines. `deviation`: of curves from their
        chords, in plotter units. Raises Failure if arcs have too many chords."""
        pen, sheets = Pen(deviation), []
        for name, given in self._instructions:
            if name == "PG":
                sheets.append(pen.finish_line().inks)
                pen.inks = {}
            else:
                try:
                    pen.run_instruction(name, given)
                except TooMany as error:
                    raise Failure("{}: its arcs have more than {} chords: give them longer ones", self._path, error) from error
        sheets = [inks for inks in [*sheets, pen.finish_line().inks] if inks]
        pen.inks = sheets[0] if sheets else {}
        without = pen.inks.get(0) if len(pen.inks) > 1 else None
        if without:  # a plotter has put its pen away; of a file that names no pen all is drawn
            del pen.inks[0]
            pen.left_out[N_("line without a pen (SP0)")] += sum(len(ink.lines) for ink in without)
        if len(sheets) > 1:
            pen.left_out[N_("sheet behind the first")] += len(sheets) - 1
        return pen

    def _parse_text(self, text):
        """Yield (instruction, its numbers, or the text of a label)."""
        text = _ESCAPE.sub("", text)
        at, end_of_label, drawn_end, buffered, symbols = 0, "\x03", "", "", SymbolSets()
        while True:
            match = _INSTRUCTION.search(text, at)
            if match is None:
                return
            name, at = match[0].upper(), match.end()
            if name == "PB":
                yield "LB", buffered
                continue
            if name in ("LB", "BL", "SM", "DT", "CO"):
                if name == "LB" or name == "BL":
                    end = text.find(end_of_label, at)
                    end = len(text) if end < 0 else end
                    letters = symbols.decode_letters(text[at:end]) + drawn_end
                    if len(letters) > LONGEST_TEXT:
                        self._left_out[TOO_LONG] += 1
                    elif name == "LB":
                        yield name, letters
                    else:
                        buffered = letters
                    at = end + len(end_of_label)
                elif name == "DT":
                    match = _TERMINATOR.match(text, at)
                    end_of_label, at = match[1] or "\x03", match.end()
                    drawn_end = end_of_label if match[2] == "0" and (end_of_label.isprintable() or end_of_label in "\r\n") else ""
                elif name == "CO":
                    quoted = text[at:].lstrip()[:1] == '"'
                    at = (text.find('"', text.find('"', at) + 1) if quoted else text.find(";", at)) + 1 or len(text)
                else:
                    yield name, symbols.decode_letters(text[at : at + 1].strip(";"))
                    at += 1
                continue
            if name == "PE":
                end = text.find(";", at)
                at = len(text) if end < 0 else end
                yield name, hpgl_encoded.decode_moves(text[match.end() : at])
                continue
            end = _INSTRUCTION.search(text, at)
            stop = text.find(";", at, end.start() if end else None)
            stop = stop if stop >= 0 else end.start() if end else len(text)
            given = [float(each) for each in _NUMBER.findall(text[at:stop])]
            at = stop
            if not symbols.choose_set(name, given):
                self._left_out[N_("letters of a set that is not known (drawn as ASCII)")] += 1
            if name in Pen.WORDS or name == "PG":
                if all(math.isfinite(each) and abs(each) < 1e9 for each in given):
                    yield name, given
                else:
                    self._left_out[N_("number that is too large")] += 1
            elif name not in _SILENT:
                self._left_out[N_("instruction that is not known")] += 1
