"""A drawing that is uploaded becomes a job, as `passo draw` would place and order it: a plotter's words, or G-code.

    made = words_of(board, machine)
    made("map.svg", text)                       # ("map.svg.txt", "MOVE 10 20\\nLINE …"), or the number of an error
    made("map.svg", text, (20.0, 30.0, 80.0))   # its outlines' lower left corner at 20, 30 mm, 80 mm wide; None for a width: as wide as it is
    made = gcode_of(board, machine)             # ("map.svg.gcode", "G21 G90 …"); a file of G-code stays as it is
"""

import tempfile
from pathlib import Path

from host_tools.failure import Failure
from host_tools.programs import gcode_file
from host_tools.programs.program_lines import raw_lines_of
from host_tools.running_board import as_set
from passo import errors

_MOST_POINTS = 1000  # of one object
_NARROW_MM = 0.001  # a single upright line has no width
_MOST_BYTES = 4 << 20  # of a file


def words_of(board, machine):
    """Return the function made(name, text, place=None) for a plotter. `board`: its checked board file; settings received by `machine` replace its
    values."""
    from host_tools.drawings.packets import packet_words
    from host_tools.drawings.sources import SUFFIXES

    def write(board, plan):
        return "".join(packet_words(points) for points in plan.objects(_MOST_POINTS))

    return _job_maker(lambda: as_set(board, machine.settings), SUFFIXES, ".txt", write)


def gcode_of(board, machine):
    """Return the same function for a machine that speaks grbl; its settings (steps/mm, travel, laser, $30) replace the board file's values."""
    from host_tools.drawings import gcode
    from host_tools.drawings.sources import GCODE, SUFFIXES

    def write(board, plan):
        cut = gcode.usual_cut(board)
        return "\n".join([*gcode.lines_of(plan, {part.number: cut for part in plan.parts}), ""])

    return _job_maker(lambda: as_set(board, machine.settings), tuple(set(SUFFIXES) - set(GCODE)), ".gcode", write, _no_program)


def _no_program(name, text):
    """0, or why the text is no job of G-code, a dict."""
    try:
        for _row in gcode_file.jobs_only(gcode_file.lines_of(name, raw_lines_of(text.encode("utf-8", "replace")))):
            pass
    except Failure as failure:
        return {"error": errors.NOT_A_JOB, "text": failure.message()}
    return 0


def _job_maker(board_now, suffixes, suffix, write, read=None):
    """Return the function that makes a job of an uploaded file. `read(name, text)`: 0, or why a file that is no drawing is no job."""

    def make_job(name, text, place=None):
        """Return (name, text) of the job that a file becomes, or a refusal. `place`: (x, y, width) in mm, or None."""
        if not name.lower().endswith(suffixes):
            return (read(name, text) if read else 0) or (name, text)
        if len(text) > _MOST_BYTES:
            return errors.JOB_SIZE
        from host_tools.drawings import drawing
        from host_tools.drawings.placement import Options

        board = board_now()
        with tempfile.TemporaryDirectory() as folder:
            path = (Path(folder) / "drawing").with_suffix(Path(name.lower()).suffix)
            path.write_text(text, encoding="utf-8")
            try:
                plan = drawing.load(path, board, Options(keep_order=bool(place)))  # only its size is wanted, to place it
                if place:
                    plan = drawing.load(path, board, _place_options(plan, *place))
            except Failure:
                return errors.DRAWING
        return name + suffix, write(board, plan)

    return make_job


def _place_options(plan, x, y, width):
    """Options that move the lower left corner of a drawing's outlines to x, y and scale them to `width`, all in mm; None: the drawing's width."""
    from host_tools.drawings.placement import Options

    left, _, right, _ = plan.box_mm
    by = width / (right - left) if width and right - left > _NARROW_MM else 1.0
    return Options(place="outlines", origin=(x, y), scale=plan.scale * by)
