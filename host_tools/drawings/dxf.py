"""DXF files as a drawing, by ezdxf: what its own drawing add-on would show, as lines and areas; a layer is a layer of the file.

    file = DxfFile("part.dxf")
    page = file.outlines(deviation_px=0.1)

Blocks, splines, ellipses, bulges, dimensions, hatches and text (as outlines of its letters) are those of ezdxf. Lengths are in the unit
that the file names, else in mm. Layers that are off or frozen are left out, and what lies
under a wipeout, or under an area of the background's colour; pictures are counted in `left_out`.
"""

import io
import logging
from pathlib import Path

import numpy

from host_tools.drawings.dxf_repair import repaired
from host_tools.drawings.page import Page
from host_tools.failure import Failure, reason

_MM_PX = 96 / 25.4
_LEAST_PX = 1.0
_MM = {0: 1.0, 1: 25.4, 2: 304.8, 4: 1.0, 5: 10.0, 6: 1000.0, 8: 25.4e-6, 9: 0.0254, 10: 914.4, 13: 0.001, 14: 100.0}  # $INSUNITS
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


def _read(path):
    """ezdxf's document. Raises what ezdxf does."""
    import ezdxf
    from ezdxf import recover
    from ezdxf.lldxf.const import DXFError

    data = Path(path).read_bytes()
    if data.startswith(_BINARY):
        return ezdxf.readfile(path)  # recover reads text only
    try:
        return recover.read(io.BytesIO(data))[0]
    except DXFError:
        better = repaired(data)
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
            self._document = _read(path)
        except FileNotFoundError as error:
            raise Failure("no file {}", path) from error
        except (OSError, DXFError, ValueError, TypeError, LookupError, AttributeError, RecursionError) as error:
            raise Failure("{} is not a DXF file that can be read: {}", path, reason(error)) from error
        self._mm = _MM.get(self._document.header.get("$INSUNITS", 0), 1.0)
        # In the file's units: the size decides how fine curves have to be.
        found = self._drawn(0.1 / self._mm, False)
        places = numpy.concatenate([line for inks in found.inks.values() for ink in inks for line in ink.lines] or [numpy.zeros(1, complex)])
        box = places.real.min(), places.imag.min(), places.real.max(), places.imag.max()
        size, far = max(box[2] - box[0], box[3] - box[1]), max(map(abs, box))
        # A survey lies far from its zero.
        if not (size * self._mm < _FARTHEST_MM and (far * self._mm < _FARTHEST_MM or far < _EXACT * size)):
            raise Failure("{}: {} mm is too far away for a drawing", path, far * self._mm)
        self._left, self._bottom = box[:2]
        self.size_px = tuple(max(_LEAST_PX, side * self._mm * _MM_PX) for side in (box[2] - box[0], box[3] - box[1]))

    def outlines(self, deviation_px, progress=None, by_colour=False, fills=False):
        """The page; chords are at most `deviation_px` from their curves."""
        from shapely.affinity import affine_transform

        scale = self._mm * _MM_PX
        found = self._drawn(deviation_px / scale, fills)
        page = Page(self.size_px, by_colour=by_colour)
        page.left_out = found.left_out
        height = self.size_px[1]
        for number, name in enumerate(sorted(found.inks), 1):
            for ink in found.inks[name]:
                ink.lines = [(line.real - self._left) * scale + 1j * (height - (line.imag - self._bottom) * scale) for line in ink.lines]
                ink.areas = [
                    affine_transform(area, [scale, 0, 0, -scale, -self._left * scale, height + self._bottom * scale]) for area in ink.areas
                ]
            page.add(number, name, found.inks[name])
        return page

    def _drawn(self, deviation, fills):
        from ezdxf.addons.drawing import RenderContext
        from ezdxf.addons.drawing.config import Configuration, HatchPolicy, ImagePolicy, TextPolicy

        from host_tools.drawings.dxf_backend import Backend, Frontend

        backend = Backend(deviation, fills)
        config = Configuration(
            max_flattening_distance=deviation, hatch_policy=HatchPolicy.NORMAL, text_policy=TextPolicy.OUTLINE,
            image_policy=ImagePolicy.RECT, circle_approximation_count=256,
        )  # fmt: skip
        for entity in self._document.entitydb.values():
            if entity.dxftype() == "INSERT" and not entity.dxf.zscale:
                entity.dxf.zscale = 1.0  # of a flat block: ezdxf would divide by it
        try:
            Frontend(RenderContext(self._document), backend, config=config).draw_layout(self._document.modelspace())
        except (ArithmeticError, ValueError, TypeError, LookupError, AttributeError, RecursionError) as error:
            raise Failure("{}: its numbers cannot be drawn: {}", self._path, reason(error)) from error
        return backend
