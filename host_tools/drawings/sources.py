"""Finds the reader of a drawing by what stands in the file.

    file = opened("map.plt")
    file.size_px, file.outlines(0.1)        # a Page
"""

from pathlib import Path

from host_tools.failure import Failure, reason

SUFFIXES = (".svg", ".plt", ".hpgl", ".hpg", ".hgl", ".dxf")
_FIRST = 4096  # bytes that say what a file is


def opened(path):
    """A reader. Raises Failure."""
    path = Path(path)
    try:
        with open(path, "rb") as file:
            first = file.read(_FIRST)
    except FileNotFoundError as error:
        raise Failure("no file {}", path) from error
    except OSError as error:
        raise Failure("{} cannot be read: {}", path, reason(error)) from error
    from host_tools.drawings import hpgl

    suffix = path.suffix.lower()
    if suffix != ".svg" and hpgl.is_hpgl(first):
        return hpgl.HpglFile(path)
    from host_tools.drawings.svg_file import SvgFile

    return SvgFile(path)
