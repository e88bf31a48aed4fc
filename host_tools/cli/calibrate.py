"""`passo calibrate`: steps/mm, backlash and squareness from measured lengths."""

from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.options import AnyBaud
from host_tools.failure import Failure, reason
from host_tools.language import _

_AXES = "xyza"
_MOST_MM = 2.0  # of $160 to $163
_COLUMN = 14  # letters wide
_MOST_STEPS_MM = 100_000
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
        Optional[str], typer.Option(help="The machine, whatever it speaks: its steps/mm were used, --write goes there.")
    ] = None,
    baud: AnyBaud = None,
    protocol: Annotated[Optional[str], typer.Option(help="Language of the link of --port: grbl, torch, pulses, plotter or keys. Default: found by asking.")] = None,
    write: Annotated[bool, typer.Option("--write", help="Set $100…, and $160… if it takes up backlash, of the machine at --port to what is right.")] = False,
    anyway: Annotated[bool, typer.Option("--anyway", help="Write although the mechanics are at fault, or nothing is known.")] = False,
    means: Annotated[bool, typer.Option("--means", help="First the table of the document of 2020: means and standard deviations of each length.")] = False,
    pattern: Annotated[
        Optional[Path], typer.Option(help="Write the program that draws the lengths to be measured to this file, in G-code or the language of --board, and a new TABLE to fill in.")
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

        passo calibrate examples/torch_2020.txt --board torch_manipulator
        passo calibrate examples/torch_2020.txt --board torch_manipulator --means
        passo calibrate table.txt --pattern strokes_x.gcode --lengths 20,50,100,200
        passo calibrate table.txt --pattern strokes.txt --board plotter_2014
        passo calibrate table.txt --port /dev/ttyACM0 --write
        passo calibrate table.txt --port /dev/ttyUSB0 --protocol torch --write
    """
    from host_tools.programs import calibration

    if pattern:
        _write_pattern(calibration, table, pattern, lengths, strokes, feed, board)
        return
    if write and not port:
        raise Failure("--write wants the --port of the machine")
    if sum(source is not None for source in (board, steps_per_mm, port)) != 1:
        raise Failure("which steps/mm were used? Give one of --board, --steps-per-mm and --port")
    rows = calibration.read(table)
    link = port and (port, baud, protocol)
    used, taken = _scales_of_machine(*link) if link else (_parse_steps_per_mm(steps_per_mm), {}) if steps_per_mm else _scales_of_board(board)
    fits = _fit_axes(rows, used, reading)
    if means:
        print("\n".join(table_of_means(calibration.characterise(rows))), end="\n\n")
    _print_fits(fits, used, taken)
    diagonals = [row for row in rows if len(row.axis) > 1]
    for square in calibration.squareness(diagonals, {fit.axis: fit.scale for fit in fits}, reading):
        print(square_text(square))
    if write:
        _write_settings(fits, taken, link, anyway)


def _print_fits(fits, used, taken):
    """Print the lines of each axis's fit, and how to take up its backlash."""
    for fit in fits:
        print("\n".join(fit_lines(fit, used[fit.axis])))
        print("".join(f"   {line}\n" for line in backlash_advice(fit, taken)), end="")


def table_of_means(lengths):
    """Yield the lines of table 1 of the document of 2020: the length commanded, then mean and standard deviation of each axis, in mm. `lengths`: {mm:
    {axis: (mean, deviation)}}."""
    axes = sorted({axis for means in lengths.values() for axis in means})
    wide = 2 * _COLUMN + 1
    yield _("Measured movement, in mm")
    yield f"{_('Expected value'):<{_COLUMN}}" + "".join(f" {_('Axis {}', axis.upper()):<{wide}}" for axis in axes).rstrip()
    yield " " * _COLUMN + "".join(f" {_('Mean'):<{_COLUMN}} {_('Deviation'):<{_COLUMN}}" for _axis in axes).rstrip()
    for length, means in lengths.items():
        cells = [f" {means[axis][0]:<{_COLUMN}.3f} {means[axis][1]:<{_COLUMN}.3f}" if axis in means else " " * (wide + 1) for axis in axes]
        yield f"{length:<{_COLUMN}g}" + "".join(cells).rstrip()


def backlash_advice(fit, taken):
    """Yield lines that say how to take up the backlash found, if the fit is sure of it. `taken`: {axis: mm taken up already}; empty if the board has
    no key "backlash"."""
    play = total_backlash(fit, taken)
    if play is None:
        return
    if not taken:
        yield _('backlash is taken up by machines with the key "backlash" in the board file: "{}": {:.0f}', fit.axis, 1000 * play)
    elif play > _MOST_MM:
        yield _("{:.3f} mm are more than can be taken up, {:g}: look for what is loose", play, _MOST_MM)
    else:
        line = f"${160 + _AXES.index(fit.axis)}={play:.3f}"
        yield _("{} takes it up", line) if fit.split else _("{} takes it up, if the readings have no offset: measure lengths with `same`, too", line)


def total_backlash(fit, taken):
    """Return the backlash to take up in all, mm ≥ 0; None if the measured one is within twice its standard uncertainty."""
    if fit.verdict in ("mechanics", "unknown") or abs(fit.backlash) <= 2 * fit.u_backlash:
        return None
    return max(fit.backlash + taken.get(fit.axis, 0), 0)


def _fit_axes(rows, used, reading):
    """Return the fit of each axis measured. `used`: {axis: steps/mm}; `reading`: uncertainty of one reading, mm. Raises Failure for an axis that the
    machine lacks."""
    from host_tools.programs import calibration

    fits = []
    for axis in _AXES:
        own = [row for row in rows if row.axis == axis]
        if own and axis not in used:
            raise Failure("the machine has no axis {}: steps/mm are known of {}", axis.upper(), ", ".join(used).upper())
        if own:
            fits.append(calibration.fit_axis(own, used[axis], reading))
    return fits


def fit_lines(fit, used):
    """Yield lines with the fit of an axis: steps/mm (`used`: those of the measurement), backlash in mm, the distance of each reading from the line,
    χ², verdict."""
    name = fit.axis.upper()
    text = _("{}  steps/mm {:.3f} ± {:.3f}, {:g} were used; scale {:.5f} ± {:.5f}")
    yield text.format(name, fit.steps_per_mm, fit.u_steps_per_mm, used, fit.scale, fit.u_scale)
    if fit.split:
        yield _("   backlash {:.3f} ± {:.3f} mm, offset of the readings {:.3f} mm", fit.backlash, fit.u_backlash, fit.offset)
    else:
        yield _("   backlash (with the readings' offset) {:.3f} ± {:.3f} mm", fit.backlash, fit.u_backlash)
    for commanded, measured, rest, sigma in fit.left:
        yield _("   {:8g} mm commanded, {:.3f} measured ± {:.3f}, {:+.3f} from the line", commanded, measured, sigma, rest)
    chance = "" if fit.chance is None else _("; by chance {}", _percent_text(fit.chance))
    yield _("   χ² {:.2f} of {} degrees of freedom", fit.chi2, fit.freedom) + chance
    yield f"   {_VERDICTS[fit.verdict](fit)}"


def _percent_text(chance):
    """Return a probability, 0 … 1, as a percentage: whole above 1 %, with one decimal above 0.1 %."""
    return f"{chance:.0%}" if chance >= 0.01 else f"{chance:.1%}" if chance >= 0.001 else _("less than 0.1%")


def _mechanics_text(fit):
    """Return the verdict of lengths that lie off any line: the worst of them, and a wrong scale beside it."""
    worst = max(fit.left, key=lambda row: abs(row[2] / row[3]))
    text = _("MECHANICS, or the measuring: {:g} mm lies {:.2f} mm off the best line, {:.0f} times what its readings scatter")
    text = text.format(worst[0], abs(worst[2]), abs(worst[2] / worst[3]))
    if abs(fit.scale - 1) > 2 * fit.u_scale:
        text += _("; beside it the scale is wrong: {:.2f} steps/mm would be nearer", fit.steps_per_mm)
    return text


def _scale_text(fit):
    """Return the verdict of a wrong scale, with the right steps/mm."""
    if fit.scale > 1:
        text = _("SCALE: lengths come out {:.2%} too long; with {:.3f} steps/mm they are right")
    else:
        text = _("SCALE: lengths come out {:.2%} too short; with {:.3f} steps/mm they are right")
    return text.format(abs(fit.scale - 1), fit.steps_per_mm) + _backlash_text(fit)


def _backlash_text(fit):
    """Return a sentence about backlash, or about an offset of the readings, beyond twice its uncertainty; else ""."""
    if fit.backlash > 2 * fit.u_backlash:
        return _(". Backlash of {:.2f} mm after each turn stays", fit.backlash)
    if fit.backlash < -2 * fit.u_backlash:
        return _(". All lengths are {:.2f} mm too long: measure between the same edges", -fit.backlash)
    return ""


_VERDICTS = {
    "right": lambda fit: _("RIGHT: the steps/mm are as good as these lengths can tell") + _backlash_text(fit),
    "scale": _scale_text,
    "mechanics": _mechanics_text,
    "unknown": lambda fit: _("UNKNOWN: give three lengths or more with several readings each, to tell the scale from the mechanics"),
}  # fmt: skip


def square_text(square):
    """Return a line about two axes' squareness: mm at 1 m with its standard uncertainty, and which way to turn the second axis, in degrees."""
    sure = abs(square.mm_m) > 2 * square.u_mm_m
    first, second = square.axes.upper()
    if not sure:
        verdict = _("square, as far as these diagonals can tell")
    elif square.mm_m > 0:
        verdict = _("{} leans towards {}+: turn it by {:.3f}°", second, first, abs(square.degrees))
    else:
        verdict = _("{} leans away from {}+: turn it by {:.3f}°", second, first, abs(square.degrees))
    return _("{}{} {:+.2f} ± {:.2f} mm at 1 m: {}", first, second, square.mm_m, square.u_mm_m, verdict)


def _parse_steps_per_mm(text):
    """Return {axis: steps/mm} of --steps-per-mm. Raises Failure unless there are one to four numbers above 0, up to 100,000."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if not 1 <= len(values) <= 4 or not all(0 < value <= _MOST_STEPS_MM for value in values):
        raise Failure("--steps-per-mm wants one number an axis, above 0, as in 48,83, not {!r}", text)
    return dict(zip(_AXES, values))


def _scales_of_board(name):
    """Return ({axis: steps/mm}, {axis: mm of backlash taken up}) of a board file; the second is empty if it takes up none."""
    from host_tools import boards

    board = boards.load(name)
    names = [axis["name"] for axis in board["axes"]]
    scales = {axis["name"]: axis["steps_per_m"] / 1000 for axis in board["axes"]}
    return scales, {axis: board["backlash"].get(axis, 0) / 1000 for axis in names if board.get("backlash")}


def _scales_of_machine(port, baud, protocol):
    """Return ({axis: steps/mm}, {axis: mm of backlash taken up}) of a machine's settings $100… and $160…. Raises Failure."""
    from host_tools.cli.settings import board_at

    with board_at(port, baud, protocol) as board:
        values = dict(line[1:].split("=") for line in board.command("$$"))
    found = []
    for first in (100, 160):
        found.append({axis: float(values[f"{first + number}"]) for number, axis in enumerate(_AXES) if f"{first + number}" in values})
    return found


def _write_settings(fits, taken, link, anyway):
    """Send the steps/mm that are known to be wrong, and the backlash that is known. `link`: (port, baud, language). Raises Failure, before it sends
    anything, if a fit is doubtful and not `anyway`."""
    from host_tools.cli.settings import board_at

    doubtful = [fit.axis.upper() for fit in fits if fit.verdict in ("mechanics", "unknown")]
    if doubtful and not anyway:
        raise Failure("nothing is written: {} has no scale to be trusted; --anyway writes it all the same", ", ".join(doubtful))
    lines = [f"${100 + _AXES.index(fit.axis)}={fit.steps_per_mm:.3f}" for fit in fits if anyway or fit.verdict == "scale"]
    for fit in fits:
        play = total_backlash(fit, taken) if taken and fit.split else None
        if play is not None and play <= _MOST_MM:
            lines.append(f"${160 + _AXES.index(fit.axis)}={play:.3f}")
    if not lines:
        print(_("nothing to write: the steps/mm are right"))
        return
    written = False
    try:
        with board_at(*link) as board:
            for line in lines:
                board.command(line)
                written = True
                print(_("written: {}", line))
    finally:
        if written:  # also if the board has refused a later one
            print(_("home the machine again before it cuts: its millimetres have changed"))


def parse_lengths(text):
    """Return the lengths of --lengths, mm. Raises Failure unless there are two different ones or more, above 0 and up to 10,000."""
    try:
        lengths = [float(part) for part in text.split(",")]
    except ValueError:
        lengths = []
    if len(set(lengths)) < 2 or min(lengths) <= 0 or max(lengths) > 10_000:
        raise Failure("--lengths wants two different lengths or more, in mm, as in 10,20,50,100, not {!r}", text)
    return lengths


def _pattern_lines(calibration, axis, lengths, strokes, feed, board):
    """Return the lines of a program that draws `strokes` of each length along an axis, in the board's language; without a board in G-code. `feed`:
    mm/min. Raises Failure."""
    from host_tools import boards

    config = boards.load(board) if board else None
    language = config["links"][0]["protocol"] if config else "grbl"
    if language == "grbl":
        return calibration.pattern_lines(axis, lengths, strokes, feed)
    if language == "keys":
        raise Failure("{} turns motors without an end: it draws no lengths", board)
    if language == "plotter":
        return calibration.pattern_packets(axis, lengths, strokes, boards.steps_per_mm(config))
    if language == "pulses":
        return calibration.pattern_pulses(axis, lengths, strokes, feed, boards.steps_per_mm(config))
    return [f"passo torch strokes {axis} --board {board} --lengths {','.join(f'{length:g}' for length in lengths)} --strokes {strokes} --speed {feed:g}"]


def _write_pattern(calibration, table, pattern, text, strokes, feed, board):
    """Write a program for X and one for Y that draw the lengths, and a new table to fill in. Raises Failure if the table is there already."""
    lengths = parse_lengths(text)
    if table.exists():
        raise Failure("{} is there already: name a new table, or move that one away", table)
    files = {table: _TABLE}
    for axis in "xy":
        path = pattern.with_name(f"{pattern.stem}_{axis}{pattern.suffix}")
        files[path] = "\n".join(_pattern_lines(calibration, axis, lengths, strokes, feed, board)) + "\n"
        files[table] += "".join(f"#{axis}      {length:<9g}  ?         ?      {strokes:<8}  turn\n" for length in lengths)
    for path, content in files.items():
        try:
            path.write_text(content, encoding="utf-8")
        except OSError as error:
            raise Failure("cannot write {}: {}", path, reason(error)) from error
        print(path)
