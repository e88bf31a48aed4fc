"""`passo check`: a job of G-code on the virtual board: errors by line, bounds, time, speeds, a picture."""

import contextlib
import sys
import time
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.options import DropZ, ZPen
from host_tools.failure import Failure
from host_tools.language import _, count_text

_MOST_SHOWN = 20  # errors
_TELL_S = 0.2
_PIECE = 4000  # positions drawn as one line


Place = Annotated[
    Optional[str],
    typer.Option(metavar="X,Y,Z", help="Where the program's zero (G54) lies, in mm of the homed machine: checks soft limits."),
]
MachinePort = Annotated[
    Optional[str], typer.Option(help="The machine's port: checks with its settings and offsets, from where it stands.")
]


def check(
    file: Path = typer.Argument(..., help="The G-code, or a folder of programs."),
    board: str = typer.Option("router_3axis", help="Board file: a name of boards/, or the path of a .py file."),
    out: Optional[Path] = typer.Option(None, "-o", "--out", help="A picture of the path, speed and acceleration; of a folder its table, FILE.csv."),
    at: Place = None,
    port: MachinePort = None,
    baud: Annotated[int, typer.Option(help="Bits per second of a serial port.")] = 115200,
    dialect: Annotated[Optional[str], typer.Option(help="num, ngc, or plain: as it is; default: by what stands in the file.")] = None,
    tools: Annotated[Optional[Path], typer.Option(help="The tool table of a program that is compiled; see passo compile.")] = None,
    drop_z: DropZ = False,
    z_pen: ZPen = None,
    workers: Annotated[Optional[int], typer.Option(min=1, help="Of a folder: processes on this PC; default: one for each processor.")] = None,
    dask: Annotated[Optional[str], typer.Option(metavar="tcp://HOST:PORT", help="Of a folder: the scheduler of a Dask cluster, which checks.")] = None,
):
    """Run a job on the virtual board and say what it would do.

    Every line goes through the real firmware, and every step through its pins. Exit status 1 if a line was refused, or if
    the job is larger than the machine's travel.

    With --at the job starts on the homed machine, at machine zero, with soft limits on, and bounds are in machine
    coordinates. With --port it starts where the machine stands, with its offsets, speeds and soft limits: as `passo stream`
    would find them. Without both, the position of the job on the machine is not known, and only its size is checked.

    A program in a dialect of its own is compiled first (passo compile); errors name the program's lines.

    Of a folder all programs in it are checked, each a line of one table. If a process of --workers dies, its program is tried again.

    --dask checks on a cluster: programs, board file and tool table travel to its workers, small programs up to 16 together. If a worker dies,
    what it had is tried again on another one. Install Passo there with pip install '.[cluster]', and start workers with docs/use/dask.yaml.

    A million words take about a second if MicroPython is installed (pip install '.[check]', Linux), else three. Memory does not
    grow with the file.

    Examples:

        passo check part.gcode
        passo check part.gcode --at 20,30,-35
        passo check part.gcode --port /dev/ttyACM0
        passo check part.gcode --board boards/mine.py -o part.png

        passo check programs --workers 4 -o table.csv

        passo check programs --dask tcp://192.168.1.20:8786
    """
    if workers and dask:
        raise Failure("--workers are of this PC, --dask of a cluster: give one of them")
    if (workers or dask) and not file.is_dir():
        raise Failure("--workers and --dask are for a folder of programs, and {} is none", file)
    if at and port:
        raise Failure("--at says where the program's zero lies, and so does the machine at --port: give one of them")
    changes, start = _read_machine(port, baud) if port else ((), None)
    place = tuple(changes), _parse_zero(at), start
    if file.is_dir():
        if drop_z or z_pen is not None:
            raise Failure("--drop-z and --z-pen are for one program, and {} is a folder", file)
        from host_tools.cli.check_folder import check_folder

        check_folder(file, board, place, dialect, tools, out, workers, dask)
    else:
        _check_file(file, board, place, dialect, tools, out, drop_z, z_pen)


def _check_file(file, board, place, dialect, tools, out, drop_z=False, z_pen=None):
    """Run one program on the virtual board, and print its time, bounds and errors; with `out` draw it. `place`: (changes, zero, start) of a
    VirtualJob. Raises Failure."""
    from host_tools import boards
    from host_tools.programs import compiler, feeds, flat
    from host_tools.sim.job import VirtualJob

    if out:
        import matplotlib  # noqa: F401  before the job runs, not after it
    program = compiler.read(file, dialect, tools, not boards.load(board).get("rotary"))
    flat.leave_out_z(program, drop_z, z_pen)
    job = VirtualJob(board, *place, drawn=bool(out))
    flat.refuse_z(program, len(job.board["axes"]) > 2)
    _run_program(job, program)
    compiler.print_notes(program)
    for line in summary_lines(job):
        print(line)
    if slow := feeds.slow_feeds(program.rows(), job.seconds):
        print(slow)
    if out:
        save_job_picture(out, job, file.name)
        print(out)
    for number, text, what in job.errors[:_MOST_SHOWN]:
        typer.echo(f"{program.place_text(number)}: {text}: {what}", err=True)
    _raise_if_faulty(job, program)


def _raise_if_faulty(job, program):
    """Raise Failure if the machine refused lines, or if the job is larger than its travel."""
    if job.errors:
        if advice := program.advice():
            typer.echo(f"{program.name}: {advice}", err=True)
        raise Failure("{}: {} would be refused; the first is {}", program.path, count_text(job.error_count, "line"), program.origin(job.errors[0][0]))
    if too_long := job.beyond_travel():
        raise Failure("{} is larger than the machine: {}", program.path, too_long)


def _run_program(job, program):
    """Run all lines of a program, with progress. Raises Failure with the program's line if the job cannot go on."""
    job.origin = program.origin
    with _show_progress(program) as progress:
        job.run(program.rows(), progress)


def _parse_zero(text):
    """Return the mm of --at, one an axis, or None. Raises Failure."""
    if text is None:
        return None
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise Failure("--at {}: millimetres are wanted, one number an axis, for example 20,30,-35", text) from None


def _read_machine(port, baud):
    """Return (changes, start) for a VirtualJob: lines that set a machine's settings and work offsets, and where it stands in mm. Not G92 and G43.1,
    which end with the reset that begins a job. Raises Failure if its position is unknown."""
    from host_tools.cli.settings import backup_lines
    from host_tools.clients.grbl import GrblClient

    with GrblClient(port, baud) as client:
        client.connect()
        status = client.ask_status()
        if status["state"] == "Alarm":
            raise Failure("the machine is in alarm, so its position is not known: home it first")
        kept = backup_lines(client)
    inches = "$13=1" in kept
    positions = [float(position) * (25.4 if inches else 1.0) for position in status["MPos"].split(",")]
    changes = ["G20" if inches else "G21"]
    changes += [line for line in kept if line.startswith("G10") or line.startswith("$") and _bears_on_motion(line)]
    return changes, positions


def _bears_on_motion(line):
    """True if a `$` line sets the path, soft limits, spindle's range, steps/mm, a speed or an acceleration; false for pins, reports and homing, which
    the virtual board does not use."""
    number = line[1:].partition("=")[0]
    return number.isdigit() and (int(number) in (11, 12, 20, 30, 31, 32) or int(number) >= 100)


@contextlib.contextmanager
def _show_progress(program):
    """Give a function of the line number that shows progress at the terminal; None without a terminal."""
    from host_tools.cli.stream import progress_bar

    if not sys.stderr.isatty():
        yield None
        return
    last = program.last_number()
    with progress_bar(transient=True) as bar:
        told = time.monotonic()

        def show_line(number):
            """Show line `number` and its share of the file, each _TELL_S at most."""
            nonlocal told
            if time.monotonic() - told > _TELL_S:
                told = time.monotonic()
                share = number / max(last, 1)
                text = f"{share:4.0%} checking {program.name}: line {number} of {last}"
                bar.update(bar.task_ids[0], completed=share, description=text, refresh=True)

        yield show_line


def table_mm(board):
    """Return the reach of X and Y in machine coordinates: left, bottom, right, top in mm; negative if an axis homes at its high end."""
    ranges = []
    high_end = (board["homing"] or {}).get("high_end", "")
    for axis in board["axes"][:2]:
        travel = axis["travel_steps"] / axis["steps_per_m"] * 1000
        ranges.append((-travel, 0.0) if axis["name"] in high_end else (0.0, travel))
    (left, right), (bottom, top) = ranges
    return left, bottom, right, top


def summary_lines(job):
    """Yield lines about a job: its time, range and fastest speed of each axis, pauses, skipped lines, probes."""
    from host_tools.programs.gcode_file import clock_text

    yield _("time    {} ({:.1f} s), {} words with a step", clock_text(job.seconds), job.seconds, job.track.steps)
    for number, axis in enumerate(job.board["axes"]):
        low, high = job.low[number], job.high[number]
        note = "  " + _("MORE THAN THE TRAVEL") if job.excess_text(number) else ""
        fastest = job.track.fastest[number]
        unit = "°" if job.board.get("rotary") == axis["name"] else "mm"
        yield _("{}       {:9.3f} … {:9.3f} {}, up to {:.0f} {}/min", axis["name"].upper(), low, high, unit, fastest, unit) + note
    for number, text in job.pauses[:_MOST_SHOWN]:
        yield _("pause   {}: {}: it goes on when the operator resumes", job.origin(number), text)
    if len(job.pauses) > _MOST_SHOWN:
        yield _("        and {} more pauses", len(job.pauses) - _MOST_SHOWN)
    for number, text in job.skipped[:_MOST_SHOWN]:
        yield _("skipped {}: {}: no part of a job", job.origin(number), text)
    for number, text in job.probes[:_MOST_SHOWN]:
        yield _("probe   {}: {}: nothing is touched here, it goes its whole way", job.origin(number), text)


def plot_accelerations(axes, job):
    """Plot each axis's acceleration in mm/s² over seconds, and its limit as a dashed line. Steps are whole, so the lines tremble."""
    made = job.track.accelerations()
    for number, (axis, color) in enumerate(zip(job.board["axes"], ("#c0392b", "#1e8449", "#1f618d", "#7d3c98"))):
        axes.plot(made[:, 0], made[:, 1 + number], color=color, linewidth=0.6, label=axis["name"].upper())
        for limit in (axis["accel_mm_s2"], -axis["accel_mm_s2"]):
            axes.axhline(limit, color=color, linewidth=0.5, linestyle=(0, (4, 6 + 2 * number)))
    axes.set_xlabel("s")
    axes.set_ylabel(_("mm/s² of each axis"))
    axes.grid(color="#e6e6e6", linewidth=0.5)
    axes.legend(loc="upper right")


def _show_table(axes, job):
    """Draw a small map: the table, and the box of the job on it; without --at, as if work zero were machine zero."""
    from host_tools.drawings import plot

    table = [round(side, 2) for side in table_mm(job.board)]
    plot.show_box(axes, table, _("table"), plot.TABLE)
    plot.show_box(axes, [round(side, 2) for side in (*job.low[:2], *job.high[:2])], _("job"), "#1a1a2e")
    axes.plot(0, 0, "o", color="#2a9d3f", markersize=4, label=_("machine zero") if job.placed else _("machine zero, as work zero"))
    axes.set_aspect("equal", adjustable="box")
    axes.margins(0.08)
    axes.tick_params(labelsize=6)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize=7, frameon=False)


def _split_stroke(positions):
    """Return a stroke in pieces of _PIECE positions: matplotlib needs memory for all the pixels of a line."""
    return [positions[begun : begun + _PIECE + 1] for begun in range(0, max(1, len(positions) - 1), _PIECE)]


def save_job_picture(path, job, title):
    """Write a picture of a job: its path seen from above, the speed along it, and the axes' accelerations over time. Raises Failure if it cannot be
    written."""
    from matplotlib.collections import LineCollection

    from host_tools.drawings.plot import write
    from host_tools.figures import pyplot
    from host_tools.programs.gcode_file import clock_text

    plt = pyplot()
    plt.rcParams["agg.path.chunksize"] = _PIECE
    rows = [["above", "table"], ["speed", "speed"], ["acceleration", "acceleration"]]
    figure, parts = plt.subplot_mosaic(
        rows, figsize=(10.5, 12), layout="constrained", height_ratios=[3, 1, 1], width_ratios=[4, 1.3]
    )
    above, speed, acceleration = parts["above"], parts["speed"], parts["acceleration"]
    for lowered, color, width in ((False, "#9cc3e6", 0.6), (True, "#1a1a2e", 0.9)):
        lines = [part for kind, positions in job.track.strokes if kind == lowered for part in _split_stroke(positions[:, :2])]
        labels = (_("above Z0"), _("below Z0")) if job.track.by_height else (_("tool off"), _("tool on"))
        label = labels[lowered]
        above.add_collection(LineCollection(lines, colors=color, linewidths=width, label=label))
    above.autoscale()
    above.set_aspect("equal", adjustable="datalim")
    if len(job.board["axes"]) > 1:
        _show_table(parts["table"], job)
    else:
        parts["table"].set_axis_off()
    above.set_title(f"{title}, {clock_text(job.seconds)} ({job.seconds:.1f} s)")
    above.set_xlabel(_("x in mm"))
    above.set_ylabel(_("y in mm"))
    above.grid(color="#e6e6e6", linewidth=0.5)
    above.legend(loc="upper right")
    samples = job.track.samples
    speed.plot(samples[:, 0], samples[:, 1], color="#1a1a2e", linewidth=0.7)
    speed.set_ylabel(_("mm/min along the path"))
    speed.grid(color="#e6e6e6", linewidth=0.5)
    plot_accelerations(acceleration, job)
    acceleration.sharex(speed)
    write(figure, path, dpi=120)
