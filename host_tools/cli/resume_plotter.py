"""`passo resume` of a drawing: pen up, to the place, pen down; the rest as `passo draw` draws it."""

from rich.console import Console

from host_tools.cli import draw
from host_tools.cli.draw_run import Way, run
from host_tools.drawings.sources import SUFFIXES
from host_tools.failure import Failure
from host_tools.programs import drawing_progress, stored_job
from host_tools.programs.journal import Journal

_POINTS = 1000
_BOARD = "plotter_2014"


def resume_drawing(file, port, baud, home, unverified, yes):
    """Go on with a drawing (.svg, or .packets of a stored one) at the point that the board's journal names. Raises Failure."""
    way = Way(True, home, unverified, True, not yes)
    record = None
    if file.suffix.lower() in SUFFIXES:
        objects, machine, record, speed = _load_drawing(file)
        numbers = drawing_progress.numbers_of_stored(objects, speed)
    else:
        data = stored_job.plotter_job(file)
        objects, speed = drawing_progress.objects_of(data)
        machine = draw.load_plotter(_BOARD)
        numbers = [stored_job.crc_of(data)]
    if not objects:
        raise Failure("{} draws nothing", file)
    run(Console(), objects, machine, record, port, baud, speed, way, numbers=numbers)


def _load_drawing(file):
    """Return (objects, board, Journal, speed) of a drawing, with the options that it was begun with. Raises Failure."""
    from host_tools.drawings import drawing

    place = Journal.path_beside(file)
    said = Journal.options_of(place)
    machine = draw.load_plotter(said.get("board", _BOARD))
    most = said.get("points", _POINTS)
    plan = drawing.load(file, machine, draw.options_of(said), lambda text, share: None)
    return plan.objects(most), machine, Journal(place, plan.digest(most), most, said), said.get("speed")
