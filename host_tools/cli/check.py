"""`passo check`: a job of G-code on the virtual board: errors by line, bounds, time, speeds, a picture."""

import bisect
import contextlib
import itertools
import sys
import time
from pathlib import Path
from typing import Optional

import typer

from host_tools.failure import Failure

_MOST_SHOWN = 20  # errors
_TELL_S = 0.2


def check(
    file: Path = typer.Argument(..., help="The G-code."),
    board: str = typer.Option("router_3axis", help="Board file: a name of boards/, or the path of a .py file."),
    out: Optional[Path] = typer.Option(None, "-o", "--out", help="A picture of the path, speed and acceleration."),
    at: Optional[str] = typer.Option(
        None, metavar="X,Y,Z", help="Where the program's zero (G54) lies, in mm of the homed machine: checks soft limits."
    ),
):
    """Run a job on the virtual board and say what it would do.

    Every line goes through the real firmware, and every step through its pins. Exit status 1 if a line was refused, or if
    the job is larger than the machine's travel.

    With --at the job starts on the homed machine, at machine zero, with soft limits on, and bounds are in machine
    coordinates. Without it, the position of the job on the machine is not known, and only its size is checked.

    Examples:

        passo check part.gcode

        passo check part.gcode --at 20,30,-35

        passo check part.gcode --board boards/mine.py -o part.png
    """
    from host_tools.programs import gcode_file
    from host_tools.sim.job import VirtualJob

    if out:
        import matplotlib  # noqa: F401  before the job runs, not after it

    lines = gcode_file.read(file)
    job = VirtualJob(board, zero=_zero(at))
    with _shown(file, lines) as progress:
        job.run(lines, progress)
    for line in summary(job):
        print(line)
    if out:
        picture(out, job, file.name)
        print(out)
    for number, text, what in job.errors[:_MOST_SHOWN]:
        typer.echo(f"{file}:{number}: {text}: {what}", err=True)
    if job.errors:
        raise Failure(f"{file}: {len(job.errors)} lines would be refused; the first is line {job.errors[0][0]}")
    too_long = [text for text in map(_excess, range(len(job.steps_per_mm)), itertools.repeat(job)) if text]
    if too_long:
        raise Failure(f"{file} is larger than the machine: {', '.join(too_long)}")


def _zero(text):
    """The places of `--at`, or None. Raises Failure."""
    if text is None:
        return None
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise Failure(f"--at {text}: millimetres are wanted, one number an axis, for example 20,30,-35") from None


def _excess(number, job):
    """A text if the job is longer than the travel of an axis, else ""."""
    axis = job.board["axes"][number]
    travel = axis["travel_steps"] / job.steps_per_mm[number]
    length = job.high[number] - job.low[number]
    # Travel and place are whole steps, each rounded once.
    if length <= travel + 1 / job.steps_per_mm[number]:
        return ""
    return f"{axis['name'].upper()} goes {length:.1f} of {travel:.1f} mm"


@contextlib.contextmanager
def _shown(file, lines):
    """Shows progress and the current line at the terminal."""
    from host_tools.cli.stream import progress_bar
    from host_tools.programs.gcode_time import Limits, Remaining, estimate

    if not sys.stderr.isatty():
        yield None
        return
    numbers = [number for number, _ in lines]
    remaining = Remaining(estimate(lines, Limits.of_settings([])))
    with progress_bar(transient=True) as bar:
        told = time.monotonic()

        def progress(number):
            nonlocal told
            if time.monotonic() - told > _TELL_S:
                told = time.monotonic()
                remaining.at(bisect.bisect_left(numbers, number), 0.0)
                text = f"{remaining.share:4.0%} checking {file}: line {number} of {numbers[-1]}"
                bar.update(bar.task_ids[0], completed=remaining.share, description=text, refresh=True)

        yield progress


def table_mm(board):
    """The reach of X and Y in machine coordinates: left, bottom, right, top in mm; negative if an axis homes at its high end."""
    ranges = []
    high_end = (board["homing"] or {}).get("high_end", "")
    for axis in board["axes"][:2]:
        travel = axis["travel_steps"] / axis["steps_per_m"] * 1000
        ranges.append((-travel, 0.0) if axis["name"] in high_end else (0.0, travel))
    (left, right), (bottom, top) = ranges
    return left, bottom, right, top


def summary(job):
    """What the job would do, in lines of text."""
    from host_tools.programs.gcode_file import clock

    yield f"time    {clock(job.seconds)} ({job.seconds:.1f} s), {job.track.steps} words with a step"
    for number, axis in enumerate(job.board["axes"]):
        low, high = job.low[number], job.high[number]
        note = "  MORE THAN THE TRAVEL" if _excess(number, job) else ""
        fastest = job.track.fastest[number]
        yield f"{axis['name'].upper()}       {low:9.3f} … {high:9.3f} mm, up to {fastest:.0f} mm/min{note}"
    for number, text in job.pauses[:_MOST_SHOWN]:
        yield f"pause   line {number}: {text}: it goes on when the operator resumes"
    if len(job.pauses) > _MOST_SHOWN:
        yield f"        and {len(job.pauses) - _MOST_SHOWN} more pauses"
    for number, text in job.skipped[:_MOST_SHOWN]:
        yield f"skipped line {number}: {text}: no part of a job"
    for number, text in job.probes[:_MOST_SHOWN]:
        yield f"probe   line {number}: {text}: nothing is touched here, it goes its whole way"


def plot_accelerations(axes, job):
    """Each axis's acceleration over time, and its limit as a dashed line; steps are whole, so the lines tremble."""
    made = job.track.accelerations()
    for number, (axis, color) in enumerate(zip(job.board["axes"], ("#c0392b", "#1e8449", "#1f618d", "#7d3c98"))):
        axes.plot(
            [seconds for seconds, _ in made], [along[number] for _, along in made], color=color, linewidth=0.6,
            label=axis["name"].upper(),
        )  # fmt: skip
        for limit in (axis["accel_mm_s2"], -axis["accel_mm_s2"]):
            axes.axhline(limit, color=color, linewidth=0.5, linestyle=(0, (4, 6 + 2 * number)))
    axes.set_xlabel("s")
    axes.set_ylabel("mm/s² of each axis")
    axes.grid(color="#e6e6e6", linewidth=0.5)
    axes.legend(loc="upper right")


def _show_table(axes, job):
    """A small map: the table, and the box of the job on it; without --at, as if work zero were machine zero."""
    from host_tools.drawings import plot

    table = [round(side, 2) for side in table_mm(job.board)]
    plot.show_box(axes, table, "table", plot.TABLE)
    plot.show_box(axes, [round(side, 2) for side in (*job.low[:2], *job.high[:2])], "job", "#1a1a2e")
    axes.plot(0, 0, "o", color="#2a9d3f", markersize=4, label="machine zero" if job.placed else "machine zero, as work zero")
    axes.set_aspect("equal", adjustable="box")
    axes.margins(0.08)
    axes.tick_params(labelsize=6)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize=7, frameon=False)


def picture(path, job, title):
    """The path seen from above, the speed along it and the axes' accelerations over time."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.collections import LineCollection

    from host_tools.programs.gcode_file import clock

    rows = [["above", "table"], ["speed", "speed"], ["acceleration", "acceleration"]]
    figure, parts = plt.subplot_mosaic(
        rows, figsize=(10.5, 12), layout="constrained", height_ratios=[3, 1, 1], width_ratios=[4, 1.3]
    )
    above, speed, acceleration = parts["above"], parts["speed"], parts["acceleration"]
    for lowered, color, width in ((False, "#9cc3e6", 0.6), (True, "#1a1a2e", 0.9)):
        lines = [[place[:2] for place in places] for kind, places in job.track.strokes if kind == lowered]
        labels = ("above Z0", "below Z0") if job.track.by_height else ("tool off", "tool on")
        label = labels[lowered]
        above.add_collection(LineCollection(lines, colors=color, linewidths=width, label=label))
    above.autoscale()
    above.set_aspect("equal", adjustable="datalim")
    if len(job.board["axes"]) > 1:
        _show_table(parts["table"], job)
    else:
        parts["table"].set_axis_off()
    above.set_title(f"{title}, {clock(job.seconds)} ({job.seconds:.1f} s)")
    above.set_xlabel("x in mm")
    above.set_ylabel("y in mm")
    above.grid(color="#e6e6e6", linewidth=0.5)
    above.legend(loc="upper right")
    samples = job.track.samples or [(0, 0, ())]
    speed.plot([sample[0] for sample in samples], [sample[1] for sample in samples], color="#1a1a2e", linewidth=0.7)
    speed.set_ylabel("mm/min along the path")
    speed.grid(color="#e6e6e6", linewidth=0.5)
    plot_accelerations(acceleration, job)
    acceleration.sharex(speed)
    try:
        figure.savefig(path, dpi=120)
    except (OSError, ValueError) as error:
        raise Failure(f"cannot write {path}: {error}") from error
    finally:
        plt.close(figure)
