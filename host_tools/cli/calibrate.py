"""`passo calibrate`: steps/mm, backlash and squareness from measured lengths."""

from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.failure import Failure

_AXES = "xyza"
_TABLE = """\
# Fill in what you measure: a line a length with the mean of so many readings and their standard deviation, or a line a reading.
# Two diagonals of a rectangle (xy+ from the lower left corner, xy- from the lower right) tell whether the axes are square.
# axis  commanded  measured  sigma  readings  after
"""


def calibrate(
    table: Path = typer.Argument(..., help="The lengths: axis, commanded mm, measured mm, sigma, readings, turn or same."),
    board: Annotated[
        Optional[str], typer.Option(help="Board file with the steps/mm that were used: a name, or the path of a .py file.")
    ] = None,
    steps_per_mm: Annotated[
        Optional[str], typer.Option(metavar="X,Y[,Z]", help="The steps/mm that were used, instead of the board file's.")
    ] = None,
    reading: Annotated[float, typer.Option(min=0.0001, max=10, help="What one reading is uncertain by, in mm.")] = 0.02,
    port: Annotated[
        Optional[str], typer.Option(help="A machine that speaks G-code: its steps/mm were used, --write goes there.")
    ] = None,
    baud: Annotated[int, typer.Option(help="Bits per second of a serial port.")] = 115200,
    write: Annotated[bool, typer.Option("--write", help="Set $100… of the machine at --port to what is right.")] = False,
    anyway: Annotated[bool, typer.Option("--anyway", help="Write although the mechanics are at fault, or nothing is known.")] = False,
    pattern: Annotated[
        Optional[Path], typer.Option(help="Write G-code that draws the lengths to be measured to this file, and a new TABLE to fill in.")
    ] = None,
    lengths: Annotated[str, typer.Option(metavar="MM,MM…", help="The lengths of --pattern.")] = "10,20,50,100",
    strokes: Annotated[int, typer.Option(min=2, max=100, help="Of --pattern: strokes of each length.")] = 10,
    feed: Annotated[float, typer.Option(min=1, max=100_000, help="Of --pattern: mm/min.")] = 600.0,
):  # fmt: skip
    """Find the right steps/mm by least squares, with its uncertainty; backlash; squareness; and what is at fault.

    Lengths at several distances are wanted: of one alone nobody can tell a wrong scale from backlash. If a line through them leaves
    more than their scatter explains, the mechanics are at fault (play that changes, slip, a bent screw) or the measuring, and no
    steps/mm makes it right. Uncertainties are standard ones: the true value lies within twice of it in 95 of 100 cases.

    Examples:

        passo calibrate docs/torch_2020.txt --board torch_manipulator

        passo calibrate table.txt --pattern strokes_x.gcode --lengths 20,50,100,200

        passo calibrate table.txt --port /dev/ttyACM0 --write
    """
    from host_tools.programs import calibration

    if pattern:
        _write_pattern(calibration, table, pattern, lengths, strokes, feed)
        return
    if write and not port:
        raise Failure("--write wants the --port of a machine that speaks G-code; of others, change steps_per_m in the board file")
    if sum(source is not None for source in (board, steps_per_mm, port)) != 1:
        raise Failure("which steps/mm were used? Give one of --board, --steps-per-mm and --port")
    rows = calibration.read(table)
    used = _machine_scales(port, baud) if port else _given(steps_per_mm) if steps_per_mm else _board_scales(board)
    fits = _fits(rows, used, reading)
    for fit in fits:
        print("\n".join(told(fit, used[fit.axis])))
    diagonals = [row for row in rows if len(row.axis) > 1]
    for square in calibration.squareness(diagonals, {fit.axis: fit.scale for fit in fits}, reading):
        print(told_square(square))
    if write:
        _write(fits, port, baud, anyway)


def _fits(rows, used, reading):
    """The fit of each axis that was measured."""
    from host_tools.programs import calibration

    fits = []
    for axis in _AXES:
        own = [row for row in rows if row.axis == axis]
        if own and axis not in used:
            raise Failure(f"the machine has no axis {axis.upper()}: steps/mm are known of {', '.join(used).upper()}")
        if own:
            fits.append(calibration.fit_axis(own, used[axis], reading))
    return fits


def told(fit, used):
    """What was found of an axis, in lines."""
    name = fit.axis.upper()
    yield f"{name}  steps/mm {fit.steps_per_mm:.3f} ± {fit.u_steps_per_mm:.3f}, {used:g} were used; scale {fit.scale:.5f} ± {fit.u_scale:.5f}"
    what = "backlash" if fit.split else "backlash (with the readings' offset)"
    yield f"   {what} {fit.backlash:.3f} ± {fit.u_backlash:.3f} mm" + (f", offset of the readings {fit.offset:.3f} mm" if fit.split else "")
    for commanded, measured, rest, sigma in fit.left:
        yield f"   {commanded:8g} mm commanded, {measured:.3f} measured ± {sigma:.3f}, {rest:+.3f} from the line"
    chance = "" if fit.chance is None else f"; by chance {_percent(fit.chance)}"
    yield f"   χ² {fit.chi2:.2f} of {fit.freedom} degrees of freedom{chance}"
    yield f"   {_VERDICTS[fit.verdict](fit)}"


def _percent(chance):
    return f"{chance:.0%}" if chance >= 0.01 else f"{chance:.1%}" if chance >= 0.001 else "less than 0.1%"


def _mechanics(fit):
    worst = max(fit.left, key=lambda row: abs(row[2] / row[3]))
    text = f"MECHANICS, or the measuring: {worst[0]:g} mm lies {abs(worst[2]):.2f} mm off the best line, {abs(worst[2] / worst[3]):.0f} times what its readings scatter"
    if abs(fit.scale - 1) > 2 * fit.u_scale:
        text += f"; beside it the scale is wrong: {fit.steps_per_mm:.2f} steps/mm would be nearer"
    return text


def _scale(fit):
    return f"SCALE: lengths come out {abs(fit.scale - 1):.2%} too {'long' if fit.scale > 1 else 'short'}; with {fit.steps_per_mm:.3f} steps/mm they are right" + _play(fit)


def _play(fit):
    if fit.backlash > 2 * fit.u_backlash:
        return f". Backlash of {fit.backlash:.2f} mm after each turn stays"
    if fit.backlash < -2 * fit.u_backlash:
        return f". All lengths are {-fit.backlash:.2f} mm too long: measure between the same edges"
    return ""


_VERDICTS = {
    "right": lambda fit: "RIGHT: the steps/mm are as good as these lengths can tell" + _play(fit),
    "scale": _scale,
    "mechanics": _mechanics,
    "unknown": lambda fit: "UNKNOWN: give three lengths or more with several readings each, to tell the scale from the mechanics",
}  # fmt: skip


def told_square(square):
    sure = abs(square.mm_m) > 2 * square.u_mm_m
    first, second = square.axes.upper()
    side = "towards" if square.mm_m > 0 else "away from"
    verdict = f"{second} leans {side} {first}+: turn it by {abs(square.degrees):.3f}°" if sure else "square, as far as these diagonals can tell"
    return f"{first}{second} {square.mm_m:+.2f} ± {square.u_mm_m:.2f} mm at 1 m: {verdict}"


def _given(text):
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if not 1 <= len(values) <= 4 or min(values) <= 0:
        raise Failure(f"--steps-per-mm wants one number an axis, above 0, as in 48,83, not {text!r}")
    return dict(zip(_AXES, values))


def _board_scales(name):
    from host_tools import boards

    return {axis["name"]: axis["steps_per_m"] / 1000 for axis in boards.load(name)["axes"]}


def _machine_scales(port, baud):
    from host_tools.clients.grbl import GrblClient

    with GrblClient(port, baud) as client:
        client.connect()
        values = dict(line.split("=") for line in client.command("$$") if line.startswith("$"))
    return {axis: float(values[f"${100 + number}"]) for number, axis in enumerate(_AXES) if f"${100 + number}" in values}


def _write(fits, port, baud, anyway):
    """Set the steps/mm that are known to be wrong. Raises Failure, before anything is written, if a fit does not allow it."""
    from host_tools.clients.grbl import GrblClient

    doubtful = [fit.axis.upper() for fit in fits if fit.verdict in ("mechanics", "unknown")]
    if doubtful and not anyway:
        raise Failure(f"nothing is written: {', '.join(doubtful)} has no scale to be trusted; --anyway writes it all the same")
    wanted = [fit for fit in fits if anyway or fit.verdict == "scale"]
    if not wanted:
        print("nothing to write: the steps/mm are right")
        return
    with GrblClient(port, baud) as client:
        client.connect()
        for fit in wanted:
            line = f"${100 + _AXES.index(fit.axis)}={fit.steps_per_mm:.3f}"
            client.command(line)
            print(f"written: {line}")
    print("home the machine again before it cuts: its millimetres have changed")


def _write_pattern(calibration, table, pattern, text, strokes, feed):
    try:
        lengths = [float(part) for part in text.split(",")]
    except ValueError:
        lengths = []
    if len(set(lengths)) < 2 or min(lengths) <= 0 or max(lengths) > 10_000:
        raise Failure(f"--lengths wants two different lengths or more, in mm, as in 10,20,50,100, not {text!r}")
    if table.exists():
        raise Failure(f"{table} is there already: name a new table, or move that one away")
    files = {table: _TABLE}
    for axis in "xy":
        path = pattern.with_name(f"{pattern.stem}_{axis}{pattern.suffix}")
        files[path] = "\n".join(calibration.pattern(axis, lengths, strokes, feed)) + "\n"
        files[table] += "".join(f"#{axis}      {length:<9g}  ?         ?      {strokes:<8}  turn\n" for length in lengths)
    for path, content in files.items():
        try:
            path.write_text(content, encoding="utf-8")
        except OSError as error:
            raise Failure(f"cannot write {path}: {error.strerror}") from error
        print(path)
