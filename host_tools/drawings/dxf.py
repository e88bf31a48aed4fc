"""DXF files as a drawing, by ezdxf: the lines and areas that its own drawing add-on shows; a layer is a layer of the file.

    file = DxfFile("part.dxf")
    page = file.outlines(deviation_px=0.1)

Blocks, splines, ellipses, bulges, dimensions, hatches and text (as outlines of its letters) are those of ezdxf. Lengths are in the unit
that $INSUNITS names; without it `notes` says which one was taken, inches if $MEASUREMENT is 0, else mm. Layers that are off or frozen are
left out, and lines under a wipeout or under an area of the background's colour; pictures are counted in `left_out`.
"""

import io
import logging
from pathlib import Path

import numpy

from host_tools.drawings.dxf_repair import repair_tags, section_cut_off
from host_tools.drawings.page import Page
from host_tools.failure import Failure, reason
from host_tools.language import _

_MM_PX = 96 / 25.4
_LEAST_PX = 1.0
_FIRST_MM = 0.025  # chords' distance from curves of the first drawing
_LEAST_HATCH_MM = 0.05  # between two lines of a hatch
_INCH, _US_FOOT = 25.4, 1200 / 3937 * 1000
_MM = {  # a unit of $INSUNITS
    1: _INCH, 2: 304.8, 3: 1609344.0, 4: 1.0, 5: 10.0, 6: 1000.0, 7: 1e6, 8: 25.4e-6, 9: 0.0254, 10: 914.4, 11: 1e-7, 12: 1e-6, 13: 0.001,
    14: 100.0, 15: 1e4, 16: 1e5, 17: 1e12, 21: _US_FOOT, 22: _US_FOOT / 12, 23: 3 * _US_FOOT, 24: 5280 * _US_FOOT,
}  # fmt: skip
_INCHES = 0  # of $MEASUREMENT
_FARTHEST_MM = 1e9
_BINARY = b"AutoCAD Binary DXF"
_EXACT = 1e9  # of a size: how far away numbers are still exact enough


def is_dxf(first):
    """True if a file's first bytes are DXF, as text or binary."""
    if first.startswith(_BINARY):
        return True
    lines = [line.strip() for line in first.split(b"\n") if line.strip()]
    while len(lines) > 2 and lines[0] == b"999":
        lines = lines[2:]
    return len(lines) > 1 and lines[0] == b"0" and lines[1] == b"SECTION"


def _unit_mm(header):
    """Return (mm of the file's unit, [a sentence if the file names no unit])."""
    named = _MM.get(header.get("$INSUNITS", 0))
    if named:
        return named, []
    if header.get("$MEASUREMENT") == _INCHES:
        return _INCH, [_("the file names no unit ($INSUNITS): inches are taken, as its $MEASUREMENT says; if it is in mm, --scale {:.5g}", 1 / _INCH)]
    return 1.0, [_("the file names no unit ($INSUNITS): mm are taken; if it is in inches, --scale {:g}", _INCH)]


def _read_document(path):
    """Read a file as ezdxf's document. Raises Failure, and ezdxf's own errors."""
    import ezdxf
    from ezdxf import recover
    from ezdxf.lldxf.const import DXFError

    data = Path(path).read_bytes()
    if data.startswith(_BINARY):
        if not data.rstrip(b"\0\r\n\x1a").endswith(b"EOF"):
            raise Failure("{} is cut off: it has no end; save it again, or copy it again", path)
        return ezdxf.readfile(path)  # recover reads text only
    section = section_cut_off(data)
    if section:
        raise Failure("{} is cut off: it ends amid its section {}; save it again, or copy it again", path, section)
    try:
        return recover.read(io.BytesIO(data))[0]
    except DXFError:
        better = repair_tags(data)
        if better is None:
            raise
        return recover.read(io.BytesIO(better))[0]


class DxfFile:
    def __init__(self, path):
        """Raises Failure if the file cannot be read."""
        from ezdxf.lldxf.const import DXFError

        self._path = path
        logging.getLogger("ezdxf").setLevel(logging.CRITICAL)
        try:
            self._document = _read_document(path)
        except FileNotFoundError as error:
            raise Failure("no file {}", path) from error
        except (OSError, DXFError, ValueError, TypeError, LookupError, AttributeError, RecursionError) as error:
            raise Failure("{} is not a DXF file that can be read: {}", path, reason(error)) from error
        self._mm, self._unit_note = _unit_mm(self._document.header)
        self._mend_document()
        # As fine as most drawings are wanted: outlines() need not draw it anew then.
        self._fineness = _FIRST_MM / self._mm
        self._first = self._draw_document(self._fineness, False)
        left, bottom, right, top = self._box_of(self._first)
        size, far = max(right - left, top - bottom), max(map(abs, (left, bottom, right, top)))
        # A survey lies far from its zero.
        if not (size * self._mm < _FARTHEST_MM and (far * self._mm < _FARTHEST_MM or far < _EXACT * size)):
            raise Failure("{}: {} mm is too far away for a drawing", path, far * self._mm)
        self.size_px = self._size_px((left, bottom, right, top))

    def _mend_document(self):
        """Mend the document's entities (dxf_entities.py), and check their count. Raises Failure if blocks multiply to too many, or numbers cannot be
        used."""
        from host_tools.drawings import dxf_entities

        try:
            dxf_entities.mend_document(self._document)
            dxf_entities.check_size(self._document)
        except dxf_entities.TooMany as error:
            raise Failure(
                "{}: block {}, as often as it is inserted, has more entities than can be drawn: insert it less often, or smaller blocks", self._path, error
            ) from error
        except (ArithmeticError, ValueError, TypeError, LookupError, AttributeError, RecursionError) as error:
            raise Failure("{}: its numbers cannot be drawn: {}", self._path, reason(error)) from error

    @staticmethod
    def _box_of(drawn):
        """Return left, bottom, right, top of all lines, in the file's units."""
        places = numpy.concatenate([line for inks in drawn.inks.values() for ink in inks for line in ink.lines] or [numpy.zeros(1, complex)])
        return places.real.min(), places.imag.min(), places.real.max(), places.imag.max()

    def _size_px(self, box):
        return tuple(max(_LEAST_PX, side * self._mm * _MM_PX) for side in (box[2] - box[0], box[3] - box[1]))

    def outlines(self, deviation_px, progress=None, by_colour=False, fills=False, unseen=False):
        """Return the page, as large as the lines on it; chords are at most `deviation_px` from their curves."""
        from shapely.affinity import affine_transform

        scale = self._mm * _MM_PX
        drawn, self._first = self._first, None
        if drawn is None or fills or not 0.5 < self._fineness * scale / deviation_px < 1.001:
            drawn = self._draw_document(deviation_px / scale, fills)
        left, bottom, *_others = box = self._box_of(drawn)
        page = Page(self._size_px(box), by_colour=by_colour)
        page.left_out = drawn.left_out
        page.notes += self._unit_note
        height = page.size_px[1]
        for number, name in enumerate(sorted(drawn.inks), 1):
            for ink in drawn.inks[name]:
                ink.lines = [(line.real - left) * scale + 1j * (height - (line.imag - bottom) * scale) for line in ink.lines]
                ink.areas = [affine_transform(area, [scale, 0, 0, -scale, -left * scale, height + bottom * scale]) for area in ink.areas]
            page.add_inks(number, name, drawn.inks[name])
        return page

    def _draw_document(self, deviation, fills):
        """Draw the model space into a new Backend, and return it. `deviation`: of curves from their chords, in the file's units; `fills`: with areas.
        Raises Failure if a number cannot be drawn."""
        from ezdxf.addons.drawing.config import Configuration, HatchPolicy, ImagePolicy, TextPolicy

        from host_tools.drawings.dxf_backend import Backend, Frontend

        backend = Backend(deviation, fills)
        config = Configuration(
            max_flattening_distance=deviation, hatch_policy=HatchPolicy.NORMAL, text_policy=TextPolicy.OUTLINE,
            image_policy=ImagePolicy.RECT, min_hatch_line_distance=_LEAST_HATCH_MM / self._mm, circle_approximation_count=256,
        )  # fmt: skip
        try:
            Frontend(self._document, backend, config).draw_layout(self._document.modelspace())
        except (ArithmeticError, ValueError, TypeError, LookupError, AttributeError, RecursionError) as error:
            raise Failure("{}: its numbers cannot be drawn: {}", self._path, reason(error)) from error
        return backend
