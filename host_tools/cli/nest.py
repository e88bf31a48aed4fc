"""`passo nest`: drawings on one sheet in many orders, by several processes or a cluster, as one table."""

import os
from pathlib import Path
from typing import Annotated, NamedTuple, Optional

import typer

from host_tools.failure import Failure
from host_tools.language import _

_COLUMNS = ("nesting", "height_mm", "full_percent", "fault")
_SHOWN = 5  # of the lowest


class Try(NamedTuple):
    """`shapes`: as WKB, which travels."""

    order: int
    shapes: tuple
    width: float
    height: float
    gap: float
    turn: bool


def nest_try(item):
    """Nest the shapes of a Try; return (height used in mm, share of it that is full, 0 … 1), or None if there is no room. A worker process
    calls it."""
    import shapely

    from host_tools.drawings import nesting

    shapes = list(shapely.from_wkb(item.shapes))
    try:
        spots = nesting.nest_shapes(shapes, item.width, item.height, item.gap, item.turn, item.order)
    except Failure:
        return None
    return nesting.fullness(shapes, spots, item.width)


def nest(
    file: Annotated[list[Path], typer.Argument(help="The drawings: SVG, HPGL, DXF or G-code.")],
    board: Annotated[str, typer.Option(help="Board by name, or the path of a board file.")] = "plotter_2014",
    gap: Annotated[float, typer.Option(min=0.0, max=1000.0, help="Between drawings, in mm.")] = 5.0,
    turn: Annotated[bool, typer.Option("--turn/--no-turn", help="Drawings may be turned.")] = True,
    scale: Annotated[Optional[float], typer.Option(help="Factor of the real size, e.g. 0.5.")] = None,
    margin: Annotated[float, typer.Option(help="Margin that is kept free on the table, in mm.")] = 10.0,
    place: Annotated[str, typer.Option(help="page or outlines, as passo draw has it.")] = "page",
    tries: Annotated[int, typer.Option(min=1, max=1_000_000, help="How many orders are tried.")] = 100,
    workers: Annotated[Optional[int], typer.Option(min=1, help="Processes on this PC; default: one for each processor.")] = None,
    dask: Annotated[Optional[str], typer.Option(metavar="tcp://HOST:PORT", help="The scheduler of a Dask cluster, which tries.")] = None,
    out: Annotated[Optional[Path], typer.Option("-o", "--out", metavar="FILE.csv", help="A table of all nestings.")] = None,
):
    """Nest drawings on one sheet in many orders, and name the one that takes the least of its height.

    `passo draw` with the same options, and --nesting and that number, draws it. Number 0 is what passo draw does by itself. If a worker dies, its
    nesting is tried again.

    Examples:

        passo nest *.svg --board laser_xy --gap 2 --tries 1000

        passo nest *.svg --board laser_xy --gap 2 --tries 10000 --dask tcp://192.168.1.20:8786 -o table.csv
    """
    import shapely

    from host_tools.cli.draw import machine_of
    from host_tools.drawings.drawing import Options, load_shapes
    from host_tools.workers import DIED, run_items, open_table

    if workers and dask:
        raise Failure("--workers are of this PC, --dask of a cluster: give one of them")
    if len(file) < 2:
        raise Failure("one drawing is no nesting: give several, or one several times")
    if scale is not None and scale <= 0:
        raise Failure("--scale must be above 0")
    found, (width, height) = load_shapes(file, machine_of(board, True)[0], Options(gap=gap, turn=turn, scale=scale, margin=margin, place=place))
    sent = tuple(shapely.to_wkb(found))
    items = (Try(order, sent, width, height, gap, turn) for order in range(tries))
    with open_table(out, _COLUMNS) as write:
        rows = sorted((item.order, result) for item, result in run_items(nest_try, items, min(workers or os.cpu_count() or 1, tries), dask))
        for order, result in rows:
            write((order, f"{result[0]:.3f}", f"{100 * result[1]:.1f}", "") if result not in (DIED, None) else (order, "", "", result or _("no room")))
    made = sorted((round(result[0], 3), order, 100 * result[1]) for order, result in rows if result not in (DIED, None))
    _print_best(made, tries, sum(result == DIED for _order, result in rows), width, height)


def _print_best(made, tries, died, width, height):
    """Print the _SHOWN nestings that take the least height. `made`: sorted [(mm, order, percent full)]. Raises Failure if none has room, or workers
    died."""
    for used, order, full in made[:_SHOWN]:
        print(_("nesting {:>6}: {:.1f} mm of the sheet's height, {:.0f} % of that full", order, used, full))
    print(_("{} nestings of {} have room on {:g} x {:g} mm", len(made), tries, width, height))
    if died:
        raise Failure("the workers of {} nestings died again and again", died)
    if not made:
        raise Failure("there is no room for all of them in any order")
    print(_("passo draw with --nesting {} draws the lowest", made[0][1]))
