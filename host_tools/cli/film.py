"""`passo film`: a trace as a film."""

import sys
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.failure import Failure
from host_tools.language import _


def film(
    trace: Path = typer.Argument(..., help="A trace CSV, as passo board --trace writes it."),
    out: Annotated[Optional[Path], typer.Option("-o", "--out", help="The film, .gif or .mp4; default TRACE.gif.")] = None,
    board: Annotated[str, typer.Option(help="Board file with the steps/mm: a name, or the path of a .py file.")] = "plotter_2014",
    steps_per_mm: Annotated[Optional[str], typer.Option(metavar="N[,M]", help="Instead of --board; N for X, M for Y.")] = None,
    seconds: Annotated[float, typer.Option(min=0.5, max=600, help="How long the film is.")] = 15.0,
    speed: Annotated[Optional[float], typer.Option(min=0.001, help="Instead: so many times as fast as the machine.")] = None,
    per_second: Annotated[int, typer.Option("--fps", min=1, max=60, help="Frames a second.")] = 20,
):
    """Make a film of a trace, seen from above: the path drawn so far and the rest of it, the head, time and speed.

    An .mp4 wants pip install '.[film]'.

    Examples:

        passo film out/contours.csv
        passo film job.csv -o job.mp4 --speed 10 --board router_3axis
    """
    from host_tools.cli.plot import scale_of
    from host_tools.cli.stream import progress_bar
    from host_tools.drawings import film as films

    out = out or trace.with_suffix(".gif")
    if out.suffix.lower() not in (".gif", ".mp4"):
        raise Failure("{}: a film is a .gif or an .mp4", out)
    if out.suffix.lower() == ".mp4":
        import imageio_ffmpeg  # noqa: F401  before the trace is read, not after it
    scale = scale_of(steps_per_mm, board)
    moves = films.load_moves(trace)
    if sys.stderr.isatty():
        with progress_bar(transient=True) as bar:

            def show_share(share):
                """Show the share of frames written, 0 … 1."""
                bar.update(bar.task_ids[0], completed=share, description=f"{share:4.0%} {out}", refresh=True)

            count = films.write(out, moves, scale, seconds, speed, per_second, show_share)
    else:
        count = films.write(out, moves, scale, seconds, speed, per_second)
    print(_("{}: {} frames", out, count))
