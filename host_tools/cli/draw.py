"""`passo draw`: an SVG file, drawn by a plotter, or by G-code on any other machine."""

import inspect

from host_tools.cli.draw_options import PLACED, Said
from host_tools.failure import Failure, reason
from host_tools.language import _, count_text
from host_tools.programs.journal import Journal

EXAMPLES = """Draw a file on a plotter, or by G-code on a laser, a router or any other machine that speaks grbl.

Examples:

    passo draw map.svg --port /dev/ttyACM0
    passo draw map.svg --port /dev/ttyACM0 --fit --margin 20
    passo draw map.svg --scale 0.5 --origin 30,40 --dry-run --preview map.png
    passo draw map.svg --port /dev/ttyACM0 --layer 2
    passo draw map.svg --port /dev/ttyACM0 --continue
    passo draw sign.svg --board laser_xy --power 400 --feed 1200 -o sign.gcode
    passo draw map.plt --pens layers --marks --port /dev/ttyACM0
    passo draw part.dxf --hatch 45,1 --hatch 2:0,0.5,crossed --preview -
    passo draw a.svg b.svg c.svg --gap 3 --board laser_xy -o sheet.gcode
    passo draw outline.svg --unseen --board laser_xy -o outline.gcode
    passo draw label.svg --copies 4x6 --gap 2 --place outlines --port /dev/ttyACM0
    passo draw sign.svg --board router_3axis --depth 1.5 --passes 3 --for 2:depth=0.3,passes=1

The page lies with its lower left corner at 0;0, in its real size. It is reduced if it is larger than the table and has
lines beyond it. Several drawings are nested on the table, their outlines --gap apart.

--pens layers draws one layer after the other, and waits for the next pen in between; --pens colours does that by the colour of lines.
Layers that are drawn one by one, by --layer, fall on each other if the options of size and position are the same.

What nobody sees in an SVG file is left out and named, a white background too: --unseen draws it.

Lines are joined and put in an order of little travel; --keep-order leaves them as they are in the file.

By G-code 0;0 is the zero of the work, and Z0 its surface. A laser burns by M4 and S; a tool on Z goes down to --depth in --passes
and up to --lift; a machine without Z lowers its tool by M3 S and lifts it by M5. -o writes the file, for passo check and any sender.

If a plotter keeps a journal (docs/use/jobs.md), --continue goes on amid a line, at the very step; so it does with a stored job.

Ctrl-C stops the machine, pen up. --continue with the same options goes on from there, also after the board was unplugged or
the PC went to sleep.
"""

def draw(**given):
    from rich.console import Console

    from host_tools.cli import draw_gcode, draw_picture, draw_run
    from host_tools.drawings import drawing

    said = Said(**given)
    machine, spoken = machine_of(said.board, said.out)
    options = options_of(said.options_to_keep())
    console = Console()
    if spoken == "plotter":
        machine, whose = machine_as_running(machine, said)
        console.print(whose, soft_wrap=True)
    names = ", ".join(map(str, said.file))
    with console.status(_("reading {}", names)) as status:
        plan = drawing.load(said.file, machine, options, lambda text, share: status.update(f"{_(text)} {names}: {share:.0%}"))
    job = (draw_run.Plotted if spoken == "plotter" else draw_gcode.Written)(machine, plan, said)
    _print_plan(console, plan, options, job)
    if said.preview:
        draw_picture.write(console, said.preview, plan, machine, job.seconds)
    if said.dry_run:
        return
    if said.out:
        job.write(console, said.out)
        return
    record = Journal(said.journal or Journal.path_beside(said.file[0]), job.digest, said.points, said.options_to_keep())
    if not said.resume:
        record.check_writable()
        if record.is_begun():
            console.print(_("  [yellow]begun before and not finished: it is drawn anew; --continue would go on[/yellow]"))
    job.run(console, record, said)


draw.__doc__ = EXAMPLES
draw.__signature__ = inspect.signature(Said)
draw.__annotations__ = Said.__annotations__


def machine_as_running(machine, said):
    """Return (board file with the steps/mm of the board that is to draw, a line that says whose they are)."""
    from host_tools.cli import draw_run, ports
    from host_tools.running_board import as_running

    sends = not said.dry_run and not said.out
    port = said.port or (ports.only_port() if sends else None)
    return as_running(machine, "plotter", port, said.baud or draw_run.BAUD)


def options_of(said):
    """Return the Options of a dict of the command's options; missing ones have their defaults. Raises Failure if the origin is wrong."""
    from host_tools.drawings.drawing import Options

    known = {key: said[key] for key in PLACED if key in said}
    return Options(origin=parse_corner(said.get("origin")), layers=tuple(said.get("layer") or ()), hatch=tuple(said.get("hatch") or ()), **known)


def parse_corner(text):
    """Return (x, y) in mm of --origin, or None. Raises Failure unless there are two numbers."""
    if text is None:
        return None
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise Failure("--origin wants two lengths in mm, as in 30,40, not {!r}", text) from None
    return x, y


def load_plotter(name):
    """Return the checked board file. Raises Failure if none of its links speaks the plotter's language."""
    machine, spoken = machine_of(name)
    if spoken != "plotter":
        raise Failure("board {} speaks {}, and no plotter's language", name, spoken)
    return machine


def machine_of(name, out=None):
    """Return (checked board file, "plotter" or "grbl"). Raises Failure if its links speak neither, unless G-code goes to a file, `out`."""
    from host_tools import boards
    from passo.config.boardfile import BoardError, check

    try:
        board = check(boards.load(name))
    except BoardError as error:
        raise Failure("board {}: {}", name, reason(error)) from error
    spoken = sorted({link["protocol"] for link in board["links"]})
    for language in ("plotter", "grbl"):
        if language in spoken:
            return board, language
    if not out:
        raise Failure("board {} speaks {}: passo draw speaks to plotters, and in G-code; -o writes G-code to a file", name, ", ".join(spoken))
    return board, "grbl"


def _print_plan(console, plan, options, job):
    """Print the size, layers, lengths and estimated time of a drawing, and its notes."""
    from rich.markup import escape

    from host_tools.drawings import drawing
    from host_tools.programs import estimate

    down, up = plan.lengths_mm()
    console.print(_("[bold]{}[/bold] at {} % of its real size", escape(plan.name), drawing.percent_text(plan.scale)))
    for text, (left, bottom, right, top) in (
        (_("  page  {:.1f} × {:.1f} mm, corner at {:.1f}, {:.1f}"), plan.page_mm),
        (_("  drawn {:.1f} × {:.1f} mm, corner at {:.1f}, {:.1f}"), plan.box_mm),
    ):
        console.print(text.format(right - left, top - bottom, round(left, 1) + 0.0, round(bottom, 1) + 0.0))  # no -0.0
    if len(plan.layers) > 1:
        named = ", ".join(f"{number} {name or ''}".rstrip() for number, name in plan.layers.items())
        chosen = _(", drawn: {}", ", ".join(map(str, options.layers))) if options.layers else ""
        console.print(_("  layers {}", escape(named)) + chosen)
    console.print(f"  {count_text(len(plan.lines), 'line')}, {count_text(plan.count_points(), 'point')}")
    console.print(_("  pen down {:.2f} m, pen up {:.2f} m, about {}", down / 1000, up / 1000, estimate.clock_text(job.seconds)))
    if plan.before_mm > up * 1.01:
        later = estimate.clock_text(job.seconds + job.travel_s(plan.before_mm - up))
        console.print(_("  in the order of the file: pen up {:.2f} m, about {}", plan.before_mm / 1000, later))
    for line in job.tool_lines():
        console.print(f"  {line}")
    for note in plan.notes:
        console.print(f"  [yellow]{escape(note)}[/yellow]")
