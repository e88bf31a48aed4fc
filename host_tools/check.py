"""`passo check`: a job of G-code on the virtual board: errors by line, bounds, time, speeds, a picture."""

from pathlib import Path
from typing import Optional

import typer

from host_tools.failure import Failure

_MOST_SHOWN = 20  # errors


def check(
    file: Path = typer.Argument(..., help="The G-code."),
    board: str = typer.Option("router_3axis", help="Board file: a name of boards/, or the path of a .py file."),
    out: Optional[Path] = typer.Option(None, "-o", "--out", help="A picture of the path, speed and acceleration."),
):
    """Run a job on the virtual board and say what it would do.

    Every line goes through the real firmware, and every step through its pins. Exit status 1 if a line was refused.

    Examples:

        passo check part.gcode

        passo check part.gcode --board boards/mine.py -o part.png
    """
    from host_tools import gcode_file
    from host_tools.virtual_job import VirtualJob

    if out:
        import matplotlib  # noqa: F401  before the job runs, not after it

    job = VirtualJob(board)
    job.run(gcode_file.read(file))
    for line in summary(job):
        print(line)
    if out:
        picture(out, job, file.name)
        print(out)
    for number, text, what in job.errors[:_MOST_SHOWN]:
        typer.echo(f"{file}:{number}: {text}: {what}", err=True)
    if job.errors:
        raise Failure(f"{file}: {len(job.errors)} lines would be refused; the first is line {job.errors[0][0]}")


def summary(job):
    """What the job would do, in lines of text."""
    from host_tools.gcode_file import clock

    yield f"time    {clock(job.seconds)} ({job.seconds:.1f} s), {job.track.steps} words with a step"
    for number, axis in enumerate(job.board["axes"]):
        low, high = job.low[number], job.high[number]
        travel = axis["travel_steps"] / job.steps_per_mm[number]
        note = "" if high - low <= travel else f"  MORE THAN THE TRAVEL of {travel:.1f}"
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


def picture(path, job, title):
    """The path seen from above, the speed along it and the axes' accelerations over time."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.collections import LineCollection

    figure, (above, speed, acceleration) = plt.subplots(
        3, 1, figsize=(9, 12), layout="constrained", gridspec_kw={"height_ratios": [3, 1, 1]}
    )
    for lowered, color, width in ((False, "#9cc3e6", 0.6), (True, "#1a1a2e", 0.9)):
        lines = [[place[:2] for place in places] for kind, places in job.track.strokes if kind == lowered]
        labels = ("above Z0", "below Z0") if job.track.by_height else ("tool off", "tool on")
        label = labels[lowered]
        above.add_collection(LineCollection(lines, colors=color, linewidths=width, label=label))
    above.autoscale()
    above.set_aspect("equal", adjustable="datalim")
    above.set_title(title)
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
