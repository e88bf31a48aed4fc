"""`passo draw`: an SVG file, drawn by the plotter."""

import sys
from pathlib import Path
from typing import Optional

import typer

from host_tools.failure import Failure, reason
from host_tools.language import _

EXAMPLES = """Draw an SVG file on the plotter.

Examples:

    passo draw map.svg --port /dev/ttyACM0

    passo draw map.svg --port /dev/ttyACM0 --fit --margin 20

    passo draw map.svg --scale 0.5 --origin 30,40 --dry-run --preview map.png

    passo draw map.svg --port /dev/ttyACM0 --layer 2

    passo draw map.svg --port /dev/ttyACM0 --continue

The page lies with its lower left corner at 0;0, in its real size. It is reduced if it is larger than the table and has
lines beyond it. To change pens, draw one layer after the other: they fall on each other if the options of size and position
are the same.

If the board keeps a journal (docs/jobs.md), --continue goes on amid a line, at the very step.

Ctrl-C stops the machine, pen up. --continue with the same options goes on from there, also after the board was unplugged or
the PC went to sleep.
"""


def draw(
    file: Path = typer.Argument(..., help="The SVG file."),
    port: Optional[str] = typer.Option(None, help="Serial port, pty or pyserial URL (socket://host:port)."),
    board: str = typer.Option("plotter_2014", help="Board by name, or the path of a board file."),
    baud: int = typer.Option(57600, help="Bits per second of a serial port."),
    fit: bool = typer.Option(False, "--fit", help="Enlarge or reduce to fill the table within the margin."),
    center: bool = typer.Option(False, "--center", help="In the middle of the table."),
    scale: Optional[float] = typer.Option(None, help="Factor of the real size, e.g. 0.5."),
    origin: Optional[str] = typer.Option(None, metavar="X,Y", help="Position of the lower left corner, in mm; default 0,0."),
    place: str = typer.Option("page", help="Position and fit the page, or the outlines: the box around all lines."),
    margin: float = typer.Option(10.0, help="Margin that --fit keeps free on the table, in mm."),
    tolerance: float = typer.Option(0.1, min=0.01, max=1.0, help="How finely curves are followed, in mm."),
    layer: Optional[list[int]] = typer.Option(
        None, help="Draw this layer only, at its position among all; may be given more than once."
    ),
    crop: bool = typer.Option(True, "--crop/--no-crop", help="Leave out what lies outside the SVG's page."),
    speed: Optional[int] = typer.Option(None, min=1, max=65535, help="Drawing speed, in the board file's unit."),
    points: int = typer.Option(1000, min=2, max=60000, help="Most points of an object sent before it is drawn."),
    home: bool = typer.Option(True, "--home/--no-home", help="Seek the origin before drawing."),
    resume: bool = typer.Option(False, "--continue", help="Continue a drawing that was interrupted."),
    journal: Optional[Path] = typer.Option(None, help="Where progress is kept; default FILE.svg.journal."),
    dry_run: bool = typer.Option(False, "--dry-run", help="Say what would be drawn; needs no port."),
    packets: Optional[Path] = typer.Option(None, metavar="FILE", help="Write the packets, for passo jobs store; needs no port."),
    preview: Optional[Path] = typer.Option(None, metavar="PNG", help="Write a picture of what would be drawn."),
    log: Optional[Path] = typer.Option(None, help="Save the conversation on the wire to this file."),
    timeout: float = typer.Option(3.0, min=0.5, help="Seconds an answer may take."),
):
    from rich.console import Console

    from host_tools.drawings import drawing
    from host_tools.programs.drawn import write_packets
    from host_tools.programs.journal import Journal

    said = {
        "board": board, "fit": fit, "center": center, "scale": scale, "origin": origin, "place": place, "margin": margin,
        "tolerance": tolerance, "layer": layer, "crop": crop, "speed": speed, "points": points,
    }  # fmt: skip
    machine = plotter(board)
    options = options_of(said)
    console = Console()
    with console.status(_("reading {}", file)) as status:
        plan = drawing.load(file, machine, options, lambda text, share: status.update(f"{_(text)} {file}: {share:.0%}"))
    seconds = _describe(console, plan, options, machine, speed)
    if preview:
        _picture(preview, plan, machine, seconds, file)
    if dry_run:
        return
    objects = plan.objects(points)
    if packets:
        write_packets(packets, objects, home, speed)
        console.print(_("  {0}: to be stored by passo jobs store {0} --protocol plotter", packets))
        return
    record = Journal(journal or Journal.beside(file), plan.digest(points), points, said)
    if not resume:
        record.probe()
        if record.begun():
            console.print(_("  [yellow]begun before and not finished: it is drawn anew; --continue would go on[/yellow]"))
    from host_tools.cli.draw_run import Way, run

    run(console, objects, machine, record, port, baud, speed, Way(resume, home), log, timeout)


draw.__doc__ = EXAMPLES


def options_of(said):
    """The Options of those that the command was given, a dict; what is not in it is as by default."""
    from host_tools.drawings.drawing import Options

    known = {key: said[key] for key in ("margin", "fit", "center", "scale", "place", "tolerance", "crop") if key in said}
    return Options(origin=_corner(said.get("origin")), layers=tuple(said.get("layer") or ()), **known)


def _corner(text):
    if text is None:
        return None
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise Failure("--origin wants two lengths in mm, as in 30,40, not {!r}", text) from None
    return x, y


def plotter(name):
    """The checked board file. Raises Failure if none of its links speaks the plotter's language."""
    from host_tools import boards
    from passo.config.boardfile import BoardError, check

    try:
        board = check(boards.load(name))
    except BoardError as error:
        raise Failure("board {}: {}", name, reason(error)) from error
    spoken = sorted({link["protocol"] for link in board["links"]})
    if "plotter" not in spoken:
        if "grbl" in spoken:
            raise Failure(
                "board {} speaks {}: passo draw speaks to plotters only; docs/gcode.md says how a drawing becomes G-code for passo stream",
                name, ", ".join(spoken),
            )
        raise Failure("board {} speaks {}: passo draw speaks to plotters only", name, ", ".join(spoken))
    return board


def _describe(console, plan, options, machine, speed):
    """Say what would be drawn; returns the seconds that it would take."""
    from rich.markup import escape

    from host_tools.drawings import drawing
    from host_tools.programs import estimate

    down, up = plan.lengths_mm()
    times = estimate.Estimate(machine, speed)
    total = sum(times.object_s(plan.objects(sys.maxsize)[0]))
    console.print(_("[bold]{}[/bold] at {} % of its real size", escape(plan.name), drawing.percent(plan.scale)))
    for text, (left, bottom, right, top) in (
        (_("  page  {:.1f} × {:.1f} mm, corner at {:.1f}, {:.1f}"), plan.page_mm),
        (_("  drawn {:.1f} × {:.1f} mm, corner at {:.1f}, {:.1f}"), plan.box_mm),
    ):
        console.print(text.format(right - left, top - bottom, left, bottom))
    if len(plan.layers) > 1:
        named = ", ".join(f"{number} {name or ''}".rstrip() for number, name in plan.layers.items())
        chosen = _(", drawn: {}", ", ".join(map(str, options.layers))) if options.layers else ""
        console.print(_("  layers {}", escape(named)) + chosen)
    console.print(_("  {} lines, {} points", len(plan.lines), plan.points()))
    console.print(_("  pen down {:.2f} m, pen up {:.2f} m, about {}", down / 1000, up / 1000, estimate.clock(total)))
    for note in plan.notes:
        console.print(f"  [yellow]{escape(note)}[/yellow]")
    return total


def _picture(path, plan, machine, seconds, file):
    from host_tools.drawings import drawing, placement, plot
    from host_tools.programs import estimate

    title = _("{} at {} %, about {}", file.name, drawing.percent(plan.scale), estimate.clock(seconds))
    table = (0.0, 0.0, *placement.table_mm(machine))
    plot.save(path, plot.strokes_of_lines(plan.lines, plan.steps_per_mm), title, table, plan.page_mm)
