"""What a file is that somebody gives to a verb which cannot take it: told by its first bytes, with the verb that does.

    refuse_others("photo.png", first, GCODE)    # Failure: photo.png is a picture: passo engrave burns it
"""

import re

from host_tools.failure import Failure
from host_tools.language import N_, _

FIRST = 4096  # bytes that say what a file is
PICTURE, SVG, DXF, HPGL = "picture", "svg", "dxf", "hpgl"
DRAWINGS = SVG, DXF, HPGL
HPGL_START = re.compile(rb"\s*(\x1b|(IN|DF|PU|PD|PA|PR|SP\d*|VS\d*)\s*(;|[-\d.]+\s*,|$))", re.IGNORECASE)

# Kind, how its files begin, and what takes it.
_KINDS = (
    (PICTURE, re.compile(rb"\x89PNG|\xff\xd8\xff|GIF8|BM.{4}\0\0\0\0|II\*\0|MM\0\*|RIFF.{4}WEBP", re.DOTALL), N_("a picture: passo engrave burns it")),
    (SVG, re.compile(rb"(\xef\xbb\xbf|\xff\xfe|\xfe\xff)?[\s\0]*<.*?s\0?v\0?g", re.DOTALL), N_("a drawing (SVG): passo draw draws it, or makes G-code of it")),
    (DXF, re.compile(rb"AutoCAD Binary DXF|\s*(999\s*\n[^\n]*\n\s*)*0[ \t]*\r?\n\s*SECTION"), N_("a drawing (DXF): passo draw draws it, or makes G-code of it")),
    ("excellon", re.compile(rb"(\s*;[^\n]*\n)*\s*M48\s(?=.*^(METRIC|INCH|FMAT|T\d+[^\n]*C[\d.]))", re.DOTALL | re.MULTILINE), N_("a drill file (Excellon), which no verb takes: pcb2gcode or FlatCAM makes G-code of it")),
    ("gerber", re.compile(rb"(\s*G0?4[^\n]*\*\s*|\s*%TF[^\n]*\s*)*%(FS[LTD][AI]|MO(MM|IN)\*)"), N_("a board's layer (Gerber), which no verb takes: KiCad plots SVG or DXF, pcb2gcode makes G-code of it")),
    ("stl", re.compile(rb"solid\b[^\n]*\n\s*facet\b"), N_("a model (STL), which no verb takes: a CAM program makes G-code of it")),
    ("pdf", re.compile(rb"%PDF-"), N_("a PDF, which no verb takes: Inkscape or pdf2svg makes SVG of it")),
    ("postscript", re.compile(rb"%!PS"), N_("PostScript, which no verb takes: pstoedit or Inkscape makes SVG of it")),
)  # fmt: skip
_HPGL_TEXT = N_("HPGL, the language of pen plotters, and no G-code: passo draw draws it")


def refuse_others(path, first, taken=()):
    """Raise Failure if the file that begins with `first` is of a known kind, and not of those `taken`."""
    for kind, begins, text in _KINDS:
        if kind not in taken and begins.match(first):
            raise Failure("{} is {}", path, _(text))
    if HPGL not in taken and HPGL_START.match(first[:200].lstrip().partition(b"\n")[0].rstrip()):
        raise Failure("{} is {}", path, _(_HPGL_TEXT))
