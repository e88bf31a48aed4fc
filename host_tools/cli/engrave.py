"""`passo engrave`: a picture, burnt by a laser."""

import contextlib
from functools import partial
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli import resume_gcode
from host_tools.cli.draw import parse_corner
from host_tools.cli.stream import make_ready, send
from host_tools.failure import Failure
from host_tools.language import _, count_text, line_text
from host_tools.programs.program_names import CARD

DIALECTS = "plain", "cluster", "frames"
EXAMPLES = """Engrave a picture with a laser: to its size, in rows of dots, as G-code that is sent or kept.

Examples:

    passo engrave photo.jpg --width 60 --preview photo.png
    passo engrave photo.jpg --width 60 --power 35 --speed 6000 --port /dev/ttyACM0 --unlock
    passo engrave photo.jpg --width 60 --shade grey --curve card.jpg -o photo.gcode
    passo engrave photo.jpg --width 60 --power 35 --speed 6000 --port /dev/ttyACM0 --continue
    passo engrave --card --power 60 -o card.gcode

The lower left corner of the picture lies at the program's zero, or at --origin. The head needs room on both sides to speed up and
slow down, with the beam off; passo says how much. --frame runs around everything at a low power first, and waits: r goes on.

If it is interrupted, give the same command with --continue: it goes on at the dot where it stopped.

--card burns patches of 0 to 100 % of the power. Photograph the burnt card, cut the picture to its frame, and give it as --curve: grey
tones then come out as they are in the picture. A text with lines of POWER DARKNESS in % does as well.

Wear glasses for the laser's wavelength. Never leave it alone while it burns.
"""


def engrave(
    file: Annotated[Optional[Path], typer.Argument(help="The picture: JPEG, PNG, and what else pillow reads.")] = None,
    card: Annotated[bool, typer.Option("--card", help="Burn the test card instead of a picture.")] = False,
    width: Annotated[Optional[float], typer.Option(min=0.1, help="Width in mm; the height follows.")] = None,
    height: Annotated[Optional[float], typer.Option(min=0.1, help="Height in mm; the width follows.")] = None,
    dots: Annotated[float, typer.Option(min=0.5, max=50, help="Dots a millimetre, along the rows and across: 10 are 254 dpi.")] = 10.0,
    shade: Annotated[str, typer.Option(help="jarvis, floyd: dots, dense where it is dark; threshold: black and white; grey: the power varies.")] = "jarvis",
    threshold: Annotated[float, typer.Option(min=1, max=100, help="With threshold: darkness in % from which a dot burns.")] = 50.0,
    greys: Annotated[int, typer.Option(min=2, max=1000, help="With grey: how many powers. Fewer make shorter files.")] = 64,
    black: Annotated[float, typer.Option(min=0, max=100, help="Brightness in % that counts as black.")] = 0.0,
    white: Annotated[float, typer.Option(min=0, max=100, help="Brightness in % that counts as white.")] = 100.0,
    gamma: Annotated[float, typer.Option(min=0.1, max=10, help="Above 1: middle tones get lighter.")] = 1.0,
    invert: Annotated[bool, typer.Option("--invert", help="Burn what is light: for slate, mirrors, painted metal.")] = False,
    curve: Annotated[Optional[Path], typer.Option(help="Darkness by power: a picture of the burnt card, or a text.")] = None,
    power: Annotated[float, typer.Option(min=0, max=100, help="Power of the darkest dots, in % of full power.")] = 20.0,
    least: Annotated[float, typer.Option(min=0, max=100, help="Power of the lightest dots that burn.")] = 0.0,
    speed: Annotated[float, typer.Option(min=1, help="Speed along the rows, in mm/min.")] = 3000.0,
    one_way: Annotated[bool, typer.Option("--one-way", help="All rows from left to right: slower, in register on any machine.")] = False,
    offset: Annotated[float, typer.Option(min=-5, max=5, help="Move the rows from right to left by so many mm.")] = 0.0,
    overscan: Annotated[Optional[float], typer.Option(min=0, help="Room before and behind a row, in mm; default: computed from speed and acceleration.")] = None,
    origin: Annotated[str, typer.Option(metavar="X,Y", help="Position of the lower left corner, in mm.")] = "0,0",
    passes: Annotated[int, typer.Option(min=1, max=100, help="Burn everything so many times.")] = 1,
    constant: Annotated[bool, typer.Option("--constant", help="M3: the power does not follow the speed. Default M4.")] = False,
    air: Annotated[bool, typer.Option("--air", help="Air assist by M8.")] = False,
    frame: Annotated[Optional[float], typer.Option(min=0, max=10, help="Run around everything at so many % of full power first, and wait.")] = None,
    dialect: Annotated[Optional[str], typer.Option(help="plain: a line for each power; cluster: up to 16 dots a line, which other boards of LightBurn's take as well; frames: up to 100 packed dots a line, for Passo only, in frames if the link has them. Default: what the machine at --port takes, plain for a file.")] = None,
    board: Annotated[str, typer.Option(help="Board by name, or the path of a board file: its speeds and full power.")] = "laser_xy",
    out: Annotated[Optional[Path], typer.Option("-o", "--out", help="Write the G-code to this file.")] = None,
    preview: Annotated[Optional[Path], typer.Option(metavar="PNG", help="A picture of what will burn, and in which order.")] = None,
    port: Annotated[Optional[str], typer.Option(help="Send it to the machine at this port; its settings count instead of the board's.")] = None,
    baud: Annotated[int, typer.Option(help="Bits per second of a serial port.")] = 115200,
    home: Annotated[bool, typer.Option("--home", help="Home the machine first.")] = False,
    unlock: Annotated[bool, typer.Option("--unlock", help="Leave an alarm without homing first.")] = False,
    continued: Annotated[bool, typer.Option("--continue", help="Go on amid the row where it was interrupted: with the same picture and options. The board needs a journal.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="With --continue: do not ask before it burns.")] = False,
):  # fmt: skip
    from host_tools.drawings import engraving

    if (file is None) != card:
        raise Failure("give a picture, or --card")
    if shade not in engraving.SHADES:
        raise Failure("--shade is one of {}, not {!r}", ", ".join(engraving.SHADES), shade)
    if dialect not in (None, *DIALECTS):
        raise Failure("--dialect is one of {}, not {!r}", ", ".join(DIALECTS), dialect)
    options = engraving.Options(
        width, height, dots, shade, threshold / 100, greys, black / 100, white / 100, gamma, invert,
        engraving.read_curve(curve) if curve else (), power / 100, min(least, power) / 100, speed, one_way, offset, overscan, parse_corner(origin),
        passes, constant, air, None if frame is None else frame / 100,
    )  # fmt: skip
    if continued and not port:
        raise Failure("--continue goes on at a machine: give --port")
    with contextlib.ExitStack() as ends:
        client = _connect_machine(ends, port, baud, home, unlock, continued) if port else None
        rest = partial(resume_gcode.go_on, stored=0, home=home, unverified=False, yes=yes) if continued else None
        _carry_out(file, options, board, dialect, client, out, preview, rest)


engrave.__doc__ = EXAMPLES


def _carry_out(file, options, board, dialect, client, out, preview, go_on):
    """Shade the picture, or make the test card if there is no `file`; print its size and time; write, draw or send it. `go_on`: function that goes on
    with an interrupted one, or None. Raises Failure."""
    from rich.console import Console

    from host_tools import boards
    from host_tools.drawings import engraving
    from host_tools.programs import gcode_file, gcode_time

    console = Console()
    machine = engraving.Machine.of_settings(client.command("$$")) if client else engraving.Machine.of_board(boards.load(board), board)
    _choose_dialect(dialect, machine, client)
    options.speed = _limit_speed(console, options.speed, machine)
    picture = engraving.open_picture(file) if file else engraving.draw_card(options)
    with console.status(_("shading")) as status:
        powers = engraving.powers_of(picture, options, lambda share: status.update(_("shading: {:.0%}", share)))
    rows = engraving.rows_of(powers, options)
    lines = [(number, line.encode()) for number, line in enumerate(engraving.gcode_lines(rows, options, machine), 1)]
    seconds = sum(gcode_time.estimate_seconds(lines, machine.limits))
    _print_plan(console, powers, rows, options, machine, len(lines), seconds)
    if preview:
        save_preview(preview, powers, rows, options, machine, seconds)
        console.print(str(preview))
    if out:
        with out.open("wb") as written:
            written.writelines(line + b"\n" for _number, line in lines)
        console.print(f"{out}: {count_text(len(lines), 'line')}")
    if client:
        name = file.name if file else CARD
        if go_on:
            go_on(client, lines, name)
            return
        seconds, count = send(client, lines, name, True, None, False, line_text)
        console.print(_("{}: {} in {}", name, count_text(count, "line"), gcode_file.clock_text(seconds)))


def _choose_dialect(dialect, machine, client):
    """Choose how rows of dots are written: packed, if the machine takes that. Raises Failure if `dialect` asks for rows that the machine does not
    take."""
    from host_tools.drawings import engraving

    if dialect == "plain" or not (client or dialect):
        return
    if not client:
        machine.packed = dialect == "frames"
        machine.cluster = engraving.PACKED if machine.packed else engraving.CLUSTER
        return
    answer = client.command("$I")
    if dialect != "cluster" and machine.takes_rows(answer, True) or dialect != "frames" and machine.takes_rows(answer):
        return
    if dialect:
        raise Failure("this machine takes no such rows of dots: its $I does not say so; give --dialect plain")


def _connect_machine(ends, port, baud, home, unlock, continued):
    """Return a connected GrblClient, ready to send; `ends` closes it. Raises Failure if the machine is in alarm."""
    from host_tools.clients.grbl import GrblClient

    client = ends.enter_context(GrblClient(port, baud))
    if continued:
        resume_gcode.wait_until_settled(client)
    else:
        make_ready(client, home, unlock)
    return client


def _limit_speed(console, speed, machine):
    """Return `speed` (mm/min), at most the machine's own; print a note if that is less."""
    if speed > machine.speed:
        console.print(_("  [yellow]{:g} mm/min is more than the machine goes: {:g}[/yellow]", speed, machine.speed))
    return min(speed, machine.speed)


def _print_plan(console, powers, rows, options, machine, lines, seconds):
    """Print size, dots, time and the head's travel, and the speed up to which a link carries all powers."""
    from host_tools.drawings import engraving
    from host_tools.programs.gcode_file import clock_text

    height, width = powers.shape
    left, bottom, right, top = engraving.bounds_mm(rows, options, machine)
    console.print(
        _("  {:g} × {:g} mm, {} × {} dots, {} rows that burn, {}, {}", width / options.dots_mm, height / options.dots_mm,
          width, height, len(rows), count_text(lines, "line of G-code"), clock_text(seconds))
    )  # fmt: skip
    console.print(
        _("  the head goes from X{:.1f} to X{:.1f} and from Y{:.1f} to Y{:.1f}: {:.1f} mm beside the dots, to speed up",
          left, right, bottom, top, engraving.overscan_length(options, machine))
    )  # fmt: skip
    rate, most = engraving.powers_s(rows, options, machine)
    if rate > most:
        slower = options.speed * most / rate
        console.print(
            _("  [yellow]the densest row wants {:.0f} powers a second, and a link carries some {}: the machine slows down there. At {:.0f} mm/min it "
              "would not.[/yellow]", rate, most, slower)
        )  # fmt: skip


def save_preview(path, powers, rows, options, machine, seconds):
    """Draw the powers of the dots in grey, and the head's overscan at both ends of each row, coloured in the order of rows. Raises Failure if the
    file cannot be written."""
    from matplotlib.collections import LineCollection

    from host_tools.drawings import engraving
    from host_tools.drawings.plot import finish_axes, write
    from host_tools.figures import pyplot
    from host_tools.programs.gcode_file import clock_text

    height, width = powers.shape
    x, y = options.origin
    plt = pyplot()
    figure, axes = plt.subplots(figsize=(10, 8), layout="constrained")
    most = max(options.power, 1e-9)
    axes.imshow(1 - powers / most, cmap="gray", vmin=0, vmax=1, origin="lower", interpolation="antialiased",
                extent=(x, x + width / options.dots_mm, y, y + height / options.dots_mm), zorder=1)  # fmt: skip
    over = engraving.overscan_length(options, machine)
    ways = []
    for row in rows:
        side = -over if row.backward else over
        begin, end = row.begin, row.end
        ways += [[(begin - side, row.y), (begin, row.y)], [(end, row.y), (end + side, row.y)]]
    colors = plt.get_cmap("turbo")([at / max(1, len(ways) - 1) for at in range(len(ways))])
    axes.add_collection(LineCollection(ways, colors=colors, linewidths=0.6, label=_("speeding up and slowing down, beam off; the first row is blue")))
    finish_axes(figure, axes, _("{:g} × {:g} mm at {:g} mm/min, {}", width / options.dots_mm, height / options.dots_mm, options.speed, clock_text(seconds)))
    write(figure, path)
