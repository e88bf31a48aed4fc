"""A drawing that is uploaded becomes a job in the plotter's words, as `passo draw` would place and order it: MOVE, LINE, END.

    made = job_of(board)
    made("map.svg", text)           # ("map.svg.txt", "MOVE 10 20\\nLINE …"), or the number of an error
"""

import tempfile
from pathlib import Path

from host_tools.drawings.packets import packet_words
from host_tools.failure import Failure
from passo import errors

_MOST_POINTS = 1000  # of one object
_MOST_BYTES = 4 << 20  # of a file: the page's server waits for it


def job_of(board):
    """A function of name and text; `board`: the checked board file of the plotter."""

    def made(name, text):
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
            except Failure:
                return errors.DRAWING
        return name + ".txt", "".join(packet_words(points) for points in plan.objects(_MOST_POINTS))

    return made
