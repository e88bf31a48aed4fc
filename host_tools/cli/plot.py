"""`passo plot`: the path of a trace as a picture."""

from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.failure import Failure


def plot(
    trace: Path = typer.Argument(..., help="A trace CSV, as passo board --trace writes it."),
    out: Optional[Path] = typer.Option(None, "-o", "--out", help="The picture; default TRACE.png."),
    board: str = typer.Option("plotter_2014", help="Board file with steps/mm and travel: a name, or the path of a .py file."),
    steps_per_mm: Optional[str] = typer.Option(None, metavar="N[,M]", help="Instead of --board; N for X, M for Y."),
    order: Annotated[bool, typer.Option("--order", help="Colour each line by when it was drawn: first blue, last red.")] = False,
    drawn: Annotated[bool, typer.Option("--drawn", help="Only where the pen was down, as large as it fits: single steps show.")] = False,
):
    """Draw the path of a trace.

    Examples:

        passo plot out/contours.csv
        passo plot job.csv -o job.png --order
        passo plot job.csv -o job.png --steps-per-mm 48,83
    """
    from host_tools.drawings.plot import save_picture, strokes_of_trace, title_of_trace
    from host_tools.sim.measure import read_trace

    scale = scale_of(steps_per_mm, board)
    out = out or trace.with_suffix(".png")
    rows = read_trace(trace)
    table = None if steps_per_mm or drawn else _table_box(board)
    strokes = [stroke for stroke in strokes_of_trace(rows, scale) if stroke[0] or not drawn]
    save_picture(out, strokes, title_of_trace(trace.stem, rows), table, order=order)
    print(out)


def _table_box(name):
    """Return the box that the machine can reach, (left, bottom, right, top) in mm, or None if the board file does not say."""
    from host_tools import boards
    from host_tools.drawings import placement

    try:
        width, height = placement.table_mm(boards.load(name))
    except (KeyError, IndexError, TypeError):
        return None
    return (0.0, 0.0, width, height)


def scale_of(text, board):
    """Return steps/mm of X and Y, from the text of --steps-per-mm or a board file. Raises Failure."""
    from host_tools import boards

    if text is None:
        return boards.steps_per_mm(boards.load(board))
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 2) or min(numbers) <= 0:
        raise Failure("--steps-per-mm wants one or two numbers above 0, as in 10 or 48,83, not {!r}", text)
    return numbers[0], numbers[-1]
