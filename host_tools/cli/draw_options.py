"""The options of `passo draw`, one field each: typer reads them from the class, the journal beside a drawing keeps those that decide
where its points are."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.language import _


@dataclass
class Said:
    """Arguments and options of `passo draw`."""

    file: Annotated[list[Path], typer.Argument(help="The drawing: SVG, HPGL, DXF or G-code. Several are nested on one sheet.")]
    port: Annotated[Optional[str], typer.Option(help="Serial port, pty or pyserial URL (socket://host:port).")] = None
    board: Annotated[str, typer.Option(help="Board by name, or the path of a board file.")] = "plotter_2014"
    baud: Annotated[Optional[int], typer.Option(help="Bits per second of a serial port; default 57600 for a plotter, else 115200.")] = None
    fit: Annotated[bool, typer.Option("--fit", help="Enlarge or reduce to fill the table within the margin.")] = False
    center: Annotated[bool, typer.Option("--center", help="In the middle of the table.")] = False
    scale: Annotated[Optional[float], typer.Option(help="Factor of the real size, e.g. 0.5.")] = None
    origin: Annotated[Optional[str], typer.Option(metavar="X,Y", help="Position of the lower left corner, in mm; default 0,0.")] = None
    place: Annotated[str, typer.Option(help="Position and fit the page, or the outlines: the box around all lines.")] = "page"
    margin: Annotated[float, typer.Option(help="Margin that --fit keeps free on the table, in mm.")] = 10.0
    tolerance: Annotated[float, typer.Option(min=0.01, max=1.0, help="How finely curves are followed, in mm.")] = 0.1
    layer: Annotated[
        Optional[list[int]], typer.Option(help="Draw this layer only, at its position among all; may be given more than once.")
    ] = None
    crop: Annotated[bool, typer.Option("--crop/--no-crop", help="Leave out what lies outside the drawing's page.")] = True
    pens: Annotated[
        str, typer.Option(help="layers or colours: each is a pen, and the machine waits for you to change it; none: one pen.")
    ] = "none"
    change: Annotated[
        Optional[str], typer.Option(metavar="GCODE", help="G-code: lines of a pen's change, ; between them, {} for its number; default M0.")
    ] = None
    repeat: Annotated[int, typer.Option(min=1, max=100, help="How often each line is drawn.")] = 1
    copies: Annotated[str, typer.Option(metavar="COLUMNSxROWS", help="Copies side by side, as 3x2.")] = ""
    gap: Annotated[float, typer.Option(min=0.0, max=1000.0, help="Between copies, and between drawings on one sheet, in mm.")] = 5.0
    turn: Annotated[bool, typer.Option("--turn/--no-turn", help="Drawings on one sheet may be turned.")] = True
    nesting: Annotated[int, typer.Option(min=0, help="Drawings on one sheet: the nesting of that number, as passo nest has found it.")] = 0
    hatch: Annotated[
        Optional[list[str]], typer.Option(metavar="[LAYER:]ANGLE,SPACING[,crossed]", help="Fill areas with lines, in degrees and mm.")
    ] = None
    marks: Annotated[bool, typer.Option("--marks", help="Draw crosses at the corners, with each pen.")] = False
    keep_order: Annotated[bool, typer.Option("--keep-order", help="Draw lines in the order of the file.")] = False
    unseen: Annotated[
        bool, typer.Option("--unseen", help="SVG: draw what nobody sees, too: shapes without stroke and fill, and a white background over the page.")
    ] = False
    speed: Annotated[Optional[int], typer.Option(min=1, max=65535, help="Drawing speed, in the board file's unit.")] = None
    points: Annotated[int, typer.Option(min=2, max=60000, help="Most points of an object sent before it is drawn.")] = 1000
    home: Annotated[bool, typer.Option("--home/--no-home", help="Seek the origin before drawing.")] = True
    unlock: Annotated[bool, typer.Option("--unlock", help="G-code: leave an alarm without homing first.")] = False
    resume: Annotated[bool, typer.Option("--continue", help="Continue a drawing that was interrupted.")] = False
    journal: Annotated[Optional[Path], typer.Option(help="Where progress is kept; default FILE.svg.journal.")] = None
    yes: Annotated[bool, typer.Option("--yes", help="With --continue: do not ask before the tool goes down.")] = False
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say what would be drawn; needs no port.")] = False
    out: Annotated[
        Optional[Path], typer.Option("-o", "--out", "--packets", metavar="FILE", help="Write what the machine would be sent: G-code, or a plotter's packets.")
    ] = None
    tool: Annotated[
        Optional[str], typer.Option(help="G-code: laser, z, or m3 (M3 lowers it, M5 lifts it); default: as the board file says.")
    ] = None
    feed: Annotated[Optional[float], typer.Option(help="G-code: speed of lines, in mm/min.")] = None
    plunge: Annotated[Optional[float], typer.Option(help="G-code: speed of Z on its way down, in mm/min.")] = None
    power: Annotated[Optional[float], typer.Option(help="G-code: S of M3 or M4.")] = None
    depth: Annotated[Optional[float], typer.Option(help="G-code: how deep the last pass goes below Z0, in mm.")] = None
    passes: Annotated[Optional[int], typer.Option(help="G-code: how often each line is gone along.")] = None
    lift: Annotated[Optional[float], typer.Option(help="G-code: height of Z between lines, in mm.")] = None
    dwell: Annotated[Optional[float], typer.Option(help="G-code: seconds that the tool takes to go up or down.")] = None
    layers: Annotated[
        Optional[list[str]], typer.Option("--for", metavar="LAYER:NAME=NUMBER,…", help="G-code: other figures for a layer, e.g. 2:feed=300,depth=1; may be given more than once.")
    ] = None
    preview: Annotated[Optional[Path], typer.Option(metavar="FILE", help="A picture of what would be drawn: .png, .svg, or - for this terminal.")] = None
    log: Annotated[Optional[Path], typer.Option(help="Save the conversation on the wire to this file.")] = None
    timeout: Annotated[float, typer.Option(min=0.5, help="Seconds an answer may take.")] = 3.0

    def options_to_keep(self):
        """Return {name: value} of the options that decide where points are: the journal keeps them, to go on with."""
        return {name: getattr(self, name) for name in KEPT}


# Options that drawing.Options has by the same name and type; options_of() converts `origin`, `layer` and `hatch`.
PLACED = (
    "fit", "center", "scale", "place", "margin", "tolerance", "crop", "pens", "repeat", "copies", "gap", "turn", "nesting", "marks", "keep_order", "unseen",
)  # fmt: skip
KEPT = ("board", "speed", "points", "origin", "layer", "hatch", *PLACED)


def pen_of(part):
    """Return number and name of a pen, for people."""
    return f"{part.number} ({part.name})" if part.name else str(part.number)


def continue_advice(record):
    """Return the words that say how to go on with an interrupted drawing."""
    return _("go on with the same command and --continue ({})", record.path) if record else _("go on with passo resume")
