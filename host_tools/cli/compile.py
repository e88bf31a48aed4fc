"""`passo compile`: a program in NUM's or LinuxCNC's dialect to plain G-code."""

from pathlib import Path
from typing import Optional

import typer

from host_tools.failure import Failure
from host_tools.language import _, count_text

_MOST_LABELS = 60  # of a picture


def compile_(
    file: Path = typer.Argument(..., help="The program."),
    dialect: Optional[str] = typer.Option(None, help="num or ngc; default: by what stands in the file."),
    out: Optional[Path] = typer.Option(None, "-o", "--out", help="Where the listing goes; default: the screen. - is the screen too."),
    picture: Optional[Path] = typer.Option(None, help="A picture (.png, .svg) of the path, with the lines of the program."),
    tools: Optional[Path] = typer.Option(None, help="The tool table, a tool a line: T1 P1 D6.0 Z42.5 (diameter, length in mm)."),
    start: Optional[str] = typer.Option(
        None, metavar="X,Y,Z[,A]", help="Where the machine stands at first, mm (A: degrees) of the program: for programs that begin with G91."
    ),
    skip: bool = typer.Option(False, "--skip", help="Leave out lines that begin with /."),
    linear: bool = typer.Option(False, "--linear-a", help="A is no rotary axis: in G20 its words are inches."),
    bound: int = typer.Option(1_000_000, min=1, help="Stop a program that carries out, or makes, more lines than this."),
):
    """Compile a program to plain G-code: parameters, subprograms, loops, radius compensation and canned cycles become lines and arcs.

    Dialects: ngc is RS274/NGC as LinuxCNC has it, num the NUM dialect; docs/use/programs.md lists their words. Each line of the listing
    names the program's line that it came from, behind a semicolon. Errors have numbers, and the line.

    passo stream and passo check compile by themselves; this is to look at the result, or to keep it.

    Examples:

        passo compile part.ngc
        passo compile part.ngc --tools tools.tbl -o part.gcode --picture part.png
        passo compile pocket.num --dialect num --tools tools.tbl -o pocket.gcode
    """
    from host_tools.programs.compiler import compile_file

    if out and out != Path("-") and out.exists() and out.resolve() == file.resolve():
        raise Failure("{} is the program itself", out)
    program = compile_file(file, dialect, tools, _parse_start(start), bound, skip, linear)
    if program.listing.turns_in_inches:
        typer.echo(_("warning: A has words in G20, which count degrees; if A is linear on your machine, give --linear-a"), err=True)
    for warning in program.listing.warnings:
        typer.echo(_("warning: {}", warning), err=True)
    text = program.listing.text(program.texts)
    if out and out != Path("-"):
        out.write_text(text, encoding="ascii")
        typer.echo(_("{}: {}, of {} as {}", out, count_text(len(program.listing.codes), "line of G-code"), file, program.dialect), err=True)
    elif not picture or out:
        typer.echo(text, nl=False)
    if picture:
        save_picture(picture, program)
        typer.echo(str(picture), err=True)


def _parse_start(text):
    """Return the positions of --start, mm of X, Y, Z and degrees of A, or None. Raises Failure."""
    if text is None:
        return None
    try:
        x, y, z, *a = (float(part) for part in text.split(","))
        if len(a) > 1:
            raise ValueError
    except ValueError:
        raise Failure("--start {}: three numbers are wanted, mm of X, Y and Z, or four, with the degrees of A: --start 0,0,5", text) from None
    return x, y, z, *a


def save_picture(path, program):
    """Write a picture of the path from above, each program line in a colour and with its number. Raises Failure if nothing moves, or the file cannot
    be written."""
    from matplotlib.collections import LineCollection

    from host_tools.drawings.plot import finish_axes, write
    from host_tools.figures import pyplot

    strokes = program.listing.strokes
    if not strokes:
        raise Failure("a program that moves nothing has no picture")
    order = {source: at for at, source in enumerate(sorted({stroke.source for stroke in strokes}))}
    plt = pyplot()
    figure, axes = plt.subplots(figsize=(10, 9), layout="constrained")
    colors = plt.get_cmap("turbo")
    rapids = [[point[:2] for point in stroke.points] for stroke in strokes if stroke.rapid]
    cuts = [stroke for stroke in strokes if not stroke.rapid]
    axes.add_collection(LineCollection(rapids, colors="#9cc3e6", linewidths=0.7, linestyles="dashed", label=_("rapid")))
    axes.add_collection(
        LineCollection(
            [[point[:2] for point in stroke.points] for stroke in cuts], linewidths=1.2,
            colors=[colors(order[stroke.source] / max(1, len(order) - 1)) for stroke in cuts], label=_("feed, by line of the program"),
        )
    )  # fmt: skip
    holes = [stroke.points[-1] for stroke in cuts if stroke.points[0][:2] == stroke.points[-1][:2] and len(stroke.points) == 2]
    if holes:
        axes.plot([point[0] for point in holes], [point[1] for point in holes], "o", color="#d03030", markersize=4, label=_("straight down"))
    _label_strokes(axes, cuts or strokes, len(program.texts) > 1)
    finish_axes(figure, axes, f"{program.name} ({program.dialect}): {count_text(len(program.listing.codes), 'line of G-code')}")
    write(figure, path)


def _label_strokes(axes, strokes, files):
    """Write the numbers of up to _MOST_LABELS program lines beside their longest strokes; with several `files`, their names too."""
    longest = {}
    for stroke in strokes:
        box = [max(point[axis] for point in stroke.points) - min(point[axis] for point in stroke.points) for axis in (0, 1)]
        if max(box) > longest.get(stroke.source, (0, None))[0]:
            longest[stroke.source] = max(box), stroke
    shown = sorted(longest.values(), key=lambda each: -each[0])[:_MOST_LABELS]
    for size, stroke in shown:
        points = stroke.points
        middle = points[len(points) // 2]
        if len(points) == 2:
            middle = [(a + b) / 2 for a, b in zip(*points)]
        text = str(stroke.source) if files else str(stroke.source.line)
        axes.annotate(text, middle[:2], fontsize=7, xytext=(2, 2), textcoords="offset points", color="#333333")
