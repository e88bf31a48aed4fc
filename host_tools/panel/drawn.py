"""A drawing that is uploaded becomes a job in the plotter's words, as `passo draw` would place and order it: MOVE, LINE, END.

    made = job_of(board)
    made("map.svg", text)                       # ("map.svg.txt", "MOVE 10 20\\nLINE …"), or the number of an error
    made("map.svg", text, (20.0, 30.0, 80.0))   # its outlines' lower left corner at 20, 30 mm, 80 mm wide; None for a width: as wide as it is
"""

import tempfile
from pathlib import Path

from host_tools.drawings.packets import packet_words
from host_tools.failure import Failure
from passo import errors

_MOST_POINTS = 1000  # of one object
_NARROW_MM = 0.001  # a single upright line has no width
_MOST_BYTES = 4 << 20  # of a file: the page's server waits for it


def job_of(board):
    """A function of name and text; `board`: the checked board file of the plotter."""

    def made(name, text, place=None):
        if not name.lower().endswith(".svg"):
            return name, text
        if len(text) > _MOST_BYTES:
            return errors.JOB_SIZE
        from host_tools.drawings import drawing

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "drawing.svg"
            path.write_text(text, encoding="utf-8")
            try:
                plan = drawing.load(path, board)
                if place:
                    plan = drawing.load(path, board, _placed(plan, *place))
            except Failure:
                return errors.DRAWING
        return name + ".txt", "".join(packet_words(points) for points in plan.objects(_MOST_POINTS))

    return made


def _placed(plan, x, y, width):
    """Options that put a drawing's outlines elsewhere, and make them so wide."""
    from host_tools.drawings.placement import Options

    left, _, right, _ = plan.box_mm
    by = width / (right - left) if width and right - left > _NARROW_MM else 1.0
    return Options(place="outlines", origin=(x, y), scale=plan.scale * by)
