"""The commands of `passo pulses` that need no board: check, convert, image, example. Those that count in mm ask one for its steps/mm, if they are given
its port."""

import sys
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.options import Baud
from host_tools.failure import Failure, reason
from host_tools.language import _, count_text

BoardName = Annotated[str, typer.Option("--board", help="Board file: a name of boards/, or the path of a .py file.")]
PulseFile = Annotated[Path, typer.Argument(help="The pulse file.")]
Out = Annotated[Optional[Path], typer.Option("-o", "--out", help="The file to write.")]
FilePort = Annotated[Optional[str], typer.Option("--port", help="Count in the steps/mm of the board there; without it in the board file's.")]
BOARD = "lpt_router"
GCODE = (".gcode", ".nc", ".ngc", ".tap", ".g")


def _running_board(name, port, baud):
    """Return _load_board() with the steps/mm of the board at `port`; print whose they are on stderr."""
    from host_tools.running_board import as_running

    config, axes = _load_board(name)
    config, whose = as_running(config, "pulses", port, baud)
    print(whose, file=sys.stderr)
    return config, axes


def _load_board(name):
    """Return (checked board file, names of its axes, at most three). Raises Failure if it has no section step_program."""
    from host_tools import boards
    from passo.config.boardfile import BoardError, check

    try:
        board = check(boards.load(name))
    except BoardError as error:
        raise Failure("board {}: {}", name, reason(error)) from error
    if not board.get("step_program"):
        raise Failure("board {} has no section step_program", name)
    return board, "".join(axis["name"] for axis in board["axes"])[:3]


def check(file: PulseFile, board: BoardName = BOARD, port: FilePort = None, baud: Baud = 115200):
    """Check a file: errors by line and column, number of commands, box, time. Sends nothing.

    Examples:

        passo pulses check square.txt
    """
    from host_tools.programs import pulse_file
    from host_tools.programs.gcode_file import clock_text

    config, axes = _running_board(board, port, baud)
    course = pulse_file.Course(pulse_file.read_items(pulse_file.load_pulses(file), axes, config["step_program"], file), config)
    print(_("commands {}, {} of them steps; {} ({:.1f} s)", course.commands, course.steps, clock_text(course.seconds), course.seconds))
    for number, axis in enumerate(config["axes"]):
        per_mm = axis["steps_per_m"] / 1000
        low, high, end = (place[number] / per_mm for place in (course.low, course.high, course.place))
        print(_("{} {:9.3f} … {:9.3f} mm, ends at {:.3f}", axis["name"].upper(), low, high, end))


def convert(
    file: Annotated[Path, typer.Argument(help="A pulse file, or G-code (.gcode, .nc, .ngc, .tap).")],
    out: Out = None,
    board: BoardName = BOARD,
    side: Annotated[Optional[str], typer.Option(help="left or right: the tool's centre runs beside what was taught.")] = None,
    radius: Annotated[float, typer.Option(min=0.01, max=100, help="Of --side: the tool's, in mm.")] = 1.0,
    port: FilePort = None,
    baud: Baud = 115200,
):
    """Convert a pulse file to a picture or to G-code, or G-code to a pulse file.

    The picture is a .png, .svg or .pdf, dark where the tool is on. -o NAME.gcode makes G-code: straight runs and arcs are recognised,
    and it makes the same steps. With --side each contour, from tool on to tool off, is compensated by the tool's radius. Lines and arcs of G-code become the steps that the firmware
    makes. M3 and M5 switch the tool, G4 waits, M0 asks the operator for the speed, M2 and M30 end it. If the program has no S
    at all, M3 needs none; otherwise S0 is off.

    Examples:

        passo pulses convert hexagon.txt -o hexagon.png
        passo pulses convert taught.txt -o taught.gcode
        passo pulses convert taught.txt -o part.gcode --side left --radius 1.5
        passo pulses convert part.gcode -o part.txt
    """
    from host_tools.drawings import plot
    from host_tools.programs import gcode_file, pulse_file

    config, axes = _running_board(board, port, baud)
    if side not in (None, "left", "right"):
        raise Failure("--side is left or right, not {!r}", side)
    if side and not (out and out.suffix.lower() in GCODE):
        raise Failure("--side makes G-code of a pulse file: name it, as in -o part.gcode")
    if file.suffix.lower() in GCODE:
        target = out or file.with_suffix(".txt")
        _write_text(target, pulse_file.Converter(config).convert(gcode_file.read(file)))
    elif out and out.suffix.lower() in GCODE:
        from host_tools.programs import pulse_gcode
        from host_tools.programs.compensation import LEFT, RIGHT

        target = out
        found = pulse_file.read_items(pulse_file.load_pulses(file), axes, config["step_program"], file)
        beside = ({"left": LEFT, "right": RIGHT}[side], radius) if side else None
        text, counts = pulse_gcode.to_gcode(found, config, beside)
        _write_text(target, text)
        print(_("{} and {} of {}", *(count_text(counts[noun + "s"], noun) for noun in ("line", "arc", "step"))))
    else:
        course = pulse_file.Course(pulse_file.read_items(pulse_file.load_pulses(file), axes, config["step_program"], file), config)
        target = out or file.with_suffix(".png")
        plot.save_picture(target, course.strokes, file.stem)
    print(target)


def _write_text(target, text):
    """Write an ASCII file. Raises Failure if it cannot be written."""
    try:
        target.write_text(text, encoding="ascii")
    except OSError as error:
        raise Failure("cannot write {}: {}", target, reason(error)) from error


def ramps(
    file: PulseFile,
    out: Out = None,
    board: BoardName = BOARD,
    accel: Annotated[Optional[int], typer.Option(min=1, max=900_000, help="mm/s²; default: the board file's.")] = None,
    port: FilePort = None,
    baud: Baud = 115200,
):
    """Give a file acceleration: speeds between its steps, so that it starts, turns corners and stops gently. The steps stay the same.

    Examples:

        passo pulses ramps square.txt -o soft.txt --accel 200
    """
    from host_tools.programs import pulse_file
    from host_tools.programs.pulse_gcode import same_steps
    from host_tools.programs.pulse_ramps import with_ramps

    config, axes = _running_board(board, port, baud)
    accel = accel or config["step_program"]["accel_mm_s2"]
    if not accel:
        raise Failure("board {} asks for no acceleration: step_program.accel_mm_s2 is 0; give --accel", board)
    target = out or file.with_name(f"{file.stem}_ramps{file.suffix}")
    found = pulse_file.read_items(pulse_file.load_pulses(file), axes, config["step_program"], file)
    text = with_ramps(found, config, accel)
    made = pulse_file.read_items(text.encode(), axes, config["step_program"])
    if not same_steps(found, made, len(axes)):
        raise Failure("the steps would not be the same: this is a fault of passo")
    _write_text(target, text)
    print(_("{}: {} cells, {:.1f} s", target, len(made), pulse_file.Course(made, config).seconds))


def image(file: PulseFile, board: BoardName = BOARD):
    """Show the bytes of the parallel port, command by command, in hex.

    Examples:

        passo pulses image square.txt --board boards/mine.py
    """
    from host_tools.programs import pulse_file
    from passo.options.step_program.commands import STEPS_DRIVES, STEPS_TOOL
    from passo.protocols.pulses.report import port_byte

    config, axes = _load_board(board)
    drives = tool = False
    for item in pulse_file.read_items(pulse_file.load_pulses(file), axes, config["step_program"], file):
        kind = 0 if item & 15 else item >> 4 & 15
        if kind == STEPS_DRIVES:
            drives = bool(item >> 8)
        elif kind == STEPS_TOOL:
            tool = bool(item >> 8) and not config["step_program"]["dry_run"]
        elif kind:
            continue
        byte = port_byte(item & 255 if item & 15 else 0, tool, drives, config["step_program"])
        for each in range(item >> 8 if item & 15 else 1):
            print(f"{byte:02X}")


def example(
    shape: Annotated[str, typer.Argument(help="square, triangle, hexagon or octagon.")],
    out: Out = None,
    speed: Annotated[int, typer.Option(min=1, help="mm/min.")] = 1000,
    down: Annotated[float, typer.Option(min=0, help="Lower the tool by so many mm before it cuts.")] = 0.0,
    board: BoardName = BOARD,
    port: FilePort = None,
    baud: Baud = 115200,
):
    """Write an example file: one of the four shapes of LPTControl's document, 10 to 15 cm wide.

    Examples:

        passo pulses example hexagon -o hexagon.txt --speed 800
    """
    from host_tools.programs import pulse_shapes

    if shape not in pulse_shapes.SHAPES:
        raise Failure("{!r} is no example; known are {}", shape, ", ".join(sorted(pulse_shapes.SHAPES)))
    config = _running_board(board, port, baud)[0]
    scale = {axis["steps_per_m"] for axis in config["axes"][:2]}
    if len(scale) != 1:
        raise Failure("board {}: X and Y differ in steps/mm, and a diagonal would not be one", board)
    per_mm = scale.pop() / 1000
    z_per_mm = config["axes"][-1]["steps_per_m"] / 1000
    target = out or Path(f"{shape}.txt")
    _write_text(target, pulse_shapes.shape_text(shape, per_mm, speed, round(down * z_per_mm)))
    print(target)
