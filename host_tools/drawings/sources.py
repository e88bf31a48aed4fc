"""Finds the reader of a drawing by the content of the file.

    file = open_drawing("map.plt")
    file.size_px, file.outlines(0.1)        # a Page
"""

import re
from pathlib import Path

from host_tools.failure import Failure, reason

GCODE = (".gcode", ".nc", ".ngc", ".tap", ".cnc", ".num")
HPGL = (".plt", ".hpgl", ".hpg", ".hgl")
SUFFIXES = (".svg", *HPGL, ".dxf", *GCODE)
_MARKUP = re.compile(rb"(\xef\xbb\xbf|\xff\xfe|\xfe\xff)?[\s\0]*<")
_FIRST = 4096  # bytes that say what a file is


def open_drawing(path):
    """Return the reader of a drawing, by the first bytes of the file. Raises Failure."""
    path = Path(path)
    try:
        with open(path, "rb") as file:
            first = file.read(_FIRST)
    except FileNotFoundError as error:
        raise Failure("no file {}", path) from error
    except OSError as error:
        raise Failure("{} cannot be read: {}", path, reason(error)) from error
    from host_tools.drawings import dxf, hpgl
    from host_tools.programs.file_kinds import DRAWINGS, refuse_others

    refuse_others(path, first, DRAWINGS)

    suffix = path.suffix.lower()
    if suffix == ".dxf" or dxf.is_dxf(first):
        return dxf.DxfFile(path)
    if suffix != ".svg" and hpgl.is_hpgl(first) or suffix in HPGL and not _MARKUP.match(first):
        return hpgl.HpglFile(path)
    if suffix in GCODE:
        from host_tools.drawings.gcode_file import GcodeFile

        return GcodeFile(path)
    from host_tools.drawings.svg_file import SvgFile

    return SvgFile(path)
